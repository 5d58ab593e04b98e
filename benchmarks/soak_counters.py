"""The counters of /diagnostics, held against what was sent."""

from collections.abc import Mapping

from soak_judge import Judge
from soak_node import DISPLACEMENT
from soak_plant import NAMES

COUNTED = (
    "samples", "estimates", "dropped: equal stamp", "dropped: older stamp", "dropped: not finite", "resets: gap",
    "resets: clock stepped back",
)  # fmt: skip


class Counters:
    """What the node counted and what is right, at the last look; final."""

    def __init__(self) -> None:
        self._before: tuple[dict[str, int], dict[str, int]] | None = None

    def forget(self) -> None:
        """The node counts from zero, from some message on: the next look only begins."""
        self._before = None

    def check(self, values: Mapping[str, Mapping[str, str]], judge: Judge, now: float) -> None:
        """Compares how both have grown since the last look; ``values`` of a report by the last part of its names."""
        told = {"malformed": int(values[f"input {DISPLACEMENT}"]["malformed"])}
        right = {"malformed": judge.malformed}
        for k, name in enumerate(NAMES):
            told |= {f"{name}: {key}": int(values[name][key]) for key in COUNTED}
            right |= {f"{name}: {key}": judge.rules[k].counts[key] for key in COUNTED}
            told[f"{name}: missing"], right[f"{name}: missing"] = (
                int(values[name]["not in the message"]),
                judge.missing[k],
            )
        if self._before is not None:
            for key, value in told.items():
                new, expected = value - self._before[0][key], right[key] - self._before[1][key]
                if new != expected:
                    what = f"counter {key} grew by {new} instead of {expected}"
                    judge.violate(what, (), now, key=f"counter {key}")
        self._before = told, right
