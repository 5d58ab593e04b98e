"""Compare, diagnose, fit or replay thousands of recordings on all cores or on a cluster.

Every recording and damper is a task for a worker of Dask distributed; without --scheduler workers are started on this
machine. DIR receives rows/VERB.parquet (a row per recording and damper), tasks/ (what the verb itself writes for each)
and index.html (the fleet's page). A second run does only what is missing or changed; what failed is tried again when
its recording, model, map or options change, or with --retry. A recording that fails is listed with its reason and
stops nothing: the exit status is 1 only where no task at all went well, or results cannot be written.
"""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from damper_estimator.cli.common import STANDARD_OUTPUT, add_json, add_models, add_signals, add_window, write_json
from damper_estimator.cli.fit_words import check_objectives, limits_of
from damper_estimator.errors import InputError

if TYPE_CHECKING:
    from damper_estimator.fleet.task import Options

EXAMPLES = (
    "fleet compare 'passenger_*.mcap' -m mine.yaml -o fleet",
    "fleet fit 'cars/**/*.mcap' -m viscous_curve -o fleet --joint vehicle",
)
_LISTED = 20  # failures that are printed

# The options of each verb beside the window.
_OPTIONS = {
    "compare": {},
    "diagnose": {
        "--keep-parameters": {"action": "store_true", "help": "the model's parameters were right: what is new?"},
        "--refit": {"action": "store_true", "help": "judge every effect refitted with the model"},
    },
    "fit": {
        "--method": {"default": "least_squares", "help": "as of fit (default: %(default)s)"},
        "--free": {"metavar": "NAME", "action": "append", "default": [], "help": "identify although it is fixed"},
        "--fix": {"metavar": "NAME", "action": "append", "default": [], "help": "leave as it is; may be repeated"},
        "--limit": {"metavar": "NAME=LOW:HIGH", "action": "append", "default": [], "help": "keep it in there"},
        "--seed": {"type": int, "default": 0, "help": "of the start values that are drawn (default: %(default)s)"},
        "--population": {"metavar": "N", "type": int, "help": "parameter sets per generation (evolutionary methods)"},
        "--generations": {"metavar": "N", "type": int, "help": "how many (evolutionary methods)"},
        "--pick": {"metavar": "POINT", "help": "of the front (--method nsga2): knee, or a group"},
    },
    "replay": {"--max-gap": {"metavar": "S", "type": float, "help": "a longer gap between stamps resets the state"}},
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """One command for each verb that works on fleets."""
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
                help="one model per damper, or per vehicle and damper, identified on all its recordings together where "
                "they lie, into DIR/models; then every recording is compared with it",
            )  # fmt: skip
        _add_cluster(command)
        add_json(command)


def _add_cluster(command: argparse.ArgumentParser) -> None:
    group = command.add_argument_group("cluster")
    where = group.add_mutually_exclusive_group()
    where.add_argument("--scheduler", metavar="ADDRESS", help="of a Dask scheduler that is there: tcp://HOST:8786")
    where.add_argument("--workers", metavar="N", type=_positive, help="started here (default: one per core)")
    group.add_argument(
        "--memory", metavar="SIZE", default="auto",
        help="limit of each worker that is started here, such as 2GiB (default: this machine's, shared)",
    )  # fmt: skip
    group.add_argument("--retry", action="store_true", help="try what failed before again, although nothing changed")
    group.add_argument("--no-pages", action="store_true", help="write no page per recording and damper")


def _positive(text: str) -> int:
    number = int(text)
    if number < 1:
        raise ValueError(text)
    return number


def run(arguments: argparse.Namespace) -> int:
    """Does the work; see the module's docstring."""
    try:
        from damper_estimator.cli.fleet_run import run_fleet
    except ModuleNotFoundError as error:
        if (error.name or "").partition(".")[0] not in ("distributed", "dask", "pyarrow"):
            raise
        raise InputError(
            f"fleet needs {error.name}, which is not installed: pip install 'damper_estimator[fleet]'"
        ) from error
    done = run_fleet(arguments, _options(arguments))
    record = done.record()
    if arguments.json != STANDARD_OUTPUT:
        for fit in done.fits:
            print(fit)
        print(f"{done.summary}\nrows in {record['rows']}, page {record['page']}")
        failures = record["failures"]
        for row in failures[:_LISTED]:
            print(f"  failed: {row['recording']} {row['damper']}: {row['reason']}")
        if len(failures) > _LISTED:
            print(f"  and {len(failures) - _LISTED} more; see the page")
    write_json(arguments.json, record)
    return 1 if record["tasks"] and record["failed"] == record["tasks"] else 0


def _options(arguments: argparse.Namespace) -> "Options":
    """What is done with every recording."""
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
