"""Desired forces in, currents out: the inverse of the running node, its safe current, and its reports."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml
from rig import MS, START

from damper_estimator.control import InverseModel
from damper_estimator.model import load_model
from damper_estimator.recordings import floats, joint_states
from damper_estimator.runtime import DamperEstimator, deployed

SAFE = 0.25
CURRENT, JOINT_STATE, FLOAT = "/suspension/left/current", "sensor_msgs/msg/JointState", "std_msgs/msg/Float64"
WISH = "/damper_estimator/desired_force"
GOOD, DEGRADED, ACTIVATE, DEACTIVATE = 0, 3, 3, 4
REACHED, LIMITED, SAFE_OLD, SAFE_STATUS, SAFE_NO_ANSWER, SAFE_STOPPED, IDLE = range(7)


@pytest.fixture
def semi_active(tmp_path) -> dict[str, object]:
    """Parameters of a node with a magneto-rheological damper and one whose force depends on no current."""
    effects = [{"command_lag": {}}, {"viscous": {"rate": 800.0}}, {"semi_active_squash": {"gain": 600.0}}]
    for name, of_damper in (("left", effects), ("right", effects[1:2])):
        region = {"velocity": [-9.0, 9.0], "command": [0.0, 2.0]} if name == "left" else {"velocity": [-9.0, 9.0]}
        fit = {"residual_stddev": 10.0, "region": region}
        content = {"name": name, "source": "test", "effects": of_damper, "fit": fit}
        (tmp_path / f"{name}.yaml").write_text(yaml.safe_dump(content))
    signals = {"dampers": {"left": {"command": {"topic": CURRENT, "limits": [0.0, 2.0]}}, "right": {}}}
    (tmp_path / "signals").mkdir()
    (tmp_path / "signals" / "map.yaml").write_text(yaml.safe_dump(signals))
    return {
        "model": str(tmp_path), "signals": str(tmp_path / "signals" / "map.yaml"), "dampers": ["left", "right"],
        "safe_current": SAFE, "desired_force_timeout": 10.0, "command_extrapolating": False,
        "command_lag": 0.0,  # the driver of these tests reports any current
    }  # fmt: skip


class Commanded:
    """A rig that requests forces and receives the currents; final.

    Attributes:
        currents: A, of the left damper; ``reports``: the messages with their sources.
        motion: sent displacements, m.
        flows: A, current that the driver reports with every 20th sample; None for no report.
    """

    def __init__(self, rig) -> None:
        from damper_msgs.msg import DamperCommand
        from std_msgs.msg import Float64

        self.rig, self.currents, self.reports, self.motion, self.flows = rig, [], [], [], 0.5
        self._requested, self._is_wished, self._is_fresh = 0, False, False
        node = rig.node
        node.create_subscription(
            Float64, "/suspension/left/current_command", lambda m: self.currents.append(m.data), 1000
        )
        node.create_subscription(DamperCommand, f"{rig.name}/command", self.reports.append, 1000)
        rig.ready()
        rig.publisher(CURRENT, FLOAT)
        rig.publisher(WISH, JOINT_STATE)
        rig.wait(lambda: node.count_publishers("/suspension/left/current_command") > 0, "the currents")
        rig.wait(lambda: self.reports, "what is commanded")
        self.flow(0.5)
        rig.listen(0.5)

    def flow(self, current: float) -> None:
        """The reported current."""
        self.rig.send_raw(floats(np.array([current]))[0], CURRENT)

    def drive(self, count: int) -> None:
        """Sends good samples of both dampers, and waits for all answers."""
        before = len(self.rig.forces)
        for i in range(count):
            if i % 20 == 0 and self.flows is not None:
                self.flow(self.flows)
            self.motion.append(0.02 * np.sin(0.02 * len(self.motion)))
            self.rig.send([self.motion[-1]] * 2, ["left", "right"])
            self.rig.wait(lambda i=i: len(self.rig.forces) > before + i, "an answer")
        # The first sample after a desired force waits for the next one; the others are answered with the last one.
        if self._is_wished and (count > 1 or not self._is_fresh):
            self.await_command(lambda m: m.header.stamp.sec * 10**9 + m.header.stamp.nanosec == self.rig.stamp)
        self._is_fresh = False

    def request(self, force: float) -> float:
        """Requests a force of the left damper; returns the current that answers it."""
        self._requested = len(self.reports)  # repetitions of an older answer do not count
        self.send_wish(force, "left")
        self._is_wished = self._is_fresh = True
        return self.await_command(lambda m: m.desired_force[0] == force or np.isnan([force, m.desired_force[0]]).all())

    def send_wish(self, force: float, name: str) -> None:
        """Requests a force."""
        self.rig.send_raw(joint_states([name], np.array([START]), effort=np.array([[force]]))[0], WISH)

    def replaced(self) -> None:
        """Filters and models were replaced: there is no desired force now."""
        self._is_wished = self._is_fresh = False

    def await_command(self, condition) -> float:
        """Waits for the next message that meets a condition; returns its current. Older ones are not checked again."""

        def found() -> int | None:
            new = enumerate(self.reports[self._requested :], self._requested)
            return next((i for i, m in new if m.source[0] != IDLE and condition(m)), None)

        self.rig.wait(lambda: found() is not None, "the command")
        self._requested = found() + 1
        commanded = [m for m in self.reports[: self._requested] if m.source[0] != IDLE]
        self.rig.wait(lambda: len(self.currents) >= len(commanded), "the currents")
        assert self.currents[len(commanded) - 1] == commanded[-1].current[0]
        return commanded[-1].current[0]


def test_every_desired_force_is_answered_with_the_current_of_the_inverse_model(semi_active, shared, rig):
    shared(rig, **semi_active)
    node = Commanded(rig)
    node.drive(300)
    assert node.currents == []  # no force was desired
    forces = rig.forces[-1]
    requests = (450.0, 700.0, -200.0, 1e5)
    answers = [node.request(force) for force in requests]
    # The same samples offline.
    motion = np.array(node.motion)
    estimator = DamperEstimator(deployed(load_model(semi_active["model"], "left"), 60.0, 0.1))
    kinematics = estimator.block(START + MS * (1 + np.arange(motion.size)), motion, 0.5).kinematics
    inverse = InverseModel(load_model(semi_active["model"], "left"), (0.0, 2.0))
    looked = [inverse.solve(column, slope=True) for column in kinematics.block.T][-1]
    assert [inverse.again(force).current for force in requests] == answers
    assert answers[-1] == 2.0 and 0.0 < answers[0] < 2.0
    fields = ("force_min", "force_max", "dforce_dvelocity", "dforce_dcurrent")
    left, right = list(forces.name).index("left"), list(forces.name).index("right")
    assert tuple(getattr(forces, field)[left] for field in fields) == looked.reach
    assert np.isnan([getattr(forces, field)[right] for field in fields]).all()
    assert forces.force_min[left] < forces.force[left] < forces.force_max[left]


def test_samples_faster_than_desired_forces_are_answered_with_the_last_desired_force(semi_active, shared, rig):
    shared(rig, **semi_active)
    node = Commanded(rig)
    node.drive(250)
    first = node.request(500.0)
    node.drive(11)
    assert len(node.currents) == 11
    assert first != SAFE and SAFE not in node.currents


def test_the_safe_current_is_commanded_whenever_a_desired_force_cannot_be_trusted(semi_active, shared, rig):
    shared(rig, **semi_active)
    node = Commanded(rig)
    assert node.request(500.0) == SAFE  # no sample yet
    node.drive(50)
    assert node.request(500.0) == SAFE  # warming up
    node.drive(250)
    assert node.request(500.0) != SAFE
    assert node.request(float("nan")) == SAFE  # withdrawn
    assert node.request(500.0) != SAFE
    assert rig.set(desired_force_timeout=0.002) == (True, "")
    # A repetition of the last answer may still be on its way; from the first safe current on, all are safe.
    rig.wait(lambda: node.currents[-1] == SAFE, "the safe current when the request is old")
    before = len(node.currents)
    node.drive(20)
    assert len(node.currents) > before
    assert set(node.currents[before:]) == {SAFE}
    rig.wait(lambda: "the desired force was too old" in rig.message(": left command"), "the report")
    assert rig.set(desired_force_timeout=10.0, safe_current=0.75) == (True, "")
    node.drive(2)
    assert node.request(500.0) not in (SAFE, 0.75)
    assert rig.set(stale_after=0.05) == (True, "")
    rig.wait(lambda: node.currents[-1] == 0.75, "the safe current when the input stops")
    assert rig.set(stale_after=60.0) == (True, "")
    node.drive(5)
    assert node.request(500.0) != 0.75
    assert rig.transition(DEACTIVATE)
    rig.wait(lambda: node.currents[-1] == 0.75, "the safe current at the end")
    assert rig.transition(ACTIVATE)


def test_a_desired_force_that_no_current_can_follow_is_reported_with_the_reason(semi_active, shared, rig):
    shared(rig, **semi_active)
    node = Commanded(rig)
    node.send_wish(200.0, "right")
    rig.wait(lambda: rig.status(": right command") is not None, "the report")
    assert "was not fitted on recordings with a command" in rig.message(": right command")
    assert rig.status(": right command").level == b"\x01" and node.currents == []


def with_region(semi_active, **region: list[float]) -> None:
    """Another region of the left damper's fit."""
    path = Path(semi_active["model"]) / "left.yaml"
    fit = {"residual_stddev": 10.0, "region": {"velocity": [-9.0, 9.0], "command": [0.0, 2.0]} | region}
    path.write_text(yaml.safe_dump(yaml.safe_load(path.read_text()) | {"fit": fit}))


def test_outside_the_region_of_the_fit_desired_forces_are_followed_only_if_that_is_set(semi_active, shared, rig):
    with_region(semi_active, velocity=[-0.001, 0.001])
    shared(rig, **semi_active)
    node = Commanded(rig)
    node.drive(250)
    assert node.request(500.0) == SAFE
    assert rig.set(command_extrapolating=True) == (True, "")
    node.replaced()
    node.drive(250)
    assert node.request(500.0) != SAFE


def test_currents_stay_within_the_region_of_the_fit_unless_that_is_set(semi_active, shared, rig):
    with_region(semi_active, command=[0.0, 0.4])
    shared(rig, **semi_active)
    node = Commanded(rig)
    node.flows = 0.3
    node.drive(250)
    assert node.request(1e5) == 0.4  # while it extends
    assert rig.set(command_extrapolating=True) == (True, "")
    node.replaced()
    node.drive(250)
    assert node.request(-1e5) == 2.0


@pytest.mark.parametrize("safe", [0.0, SAFE])
def test_a_safe_current_outside_the_region_of_the_fit_does_not_keep_the_damper_passive(safe, semi_active, shared, rig):
    """The sent command flows, as in a car: after a cold start and after a gap of the input the node recovers."""
    with_region(semi_active, command=[0.5, 1.9])
    shared(rig, **semi_active | {"safe_current": safe})
    node = Commanded(rig)
    node.flows = None
    for gap in (0, 150 * MS):
        rig.stamp += gap
        node.request(500.0)
        for _ in range(40):
            node.flow(node.currents[-1])
            node.drive(10)
        assert node.request(500.0) != safe and node.currents[-1] >= 0.5
    assert rig.forces[-1].status[0] == GOOD


def test_limits_and_safe_current_that_contradict_the_model_are_refused(semi_active, shared, rig):
    shared(rig, **semi_active)
    taken, reason = rig.set(safe_current=2.5)
    assert not taken and "safe current 2.5 A lies outside the limits 0 to 2 A" in reason
    with_region(semi_active, command=[3.0, 4.0])
    taken, reason = rig.set(model=semi_active["model"])
    assert not taken and "nothing in common with the region 3 to 4 A" in reason


def test_after_a_silent_or_implausible_current_no_estimate_is_good_until_the_model_has_forgotten_it(
    semi_active, shared, rig
):
    shared(rig, **semi_active)
    node = Commanded(rig)
    node.drive(260)
    assert rig.forces[-1].status[0] == GOOD
    node.flows = None
    node.drive(300)
    assert rig.forces[-1].status[0] == DEGRADED and node.request(500.0) == SAFE
    node.flows = 0.5
    node.drive(300)
    assert rig.forces[-1].status[0] == GOOD and node.request(500.0) != SAFE
    for wild in (65535.0, 1e300, float("nan"), -50.0):
        before = rig.forces[-1].force[0]
        node.flow(wild)
        node.flows = None
        node.drive(1)
        assert rig.forces[-1].status[0] == DEGRADED and abs(rig.forces[-1].force[0] - before) < 100.0
        node.flows = 0.5
        node.drive(260)
        assert rig.forces[-1].status[0] == GOOD
    assert int(rig.fresh_values(": left")["command: values that cannot be"]) >= 4


def test_commands_are_reported_with_stamp_reason_and_sequence_number(semi_active, shared, rig):
    shared(rig, **semi_active)
    node = Commanded(rig)
    assert {m.source[0] for m in node.reports} == {IDLE} and not any(m.valid[0] for m in node.reports)
    assert [list(m.name) for m in node.reports[-2:]] == [["left"], ["left"]] and node.reports[-1].current[0] == SAFE
    node.drive(260)
    seen = len(node.reports)
    for force, source in ((500.0, REACHED), (1e5, LIMITED), (float("nan"), SAFE_OLD)):
        node.request(force)
        (report,) = [m for m in node.reports[seen:] if m.source[0] == source][-1:]
        assert report.header.stamp.sec * 10**9 + report.header.stamp.nanosec == rig.stamp
        assert report.valid[0] == (source in (REACHED, LIMITED)) and (
            source != REACHED or report.achievable_force[0] == pytest.approx(500.0, rel=0.01)
        )
    numbers = [m.sequence for m in node.reports]
    assert numbers == list(range(numbers[0], numbers[0] + len(numbers)))
    assert rig.set(stale_after=0.05) == (True, "")
    rig.wait(lambda: node.reports[-1].source[0] in (SAFE_OLD, SAFE_STOPPED), "the safe current")
    # The driver receives commands all the time.
    before = len(node.reports)
    rig.listen(1.0)
    assert len(node.reports) - before >= 8


def test_a_command_in_another_unit_is_sent_in_that_unit():
    """Milliamperes, and a table of the coil's effect."""
    from damper_estimator.node.force_follower import ForceFollower
    from damper_estimator.node.settings import DECLARATIONS
    from damper_estimator.signals import Channel

    class Rules:
        safe_current, desired_force_timeout, command_extrapolating = SAFE, 1.0, False
        command_lag, horizon, lead = 0.0, DECLARATIONS["horizon"].default, 0.0

    effects = {"name": "one", "effects": [{"viscous": {}}, {"semi_active_squash": {"gain": 600.0}}]}
    model = load_model_from(effects)
    table = ((0.0, 500.0, 2000.0), (0.0, 1.6, 2.0))
    channels = {
        "plain": Channel("/c", "data", limits=(0.0, 2.0)),
        "milli": Channel("/c", "data", scale=1e-3, limits=(0.0, 2000.0)),
        "table": Channel("/c", "data", table=table, limits=(0.0, 2000.0)),
    }
    sample = np.array([0.0, 0.0, 0.01, 0.3, 0.0, 0.5, np.nan, np.nan])
    sent = {}
    for name, channel in channels.items():
        follower = ForceFollower("one", deployed_with(model, channel), Rules)
        follower.update(sample)
        follower.request(700.0, 0.0)
        sent[name] = follower.command(GOOD, 0, 0.0, Rules).current
        assert follower.tally.followed == 1 and follower.sent == sent[name]
        assert follower.safe(0, Rules).current == SAFE
    assert 0.0 < sent["plain"] < 2.0
    assert sent["milli"] == pytest.approx(1e3 * sent["plain"])
    assert sent["table"] == pytest.approx(np.interp(sent["plain"], table[1], table[0]))


def load_model_from(content: dict):
    from damper_estimator.model.model_files import parse_model

    return parse_model(content, "test")


def deployed_with(model, channel):
    from damper_estimator.signals import default_signals

    return deployed(model, 60.0, 0.1, signals=replace(default_signals("one"), command=channel))
