"""Fault kinds of the node, its publishers, its clock and the drivers: generators over samples."""

import signal
import time
from collections.abc import Iterator

import numpy as np
from soak_faults import Fault, on_node
from soak_node import DESIRED_FORCE, DISPLACEMENT
from soak_plant import NAMES, SAFE
from soak_wire import States, joint_state

WAITED = "the node was stopped, and the waiting messages have no order"
DISCOVERY = 0.2  # s from a new publisher to its first message
HEARTBEAT = 3.0  # s, of the middleware
CONFIGURE, CLEAN_UP, ACTIVATE, DEACTIVATE = 1, 2, 3, 4


def _wait(fault: Fault, campaign) -> Iterator[None]:
    while campaign.time < fault.until:
        yield


def _answered(campaign, future) -> Iterator[None]:
    while not campaign.node.is_answered(future):
        yield


@on_node("clock back")
def _(fault: Fault, campaign) -> Iterator[None]:
    shift = int(fault.random.uniform(2e6, 4e9) if fault.chance(0.7) else fault.random.uniform(2e6, 9e7))
    campaign.shift -= shift
    yield from _wait(fault, campaign)
    campaign.shift += shift


@on_node("clock forward")
def _(fault: Fault, campaign) -> Iterator[None]:
    shift = int(fault.random.uniform(2e7, 4e9))
    campaign.shift += shift
    yield from _wait(fault, campaign)
    campaign.shift -= shift


@on_node("second publisher", 0.3, 1.0, needs="damper_estimator.node.sequence_numbers", is_alone=True)
def _(fault: Fault, campaign) -> Iterator[None]:
    publish = campaign.node.second_publisher(DISPLACEMENT)
    begin = campaign.time + DISCOVERY
    while campaign.time < begin:
        yield
    while campaign.time < fault.until:
        stamp = campaign.stamp + campaign.step_ns // 2
        values = (0.02 * np.sin(7.0 * campaign.time + np.arange(4.0))).tolist()
        other = States(list(NAMES), values, stamp, foreign=True, truth=campaign.truth, undisturbed=campaign.truth)
        campaign.send_states(other, publish)
        yield
    campaign.node.end_second_publisher(DISPLACEMENT)
    campaign.counters.forget()  # the messages of two publishers race


@on_node("publisher restart")
def _(fault: Fault, campaign) -> Iterator[None]:
    campaign.settle()
    campaign.node.restart_publisher(DISPLACEMENT)
    yield


@on_node("desired force for a stranger")
def _(fault: Fault, campaign) -> Iterator[None]:
    while campaign.time < fault.until:
        campaign.node.publish(DESIRED_FORCE, joint_state(["stranger", ""], campaign.stamp, (), [1e9, 1.0]))
        yield


@on_node("malformed slow messages")
def _(fault: Fault, campaign) -> Iterator[None]:
    while campaign.time < fault.until:
        name = NAMES[fault.random.integers(len(NAMES))]
        campaign.node.publish(f"/suspension/{name}/temperature", b"\0\1\0\0" + fault.random.bytes(5))
        campaign.node.publish(DESIRED_FORCE, b"\0\1\0\0" + fault.random.bytes(9))
        yield


@on_node("driver restart")
def _(fault: Fault, campaign) -> Iterator[None]:
    for k in fault.dampers:
        campaign.drivers[k].is_on = False
    yield from _wait(fault, campaign)
    for k in fault.dampers:
        campaign.drivers[k].is_on = True


@on_node("process stopped", 0.2, 2.0)
def _(fault: Fault, campaign) -> Iterator[None]:
    campaign.is_held, stopped = True, time.monotonic()
    campaign.node.signal(signal.SIGSTOP)
    yield from _wait(fault, campaign)
    campaign.node.signal(signal.SIGCONT)
    campaign.judge.waited(campaign.time, stopped, WAITED)
    campaign.is_held = False
    # Messages of a slow topic lost by a full socket buffer return with the next heartbeat of the reliable transport.
    end = campaign.time + HEARTBEAT
    while campaign.time < end:
        campaign.judge.expect_nothing(range(len(NAMES)), campaign.time)
        yield


@on_node("parameters: model again", is_alone=True)
def _(fault: Fault, campaign) -> Iterator[None]:
    campaign.judge.pause(True, campaign.time)
    yield from _answered(campaign, campaign.node.set(model=campaign.node.parameters["model"]))
    campaign.judge.pause(False, campaign.time)
    campaign.counters.forget()


@on_node("parameters: refused")
def _(fault: Fault, campaign) -> Iterator[None]:
    wrong = [{"safe_current": 3.0}, {"model": "/nowhere.yaml"}, {"max_gap": -1.0}, {"cutoff": float("nan")},
             {"record": "/tmp"}, {"signals": "/nowhere.yaml"}]  # fmt: skip
    change = wrong[fault.random.integers(len(wrong))]
    future = campaign.node.set(**change)
    yield from _answered(campaign, future)
    if future.result().result.successful:
        campaign.judge.violate(f"{change} was accepted", (fault.kind.name,), campaign.time)


@on_node("parameters: safe current", 0.2, 1.0)
def _(fault: Fault, campaign) -> Iterator[None]:
    campaign.judge.is_safe_changed = True
    yield from _answered(campaign, campaign.node.set(safe_current=0.4))
    yield from _wait(fault, campaign)
    yield from _answered(campaign, campaign.node.set(safe_current=SAFE))
    end = campaign.time + 0.3
    while campaign.time < end:
        yield
    campaign.judge.is_safe_changed = False


@on_node("parameters: timeouts")
def _(fault: Fault, campaign) -> Iterator[None]:
    yield from _answered(campaign, campaign.node.set(stale_after=0.05, desired_force_timeout=0.05, max_age=0.3))
    yield from _wait(fault, campaign)
    yield from _answered(campaign, campaign.node.set(stale_after=0.1, desired_force_timeout=0.1, max_age=0.5))


def _change(campaign, transition: int) -> Iterator[None]:
    future = campaign.node.change(transition)
    yield from _answered(campaign, future)
    if not future.result().success:
        campaign.judge.violate(f"transition {transition} was refused", ("lifecycle",), campaign.time)


@on_node("deactivated and activated", 0.1, 0.5, is_alone=True)
def _(fault: Fault, campaign) -> Iterator[None]:
    campaign.rest(True)
    yield from _change(campaign, DEACTIVATE)
    yield from _wait(fault, campaign)
    campaign.expect_safe("deactivation")
    yield from _change(campaign, ACTIVATE)
    campaign.rest(False)
    campaign.counters.forget()


@on_node("cleaned up and configured", 0.1, 0.3, is_alone=True)
def _(fault: Fault, campaign) -> Iterator[None]:
    campaign.rest(True)
    for transition in (DEACTIVATE, CLEAN_UP):
        yield from _change(campaign, transition)
    yield from _wait(fault, campaign)
    campaign.expect_safe("clean-up")
    campaign.take_turns()
    yield from _answered(campaign, campaign.node.set(signals=campaign.node.parameters["signals"]))
    for transition in (CONFIGURE, ACTIVATE):
        yield from _change(campaign, transition)
    campaign.node.find()
    campaign.rest(False)
    campaign.counters.forget()


@on_node("disk full", 0.6, 1.5)
def _(fault: Fault, campaign) -> Iterator[None]:
    campaign.node.limit_files(1000)
    yield from _wait(fault, campaign)
    campaign.node.limit_files(-1)


def _ended_by(name: str, number: int, **more: object) -> None:
    @on_node(name, is_alone=True, is_end=True, **more)
    def _(fault: Fault, campaign) -> Iterator[None]:
        campaign.rest(True)
        campaign.node.signal(number)
        status = campaign.node.ended()
        campaign.take_commands()
        if number != signal.SIGKILL:
            campaign.expect_safe(name)
            if status:
                campaign.judge.violate(f"exit status {status}", (name,), campaign.time)
        campaign.take_turns()
        campaign.restart()
        yield


_ended_by("process killed", signal.SIGKILL)
for _signal in ("SIGTERM", "SIGINT", "SIGHUP"):
    _ended_by(f"process ended by {_signal}", getattr(signal, _signal), needs="damper_estimator.node.stopping")
