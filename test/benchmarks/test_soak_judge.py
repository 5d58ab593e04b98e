"""The judge of the soak: its filter, its packing of messages and its rule are correct, and it detects violations."""

import time
from dataclasses import replace

import numpy as np
import pytest
import soak_node_faults  # noqa: F401
import soak_slow_faults  # noqa: F401
from scipy.signal import butter, lsim
from soak_faults import KINDS
from soak_judge import LATCH, Judge
from soak_plant import LIMITS, NAMES, SAFE, Driver, Road
from soak_rounds import Rounds
from soak_rule import MAX_GAP, SETTLING, Current, Displacement, Slow
from soak_truth import Filter
from soak_wire import Commands, Forces, States, commands_in, forces_in, joint_state, number, stamped

from damper_estimator.node.command_message import CommandMessages
from damper_estimator.node.force_follower import Command
from damper_estimator.recordings import accelerations, damper_forces, floats, joint_states, temperatures
from damper_estimator.runtime import FIELDS

STAMP, MS = 1_700_000_000_123_456_789, 1_000_000
SIGMA = 10.0


def test_the_filter_is_the_butterworth_of_the_definitions():
    values = np.cumsum(np.random.default_rng(1).standard_normal(300))
    low_pass = Filter(60.0, 0.002, values[:1])
    filtered = [low_pass.take(values[i : i + 1])[0] for i in range(1, values.size)]
    reference = lsim(butter(3, 2.0 * np.pi * 60.0, analog=True), values - values[0], 0.002 * np.arange(values.size))[1]
    assert np.allclose(filtered, reference[1:] + values[0], atol=1e-9)


def test_messages_are_packed_in_the_standard_way():
    stamps, names = np.array([STAMP]), ["front_left", "b"]
    assert joint_state(names, STAMP, [1.0, 2.0]) == joint_states(names, stamps, position=np.array([[1.0, 2.0]]))[0]
    assert joint_state(names, STAMP, (), [1.0, 2.0]) == joint_states(names, stamps, effort=np.array([[1.0, 2.0]]))[0]
    assert number(3.5) == floats(np.array([3.5]))[0]
    assert stamped(STAMP, 3.5, 0.0) == temperatures(stamps, np.array([3.5]))[0]
    assert stamped(STAMP, 0.0, 0.0, 3.5, 0.0, 0.0, 0.0) == accelerations(stamps, np.array([3.5]))[0]
    fields = {name: np.array([[i, i + 0.5]]) for i, name in enumerate(FIELDS)} | {
        "status": np.array([[0, 3]], np.uint8)
    }
    parsed = forces_in(damper_forces(names, stamps, fields)[0])
    assert parsed == Forces(STAMP, names, (3.0, 3.5), (4.0, 4.5), b"\0\3")


def test_a_round_repeats_with_its_seed_and_number():
    kinds = list(KINDS.values())
    drawn = [[(f.kind.name, f.dampers, f.until) for f in Rounds(kinds, 5, 17).next(1.0, True, True)] for _ in range(2)]
    assert drawn[0] == drawn[1] and drawn[0]
    rounds = Rounds(kinds, 5, 0)
    seen = {rounds.next(0.0, True, True)[0].kind.name for _ in kinds}
    assert seen == set(KINDS)


def test_stamped_commands_are_parsed_and_compared_with_the_sent_samples():
    command = Command("rear_left", STAMP, 1.0, 300.0, 310.0, 0)
    (data,) = CommandMessages().of([command, command._replace(damper="b", current=SAFE, source=3)])
    parsed = commands_in(data)
    assert parsed == Commands(STAMP, 1, ["rear_left", "b"], (1.0, SAFE), b"\1\0")
    judge = judged(displacement=np.nan)
    late = STAMP + 2 * MS * 990  # soon after the non-finite sample
    followed = Commands(late, 1, ["rear_left"], (1.0,), b"\1")
    judge.violations.clear()
    judge.stamped_command(followed, 2.0)
    assert any("followed although: not finite" in what for what in judge.violations.values())
    judge.violations.clear()
    judge.stamped_command(replace(followed, stamp=STAMP + 200 * MS, sequence=2), 2.0)
    assert not judge.violations
    judge.stamped_command(replace(followed, sequence=2, valid=b"\0"), 2.0)
    assert len(judge.violations) == 2


def test_every_channel_has_kinds_of_faults():
    assert len(KINDS) >= 30
    channels = (
        "displacement",
        "current",
        "temperature",
        "pressure",
        "acceleration",
        "gauge",
        "desired force",
        "parameters",
        "process",
    )
    assert all(any(name.startswith(channel) for name in KINDS) for channel in channels)
    assert all(KINDS[f"{name} stuck"].excuse for name in ("displacement", "temperature"))
    assert not KINDS["current stuck"].excuse  # its commands reveal it


@pytest.mark.parametrize(
    ("step", "value", "reason"),
    [(2, np.nan, "not finite"), (2, 1e9, "not finite"), (-10, 0.0, "older stamp"), (2, 0.05, "jump"), (50, 0.0, "late"),
     (200, 0.0, "reset"), (-200, 0.0, "reset")],
)  # fmt: skip
def test_after_a_displacement_fault_nothing_may_be_good_for_a_fifth_of_a_second(step, value, reason):
    rule, stamp = Displacement(2 * MS), STAMP
    for i in range(200):
        stamp += 2 * MS
        assert rule.take(stamp, 1e-5 * (i % 2))
    assert not rule.verdict(stamp)
    rule.take(stamp + step * MS, value)
    stamp = rule.last
    assert rule.verdict(stamp + 2 * MS) == reason
    assert not rule.verdict(stamp + SETTLING) and MAX_GAP < SETTLING


def test_a_channel_must_be_plausible_and_recent():
    slow = Slow(0.0, 2.0, 0.5)
    assert not slow.verdict(1.0)  # never received: left to the estimator
    slow.take(1.0, 1.0)
    assert not slow.verdict(1.4) and slow.verdict(1.6) == "silent"
    slow.take(np.nan, 2.0)
    assert slow.verdict(2.1) == "impossible value"
    slow.take(1.0, 2.2)
    assert not slow.verdict(2.3)


@pytest.mark.parametrize(("before", "reason"), [(6000, "stands still"), (1000, "")])
def test_a_constant_displacement_is_a_fault_if_its_noise_was_observed(before, reason):
    rule = Displacement(2 * MS)
    for i in range(before + 100):
        rule.take(STAMP + 2 * MS * i, 0.01 + 1e-5 * (min(i, before) % 2))
        is_still = i > before + 50
        assert rule.is_unknown == (is_still and not reason)
        if i > 200:
            assert rule.verdict(STAMP + 2 * MS * i) == (reason if is_still else "")


def test_two_equal_values_around_a_gap_do_not_stand_still():
    rule, stamp = Displacement(2 * MS), STAMP
    for i in range(6000):
        stamp += 2 * MS
        rule.take(stamp, 0.01 + 1e-5 * (i % 2))
    for after in (MAX_GAP - MS, MAX_GAP + MS):
        rule.take(stamp + after, 0.01 + 1e-5 * (5999 % 2))
        assert rule.verdict(rule.last) == "late"


def test_a_current_is_compared_with_the_recent_commands():
    current = Current(0.0, 1.6)
    assert not current.is_contradicted(0.0)
    for i in range(100):
        now = 0.002 * i
        current.command(0.2 if i < 50 else 1.4, now)
        current.take(0.2, now)
    assert not current.is_contradicted(0.13)
    for i in range(100, 150):
        current.command(1.4, 0.002 * i)
        current.take(0.2, 0.002 * i)
    assert current.is_contradicted(0.3) and not current.is_contradicted(1.0)


def judged(error=0.0, undisturbed=0.0, status=0, displacement=0.0, seconds=2.0, excuse=""):
    """A judge after answers with the same ``error``, the last of them after a fault."""
    judge = Judge(2 * MS, [True] * 4, np.full(4, SIGMA))
    judge.pause(False, 0.0)
    count = round(seconds / 0.002)
    for i in range(count):
        if excuse:
            judge.excuse(0, excuse, 1e9)
        stamp, now = STAMP + 2 * MS * i, 0.002 * i
        values = [displacement if i == count - 20 else 1e-5 * (i % 2)] * 4
        m = States(list(NAMES), values, stamp, truth=np.zeros(4), undisturbed=np.full(4, undisturbed))
        judge.hear(m, now, 0.0, ("kind",), time.monotonic())
        shown = status if i > 150 else 1
        judge.answer(Forces(stamp, list(NAMES), (error,) * 4, (SIGMA,) * 4, bytes([shown] * 4)))
    return judge


def test_an_error_of_three_standard_deviations_is_the_limit():
    assert not judged(error=29.0).violations
    assert "GOOD but off (kind)" in judged(error=31.0).violations
    assert "GOOD but off (kind)" in judged(error=31.0, undisturbed=31.0).violations
    assert judged(error=31.0, status=3, seconds=0.5).tallies["kind"].good == 0


def test_an_excuse_is_counted_and_applies_only_to_its_damper():
    judge = judged(error=50.0, excuse="nobody could know")
    assert judge.excuses["nobody could know"] > 0
    assert all("front_left" not in violation for violation in judge.violations.values())
    assert judge.violations


def test_a_forbidden_good_is_detected():
    assert any("GOOD although: not finite" in what for what in judged(displacement=np.nan).violations.values())


def test_a_status_that_does_not_recover_is_detected():
    assert not judged(status=3, seconds=0.1 + LATCH).violations
    assert any("not GOOD again" in what for what in judged(status=3, seconds=3.0).violations.values())


def test_a_stuck_sensor_with_uncertain_noise_may_be_good_or_not():
    judge = Judge(2 * MS, [True] * 4, np.full(4, SIGMA))
    judge.pause(False, 0.0)
    for i in range(1500):
        stamp, now = STAMP + 2 * MS * i, 0.002 * i
        is_stuck = 250 <= i < 1250
        values = [0.0 if is_stuck else 1e-5 * (1 + i % 2)] * 4
        m = States(list(NAMES), values, stamp, truth=np.zeros(4), undisturbed=np.zeros(4))
        judge.hear(m, now, 0.0, ("kind",), time.monotonic())
        status = 1 if i < 100 else 3 * (255 <= i < 1350)  # the node learned the noise within half a second
        judge.answer(Forces(stamp, list(NAMES), (0.0,) * 4, (SIGMA,) * 4, bytes([status] * 4)))
    assert not judge.violations


def test_commands_are_checked_against_limits_and_the_safe_current():
    judge = judged()
    judge.command(0, LIMITS[1] + 0.01, 2.0)
    assert any("outside the limits" in what for what in judge.violations.values())
    judge = judged()
    judge.desired_at = [2.0] * 4
    for k in range(4):
        judge.command(k, 1.0, 2.0)
    judge.watch_loop(2.0, [1.0] * 4, (), False)
    assert not judge.violations
    judge.watch_loop(2.5, [1.0, SAFE, SAFE, SAFE], (), False)
    assert len(judge.violations) == 1


def test_the_driver_sets_its_safe_current_when_commands_stop():
    driver = Driver()
    driver.take(9.0, 0.0)
    for _ in range(50):
        driver.step(0.05, 0.002)
    assert driver.current == pytest.approx(LIMITS[1])
    for _ in range(50):
        driver.step(0.5, 0.002)
    assert driver.current == pytest.approx(SAFE)


def test_the_road_is_continuous():
    whole, parts = Road(3), Road(3)
    long = whole.stretch(4000)
    first = parts.stretch(2000)
    assert np.allclose(np.concatenate([first, parts.stretch(2000)[1:]]), long)
