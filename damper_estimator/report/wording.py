"""What the page says in words: the headline, the measures with their units, the quality of the data."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from damper_estimator.numbers import number
from damper_estimator.validation import Comparison

MEASURES = (
    ("rmse_n", "rms error", "N", "root mean square of modelled - measured force"),
    ("nrmse", "relative", "%", "rms error over rms force"),
    ("esr", "ESR", "", "error variance over force variance"),
    ("fit_percent", "fit", "%", "100 (1 - |e| / |F - mean F|)"),
    ("correlation", "correlation", "", "of modelled and measured force"),
    ("peak_error_n", "peak error", "N", "largest |e|"),
    ("energy_error", "energy error", "%", "dissipated energy, modelled - measured over measured"),
    ("bias_n", "bias", "N", "mean error"),
)

_GRAVE = ("sign", "dead_channel", "saturation", "held", "clock_drift")


def measure_text(name: str, value: float) -> str:
    """A measure as the page shows it, without its unit."""
    if name in ("correlation", "esr"):
        return f"{value:.4f}" if np.isfinite(value) else number(value)
    return number(100.0 * value if name in ("nrmse", "energy_error") else value)


def headline(comparisons: list[Comparison]) -> str:
    """The verdict in one sentence, for the best of the models."""
    best = min(comparisons, key=lambda c: c.measures.rmse_n)
    m = best.measures
    head = f"{best.model.name} is " if len(comparisons) == 1 else f"{best.model.name} is the closest: it is "
    text = (
        f"{head}{number(m.rmse_n)} N rms off, {number(100.0 * m.nrmse)} % of a force of {number(m.force_rms_n)} N rms"
    )
    grave = [finding.sentence for finding in best.findings if finding.kind in _GRAVE]
    if grave:
        text = f"The measurement comes first: {grave[0]}. {text}"
    if np.isfinite(best.noise_floor_n) and m.rmse_n <= 1.3 * best.noise_floor_n:
        return f"{text}: that is the noise of the measurement."
    sentences = [f"{sentence[0].upper()}{sentence[1:].split(':')[0]}" for sentence in best.split.sentences[:1]]
    sentences += [f"Its worst region is {region.where}: {region.what}" for region in best.regions[:1]]
    if sentences:
        return in_signs(f"{text}. {'. '.join(sentences)}.")
    return f"{text}; the error is spread evenly over the operation."


def in_signs(text: str) -> str:
    """A sentence with the signs of units that plain text lacks: ``m/s^2`` as m/s²."""
    return text.replace("m/s^2", "m/s²").replace("deg C", "°C")


def error_parts(comparison: Comparison) -> list[dict[str, object]]:
    """What the error is made of, N rms each, with the share of the sum of their squares in %."""
    split = comparison.split
    parts = [("zero", float(np.sqrt(np.mean(np.square(split.offsets))))), ("drift", split.drift_n)]
    parts += [("gain", split.gain_n), ("scatter", split.scatter_n)]
    total = sum(value**2 for _, value in parts) or 1.0
    return [{"name": name, "text": number(value), "width": 100.0 * value**2 / total} for name, value in parts]


def finding_rows(comparison: Comparison) -> list[dict[str, str]]:
    """What the recordings show to be wrong, once for all that show it."""
    same: dict[tuple[str, str], list[str]] = {}
    for finding in comparison.findings:
        same.setdefault((finding.sentence, finding.remedy), []).append(recording_name(finding.recording))
    several = len(comparison.traces) > 1
    return [
        {"sentence": sentence, "remedy": remedy, "where": ", ".join(names) if several and names[0] else ""}
        for (sentence, remedy), names in same.items()
    ]


def quality_rows(comparison: Comparison) -> list[dict[str, str]]:
    """Data quality by name, with what is suspicious marked."""
    q = comparison.data_quality
    rows = [("samples", f"{q.samples}", False), ("rate", f"{number(q.rate_hz, 4)} Hz", False)]
    counts = {
        "gaps": q.gaps,
        "steps back in time": q.steps_back,
        "older stamps": q.inversions,
        "equal stamps": q.duplicates,
        "not finite": q.non_finite,
        "saturated": q.saturated,
    }
    rows += [(name, f"{count}", count > 0) for name, count in counts.items()]
    skew = f"{1e3 * q.skew_s:.2f} ms" if np.isfinite(q.skew_s) else "not determined"
    # Friction and compliance delay the force as well: only the diagnosis can call it a mistake of the clock.
    rows.append(("force behind the model by", skew, False))
    rows.append(
        (
            "noise floor",
            f"{number(comparison.noise_floor_n)} N" if np.isfinite(comparison.noise_floor_n) else "not determined",
            False,
        )
    )
    return [{"name": name, "text": text, "bad": bad} for name, text, bad in rows]


def recording_name(path: str) -> str:
    """Short name of a recording."""
    return Path(path).name


_SPEEDS = {"LV": "low velocity", "HV": "high velocity"}
_RATES = {"LF": "low frequency", "HF": "high frequency"}


def groups_in_words(names: Sequence[str]) -> str:
    """What the abbreviations of groups of cycles stand for: ``LVLF: low velocity and low frequency; ...``."""
    known = {}
    for name in names:
        parts = [words for short, words in (_SPEEDS | _RATES).items() if short in (name[:2], name[2:])]
        if parts and len(name) == 2 * len(parts):
            known[name] = " and ".join(parts)
    return "; ".join(f"{name}: {words}" for name, words in known.items())
