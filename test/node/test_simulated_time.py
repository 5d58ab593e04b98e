"""Simulated time, which goes on if its clock stops while messages arrive."""

from damper_estimator.node.simulated_time import PATIENCE, SimulatedTime


def test_it_is_that_of_the_clock_at_any_pace():
    time = SimulatedTime()
    for k in range(100):
        time.hear(10.0 * k)
        assert time.seconds(0.1 * k, 10.0 * k) == 0.1 * k and not time.has_stopped


def test_it_stands_still_in_a_pause():
    time = SimulatedTime()
    time.hear(5.0)
    time.seconds(7.0, 5.0)
    assert time.seconds(7.0, 500.0) == 7.0


def test_it_goes_on_if_messages_arrive_without_a_clock_and_stays_on_the_way():
    time = SimulatedTime()
    time.seconds(0.0, 50.0)
    time.hear(50.0 + 0.9 * PATIENCE)
    assert time.seconds(0.0, 50.0 + PATIENCE) == 0.0
    time.hear(50.0 + 2.0 * PATIENCE)
    assert time.has_stopped
    assert time.seconds(0.0, 55.0) == 5.0 and time.seconds(0.0, 60.0) == 10.0  # no message since
    assert time.seconds(4.0, 61.0) == 4.0 and not time.has_stopped
