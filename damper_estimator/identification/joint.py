"""Joint identification: some parameters are shared by all recordings, others have a value per setting.

The user changes the setting of a damper: adjuster position, current, gas pressure. All recordings are
fitted together, so that all of them determine the shared values; for another adjuster position of the
track paper's damper, for example, only K_leak and K_port change.

Source: Carrera Akutain et al., section 4.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from time import perf_counter

import numpy as np

from damper_estimator.errors import InputError
from damper_estimator.identification.fit import (
    Fit,
    FittedParameter,
    identified,
    judged_rows,
    lost_and_filters,
    parameters_of,
    result,
    warnings_of,
)
from damper_estimator.identification.knots import with_placed_knots
from damper_estimator.identification.local_rows import LocalRows
from damper_estimator.identification.methods.contract import MethodOptions
from damper_estimator.identification.problem import Problem
from damper_estimator.identification.selection import free_slots, named_slots, narrowed
from damper_estimator.identification.unknowns import Settings
from damper_estimator.model import DamperModel
from damper_estimator.signals import Measurement

_SAME = 0.02  # of the largest value: settings that count as one
_STEADY = 0.05  # of the largest value: a channel that spreads by more is not a setting


@dataclass(frozen=True)
class JointFit:
    """Models that share parameters.

    Attributes:
        fits: by setting, each with all its parameters, the shared ones included, and the errors over its recordings.
        parameters: all that was identified, those that differ as ``ADDRESS@SETTING``.
        each: addresses that differ between the settings.
        undetermined: as in ``Fit``, over all settings together.
        warnings: the same.
    """

    fits: dict[str, Fit]
    parameters: tuple[FittedParameter, ...]
    each: tuple[str, ...]
    undetermined: tuple[tuple[str, ...], ...]
    warnings: tuple[str, ...]


def fit_joint(
    model: DamperModel,
    measurements: Sequence[Measurement],
    settings: Sequence[str],
    each: Iterable[str],
    free: Iterable[str] = (),
    fix: Iterable[str] = (),
    method: str = "least_squares",
    seed: int = 0,
    starts: int | None = None,
    method_options: MethodOptions = MethodOptions(),
    limits: Mapping[str, tuple[float, float]] | None = None,
) -> JointFit:
    """Identifies a model on all measurements together, with a separate value of some parameters for each setting.

    Args:
        settings: name of the setting of each measurement.
        each: parameters that differ, named as in ``selection.free_slots``; all of them are identified.
        free, fix, method, seed, starts, method_options, limits: as in ``fit``.

    Raises:
        InputError: as ``fit``, and where there is only one setting.
    """
    began = perf_counter()
    names = tuple(dict.fromkeys(settings))
    if len(names) < 2:
        raise InputError(f"all recordings have the setting {', '.join(names)}; a joint fit needs two or more")
    order = np.argsort([names.index(setting) for setting in settings], kind="stable")
    given = [measurements[i] for i in order]
    rows = judged_rows(model, given, [1.0] * len(given), [names.index(settings[i]) for i in order])
    missing = [name for k, name in enumerate(names) if all(recording.setting != k for recording in rows)]
    if missing:
        raise InputError(f"setting {', '.join(missing)}: no sample can be judged; record longer or widen the window")
    placed = with_placed_knots(model, [recording.measurement for recording in rows])
    each = list(each)
    differing = named_slots(placed, each)
    chosen = free_slots(placed, [*free, *each], fix)
    settled = Settings(names, frozenset(differing))
    problem = Problem(placed, LocalRows(rows), chosen, settled, narrowed(placed, limits or {}))
    solution, known = identified(problem, method, starts, replace(method_options, seed=seed))
    warnings = warnings_of(problem, model, solution, known, *lost_and_filters(rows, given))
    seconds = perf_counter() - began
    fits = {name: result(model, problem, rows, solution, known, seconds, warnings, k) for k, name in enumerate(names)}
    addresses = tuple(placed.slots[i].address for i in differing)
    return JointFit(fits, parameters_of(problem, solution, known), addresses, known.undetermined, warnings)


def settings_by_channel(measurements: Sequence[Measurement], row: int, name: str) -> list[str]:
    """Each recording's setting, named by the channel's steady value; values within 2 % of the largest are one.

    Args:
        row: of the sample block.
        name: of the channel, for errors.

    Raises:
        InputError: where a recording lacks the channel, or it is not steady there.
    """
    values = []
    for measurement in measurements:
        channel = measurement.kinematics.block[row, measurement.judged]
        if channel.size == 0 or not np.isfinite(channel).any():
            raise InputError(f"{measurement.recording}: has no {name}; name its setting with --by SETTING=BAG[,BAG]")
        values.append(channel[np.isfinite(channel)])
    largest = max(float(np.abs(channel).max()) for channel in values)
    for measurement, channel in zip(measurements, values, strict=True):
        if channel.std() > _STEADY * largest:
            raise InputError(
                f"{measurement.recording}: its {name} is not steady ({channel.min():.3g} to {channel.max():.3g}); "
                "name its setting with --by SETTING=BAG[,BAG], or let the model depend on it"
            )
    known: list[float] = []
    names = []
    for channel in values:
        middle = float(np.median(channel))
        same = [value for value in known if abs(value - middle) <= _SAME * largest]
        if not same:
            known.append(middle)
        names.append(f"{(same or [middle])[0]:.3g}")
    return names
