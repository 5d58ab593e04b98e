"""Sequence numbers: every loss counts once, two publishers of one damper are detected, others are not."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from damper_estimator.node.sequence_numbers import CONFIRMING, DoubleSenders, Losses

FRONT, REAR, BOTH = frozenset({"front"}), frozenset({"rear"}), frozenset({"front", "rear"})
SILENCE = 0.1


def counted(numbers, matched=1) -> int:
    losses = Losses()
    losses.matched(matched)
    for number in numbers:
        losses.take(int(number))
    return losses.lost


@settings(deadline=None)
@given(start=st.integers(1, 10**6), kept=st.lists(st.booleans(), max_size=200))
def test_every_message_missing_between_two_of_one_publisher_is_counted(start, kept):
    numbers = start + np.flatnonzero(kept)
    assert counted(numbers) == (numbers[-1] - numbers[0] + 1 - numbers.size if numbers.size else 0)


@settings(deadline=None)
@given(seed=st.integers(0, 10**6), starts=st.lists(st.integers(1, 3000), min_size=2, max_size=4))
def test_every_missing_message_of_several_publishers_is_counted(seed, starts):
    """Any order and any loss between the first messages, which no other publisher explains, and two rounds of all."""
    random = np.random.default_rng(seed)
    kept = [start + np.append(0, np.flatnonzero(random.random(200) < 0.7) + 1) for start in starts]
    first, order = sorted((numbers[0] for numbers in kept), reverse=True), []
    rest = [list(numbers[1:]) for numbers in kept]
    while any(rest):
        waiting = [numbers for numbers in rest if numbers]
        order.append(waiting[random.integers(len(waiting))].pop(0))
    rounds = [numbers[-1] + k for k in (1, 2) for numbers in kept]
    assert counted([*first, *order, *rounds], matched=len(starts)) == sum(
        numbers[-1] - numbers[0] + 1 - numbers.size for numbers in kept
    )


def test_restarted_or_earlier_publishers_are_no_loss():
    assert counted([*range(1, 100), *range(1, 50)]) == 0
    assert counted([*range(1, 100), *range(500, 600)], matched=2) == 0
    assert counted([*range(1, 100), *range(500, 600)], matched=1) == 400
    assert counted([5000, 17, 5001, 18, 19, 5002], matched=2) == 0


def suspects(messages, silence=SILENCE) -> tuple[list[bool], dict[str, int]]:
    """Messages as (number, dampers, s)."""
    senders = DoubleSenders()
    found = [senders.take(number, dampers, now, silence) for number, dampers, now in messages]
    return found, senders.confirmed


def interleaved(first, second, rates=(1000, 1000), dampers=(FRONT, FRONT), seconds=1.0, seed=0):
    """Messages of two publishers from these numbers on, in order of time, half of them lost."""
    random, found = np.random.default_rng(seed), []
    for start, rate, names in zip((first, second), rates, dampers, strict=True):
        times = np.arange(int(seconds * rate)) / rate + random.uniform(0.0, 1.0 / rate)
        found += [(start + i, names, float(t)) for i, t in enumerate(times) if random.random() < 0.5]
    return sorted(found, key=lambda message: message[2])


@pytest.mark.parametrize("second", [1, 1000, 1001, 5_000_000])
@pytest.mark.parametrize("dampers", [(FRONT, FRONT), (BOTH, FRONT), (FRONT, BOTH)])
def test_two_publishers_of_one_damper_are_found_with_any_sequence_numbers(second, dampers):
    found, confirmed = suspects(interleaved(1000, second, dampers=dampers))
    assert confirmed["front"] > 50 and "rear" not in confirmed
    assert max(np.diff(np.flatnonzero(found))) < 40  # much more often than a fault is remembered


def test_a_slow_second_publisher_is_found():
    _, confirmed = suspects(interleaved(7_000, 5, rates=(1000, 4), seconds=20.0))
    assert confirmed["front"] > 20


@settings(deadline=None)
@given(seed=st.integers(0, 1000), second=st.integers(1, 3000))
def test_publishers_of_different_dampers_are_never_suspect(seed, second):
    found, confirmed = suspects(interleaved(1000, second, dampers=(FRONT, REAR), seed=seed))
    assert not any(found) and not confirmed


def test_one_publisher_that_sends_its_dampers_in_turn_is_never_suspect():
    assert not any(suspects([(i, (FRONT, REAR, BOTH)[i % 3], i / 1000) for i in range(1, 2000)])[0])


def test_a_restarted_publisher_is_never_reported():
    after_silence = [
        *((i, FRONT, i / 1000) for i in range(1, 500)),
        *((i, FRONT, 0.7 + i / 1000) for i in range(1, 900)),
    ]
    assert not any(suspects(after_silence)[0])
    at_once = [*((i, FRONT, i / 1000) for i in range(1, 500)), *((i, FRONT, 0.5 + i / 1000) for i in range(1, 900))]
    found, confirmed = suspects(at_once)
    assert sum(found) == 1 and not confirmed  # doubtful, since another one continues without a silence
    often = [(i, FRONT, k * (CONFIRMING + 1.0) + i / 1000) for k in range(5) for i in range(1, 500)]
    assert not suspects(often)[1]
