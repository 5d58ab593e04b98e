"""Plays the inputs of a replayed recording to the live node and compares its forces with ``replay``, bit for bit.

::

    damper-estimator replay bag.mcap -m model.yaml -o replayed.mcap
    python -m damper_estimator.node.playback.rehearsal replayed.mcap -m model.yaml
"""

import argparse
import json
import subprocess
import sys
import sysconfig
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import rclpy

from damper_estimator.errors import InputError
from damper_estimator.node.playback.domain import free_ros_domain
from damper_estimator.node.playback.player import Player
from damper_estimator.recordings import Bag, open_bag
from damper_estimator.runtime import SLOW
from damper_estimator.signals import SignalMap, load_signal_map
from damper_estimator.signals.channels import find_topic, signals_for

DEPTH = 1000  # waiting messages; the estimates are compared, not the losses of a busy machine
FORCE = "/damper_estimator/force"
EXECUTABLE = Path(sysconfig.get_path("scripts")) / "estimator_node"
FIELDS = (
    "displacement", "velocity", "acceleration", "force", "force_stddev", "force_min", "force_max",
    "dforce_dvelocity", "dforce_dcurrent", "status",
)  # fmt: skip


@dataclass(frozen=True)
class Outcome:
    """Comparison of live and replayed forces.

    Attributes:
        replayed, live: number of messages.
        unequal: messages that differ in stamp, names or any bit of a number.
        largest: N, largest difference of force among messages with equal stamp and names.
    """

    replayed: int
    live: int
    unequal: int
    largest: float

    @property
    def is_equal(self) -> bool:
        """Whether both have the same messages."""
        return self.replayed == self.live and not self.unequal


def rehearse(player: Player, replayed: Path, signal_map: SignalMap) -> Outcome:
    """Plays to a running node.

    Args:
        player: fresh, on the node's ROS domain.
        replayed: written by ``replay`` with the node's model and signal map.
        signal_map: the node's.

    Raises:
        InputError: if the recording is unusable or there is no subscriber.
    """
    with open_bag(replayed) as bag:
        displacement, slow = _inputs(bag, signal_map)
        types = {topic.name: topic.type for topic in bag.topics}
        kinds = {name: types[name] for name in (*sorted(slow - displacement), *sorted(displacement))}
        player.connect(kinds)
        player.play(_messages(bag, kinds), displacement)
        expected = [message for batch in bag.batches([FORCE]) for _, message in batch.messages(FORCE)]
        player.linger(len(expected))
    return compared(expected, player.forces)


def compared(replayed: Sequence[object], live: Sequence[object]) -> Outcome:
    """Compares two series of ``DamperForces`` message by message."""
    unequal, largest = 0, 0.0
    for expected, received in zip(replayed, live, strict=False):
        if _key(expected) != _key(received):
            unequal += 1
        elif any(_bits(expected, field) != _bits(received, field) for field in FIELDS):
            unequal += 1
            difference = np.abs(np.subtract(expected.force, received.force))
            largest = max(largest, float(np.nanmax(difference, initial=0.0)))
    return Outcome(len(replayed), len(live), unequal, largest)


def _key(message: object) -> tuple:
    return message.header.stamp.sec, message.header.stamp.nanosec, *message.name


def _bits(message: object, field: str) -> bytes:
    return np.asarray(getattr(message, field), np.uint8 if field == "status" else np.float64).tobytes()


def _inputs(bag: Bag, signal_map: SignalMap) -> tuple[set[str], set[str]]:
    """The bag's topics of displacement, and of the slow channels."""
    signals = signals_for(bag, signal_map).dampers.values()
    roles = (*SLOW, "acceleration") if signal_map.fusion else SLOW
    displacement = {find_topic(bag, damper.displacement.topic) for damper in signals}
    slow = {find_topic(bag, getattr(damper, role).topic) for damper in signals for role in roles}
    return displacement - {None}, slow - {None}


def _messages(bag: Bag, topics: Sequence[str]) -> Iterator[tuple[str, bytes]]:
    for batch in bag.batches(list(topics)):
        for connection, _, data in batch.raw():
            yield connection.topic, data


def _rehearse_with_new_node(replayed: Path, model: str, signals: Path | None) -> Outcome:
    signal_map = load_signal_map(signals)
    with open_bag(replayed) as bag:
        dampers = list(signals_for(bag, signal_map).dampers)
    parameters = {"model": model, "dampers": json.dumps(dampers), "qos_reliability": "reliable", "qos_depth": DEPTH}
    parameters |= {"signals": signals} if signals else {}
    words = [word for name, value in parameters.items() for word in ("-p", f"{name}:={value}")]
    node = subprocess.Popen([EXECUTABLE, "--ros-args", *words])
    rclpy.init()
    player = Player(process=node)
    try:
        return rehearse(player, replayed, signal_map)
    finally:
        player.close()
        rclpy.shutdown()
        node.terminate()
        node.wait()


def main() -> int:
    """Starts a node, plays to it, prints the comparison of the forces; the exit status is 1 if they differ."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("replayed", type=Path, help="recording written by damper-estimator replay")
    parser.add_argument("-m", "--model", required=True, help="the model of that replay")
    parser.add_argument("-s", "--signals", type=Path, help="the signal map of that replay")
    arguments = parser.parse_args()
    try:
        with free_ros_domain():
            outcome = _rehearse_with_new_node(arguments.replayed, arguments.model, arguments.signals)
    except InputError as error:
        print(f"rehearsal: {error}", file=sys.stderr)
        return 1
    print(
        f"live node against replay: {outcome.live} of {outcome.replayed} messages received over DDS, "
        f"{outcome.unequal} differ, largest difference {outcome.largest:g} N: "
        + ("live equals offline, bit for bit" if outcome.is_equal else "live and offline are NOT equal")
    )
    return 0 if outcome.is_equal else 1


if __name__ == "__main__":
    sys.exit(main())
