"""Force error due to latency, and its reduction by prediction or an accelerometer, on a simulated damper.

The force of an estimator that knows the damper (a map of the simulated force over velocity and displacement) is
compared with the true force *at the same instant*, on a road that was not used for the map: rms error as a share of the
rms force, and the delay at which the estimate fits best. Three ways from displacement to velocity: the node's filter,
the same with part of its delay predicted (`compensation`), and `fusion` in the signal map with the relative
acceleration (0.3 m/s^2 noise, 0.2 m/s^2 offset).
"""

import numpy as np

from damper_estimator.plant import DAMPERS, Sensors, bench_drive, measure, simulate
from damper_estimator.runtime.line import predict
from damper_estimator.signals import Differentiator, delay_seconds
from damper_estimator.signals.fusion import Fusion
from damper_estimator.signals.layout import V, X
from damper_estimator.vehicle import drive

DAMPER, RATE, SECONDS, MARGIN = "passenger_front", 1000.0, 30.0, 2.0
ACCELERATION_NOISE, ACCELERATION_OFFSET = 0.3, 0.2  # m/s^2


def force_map(seed: int):
    """Force (N) over velocity and displacement: least squares on smooth bases, on the true motion."""
    truth = simulate(DAMPERS[DAMPER], bench_drive("random", DAMPERS[DAMPER], SECONDS, seed))
    v = np.gradient(truth.drive.displacement, truth.time)
    knots = np.quantile(v, np.linspace(0.001, 0.999, 40))

    def bases(x: np.ndarray, velocity: np.ndarray) -> np.ndarray:
        hats = [np.interp(velocity, knots, row) for row in np.eye(knots.size)]
        return np.stack([*hats, x, x**2, np.tanh(velocity / 0.01)], axis=1)

    weights = np.linalg.lstsq(bases(truth.drive.displacement, v)[::7], truth.force[::7], rcond=None)[0]
    return lambda x, velocity: bases(x, velocity) @ weights


def judged(stamp: np.ndarray, estimate: np.ndarray, truth) -> tuple[float, float]:
    """Error at the same instant (share of the rms force), and the delay in ms at which it would be smallest."""
    time = stamp / 1e9
    kept = (time > MARGIN) & (time < SECONDS - MARGIN)

    def error(delay: float) -> float:
        there = np.interp(time[kept] - delay, truth.time, truth.force)
        return float(np.sqrt(np.mean((estimate[kept] - there) ** 2)) / np.sqrt(np.mean(there**2)))

    delays = np.arange(-0.003, 0.02, 0.0002)
    return error(0.0), 1e3 * float(delays[np.argmin([error(delay) for delay in delays])])


def main() -> None:
    """Prints a table per displacement noise."""
    force = force_map(1)
    truth = simulate(DAMPERS[DAMPER], drive("road", DAMPERS[DAMPER], SECONDS, 2))
    velocity = np.gradient(truth.drive.displacement, truth.time)
    true_acceleration = np.gradient(velocity, truth.time)
    print(f"{DAMPER}, road, {RATE:g} Hz; the error of the map with the true motion is ", end="")
    print(f"{100 * judged(truth.time * 1e9, force(truth.drive.displacement, velocity), truth)[0]:.1f} %")
    for noise in (1.2e-5, 1e-4):
        sensed = measure(truth, Sensors(rate=RATE, displacement_noise=noise), 3).displacement
        rows = {}
        for cutoff in (30.0, 60.0, 120.0):
            for share in (0.0, 0.5, 1.0):
                block = Differentiator(cutoff, 0.1).block(sensed.stamp, sensed.value)[0].block
                predict(share * delay_seconds(cutoff), block)
                rows[f"filter {cutoff:3.0f} Hz, compensation {share:.1f}"] = force(block[X], block[V])
        random = np.random.default_rng(4)
        felt = np.interp(sensed.stamp / 1e9, truth.time, true_acceleration) + ACCELERATION_OFFSET
        felt += ACCELERATION_NOISE * random.standard_normal(felt.size)
        fusion = Fusion(noise, ACCELERATION_NOISE)
        block = Differentiator(60.0, 0.1, fusion).block(sensed.stamp, sensed.value, acceleration=felt)[0].block
        rows["fusion with an accelerometer"] = force(block[X], block[V])
        print(f"displacement noise {1e3 * noise:g} mm rms:")
        for name, estimate in rows.items():
            error, delay = judged(sensed.stamp, estimate, truth)
            print(f"  {name:36s} error {100 * error:5.1f} %   fits best {delay:4.1f} ms late")


if __name__ == "__main__":
    main()
