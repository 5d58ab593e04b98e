"""One declaration per parameter, from which the ROS descriptor, the settings and the parameter file are made.
Independent of ROS.
"""

from dataclasses import dataclass, field, fields
from typing import Any

# When a change takes effect: while the node runs; at the next transition to configured; only at the start.
RUNNING, CONFIGURING, STARTING = "any time", "when the node is configured", "when the process starts"
_KEY = "declaration"


@dataclass(frozen=True)
class Declaration:
    """One parameter.

    Attributes:
        default: value of a parameter that is not set.
        description: one line with the unit, for ROS tools.
        explanation: unit, default and consequences, for the parameter file.
        changes: when a change takes effect.
        low, high: bounds of a number.
        allowed: the words of a text.
        introduction: precedes this parameter and the next ones in the parameter file.
    """

    default: object
    description: str
    explanation: str = ""
    changes: str = RUNNING
    low: float | int | None = None
    high: float | int | None = None
    allowed: tuple[str, ...] = ()
    introduction: str = ""

    @property
    def requirement(self) -> str:
        """The permitted values in words."""
        if isinstance(self.default, tuple):
            return "a list of names"
        if isinstance(self.default, bool):
            return "true or false"
        if self.allowed:
            return f"one of {', '.join(self.allowed)}"
        if self.low is None:
            return "text"
        point = ", written with a point (60.0)" if isinstance(self.low, float) else ""
        return f"between {self.low:g} and {self.high:g}{point}"


def parameter(default: object, description: str, explanation: str, **details: Any) -> Any:
    """A field of a settings class; ``details`` are the other attributes of `Declaration`."""
    return field(default=default, metadata={_KEY: Declaration(default, description, explanation, **details)})


def declarations_of(settings: type) -> dict[str, Declaration]:
    """The declarations of a settings class by name, in the order of its fields."""
    return {one.name: one.metadata[_KEY] for one in fields(settings)}
