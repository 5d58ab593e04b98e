"""The node's parameters: declared with range and meaning, checked together, then frozen."""

from dataclasses import dataclass

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.exceptions import InvalidParameterTypeException, InvalidParameterValueException
from rclpy.node import Node
from rclpy.parameter import Parameter

from damper_estimator.errors import InputError

EXECUTORS = ("events", "single")
RELIABILITIES = ("best_effort", "reliable")
FROM_SIGNAL_MAP = -1.0


@dataclass(frozen=True)
class Settings:
    """What was set.

    Attributes:
        dampers: names; empty for all.
        model: file, folder or name.
        signals: path of the signal map; empty for the default topics.
        cutoff: Hz; 0 unfiltered, negative as in the signal map.
        max_gap: s.
        executor, qos_reliability: one of ``EXECUTORS``, ``RELIABILITIES``.
        qos_depth: messages.
    """

    dampers: tuple[str, ...]
    model: str
    signals: str
    cutoff: float
    max_gap: float
    executor: str
    qos_reliability: str
    qos_depth: int


def read_settings(node: Node) -> Settings:
    """Declares the parameters on the node and reads them.

    Raises:
        InputError: one line with every wrong value and what is allowed.
    """
    declared = {
        "dampers": _declare(node, "dampers", Parameter.Type.STRING_ARRAY, "names of the dampers; not set: all"),
        "model": _declare(node, "model", "", "model file, folder with one DAMPER.yaml each, or a model's name"),
        "signals": _declare(node, "signals", "", "signal map; '' is the default topics"),
        "cutoff": _declare(node, "cutoff", FROM_SIGNAL_MAP, "Hz; 0 is unfiltered, -1 as in the signal map", -1.0, 1e5),
        "max_gap": _declare(node, "max_gap", 0.1, "s, longest continuous step between stamps", 1e-6, 3600.0),
        "executor": _declare(node, "executor", "events", f"one of {', '.join(EXECUTORS)}"),
        "qos_reliability": _declare(node, "qos_reliability", "best_effort", f"one of {', '.join(RELIABILITIES)}"),
        "qos_depth": _declare(node, "qos_depth", 100, "messages that wait while the node is busy", 1, 1_000_000),
    }
    # A parameter file cannot hold an empty list; [''] is what people write instead.
    declared["dampers"] = tuple(filter(None, declared["dampers"] or ()))
    settings = Settings(**declared)
    _check(settings)
    return settings


def _declare(
    node: Node, name: str, default: object, description: str, low: object = None, high: object = None
) -> object:
    descriptor = ParameterDescriptor(description=description, read_only=True)
    if isinstance(low, float):
        descriptor.floating_point_range = [FloatingPointRange(from_value=low, to_value=high)]
    elif low is not None:
        descriptor.integer_range = [IntegerRange(from_value=low, to_value=high, step=1)]
    try:
        return node.declare_parameter(name, default, descriptor).value
    except (InvalidParameterTypeException, InvalidParameterValueException) as error:
        hint = f"between {low:g} and {high:g}" if low is not None else "text"
        if name == "dampers":
            hint = "a list of names"
        elif isinstance(low, float):
            hint += ", written with a point (60.0)"
        raise InputError(f"parameter {name}: must be {hint} ({error})") from error


def _check(settings: Settings) -> None:
    faults = []
    if not settings.model:
        faults.append(
            "parameter model is not set; give a model file, a folder, or a name that damper-estimator models lists"
        )
    for name, allowed in (("executor", EXECUTORS), ("qos_reliability", RELIABILITIES)):
        if (value := getattr(settings, name)) not in allowed:
            faults.append(f"parameter {name} is {value!r}; allowed are {', '.join(allowed)}")
    if faults:
        raise InputError("; ".join(faults))
