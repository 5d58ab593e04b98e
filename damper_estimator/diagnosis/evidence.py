"""Evidence in words that an engineer can check on a plot: where and when an effect takes error away."""

from collections.abc import Sequence

import numpy as np

from damper_estimator.diagnosis.attempt import Null
from damper_estimator.diagnosis.judge import Errors
from damper_estimator.effects.contract import Effect
from damper_estimator.numerics import rank_correlation
from damper_estimator.signals.layout import COMMAND, TEMPERATURE, A, T, V, X

_TELLING = 0.35  # correlation of ranks that is worth a word
_LEAST_BLOCKS = 8


def evidence(null: Null, effect: Effect, without: Errors, with_it: Errors) -> str:
    """How the effect shows, where it takes the error away, and with what that grows."""
    sentences = [_sentence(effect.shows)] if effect.shows else []
    sentences.append(_where(null, without, with_it))
    grows = _grows(null, without, with_it)
    if grows:
        sentences.append(grows)
    return " ".join(s for s in sentences if s)


def _sentence(text: str) -> str:
    text = text.strip().rstrip(".")
    return text[:1].upper() + text[1:] + "."


def _rows(null: Null, row: int) -> np.ndarray:
    return np.concatenate([own.measurement.kinematics.block[row][own.picks] for own in null.scene.unseen])


def _where(null: Null, without: Errors, with_it: Errors) -> str:
    """The speeds that carry most of what is taken away."""
    velocity = _rows(null, V)
    taken = without.unseen**2 - with_it.unseen**2
    total = float(taken.sum())
    if total <= 0.0:
        return ""
    speed = np.abs(velocity)
    edges = np.quantile(speed, [0.0, 1 / 3, 2 / 3, 1.0])
    parts = []
    for name, side in (("rebound", velocity > 0.0), ("compression", velocity <= 0.0)):
        for low, high in zip(edges, edges[1:], strict=False):
            inside = side & (speed >= low) & (speed <= high)
            if inside.any():
                parts.append((float(taken[inside].sum()) / total, float(inside.mean()), name, low, high))
    share, time, name, low, high = max(parts, key=lambda part: part[0])
    return (
        f"{100.0 * share:.0f} % of what it takes away lies in {name} between {low:.2g} and {high:.2g} m/s "
        f"({100.0 * time:.0f} % of the time)."
    )


def _grows(null: Null, without: Errors, with_it: Errors) -> str:
    """With what the relative share of the explained error rises from second to second."""
    blocks = null.scene.blocks
    force = np.concatenate([own.target for own in null.scene.unseen])
    power = np.bincount(blocks, force**2)
    taken = np.bincount(blocks, without.unseen**2 - with_it.unseen**2)
    moving = power > 0.02 * power.max()
    if moving.sum() < _LEAST_BLOCKS:
        return ""
    share = taken[moving] / power[moving]
    quantities = {name: values[moving] for name, values in _per_block(null, blocks).items()}
    known = {name: rank_correlation(share, own) for name, own in quantities.items() if np.ptp(own) > 0.0}
    up = [name for name, value in known.items() if value >= _TELLING]
    flat = [name for name, value in known.items() if abs(value) < 0.5 * _TELLING]
    down = [name for name, value in known.items() if value <= -_TELLING]
    if not (up or down):
        return ""
    words = []
    if up:
        words.append(f"grows with {_listed(up)}")
    if down:
        words.append(f"falls with {_listed(down)}")
    text = "Relative to the force it " + " and ".join(words)
    return text + (f", not with {_listed(flat, 'or')}." if flat else ".")


def _per_block(null: Null, blocks: np.ndarray) -> dict[str, np.ndarray]:
    """Conditions by block: frequency of the motion, amplitude, acceleration, time, temperature, command."""
    count = np.maximum(np.bincount(blocks), 1)

    def mean(values: np.ndarray) -> np.ndarray:
        return np.bincount(blocks, np.nan_to_num(values)) / count

    x, v, a = _rows(null, X), _rows(null, V), _rows(null, A)
    middle = mean(x)[blocks]
    amplitude = np.sqrt(2.0 * mean((x - middle) ** 2))
    speed = np.sqrt(mean(v**2))
    quantities = {
        "frequency": np.sqrt(mean(a**2)) / np.maximum(speed, 1e-9),
        "amplitude": amplitude,
        "time": mean(_rows(null, T)),
    }
    for name, row in (("temperature", TEMPERATURE), ("command", COMMAND)):
        values = _rows(null, row)
        if np.isfinite(values).any() and np.ptp(values[np.isfinite(values)]) > 0.0:
            quantities[name] = mean(values)
    return quantities


def _listed(names: Sequence[str], last: str = "and") -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} {last} {names[-1]}"


def confirming(effect: Effect, tied: Sequence[str]) -> str:
    """The test that tells the effect from its look-alikes."""
    text = _sentence(effect.separate) if effect.separate else ""
    return f"To tell it from {_listed(list(tied), 'or')}: {text[:1].lower()}{text[1:]}" if tied and text else text
