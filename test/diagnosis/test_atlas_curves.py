"""The curves of what a model lacks: each shows what was hidden along its variable, the others stay at zero."""

from dataclasses import replace

import numpy as np
import pytest

from damper_estimator.diagnosis.atlas_curves import AtlasCurve, atlas_curves
from damper_estimator.diagnosis.baseline import baseline_of
from damper_estimator.diagnosis.diagnosis_data import data_of, slope_of
from damper_estimator.files import json_text
from damper_estimator.signals.layout import COMMAND, TEMPERATURE

NOISE = 5.0  # N
WARM = 40.0  # deg C, where the model was identified
MASS, LATE, STIFFNESS, FADE, CURRENT, SPRING = 2.0, 1e-3, 1.2e6, -0.004, 60.0, 2000.0
HIDDEN = {
    "blow-off": lambda k, force, slope: -0.4 * force * np.maximum(np.abs(k.velocity) - 0.15, 0.0),
    "friction": lambda k, force, slope: 60.0 * np.tanh(k.velocity / 0.01),
    "mass": lambda k, force, slope: MASS * k.acceleration,
    "shift": lambda k, force, slope: np.interp(k.time - LATE, k.time, force) - force,
    "series": lambda k, force, slope: -slope * np.gradient(force, k.time) / STIFFNESS,
    "valve": lambda k, force, slope: np.where(k.velocity > 0.24, 4.0 * k.acceleration, 0.0),
    "fade": lambda k, force, slope: FADE * (k.temperature - WARM) * force,
    "current": lambda k, force, slope: CURRENT * np.tanh(k.velocity / 0.05) * (k.command - k.command.mean()),
    "spring": lambda k, force, slope: SPRING * k.displacement,
    "stops": lambda k, force, slope: 2e7 * np.maximum(np.abs(k.displacement) - 0.021, 0.0) ** 2,
    "bypass": lambda k, force, slope: -10.0 * k.displacement * (force - force.mean()),
}
SHOWS = {
    "blow-off": "velocity", "friction": "velocity", "mass": "acceleration", "shift": "acceleration",
    "series": "acceleration", "valve": "acceleration", "fade": "temperature", "current": "command",
    "spring": "displacement", "stops": "displacement", "bypass": "position",
}  # fmt: skip


@pytest.fixture(scope="module")
def perfect(user_model, base):
    """The base recording as the model itself would have made it, with a temperature and a command that vary."""
    block = base.kinematics.block.copy()
    time = base.kinematics.time - base.kinematics.time[0]
    block[TEMPERATURE] = WARM + 10.0 * np.sin(0.9 * time)
    block[COMMAND] = 0.7 + 0.5 * np.sin(1.3 * time)
    return replace(base, kinematics=replace(base.kinematics, block=block), force=user_model.force(block))


@pytest.fixture(scope="module")
def found(user_model, perfect):
    """Finds the curves of a damper in which something is hidden, with white noise."""

    def curves(change, seed: int = 1) -> dict[str, AtlasCurve]:
        kinematics = perfect.kinematics
        hidden = change(kinematics, perfect.force, slope_of(user_model, kinematics.block))
        noise = NOISE * np.random.default_rng(seed).standard_normal(hidden.size)
        measured, middle = replace(perfect, force=perfect.force + hidden + noise), hidden.size // 2
        parts = [measured.part(0, middle)], [measured.part(middle, hidden.size)]
        return {curve.name: curve for curve in atlas_curves(baseline_of(user_model, data_of(user_model, *parts)))}

    return curves


def nothing(kinematics, force, slope):
    return np.zeros(force.size)


def at(curve: AtlasCurve, places) -> np.ndarray:
    return np.interp(places, curve.at, curve.value)


@pytest.mark.parametrize("name", HIDDEN)
def test_what_was_hidden_shows_in_its_curve_and_nowhere_else(name, found):
    curves = found(HIDDEN[name])
    assert [curve.name for curve in curves.values() if curve.is_notable] == [SHOWS[name]]
    assert curves[SHOWS[name]].explains > 0.6
    if SHOWS[name] == "acceleration":
        assert curves["acceleration"].templates[0].name == name


def test_the_curves_have_the_size_and_the_sign_of_what_was_hidden(found, user_model):
    over_velocity = found(HIDDEN["friction"])["velocity"]
    np.testing.assert_allclose(at(over_velocity, [-0.4, -0.1, 0.1, 0.4]), [-60.0, -60.0, 60.0, 60.0], atol=6.0)
    spring = found(HIDDEN["spring"])["displacement"]
    np.testing.assert_allclose(at(spring, 0.015) - at(spring, -0.015), 0.03 * SPRING, rtol=0.1)
    current = found(HIDDEN["current"])["command"]
    np.testing.assert_allclose(at(current, [-0.3, 0.3]), [-CURRENT, CURRENT], rtol=0.1)
    bypass = found(HIDDEN["bypass"])["position"]
    np.testing.assert_allclose(at(bypass, 0.015) - at(bypass, -0.015), -0.3, rtol=0.1)


def test_the_templates_say_how_large_the_mass_and_how_late_the_force_is(found):
    sizes = {
        name: next(one.size for one in found(HIDDEN[name])["acceleration"].templates if one.name == name)
        for name in ("mass", "shift", "valve")
    }
    assert sizes["mass"] == pytest.approx(MASS, rel=0.05)
    assert sizes["shift"] == pytest.approx(LATE, rel=0.15)
    assert sizes["valve"] == pytest.approx(0.24, abs=0.06)


def test_a_wrong_template_explains_less_than_the_right_one(found):
    (first, *others) = found(HIDDEN["series"])["acceleration"].templates
    assert first.name == "series" and all(one.explains < first.explains - 0.02 for one in others)


def test_bands_cover_zero_where_nothing_is_hidden(found):
    tried = [curve for seed in range(10) for curve in found(nothing, seed).values()]
    low, high = (np.concatenate([getattr(curve, end) for curve in tried]) for end in ("low", "high"))
    assert np.mean((low <= 0.0) & (high >= 0.0)) > 0.82
    assert not any(curve.is_notable for curve in tried)
    assert sum(curve.is_clear for curve in tried) <= 0.15 * len(tried)


def test_bands_hold_what_was_hidden(found):
    inside = []
    for seed in range(10):
        curve = found(HIDDEN["mass"], seed)["acceleration"]
        inside += [low <= MASS <= high for low, high in zip(curve.low, curve.high, strict=True)]
    assert np.mean(inside) > 0.75


def test_a_variable_that_stands_still_has_no_curve(user_model, base):
    curves = atlas_curves(baseline_of(user_model, data_of(user_model, [base], [base])))
    assert {curve.name for curve in curves} == {"velocity", "displacement", "position", "acceleration"}


def test_a_perfect_model_and_a_force_that_runs_away_are_survived(user_model, perfect):
    middle = perfect.force.size // 2
    baseline = baseline_of(
        user_model, data_of(user_model, [perfect.part(0, middle)], [perfect.part(middle, 2 * middle)])
    )
    exact = replace(
        baseline,
        residual_fit=np.zeros_like(baseline.residual_fit),
        residual_unseen=np.zeros_like(baseline.residual_unseen),
    )
    assert all(max(np.abs(curve.value)) < 1e-6 and not curve.is_notable for curve in atlas_curves(exact))
    assert atlas_curves(replace(baseline, residual_fit=np.full(baseline.residual_fit.size, np.inf))) == ()


def test_the_curves_are_written_as_json_with_null_for_what_is_not_known(found):
    curve = found(HIDDEN["mass"])["acceleration"]
    record = replace(curve, value=(float("nan"), *curve.value[1:])).record()
    sizes = {template["name"]: template["size"] for template in record["templates"]}
    assert record["value"][0] is None and sizes["series"] is None and sizes["mass"] > 0.0
    assert '"name": "acceleration"' in json_text({"curves": [record]})
