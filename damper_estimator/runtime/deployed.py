"""A model as it runs on a vehicle: checked, with everything that the line has to know of it."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from damper_estimator.errors import InputError
from damper_estimator.model import DamperModel
from damper_estimator.runtime.memory import memory, settling
from damper_estimator.runtime.record import SLOW, fresh_record
from damper_estimator.runtime.status import bounds_of
from damper_estimator.signals import DamperSignals, default_signals
from damper_estimator.signals.fusion import Fusion
from damper_estimator.signals.layout import COMMAND

# What a slow channel can be where neither map nor fit say more: A, deg C, Pa; how old its value may be (s); and whether
# several of its usual intervals are too old already.
_POSSIBLE = {"command": (-1e3, 1e3), "temperature": (-60.0, 300.0), "pressure": (0.0, 1e8)}
_MAX_AGE = {"command": 0.5, "temperature": 30.0, "pressure": 1.0}
_ADAPTIVE = {"command": True, "temperature": False, "pressure": True}
_STDDEVS = ("force_stddev", "residual_stddev")  # of a fit; the first that is there counts
_BEYOND_LIMITS = 0.1  # of their width; a measured current is noisy and overshoots
_BEYOND_REGION = 1.0


@dataclass(frozen=True, eq=False)
class Deployed:
    """A model as it runs on a vehicle.

    Attributes:
        model: of the damper.
        cutoff: Hz; 0 is unfiltered.
        max_gap: s.
        lead: s that the motion is predicted ahead to make up for the filter's delay; 0 is none.
        stddev: N, of the force; NaN if the model was not fitted. Files of older fits have the residual's alone.
        bounds: (8, 2), the region of the fit.
        fusion: where an accelerometer is taken in; then nothing is predicted.
        signals: the damper's channels, with their limits and ages.
    """

    model: DamperModel
    cutoff: float
    max_gap: float
    lead: float
    stddev: float
    bounds: np.ndarray
    fusion: Fusion | None
    signals: DamperSignals

    @property
    def is_identified(self) -> bool:
        """Whether the model was fitted to measurements, so that its error and its region are known."""
        return bool(np.isfinite(self.stddev) and np.isfinite(self.bounds).any())

    @cached_property
    def memories(self) -> Mapping[str, float | None]:
        """By slow channel: how many seconds the force remembers a wrong value, None if it does not depend on it."""
        return {role: memory(self.model, COMMAND + row, self.bounds) for row, role in enumerate(SLOW)}

    @cached_property
    def settling(self) -> float:
        """How many seconds after a start or a fault filter and model have forgotten it; see ``memory.settling``."""
        return settling(self.model, self.cutoff, self.bounds)

    def possible(self, role: str) -> tuple[float, float]:
        """Lowest and highest value that a slow channel can have: its limits in the signal map, for the command with a
        tenth of their width on either side; else the region of the fit with its width on either side, within what is
        possible at all."""
        low, high = _POSSIBLE[role]
        limits, region = getattr(self.signals, role).value_limits, self.bounds[COMMAND + SLOW.index(role)]
        if limits is not None:
            beyond = _BEYOND_LIMITS * (limits[1] - limits[0]) if role == "command" else 0.0
            return limits[0] - beyond, limits[1] + beyond
        if role == "command" and np.isfinite(region).all() and region[0] < region[1]:
            beyond = _BEYOND_REGION * (region[1] - region[0])
            return float(region[0]) - beyond, float(region[1]) + beyond
        return low, high

    def record(self) -> np.ndarray:
        """(1,) of ``runtime.record.RECORD``: the settings, and the state before the first sample."""
        record = fresh_record()
        (own,) = record
        own["max_gap"], own["cutoff"], own["lead"] = round(self.max_gap * 1e9), self.cutoff, self.lead
        own["settling"], own["likelihood"], own["equal"] = round(self.settling * 1e9), 1.0, 1.0
        own["noise_cutoff"] = self.cutoff if self.fusion is None else 0.0
        own["stddev"], own["bounds"], own["identified"] = self.stddev, self.bounds, self.is_identified
        if self.fusion is not None:
            own["fuses"], own["noises"] = True, self.fusion.noises()
        for row, role in enumerate(SLOW):
            channel, remembers = getattr(self.signals, role), self.memories[role]
            own["low"][row], own["high"][row] = self.possible(role)
            own["max_age"][row] = _MAX_AGE[role] if channel.max_age is None else channel.max_age
            own["adaptive"][row] = _ADAPTIVE[role] and channel.max_age is None
            own["matters"][row], own["memory"][row] = remembers is not None, round((remembers or 0.0) * 1e9)
        return record


def deployed(
    model: DamperModel,
    cutoff: float,
    max_gap: float,
    lead: float = 0.0,
    fusion: Fusion | None = None,
    signals: DamperSignals | None = None,
) -> Deployed:
    """Checks that a model can be run on a vehicle; arguments as in `Deployed`, ``signals`` None for the default ones.

    Raises:
        InputError: if the model holds effects of the measurement chain, which belong to the signal map, or what it
            knows of its fit is malformed.
    """
    if model.channel_effects:
        raise InputError(
            f"model {model.name}: {', '.join(model.channel_effects)} belong to the measurement chain; correct the "
            "signal map and take them out of the model"
        )
    errors = {name: model.fit[name] for name in _STDDEVS if model.fit.get(name) is not None}
    region = model.fit.get("region") or {}
    faults = [f"{name} = {value!r} is not a number" for name, value in errors.items() if not _is_number(value)]
    if not isinstance(region, Mapping):
        faults, region = [*faults, f"region must be a mapping, got {region!r}"], {}
    faults += [f"region.{name} must be two numbers, got {r!r}" for name, r in region.items() if not _is_range(r)]
    if faults:
        raise InputError(f"model {model.name}: fit: {'; '.join(faults)}; identify the model again, or remove fit")
    bounds = bounds_of({name: (float(r[0]), float(r[1])) for name, r in region.items()})
    return Deployed(
        model, cutoff, max_gap, lead if fusion is None else 0.0, float(next(iter(errors.values()), np.nan)), bounds,
        fusion, signals or default_signals(""),
    )  # fmt: skip


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 1e300


def _is_range(value: object) -> bool:
    return isinstance(value, list | tuple) and len(value) == 2 and all(_is_number(item) for item in value)
