"""All dampers of a vehicle over blocks of messages: channel values in order of arrival in, DamperForces contents out.

One output message answers one displacement message; it holds the dampers that this message moved (a sample
that is dropped moves none), in the order in which the line was given its dampers (that of the signal map).
``replay`` runs on this. The node follows the same rule message by message, on the same line; a test over DDS holds the
two together bit for bit.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from damper_estimator.runtime.estimates import Estimates
from damper_estimator.runtime.estimator import DamperEstimator, Held
from damper_estimator.runtime.record import SLOW
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
    """Output messages that hold the same k dampers.

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


class HeldChannel:
    """A slow channel: the last value that has arrived, how many have, and the last one's stamp."""

    def __init__(self) -> None:
        self._last = Held()

    def at(self, rank: np.ndarray, arrivals: Arrivals | None) -> Held:
        """What was held when the messages of these ranks (n,) came; carries the last over to the next block."""
        last = self._last
        if arrivals is None or not arrivals.rank.size:
            return last
        values = np.concatenate([[last.value], arrivals.value])
        stamps = np.concatenate([np.array([last.stamp], np.int64), arrivals.stamp])
        self._last = Held(float(values[-1]), last.heard + arrivals.rank.size, int(stamps[-1]))
        place = np.searchsorted(arrivals.rank, rank, side="right")
        return Held(values[place], last.heard + place, stamps[place])


class VehicleLine:
    """The running state of all dampers; blocks of any size, also of one message, give the same forces bit for bit."""

    def __init__(
        self,
        estimators: Mapping[str, DamperEstimator],
        reaches: Mapping[str, Callable[[np.ndarray], np.ndarray]] | None = None,
    ):
        """Both by damper.

        Args:
            estimators: in the order of the output.
            reaches: of dampers whose force depends on a command, what gives for the next samples (8, n) the interval
                that can be reached and the slopes, (4, n) from force_min to dforce_dcurrent.
        """
        self._estimators = dict(estimators)
        self._reaches = dict(reaches or {})
        self._held = {name: {role: HeldChannel() for role in (*SLOW, "acceleration")} for name in self._estimators}

    def block(
        self, displacement: Mapping[str, Arrivals], slow: Mapping[str, Mapping[str, Arrivals]]
    ) -> tuple[list[ForceMessages], dict[str, Estimates]]:
        """Runs the next messages.

        Args:
            displacement: by damper; those without news may be left out.
            slow: by damper and role (command, temperature, pressure, acceleration); the same.

        Returns:
            The messages to send, and the estimates of each damper that had displacements.
        """
        estimates, ranks = {}, {}
        for name, estimator in self._estimators.items():
            own, given = displacement.get(name), slow.get(name, {})
            rank = own.rank if own is not None else np.zeros(0, np.int64)
            held = {role: channel.at(rank, given.get(role)) for role, channel in self._held[name].items()}
            if own is not None and rank.size:
                estimates[name] = estimator.take(own.stamp, own.value, held)
                if name in self._reaches:
                    reach = self._reaches[name](estimates[name].kinematics.block)
                    estimates[name] = replace(estimates[name], reach=reach)
                ranks[name] = rank[estimates[name].verdict < DUPLICATE]
        return _messages(estimates, ranks), estimates


def _messages(estimates: Mapping[str, Estimates], ranks: Mapping[str, np.ndarray]) -> list[ForceMessages]:
    messages = []
    for rank, rows in together(ranks):
        names = tuple(rows)
        parts = {name: estimates[name].fields() for name in names}
        fields = {field: np.stack([parts[n][field][rows[n]] for n in names], axis=1) for field in parts[names[0]]}
        messages.append(ForceMessages(names, rank, estimates[names[0]].kinematics.stamp[rows[names[0]]], fields))
    return messages


def together(keys: Mapping[str, np.ndarray]) -> Iterator[tuple[np.ndarray, dict[str, np.ndarray]]]:
    """Brings equal keys of several owners together: rising keys in, and for each set of owners that share keys these
    keys and their rows in each owner's array."""
    everything = np.unique(np.concatenate([np.zeros(0, np.int64), *keys.values()]))
    if not everything.size:
        return
    there = np.stack([np.isin(everything, own, assume_unique=True) for own in keys.values()])
    for pattern in np.unique(there, axis=1).T:
        shared = everything[np.all(there == pattern[:, None], axis=0)]
        yield shared, {n: np.searchsorted(keys[n], shared) for n, inside in zip(keys, pattern, strict=True) if inside}
