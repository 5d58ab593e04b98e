"""What the pages of a diagnosis and an improvement say in words and tables."""

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from damper_estimator.diagnosis import Diagnosis, Finding, Improvement, RankedEffect, Step, in_yaml
from damper_estimator.numbers import UNDETERMINED, number, plus_minus
from damper_estimator.report.before_after import first_diagnosis
from damper_estimator.report.wording import recording_name

_UNITS = {"1": "", "m/s^2": "m/s²", "deg C": "°C"}


class Parameter(Protocol):
    """An identified number, as identification gives it."""

    name: str
    value: float
    standard_error: float
    unit: str
    at_bound: bool


def plain_name(phenomenon: str) -> str:
    """``oil_compressibility`` as people write it."""
    return phenomenon.replace("_", " ")


def listed(names: Sequence[str], last: str = "or") -> str:
    """``a, b or c``."""
    plain = [plain_name(name) for name in names]
    return "".join(plain) if len(plain) < 2 else f"{', '.join(plain[:-1])} {last} {plain[-1]}"


def step_name(step: Step) -> str:
    """What a step did, in a few words."""
    given = step.phenomenon or ("a free curve" if step.effect else "")
    name = given if step.action == "refit" else plain_name(given)
    return {
        "start": "model as given",
        "correct": f"correct {name}",
        "refit": f"refit {name}".strip(),
        "add": f"add {name}",
        "prune": f"take out {step.effect}",
    }.get(step.action, f"{step.action} {name}".strip())


def with_error(value: float, error: float) -> tuple[str, str]:
    """A value to the digits that its standard error leaves, and the error with a sign; "" where none is known. A value
    that its error exceeds keeps three digits.
    """
    if not np.isfinite(error) or error <= 0.0:
        return _grouped(float(f"{value:.4g}")), ""
    digits = _places(error, 2)
    shown = plus_minus(value, error, _grouped(round(error, digits), digits))
    kept = _places(value, 3) if error > abs(value) > 0.0 else digits
    return _grouped(round(value, kept), kept), shown


def _places(value: float, digits: int) -> int:
    """Decimal places that leave so many significant digits; negative before the point."""
    return digits - 1 - int(np.floor(np.log10(abs(value))))


def _grouped(value: float, digits: int | None = None) -> str:
    """Thousands apart by a thin space; tiny and huge numbers as powers of ten."""
    if value and not 1e-4 <= abs(value) < 1e8:
        return f"{value:.3g}"
    places = max(digits, 0) if digits is not None else max(3 - int(np.floor(np.log10(abs(value) or 1.0))), 0)
    return f"{value:,.{places}f}".replace(",", "\u2009")


def parameter_rows(parameters: Sequence[Parameter]) -> list[dict[str, object]]:
    """Value, standard error and unit of each identified parameter, with what stopped at a bound marked."""
    rows = []
    for parameter in parameters:
        value, error = with_error(parameter.value, parameter.standard_error)
        rows.append(
            {
                "name": parameter.name,
                "value": value,
                "error": "" if parameter.at_bound else error or UNDETERMINED,
                "unit": _UNITS.get(parameter.unit, parameter.unit),
                "at_bound": parameter.at_bound,
            }
        )
    return rows


def finding_text(finding: Finding) -> dict[str, object]:
    """One finding's words and numbers."""
    return {
        "name": plain_name(finding.phenomenon),
        "accounted": plain_name(finding.phenomenon),
        "effect": finding.effect,
        "tied": listed(finding.tied_with),
        "confidence": f"{100.0 * finding.confidence:.0f} %",
        "share": f"{100.0 * finding.share_of_explainable_error:.0f} %",
        "errors": f"{number(finding.rmse_before_n)} → {number(finding.rmse_after_n)} N",
        "evidence": finding.evidence,
        "test": finding.test_to_separate,
        "remark": finding.remark,
        "parameters": parameter_rows(finding.parameters),
        "is_channel": finding.is_channel,
    }


def rejected_rows(ranking: Sequence[RankedEffect], untestable: dict[str, str] | None = None) -> list[dict[str, str]]:
    """Every candidate that was not taken, with the reason, and those that could not be tried."""
    rows = [
        {"phenomenon": plain_name(judged.phenomenon), "effect": judged.effect, "reason": judged.reason}
        for judged in ranking
        if judged.reason
    ]
    return rows + [
        {"phenomenon": "", "effect": name, "reason": f"not tried: {reason}"}
        for name, reason in (untestable or {}).items()
    ]


def moved_rows(diagnosis: Diagnosis) -> list[dict[str, str]]:
    """Parameters that re-identification moves."""
    return [
        {
            "name": parameter.name,
            "before": with_error(parameter.before, parameter.standard_error)[0],
            "after": with_error(parameter.after, parameter.standard_error)[0],
            "error": with_error(parameter.after, parameter.standard_error)[1],
            "unit": _UNITS.get(parameter.unit, parameter.unit),
        }
        for parameter in diagnosis.moved
    ]


def data_rows(diagnosis: Diagnosis) -> list[dict[str, str]]:
    """Mistakes of the recordings, with what corrects them; those that several recordings share are reported once."""
    same: dict[tuple[str, str], list[str]] = {}
    for finding in diagnosis.data:
        same.setdefault((finding.sentence, finding.remedy), []).append(recording_name(finding.recording))
    return [
        {"sentence": sentence, "remedy": remedy, "recording": ", ".join(filter(None, dict.fromkeys(names)))}
        for (sentence, remedy), names in same.items()
    ]


def stretches_sentence(diagnosis: Diagnosis) -> str:
    """Which part of long recordings was used; "" if they were used whole."""
    if not diagnosis.stretches:
        return ""
    uses = (("fit", "fitted to", diagnosis.fit), ("unseen", "judged on", diagnosis.unseen))
    shares = []
    for use, name, recordings in uses:
        used = sum(one.stop - one.start for one in diagnosis.stretches if one.use == use)
        whole = sum(float(m.kinematics.dt.sum()) for m in recordings)
        shares.append(f"{name} {number((used or whole) / 60.0, 2)} of {number(whole / 60.0, 2)} minutes")
    return (
        f"Effects were {' and '.join(shares)}, the stretches with the most varied motion; "
        "the errors of models are those of the whole."
    )


def correction_rows(found: Diagnosis | Improvement) -> list[dict[str, str]]:
    """What the signal map's entry of the force gets."""
    old = first_diagnosis(found).fit[0].signals
    units = {"scale": "", "offset": "N", "skew": "s", "spring_rate": "N/m", "preload": "N"}
    before = {"scale": old.force.scale, "offset": old.force.offset, "skew": old.force.skew}
    before |= {"spring_rate": old.spring_rate, "preload": old.preload}
    return [
        {"name": f"force.{name}", "before": number(before[name], 5), "after": number(value, 5), "unit": units[name]}
        for name, value in in_yaml(found.signals, old).items()
        if np.isfinite(value)
    ]


def model_rows(model: object) -> list[dict[str, object]]:
    """All parameters of a model with the standard errors that its last identification left."""
    errors = model.standard_errors
    rows = []
    for slot in model.slots:
        value, error = with_error(slot.value, errors.get(slot.address, float("nan")))
        rows.append(
            {
                "name": slot.address,
                "value": value,
                "error": "fixed" if slot.fixed else error or (UNDETERMINED if errors else ""),
                "unit": _UNITS.get(slot.parameter.unit, slot.parameter.unit),
                "at_bound": slot.is_at_bound,
            }
        )
    return rows
