"""Motions whose kinematics are exact, and the forces of some effects on them."""

import numpy as np

from damper_estimator.effects.discovery import find_effect
from damper_estimator.model import make_element
from damper_estimator.model.damper_model import DamperModel
from damper_estimator.signals.layout import COMMAND, DT, ROWS, TEMPERATURE, A, T, V, X


def sweep(amplitude=0.03, frequency=2.0, seconds=1.0, rate=1000, command=np.nan, temperature=np.nan):
    """Exact kinematics of a sine."""
    time = np.arange(round(seconds * rate) + 1) / rate
    omega = 2 * np.pi * frequency
    block = np.full((ROWS, time.size), np.nan)
    block[T], block[DT] = time, np.diff(time, prepend=0.0)
    block[X], block[V] = amplitude * np.sin(omega * time), amplitude * omega * np.cos(omega * time)
    block[A] = -(omega**2) * block[X]
    block[COMMAND], block[TEMPERATURE] = command, temperature
    return block


def entry(name, path=(), **values):
    """The entry of an effect with these values and settings."""
    return make_element(find_effect(name), values, path)


def force(block, *entries):
    """(n,) N of a model with these entries."""
    return DamperModel("m", "", entries).force(block)


def standing(places):
    """At rest in places (n,) m, a sample in each."""
    block = np.full((ROWS, places.size), np.nan)
    block[T], block[DT] = np.arange(places.size) / 1000.0, 1e-3
    block[X], block[V], block[A] = places, 0.0, 0.0
    return block
