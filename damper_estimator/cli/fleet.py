"""Compare, diagnose, fit or replay thousands of recordings on all cores or on a cluster.

Each recording and damper is a task for a worker of Dask distributed; without --scheduler, workers are started on this
machine. DIR receives rows/VERB.parquet (a row per recording and damper), tasks/ (the files of the verb for each) and
index.html (the fleet's page). A second run executes only missing or changed tasks; failed ones are tried again when
their recording, model, map or options change, or with --retry. A failed recording is listed with the reason and does
not stop the run: the exit status is 1 only if every task failed, or results cannot be written.
"""

import argparse
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from damper_estimator.cli.fit_option_values import check_objectives, limits_of
from damper_estimator.cli.verb_support import (
    above_zero,
    add_json,
    add_models,
    add_signals,
    add_window,
    at_least,
    optional_packages,
    prints_text,
    write_json,
)

if TYPE_CHECKING:
    from damper_estimator.fleet.task import Options

EXAMPLES = (
    "fleet compare 'passenger_*.mcap' -m mine.yaml -o fleet",
    "fleet fit 'cars/**/*.mcap' -m viscous_curve -o fleet --joint vehicle",
)
_LISTED = 20  # failures, and spoiled recordings, printed

# The options of each verb besides the window.
_OPTIONS = {
    "compare": {},
    "diagnose": {
        "--keep-parameters": {"action": "store_true", "help": "judge effects with unchanged parameters"},
        "--refit": {"action": "store_true", "help": "judge every effect refitted with the model"},
    },
    "fit": {
        "--method": {"default": "least_squares", "help": "as for fit (default: %(default)s)"},
        "--free": {"metavar": "NAME", "action": "append", "default": [], "help": "identify although it is fixed"},
        "--fix": {"metavar": "NAME", "action": "append", "default": [], "help": "do not identify; may be repeated"},
        "--limit": {"metavar": "NAME=LOW:HIGH", "action": "append", "default": [], "help": "limits of a parameter"},
        "--seed": {"type": int, "default": 0, "help": "of the random start values (default: %(default)s)"},
        "--population": {"metavar": "N", "type": int, "help": "parameter sets per generation (evolutionary methods)"},
        "--generations": {"metavar": "N", "type": int, "help": "number of generations (evolutionary methods)"},
        "--pick": {"metavar": "POINT", "help": "point of the front (--method nsga2): knee, or a group"},
    },
    "replay": {
        "--max-gap": {"metavar": "S", "type": above_zero, "help": "a longer gap between stamps resets the state"},
    },
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """One subcommand for each verb that fleets support."""
    commands = parser.add_subparsers(dest="work", metavar="compare|diagnose|fit|replay", required=True)
    for verb, options in _OPTIONS.items():
        text = f"{verb} every recording and damper"
        command = commands.add_parser(verb, help=text, description=text, allow_abbrev=False)
        command.add_argument(
            "sources", metavar="MANIFEST_OR_GLOB", nargs="+",
            help="a manifest (.yaml, .csv: recording, vehicle, dampers, signals, model), a pattern such as "
            "'cars/**/*.mcap' (the folder names the vehicle), or recordings",
        )  # fmt: skip
        add_models(command)
        command.add_argument("-o", "--output", metavar="DIR", type=Path, required=True, help="folder of the results")
        add_signals(command)
        add_window(command)
        for flag, settings in options.items():
            command.add_argument(flag, **settings)
        if verb == "fit":
            command.add_argument(
                "--joint", choices=("damper", "vehicle"),
                help="one model per damper, or per vehicle and damper, identified on all its recordings by the "
                "workers, into DIR/models; then every recording is compared with it",
            )  # fmt: skip
        _add_cluster(command)
        add_json(command)


def _add_cluster(command: argparse.ArgumentParser) -> None:
    group = command.add_argument_group("cluster")
    where = group.add_mutually_exclusive_group()
    where.add_argument("--scheduler", metavar="ADDRESS", help="address of a running Dask scheduler: tcp://HOST:8786")
    where.add_argument(
        "--workers", metavar="N", type=at_least(1), help="number of local workers (default: one per core)"
    )
    group.add_argument(
        "--memory", metavar="SIZE", default="auto",
        help="limit of each local worker, such as 2GiB (default: an equal share of the memory)",
    )  # fmt: skip
    group.add_argument("--retry", action="store_true", help="try failed tasks again although nothing changed")
    group.add_argument("--no-pages", action="store_true", help="do not write a page per recording and damper")


def run(arguments: argparse.Namespace) -> int:
    """Runs the verb on the fleet."""
    with optional_packages("fleet", "fleet", ("distributed", "dask", "pyarrow")):
        from damper_estimator.cli.fleet_run import run_fleet
    done = run_fleet(arguments, _options(arguments))
    record = done.record()
    if prints_text(arguments):
        for fit in done.fits:
            print(fit)
        print(f"{done.summary}\nrows in {record['rows']}, page {record['page']}")
        _print_rows("failed", record["failures"], "reason")
        _print_rows("data", record["spoiled"], "spoiled")
    write_json(arguments.json, record)
    return 1 if record["tasks"] and record["failed"] == record["tasks"] else 0


def _print_rows(what: str, rows: Sequence[Mapping[str, str]], text: str) -> None:
    for row in rows[:_LISTED]:
        print(f"  {what}: {row['recording']} {row['damper']}: {row[text]}")
    if len(rows) > _LISTED:
        print(f"  and {len(rows) - _LISTED} more; see the page")


def _options(arguments: argparse.Namespace) -> "Options":
    """The verb and its options."""
    from damper_estimator.fleet.verbs import Compare, Diagnose, Fit, Replay
    from damper_estimator.workflows import FitOptions

    window = (arguments.start, arguments.stop)
    if arguments.work == "diagnose":
        kept, refit = arguments.keep_parameters, arguments.refit
        return Diagnose(*window, "both" if kept == refit else "kept" if kept else "refit")
    if arguments.work == "replay":
        return Replay(*window, arguments.max_gap)
    if arguments.work == "compare":
        return Compare(*window)
    check_objectives(arguments.method, ["--pick"] if arguments.pick else [])
    how = FitOptions(
        free=tuple(arguments.free),
        fix=tuple(arguments.fix),
        limits=limits_of(arguments.limit),
        method=arguments.method,
        seed=arguments.seed,
        pick=arguments.pick or FitOptions.pick,
        population=arguments.population,
        generations=arguments.generations,
    )
    return Fit(*window, how)
