"""A fit finds the parameters that the data were made with, states its uncertainty, and obeys its settings."""

from dataclasses import replace

import numpy as np
import pytest

from damper_estimator.errors import InputError
from damper_estimator.identification import fit, pooled_error
from damper_estimator.model import load_model

SEEDS = range(12)
COVERED = (0.85, 1.0)  # share of 95 % intervals that may hold the truth, 60 parameters counted
FAR = 4.5  # standard errors: farther off, a value is wrong
EXACT = 1e-6  # of a value: two fits are the same except for rounding


def values(result):
    return {p.name: p.value for p in result.parameters}


def errors(result):
    return {p.name: p.standard_error for p in result.parameters}


def deviations(result, truth):
    """Distance from the truth in standard errors."""
    true = {slot.address: slot.value for slot in truth.slots}
    return {p.name: (p.value - true[p.name]) / p.standard_error for p in result.parameters}


@pytest.fixture
def baseline():
    return load_model("memoryless_baseline").with_values(
        {
            "tanh_hysteresis.force": 420.0,
            "tanh_hysteresis.steepness": 55.0,
            "tanh_hysteresis.shift": 0.004,
            "viscous.rate": 2100.0,
            "static_force.force": 25.0,
        }
    )


def test_the_truth_lies_in_the_stated_intervals_as_often_as_stated(baseline, measured):
    away = [
        d
        for seed in SEEDS
        for d in deviations(fit(load_model("memoryless_baseline"), [measured(baseline, seed)]), baseline).values()
    ]
    assert len(away) == 5 * len(SEEDS)
    assert COVERED[0] <= np.mean(np.abs(away) < 1.96) <= COVERED[1]
    assert 0.7 < np.std(away) < 1.3


def test_the_carrera_akutain_model_is_recovered_from_two_excitations(measured):
    truth = load_model("carrera_akutain").with_values(
        {
            "leak_blow_off_port.leak_rebound": 32000.0,
            "leak_blow_off_port.preload_rebound": 700.0,
            "leak_blow_off_port.transition_rebound": 2.0,
            "leak_blow_off_port.spring_compression": 900.0,
            "leak_blow_off_port.port_compression": 250.0,
            "seal_friction.rebound": 30.0,
            "acceleration_hysteresis.constant": -3.0,
            "static_force.force": 12.0,
        }
    )
    result = fit(load_model("carrera_akutain"), [measured(truth, 1, rms=0.008), measured(truth, 2, rms=0.02)])
    assert result.converged and len(result.parameters) == 14
    assert max(map(abs, deviations(result, truth).values())) < FAR
    assert result.esr < 1e-4


RECOVERED = {
    "a lag of the force": (
        ("viscous", {"rate": 2200.0}),
        ("coulomb", {"force": 80.0}),
        ("force_lag", {"time_constant": 0.004}),
    ),
    "a groove": (("viscous", {"rate": 1500.0}), ("position_gain", {"gain": 0.6, "middle": 0.004})),
    "a skew and an offset of the gauge": (
        ("viscous", {"rate": 2200.0}),
        ("channel_skew", {"skew": 0.003}),
        ("force_offset", {"offset": 40.0}),
    ),
    "friction with memory": (("viscous", {"rate": 900.0}), ("dahl", {"force": 120.0, "stiffness": 3e5})),
}


@pytest.mark.parametrize("name", RECOVERED)
def test_parameters_behind_memory_and_modifiers_are_recovered(name, entry, model_of, measured):
    truth = model_of(*(entry(effect, **given) for effect, given in RECOVERED[name]))
    start = model_of(*(entry(effect) for effect, _ in RECOVERED[name]))
    result = fit(start, [measured(truth)])
    assert result.converged
    known = {name: d for name, d in deviations(result, truth).items() if np.isfinite(d)}
    assert set(known) >= {f"{effect}.{given}" for effect, values in RECOVERED[name] for given in values}
    assert max(map(abs, known.values())) < FAR


def test_a_compliance_around_the_damper_is_recovered(entry, model_of, measured):
    inner = entry("viscous", rate=2500.0), entry("coulomb", force=60.0)
    truth = model_of(entry("oil_spring", inner, stiffness_rebound=5e5, stiffness_compression=8e5))
    start = model_of(entry("oil_spring", (entry("viscous"), entry("coulomb"))))
    result = fit(start, [measured(truth, seconds=6.0)], starts=0)
    assert result.converged and max(map(abs, deviations(result, truth).values())) < FAR


def test_a_poor_start_is_overcome_by_the_datas_own(baseline, measured):
    far = load_model("memoryless_baseline").with_values(
        {"tanh_hysteresis.steepness": 4000.0, "tanh_hysteresis.shift": -0.05}
    )
    result = fit(far, [measured(baseline)])
    assert max(map(abs, deviations(result, baseline).values())) < FAR


def test_equal_seeds_give_equal_results(baseline, measured):
    first, second = (fit(load_model("memoryless_baseline"), [measured(baseline)], seed=7) for _ in range(2))
    assert values(first) == values(second) and errors(first) == errors(second)


def test_the_same_recording_twice_gives_the_same_values(baseline, measured):
    one, two = measured(baseline), [measured(baseline)] * 2
    single, double = (fit(load_model("memoryless_baseline"), recorded) for recorded in ([one], two))
    for name, value in values(single).items():
        assert values(double)[name] == pytest.approx(value, rel=EXACT)
        assert errors(double)[name] == pytest.approx(errors(single)[name] / np.sqrt(2.0), rel=0.05)
    assert double.rmse_n == pytest.approx(single.rmse_n, rel=EXACT)


def test_a_weight_of_zero_takes_a_recording_out(baseline, measured):
    other = load_model("memoryless_baseline")
    right, wrong = measured(baseline), measured(other, seed=1)
    weighted = fit(other, [right, wrong], weights=[1.0, np.zeros(len(wrong.kinematics))])
    for name, value in values(fit(other, [right])).items():
        assert values(weighted)[name] == pytest.approx(value, rel=1e-4)


@pytest.mark.parametrize("factor", [0.01, 20.0])
def test_forces_in_another_scale_give_parameters_in_that_scale(factor, baseline, measured):
    normal, scaled = (
        fit(load_model("memoryless_baseline"), [measured(baseline, scale=scale)]) for scale in (1.0, factor)
    )
    powers = {"tanh_hysteresis.force": factor, "viscous.rate": factor, "static_force.force": factor}
    for name, value in values(normal).items():
        assert values(scaled)[name] == pytest.approx(value * powers.get(name, 1.0), rel=1e-4)
    assert scaled.esr == pytest.approx(normal.esr, rel=1e-3)


def test_what_is_fixed_stays_and_what_is_freed_moves(measured):
    start = load_model("carrera_akutain")
    truth = start.with_values({"gas_spring.static_force": 350.0, "seal_friction.rebound": 90.0})
    data = [measured(truth, rms=0.02)]
    assert not {"gas_spring.static_force", "gas_spring.volume"} & set(values(fit(start, data, starts=0)))
    friction = fit(start, data, fix=["*"], free=["seal_friction"])
    assert list(values(friction)) == ["seal_friction.rebound", "seal_friction.compression"]
    unchanged = [slot.value for slot in friction.model.slots if not slot.address.startswith("seal_friction")]
    assert unchanged == [slot.value for slot in start.slots if not slot.address.startswith("seal_friction")]
    gas = fit(start, data, fix=["*"], free=["gas_spring.static_force", "seal_friction.rebound"])
    assert max(map(abs, deviations(gas, truth).values())) < FAR
    assert gas.model.fixed == start.fixed


def test_a_parameter_that_is_stopped_by_its_bound_is_named(entry, model_of, measured):
    pushing = measured(model_of(entry("viscous", rate=1000.0), entry("inertia", mass=20.0)))
    result = fit(model_of(entry("viscous"), entry("acceleration_hysteresis")), [pushing])
    bounded = {p.name: p for p in result.parameters}["acceleration_hysteresis.constant"]
    assert bounded.at_bound and bounded.value == 0.0 and np.isnan(bounded.standard_error)
    assert any("acceleration_hysteresis.constant" in warning and "bound" in warning for warning in result.warnings)
    assert not any(p.at_bound for p in result.parameters if p is not bounded)


def test_every_value_keeps_its_bounds_whatever_the_data(entry, model_of, measured):
    strange = measured(
        model_of(entry("viscous", rate=2e5), entry("static_force", force=-20000.0)), rms=0.05, scale=-1.0
    )
    result = fit(load_model("memoryless_baseline"), [strange])
    for slot in result.model.slots:
        assert slot.parameter.lower <= slot.value <= slot.parameter.upper
    assert any(p.at_bound for p in result.parameters)


def test_parameters_that_trade_off_are_named_together(entry, model_of, measured):
    twice = model_of(entry("viscous"), entry("viscous"), entry("coulomb"))
    result = fit(twice, [measured(twice)])
    assert result.undetermined == (("viscous.rate", "viscous#2.rate"),)
    assert any("viscous.rate and viscous#2.rate trade off" in warning for warning in result.warnings)
    assert np.isnan(errors(result)["viscous.rate"]) and errors(result)["coulomb.force"] > 0.0


def test_searched_parameters_that_trade_off_are_named_too(measured):
    truth = load_model("carrera_akutain").with_values({"leak_blow_off_port.port_rebound": 9000.0})
    below_the_knee = measured(truth, rms=0.0004)
    result = fit(truth, [below_the_knee], fix=["transition*", "spring*", "preload*", "*compression"], starts=0)
    assert ("leak_blow_off_port.leak_rebound", "leak_blow_off_port.port_rebound") in result.undetermined
    assert np.isnan(errors(result)["leak_blow_off_port.leak_rebound"])


def test_a_parameter_without_influence_is_named_alone_and_keeps_its_value(entry, model_of, measured):
    model = model_of(entry("viscous", rate=1200.0), entry("command_lag", time_constant=0.03))
    result = fit(model, [measured(model, command=1.0)])
    assert ("command_lag.time_constant",) in result.undetermined
    assert values(result)["command_lag.time_constant"] == 0.03


def test_the_error_is_the_documented_one(baseline, measured):
    recorded = measured(baseline)
    result = fit(load_model("memoryless_baseline"), [recorded])
    error = (recorded.in_band(result.model.force(recorded.kinematics.block)) - recorded.in_band(recorded.force))[
        recorded.judged
    ]
    assert result.rmse_n == pytest.approx(np.sqrt(np.mean(error**2)))
    assert result.esr == pytest.approx(error.var() / recorded.in_band(recorded.force)[recorded.judged].var())
    assert (result.rmse_before_n, result.esr_before, result.samples) == pooled_error(
        load_model("memoryless_baseline"), [recorded]
    )


def test_the_model_remembers_what_it_was_fitted_to(baseline, measured):
    recorded = [measured(baseline, 0), measured(baseline, 1)]
    record = fit(load_model("memoryless_baseline"), recorded).model.fit
    assert record["bags"] == ["recording_0", "recording_1"] and record["cutoff"] == 60.0
    assert set(record["region"]) == {"displacement", "velocity", "acceleration"}
    low, high = record["region"]["velocity"]
    velocity = np.concatenate([m.kinematics.velocity[m.judged] for m in recorded])
    assert velocity.min() <= low < np.percentile(velocity, 1) and np.percentile(velocity, 99) < high <= velocity.max()
    assert set(record["standard_errors"]) == {slot.address for slot in load_model("memoryless_baseline").slots}
    assert 0.0 < record["residual_stddev"] < 20.0
    assert record["force_stddev"] >= record["residual_stddev"]


def test_three_standard_deviations_of_the_force_cover_the_errors_on_recordings_that_were_not_fitted(baseline, measured):
    """Also where the form is not quite the damper's, so that the errors are no normal noise: Coulomb's law alone."""
    model = fit(load_model("coulomb"), [measured(baseline, seed) for seed in range(3)]).model
    unseen = [measured(baseline, seed) for seed in range(3, 6)]
    errors = np.concatenate([np.abs(model.force(m.kinematics.block) - m.force)[m.judged] for m in unseen])
    assert np.mean(errors > 3.0 * model.fit["force_stddev"]) < 0.003
    assert errors.max() > 1.5 * model.fit["force_stddev"]  # it is no idle bound


def test_a_model_that_contains_another_never_fits_worse(baseline, measured):
    recorded = [measured(baseline, noise=0.1)]
    smaller = fit(load_model("linear_viscous"), recorded)
    larger = fit(smaller.model.with_effect(load_model("memoryless_baseline").effects[0]), recorded)
    assert larger.rmse_n <= smaller.rmse_n * (1.0 + EXACT)


def test_a_command_that_begins_late_costs_only_what_came_before(entry, model_of, measured):
    model = model_of(entry("viscous", rate=800.0), entry("semi_active_squash"))
    command = np.where(np.arange(4000) < 500, np.nan, 1.0 + 0.5 * np.sin(np.arange(4000) / 300.0))
    recorded = measured(model, command=command)
    result = fit(model, [recorded], starts=0)
    assert result.samples < recorded.judged.sum() - 400
    assert any("samples were left out" in warning for warning in result.warnings)
    assert max(abs(d) for d in deviations(result, model).values() if np.isfinite(d)) < FAR


def test_without_filters_every_sample_counts(baseline, measured):
    recorded = replace(measured(baseline), cutoff=0.0, band=0.0)
    result = fit(load_model("memoryless_baseline"), [recorded])
    assert result.samples == recorded.judged.sum()
    assert max(map(abs, deviations(result, baseline).values())) < FAR
    assert result.rmse_n == pytest.approx(0.01 * recorded.force.std(), rel=0.1)


def refusal(*arguments, **options):
    with pytest.raises(InputError) as caught:
        fit(*arguments, **options)
    return str(caught.value)


def test_what_cannot_be_fitted_is_refused_with_the_reason(baseline, entry, model_of, measured):
    model, recorded = load_model("memoryless_baseline"), measured(baseline)
    broken = recorded.force.copy()
    broken[1000] = np.nan
    assert "no measured force" in refusal(model, [replace(recorded, force=None)])
    assert "not a number" in refusal(model, [replace(recorded, force=broken)])
    assert "fixed" in refusal(model, [recorded], fix=["*"])
    assert "no parameter coulomb" in refusal(model, [recorded], fix=["coulomb"])
    assert "viscous.rate" in refusal(model, [recorded], free=["viscous.rat"])
    assert "samples" in refusal(model, [recorded.part(0, 80)])
    assert "no sample can be judged" in refusal(model, [recorded.part(0, 20)])
    assert "no recordings" in refusal(model, [])
    still = replace(recorded, raw_displacement=np.full_like(recorded.raw_displacement, 0.01))
    assert "displacement never changes" in refusal(model, [still])
    assert "measured force never changes" in refusal(model, [replace(recorded, force=np.zeros_like(recorded.force))])
    assert "least_squares" in refusal(model, [recorded], method="guessing")
    assert "no command" in refusal(model_of(entry("semi_active_squash")), [recorded])
