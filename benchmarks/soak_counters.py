"""Compares the counters of /diagnostics with the sent messages."""

from collections.abc import Mapping

from soak_judge import Judge
from soak_node import DISPLACEMENT
from soak_plant import NAMES

COUNTED = (
    "samples", "estimates", "dropped: equal stamp", "dropped: older stamp", "dropped: not finite", "resets: gap",
    "resets: clock stepped back",
)  # fmt: skip


class Counters:
    """The node's and the correct counts at the last check; final."""

    def __init__(self) -> None:
        self._before: tuple[dict[str, int], dict[str, int]] | None = None

    def forget(self) -> None:
        """The node restarted its counts at an unknown message: the next check only sets the reference."""
        self._before = None

    def check(self, values: Mapping[str, Mapping[str, str]], judge: Judge, now: float) -> None:
        """Compares the growth of both since the last check; ``values`` of a report by the last part of its names."""
        counted = {"malformed": int(values[f"input {DISPLACEMENT}"]["malformed"])}
        right = {"malformed": judge.malformed}
        for k, name in enumerate(NAMES):
            counted |= {f"{name}: {key}": int(values[name][key]) for key in COUNTED}
            right |= {f"{name}: {key}": judge.rules[k].counts[key] for key in COUNTED}
            counted[f"{name}: missing"], right[f"{name}: missing"] = (
                int(values[name]["not in the message"]),
                judge.missing[k],
            )
        if self._before is not None:
            for key, value in counted.items():
                new, expected = value - self._before[0][key], right[key] - self._before[1][key]
                if new != expected:
                    what = f"counter {key} grew by {new} instead of {expected}"
                    judge.violate(what, (), now, key=f"counter {key}")
        self._before = counted, right
