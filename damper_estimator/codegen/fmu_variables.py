"""The variables of an FMU: inputs, outputs and parameters with the value references of ``fmi/unit.h``."""

from dataclasses import dataclass

from damper_estimator.codegen.c_source import Damper
from damper_estimator.runtime.damper_record import SLOW

FIRST_INPUT, FIRST_OUTPUT, FIRST_INTEGER, REACHED, FIRST_PARAMETER = 1, 100, 200, 300, 1000


@dataclass(frozen=True)
class Input:
    """One of the inputs of ``unit.h``; ``present`` if the damper's force depends on it."""

    name: str
    unit: str
    meaning: str
    start: float
    present: bool


@dataclass(frozen=True)
class Output:
    """An output; ``kind`` is Real, Integer or Boolean."""

    name: str
    unit: str
    meaning: str
    reference: int
    kind: str = "Real"


@dataclass(frozen=True)
class Unit:
    """One FMU.

    Attributes:
        name: the model identifier.
        tunable: for every slot of the model.
    """

    name: str
    damper: Damper
    version: str
    token: str
    tunable: tuple[bool, ...]
    inputs: tuple[Input, ...]


def inputs_of(damper: Damper) -> tuple[Input, ...]:
    """The inputs in order of ``unit.h``."""
    matters = {role: damper.deployed.memories[role] is not None for role in SLOW}
    inverts = damper.limits is not None
    low = damper.limits[0] if damper.limits else 0.0
    return (
        Input("displacement", "m", "of the damper, positive in extension", 0.0, True),
        Input("command", "A", "that acts until the next step", low, matters["command"]),
        Input("temperature", "degC", "of the damper", 20.0, matters["temperature"]),
        Input("pressure", "Pa", "of the gas", 1e5, matters["pressure"]),
        Input("desired_force", "N", "for which a command is computed", 0.0, inverts),
    )


def outputs_of(damper: Damper) -> tuple[Output, ...]:
    """The outputs of this damper, with their references."""
    reals = [
        ("filtered_displacement", "m", "behind the filter"),
        ("velocity", "m/s", "behind the filter"),
        ("acceleration", "m/s2", "behind the filter"),
        ("force", "N", "of the damper, positive when it resists extension"),
        ("force_stddev", "N", "three of it cover the errors of the fit; 0 if unknown"),
    ]
    if damper.limits is not None:
        reals += [
            ("force_min", "N", "lowest force that a command can reach"),
            ("force_max", "N", "highest force that a command can reach"),
            ("dforce_dvelocity", "N.s/m", "slope of the force over velocity"),
            ("dforce_dcurrent", "N/A", "slope of the force over the command"),
            ("current", "A", "command that gives the desired force"),
            ("expected", "N", "force that this command will reach"),
        ]
    numbers = [Output(*entry, FIRST_OUTPUT + i) for i, entry in enumerate(reals)]
    integers = [
        ("status", "0 GOOD, 1 WARMING_UP, 2 EXTRAPOLATING, 3 DEGRADED"),
        ("trusted", "the same regardless of the command's present value"),
        ("verdict", "treatment of the sample: 0 to 3 used, 4 a repeated stamp"),
    ]
    numbers += [Output(n, "", meaning, FIRST_INTEGER + i, "Integer") for i, (n, meaning) in enumerate(integers)]
    if damper.limits is not None:
        numbers.append(Output("reached", "", "whether the expected force is the desired one", REACHED, "Boolean"))
    return tuple(numbers)
