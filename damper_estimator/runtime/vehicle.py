"""All dampers of a vehicle over blocks of messages: channel values in order of arrival in, DamperForces contents out.

One output message answers one displacement message; it contains the dampers with a used sample in this message, in the
order in which the dampers were added to the line (that of the signal map). ``replay`` uses this module. The node
follows the same rule message by message, on the same line; a test over DDS compares the two bit for bit.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from damper_estimator.runtime.damper_record import SLOW
from damper_estimator.runtime.estimates import Estimates
from damper_estimator.runtime.estimator import DamperEstimator, HeldValues
from damper_estimator.signals.admission import DUPLICATE


@dataclass(frozen=True)
class Arrivals:
    """Values of one channel in order of arrival.

    Attributes:
        rank: (n,) int64, place among all messages.
        stamp: (n,) int64 ns.
        value: (n,) SI.
    """

    rank: np.ndarray
    stamp: np.ndarray
    value: np.ndarray


@dataclass(frozen=True)
class ForceMessages:
    """Output messages with the same k dampers.

    Attributes:
        names: the dampers.
        rank: (m,) int64, of the displacement messages that they answer.
        stamp: (m,) int64 ns, of those messages.
        fields: (m, k) by field of damper_msgs/DamperForces.
    """

    names: tuple[str, ...]
    rank: np.ndarray
    stamp: np.ndarray
    fields: Mapping[str, np.ndarray]


class SampleAndHold:
    """A slow channel: its last value with its stamp, and the number of messages so far."""

    def __init__(self) -> None:
        self._last = HeldValues()

    def at(self, rank: np.ndarray, arrivals: Arrivals | None) -> HeldValues:
        """The held values at the messages of these ranks (n,); keeps the last one for the next block."""
        last = self._last
        if arrivals is None or not arrivals.rank.size:
            return last
        values = np.concatenate([[last.value], arrivals.value])
        stamps = np.concatenate([np.array([last.stamp], np.int64), arrivals.stamp])
        self._last = HeldValues(float(values[-1]), last.received + arrivals.rank.size, int(stamps[-1]))
        place = np.searchsorted(arrivals.rank, rank, side="right")
        return HeldValues(values[place], last.received + place, stamps[place])


class VehicleLine:
    """The running state of all dampers; blocks of any size, also of one message, yield the same forces bit for bit."""

    def __init__(
        self,
        estimators: Mapping[str, DamperEstimator],
        reaches: Mapping[str, Callable[[np.ndarray], np.ndarray]] | None = None,
    ):
        """Both by damper.

        Args:
            estimators: in the order of the output.
            reaches: for dampers whose force depends on a command, functions of the next samples (8, n) that return the
                reachable interval and the slopes, (4, n) from force_min to dforce_dcurrent.
        """
        self._estimators = dict(estimators)
        self._reaches = dict(reaches or {})
        self._held = {name: {role: SampleAndHold() for role in (*SLOW, "acceleration")} for name in self._estimators}

    def block(
        self, displacement: Mapping[str, Arrivals], slow: Mapping[str, Mapping[str, Arrivals]]
    ) -> tuple[list[ForceMessages], dict[str, Estimates]]:
        """Runs the next messages.

        Args:
            displacement: by damper; those without new messages can be left out.
            slow: by damper and role (command, temperature, pressure, acceleration); likewise.

        Returns:
            The messages to send, and the estimates of each damper with displacements.
        """
        estimates, ranks = {}, {}
        for name, estimator in self._estimators.items():
            arrivals, slow_arrivals = displacement.get(name), slow.get(name, {})
            rank = arrivals.rank if arrivals is not None else np.zeros(0, np.int64)
            held = {role: channel.at(rank, slow_arrivals.get(role)) for role, channel in self._held[name].items()}
            if arrivals is not None and rank.size:
                estimates[name] = estimator.take(arrivals.stamp, arrivals.value, held)
                if name in self._reaches:
                    reach = self._reaches[name](estimates[name].kinematics.block)
                    estimates[name] = replace(estimates[name], reach=reach)
                ranks[name] = rank[estimates[name].verdict < DUPLICATE]
        return _messages(estimates, ranks), estimates


def _messages(estimates: Mapping[str, Estimates], ranks: Mapping[str, np.ndarray]) -> list[ForceMessages]:
    messages = []
    for rank, rows in group_equal_keys(ranks):
        names = tuple(rows)
        parts = {name: estimates[name].fields() for name in names}
        fields = {field: np.stack([parts[n][field][rows[n]] for n in names], axis=1) for field in parts[names[0]]}
        messages.append(ForceMessages(names, rank, estimates[names[0]].kinematics.stamp[rows[names[0]]], fields))
    return messages


def group_equal_keys(keys: Mapping[str, np.ndarray]) -> Iterator[tuple[np.ndarray, dict[str, np.ndarray]]]:
    """Groups the equal keys of several owners, each with rising keys: yields for each set of owners the keys that they
    share, and the rows of these keys in each owner's array.
    """
    all_keys = np.unique(np.concatenate([np.zeros(0, np.int64), *keys.values()]))
    if not all_keys.size:
        return
    present = np.stack([np.isin(all_keys, of_owner, assume_unique=True) for of_owner in keys.values()])
    for pattern in np.unique(present, axis=1).T:
        shared = all_keys[np.all(present == pattern[:, None], axis=0)]
        yield shared, {n: np.searchsorted(keys[n], shared) for n, inside in zip(keys, pattern, strict=True) if inside}
