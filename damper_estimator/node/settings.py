"""The node's parameters: declared with range and meaning, checked together, then frozen."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from math import isfinite

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.exceptions import InvalidParameterTypeException, InvalidParameterValueException
from rclpy.node import Node
from rclpy.parameter import Parameter

from damper_estimator.control.inverse import HORIZON, LEAD
from damper_estimator.errors import InputError

FROM_SIGNAL_MAP = -1.0
# When a change takes effect: while the node runs; at the next transition to configured; only at the start.
RUNNING, CONFIGURING, STARTING = "any time", "when the node is configured", "when the process starts"


@dataclass(frozen=True)
class Declaration:
    """One parameter; ``low`` and ``high`` bound a number, ``allowed`` lists the words of a text."""

    default: object
    description: str
    changes: str = RUNNING
    low: float | int | None = None
    high: float | int | None = None
    allowed: tuple[str, ...] = ()


DECLARATIONS: dict[str, Declaration] = {
    "dampers": Declaration(("",), "names of the dampers; [''] is all"),
    "model": Declaration("", "model file, folder with one DAMPER.yaml each, or a model's name"),
    "signals": Declaration("", "signal map; '' is the default topics"),
    "cutoff": Declaration(FROM_SIGNAL_MAP, "Hz; 0 is unfiltered, -1 as in the signal map", low=-1.0, high=1e5),
    "max_gap": Declaration(0.1, "s, longest continuous step between stamps", low=1e-6, high=3600.0),
    "max_age": Declaration(
        0.5, "s after its stamp from which on a sample is too old; 0 judges no age", low=0.0, high=3600.0
    ),
    "compensation": Declaration(0.0, "share of the filter's delay that is predicted away", low=0.0, high=1.0),
    "stale_after": Declaration(0.1, "s without a good sample until STALE is published", low=0.005, high=3600.0),
    "drift_window": Declaration(60.0, "s over which the error against the gauge is averaged", low=1.0, high=3600.0),
    "drift_factor": Declaration(2.0, "growth of that error that raises the alarm", low=1.1, high=100.0),
    "safe_current": Declaration(0.0, "commanded without a fresh desired force or a good estimate", low=-1e3, high=1e3),
    "desired_force_timeout": Declaration(0.1, "s after which a desired force no longer counts", low=0.002, high=10.0),
    "command_extrapolating": Declaration(False, "follow desired forces outside the region of the model's fit as well"),
    "command_lag": Declaration(
        0.05,
        "s within which a driver follows its command and reports the current; 0 compares nothing",
        low=0.0,
        high=10.0,
    ),
    "horizon": Declaration(
        HORIZON, "s ahead at which a command is to have reached the desired force", low=1e-4, high=1.0
    ),
    "lead": Declaration(LEAD, "s ahead at which the inverse sees the motion", low=0.0, high=1.0),
    "record": Declaration("", "folder for recordings of inputs and estimates; '' is none", CONFIGURING),
    "record_size": Declaration(256, "MB per file of a recording", CONFIGURING, 1, 1_000_000),
    "record_files": Declaration(
        0, "files of a recording that are kept, oldest go first; 0 is all", CONFIGURING, 0, 10**6
    ),
    "qos_reliability": Declaration(
        "best_effort", "what is asked of publishers", CONFIGURING, allowed=("best_effort", "reliable")
    ),
    "qos_depth": Declaration(100, "messages that wait while the node is busy", CONFIGURING, 1, 1_000_000),
    "realtime_priority": Declaration(0, "SCHED_FIFO priority of the process; 0 is none", STARTING, 0, 99),
    "executor": Declaration("events", "what delivers the messages", STARTING, allowed=("events", "single")),
    "autostart": Declaration(True, "configure and activate without being told to", STARTING),
}


@dataclass(frozen=True)
class Settings:
    """What was set; fields as in ``DECLARATIONS``, ``dampers`` empty for all."""

    dampers: tuple[str, ...]
    model: str
    signals: str
    cutoff: float
    max_gap: float
    max_age: float
    compensation: float
    stale_after: float
    drift_window: float
    drift_factor: float
    safe_current: float
    desired_force_timeout: float
    command_extrapolating: bool
    command_lag: float
    horizon: float
    lead: float
    record: str
    record_size: int
    record_files: int
    qos_reliability: str
    qos_depth: int
    realtime_priority: int
    executor: str
    autostart: bool


def declare(node: Node, declarations: Mapping[str, Declaration] = DECLARATIONS) -> None:
    """Declares the parameters on the node.

    Raises:
        InputError: one line, where a given value has another type or is out of range.
    """
    for name, declaration in declarations.items():
        descriptor = ParameterDescriptor(
            description=f"{declaration.description} (changes take effect: {declaration.changes})",
            additional_constraints=f"one of {', '.join(declaration.allowed)}" if declaration.allowed else "",
            read_only=declaration.changes == STARTING,
        )
        if isinstance(declaration.low, float):
            low, high = declaration.low, declaration.high
            descriptor.floating_point_range = [FloatingPointRange(from_value=low, to_value=high)]
        elif declaration.low is not None:
            low, high = declaration.low, declaration.high
            descriptor.integer_range = [IntegerRange(from_value=low, to_value=high, step=1)]
        try:
            node.declare_parameter(name, declaration.default, descriptor)
        except (InvalidParameterTypeException, InvalidParameterValueException) as error:
            raise InputError(f"parameter {name}: must be {wanted(declaration)} ({error})") from error


def wanted(declaration: Declaration) -> str:
    """What a value of this parameter must be, in words."""
    if isinstance(declaration.default, tuple):
        return "a list of names"
    if isinstance(declaration.default, bool):
        return "true or false"
    if declaration.allowed:
        return f"one of {', '.join(declaration.allowed)}"
    if declaration.low is None:
        return "text"
    point = ", written with a point (60.0)" if isinstance(declaration.low, float) else ""
    return f"between {declaration.low:g} and {declaration.high:g}{point}"


def read_settings(node: Node, changed: Mapping[str, object] | None = None) -> Settings:
    """The settings as the node's parameters have them, with ``changed`` ones on top.

    Raises:
        InputError: one line with every wrong value and what is allowed.
    """
    values = {f.name: node.get_parameter_or(f.name, Parameter(f.name)).value for f in fields(Settings)}
    values |= {name: value for name, value in (changed or {}).items() if name in values}
    # A parameter file cannot hold an empty list; [''] stands for it.
    values["dampers"] = tuple(filter(None, values["dampers"] or ()))
    faults = (
        []
        if values["model"]
        else ["parameter model is not set; give a model file, a folder, or a name that damper-estimator models lists"]
    )
    faults += _wrong_words(values, DECLARATIONS)
    faults += [
        f"parameter {name} is {values[name]!r}; it must be {wanted(declaration)}"
        for name, declaration in DECLARATIONS.items()
        if isinstance(declaration.low, float) and not isfinite(values[name])
    ]
    if faults:
        raise InputError("; ".join(faults))
    return Settings(**values)


def check_words(node: Node, declarations: Mapping[str, Declaration] = DECLARATIONS) -> None:
    """Checks the parameters that choose among words.

    Raises:
        InputError: one line with every wrong word and what is allowed.
    """
    values = {name: node.get_parameter_or(name, Parameter(name)).value for name in declarations}
    faults = _wrong_words(values, declarations)
    if faults:
        raise InputError("; ".join(faults))


def _wrong_words(values: Mapping[str, object], declarations: Mapping[str, Declaration]) -> list[str]:
    return [
        f"parameter {name} is {values[name]!r}; allowed are {', '.join(declaration.allowed)}"
        for name, declaration in declarations.items()
        if declaration.allowed and values[name] not in declaration.allowed
    ]
