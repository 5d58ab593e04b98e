"""Export a model as C for controllers, as an FMU for simulation, or as force-velocity tables for other programs.

--c writes NAME.h and NAME.c (C99, no allocation): the complete line from raw displacement to force, standard deviation
and status, and the inverse if the model has a command. --fmu writes a functional mock-up unit for co-simulation with
the same code. --tables writes force_velocity.csv and, for multibody programs, a damper property file (.dpr, [CURVE] in
mm/s and N) for each current and temperature: forces of steady motion through one displacement (--displacement), with
the middle of the loops in place of hysteresis. Beyond the velocities of the fit the tables continue linearly; all
points outside the region of validity are marked. docs/export.md has examples.
"""

import argparse
from pathlib import Path

import numpy as np

from damper_estimator.cli.export_code import add_code_arguments, write_code
from damper_estimator.cli.verb_support import add_json, add_signals, prints_text, write_json
from damper_estimator.errors import InputError
from damper_estimator.model import load_model
from damper_estimator.model.force_table import force_table, write_tables

EXAMPLES = (
    "export mine.yaml --c controller",
    "export mine.yaml --tables tables --velocity 0.05,0.1,0.3,1.0",
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """``MODEL --c DIR --fmu FILE --tables DIR``, and the options of each."""
    parser.add_argument("model", metavar="MODEL", help="a model's name or a model file (YAML)")
    parser.add_argument("--c", metavar="DIR", type=Path, help="folder for the C files")
    parser.add_argument("--fmu", metavar="FILE.fmu", type=Path, help="the FMU to write")
    parser.add_argument("--tables", metavar="DIR", type=Path, help="folder for the tables")
    add_code_arguments(parser.add_argument_group("C and FMU"))
    add_signals(parser)
    add_table_arguments(parser.add_argument_group("tables"))
    add_json(parser)


def add_table_arguments(parser: argparse._ArgumentGroup) -> None:
    """The grid of the tables."""
    parser.add_argument(
        "--velocity",
        metavar="M/S",
        type=numbers,
        default=(),
        help="velocities separated by commas (default: over the region of the fit, else -1 to 1)",
    )
    parser.add_argument(
        "--current",
        metavar="A",
        type=numbers,
        default=(),
        help="commands separated by commas (default: five over the region of the fit)",
    )
    parser.add_argument(
        "--temperature",
        metavar="C",
        type=numbers,
        default=(),
        help="temperatures separated by commas (default: five over the region of the fit)",
    )
    parser.add_argument(
        "--displacement",
        metavar="M",
        type=float,
        default=0.0,
        help="position of the steady motion (default: %(default)s)",
    )


def numbers(text: str) -> tuple[float, ...]:
    """Numbers separated by commas."""
    return tuple(float(part) for part in text.split(","))


def run(arguments: argparse.Namespace) -> int:
    """Writes the requested files."""
    if arguments.c is None and arguments.fmu is None and arguments.tables is None:
        raise InputError(f"{arguments.model}: choose an output: --c DIR, --fmu FILE.fmu or --tables DIR")
    written = {}
    if arguments.c is not None or arguments.fmu is not None:
        written = write_code(arguments)
    if arguments.tables is not None:
        written |= _write_table_files(arguments)
    write_json(arguments.json, written)
    return 0


def _write_table_files(arguments: argparse.Namespace) -> dict[str, object]:
    """Writes the tables; returns their results for JSON."""
    model = load_model(arguments.model)
    if not np.isfinite([*arguments.velocity, *arguments.current, *arguments.temperature, arguments.displacement]).all():
        raise InputError(
            f"{arguments.model}: velocities, currents, temperatures and displacement must be finite numbers"
        )
    velocity = np.array(arguments.velocity) if arguments.velocity else None
    table = force_table(model, velocity, arguments.current, arguments.temperature, arguments.displacement)
    written = write_tables(model, table, arguments.tables)
    if prints_text(arguments):
        v = table.velocity
        print(
            f"{model.name}: {v.size} velocities from {v[0]:g} to {v[-1]:g} m/s, {table.commands.size} "
            f"command(s), {table.temperatures.size} temperature(s)"
        )
        print(f"  steady force at {1e3 * table.displacement:g} mm without hysteresis: the middle of the model's loops")
        if table.inside is not None and not table.inside.all():
            print(f"  {np.sum(~table.inside)} of {table.inside.size} points lie outside the region of the fit")
        for path in written:
            print(f"  {path}")
    grid = {
        "velocity_m_s": table.velocity,
        "command": table.commands,
        "temperature_degc": table.temperatures,
        "force_n": table.force,
        "in_region": table.inside,
    }
    return {"model": model.name, "displacement_m": table.displacement, "files": written, **grid}
