"""The node ``damper_estimator``: displacement in, damper forces out, health once a second."""

import time
import traceback
from collections.abc import Callable

import numpy as np
from damper_msgs.msg import DamperForces
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import JointState

from damper_estimator.node import health
from damper_estimator.node.conversion import TYPES, forces_message, live_path, number_at, places_by_name, stamp_ns
from damper_estimator.node.live_damper import SLOW, LiveDamper
from damper_estimator.node.roster import MOST_DAMPERS, make_roster
from damper_estimator.node.settings import read_settings
from damper_estimator.recordings import FieldPath
from damper_estimator.signals import default_signals, delay_seconds

HEALTH_PERIOD = 1.0  # s, REP-107
OUTPUT_DEPTH = 100


class EstimatorNode(Node):
    """Runs filter and model of every damper at the rate of the input; final.

    Publishes one ``DamperForces`` per displacement message, with its header, for those dampers whose sample was
    good; a message that gives no estimate gives no output, and is counted.
    """

    def __init__(self) -> None:
        """Raises InputError where parameters, signal map or a model are unusable."""
        super().__init__("damper_estimator")
        self.settings = read_settings(self)
        self.get_logger().info(
            "loading the models; the first start of a version compiles them, which takes some seconds"
        )
        self._roster = make_roster(self.settings)
        self._dampers: dict[str, LiveDamper] = {}
        self._inputs: dict[str, list[tuple[LiveDamper, FieldPath]]] = {}
        self._tallies: dict[str, health.InputTally] = {}
        self._published = 0
        self._before: dict[tuple[str, str], health.Glance] = {}
        self._quality = QoSProfile(
            depth=self.settings.qos_depth,
            reliability=ReliabilityPolicy[self.settings.qos_reliability.upper()],
        )
        self._forces = self.create_publisher(DamperForces, "~/force", OUTPUT_DEPTH)
        self._diagnostics = self.create_publisher(DiagnosticArray, "/diagnostics", OUTPUT_DEPTH)
        if self._roster.is_open:
            self._listen(default_signals("").displacement.topic)
        for name in self._roster.names:
            self._take(name)
        # A simulated clock may stand still; health is told all the same.
        self.create_timer(HEALTH_PERIOD, self._tell_health, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def _take(self, name: str) -> None:
        """Begins to estimate a damper: its subscriptions, and a place in its displacement topic."""
        damper = self._roster.damper(name)
        path = live_path("displacement", damper.signals.displacement)
        for role in SLOW:
            channel = getattr(damper.signals, role)
            self._subscribe(TYPES[role], channel.topic, self._holder(damper, role, live_path(role, channel)))
        topic = damper.signals.displacement.topic
        self._listen(topic)
        self._dampers[name] = damper
        self._inputs[topic].append((damper, path))
        self.get_logger().info(f"{name}: model {damper.model.name}, displacement from {self._tallies[topic].topic}")
        fitted = damper.model.fit.get("cutoff")
        if fitted is not None and fitted != self._roster.signal_map.cutoff:
            self.get_logger().warning(
                f"{name}: model {damper.model.name} was identified at a cutoff of {fitted:g} Hz, "
                f"{self._roster.signal_map.cutoff:g} Hz is in use"
            )

    def _listen(self, topic: str) -> None:
        if topic in self._inputs:
            return
        tally = health.InputTally(self.resolve_topic_name(topic))
        self._inputs[topic] = []
        self._tallies[topic] = tally

        def on_incompatible(event: object) -> None:
            tally.incompatible = event.total_count

        def on_lost(event: object) -> None:
            tally.lost = event.total_count

        events = SubscriptionEventCallbacks(incompatible_qos=on_incompatible, message_lost=on_lost)
        self._subscribe(JointState, topic, lambda message: self._estimate(topic, message), tally, events)

    def _subscribe(
        self,
        kind: type,
        topic: str,
        act: Callable,
        tally: health.InputTally | None = None,
        events: SubscriptionEventCallbacks | None = None,
    ) -> None:
        """Subscribes so that whatever a message provokes is logged and counted, and the node goes on."""

        def receive(message: object) -> None:
            try:
                act(message)
            except Exception:
                if tally:
                    tally.failures += 1
                self.get_logger().error(
                    f"message on {topic}: {traceback.format_exc()}", throttle_duration_sec=HEALTH_PERIOD
                )

        self.create_subscription(kind, topic, receive, self._quality, event_callbacks=events)

    def _holder(self, damper: LiveDamper, role: str, path: FieldPath) -> Callable:
        return lambda message: damper.hold(role, number_at(message, path, {}))

    def _estimate(self, topic: str, message: JointState) -> None:
        """Estimates for the dampers in one displacement message."""
        tally = self._tallies[topic]
        tally.messages += 1
        tally.last = time.monotonic()
        tally.names = message.name
        if self._roster.is_open:
            self._take_new(message.name)
        places = places_by_name(message.name)
        stamp = stamp_ns(message.header.stamp)
        names, parts = [], []
        for damper, path in self._inputs[topic]:
            raw = number_at(message, path, places)
            if raw is None:
                damper.missing += 1
                continue
            estimates = damper.estimate(stamp, raw)
            if estimates.force.size:
                names.append(damper.name)
                parts.append(estimates.fields())
        if names:
            fields = {field: np.concatenate([part[field] for part in parts]) for field in parts[0]}
            self._published += 1
            self._forces.publish(forces_message(message.header, names, fields))

    def _take_new(self, names: list[str]) -> None:
        for name in names:
            if name and name not in self._dampers and len(self._dampers) < MOST_DAMPERS:
                self._take(name)

    def _tell_health(self) -> None:
        prefix = self.get_fully_qualified_name().lstrip("/")
        cutoff = self._roster.signal_map.cutoff
        delay = delay_seconds(cutoff)
        now, nothing = time.monotonic(), health.glance(health.InputTally(""))
        message = DiagnosticArray()
        message.header.stamp = self.get_clock().now().to_msg()
        for topic, tally in self._tallies.items():
            before = self._before.get((topic, ""), nothing)
            message.status.append(health.input_status(prefix, tally, before, now, set(self._dampers)))
            self._before[topic, ""] = health.glance(tally)
            for damper, _ in self._inputs[topic]:
                before = self._before.get((topic, damper.name), nothing)
                message.status.append(health.damper_status(prefix, damper, before, cutoff, delay))
                self._before[topic, damper.name] = health.glance(tally, damper)
        subscribers = self._forces.get_subscription_count()
        message.status.append(health.output_status(prefix, self._forces.topic_name, self._published, subscribers))
        self._diagnostics.publish(message)
