"""Export a model as force-velocity tables, per current and temperature, for other programs.

Forces are those of a steady passage through one displacement: hysteresis is replaced by the middle of its loops, and
what depends on position is taken at --displacement. Writes force_velocity.csv and, for multibody programs, a damper
property file (.dpr, [CURVE] in mm/s and N) for each current and temperature. At velocities outside the region of the
fit the tables go on straight from its edge; all points outside the region are marked in the files.
"""

import argparse
from pathlib import Path

import numpy as np

from damper_estimator.cli.common import STANDARD_OUTPUT, add_json, write_json
from damper_estimator.errors import InputError
from damper_estimator.model import load_model
from damper_estimator.model.export import force_table, write_tables


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """``MODEL --tables DIR`` and the grid."""
    parser.add_argument("model", metavar="MODEL", help="a model's name or a model file (YAML)")
    parser.add_argument("--tables", metavar="DIR", type=Path, required=True, help="folder that receives the files")
    parser.add_argument(
        "--velocity",
        metavar="M/S",
        type=numbers,
        default=(),
        help="velocities, separated by commas (default: over the region of the fit, else -1 to 1)",
    )
    parser.add_argument(
        "--current",
        metavar="A",
        type=numbers,
        default=(),
        help="commands, separated by commas (default: five over the region of the fit)",
    )
    parser.add_argument(
        "--temperature",
        metavar="C",
        type=numbers,
        default=(),
        help="temperatures, separated by commas (default: five over the region of the fit)",
    )
    parser.add_argument(
        "--displacement", metavar="M", type=float, default=0.0, help="where the motion passes (default: %(default)s)"
    )
    add_json(parser)


def numbers(text: str) -> tuple[float, ...]:
    """Numbers separated by commas."""
    return tuple(float(part) for part in text.split(","))


def run(arguments: argparse.Namespace) -> int:
    """Writes the tables."""
    model = load_model(arguments.model)
    if not np.isfinite([*arguments.velocity, *arguments.current, *arguments.temperature, arguments.displacement]).all():
        raise InputError(
            f"{arguments.model}: velocities, currents, temperatures and displacement must be finite numbers"
        )
    velocity = np.array(arguments.velocity) if arguments.velocity else None
    table = force_table(model, velocity, arguments.current, arguments.temperature, arguments.displacement)
    written = write_tables(model, table, arguments.tables)
    if arguments.json != STANDARD_OUTPUT:
        v = table.velocity
        print(
            f"{model.name}: {v.size} velocities from {v[0]:g} to {v[-1]:g} m/s, {table.commands.size} "
            f"command(s), {table.temperatures.size} temperature(s)"
        )
        print(f"  steady force through {1e3 * table.displacement:g} mm, no memory: the middle of the model's loops")
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
    write_json(arguments.json, {"model": model.name, "displacement_m": table.displacement, "files": written, **grid})
    return 0
