"""Is the noise floor of a recording the error that a perfect model would show?

    python benchmarks/bench_noise_floor.py --cases 100 --seed 3

Dampers, drives and sensors are drawn at random (benchmarks/population); every seed draws others. The perfect model is
the simulated damper itself: once over the filtered displacement without errors of the sensors, once over the same with
them. The difference of its forces, less the error of the gauge, is the truth. Drift of the gauge is no noise and left
out. How held friction answers to noise shows in no motion, so the table also has the part in motion alone.
"""

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from bench_plan import share
from population import drives, families
from population.drives import RATE, Drive
from population.measurement_chain import RATES
from population.plant_parameters import FAMILIES, MAGNETO, MONO, TWIN, Plant
from population.simulate import Unstable, force_of
from scipy import signal
from scipy.interpolate import CubicSpline

from damper_estimator.signals import Measurement, SignalMap, default_signals
from damper_estimator.signals.channels import ChannelData
from damper_estimator.signals.layout import X
from damper_estimator.signals.measurement import measured
from damper_estimator.validation.noise import noise_floor

WITHIN = 1.2
MOVING = 0.02  # m/s
KINDS = (*drives.KINDS, "steps")


@dataclass(frozen=True)
class Sensing:
    """What is drawn of a measurement: Hz, m, N, A; steps of 0 are no quantisation, a corner of 0 is no filter."""

    rate: int
    gauge_rate: int
    x_noise: float
    x_step: float
    f_noise: float
    f_step: float
    x_corner: float
    f_corner: float
    jitter: float
    cutoff: float
    band: float


@dataclass(frozen=True)
class Case:
    """A drawn case: recordings, and the error in N of the perfect model by gauge and by displacement, (n,)."""

    damper: str
    drive: str
    heavy: bool
    sensing: Sensing
    noisy: Measurement
    clean: Measurement
    by_gauge: np.ndarray
    by_damper: np.ndarray
    force_rms: float

    def judged(self, least: float = 0.0) -> tuple[float, float]:
        """RMS in N of the perfect model's error and the noise floor, where the damper is not slower than ``least``."""
        moving = np.abs(self.clean.kinematics.velocity) >= least
        part = replace(self.noisy, judged=self.noisy.judged & moving)
        error = part.in_band(self.by_gauge + self.by_damper)[part.judged]
        return float(np.sqrt(np.mean(error**2))), noise_floor(part)

    @property
    def sensors(self) -> str:
        """Their kind, for the table."""
        s = self.sensing
        if s.x_step > 2e-4:
            return "displacement 0.5 mm"
        if s.x_corner or s.f_corner:
            return "filtered noise"
        return f"{'below 500 Hz' if s.rate < 500 else '500 Hz' if s.rate == 500 else 'above 500 Hz'}, white noise"


def sensing(rng: np.random.Generator, force_rms: float) -> Sensing:
    """Sensors from good to poor."""
    rate = int(rng.choice(list(RATES), p=list(RATES.values())))
    plain, filtered = rng.random() < 0.6, rng.random() < 0.2
    corner = np.exp(rng.uniform(*np.log((80.0, 500.0)), 2)) * (rng.random(2) < 0.7) * filtered
    return Sensing(
        rate=rate,
        gauge_rate=rate if rng.random() < 0.7 else int(rng.choice(list(RATES))),
        x_noise=float(np.exp(rng.uniform(*np.log((2e-6, 6e-5))))),
        x_step=float(rng.choice([0.0, 2e-6, 1e-5, 2.5e-5, 1e-4, 5e-4], p=[0.1, 0.2, 0.3, 0.25, 0.12, 0.03])),
        f_noise=force_rms * float(np.exp(rng.uniform(*np.log((1e-3, 2e-2))))),
        f_step=float(rng.choice([0.0, 0.2, 1.0, 3.0, 10.0], p=[0.1, 0.3, 0.3, 0.2, 0.1])),
        x_corner=float(corner[0]),
        f_corner=float(corner[1]),
        jitter=float(rng.choice([0.0, 1e-5, 4e-5])),
        cutoff=60.0 if plain else float(rng.choice([40.0, 60.0, 90.0])),
        band=30.0 if plain else float(rng.choice([15.0, 30.0, 45.0])),
    )


def setting(rng: np.random.Generator) -> tuple[Plant, Drive, str, bool, bool]:
    """Damper, drive and its kind; whether friction is heavy and whether the current moves."""
    family = int(rng.choice([TWIN, MONO, MAGNETO], p=[0.3, 0.4, 0.3]))
    plant = families.drawn(rng, family)
    heavy = bool(rng.random() < 0.35)
    if heavy:
        plant = plant._replace(rub=float(np.exp(rng.uniform(*np.log((40.0, 200.0))))))
    moves = family == MAGNETO and rng.random() < 0.5
    if family == MAGNETO:
        plant = plant._replace(current_form=int(rng.integers(1, 4)))
    kind = str(rng.choice(KINDS))
    seconds, speed = rng.uniform(15.0, 40.0), float(np.exp(rng.uniform(*np.log((0.15, 1.0)))))
    highest = float(rng.uniform(0.8, 2.0)) * moves
    shape = "sines" if kind == "steps" else kind
    drive = drives.drawn(rng, shape, seconds, speed, families.tightest(plant), rng.uniform(0.0, 8.0), highest)
    return plant, steps(drive) if kind == "steps" else drive, kind, heavy, moves


def steps(drive: Drive) -> Drive:
    """The speeds of sines limited to a quarter of their highest: nearly triangles, as steps of constant speed."""
    limit = 0.25 * np.abs(drive.v).max()
    smooth = signal.butter(2, 30.0, fs=RATE, output="sos")
    x = signal.detrend(np.cumsum(signal.sosfiltfilt(smooth, np.clip(drive.v, -limit, limit))) / RATE)
    return moved(replace(drive, kind="steps"), x - x[0])


def moved(drive: Drive, x: np.ndarray) -> Drive:
    """The drive with another displacement (n,) m."""
    v = np.gradient(x, 1.0 / RATE)
    return replace(drive, x=x, v=v, a=np.gradient(v, 1.0 / RATE))


def disturbed(rng, clean: np.ndarray, rate: float, noise: float, corner: float, step: float) -> np.ndarray:
    """(n,) a sensor's values: noise, white or through its filter (with the same rms before it), and quantised."""
    white = noise * rng.standard_normal(clean.size)
    if 0.0 < corner < 0.45 * rate:
        white = signal.sosfilt(signal.butter(2, corner, fs=rate, output="sos"), white)
    return step * np.round((clean + white) / step) if step > 0.0 else clean + white


def made(seed: int, number: int) -> Case:
    """Case ``number`` of a seed; draws again if a damper cannot be simulated."""
    for attempt in range(50):
        rng = np.random.default_rng([seed, 11, number, attempt])
        plant, drive, kind, heavy, moves = setting(rng)
        try:
            force = force_of(plant, drive)
            sensed = sensing(rng, float(force.std()))
            return _case(rng, plant, drive, force, sensed, (kind, heavy, moves))
        except Unstable:
            continue
    raise RuntimeError(f"no damper of case {number} can be simulated")


def _case(rng, plant: Plant, drive: Drive, force: np.ndarray, s: Sensing, kinds: tuple[str, bool, bool]) -> Case:
    kind, heavy, moves = kinds
    times = [_clock(rng, rate, drive.time[-1], s.jitter) for rate in (s.rate, s.gauge_rate)]
    x, gauge = np.interp(times[0], drive.time, drive.x), np.interp(times[1], drive.time, force)
    shown_x = disturbed(rng, x, s.rate, s.x_noise, s.x_corner, s.x_step)
    shown_gauge = disturbed(rng, gauge, s.gauge_rate, s.f_noise, s.f_corner, s.f_step)
    current = np.interp(times[0], drive.time, drive.current) if moves else None
    noisy = _measured(s, times, shown_x, shown_gauge, current)
    clean = _measured(s, times, x, gauge, current)
    time = 1e-9 * noisy.kinematics.stamp
    inside = np.clip(drive.time, time[0], time[-1])
    runs = [force_of(plant, moved(drive, CubicSpline(time, m.kinematics.block[X])(inside))) for m in (noisy, clean)]
    damper = FAMILIES[plant.family] + (", moving current" if moves else "")
    by_damper = np.interp(time, drive.time, runs[0] - runs[1])
    by_gauge = -noisy.as_gauge(noisy.gauge - clean.gauge)
    return Case(damper, kind, heavy, s, noisy, clean, by_gauge, by_damper, float(force.std()))


def _clock(rng: np.random.Generator, rate: int, seconds: float, jitter: float) -> np.ndarray:
    time = np.arange(0.5 / rate, seconds, 1.0 / rate)
    return time + np.clip(jitter * rng.standard_normal(time.size), -0.3 / rate, 0.3 / rate)


def _measured(s: Sensing, times, x: np.ndarray, gauge: np.ndarray, current: np.ndarray | None) -> Measurement:
    values = {"displacement": (times[0], x), "force": (times[1], gauge)}
    if current is not None:
        values["command"] = (times[0], current)
    data = {
        role: ChannelData(np.round(1e9 * time).astype(np.int64), np.arange(time.size), value)
        for role, (time, value) in values.items()
    }
    signal_map = SignalMap(s.cutoff, s.band, {"front": default_signals("front")})
    return measured("drawn", "front", data, signal_map)


def cases(seed: int, count: int) -> Iterator[Case]:
    """The first cases of a seed."""
    return (made(seed, number) for number in range(count))


def report(rows: Sequence[tuple[Case, float, float]], seed: int) -> str:
    """The table, as Markdown.

    Args:
        rows: case, and noise floor over the error of the perfect model, of all and in motion.
    """

    def near(ratios: np.ndarray) -> str:
        return share(int(np.count_nonzero((ratios >= 1.0 / WITHIN) & (ratios <= WITHIN))), ratios.size)

    def line(name: str, chosen: Sequence[tuple[Case, float, float]]) -> str:
        whole, moving = np.nan_to_num(np.array([ratios for _, *ratios in chosen]), nan=0.0).T
        low, middle, high = np.quantile(whole, [0.05, 0.5, 0.95])
        return f"| {name} | {near(moving)} | {near(whole)} | {middle:.2f} | {low:.2f} to {high:.2f} |"

    lines = [
        f"Seed {seed}: noise floor over the error of the perfect model; near is within 20 %, with 90 % intervals.", "",
        f"| cases | near, above {1e3 * MOVING:.0f} mm/s | near, all samples | median of these | 5 to 95 % |",
        "|---|---|---|---|---|", line("all", rows),
    ]  # fmt: skip
    for key in (
        lambda c: f"drive: {c.drive}",
        lambda c: f"damper: {c.damper}",
        lambda c: "friction: heavy" if c.heavy else "friction: ordinary",
        lambda c: f"sensors: {c.sensors}",
    ):
        names = sorted({key(case) for case, *_ in rows})
        lines += [line(name, [row for row in rows if key(row[0]) == name]) for name in names]
    return "\n".join(lines)


def main() -> None:
    """Runs the cases and prints the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cases", type=int, default=100, metavar="N")
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    rows = []
    for number, case in enumerate(cases(arguments.seed, arguments.cases)):
        truth, found = case.judged()
        true_moving, found_moving = case.judged(MOVING)
        rows.append((case, found / truth, found_moving / true_moving))
        friction = "heavy friction" if case.heavy else "ordinary friction"
        print(
            f"{number:3d} {case.damper}, {friction}, {case.drive}, {case.sensing.rate} Hz: "
            f"{found:.2f} of {truth:.2f} N ({found / truth:.2f}); in motion {found_moving:.2f} of {true_moving:.2f} N",
            flush=True,
        )
    print(report(rows, arguments.seed))


if __name__ == "__main__":
    main()
