"""Motions of a test: sines, sweeps, triangles, multisines, roads, holds and crank runs, smooth at both ends.

Every motion begins and ends at rest at the limits' home, so that motions can follow each other in any order. Ramps last
long enough for the limits; what is driven between them is scaled down until displacement, speed and acceleration are
inside, which is exact because all three are linear in it.
"""

from collections.abc import Callable, Mapping

import numpy as np

from damper_estimator.planning.limits import Limits

_MARGIN = 0.97  # of a limit
_RAMP_SPEED, _RAMP_ACCELERATION = 1.875, 5.7736  # largest derivatives of the quintic ramp of unit height and length
_SHORTEST = 0.3  # s, of a ramp
_PAUSE = 0.25  # s of rest at either end
_CLIPPINGS, _CLIPPED = 100, 0.85  # passes that lower a multisine's peaks, and the height that each leaves of them


def motion(kind: str, values: Mapping[str, float], limits: Limits) -> np.ndarray:
    """(n,) m at ``limits.rate``, from home to home.

    Args:
        kind: of ``KINDS``.
        values: of the kind: ``frequency``, ``amplitude``, ``offset`` (m from home), ``seconds``, ...

    Raises:
        KeyError: for another kind.
    """
    shape = KINDS[kind](values, limits)
    offset = _reachable(values.get("offset", 0.0), limits)
    up = _ramp(offset, limits)
    still = np.zeros(max(1, round(_PAUSE * limits.rate)))
    scaled = shape * _scale(shape, offset, limits)
    return limits.home + np.concatenate([still, up, offset + scaled, up[::-1], still])


def speed_of(displacement: np.ndarray, rate: float) -> np.ndarray:
    """(n - 1,) m/s, between samples."""
    return np.diff(displacement) * rate


def acceleration_of(displacement: np.ndarray, rate: float) -> np.ndarray:
    """(n - 2,) m/s^2."""
    return np.diff(displacement, 2) * rate**2


def smooth_step(share: np.ndarray) -> np.ndarray:
    """From 0 to 1 over ``share`` 0 to 1 with two continuous derivatives."""
    share = np.clip(share, 0.0, 1.0)
    return share**3 * (10.0 - 15.0 * share + 6.0 * share**2)


def _reachable(offset: float, limits: Limits) -> float:
    return float(np.clip(offset, _MARGIN * (limits.low - limits.home), _MARGIN * (limits.high - limits.home)))


def _ramp(height: float, limits: Limits) -> np.ndarray:
    """(n,) from 0 to ``height`` within the limits; empty where there is nothing to climb."""
    if height == 0.0:
        return np.zeros(0)
    seconds = max(
        _SHORTEST,
        _RAMP_SPEED * abs(height) / (_MARGIN * limits.speed),
        np.sqrt(_RAMP_ACCELERATION * abs(height) / (_MARGIN * limits.acceleration)),
    )
    count = int(np.ceil(seconds * limits.rate)) + 1
    return height * smooth_step(np.linspace(0.0, 1.0, count))


def _scale(shape: np.ndarray, offset: float, limits: Limits) -> float:
    """Largest factor up to 1 with which a shape about ``home + offset`` obeys the limits."""
    return 1.0 / max(1.0, _exceeded(shape, offset, limits))


def _exceeded(shape: np.ndarray, offset: float, limits: Limits) -> float:
    """The largest share of a limit that a shape about ``home + offset`` reaches; at most 1 obeys them all."""
    padded = np.pad(shape, 2)
    above, below = limits.high - limits.home - offset, limits.home + offset - limits.low
    pairs = (
        (padded.max(), above),
        (-padded.min(), below),
        (np.abs(speed_of(padded, limits.rate)).max(), _MARGIN * limits.speed),
        (np.abs(acceleration_of(padded, limits.rate)).max(), _MARGIN * limits.acceleration),
    )
    return float(
        max((reached / limit if limit > 0.0 else np.inf for reached, limit in pairs if reached > 0.0), default=0.0)
    )


def _time(seconds: float, limits: Limits) -> np.ndarray:
    return np.arange(max(8, round(seconds * limits.rate))) / limits.rate


def _envelope(time: np.ndarray, edge: float) -> np.ndarray:
    length = time[-1]
    edge = min(edge, 0.45 * length)
    return smooth_step(np.minimum(time, length - time) / edge)


def _sine(values: Mapping[str, float], limits: Limits) -> np.ndarray:
    time = _time(values["seconds"], limits)
    edge = max(1.0 / values["frequency"], _SHORTEST)
    return values["amplitude"] * np.sin(2.0 * np.pi * values["frequency"] * time) * _envelope(time, edge)


def _sweep(values: Mapping[str, float], limits: Limits) -> np.ndarray:
    """Logarithmic sweep with a constant amplitude of speed, as far as the amplitude goes."""
    time = _time(values["seconds"], limits)
    low, high = values["frequency"], values["to"]
    frequency = low * (high / low) ** (time / time[-1])
    phase = 2.0 * np.pi * np.cumsum(frequency) / limits.rate
    amplitude = np.minimum(values["amplitude"], values["speed"] / (2.0 * np.pi * frequency))
    return amplitude * np.sin(phase) * _envelope(time, max(1.0 / low, _SHORTEST))


def _triangle(values: Mapping[str, float], limits: Limits) -> np.ndarray:
    """Constant speed up and down about the mean position; corners rounded over a twelfth of the period."""
    period = 4.0 * values["amplitude"] / values["speed"]
    cycles = max(1, round(values["seconds"] / period))
    time = _time(cycles * period, limits)
    phase = time / period
    triangle = values["amplitude"] * (4.0 * np.abs(np.mod(phase - 0.25, 1.0) - 0.5) - 1.0)
    window = np.hanning(2 * max(2, round(period * limits.rate / 24.0)) + 1)
    padded = np.pad(triangle, window.size // 2)
    rounded = np.convolve(padded, window / window.sum(), mode="valid")
    return rounded * _envelope(time, max(period / 8.0, 4.0 / limits.rate))


def _multisine(values: Mapping[str, float], limits: Limits) -> np.ndarray:
    """Sines between two frequencies with a flat spectrum of velocity and low peaks, a ``share`` of what limits allow.

    Limits bound the peaks, so phases are sought that lower the peak that is closest to its limit: it is clipped, and
    what is left gives the phases of the old amplitudes (van der Ouderaa, Schoukens and Renneboog 1988, IEEE Trans.
    Instrum. Meas. 37).
    """
    time = _time(values["seconds"], limits)
    frequency = np.fft.rfftfreq(time.size, 1.0 / limits.rate)
    spectrum = _flat_velocity(values, frequency)
    amplitude = np.abs(spectrum)
    derivative = 2j * np.pi * frequency
    inside = amplitude > 0.0
    allowed = min(limits.high - limits.home, limits.home - limits.low), limits.speed, limits.acceleration
    for _ in range(_CLIPPINGS):
        quantities = [np.fft.irfft(spectrum * derivative**order, time.size) for order in range(3)]
        reached = [np.abs(one).max() / limit for one, limit in zip(quantities, allowed, strict=True)]
        order = int(np.argmax(reached))
        peak = _CLIPPED * np.abs(quantities[order]).max()
        clipped = np.fft.rfft(np.clip(quantities[order], -peak, peak))[inside] / derivative[inside] ** order
        spectrum[inside] = amplitude[inside] * np.exp(1j * np.angle(clipped))
    shape = np.fft.irfft(spectrum, time.size)
    shape *= _envelope(time, max(1.0, _SHORTEST))
    return shape * values["share"] / _exceeded(shape, 0.0, limits)


def _road(values: Mapping[str, float], limits: Limits) -> np.ndarray:
    """What a vehicle's suspension does: a flat spectrum of velocity with random phases; ``speed`` is its rms."""
    time = _time(values["seconds"], limits)
    shape = np.fft.irfft(_flat_velocity(values, np.fft.rfftfreq(time.size, 1.0 / limits.rate)), time.size)
    rms = float(np.sqrt(np.mean(speed_of(shape, limits.rate) ** 2)))
    return shape * (values["speed"] / rms) * _envelope(time, max(1.0, _SHORTEST))


def _flat_velocity(values: Mapping[str, float], frequency: np.ndarray) -> np.ndarray:
    """(m,) complex amplitudes of displacement at frequencies (m,), with random phases."""
    inside = (frequency >= values["frequency"]) & (frequency <= values["to"]) & (frequency > 0.0)
    if not inside.any():
        inside[np.argmin(np.abs(frequency[1:] - values["frequency"])) + 1] = True
    phase = np.random.default_rng(int(values.get("seed", 0))).uniform(0.0, 2.0 * np.pi, inside.sum())
    spectrum = np.zeros(frequency.size, complex)
    spectrum[inside] = np.exp(1j * phase) / frequency[inside]
    return spectrum


def _hold(values: Mapping[str, float], limits: Limits) -> np.ndarray:
    return np.zeros_like(_time(values["seconds"], limits))


def _crank(values: Mapping[str, float], limits: Limits) -> np.ndarray:
    """A crank that starts from mid-stroke, turns at one frequency and stops there, all by its speed of rotation."""
    time = _time(values["seconds"], limits)
    rotation = values["frequency"] * _envelope(time, max(1.0, 1.5 / values["frequency"]))
    turns = np.concatenate([[0.0], np.cumsum(0.5 * (rotation[1:] + rotation[:-1]))]) / limits.rate
    whole = max(1.0, np.floor(turns[-1]))
    if turns[-1] < 1.0:  # one slow turn
        return limits.amplitude * np.sin(2.0 * np.pi * smooth_step(time / time[-1]))
    return limits.amplitude * np.sin(2.0 * np.pi * turns * whole / turns[-1])


KINDS: dict[str, Callable[[Mapping[str, float], Limits], np.ndarray]] = {
    "sine": _sine,
    "sweep": _sweep,
    "triangle": _triangle,
    "multisine": _multisine,
    "road": _road,
    "hold": _hold,
    "crank": _crank,
}
