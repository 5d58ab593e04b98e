"""Identify a model's parameters from recordings.

All recordings are taken together. With several dampers, -o is a folder that receives one DAMPER.yaml each.
What the model file fixes stays as it is; --fix fixes more, --free then frees (the later word wins: --fix '*'
--free coulomb.force identifies friction alone). Names may be whole effects, whole vectors, or patterns with *
and ?.

Recordings of several settings (adjuster position, current, gas pressure): --each NAME gives a parameter a
value of its own per setting, all others are shared, and --by says which recording belongs to which: --by
soft=a.mcap --by hard=b.mcap,c.mcap, or --by command (temperature, pressure) where a channel tells. -o is then
a folder with one SETTING.yaml each.

Several objectives: --method nsga2 finds a Pareto front over groups of excitations, formed from velocity and
frequency or given by --group. It is kept in MODEL.front.csv and shown in MODEL.front.html; --pick chooses the
point that becomes the model, and with --front MODEL.front.csv another point is picked without a new search.
"""

import argparse
from collections.abc import Sequence
from pathlib import Path

from damper_estimator.cli.common import (
    STANDARD_OUTPUT,
    add_bags,
    add_json,
    add_models,
    add_signals,
    add_window,
    progress,
    write_json,
)
from damper_estimator.cli.fit_report import as_json, joint_json, joint_table, table
from damper_estimator.errors import InputError
from damper_estimator.files import write_text
from damper_estimator.identification import (
    Fit,
    JointFit,
    Wishes,
    all_methods,
    fit,
    fit_joint,
    load_front,
    settings_by_channel,
)
from damper_estimator.identification.excitations import named
from damper_estimator.model import load_model, save_model
from damper_estimator.recordings import open_bag
from damper_estimator.signals import Measurement, SignalMap, load_signal_map, measure
from damper_estimator.signals.channels import signals_for
from damper_estimator.signals.layout import COMMAND, PRESSURE, TEMPERATURE

_CHANNELS = {"command": COMMAND, "temperature": TEMPERATURE, "pressure": PRESSURE}


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
        help="where the fitted model goes; a folder for several dampers",
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
        "--fix", metavar="NAME", action="append", default=[], help="leave this parameter as it is; may be repeated"
    )
    parser.add_argument(
        "--limit", metavar="NAME=LOW:HIGH", action="append", default=[], help="keep it in there; may be repeated"
    )
    parser.add_argument("--seed", type=int, default=0, help="of the start values that are drawn (default: %(default)s)")
    _add_settings(parser)
    add_signals(parser)
    add_window(parser)
    add_json(parser)


def _add_settings(parser: argparse.ArgumentParser) -> None:
    """Joint fits, and several objectives."""
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
        help=f"the recordings of a setting, may be repeated; or the channel that tells it: {', '.join(_CHANNELS)}",
    )
    groups = parser.add_argument_group(f"several objectives (--method {several})")
    groups.add_argument(
        "--group", metavar="NAME=BAG[,BAG]", action="append", default=[], help="an objective; may be repeated"
    )
    groups.add_argument(
        "--pick", metavar="POINT", help="knee, a group, or a number in the front's file (default: knee)"
    )
    groups.add_argument("--front", metavar="CSV", type=Path, help="a front found before: pick from it, do not search")
    evolution = parser.add_argument_group("evolutionary methods")
    evolution.add_argument("--population", metavar="N", type=_count, help="parameter sets per generation")
    evolution.add_argument("--generations", metavar="N", type=_count, help="how many")


def _count(text: str) -> int:
    number = int(text)
    if number < 4:
        raise ValueError(text)
    return number


def run(arguments: argparse.Namespace) -> int:
    """Fits every damper, then writes all model files."""
    wishes = _wishes(arguments)
    if bool(arguments.each) != bool(arguments.by):
        raise InputError("--each and --by go together: which parameters differ, and between which recordings")
    measurements = read(
        arguments.bags, load_signal_map(arguments.signals), arguments.dampers, arguments.start, arguments.stop
    )
    fitted = _fit_joint if arguments.each else _fit_plain
    records = fitted(arguments, measurements, wishes)
    write_json(arguments.json, {"bags": arguments.bags, "model": arguments.model, "dampers": records})
    return 0


def _wishes(arguments: argparse.Namespace) -> Wishes:
    method = all_methods().get(arguments.method)
    asked = [f"--{name}" for name in ("group", "pick", "front") if getattr(arguments, name)]
    if method is not None and asked and not method.several:
        several = ", ".join(name for name, own in all_methods().items() if own.several)
        raise InputError(f"{', '.join(asked)}: {arguments.method} has a single objective; use --method {several}")
    return Wishes(
        progress=progress,
        groups=_named_bags("--group", arguments.group, arguments.bags),
        pick=arguments.pick or "knee",
        front=load_front(arguments.front) if arguments.front else None,
        generations=arguments.generations,
        population=arguments.population,
    )


def limits_of(words: Sequence[str]) -> dict[str, tuple[float, float]]:
    """Lowest and highest value by name from words ``NAME=LOW:HIGH``; a side that is left out is open."""
    found = {}
    for word in words:
        name, _, ends = word.rpartition("=")
        low, colon, high = ends.partition(":")
        try:
            found[name] = (float(low or "-inf"), float(high or "inf"))
        except ValueError:
            colon = ""
        if not name or not colon:
            raise InputError(f"--limit {word}: is not NAME=LOW:HIGH, such as bouc_wen.n=1.5:8")
    return found


def _named_bags(option: str, words: Sequence[str], bags: Sequence[Path]) -> dict[str, tuple[str, ...]]:
    """Recordings by name from words ``NAME=BAG[,BAG]``; a name may come several times.

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
    arguments: argparse.Namespace, measurements: dict[str, list[Measurement]], wishes: Wishes
) -> dict[str, object]:
    targets = output_paths(arguments.output, list(measurements))
    fits: dict[str, Fit] = {}
    for damper, own in measurements.items():
        model = load_model(arguments.model, damper)
        progress(f"{damper}: fitting {model.name} to {len(own)} recording{'s' if len(own) > 1 else ''}")
        chosen = (arguments.free, arguments.fix, arguments.method, arguments.seed)
        fits[damper] = fit(model, own, *chosen, wishes=wishes, limits=limits_of(arguments.limit))
    for damper, result in fits.items():
        save(result, targets[damper])
        if arguments.json != STANDARD_OUTPUT:
            print(table(damper, result, targets[damper]))
    return {damper: as_json(result, targets[damper]) for damper, result in fits.items()}


def _fit_joint(
    arguments: argparse.Namespace, measurements: dict[str, list[Measurement]], wishes: Wishes
) -> dict[str, object]:
    if arguments.output.suffix in (".yaml", ".yml"):
        raise InputError(f"{arguments.output}: is one file, but each setting gets its own; name a folder")
    joint: dict[str, JointFit] = {}
    for damper, own in measurements.items():
        model = load_model(arguments.model, damper)
        settings = _settings(arguments, own)
        progress(f"{damper}: fitting {model.name} to {len(own)} recordings, {len(set(settings))} settings")
        joint[damper] = fit_joint(
            model, own, settings, arguments.each, arguments.free, arguments.fix, arguments.method, arguments.seed,
            wishes=wishes, limits=limits_of(arguments.limit),
        )  # fmt: skip
    records = {}
    for damper, result in joint.items():
        folder = arguments.output / damper if len(joint) > 1 else arguments.output
        targets = {setting: folder / f"{setting}.yaml" for setting in result.fits}
        for setting, own in result.fits.items():
            save(own, targets[setting])
        if arguments.json != STANDARD_OUTPUT:
            print(joint_table(damper, result, folder))
        records[damper] = joint_json(result, targets)
    return records


def _settings(arguments: argparse.Namespace, measurements: Sequence[Measurement]) -> list[str]:
    """The setting of each recording."""
    if len(arguments.by) == 1 and arguments.by[0] in _CHANNELS:
        return settings_by_channel(measurements, _CHANNELS[arguments.by[0]], arguments.by[0])
    given = _named_bags("--by", arguments.by, arguments.bags)
    settings = []
    for own in measurements:
        names = [name for name, bags in given.items() if named(own.recording, bags)]
        if len(names) != 1:
            where = f"settings {', '.join(names)}" if names else "no setting"
            raise InputError(f"{own.recording}: is in {where}; name it in one --by SETTING=BAG[,BAG]")
        settings += names
    return settings


def save(result: Fit, target: Path) -> None:
    """Writes the model, and its front beside it where there is one."""
    target.parent.mkdir(parents=True, exist_ok=True)
    save_model(result.model, target)
    if result.front is not None:
        from damper_estimator.report.front_page import front_page

        front = result.front
        write_text(target.with_suffix(".front.csv"), front.as_csv())
        page = front_page(result.model.name, front.groups, front.objectives, front.picked, front.regimes())
        write_text(target.with_suffix(".front.html"), page)


def read(
    paths: Sequence[Path], signal_map: SignalMap, wanted: Sequence[str], start: float | None, stop: float | None
) -> dict[str, list[Measurement]]:
    """Measurements by damper, one for every bag that has it.

    A damper whose force was not measured is left out, unless it is asked for by name: then it is an error.

    Raises:
        InputError: where a wanted damper, or the force of all, is missing.
    """
    window = (0.0 if start is None else start, float("inf") if stop is None else stop)
    found: dict[str, list[Measurement]] = {}
    for path in paths:
        with open_bag(path) as bag:
            there = signals_for(bag, signal_map).dampers
            for damper in wanted or there:
                measurement = measure(bag, signal_map, damper, *window, force_wanted=damper in wanted)
                if measurement.force is None:
                    progress(f"{path}: the force of {damper} was not measured; left out")
                else:
                    found.setdefault(damper, []).append(measurement)
    if not found:
        raise InputError(f"{paths[0]}: no damper has a measured force; fit needs one (name its topic in a signal map)")
    return found


def output_paths(output: Path, dampers: list[str]) -> dict[str, Path]:
    """Where each damper's model goes: into the folder ``output``, or to the file ``output`` where there is one damper.

    Raises:
        InputError: for one file and several dampers.
    """
    if output.is_dir() or (len(dampers) > 1 and output.suffix not in (".yaml", ".yml")):
        return {damper: output / f"{damper}.yaml" for damper in dampers}
    if len(dampers) > 1:
        raise InputError(
            f"{output}: is one file, but there are dampers {', '.join(dampers)}; name a folder, or choose one with -d"
        )
    return {dampers[0]: output}
