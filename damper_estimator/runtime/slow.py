"""Slow channels: which value holds at a sample, and whether it can be trusted.

The last value that arrived holds. It is *wrong* where it is not finite or beyond what the channel can be; then the
last value that could be goes on. It is *silent* where no message came for longer than the channel's maximum age,
counted in the displacement's stamps from the first sample that followed the message, so that live and off line agree.
A command that usually comes often is silent sooner: after ``PATIENCE`` of its usual intervals, but not before
``SHORTEST``.
A model whose force depends on the channel cannot be trusted while it is wrong or silent, nor for as long afterwards as
the model remembers the value (`memory`).
"""

import numpy as np

from damper_estimator.compiled import compiled
from damper_estimator.runtime.record import IMPLAUSIBLE, SILENT
from damper_estimator.signals.layout import COMMAND

PATIENCE = 5.0  # usual intervals
SHORTEST = 0.05  # s
SHORTEST_FELT = 1e7  # ns, of an accelerometer: the motion that it should have measured is soon another one
_FOLLOW = 0.1  # share of a new interval in the usual one


@compiled
def hold(own, stamp, row, value, arrived):
    """Takes what is known of one slow channel at a sample; whether it is wrong or silent.

    Args:
        own: the damper's record; its ``held`` value is what the model is to see.
        stamp: ns, of the sample.
        row: of the channel, 0 for the command.
        value: that arrived last, NaN before the first.
        arrived: how many messages have arrived.
    """
    if arrived != own["heard"][row]:
        if own["heard"][row] > 0:
            _learn(own, row, (stamp - own["since"][row]) / 1e9 / (arrived - own["heard"][row]))
        own["heard"][row], own["since"][row] = arrived, stamp
        if own["low"][row] <= value <= own["high"][row]:
            own["held"][row], own["wrong"][row] = value, 0
        else:
            own["wrong"][row] = 1
            own["counts"][IMPLAUSIBLE + row] += 1
    if arrived == 0:
        return False
    if stamp < own["since"][row]:  # the clock was set back
        own["since"][row] = stamp
    silent = (stamp - own["since"][row]) / 1e9 > oldest(own, row)
    if silent:
        own["counts"][SILENT + row] += 1
    return own["wrong"][row] != 0 or silent


@compiled
def _learn(own, row, interval):
    if interval > 0.0 and own["interval"][row] <= 0.0:
        own["interval"][row] = interval
    elif interval > 0.0:
        own["interval"][row] += _FOLLOW * (min(interval, 2.0 * own["interval"][row]) - own["interval"][row])


@compiled
def oldest(own, row):
    """Age in s from which on the channel counts as silent."""
    if own["adaptive"][row] == 0 or own["interval"][row] <= 0.0:
        return own["max_age"][row]
    return min(own["max_age"][row], max(PATIENCE * own["interval"][row], SHORTEST))


@compiled
def is_recent(own, stamp, felt_at):
    """Takes the stamp of the accelerometer's last value; whether that can be used at a sample: it is silent after
    ``PATIENCE`` of its usual intervals, not before ``SHORTEST_FELT`` and at the latest after the longest gap."""
    interval = felt_at - own["felt_last"]
    if interval != 0:
        if 0 < interval <= own["max_gap"]:
            usual = own["felt_interval"] if own["felt_interval"] > 0.0 else float(interval)
            own["felt_interval"] = usual + _FOLLOW * (min(float(interval), 2.0 * usual) - usual)
        own["felt_last"] = felt_at
    oldest_felt = float(own["max_gap"])
    if own["felt_interval"] > 0.0:
        oldest_felt = min(oldest_felt, max(PATIENCE * own["felt_interval"], SHORTEST_FELT))
    return abs(stamp - felt_at) <= oldest_felt


@compiled
def is_outside(own, row, value):
    """Whether a value lies outside the region of the fit, or is unknown to a model that needs it."""
    low, high = own["bounds"][COMMAND + row, 0], own["bounds"][COMMAND + row, 1]
    if np.isnan(value):
        # Without the command that it was fitted with a model says nothing; an unknown temperature is no proof of
        # another one where the force does not depend on it.
        return own["matters"][row] != 0 or (row == 0 and low > -np.inf)
    return value < low or value > high
