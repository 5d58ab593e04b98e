"""One damper of one recording, prepared for comparison with a model: kinematics and measured force, filtered alike."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from damper_estimator.errors import InputError
from damper_estimator.signals.admission import DEFAULT_MAX_GAP, DUPLICATE, Admission, Counts
from damper_estimator.signals.at_stamps import at_stamps, in_order, last_value
from damper_estimator.signals.butterworth import low_pass, low_pass_zero_phase
from damper_estimator.signals.channels import ChannelData, read_channels, signals_for, too_few
from damper_estimator.signals.clipping import clipped, touched
from damper_estimator.signals.kinematics import Differentiator, Kinematics
from damper_estimator.signals.layout import T
from damper_estimator.signals.signal_map import DamperSignals, SignalMap
from damper_estimator.signals.spikes import displacement_course, force_course

if TYPE_CHECKING:  # the node runs without the readers' libraries
    from damper_estimator.recordings import Bag


@dataclass(frozen=True)
class Measurement:
    """The measurement of one damper.

    Attributes:
        recording: path of the bag.
        damper: its name.
        kinematics: filtered, (n,) samples.
        force: (n,) N, the damper's force through the same causal filter; None if none was recorded.
        judged: (n,) bool, samples that count: warm, and with a measured force nearby that no clipped sample affects.
        counts: of samples that a node would have dropped, in order of arrival.
        gauge: (m,) N, the finite values of the force channel by rising stamp, before spring and filter; empty without.
            Of the whole recording, also in a part of it.
        raw_displacement: (n,) m, before the filter.
        cutoff, band: Hz.
        signals: the damper's entry of the signal map.
        acceleration: (n,) m/s^2, of an accelerometer, through the same causal filter; NaN in its gaps; None without
            one. Models do not use it, but the displacement's derivative.
        gauge_stamp: (m,) int64 ns, corrected for skew; None if the gauge has the stamps of the whole kinematics.
        spikes: by role, displacement and force, s since the first displacement, of samples that are left out as spikes;
            of the whole recording, also in a part of it.
    """

    recording: str
    damper: str
    kinematics: Kinematics
    force: np.ndarray | None
    judged: np.ndarray
    counts: Counts
    gauge: np.ndarray
    raw_displacement: np.ndarray
    cutoff: float
    band: float
    signals: DamperSignals
    acceleration: np.ndarray | None = None
    gauge_stamp: np.ndarray | None = None
    spikes: Mapping[str, tuple[float, ...]] = field(default_factory=dict)

    def in_band(self, force: np.ndarray) -> np.ndarray:
        """A force (n,) through the comparison's zero-phase low-pass."""
        return low_pass_zero_phase(self.band, self.kinematics.dt, force)

    def as_gauge(self, values: np.ndarray) -> np.ndarray:
        """(n,) values (m,) at the gauge's stamps through the filter, as ``force`` results from ``gauge``."""
        if self.gauge_stamp is None:
            return low_pass(self.cutoff, self.kinematics.dt, values)
        return at_stamps(self.gauge_stamp, values, self.kinematics, self.cutoff)

    def part(self, first: int, last: int) -> Measurement:
        """Samples ``first`` to ``last``; the forces stay filtered, the warm-up starts again."""
        return self.parts([slice(first, last)])

    def parts(self, windows: Sequence[slice]) -> Measurement:
        """Several parts in order of time as one recording with gaps; the warm-up starts again in each."""
        kinematics = Kinematics.joined([self.kinematics.select(window) for window in windows])

        def cut(values: np.ndarray) -> np.ndarray:
            whole = [values[window] for window in windows]
            return whole[0] if len(whole) == 1 else np.concatenate(whole)

        return replace(
            self,
            kinematics=kinematics,
            force=None if self.force is None else cut(self.force),
            judged=cut(self.judged) & kinematics.warm(),
            gauge_stamp=self.kinematics.stamp if self.gauge_stamp is None else self.gauge_stamp,
            raw_displacement=cut(self.raw_displacement),
            acceleration=None if self.acceleration is None else cut(self.acceleration),
        )

    def thinned(self, stride: int) -> Measurement:
        """Only every ``stride``-th sample of each stretch; filtered and differentiated at the full rate."""
        places = self.kinematics.thinned(stride)
        return replace(
            self,
            kinematics=self.kinematics.at(places),
            force=None if self.force is None else self.force[places],
            judged=self.judged[places],
            gauge_stamp=self.kinematics.stamp if self.gauge_stamp is None else self.gauge_stamp,
            raw_displacement=self.raw_displacement[places],
            acceleration=None if self.acceleration is None else self.acceleration[places],
        )


def measure(
    bag: Bag,
    signal_map: SignalMap,
    damper: str,
    start: float = 0.0,
    end: float = float("inf"),
    max_gap: float = DEFAULT_MAX_GAP,
    force_wanted: bool = True,
) -> Measurement:
    """Reads one damper from a bag, in order of stamp.

    Args:
        start, end: s since the first displacement, in addition to the map's windows.
        force_wanted: whether a missing force is an error.

    Raises:
        InputError: one line; for missing topics, fields or dampers, or without samples in the window.
    """
    chosen = signals_for(bag, signal_map, damper)
    data = read_channels(bag, chosen.dampers[damper].channels())
    found = measured(str(bag.path), damper, data, chosen, start, end, max_gap)
    if force_wanted:
        check_force(found)
    return found


def measured(
    recording: str,
    damper: str,
    data: Mapping[str, ChannelData],
    signal_map: SignalMap,
    start: float = 0.0,
    end: float = float("inf"),
    max_gap: float = DEFAULT_MAX_GAP,
) -> Measurement:
    """One damper from the values of its channels, from any source, in order of stamp.

    Args:
        recording: name for errors and records.
        data: by role (displacement, force, command, ...), in order of arrival.
        signal_map: with an entry for ``damper``.
        start, end, max_gap: as in ``measure``.

    Raises:
        InputError: without displacement, or without samples in the window.
    """
    signals = signal_map.dampers[damper]
    if "displacement" not in data:
        raise InputError(
            f"{recording}: has no displacement of damper {damper!r} ({signals.displacement.topic}, "
            f"{signals.displacement.field})"
        )
    arrived = data["displacement"]
    counts = Counts.of(Admission(max_gap).block(arrived.stamp, arrived.value)[0])
    windows = _windows(signal_map, start, end)
    *moved, wild = displacement_course(arrived, signals.displacement.skew)
    origin, spikes = moved[0][0] if moved[0].size else 0, {"displacement": wild}
    kinematics, raw = _kinematics(*moved, origin, data, signals, signal_map.cutoff, max_gap, windows)
    if len(kinematics) < 2:
        raise too_few(recording, damper, len(kinematics), arrived, start, end)
    force, near = (None, np.zeros(len(kinematics), bool))
    gauge_stamp, gauge = np.zeros(0, np.int64), np.zeros(0)
    if "force" in data:
        gauge_stamp, gauge, spikes["force"] = force_course(data["force"], signals.force.skew)
        force, near = _filtered(gauge_stamp, gauge, kinematics, signal_map.cutoff, max_gap)
        force = force - signals.spring_rate * kinematics.displacement - signals.preload
        near &= ~touched(kinematics.stamp, gauge_stamp[clipped(gauge)], signal_map.cutoff, signal_map.band)
    return Measurement(
        recording=recording,
        damper=damper,
        kinematics=kinematics,
        force=force,
        judged=kinematics.warm() & near,
        counts=counts,
        gauge=gauge,
        raw_displacement=raw,
        cutoff=signal_map.cutoff,
        band=signal_map.band,
        signals=signals,
        acceleration=_acceleration(data, signals, kinematics, signal_map.cutoff, max_gap),
        gauge_stamp=gauge_stamp,
        spikes={role: tuple(((times - origin) / 1e9).tolist()) for role, times in spikes.items() if times.size},
    )


def check_force(measurement: Measurement) -> None:
    """Refuses a measurement without force, or whose force was measured at another time than its displacement.

    Raises:
        InputError: one line.
    """
    if measurement.force is None:
        force = measurement.signals.force
        raise InputError(
            f"{measurement.recording}: has no measured force of damper {measurement.damper!r} ({force.topic}, "
            f"{force.field}); this verb needs one"
        )
    if measurement.kinematics.warm().any() and not measurement.judged.any():
        raise InputError(
            f"{measurement.recording}: the force of damper {measurement.damper!r} was not recorded at the same time as "
            f"its displacement; check the stamps and the skew"
        )


def _acceleration(
    data: Mapping[str, ChannelData], signals: DamperSignals, kinematics: Kinematics, cutoff: float, max_gap: float
) -> np.ndarray | None:
    if "acceleration" not in data:
        return None
    stamp, value = in_order(data["acceleration"], signals.acceleration.skew)
    values, near = _filtered(stamp, value, kinematics, cutoff, max_gap)
    return np.where(near, values, np.nan)


def _windows(signal_map: SignalMap, start: float, end: float) -> list[tuple[float, float]]:
    windows = signal_map.windows or ((0.0, float("inf")),)
    cut = [(max(first, start), min(last, end)) for first, last in windows]
    return [(first, last) for first, last in cut if first < last]


def _kinematics(
    stamp: np.ndarray,
    displacement: np.ndarray,
    origin: int,
    data: Mapping[str, ChannelData],
    signals: DamperSignals,
    cutoff: float,
    max_gap: float,
    windows: list[tuple[float, float]],
) -> tuple[Kinematics, np.ndarray]:
    parts, raws = [], []
    for first, last in windows:
        inside = slice(*np.searchsorted(stamp - origin, [first * 1e9, last * 1e9]))
        held = {
            role: last_value(data[role], getattr(signals, role).skew, stamp[inside])
            for role in ("command", "temperature", "pressure")
            if role in data
        }
        kinematics, verdict = Differentiator(cutoff, max_gap).block(stamp[inside], displacement[inside], **held)
        parts.append(kinematics)
        raws.append(displacement[inside][verdict < DUPLICATE])
    joined = Kinematics.joined(parts)
    joined.block[T] = (joined.stamp - origin) / 1e9
    return joined, raws[0] if len(raws) == 1 else np.concatenate(raws or [np.zeros(0)])


def _filtered(
    stamp: np.ndarray, value: np.ndarray, kinematics: Kinematics, cutoff: float, max_gap: float
) -> tuple[np.ndarray, np.ndarray]:
    """A fast channel at the kinematics' stamps through the causal filter, and where it was recorded nearby.

    The channel is linear between its samples; the filter runs over the stamps of both, so it is exact for both.
    """
    if not stamp.size:
        return np.full(len(kinematics), np.nan), np.zeros(len(kinematics), bool)
    filtered = at_stamps(stamp, value, kinematics, cutoff)
    after = np.searchsorted(stamp, kinematics.stamp)
    before = np.searchsorted(stamp, kinematics.stamp, side="right") - 1
    inside = (before >= 0) & (after < stamp.size)
    gap = np.where(
        inside, stamp[np.minimum(after, stamp.size - 1)] - stamp[np.maximum(before, 0)], np.iinfo(np.int64).max
    )
    near = gap <= max_gap * 1e9
    return filtered, _settled(near, kinematics)


def _settled(near: np.ndarray, kinematics: Kinematics) -> np.ndarray:
    """``near`` less the warm-up after each gap in the channel."""
    returns = near & ~np.concatenate([[True], near[:-1]])
    for i in np.flatnonzero(returns):
        until = np.searchsorted(kinematics.stamp, kinematics.stamp[i] + 200_000_000)
        near[i:until] = False
    return near
