"""Whether a reported current can be the one that flowed: against the node's commands, and the sample's age."""

import numpy as np
import pytest

from damper_estimator.node.current_check import CurrentCheck

LAG, STEP = 0.02, 0.002  # s
WIDTH = 1.6  # A
CODED = {
    "stuck": lambda i, flowing: 0.9,
    "thousandth": lambda i, flowing: flowing[i] / 1000.0,
    "dead": lambda i, flowing: 0.0,
}


def driven(report, lag: float = LAG, seconds: float = 2.0, coil: float = 0.003) -> list[bool]:
    """Whether each report is contradicted: commands that swing, a coil that follows, and what ``report`` makes of the
    currents (n,) at sample i."""
    time = np.arange(0.0, seconds, STEP)
    commands = 0.8 + 0.7 * np.sin(12.0 * time) * np.sign(np.sin(31.0 * time))
    current, flowing, found = CurrentCheck(WIDTH, lag), [commands[0]], []
    for i, (now, command) in enumerate(zip(time, commands, strict=True)):
        flowing.append(flowing[-1] + (1.0 - np.exp(-STEP / coil)) * (command - flowing[-1]))
        current.note_report(report(i, flowing), now, 1)
        found.append(current.is_contradicted)
        current.note_command(command, now)
    return found


@pytest.mark.parametrize("coil", [0.001, 0.003, 0.006])
def test_a_driver_that_follows_within_the_lag_is_trusted(coil):
    random = np.random.default_rng(1)
    assert not any(driven(lambda i, flowing: flowing[i] + 0.01 * random.standard_normal(), coil=coil))


@pytest.mark.parametrize("fault", CODED)
def test_a_current_that_contradicts_the_commands_is_found_every_time(fault):
    found = np.flatnonzero(driven(CODED[fault]))
    assert found.size > 100
    # The status lasts 0.2 s: the estimate is never trusted again for long.
    assert np.diff(found).max() * STEP < 0.3 and found[0] * STEP < 0.3


def test_a_current_that_is_later_than_the_lag_is_found():
    assert sum(driven(lambda i, flowing: flowing[max(i - 25, 0)])) > 50


def test_no_lag_compares_nothing():
    assert not any(driven(CODED["stuck"], lag=0.0))


def test_a_damper_that_the_node_does_not_command_is_not_judged():
    current = CurrentCheck(WIDTH, LAG)
    current.note_report(5.0, 0.0, 1)
    assert not current.is_contradicted
    for i in range(100):
        current.note_command(0.2, i * STEP)
    current.note_report(1.0, 0.2, 1)
    assert current.is_contradicted and "command_lag" in current.complaint()
    current.note_report(1.0, 1.0, 1)  # commands have stopped since
    assert not current.is_contradicted and not current.complaint()


def test_a_comparison_needs_the_commands_of_a_whole_lag():
    current = CurrentCheck(WIDTH, LAG)
    current.note_command(1.0, 0.0)
    current.note_report(0.2, 0.01, 1)
    assert not current.is_contradicted
    current.note_report(0.2, 0.03, 1)
    assert current.is_contradicted


def test_a_current_that_came_long_after_the_sample_does_not_belong_to_it():
    current = CurrentCheck(WIDTH, LAG)
    current.note_report(1.0, 0.0, 1_000_000_000)
    assert not current.is_ahead(960_000_000, 0.0) and current.is_ahead(940_000_000, 0.0)
    assert not current.is_ahead(940_000_000, 0.02)  # all samples take so long
    assert not current.is_ahead(0, float("inf"))  # another clock: nothing is judged
