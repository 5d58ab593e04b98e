"""The measurement chain: a logger's recording, and its faults as phenomena."""

from dataclasses import dataclass, replace

import numpy as np

from population.drives import RATE, Drive
from population.simulate import in_band

RATES = {200: 0.15, 250: 0.1, 500: 0.35, 1000: 0.25, 2000: 0.1, 3000: 0.05}


@dataclass(frozen=True)
class Chain:
    """Sensors and their faults; a fault's ``form`` chooses its mechanism, its size has the stated unit.

    Attributes:
        spring, preload: N/m and N, a coil spring in the gauge's force as the signal map states it; 0 for none.
        zero, wander: N, zero of a good gauge at the start, and its drift; drawn for each recording.
        skew: s, force late (form 0, or 2: a slow amplifier), or early because the displacement is late (form 1).
        rate_error: N/m (form 0), or that of a spring that hardens (1) or has a soft helper (2).
        offset: N (form 0), or reached by creeping in the first third (1), or with a drift of half as much (2).
        gain: relative (form 0), or falling with force (1), or creeping up to it over the recording (2).
        wide: m, displacement at which the bent spring of ``rate_error`` has that rate; the drive's largest if 0.
    """

    rate: int
    x_noise: float
    x_step: float
    f_noise: float
    f_step: float
    jitter: float
    wander: float
    spring: float = 0.0
    preload: float = 0.0
    thermometer: bool = False
    decoy_warming: bool = False
    ammeter: bool = False
    form: int = 0
    skew: float = 0.0
    rate_error: float = 0.0
    offset: float = 0.0
    gain: float = 0.0
    wide: float = 0.0


def drawn(rng: np.random.Generator, force_rms: float, coil_over: bool) -> Chain:
    """A chain of ordinary quality for forces of that size."""
    rate = int(rng.choice(list(RATES), p=list(RATES.values())))
    spring = float(rng.uniform(1.5e4, 4e4)) if coil_over else 0.0
    return Chain(
        rate=rate,
        x_noise=float(np.exp(rng.uniform(np.log(2e-6), np.log(2.5e-5)))),
        x_step=float(rng.choice([2e-6, 1e-5, 2.5e-5])),
        f_noise=force_rms * float(np.exp(rng.uniform(np.log(1e-3), np.log(1.2e-2)))),
        f_step=float(rng.choice([0.2, 1.0, 3.0])),
        jitter=float(rng.choice([0.0, 1e-5, 4e-5])),
        wander=force_rms * float(rng.uniform(0.0, 0.006)),
        spring=spring,
        preload=-float(rng.uniform(500.0, 3000.0)) if coil_over else 0.0,
    )


FAULTS = {
    "channel_skew": ("skew", ("force late", "displacement late", "slow amplifier"), 1e-3, 8e-3),
    "spring_rate_error": ("rate_error", ("linear", "hardening", "helper spring"), 100.0, 2e5),
    "force_offset": ("offset", ("constant", "creeping", "drifting"), 1.0, 5000.0),
    "force_gain_error": ("gain", ("constant", "falling with force", "creeping"), 0.005, 0.6),
}
"""Field, forms, and the range of sizes for the search of a strength."""


def faulty(chain: Chain, phenomenon: str, form: int, size: float) -> Chain:
    """The chain with one fault."""
    return replace(chain, **{FAULTS[phenomenon][0]: size, "form": form})


def late_by(chain: Chain) -> float:
    """s, delay of the force relative to the displacement."""
    return -chain.skew if chain.form == 1 else chain.skew


def gauge(chain: Chain, drive: Drive, force: np.ndarray) -> np.ndarray:
    """(n,) N: the gauge without noise, less its spring with the stated rate."""
    shown, time = force.copy(), drive.time
    if chain.rate_error:
        wide = chain.wide or np.abs(drive.x).max() + 1e-9
        away = drive.x / wide
        bent = {0: away, 1: away + 0.4 * away**3, 2: away + 0.35 * np.tanh(6.0 * (away - 0.1))}[chain.form]
        shown += chain.rate_error * wide * bent
    if chain.gain:
        size = np.abs(force).max()
        share = {0: 1.0, 1: 1.2 - 0.4 * np.abs(force) / size, 2: 2.0 * time / time[-1]}[chain.form]
        shown += chain.gain * share * (force + chain.spring * drive.x + chain.preload * (chain.spring > 0.0))
    if chain.offset:
        share = {0: 1.0, 1: 1.0 - np.exp(-6.0 * time / time[-1]), 2: 0.75 + 0.5 * time / time[-1]}[chain.form]
        shown += chain.offset * share
    if chain.skew:
        carried = chain.spring * drive.x
        shown = _shifted(shown + carried, chain) - carried
    return shown


def _shifted(values: np.ndarray, chain: Chain) -> np.ndarray:
    frequency = np.fft.rfftfreq(values.size, 1.0 / RATE)
    late = late_by(chain)
    if chain.form == 2:  # a filter of second order, whose group delay at low frequency is the skew
        omega = 2.0j * np.pi * frequency
        ratio = 1.0 / (1.0 + omega * late + (omega * late) ** 2 / 3.0)
    else:
        ratio = np.exp(-2.0j * np.pi * frequency * late)
    return np.fft.irfft(np.fft.rfft(values) * ratio, values.size)


@dataclass(frozen=True)
class Samples:
    """The content of one recording: s, m, N, and deg C and A if recorded; (n,) each.

    ``truth`` is the damper's in-band force in N at the same times, ``name`` of the recording.
    """

    name: str
    time: np.ndarray
    x: np.ndarray
    force: np.ndarray
    temperature: np.ndarray | None
    current: np.ndarray | None
    truth: np.ndarray


def sampled(name: str, chain: Chain, drive: Drive, force: np.ndarray, rng: np.random.Generator) -> Samples:
    """A recording of a simulated drive."""
    instants = np.arange(0.0, drive.time[-1], 1.0 / chain.rate)
    if chain.jitter:
        instants = np.sort(np.clip(instants + chain.jitter * rng.standard_normal(instants.size), 0.0, drive.time[-1]))
        instants = instants[np.concatenate([[True], np.diff(instants) > 1e-5])]
    at = instants + 0.0
    shown = np.interp(at, drive.time, gauge(chain, drive, force))
    x = np.interp(at, drive.time, drive.x)
    seconds = instants / instants[-1]
    zero = chain.wander * (rng.standard_normal() + rng.standard_normal() * seconds + 0.3 * np.sin(6.0 * seconds))
    raw = shown + zero + chain.spring * x + chain.preload * (chain.spring > 0.0)
    raw += chain.f_noise * rng.standard_normal(at.size)
    raw = np.round(raw / chain.f_step) * chain.f_step
    measured = x + chain.x_noise * rng.standard_normal(at.size)
    measured = np.round(measured / chain.x_step) * chain.x_step
    temperature = None
    if chain.thermometer:
        warm = np.interp(at, drive.time, drive.temperature)
        if chain.decoy_warming:
            warm = 22.0 + rng.uniform(6.0, 15.0) * (1.0 - np.exp(-at / rng.uniform(10.0, 60.0)))
        temperature = np.round(warm + 0.05 * rng.standard_normal(at.size), 1)
    current = np.interp(at, drive.time, drive.current) if chain.ammeter else None
    truth = np.interp(at, drive.time, in_band(force))
    return Samples(name, instants, measured, raw, temperature, current, truth)
