"""The car with seven degrees of freedom against an independent computation: transfer functions of the linear car.

The equations here are written out body by body, in other coordinates than the simulation's (four heights of the body's
corners would be redundant: here heave, pitch, roll, and the wheels' travels relative to the body).
"""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from damper_estimator.effects.discovery import find_effect
from damper_estimator.errors import InputError
from damper_estimator.model import DamperModel, load_model, make_element
from damper_estimator.vehicle import FullCar, four_posts, load_car, on_posts, sweep, transfer

CAR = load_car("compact_car")


def viscous(rate: float) -> DamperModel:
    return DamperModel("linear", "test", (make_element(find_effect("viscous"), {"rate": rate}),))


def analytic(car: FullCar, rates: tuple[float, float], frequency: float, posts: np.ndarray) -> np.ndarray:
    """Complex heights of the body above the four wheels for posts (4,), by Newton's laws at one frequency."""
    s = 2j * np.pi * frequency
    front, rear = (car.front, 1.0, rates[0]), (car.rear, -1.0, rates[1])
    axles = [front, front, rear, rear]
    sides = [1.0, -1.0, 1.0, -1.0]
    # Unknowns: heave, pitch, roll, and extension of each suspension.
    matrix, right = np.zeros((7, 7), complex), np.zeros(7, complex)
    body = car.body
    matrix[0, 0], matrix[1, 1], matrix[2, 2] = body.mass * s**2, body.pitch_inertia * s**2, body.roll_inertia * s**2
    for i, ((axle, sign, rate), side) in enumerate(zip(axles, sides, strict=True)):
        x, y = sign * axle.distance, 0.5 * side * axle.track
        other = 3 + (i ^ 1)
        strut = axle.spring_rate + s * rate * axle.damper_ratio**2
        force = {3 + i: strut + axle.anti_roll_rate, other: -axle.anti_roll_rate}
        for column, value in force.items():
            matrix[0, column] += value
            matrix[1, column] += x * value
            matrix[2, column] += y * value
            matrix[3 + i, column] += value
        # The wheel stands at heave + x pitch + y roll - extension.
        tyre = axle.tyre_rate + s * axle.tyre_damping
        for column, share in ((0, 1.0), (1, x), (2, y), (3 + i, -1.0)):
            matrix[3 + i, column] -= share * (axle.wheel_mass * s**2 + tyre)
        right[3 + i] = -tyre * posts[i]
    heave, pitch, roll = np.linalg.solve(matrix, right)[:3]
    return np.array([heave + sign * a.distance * pitch + 0.5 * side * a.track * roll
                     for (a, sign, _), side in zip(axles, sides, strict=True)])  # fmt: skip


@pytest.mark.parametrize("rates", [(1500.0, 1300.0), (300.0, 6000.0)])
def test_the_swept_linear_car_has_the_analytic_transfer_functions(rates: tuple[float, float]) -> None:
    models = {"front": viscous(rates[0]), "rear": viscous(rates[1])}
    seconds, still = 30.0, 30.0  # a resonance at a hundredth of the critical damping decays
    height = sweep(0.01, seconds=seconds, still=still)
    run = on_posts(CAR, models, four_posts(height))
    for front in (True, False):
        # One line of the spectrum in the middle of each band: a mean over several misses a sharp resonance.
        line = 1.0 / (seconds + still)
        found = transfer(height, run.over_axle(front), run.step, low=41.5 * line, high=348.5 * line, width=line)
        wanted = [analytic(CAR, rates, f, np.ones(4))[0 if front else 2] for f in found.frequency]
        assert np.abs(found.value - wanted).max() < 0.005 * np.abs(wanted).max()


def test_a_single_post_moves_all_corners_by_newtons_laws() -> None:
    """Roll and the anti-roll bars take part only where the posts differ."""
    rates, frequency, step = (1500.0, 1300.0), 1.7, 2.5e-4
    time = step * np.arange(round(14.0 / step))
    post = np.zeros((4, time.size))
    post[1] = 0.005 * np.sin(2.0 * np.pi * frequency * time) * np.clip(time, 0.0, 1.0)
    run = on_posts(CAR, {"front": viscous(rates[0]), "rear": viscous(rates[1])}, post, step)
    late = slice(-round(5.0 / frequency / step), None)
    turning = np.exp(-2j * np.pi * frequency * time[late])
    found = (run.body[:, late] * turning).mean(axis=1) / (post[1, late] * turning).mean()
    wanted = analytic(CAR, rates, frequency, np.array([0.0, 1.0, 0.0, 0.0]))
    assert found == pytest.approx(wanted, abs=0.005 * np.abs(wanted).max())


def test_the_simulation_converges_with_the_second_order() -> None:
    curve = load_model("renault_modified_bouc_wen_point_1").without("renault_hysteresis")
    models = {"front": curve, "rear": curve}

    def body(step: float) -> np.ndarray:
        time = step * np.arange(round(1.0 / step) + 1)
        height = 0.01 * np.sin(2.0 * np.pi * 3.0 * time) * np.clip(2.0 * time, 0.0, 1.0) ** 2
        return on_posts(CAR, models, four_posts(height), step).body[:, :: round(2e-3 / step)]

    finest = body(6.25e-5)
    errors = [np.sqrt(np.mean((body(step) - finest) ** 2)) for step in (1e-3, 5e-4, 2.5e-4)]
    assert np.log2(errors[0] / errors[2]) / 2.0 > 1.5
    assert errors[2] < 1e-4 * finest.std()


def test_at_rest_nothing_moves_whatever_the_static_damper_forces() -> None:
    models = {axle: load_model("renault_modified_bouc_wen") for axle in ("front", "rear")}
    run = on_posts(CAR, models, np.zeros((4, 4000)))
    assert np.abs(run.body).max() < 1e-9


def test_slow_posts_lift_the_body_with_them() -> None:
    time = 2.5e-4 * np.arange(40000)
    height = 0.02 * np.clip(time / 5.0, 0.0, 1.0) ** 2 * (3.0 - 2.0 * np.clip(time / 5.0, 0.0, 1.0))
    run = on_posts(CAR, {"front": viscous(2000.0), "rear": viscous(2000.0)}, four_posts(height))
    assert run.body[:, -1] == pytest.approx(np.full(4, 0.02), abs=2e-5)


def test_a_sweep_covers_its_frequencies_at_its_amplitude_and_ends_at_rest() -> None:
    height = sweep(0.003, 0.5, 6.0, 60.0, 5.0)
    assert np.abs(height).max() == pytest.approx(0.003, rel=1e-3)
    assert np.all(height[-round(5.0 / 2.5e-4) :] == 0.0)
    power = np.abs(np.fft.rfft(height)) ** 2
    frequency = np.fft.rfftfreq(height.size, 2.5e-4)
    assert power[(frequency > 0.45) & (frequency < 6.05)].sum() > 0.99 * power.sum()


def test_a_model_without_finite_force_is_an_error() -> None:
    wild = DamperModel("wild", "test", (make_element(find_effect("viscous"), {"rate": 1e5}),))
    heavy = replace(CAR, front=replace(CAR.front, wheel_mass=0.05))
    with pytest.raises(FloatingPointError, match="no finite motion"):
        on_posts(heavy, {"front": wild, "rear": wild}, four_posts(sweep(0.01, seconds=2.0)))


@pytest.fixture
def car_file(tmp_path: Path) -> Callable[[str, str], Path]:
    """A changed copy of the installed car."""
    text = Path("config/vehicles/compact_car.yaml")
    source = (Path(__file__).resolve().parents[2] / text).read_text(encoding="utf-8")

    def changed(old: str, new: str) -> Path:
        assert old in source
        (tmp_path / "car.yaml").write_text(source.replace(old, new), encoding="utf-8")
        return tmp_path / "car.yaml"

    return changed


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("mass: 1160.0", "mass: -3.0", "body.mass = -3.0 is not a number above 0"),
        ("mass: 1160.0", "mass: .inf", "body.mass = inf is not a number above 0"),
        ("roll_inertia", "rolling", "body.rolling is unknown"),
        ("rear:", "back:", "rear is missing or not a mapping; back is an unknown key"),
        ("front:", "front: 3\nx:", "front is missing or not a mapping"),
    ],
)
def test_a_wrong_file_is_refused_in_one_line_with_all_faults(
    car_file: Callable[[str, str], Path], old: str, new: str, message: str
) -> None:
    with pytest.raises(InputError, match="correct the file") as refusal:
        load_car(car_file(old, new))
    assert message in str(refusal.value)
    assert "\n" not in str(refusal.value)


def test_a_file_is_loaded_with_its_values(car_file: Callable[[str, str], Path]) -> None:
    changed = load_car(car_file("anti_roll_rate: 5000.0", "anti_roll_rate: 0.0"))
    assert changed.rear.anti_roll_rate == 0.0
    assert replace(changed, rear=CAR.rear) == CAR
    with pytest.raises(InputError, match="available: compact_car"):
        load_car("hovercraft")
