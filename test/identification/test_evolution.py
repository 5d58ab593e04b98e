"""Direct search, genetic algorithm and NSGA-II: they arrive, keep bounds, repeat by seed, say what they need."""

import sys

import numpy as np
import pytest

from damper_estimator.errors import InputError
from damper_estimator.identification import Front, LocalRows, MethodOptions, Problem, fit, load_front
from damper_estimator.identification.excitation_problem import ExcitationProblem
from damper_estimator.identification.population import Scale, first_generation
from damper_estimator.identification.rows import rows_of
from damper_estimator.model import load_model
from damper_estimator.signals import Counts, Measurement, default_signals
from damper_estimator.signals.kinematics import differentiate_recording

FAR = 4.5  # standard errors: farther off, a value is wrong
SERIES = [(1.5, 0.1), (1.5, 0.3), (12.0, 0.1), (12.0, 0.3), (12.0, 0.7), (12.0, 1.2)]  # Hz, m/s: Gao et al., Table 1
GAO = {"LVLF": 2, "LVHF": 2, "HVHF": 2}
BRIEF = MethodOptions(generations=12, population=24)


def sines(model, *series, rate=400.0, cycles=8):
    """A recording of sines (Hz, m/s) one after the other, with half a second of rest between."""
    parts = []
    for frequency, speed in series:
        time = np.arange(int(max(cycles / frequency, 1.0) * rate)) / rate
        parts += [np.zeros(int(rate / 2)), speed / (2 * np.pi * frequency) * np.sin(2 * np.pi * frequency * time)]
    x = np.concatenate(parts)
    stamp = np.round(np.arange(x.size) / rate * 1e9).astype(np.int64)
    kinematics, _ = differentiate_recording(stamp, x, 60.0, 0.1)
    force = model.force(kinematics.block)
    force = force + 0.01 * force.std() * np.random.default_rng(x.size).standard_normal(x.size)
    name = "_".join(f"{frequency:g}Hz{speed:g}" for frequency, speed in series)
    counts, signals = Counts(samples=x.size), default_signals("d")
    return Measurement(f"{name}.mcap", "d", kinematics, force, kinematics.warm(), counts, force, x, 60.0, 30.0, signals)


def deviations(result, truth):
    true = {slot.address: slot.value for slot in truth.slots}
    return [(p.value - true[p.name]) / p.standard_error for p in result.parameters if np.isfinite(p.standard_error)]


@pytest.mark.parametrize("method", ["hooke_jeeves", "genetic"])
@pytest.mark.parametrize("name", ["memoryless_baseline", "bouc_wen", "kwok", "black_box_6", "linear_viscous"])
def test_a_model_is_recovered_without_derivatives(method, name, measured):
    truth = load_model(name)
    data = [measured(truth, 1, seconds=6.0, rms=0.005), measured(truth, 2, seconds=6.0, rms=0.012)]
    start = truth.with_values({slot.address: 1.4 * slot.value for slot in truth.slots if not slot.fixed})
    result = fit(start, data, method=method, method_options=BRIEF)
    assert result.esr < 1e-4
    assert max(map(abs, deviations(result, truth))) < FAR


@pytest.mark.parametrize("method", ["hooke_jeeves", "genetic", "nsga2"])
def test_bounds_are_kept_and_seeds_repeat(method, entry, model_of, measured):
    pushing = measured(model_of(entry("viscous", rate=1000.0), entry("inertia", mass=20.0)), seconds=6.0)
    start = model_of(entry("viscous"), entry("tanh_hysteresis"), entry("acceleration_hysteresis"))
    first, second = (fit(start, [pushing], method=method, seed=3, method_options=BRIEF) for _ in range(2))
    assert [p.value for p in first.parameters] == [p.value for p in second.parameters]
    for slot in first.model.slots:
        assert slot.parameter.lower <= slot.value <= slot.parameter.upper
    assert first.rmse_n < first.rmse_before_n


def test_direct_search_goes_on_where_the_force_has_no_derivative(entry, model_of, measured):
    truth = model_of(entry("viscous", rate=900.0), entry("joint_play", (entry("coulomb", force=150.0),), play=2e-4))
    start = truth.with_values({"joint_play.play": 6e-4, "coulomb.force": 80.0})
    result = fit(start, [measured(truth, seconds=4.0)], fix=["joint_play.stiffness"], method="hooke_jeeves", starts=0)
    assert result.esr < 2e-4


def test_his_is_identified_by_the_genetic_algorithm_from_data_of_table_3(measured):
    truth = load_model("his_piecewise")
    data = [measured(truth, seed, rms=rms) for seed, rms in enumerate((0.03, 0.07), 1)]
    start = truth.with_values({s.address: 1.3 * s.value for s in truth.slots if s.parameter.name != "delay"})
    result = fit(start, data, method="genetic", method_options=MethodOptions(generations=30, population=40))
    assert len(result.parameters) == 15
    assert result.esr < 1e-3
    values = {slot.address: slot.value for slot in result.model.slots}
    for address in ("velocity_delay.delay", "viscous.rate", "his_saturation.slope_compression"):
        true = {slot.address: slot.value for slot in truth.slots}[address]
        assert values[address] == pytest.approx(true, rel=0.05)


@pytest.fixture(scope="module")
def lagging(entry):
    """A damper that the model to fit cannot copy at low and high frequency alike."""
    return load_model("bouc_wen").with_effect(entry("force_lag", time_constant=0.004))


@pytest.fixture(scope="module")
def fronted(lagging):
    method_options = MethodOptions(generations=15, population=40)
    return fit(displaced(), [sines(lagging, *SERIES)], method="nsga2", method_options=method_options)


def displaced():
    model = load_model("bouc_wen")
    return model.with_values({slot.address: 1.5 * slot.value for slot in model.slots if not slot.fixed})


def excited(rows, given):
    """The excitations of rows by group, and for each group the positions of the rows of each."""
    found = ExcitationProblem(Problem(load_model("linear_viscous"), LocalRows(rows), (0,)), given)
    return found, found.problem.source.members


def test_a_series_of_sines_is_split_into_excitations_and_groups(lagging):
    together = excited([rows_of(sines(lagging, *SERIES))], {})
    apart = excited([rows_of(sines(lagging, one)) for one in SERIES], {})
    for found, members in (together, apart):
        assert dict(zip(found.groups, map(len, found.sizes), strict=True)) == GAO
        assert [[positions.size for positions in group] for group in members if group] == [
            sizes.tolist() for sizes in found.sizes
        ]
        every = np.concatenate([positions for group in members for positions in group])
        assert np.unique(every).size == every.size


def test_irregular_motion_gives_one_excitation_per_group(measured):
    rows = [rows_of(measured(load_model("linear_viscous"), seed, seconds=20.0)) for seed in range(2)]
    found, _ = excited(rows, {})
    assert len(found.groups) > 1 and all(len(sizes) <= 2 for sizes in found.sizes)


def test_given_groups_hold_the_recordings_that_they_name(lagging):
    rows = [rows_of(sines(lagging, one)) for one in SERIES]
    names = [recorded.measurement.recording for recorded in rows]
    found, _ = excited(rows, {"slow": names[:2], "fast": [n.removesuffix(".mcap") for n in names[2:]]})
    assert found.groups == ("slow", "fast") and list(map(len, found.sizes)) == [2, 4]
    with pytest.raises(InputError, match="no group"):
        excited(rows, {"slow": names[:2]})


def test_no_point_of_the_front_is_better_than_another_in_every_group(fronted):
    objectives = fronted.front.objectives
    assert fronted.front.groups == tuple(GAO) and fronted.front.excitations == tuple(GAO.values())
    assert len(objectives) > 5
    one, other = objectives[:, None, :], objectives[None]
    assert not ((one <= other).all(axis=2) & (one < other).any(axis=2)).any()


def test_groups_that_contradict_each_other_have_best_points_of_their_own(fronted):
    front = fronted.front
    corners = {front.row(group) for group in front.groups}
    assert len(corners) > 1
    assert (front.objectives[front.row("knee")] < 1.0).all()
    assert front.picked == front.row("knee")


def test_the_parameters_of_the_best_solutions_are_summarised_per_group(fronted):
    regimes = fronted.front.regimes(count=5)
    assert set(regimes) == set(GAO)
    for group, summary in regimes.items():
        best = np.argsort(fronted.front.objectives[:, fronted.front.groups.index(group)], kind="stable")[:5]
        column = fronted.front.values[best, fronted.front.names.index("bouc_wen.alpha")]
        assert summary["bouc_wen.alpha"]["mean"] == pytest.approx(column.mean())
        assert summary["bouc_wen.alpha"]["stddev"] == pytest.approx(column.std())


def test_a_point_is_picked_later_from_the_file_of_the_front(fronted, lagging, tmp_path):
    path = tmp_path / "model.front.csv"
    path.write_text(fronted.front.as_csv())
    again = load_front(path)
    assert np.array_equal(again.values, fronted.front.values) and again.names == fronted.front.names
    other = fit(
        displaced(), [sines(lagging, *SERIES)], method="nsga2", method_options=MethodOptions(front=again, pick="HVHF")
    )
    assert other.front.picked == again.row("HVHF")
    assert [p.value for p in other.parameters] == pytest.approx(again.values[again.row("HVHF")].tolist())
    with pytest.raises(InputError, match="options it was made with"):
        fit(load_model("kwok"), [sines(lagging, *SERIES)], method="nsga2", method_options=MethodOptions(front=again))


@pytest.mark.parametrize("pick", ["LVXF", "-1", "99999"])
def test_a_point_that_is_not_there_is_refused_with_those_that_are(pick):
    front = Front(("a.b",), ("LVLF", "HVHF"), np.zeros((3, 1)), np.array([[0.1, 0.9], [0.4, 0.4], [0.9, 0.1]]))
    with pytest.raises(InputError, match=r"knee, LVLF, HVHF.* 0 to 2"):
        front.row(pick)
    assert (front.row("knee"), front.row("LVLF"), front.row("HVHF"), front.row("2")) == (1, 0, 2, 2)


def test_a_file_that_is_no_front_is_refused(tmp_path):
    for content in ("", "point,e_a,b\n1,2\n", "a,b\n1,2\n"):
        (tmp_path / "x.csv").write_text(content)
        with pytest.raises(InputError, match="is no front"):
            load_front(tmp_path / "x.csv")


def test_shares_and_values_are_each_others_inverse():
    scale = Scale(np.array([-5.0, 0.0, 1e-3, -1e5, 2.0]), np.array([5.0, 1e6, 1e6, 0.0, 2.0]))
    shares = np.random.default_rng(1).uniform(size=(50, 5))
    values = scale.values(shares)
    assert np.allclose(scale.values(scale.shares(values)), values)
    assert np.array_equal(scale.values(np.zeros((1, 5))), [[-5.0, 0.0, 1e-3, -1e5, 2.0]])
    first = first_generation(scale, values[:10], 12, seed=0)
    assert first.shape == (12, 5) and np.allclose(scale.values(first[:6]), values[:6])


@pytest.mark.parametrize("method", ["genetic", "nsga2"])
def test_without_pymoo_the_methods_say_what_to_install(method, lagging, monkeypatch):
    monkeypatch.setitem(sys.modules, "pymoo", None)
    for name in [module for module in sys.modules if module.startswith("pymoo.")]:
        monkeypatch.setitem(sys.modules, name, None)
    with pytest.raises(InputError, match="pip install 'pymoo>=0.6.1'"):
        fit(load_model("bouc_wen"), [sines(lagging, *SERIES[:3])], method=method)
    assert fit(load_model("linear_viscous"), [sines(lagging, *SERIES[:3])]).converged
