"""Spencer's modified Bouc-Wen against an independent integration of the published equations."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from damper_estimator.model import load_model
from damper_estimator.signals.layout import COMMAND, DT, ROWS, A, T, V, X

# Spencer et al. 1997, in N, cm, s and V.
C0A, C0B, K0, C1A, C1B, K1, X0 = 21.0, 3.50, 46.9, 283.0, 2.95, 5.00, 14.3
ALPHA_A, ALPHA_B, GAMMA, BETA, SCALE, ORDER, ETA = 140.0, 695.0, 363.0, 363.0, 301.0, 2.0, 190.0
AMPLITUDE, FREQUENCY, SECONDS, FINE = 1.5, 2.5, 1.0, 1e-3
OMEGA = 2.0 * np.pi * FREQUENCY


def voltage(time):
    """Steps of the voltage, V."""
    return np.select([time < 0.3, time < 0.65], [0.0, 2.25], 1.0)


def motion(time):
    """Displacement and velocity, cm and cm/s."""
    return AMPLITUDE * np.sin(OMEGA * time), AMPLITUDE * OMEGA * np.cos(OMEGA * time)


def rates(time, state):
    """y', z', u' of the published equations."""
    y, z, u = state
    x, velocity = motion(time)
    c0, c1, alpha = C0A + C0B * u, C1A + C1B * u, ALPHA_A + ALPHA_B * u
    y_rate = (alpha * z + c0 * velocity + K0 * (x - y)) / (c0 + c1)
    slip = velocity - y_rate
    z_rate = -GAMMA * abs(slip) * z * abs(z) ** (ORDER - 1.0) - BETA * slip * abs(z) ** ORDER + SCALE * slip
    return [y_rate, z_rate, -ETA * (u - voltage(time))]


@pytest.fixture(scope="module")
def published():
    """Time (s) and force (N) of the published equations, by an implicit method with step control."""
    times, forces, state = [], [], [0.0, 0.0, 0.0]
    for first, last in ((0.0, 0.3), (0.3, 0.65), (0.65, SECONDS)):
        held = voltage(0.5 * (first + last))

        def slopes(time, state, held=held):
            y_rate, z_rate, _ = rates(time, state)
            return [y_rate, z_rate, -ETA * (state[2] - held)]

        run = solve_ivp(slopes, (first, last), state, "LSODA", rtol=1e-8, atol=1e-10, dense_output=True)
        at = np.linspace(first, last, round((last - first) / FINE), endpoint=False)
        y_rate = np.array([rates(t, state_at)[0] for t, state_at in zip(at, run.sol(at).T, strict=True)])
        times.append(at)
        forces.append((C1A + C1B * run.sol(at)[2]) * y_rate + K1 * (motion(at)[0] - X0))
        state = run.sol(last)
    return np.concatenate(times), np.concatenate(forces)


def modelled(step):
    """Time and force of the library's model, sampled every ``step`` s."""
    time = step * np.arange(round(SECONDS / step))
    x, velocity = motion(time)
    block = np.full((ROWS, time.size), np.nan)
    block[T], block[DT] = time, np.diff(time, prepend=0.0)
    block[X], block[V], block[A] = 0.01 * x, 0.01 * velocity, -(OMEGA**2) * 0.01 * x
    # The command during the step.
    block[COMMAND] = voltage(time - 0.5 * step)
    return time, load_model("spencer").force(block)


def test_converges_to_the_published_equations_with_the_step(published):
    time, force = published
    errors = []
    for step in (1e-3, 5e-4, 2.5e-4, 1.25e-4):
        computed_time, computed = modelled(step)
        errors.append(
            np.sqrt(np.mean((np.interp(time, computed_time, computed) - force)[time > 0.05] ** 2)) / force.std()
        )
    assert errors[0] < 0.03 and errors[-1] < 0.005
    slope = np.polyfit(np.log([8.0, 4.0, 2.0, 1.0]), np.log(errors), 1)[0]
    assert slope > 0.6
