"""Declares parameters on a node, and reads them, checked together, as frozen settings."""

from collections.abc import Mapping
from dataclasses import fields
from math import isfinite

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.exceptions import InvalidParameterTypeException, InvalidParameterValueException
from rclpy.node import Node
from rclpy.parameter import Parameter

from damper_estimator.errors import InputError
from damper_estimator.node.parameter import STARTING, Declaration
from damper_estimator.node.settings import DECLARATIONS, Settings


def declare(node: Node, declarations: Mapping[str, Declaration]) -> None:
    """Declares the parameters on the node.

    Raises:
        InputError: one line, if a given value has another type or is out of range.
    """
    for name, declaration in declarations.items():
        try:
            node.declare_parameter(name, declaration.default, _descriptor(declaration))
        except (InvalidParameterTypeException, InvalidParameterValueException) as error:
            raise InputError(f"parameter {name}: must be {declaration.requirement} ({error})") from error


def _descriptor(declaration: Declaration) -> ParameterDescriptor:
    descriptor = ParameterDescriptor(
        description=f"{declaration.description} (changes take effect: {declaration.changes})",
        additional_constraints=f"one of {', '.join(declaration.allowed)}" if declaration.allowed else "",
        read_only=declaration.changes == STARTING,
    )
    low, high = declaration.low, declaration.high
    if isinstance(low, float):
        descriptor.floating_point_range = [FloatingPointRange(from_value=low, to_value=high)]
    elif low is not None:
        descriptor.integer_range = [IntegerRange(from_value=low, to_value=high, step=1)]
    return descriptor


def read_settings(node: Node, changed: Mapping[str, object] | None = None) -> Settings:
    """The settings from the node's parameters, with the ``changed`` ones replaced.

    Raises:
        InputError: one line with every wrong value and what is allowed.
    """
    values = {f.name: node.get_parameter_or(f.name, Parameter(f.name)).value for f in fields(Settings)}
    values |= {name: value for name, value in (changed or {}).items() if name in values}
    values["dampers"] = tuple(values["dampers"] or ())
    faults = (
        []
        if values["model"]
        else ["parameter model is not set; give a model file, a folder, or a name that damper-estimator models lists"]
    )
    faults += _wrong_words(values, DECLARATIONS)
    faults += [
        f"parameter {name} is {values[name]!r}; it must be {declaration.requirement}"
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
