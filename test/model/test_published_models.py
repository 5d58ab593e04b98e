"""The papers' models with the papers' values against the papers' numbers."""

import numpy as np
import pytest

from damper_estimator.model import load_model
from damper_estimator.model.model_files import library_models
from damper_estimator.signals.layout import COMMAND, DT, ROWS, A, T, V, X

NAMES = [
    "linear_viscous", "viscous_curve", "coulomb", "dahl", "lugre", "bouc_wen", "bouc_wen_shifted",
    "renault_modified_bouc_wen", "his_piecewise", "his_non_hysteresis", "his_permanent_hysteresis", "kwok", "guo",
    "cesmeci", "lozoya_santos_simple", "lozoya_santos_inertial_simple", "lozoya_santos_stiff_simple",
    "lozoya_santos_complete", "carrera_akutain", *(f"black_box_{k}" for k in range(1, 13)), "force_surface",
]  # fmt: skip
# HIS Table 1: peak speed m/s, peak force in rebound and compression N, at 45 mm.
HIS_PEAKS = {
    0.1: (1848, -987), 0.2: (3023, -1502), 0.3: (3911, -2124), 0.4: (4630, -2740), 0.5: (5308, -3358),
    0.6: (5713, -4092), 0.7: (6101, -4691), 0.8: (6482, -5125), 0.9: (6934, -5779), 1.0: (7058, -6292),
}  # fmt: skip


def sine(frequency, amplitude, command=np.nan, cycles=4, samples_per_cycle=2000):
    time = np.arange(cycles * samples_per_cycle + 1) / (frequency * samples_per_cycle)
    omega = 2 * np.pi * frequency
    block = np.full((ROWS, time.size), np.nan)
    block[T], block[DT] = time, np.diff(time, prepend=0.0)
    block[X] = amplitude * np.sin(omega * time)
    block[V] = amplitude * omega * np.cos(omega * time)
    block[A] = -(omega**2) * block[X]
    block[COMMAND] = command
    return block


def last_cycle(values, samples_per_cycle=2000):
    return values[..., -samples_per_cycle - 1 :]


def forces_at_peaks(name, speed, amplitude=0.045):
    block = sine(speed / (2 * np.pi * amplitude), amplitude)
    force, velocity = last_cycle(load_model(name).force(block)), last_cycle(block[V])
    return force[np.argmax(velocity)], force[np.argmin(velocity)]


def test_the_library_has_every_documented_name():
    assert set(NAMES) <= set(library_models())


@pytest.mark.parametrize(("current", "peaks"), [(0.0, (613, -547)), (1.0, (882, -818)), (2.0, (1287, -1225))])
def test_lozoya_santos_table_15_gives_its_recomputed_peaks(current, peaks):
    force = last_cycle(load_model("lozoya_santos_complete").force(sine(1.0, 0.005, current)))
    assert (force.max(), force.min()) == pytest.approx(peaks, abs=1.0)


def test_his_table_3_misses_table_1_as_noted():
    ratios = {speed: np.array(forces_at_peaks("his_piecewise", speed)) / peaks for speed, peaks in HIS_PEAKS.items()}
    assert ratios[0.1][0] == pytest.approx(1.13, abs=0.01)
    assert ratios[0.5][0] == pytest.approx(0.96, abs=0.01)
    assert ratios[1.0][0] == pytest.approx(1.14, abs=0.01)
    assert forces_at_peaks("his_piecewise", 0.1)[1] == pytest.approx(-149.0, abs=1.0)
    assert all(1.12 - 0.005 < ratios[speed][1] < 1.25 + 0.02 for speed in ratios if speed > 0.4)


def test_his_models_agree_where_nothing_is_delayed_and_differ_in_hysteresis():
    slow = sine(0.05, 0.002)
    without = load_model("his_non_hysteresis").force(slow)
    assert load_model("his_piecewise").force(slow) == pytest.approx(without, abs=0.02 * np.abs(without).max())
    fast = sine(2.0, 0.045)
    one, other = (last_cycle(load_model(n).force(fast)) for n in ("his_piecewise", "his_permanent_hysteresis"))
    high_speed = np.abs(last_cycle(fast[V])) > 0.5
    open_loop = last_cycle(load_model("his_non_hysteresis").force(fast))
    assert np.abs(one - open_loop)[high_speed].max() < 1e-6 < 100 < np.abs(other - open_loop)[high_speed].max()


def test_no_delay_makes_his_piecewise_the_non_hysteretic_model():
    block = sine(1.5, 0.045)
    undelayed = load_model("his_piecewise").with_values({"velocity_delay.delay": 0.0})
    assert undelayed.force(block) == pytest.approx(load_model("his_non_hysteresis").force(block))


@pytest.mark.parametrize(("damper", "low", "high"), [("a", -0.204, 0.538)])
def test_black_box_12_folds_back_at_the_edges_of_its_region(damper, low, high):
    model = load_model(f"black_box_12_{damper}")
    velocity = np.linspace(-0.6, 0.7, 2601)
    block = sine(1.0, 0.01, samples_per_cycle=650)[:, : velocity.size]
    block[X], block[A], block[V] = 0.0, 0.0, velocity
    force = model.force(block)
    rising = velocity[1:][np.diff(force) > 0]
    assert model.fit["region"]["velocity"] == [low, high]
    assert (rising.min(), rising.max()) == pytest.approx((low, high), abs=2e-3)


@pytest.mark.parametrize("damper", "abc")
def test_black_box_12_equals_the_corrected_equation(damper):
    model = load_model(f"black_box_12_{damper}")
    x = [s.value for s in model.slots]
    block = sine(3.0, 0.008)
    d, w, b = 1000 * block[X], 1000 * block[V], 1000 * block[A]
    first = x[0] + x[1] * w + np.where(w > 0, x[2], x[3]) * w**2 * np.sign(w)
    expected = first * (x[4] + x[5] * np.tanh(d / (3 * 7.5))) * (x[6] + x[7] * np.tanh(b / (3 * 40000.0)))
    assert model.force(block) == pytest.approx(expected, rel=1e-9, abs=1e-6)


@pytest.mark.parametrize(("inner", "outer"), [(3, 4), (3, 5), (4, 6), (5, 6), (4, 7), (9, 10), (1, 2)])
def test_nesting_black_boxes_contain_the_smaller_ones(inner, outer):
    """The larger model with its additions switched off has the smaller one's force."""
    block = sine(2.0, 0.01)
    small, large = load_model(f"black_box_{inner}"), load_model(f"black_box_{outer}")
    shared = {
        s.address: s.value + 0.3 for s in small.slots if not s.fixed and s.address in {t.address for t in large.slots}
    }
    assert large.with_values(shared).force(block) == pytest.approx(small.with_values(shared).force(block), abs=1e-9)


@pytest.mark.parametrize(("point", "saturated"), [("_point_1", 0.94), ("_point_2", 1.30), ("_point_3", 1.07)])
def test_renaults_points_saturate_as_recomputed(point, saturated):
    values = {
        s.address.split(".")[1]: s.value
        for s in load_model(f"renault_modified_bouc_wen{point}").slots
        if "renault" in s.address
    }
    limit = (values["delta"] / (values["beta"] + values["gamma"])) ** (1 / values["n"])
    assert limit == pytest.approx(saturated, abs=0.01)


@pytest.mark.parametrize("name", sorted(library_models()))
def test_every_model_names_its_source_and_has_finite_forces_at_its_values(name):
    model = load_model(name)
    force = model.force(sine(1.5, 0.02, 0.5, samples_per_cycle=300))
    assert model.name == name and len(model.source) > 10 and model.notes
    assert np.isfinite(force).all()
    if name not in ("force_surface", "viscous_curve"):  # tables that need data
        assert np.ptp(force) > 1.0
