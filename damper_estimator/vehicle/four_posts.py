"""A car on four posts: its motion with any damper models, and the transfer functions from post to body.

Springs, tyres and bars are linear; with post heights linear between samples, their part of a step is exact (matrix
exponential). The dampers' forces are extrapolated over the step from this sample and the previous one (second order).
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.linalg import expm

from damper_estimator.compiled import compiled
from damper_estimator.model import DamperModel, chain
from damper_estimator.signals.layout import DT, ROWS, A, T, V, X
from damper_estimator.vehicle.full_car import WHEELS, FullCar

STEP = 2.5e-4
"""s, of the simulation."""

FORCE, TRAVEL, VELOCITY = range(3)


@dataclass(frozen=True)
class PostRun:
    """A run; every ``step`` s, wheels in order of ``WHEELS``.

    Attributes:
        post: (4, n) m, heights of the posts.
        body: (4, n) m, of the body above each wheel.
        wheel: (4, n) m.
        damper: (3, 4, n): force (N, less that at rest), travel (m) and velocity (m/s) of each damper.
    """

    step: float
    post: np.ndarray
    body: np.ndarray
    wheel: np.ndarray
    damper: np.ndarray

    @property
    def time(self) -> np.ndarray:
        """Seconds from the start."""
        return self.step * np.arange(self.post.shape[1])

    def over_axle(self, front: bool) -> np.ndarray:
        """(n,) m: the body's height in the middle of an axle."""
        return self.body[:2].mean(axis=0) if front else self.body[2:].mean(axis=0)


def on_posts(car: FullCar, models: Mapping[str, DamperModel], post: np.ndarray, step: float = STEP) -> PostRun:
    """The car's motion from rest.

    Args:
        models: by axle, ``front`` and ``rear``, at their reference temperature and without a command.
        post: (4, n) m, heights of the posts every ``step`` s; the first is rest.

    Raises:
        FloatingPointError: if a model has no finite force, or is too stiff for the step.
    """
    machines = [_machine(models[name]) for name in ("front", "rear")]
    states = [np.zeros((2, model.program.states)) for model in (models["front"], models["rear"])]
    motion = np.zeros((14, post.shape[1]))
    damper = np.zeros((3, 4, post.shape[1]))
    extension = car.over("damper_ratio")[:, None] * car.extensions
    with np.errstate(over="ignore", invalid="ignore"):
        _drive(*machines[0], *machines[1], *states, *_step_matrices(car, step), extension, post, step, motion, damper)
    if not np.isfinite(motion[:, -1]).all():
        raise FloatingPointError(f"no finite motion at a step of {step:g} s; use a smaller step or another model")
    return PostRun(step, post, car.body_heights @ motion[:7], motion[3:7], damper)


def _machine(model: DamperModel) -> tuple:
    """Arguments of ``chain.run`` besides states, for one sample."""
    program = model.program
    return (
        program.functions, program.table, program.parameters, program.settings,
        np.empty((program.motions, ROWS, 1)), np.empty((program.forces, 1)),
        np.zeros((program.table.shape[0] if program.series else 0, chain.SOLVER_COLUMNS)),
    )  # fmt: skip


def _step_matrices(car: FullCar, step: float) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """s' = D s + B F + P p + R p_next for the state s (positions, speeds), damper forces F and posts p."""
    inverse = 1.0 / car.masses[:, None]
    wheels = np.concatenate([np.zeros((3, 4)), np.eye(4)])
    damping = wheels @ np.diag(car.over("tyre_damping")) @ wheels.T
    system = np.block([[np.zeros((7, 7)), np.eye(7)], [-inverse * car.stiffness, -inverse * damping]])
    still = np.zeros((7, 4))
    push = np.concatenate([still, -inverse * (car.over("damper_ratio")[:, None] * car.extensions).T])
    height = np.concatenate([still, inverse * wheels * car.over("tyre_rate")])
    rate = np.concatenate([still, inverse * wheels * car.over("tyre_damping")])
    # One exponential contains the transition and the integrals over a constant input and over a ramp.
    big = np.zeros((42, 42))
    big[:14, :14], big[:14, 14:28], big[14:28, 28:] = system * step, np.eye(14) * step, np.eye(14)
    exponential = expm(big)
    constant, ramp = exponential[:14, 14:28], exponential[:14, 28:]
    now = constant @ height - ramp @ height - constant @ rate / step
    after = ramp @ height + constant @ rate / step
    return tuple(np.ascontiguousarray(m) for m in (exponential[:14, :14], constant @ push, now, after))


@compiled
def _drive(
    kernels_f, table_f, parameters_f, settings_f, motions_f, forces_f, solvers_f,
    kernels_r, table_r, parameters_r, settings_r, motions_r, forces_r, solvers_r,
    states_f, states_r, transition, push, now, after, extension, post, step, motion, damper,
):  # fmt: skip
    """The loop over a run; writes ``motion`` (14, n) and ``damper`` (3, 4, n)."""
    column, trace = np.full((ROWS, 1), np.nan), np.zeros((0, 0))
    force, before, rest, speed = np.zeros(4), np.zeros(4), np.zeros(4), np.zeros(4)
    for i in range(post.shape[1]):
        column[T, 0], column[DT, 0] = i * step, step if i > 0 else 0.0
        for w in range(4):
            x, v = 0.0, 0.0
            for k in range(7):
                x += extension[w, k] * motion[k, i]
                v += extension[w, k] * motion[7 + k, i]
            column[X, 0], column[V, 0], column[A, 0] = x, v, (v - speed[w]) / step
            speed[w] = v
            if w < 2:
                chain.run(
                    kernels_f, table_f, parameters_f, settings_f, column, motions_f, forces_f, states_f[w], solvers_f,
                    trace,
                )  # fmt: skip
                force[w] = forces_f[0, 0]
            else:
                chain.run(
                    kernels_r, table_r, parameters_r, settings_r, column, motions_r, forces_r, states_r[w - 2],
                    solvers_r, trace,
                )  # fmt: skip
                force[w] = forces_r[0, 0]
            if i == 0:
                rest[w] = force[w]
            force[w] -= rest[w]
            damper[FORCE, w, i], damper[TRAVEL, w, i], damper[VELOCITY, w, i] = force[w], x, v
        if i + 1 == post.shape[1]:
            break
        for row in range(14):
            total = 0.0
            for k in range(14):
                total += transition[row, k] * motion[k, i]
            for w in range(4):
                carried = 1.5 * force[w] - 0.5 * before[w]
                total += push[row, w] * carried + now[row, w] * post[w, i] + after[row, w] * post[w, i + 1]
            motion[row, i + 1] = total
        before[:] = force


def sweep(
    amplitude: float, low: float = 0.5, high: float = 6.0, seconds: float = 60.0, still: float = 5.0, step: float = STEP
) -> np.ndarray:
    """A sine of ``amplitude`` m whose frequency rises evenly from ``low`` to ``high`` Hz, (n,) m.

    It fades in and out within a second; ``still`` s of rest follow.
    """
    count = round(seconds / step)
    time = step * np.arange(count)
    edge = np.clip(np.minimum(time, seconds - time), 0.0, 1.0)
    phase = 2.0 * np.pi * (low * time + 0.5 * (high - low) / seconds * time**2)
    moving = amplitude * np.sin(phase) * edge**2 * (3.0 - 2.0 * edge)
    return np.concatenate([moving, np.zeros(round(still / step))])


def four_posts(height: np.ndarray) -> np.ndarray:
    """(4, n): all posts together at one height (n,)."""
    return np.tile(height, (len(WHEELS), 1))


@dataclass(frozen=True)
class Transfer:
    """A transfer function.

    Attributes:
        frequency: (m,) Hz.
        value: (m,) complex.
    """

    frequency: np.ndarray
    value: np.ndarray


def transfer(
    post: np.ndarray, body: np.ndarray, step: float, low: float = 0.5, high: float = 6.0, width: float = 0.1
) -> Transfer:
    """Body over post from one run that begins and ends at rest, (n,) m each; averaged over bands of ``width`` Hz.

    A band's frequency is the power-weighted mean of its lines. For a non-linear car this is the best linear
    approximation in each band (H1).

    Args:
        low, high: Hz, range of the values.
    """
    frequency = np.fft.rfftfreq(post.size, step)
    given, found = np.fft.rfft(post), np.fft.rfft(body)
    count = max(1, round((high - low) / width))
    band = np.floor((frequency - low) / (high - low) * count).astype(int)
    inside = (band >= 0) & (band < count)

    def summed(values: np.ndarray) -> np.ndarray:
        return np.bincount(band[inside], values[inside], count)

    cross, strength = found * np.conj(given), np.abs(given) ** 2
    power = summed(strength)
    value = (summed(cross.real) + 1j * summed(cross.imag)) / power
    return Transfer(summed(strength * frequency) / power, value)
