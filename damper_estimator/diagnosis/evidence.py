"""Evidence in words that an engineer can check on a plot: where and when an effect takes error away."""

from collections.abc import Sequence

import numpy as np

from damper_estimator.diagnosis.baseline import Baseline
from damper_estimator.diagnosis.evaluation import Errors, TestEvaluation
from damper_estimator.effects.contract import Effect
from damper_estimator.signals.layout import V


def evidence(
    baseline: Baseline,
    effect: Effect,
    without: Errors,
    with_it: Errors,
    tests: Sequence[TestEvaluation],
    because: str = "",
) -> str:
    """How the effect shows, or what speaks for it beside the recordings, where it takes the error away, and on what the
    error depends.
    """
    shows = because or effect.shows
    sentences = [_sentence(shows)] if shows else []
    sentences.append(_where(baseline, without, with_it))
    if not because:
        sentences.append(_depends(tests, effect))
    return " ".join(s for s in sentences if s)


def _sentence(text: str) -> str:
    text = text.strip().rstrip(".")
    return text[:1].upper() + text[1:] + "."


def _rows(baseline: Baseline, row: int) -> np.ndarray:
    return np.concatenate([part.measurement.kinematics.block[row][part.picks] for part in baseline.data.unseen])


def _where(baseline: Baseline, without: Errors, with_it: Errors) -> str:
    """The speeds that carry most of what is taken away."""
    velocity = _rows(baseline, V)
    change = without.unseen**2 - with_it.unseen**2
    if change.sum() <= 0.0:
        return ""
    taken = np.maximum(change, 0.0)
    total = float(taken.sum())
    speed = np.abs(velocity)
    edges = [0.0, *np.quantile(speed, [1 / 3, 2 / 3, 1.0])]
    parts = []
    for name, side in (("rebound", velocity > 0.0), ("compression", velocity <= 0.0)):
        for low, high in zip(edges, edges[1:], strict=False):
            inside = side & (speed >= low) & (speed <= high)
            if inside.any():
                parts.append((float(taken[inside].sum()) / total, float(inside.mean()), name, low, high))
    share, time, name, low, high = max(parts, key=lambda part: part[0])
    speeds = f"between {low:.2g} and {high:.2g} m/s" if low else f"below {high:.2g} m/s"
    return f"{100.0 * share:.0f} % of what it takes away lies in {name} {speeds} ({100.0 * time:.0f} % of the time)."


def _depends(tests: Sequence[TestEvaluation], effect: Effect) -> str:
    """What the form-free tests say: on which variables the error depends."""
    rows = sorted(tests, key=lambda test: test.error)
    test = next((test for test in rows if test.test.name in effect.tests), None)
    if test is None:
        return ""
    # A test that can imitate this one says nothing against it.
    others = (t for t in rows if t.test.name not in effect.tests and test.test.name not in t.test.contains)
    other = next(others, None)
    if other is None:
        return ""
    return (
        f"Without assuming a form, a dependence on {test.test.shows} explains {_percent(test)} of the squared error "
        f"on unseen data; the best other one, on {other.test.shows}, {_percent(other)}."
    )


def _percent(test: TestEvaluation) -> str:
    return f"{100.0 * max(1.0 - test.remaining.unseen, 0.0):.0f} %"


def _listed(names: Sequence[str], last: str = "and") -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} {last} {names[-1]}"


def confirming(effect: Effect, tied: Sequence[str]) -> str:
    """The test that distinguishes the effect from similar ones."""
    text = _sentence(effect.separate) if effect.separate else ""
    if not (tied and text):
        return text
    others = _listed([name.replace("_", " ") for name in tied], "or")
    return f"To distinguish it from {others}: {text[:1].lower()}{text[1:]}"
