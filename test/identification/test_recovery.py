"""Every model of the library comes back from data made with it, from perturbed starts, within its stated confidence."""

import numpy as np
import pytest

from damper_estimator.identification import fit
from damper_estimator.identification.knots import with_placed_knots
from damper_estimator.model import load_model
from damper_estimator.model.model_files import library_models

FAR = 4.5  # standard errors: farther off, a value is wrong
PERTURBED = 0.25  # standard deviation of the starts' logarithm
UNEXPLAINED = 1e-4  # ESR: 1 % force noise leaves a fifth of it in band
MODERATE, LARGE, VIOLENT = (0.005, 0.012), (0.02, 0.045), (0.03, 0.07)  # m rms, one recording each
# What a model needs besides moderate motion to show all its parameters.
EXCITATION = {
    **dict.fromkeys(("carrera_akutain", "carrera_akutain_unfiltered", "renault_modified_bouc_wen"), LARGE),
    **{f"renault_modified_bouc_wen_point_{k}": LARGE for k in (1, 2, 3)},
    **dict.fromkeys(("semi_active_yield", "semi_active_gap", "semi_active_oil"), VIOLENT),  # their curves go to 1.2 m/s
    **{f"his_{kind}": VIOLENT for kind in ("piecewise", "non_hysteresis", "permanent_hysteresis")},
}
# Parameters that no data determine, by the model's structure.
SILENT = {
    # Without a delay in front of the limits, the force never lags so far that it meets the level of C-D.
    "his_non_hysteresis": {"his_saturation.level_rebound"},
    "his_permanent_hysteresis": {"his_saturation.level_rebound"},
}
# Corners of the grid that no motion reaches: high speed at high acceleration. And dry friction next to a yield force
# that is there without current: they have the same shape, and one may take the other's place.
UNREACHED = {"force_surface", "semi_active_gap", "semi_active_oil"}


def command(size):
    return 0.8 + 0.5 * np.sin(np.arange(size) / 150.0)


def truth_of(name, motions):
    """The library's values; curves without values follow a damper's usual course over knots for these motions."""
    model = with_placed_knots(load_model(name), motions)
    curve = model.effects[0]
    if name == "viscous_curve":
        force = 900.0 * np.tanh(6.0 * np.array(curve.settings["velocity"])) + 50.0
    elif name == "force_surface":
        velocity, acceleration = (np.array(curve.settings[axis]) for axis in ("velocity", "acceleration"))
        force = (900.0 * np.tanh(6.0 * velocity)[:, None] - 2.0 * acceleration + 50.0).ravel()
    else:
        return model
    return model.with_vector(np.concatenate([force, [slot.value for slot in model.slots[force.size :]]]))


def perturbed(model, seed):
    random = np.random.default_rng(seed)
    values = {}
    for slot in model.slots:
        if not slot.fixed:
            moved = slot.value * np.exp(PERTURBED * random.standard_normal())
            values[slot.address] = float(np.clip(moved, slot.parameter.lower, slot.parameter.upper))
    return model.with_values(values)


@pytest.mark.parametrize("name", sorted(library_models()))
def test_a_model_is_recovered_from_its_data(name, measured):
    def record(model):
        pairs = enumerate(EXCITATION.get(name, MODERATE), 1)
        return [measured(model, seed, rms=rms, command=command(4000)) for seed, rms in pairs]

    truth = truth_of(name, record(load_model("linear_viscous")))
    result = fit(perturbed(truth, 5), record(truth))
    true = {slot.address: slot.value for slot in truth.slots}
    known = {p.name: (p.value - true[p.name]) / p.standard_error for p in result.parameters if p.standard_error > 0.0}
    assert result.esr < UNEXPLAINED
    if name in UNREACHED:
        assert len(known) > 0.5 * len(result.parameters)
    else:
        # A value that truly lies at a bound comes back exactly there, where no standard error can be given.
        exact = {p.name for p in result.parameters if p.at_bound and p.value == true[p.name]}
        assert {p.name for p in result.parameters} - set(known) - exact == SILENT.get(name, set())
        assert {address for group in result.undetermined for address in group} == SILENT.get(name, set())
    assert {address: d for address, d in known.items() if abs(d) > FAR} == {}


# Model, what is freed, what the fit must then name, what else is known, motion in m rms.
REDUNDANT = {
    "the scale of z": ("bouc_wen", "bouc_wen.delta", {"bouc_wen.delta", "bouc_wen.alpha"}, [], MODERATE),
    "the scale of a bracket": (
        "black_box_9",
        "displacement_decay.constant",
        {"displacement_decay.constant", "velocity_parabola_tied.linear"},
        [],
        MODERATE,
    ),
    # The gas force is known except for a few newtons, which are all of the offset.
    "gas force at rest and offset": (
        "carrera_akutain",
        "gas_spring.static_force",
        {"static_force.force"},
        ["leak_blow_off_port"],
        (5e-4, 1e-3),
    ),
}


@pytest.mark.parametrize("name", REDUNDANT)
def test_freeing_a_redundant_parameter_names_the_inseparable_parameters(name, measured):
    model, freed, cannot, fix, levels = REDUNDANT[name]
    data = [measured(load_model(model), seed, rms=rms) for seed, rms in enumerate(levels, 1)]
    plain, redundant = (fit(load_model(model), data, free, fix, starts=0) for free in ([], [freed]))
    assert not any(cannot <= set(group) for group in plain.undetermined)
    assert any(cannot <= set(group) for group in redundant.undetermined), redundant.undetermined
