"""Hides phenomena in recordings: a base record without them, a fit and an unseen record with them."""

from dataclasses import dataclass

from damper_estimator.plant.calibration import Calibration, calibrate, strength
from damper_estimator.plant.phenomena import PHENOMENA, Setup
from damper_estimator.plant.sensors import Sensed, measure
from damper_estimator.plant.simulation import Drive, Truth, simulate


@dataclass(frozen=True)
class Record:
    """One record of a setup: the truth and the measurement."""

    setup: Setup
    truth: Truth
    sensed: Sensed


@dataclass(frozen=True)
class Hidden:
    """A case; ``calibrations`` refer to the fit record, ``*_strength`` to all phenomena together."""

    calibrations: tuple[Calibration, ...]
    fit_strength: float
    unseen_strength: float
    base: Record
    fit: Record
    unseen: Record


def record(setup: Setup, drive: Drive, seed: int) -> Record:
    """Simulates and measures."""
    truth = simulate(setup.damper, drive)
    return Record(setup, truth, measure(truth, setup.sensors, seed))


def switched(setup: Setup, calibrations: tuple[Calibration, ...]) -> tuple[Setup, Setup]:
    """The setup without the phenomena, and with all of them at their magnitudes."""
    off = on = setup
    for item in calibrations:
        off = PHENOMENA[item.phenomenon].off(off, item.magnitude)
        on = PHENOMENA[item.phenomenon].on(on, item.magnitude)
    return off, on


def without(setup: Setup, names: tuple[str, ...]) -> Setup:
    """The setup with these phenomena off, at their ordinary magnitude if the off state depends on it."""
    for name in names:
        setup = PHENOMENA[name].off(setup, 1.0)
    return setup


def hidden(
    names: tuple[str, ...],
    setup: Setup,
    drives: tuple[Drive, Drive, Drive],
    wanted: float,
    seed: int,
    sign: float = 1.0,
) -> Hidden:
    """A case from the drives of its base, fit and unseen record; each phenomenon has the strength ``wanted`` on the
    fit.

    Phenomena are calibrated one by one with the others off. Without names nothing is hidden: fit and unseen are further
    records of the base.
    """
    calibrations = tuple(
        calibrate(name, without(setup, tuple(other for other in names if other != name)), drives[1], wanted, sign)
        for name in names
    )
    off, on = switched(setup, calibrations)
    base, fit, unseen = drives
    return Hidden(
        calibrations,
        strength(off, on, fit),
        strength(off, on, unseen),
        record(off, base, seed),
        record(on, fit, seed + 1),
        record(on, unseen, seed + 2),
    )
