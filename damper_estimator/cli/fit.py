"""Identify a model's parameters from recordings.

All recordings are fitted together. With several dampers, -o is a folder that receives one DAMPER.yaml each.
Parameters that the model file fixes are not identified; --fix fixes more, --free overrides both (--fix '*' --free
coulomb.force identifies friction alone). Names may be whole effects, whole vectors, or patterns with * and ?.

Recordings at several settings (adjuster position, current, gas pressure): --each NAME identifies a separate value of
a parameter for each setting, all others are shared, and --by assigns the recordings: --by soft=a.mcap --by
hard=b.mcap,c.mcap, or --by command (temperature, pressure) if a channel determines the setting. -o is then a folder
with one SETTING.yaml each.

Several objectives: --method nsga2 finds a Pareto front over groups of excitations, formed from velocity and
frequency or given by --group. The front is stored in MODEL.front.csv and shown in MODEL.front.html; --pick selects the
point that becomes the model, and --front MODEL.front.csv picks another point without a new search.
"""

import argparse
from collections.abc import Mapping, Sequence
from pathlib import Path

from damper_estimator.cli.data_finding_text import spoiled
from damper_estimator.cli.fit_option_values import check_objectives, limits_of
from damper_estimator.cli.fit_report import joint_table, table
from damper_estimator.cli.verb_support import (
    add_bags,
    add_models,
    add_reading,
    at_least,
    prints_text,
    progress,
    read_recordings,
    report_notes,
    write_json,
)
from damper_estimator.errors import InputError
from damper_estimator.identification import all_methods, load_front, named
from damper_estimator.workflows import (
    CHANNELS,
    FitOptions,
    Recording,
    fit_jointly,
    fit_record,
    fit_with,
    output_paths,
    save_fit,
)

EXAMPLES = (
    "fit hidden_base.mcap -m viscous_curve -o mine.yaml",
    "fit semi_active_random.mcap -m semi_active_yield -o semi_active.yaml --json fit.json",
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the verb's arguments."""
    add_bags(parser)
    add_models(parser)
    parser.add_argument(
        "-o",
        "--output",
        metavar="MODEL.yaml",
        type=Path,
        required=True,
        help="file for the fitted model; a folder for several dampers",
    )
    parser.add_argument(
        "--method", default="least_squares", help=f"one of {', '.join(all_methods())} (default: %(default)s)"
    )
    parser.add_argument(
        "--free",
        metavar="NAME",
        action="append",
        default=[],
        help="identify this parameter although it is fixed; may be repeated",
    )
    parser.add_argument(
        "--fix", metavar="NAME", action="append", default=[], help="do not identify this parameter; may be repeated"
    )
    parser.add_argument(
        "--limit", metavar="NAME=LOW:HIGH", action="append", default=[], help="limits of a parameter; may be repeated"
    )
    parser.add_argument("--seed", type=int, default=0, help="of the random start values (default: %(default)s)")
    _add_settings(parser)
    add_reading(parser)


def _add_settings(parser: argparse.ArgumentParser) -> None:
    """Options of joint fits and of several objectives."""
    several = ", ".join(name for name, method in all_methods().items() if method.several)
    joint = parser.add_argument_group("several settings of one damper")
    joint.add_argument(
        "--each", metavar="NAME", action="append", default=[], help="identify it per setting; may be repeated"
    )
    joint.add_argument(
        "--by",
        metavar="SETTING=BAG[,BAG]",
        action="append",
        default=[],
        help=f"the recordings of a setting, may be repeated; or the channel that determines it: {', '.join(CHANNELS)}",
    )
    groups = parser.add_argument_group(f"several objectives (--method {several})")
    groups.add_argument(
        "--group", metavar="NAME=BAG[,BAG]", action="append", default=[], help="an objective; may be repeated"
    )
    groups.add_argument(
        "--pick", metavar="POINT", help="knee, a group, or a number in the front's file (default: knee)"
    )
    groups.add_argument("--front", metavar="CSV", type=Path, help="an earlier front: pick from it without a new search")
    evolution = parser.add_argument_group("evolutionary methods")
    evolution.add_argument("--population", metavar="N", type=at_least(4), help="parameter sets per generation")
    evolution.add_argument("--generations", metavar="N", type=at_least(4), help="number of generations")


def run(arguments: argparse.Namespace) -> int:
    """Fits every damper, then writes all model files."""
    options = _options(arguments)
    if bool(arguments.each) != bool(arguments.by):
        raise InputError(
            "--each and --by require each other: name the parameters that differ, and the recordings of each setting"
        )
    recording = read_recordings(arguments).with_force("fit")
    report_notes(recording.notes)
    report_notes(spoiled(recording))
    records = (_fit_joint if arguments.each else _fit_plain)(arguments, recording, options)
    write_json(arguments.json, {"bags": arguments.bags, "model": arguments.model, "dampers": records})
    return 0


def _options(arguments: argparse.Namespace) -> FitOptions:
    given = [f"--{name}" for name in ("group", "pick", "front") if getattr(arguments, name)]
    check_objectives(arguments.method, given)
    return FitOptions(
        free=tuple(arguments.free),
        fix=tuple(arguments.fix),
        limits=limits_of(arguments.limit),
        method=arguments.method,
        seed=arguments.seed,
        groups=_named_bags("--group", arguments.group, arguments.bags),
        pick=arguments.pick or "knee",
        front=load_front(arguments.front) if arguments.front else None,
        population=arguments.population,
        generations=arguments.generations,
    )


def _named_bags(option: str, words: Sequence[str], bags: Sequence[Path]) -> dict[str, tuple[str, ...]]:
    """Recordings by name from words ``NAME=BAG[,BAG]``; a name may be repeated.

    Raises:
        InputError: for another form, and for a bag that is not among those to fit to.
    """
    found: dict[str, tuple[str, ...]] = {}
    for word in words:
        name, _, listed = word.partition("=")
        given = tuple(bag for bag in listed.split(",") if bag)
        if not given or not name or not all(c.isalnum() or c in "._+-" for c in name):
            raise InputError(f"{option} {word}: is not NAME=BAG[,BAG] with a name of letters, digits, . _ + -")
        unknown = [bag for bag in given if not any(named(str(known), [bag]) for known in bags)]
        if unknown:
            raise InputError(f"{option} {word}: {', '.join(unknown)} is not among the recordings to fit to")
        found[name] = found.get(name, ()) + given
    return found


def _fit_plain(
    arguments: argparse.Namespace, recording: Recording, options: FitOptions
) -> Mapping[str, Mapping[str, object]]:
    targets = output_paths(arguments.output, recording.dampers)
    fits = {
        damper: result.fit
        for damper, result in fit_with(recording, arguments.model, options, progress).by_damper.items()
    }
    for damper, fitted in fits.items():
        save_fit(fitted, targets[damper])
        if prints_text(arguments):
            print(table(damper, fitted, targets[damper]))
    return {damper: fit_record(fitted, targets[damper]) for damper, fitted in fits.items()}


def _fit_joint(
    arguments: argparse.Namespace, recording: Recording, options: FitOptions
) -> Mapping[str, Mapping[str, object]]:
    if arguments.output.suffix in (".yaml", ".yml"):
        raise InputError(f"{arguments.output}: is one file, but each setting needs its own; name a folder")
    channel = arguments.by[0] if len(arguments.by) == 1 and arguments.by[0] in CHANNELS else None
    settings = channel or _named_bags("--by", arguments.by, arguments.bags)
    found = fit_jointly(recording, arguments.model, arguments.each, settings, options, progress)
    found.save(arguments.output)
    for damper, folder in found.folders(arguments.output).items():
        if prints_text(arguments):
            print(joint_table(damper, found.fits[damper], folder))
    return found.records(arguments.output)
