"""The curves of what a model lacks: each shows what was hidden along its variable, the others stay at zero."""

from dataclasses import replace

import numpy as np
import pytest

from damper_estimator.diagnosis import atlas_curves as atlas_curves_module
from damper_estimator.diagnosis.atlas_curves import AtlasCurve, atlas_curves
from damper_estimator.diagnosis.baseline import baseline_of
from damper_estimator.diagnosis.diagnosis_data import data_of, slope_of
from damper_estimator.files import json_text
from damper_estimator.numerics import play
from damper_estimator.signals.layout import COMMAND, TEMPERATURE

NOISE = 5.0  # N
WARM = 40.0  # deg C, where the model was identified
PLAY, WIDTH, RISING = 60.0, 1.5e-3, 40.0
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
    "opening": lambda k, force, slope: RISING * np.sign(k.velocity * k.acceleration) * (np.abs(k.velocity) > 0.2),
}
SHOWS = {
    "blow-off": "velocity", "friction": "velocity", "mass": "acceleration", "shift": "acceleration",
    "series": "acceleration", "valve": "acceleration", "fade": "temperature", "current": "command",
    "spring": "displacement", "stops": "displacement", "bypass": "position",
    "opening": "history",
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


def hysteresis(width, sign=1.0):
    return lambda k, force, slope: sign * PLAY * play(k.displacement, k.dt, width)


def at(curve: AtlasCurve, places) -> np.ndarray:
    return np.interp(places, curve.at, curve.value)


@pytest.mark.parametrize("name", HIDDEN)
def test_what_was_hidden_shows_in_its_curve_and_nowhere_else(name, found):
    curves = found(HIDDEN[name])
    assert [curve.name for curve in curves.values() if curve.is_notable] == [SHOWS[name]]
    assert curves[SHOWS[name]].explains > (0.1 if curves[SHOWS[name]].is_memory else 0.6)
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


@pytest.mark.parametrize("width", [0.1e-3, 0.4e-3, 1.5e-3, 5e-3])
def test_a_hysteresis_rises_over_the_way_since_the_reversal_until_it_saturates(found, width):
    curves = found(hysteresis(width))
    assert {name for name, curve in curves.items() if curve.is_notable} == {"velocity", "memory"}
    way, value = np.array(curves["memory"].at), np.array(curves["memory"].value)
    assert way[0] == 0.0 and np.all(np.diff(way) > 0.0) and value[-1] == 0.0
    np.testing.assert_allclose(value, PLAY * (np.minimum(way / width, 2.0) - 2.0), atol=0.1 * PLAY)
    np.testing.assert_allclose(at(curves["velocity"], [-0.4, -0.1, 0.1, 0.4]), np.repeat([-PLAY, PLAY], 2), atol=6.0)


@pytest.mark.parametrize("width", [0.2e-3, 0.7e-3, 3e-3])
def test_a_hysteresis_that_saturates_between_the_points_of_the_curve_is_flat_beyond(found, width):
    curve = found(hysteresis(width))["memory"]
    way, value = np.array(curve.at), np.array(curve.value)
    assert curve.is_notable and np.all(np.abs(value[way > 2.0 * width]) < 0.15 * PLAY)
    np.testing.assert_allclose(value[0], -2.0 * PLAY, rtol=0.15)


def test_the_curve_over_the_way_turns_with_the_sign_of_what_was_hidden(found):
    rises, falls = (np.array(found(hysteresis(WIDTH, sign))["memory"].value) for sign in (1.0, -1.0))
    np.testing.assert_allclose(rises, -falls, atol=8.0)


def test_what_acts_at_rising_speed_only_is_halved_between_history_and_velocity(found):
    curves = found(lambda k, force, slope: np.where(k.velocity * k.acceleration > 0.0, 2.0 * RISING, 0.0))
    np.testing.assert_allclose(at(curves["history"], [-0.3, 0.3]), [2.0 * RISING] * 2, rtol=0.15)
    both = found(HIDDEN["opening"])
    assert not both["velocity"].is_notable and np.all(at(both["history"], [-0.4, 0.4]) > RISING)


def test_a_mass_beside_a_hysteresis_keeps_its_size_and_its_share(found):
    curves = found(lambda k, force, slope: HIDDEN["mass"](k, force, slope) + hysteresis(WIDTH)(k, force, slope))
    assert {name for name, curve in curves.items() if curve.is_notable} == {"velocity", "acceleration", "memory"}
    mass = next(one for one in curves["acceleration"].templates if one.name == "mass")
    assert mass.size == pytest.approx(MASS, rel=0.1)
    assert mass.explains <= curves["acceleration"].explains + 0.02


def test_curves_of_memory_that_say_nothing_leave_the_others_as_they_are(found, monkeypatch):
    with_them = found(HIDDEN["shift"])
    assert not with_them["history"].is_notable and not with_them["memory"].is_notable
    every = atlas_curves_module.panels_of
    monkeypatch.setattr(
        atlas_curves_module, "panels_of", lambda *seen: [panel for panel in every(*seen) if not panel.is_memory]
    )
    for name, curve in found(HIDDEN["shift"]).items():
        np.testing.assert_allclose(with_them[name].value, curve.value, rtol=1e-6, atol=1e-6)
        assert with_them[name].explains == pytest.approx(curve.explains)


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
    always = {"velocity", "displacement", "position", "acceleration", "history", "memory"}
    assert {curve.name for curve in curves} == always


@pytest.mark.parametrize("share, points", [(1.0, 5), (0.1, 3), (0.01, 2), (0.003, 0)])
def test_the_way_since_a_reversal_is_followed_no_farther_than_half_the_stroke(user_model, base, share, points):
    block = base.kinematics.block.copy()
    block[:3] *= share
    small = replace(base, kinematics=replace(base.kinematics, block=block))
    data = data_of(user_model, [small], [small])
    ways = [curve.at for curve in atlas_curves(baseline_of(user_model, data)) if curve.name == "memory"]
    assert sum(map(len, ways)) == points
    assert all(max(way) <= 0.5 * data.ranges.stroke for way in ways)


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
