"""Puts together what the node knows of itself for ``/diagnostics``."""

import time
from dataclasses import replace

from diagnostic_msgs.msg import DiagnosticStatus
from rclpy.lifecycle import LifecycleNode

from damper_estimator.node import health
from damper_estimator.node.commands import CommandTally, Follower
from damper_estimator.node.displacement import JOINT_STATE, names_in
from damper_estimator.node.estimation import Estimation
from damper_estimator.node.stamp_age import StampAge
from damper_estimator.node.wire import MalformedMessage


class Reporter:
    """The node's view of itself, and what it said a second ago; final.

    Attributes:
        published: force messages.
    """

    def __init__(self, node: LifecycleNode) -> None:
        self._node = node
        self.published = 0
        self._incompatible = 0
        self._before: dict[str, health.DamperNow] = {}
        self._commands: dict[str, CommandTally] = {}
        self._inputs: dict[str, health.InputTally] = {}
        self._introduced: set[tuple] = set()

    def note_incompatible_output(self, event: object) -> None:
        """A subscriber of the forces asks for more than is offered."""
        self._incompatible = event.total_count

    def introduce(self, estimation: Estimation) -> None:
        """Says in the log, once, what estimates which damper, and where a model wants another filter."""
        cutoff = estimation.roster.signal_map.cutoff
        logger = self._node.get_logger()
        for topic, own in estimation.displacement.items():
            for one, follower in zip(own.source.estimators, own.source.followers, strict=True):
                model = one.deployed.model
                key = (one.name, model.name, topic, cutoff)
                if key in self._introduced:
                    continue
                self._introduced.add(key)
                for warning in follower.warnings:
                    logger.warning(f"{one.name}: {warning}")
                if not one.deployed.is_identified:
                    logger.warning(
                        f"{one.name}: model {model.name} was never identified, so no estimate is better than DEGRADED; "
                        "fit it to recordings of this damper (damper-estimator fit)"
                    )
                logger.info(f"{one.name}: model {model.name}, displacement from {self._node.resolve_topic_name(topic)}")
                fitted = model.fit.get("cutoff")
                if fitted is not None and fitted != cutoff:
                    logger.warning(
                        f"{one.name}: model {model.name} was identified at a cutoff of {fitted} Hz, "
                        f"{cutoff:g} Hz is in use"
                    )

    def statuses(self) -> list[DiagnosticStatus]:
        """What to say now."""
        node, prefix = self._node, self._node.get_fully_qualified_name().lstrip("/")
        estimation = node.estimation
        if estimation is None:
            reason = node.refusal or "not configured"
            return [health.status(f"{prefix}: node", health.WARN, reason, {"state": "unconfigured"})]
        told, now = [], time.monotonic()
        inputs = node.inputs.snapshot(estimation.displacement)
        known = set(estimation.names)
        for topic, own in estimation.displacement.items():
            tally = inputs[topic]
            self._complete(tally, topic, own.source.age)
            before = self._inputs.get(topic, health.InputTally(""))
            told.append(health.input_status(prefix, tally, before, now, known))
            for d, one in enumerate(own.source.estimators):
                told.append(self._damper(prefix, topic, estimation, d, one.name))
            told += [self._command(prefix, follower) for follower in own.source.followers if follower.tally.desired]
        self._inputs = inputs
        told.append(health.output_status(prefix, self._output(), self._incompatible))
        if node.recorder is not None:
            told.append(health.status(f"{prefix}: recording", *node.recorder.health()))
        return told

    def _complete(self, tally: health.InputTally, topic: str, age: StampAge) -> None:
        """What is not worth computing with every message."""
        if tally.last is None:
            there = self._node.get_publishers_info_by_topic(tally.topic)
            tally.other_types = sum(publisher.topic_type != JOINT_STATE for publisher in there)
        data = self._node.inputs.data.get(topic)
        if data is None:
            return
        try:
            tally.names = names_in(data)
        except MalformedMessage:
            return
        tally.age, tally.late, tally.is_other_clock = age.age, age.late, not age.is_related

    def _damper(self, prefix: str, topic: str, estimation: Estimation, d: int, name: str) -> DiagnosticStatus:
        own = estimation.displacement[topic]
        source, model = own.source, own.source.estimators[d].deployed.model
        memories = source.estimators[d].deployed.memories
        now = health.DamperNow(
            name,
            model.name,
            model.fit.get("cutoff"),
            source.line.records["counts"][d].copy(),
            source.line.velocity_noise(d),
            source.estimators[d].deployed.is_identified,
            [role for role, memory in memories.items() if memory is not None],
            int(source.missing[d]),
            bool(self._node.inputs.now() - source.last_good[d] > estimation.settings.stale_after),
            own.comparison.drifts.get(name),
        )
        before = self._before.get(name)
        # Counts begin anew where a change of parameters did.
        if before is None or (now.counts < before.counts).any() or now.missing < before.missing:
            before = health.nothing_yet(now)
        self._before[name] = now
        roster = estimation.roster
        return health.damper_status(prefix, now, before, roster.signal_map.cutoff, roster.delay)

    def _command(self, prefix: str, own: Follower) -> DiagnosticStatus:
        before = self._commands.get(own.name, CommandTally())
        tally = self._commands[own.name] = replace(own.tally)
        # Counts begin anew where a change of parameters did.
        before = before if before.desired <= tally.desired else CommandTally()
        now = health.CommandNow(own.name, own.refusal, tally, own.wanted, own.sent, own.current.complaint())
        return health.command_status(prefix, now, before)

    def _output(self) -> dict[str, object]:
        node = self._node
        return {
            "state": "active" if node.is_active else "inactive",
            "topic": node.forces.topic_name,
            "published": self.published,
            health.SUBSCRIBERS: node.forces.get_subscription_count(),
            "incompatible subscribers": self._incompatible,
            "longest time for one message [ms]": f"{1e3 * node.inputs.take_longest():.3f}",
            "time for messages [s]": f"{node.inputs.busy:.3f}",
        }
