"""Collects the node's health for ``/diagnostics``."""

import time
from dataclasses import replace

from diagnostic_msgs.msg import DiagnosticStatus

from damper_estimator.node import health
from damper_estimator.node.command_health import CommandNow, command_status
from damper_estimator.node.diagnostic_status import WARN, status
from damper_estimator.node.displacement import JOINT_STATE, names_in
from damper_estimator.node.estimation import Estimation
from damper_estimator.node.force_follower import CommandTally, ForceFollower
from damper_estimator.node.force_publisher import ForcePublisher
from damper_estimator.node.input_health import InputTally, input_status, other_status
from damper_estimator.node.inputs import Inputs
from damper_estimator.node.ports import NamedNode, NodeState
from damper_estimator.node.stamp_age import StampAge
from damper_estimator.node.wire import MalformedMessage


class Reporter:
    """Reports the node's health, compared with that of a second ago; final."""

    def __init__(self, node: NamedNode, state: NodeState, inputs: Inputs, forces: ForcePublisher) -> None:
        self._node, self._state, self._messages, self._forces = node, state, inputs, forces
        self._before: dict[str, health.DamperNow] = {}
        self._commands: dict[str, CommandTally] = {}
        self._inputs: dict[str, InputTally] = {}
        self._introduced: set[tuple] = set()

    def introduce(self, estimation: Estimation) -> None:
        """Logs once which model estimates which damper, and whether the model was identified with another filter."""
        cutoff = estimation.roster.signal_map.cutoff
        logger = self._node.get_logger()
        for topic, displacement in estimation.displacement.items():
            source = displacement.source
            for estimator, follower in zip(source.estimators, source.followers, strict=True):
                name, model = estimator.name, estimator.deployed.model
                key = (name, model.name, topic, cutoff)
                if key in self._introduced:
                    continue
                self._introduced.add(key)
                for warning in follower.warnings:
                    logger.warning(f"{name}: {warning}")
                if not estimator.deployed.is_identified:
                    logger.warning(
                        f"{name}: model {model.name} was never identified, so no estimate is better than DEGRADED; "
                        "fit it to recordings of this damper (damper-estimator fit)"
                    )
                logger.info(f"{name}: model {model.name}, displacement from {self._node.resolve_topic_name(topic)}")
                fitted = model.fit.get("cutoff")
                if fitted is not None and fitted != cutoff:
                    logger.warning(
                        f"{name}: model {model.name} was identified at a cutoff of {fitted} Hz, {cutoff:g} Hz is in use"
                    )

    def statuses(self) -> list[DiagnosticStatus]:
        """The present statuses."""
        state, prefix = self._state, self._node.get_fully_qualified_name().lstrip("/")
        estimation = state.estimation
        if estimation is None:
            reason = state.refusal or "not configured"
            return [status(f"{prefix}: node", WARN, reason, {"state": "unconfigured"})]
        statuses, now = [], time.monotonic()
        inputs = self._messages.snapshot(estimation.displacement)
        known = set(estimation.names)
        for topic, displacement in estimation.displacement.items():
            tally, source = inputs[topic], displacement.source
            self._complete(tally, topic, source.age)
            before = self._inputs.get(topic, InputTally(""))
            statuses.append(input_status(prefix, tally, before, now, known))
            for d, estimator in enumerate(source.estimators):
                statuses.append(self._damper(prefix, topic, estimation, d, estimator.name))
            statuses += [self._command(prefix, follower) for follower in source.followers if follower.tally.desired]
        others = self._other_inputs(estimation)
        for topic, tally in others.items():
            statuses.append(other_status(prefix, tally, self._inputs.get(topic, InputTally(""))))
        self._inputs = inputs | others
        statuses.append(
            health.output_status(prefix, self._output(), self._forces.incompatible, self._messages.clock_has_stopped)
        )
        if state.recorder is not None:
            statuses.append(status(f"{prefix}: recording", *state.recorder.health()))
        return statuses

    def _other_inputs(self, estimation: Estimation) -> dict[str, InputTally]:
        """Counts of the other topics that the signal map names, or that someone publishes on."""
        topics = {topic: kind for topic, kind in estimation.topics.items() if topic not in estimation.displacement}
        found = {}
        for topic, tally in self._messages.snapshot(topics).items():
            if topic in estimation.named:
                self._count_other_types(tally, topics[topic])
            if topic in estimation.named or tally.messages or tally.publishers or tally.incompatible:
                found[topic] = tally
        return found

    def _count_other_types(self, tally: InputTally, type_name: str) -> None:
        """Counts publishers of another type on a topic that has had no message yet."""
        if tally.last is None:
            publishers = self._node.get_publishers_info_by_topic(tally.topic)
            tally.other_types = sum(publisher.topic_type != type_name for publisher in publishers)

    def _complete(self, tally: InputTally, topic: str, age: StampAge) -> None:
        """Adds the values that are not worth computing with every message."""
        self._count_other_types(tally, JOINT_STATE)
        data = self._messages.data.get(topic)
        if data is None:
            return
        try:
            tally.names = names_in(data)
        except MalformedMessage:
            return
        tally.age, tally.late, tally.is_other_clock = age.age, age.late, not age.is_related

    def _damper(self, prefix: str, topic: str, estimation: Estimation, d: int, name: str) -> DiagnosticStatus:
        source, comparison = estimation.displacement[topic].source, estimation.displacement[topic].comparison
        deployed = source.estimators[d].deployed
        model = deployed.model
        now = health.DamperNow(
            name,
            model.name,
            model.fit.get("cutoff"),
            source.line.records["counts"][d].copy(),
            source.line.velocity_noise(d),
            deployed.is_identified,
            int(source.stamps[d]),
            [role for role, memory in deployed.memories.items() if memory is not None],
            self._slow_inputs(estimation, name),
            int(source.missing[d]),
            bool(self._messages.now() - source.last_good[d] > estimation.settings.stale_after),
            comparison.drifts.get(name),
        )
        before = self._before.get(name)
        # A change of parameters resets the counts.
        if before is None or (now.counts < before.counts).any() or now.missing < before.missing:
            before = health.before_first_sample(now)
        self._before[name] = now
        roster = estimation.roster
        return health.damper_status(prefix, now, before, roster.signal_map.cutoff, roster.delay)

    def _slow_inputs(self, estimation: Estimation, damper: str) -> dict[str, InputTally]:
        topics = estimation.slow_topics(damper)
        tallies = self._messages.snapshot(topics.values())
        return {role: tallies[topic] for role, topic in topics.items()}

    def _command(self, prefix: str, follower: ForceFollower) -> DiagnosticStatus:
        name = follower.name
        before = self._commands.get(name, CommandTally())
        tally = self._commands[name] = replace(follower.tally)
        # A change of parameters resets the counts.
        before = before if before.desired <= tally.desired else CommandTally()
        now = CommandNow(name, follower.refusal, tally, follower.desired, follower.sent, follower.current.complaint())
        return command_status(prefix, now, before)

    def _output(self) -> dict[str, object]:
        return {
            "state": "active" if self._state.is_active else "inactive",
            "topic": self._forces.topic,
            "published": self._forces.published,
            health.SUBSCRIBERS: self._forces.subscribers,
            "incompatible subscribers": self._forces.incompatible,
            "longest time for one message [ms]": f"{1e3 * self._messages.take_longest():.3f}",
            "time for messages [s]": f"{self._messages.busy:.3f}",
        }
