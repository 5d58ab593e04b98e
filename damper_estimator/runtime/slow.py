"""Slow channels: the value at a sample, and whether it can be trusted.

The last value is held. It is *wrong* if it is not finite or implausible; then the last plausible value is held. The
channel is *silent* if no message came for longer than its maximum age, counted in the displacement's stamps from the
first sample after the message, so that live and offline agree. A command that usually comes often is silent sooner:
after ``PATIENCE`` of its usual intervals, but not before ``SHORTEST``. A model whose force depends on the channel
cannot be trusted while it is wrong or silent, nor afterwards for as long as the model remembers the value (`memory`).
"""

import numpy as np

from damper_estimator.compiled import compiled
from damper_estimator.runtime.damper_record import IMPLAUSIBLE, SILENT, UNKNOWN
from damper_estimator.signals.layout import COMMAND

PATIENCE = 5.0  # usual intervals
SHORTEST = 0.05  # s
SHORTEST_ACCELERATION = 1e7  # ns, of an accelerometer: the motion changes quickly
_FOLLOW = 0.1  # share of a new interval in the usual one


@compiled
def hold(record, stamp, row, value, arrived):
    """Updates one slow channel at a sample; returns whether it is wrong or silent.

    Args:
        record: of the damper; its ``held`` value is the model's input.
        stamp: ns, of the sample.
        row: of the channel, 0 for the command.
        value: the last received one, NaN before the first.
        arrived: number of messages so far.
    """
    if arrived != record["heard"][row]:
        if record["heard"][row] > 0:
            _learn(record, row, (stamp - record["since"][row]) / 1e9 / (arrived - record["heard"][row]))
        record["heard"][row], record["since"][row] = arrived, stamp
        if record["low"][row] <= value <= record["high"][row]:
            record["held"][row], record["wrong"][row] = value, 0
        else:
            record["wrong"][row] = 1
            record["counts"][IMPLAUSIBLE + row] += 1
    if arrived == 0:
        record["counts"][UNKNOWN + row] += 1
        return False
    if stamp < record["since"][row]:  # the clock was set back
        record["since"][row] = stamp
    silent = (stamp - record["since"][row]) / 1e9 > oldest(record, row)
    if silent:
        record["counts"][SILENT + row] += 1
    return record["wrong"][row] != 0 or silent


@compiled
def _learn(record, row, interval):
    if interval > 0.0 and record["interval"][row] <= 0.0:
        record["interval"][row] = interval
    elif interval > 0.0:
        record["interval"][row] += _FOLLOW * (min(interval, 2.0 * record["interval"][row]) - record["interval"][row])


@compiled
def oldest(record, row):
    """Age in s above which the channel counts as silent."""
    if record["adaptive"][row] == 0 or record["interval"][row] <= 0.0:
        return record["max_age"][row]
    return min(record["max_age"][row], max(PATIENCE * record["interval"][row], SHORTEST))


@compiled
def is_recent(record, stamp, acceleration_stamp):
    """Takes the stamp of the accelerometer's last value; returns whether that can be used at a sample. It is silent
    after ``PATIENCE`` of its usual intervals, not before ``SHORTEST_ACCELERATION`` and at the latest after the longest
    gap.
    """
    interval = acceleration_stamp - record["felt_last"]
    if interval != 0:
        if 0 < interval <= record["max_gap"]:
            usual = record["felt_interval"] if record["felt_interval"] > 0.0 else float(interval)
            record["felt_interval"] = usual + _FOLLOW * (min(float(interval), 2.0 * usual) - usual)
        record["felt_last"] = acceleration_stamp
    longest = float(record["max_gap"])
    if record["felt_interval"] > 0.0:
        longest = min(longest, max(PATIENCE * record["felt_interval"], SHORTEST_ACCELERATION))
    return abs(stamp - acceleration_stamp) <= longest


@compiled
def is_outside(record, row, value):
    """Whether a value lies outside the region of the fit, or is unknown to a model that needs it."""
    low, high = record["bounds"][COMMAND + row, 0], record["bounds"][COMMAND + row, 1]
    if np.isnan(value):
        # Without the command that it was fitted with a model is unusable; an unknown temperature matters only if the
        # force depends on it.
        return record["matters"][row] != 0 or (row == 0 and low > -np.inf)
    return value < low or value > high
