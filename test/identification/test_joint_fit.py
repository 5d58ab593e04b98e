"""Some parameters are shared by all recordings, others have a value per setting, and both come back."""

from dataclasses import replace

import numpy as np
import pytest

from damper_estimator.errors import InputError
from damper_estimator.identification import fit, fit_joint, settings_by_channel
from damper_estimator.model import load_model
from damper_estimator.signals.layout import COMMAND

FAR = 4.5  # standard errors: farther off, a value is wrong
VALVES = [f"leak_blow_off_port.{what}_{way}" for what in ("leak", "port") for way in ("rebound", "compression")]
ADJUSTED = {"1": (15e3, 100.0, 10e3, 100.0), "2": (25e3, 300.0, 18e3, 500.0), "3": (40e3, 900.0, 30e3, 1500.0)}
COMMON = {"seal_friction.rebound": 35.0, "leak_blow_off_port.preload_rebound": 600.0}


@pytest.fixture(scope="module")
def adjusted(measured):
    """Three positions of the adjuster, of which each changes leak and port alone; two recordings each."""
    start = load_model("carrera_akutain")
    truths, data, settings = {}, [], []
    for number, (position, values) in enumerate(ADJUSTED.items()):
        truths[position] = start.with_values({**dict(zip(VALVES, values, strict=True)), **COMMON})
        for rms in (0.03, 0.008):
            data.append(measured(truths[position], 2 * number + (rms > 0.01), seconds=8.0, rms=rms))
            settings.append(position)
    # Recordings of one setting need not stand together.
    order = [0, 2, 4, 1, 3, 5]
    return truths, [data[i] for i in order], [settings[i] for i in order]


@pytest.fixture(scope="module")
def joint(adjusted):
    _, data, settings = adjusted
    return fit_joint(load_model("carrera_akutain"), data, settings, VALVES)


def test_adjuster_positions_are_recovered_with_what_they_share(joint, adjusted):
    truths, _, _ = adjusted
    assert set(joint.fits) == set(ADJUSTED) and set(joint.each) == set(VALVES)
    for position, fitted in joint.fits.items():
        true = {slot.address: slot.value for slot in truths[position].slots}
        assert len(fitted.parameters) == 14 and fitted.esr < 1e-4
        known = [p for p in fitted.parameters if np.isfinite(p.standard_error)]
        assert len(known) >= 8
        assert max(abs(p.value - true[p.name]) / p.standard_error for p in known) < FAR


def test_shared_parameters_are_equal_in_all_models_and_listed_once(joint):
    values = [{p.name: p.value for p in fitted.parameters} for fitted in joint.fits.values()]
    for address in values[0]:
        assert (len({by_name[address] for by_name in values}) == 1) == (address not in VALVES)
    names = [p.name for p in joint.parameters]
    assert len(names) == 10 + 3 * len(VALVES) == len(set(names))
    assert f"{VALVES[0]}@2" in names and "static_force.force" in names


def test_shared_parameters_are_known_better_than_from_one_setting_alone(joint, adjusted):
    _, data, settings = adjusted
    alone = fit(
        load_model("carrera_akutain"), [recorded for recorded, s in zip(data, settings, strict=True) if s == "1"]
    )
    errors = {p.name: p.standard_error for p in alone.parameters}
    shared = [p for p in joint.parameters if "@" not in p.name]
    better = [p.standard_error < errors[p.name] for p in shared if np.isfinite(errors[p.name])]
    assert np.mean(better) > 0.7


def test_with_everything_per_setting_a_joint_fit_is_the_separate_fits(measured):
    start = load_model("linear_viscous")
    data = [measured(start.with_values({"linear_viscous.rebound": r}), k) for k, r in enumerate((900.0, 2600.0))]
    together = fit_joint(start, data, ["a", "b"], ["*"])
    for name, recorded in zip(("a", "b"), data, strict=True):
        separate = fit(start, [recorded])
        for joint, single in zip(together.fits[name].parameters, separate.parameters, strict=True):
            assert joint.value == pytest.approx(single.value, rel=1e-6)
            assert joint.standard_error == pytest.approx(single.standard_error, rel=0.02)


@pytest.mark.parametrize("method", ["hooke_jeeves", "genetic"])
def test_other_methods_fit_jointly_as_well(method, measured):
    start = load_model("memoryless_baseline")
    common = {"tanh_hysteresis.steepness": 60.0}
    truths = [start.with_values({"tanh_hysteresis.force": force, **common}) for force in (200.0, 500.0)]
    data = [measured(truth, k, seconds=6.0) for k, truth in enumerate(truths)]
    found = fit_joint(start, data, ["low", "high"], ["tanh_hysteresis.force"], method=method)
    forces = [fitted.parameters[0].value for fitted in found.fits.values()]
    assert forces == pytest.approx([200.0, 500.0], rel=0.02)


def test_settings_are_read_from_a_steady_channel(measured):
    start = load_model("linear_viscous")
    data = [measured(start, k, seconds=2.0, command=c) for k, c in enumerate((0.5, 0.0, 0.501, 2.0))]
    assert settings_by_channel(data, COMMAND, "command") == ["0.5", "0", "0.5", "2"]


def refusal(function, *arguments):
    with pytest.raises(InputError) as caught:
        function(*arguments)
    return str(caught.value)


def test_what_cannot_be_a_joint_fit_is_refused_with_the_reason(measured):
    start = load_model("linear_viscous")
    data = [measured(start, k, seconds=4.0, command=np.linspace(0.0, 1.0, 1000)) for k in range(2)]
    assert "setting a; a joint fit needs two" in refusal(fit_joint, start, data, ["a", "a"], ["static_force"])
    assert "no parameter coulomb" in refusal(fit_joint, start, data, ["a", "b"], ["coulomb"])
    assert "not steady" in refusal(settings_by_channel, data, COMMAND, "command")
    bare = [replace(recorded, kinematics=measured(start, 0, seconds=4.0).kinematics) for recorded in data]
    assert "has no command" in refusal(settings_by_channel, bare, COMMAND, "command")
    brief = data[1].part(0, 20)
    assert "setting b" in refusal(fit_joint, start, [data[0], brief], ["a", "b"], ["static_force"])
