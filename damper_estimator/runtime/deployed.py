"""A checked model with everything that the line needs to run it on a vehicle."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from damper_estimator.errors import InputError
from damper_estimator.model import DamperModel
from damper_estimator.model.record_faults import REMEDY, record_faults
from damper_estimator.runtime.damper_record import SLOW, fresh_record
from damper_estimator.runtime.memory import memory, settling
from damper_estimator.runtime.status import bounds_of
from damper_estimator.signals import DamperSignals, default_signals
from damper_estimator.signals.fusion import Fusion
from damper_estimator.signals.layout import COMMAND

# Plausible values of a slow channel if neither map nor fit limits it: A, deg C, Pa; maximum age of its value (s); and
# whether several of its usual intervals are too old already.
_POSSIBLE = {"command": (-1e3, 1e3), "temperature": (-60.0, 300.0), "pressure": (0.0, 1e8)}
_MAX_AGE = {"command": 0.5, "temperature": 30.0, "pressure": 1.0}
_ADAPTIVE = {"command": True, "temperature": False, "pressure": True}
_STDDEVS = ("force_stddev", "residual_stddev")  # of a fit; the first one present counts
_BEYOND_LIMITS = 0.1  # of their width; a measured current is noisy and overshoots
_BEYOND_REGION = 1.0


@dataclass(frozen=True, eq=False)
class Deployed:
    """A model on a vehicle.

    Attributes:
        model: of the damper.
        cutoff: Hz; 0 is unfiltered.
        max_gap: s.
        lead: s that the motion is predicted ahead to compensate the filter's delay; 0 is none.
        stddev: N, of the force; NaN if the model was not fitted. Files of older fits have only the residual's.
        bounds: (8, 2), the region of the fit.
        fusion: of an accelerometer, or None; with it nothing is predicted.
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
        """Time in s for which the force remembers a wrong value, by slow channel; None if it does not depend on it."""
        return {role: memory(self.model, COMMAND + row, self.bounds) for row, role in enumerate(SLOW)}

    @cached_property
    def settling(self) -> float:
        """Time in s after which filter and model have forgotten a start or a fault; see ``memory.settling``."""
        return settling(self.model, self.cutoff, self.bounds)

    def possible(self, role: str) -> tuple[float, float]:
        """Lowest and highest plausible value of a slow channel: its limits in the signal map, for the command with a
        tenth of their width on either side; else, for the command, the region of the fit with its width on either side;
        else general bounds.
        """
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
        """(1,) of ``runtime.damper_record.RECORD``: the settings, and the state before the first sample."""
        record = fresh_record()
        (settings,) = record
        settings["max_gap"], settings["cutoff"], settings["lead"] = round(self.max_gap * 1e9), self.cutoff, self.lead
        settings["settling"], settings["likelihood"], settings["equal"] = round(self.settling * 1e9), 1.0, 1.0
        settings["noise_cutoff"] = self.cutoff if self.fusion is None else 0.0
        settings["stddev"], settings["bounds"], settings["identified"] = self.stddev, self.bounds, self.is_identified
        if self.fusion is not None:
            settings["fuses"], settings["noises"] = True, self.fusion.noises()
        for row, role in enumerate(SLOW):
            channel, remembered = getattr(self.signals, role), self.memories[role]
            settings["low"][row], settings["high"][row] = self.possible(role)
            settings["max_age"][row] = _MAX_AGE[role] if channel.max_age is None else channel.max_age
            settings["adaptive"][row] = _ADAPTIVE[role] and channel.max_age is None
            settings["matters"][row], settings["memory"][row] = remembered is not None, round((remembered or 0.0) * 1e9)
        return record


def deployed(
    model: DamperModel,
    cutoff: float,
    max_gap: float,
    lead: float = 0.0,
    fusion: Fusion | None = None,
    signals: DamperSignals | None = None,
) -> Deployed:
    """Checks that a model can run on a vehicle; arguments as in `Deployed`, ``signals`` None for the default ones.

    Raises:
        InputError: if the model contains effects of the measurement chain, which belong to the signal map, or its fit
            is malformed.
    """
    if model.channel_effects:
        raise InputError(
            f"model {model.name}: {', '.join(model.channel_effects)} belong to the measurement chain; correct the "
            "signal map and remove them from the model"
        )
    faults = list(record_faults(model.fit))
    if faults:
        raise InputError(f"model {model.name}: fit: {'; '.join(faults)}; {REMEDY}")
    errors = {name: model.fit[name] for name in _STDDEVS if model.fit.get(name) is not None}
    bounds = bounds_of({name: (float(r[0]), float(r[1])) for name, r in (model.fit.get("region") or {}).items()})
    return Deployed(
        model, cutoff, max_gap, lead if fusion is None else 0.0, float(next(iter(errors.values()), np.nan)), bounds,
        fusion, signals or default_signals(""),
    )  # fmt: skip
