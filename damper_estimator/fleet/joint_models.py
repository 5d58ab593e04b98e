"""``fleet fit --joint``: one model per damper, or per vehicle and damper, identified on all its recordings together."""

import argparse
import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from distributed import Client

from damper_estimator import __version__
from damper_estimator.cli.common import progress
from damper_estimator.cli.fit_report import table
from damper_estimator.cli.limits import limits_of
from damper_estimator.errors import InputError
from damper_estimator.files import plain, write_text
from damper_estimator.fleet.held import Source
from damper_estimator.fleet.joint import fit_spread
from damper_estimator.fleet.manifest import Recording
from damper_estimator.fleet.task import Task, digest
from damper_estimator.identification import Wishes
from damper_estimator.model import load_model
from damper_estimator.workflows import fit_record, save_fit

MODELS = "models"


def joint_models(
    client: Client, tasks: Sequence[Task], arguments: argparse.Namespace, words: Sequence[str]
) -> list[str]:
    """Identifies every model that is missing or for which something changed, into ``DIR/models``.

    Args:
        tasks: one for each recording and damper that there is.
        words: the options of the fit.

    Returns:
        what is to be printed of each fit.

    Raises:
        InputError: where a model cannot be identified on any of its recordings.
    """
    groups: dict[Path, list[Task]] = {}
    for task in tasks:
        if task.damper:
            folder = model_folder(arguments, task.facts["vehicle"])
            groups.setdefault(folder / f"{task.damper}.yaml", []).append(task)
    if not groups:
        raise InputError(f"{arguments.sources[0]}: no recording can be used; fleet compare tells why")
    return [_identified(client, target, own, arguments, words) for target, own in sorted(groups.items())]


def with_models(recordings: Sequence[Recording], arguments: argparse.Namespace) -> list[Recording]:
    """The recordings, each with the models that were identified for it."""
    return [replace(own, model=str(model_folder(arguments, own.vehicle))) for own in recordings]


def model_folder(arguments: argparse.Namespace, vehicle: object) -> Path:
    """Where the models of a vehicle lie."""
    folder = arguments.output.absolute() / MODELS
    return folder / str(vehicle).replace("/", "_") if arguments.joint == "vehicle" else folder


def _identified(
    client: Client, target: Path, tasks: Sequence[Task], arguments: argparse.Namespace, words: Sequence[str]
) -> str:
    told, named = target.with_suffix(".fit.json"), _named(target, arguments)
    checksums = sorted((t.facts["recording_checksum"], t.facts["signals_checksum"]) for t in tasks)
    given = sorted({t.facts["model_checksum"] for t in tasks})
    fingerprint = digest([list(words), checksums, given, __version__])
    if target.is_file() and _kept(told) == fingerprint:
        return f"{named}: nothing changed; {target} stays"
    if len(given) > 1:
        raise InputError(f"{named}: its recordings have different models; a joint fit begins from one")
    progress(f"{named}: fitting to {len(tasks)} recordings")
    model = load_model(tasks[0].model, tasks[0].damper)
    wishes = Wishes(seed=arguments.seed, progress=progress, population=arguments.population,
                    generations=arguments.generations, pick=arguments.pick or "knee")  # fmt: skip
    fit, refused = fit_spread(
        client, model, [_source(task, arguments) for task in tasks], arguments.free, arguments.fix,
        arguments.method, wishes, limits_of(arguments.limit),
    )  # fmt: skip
    save_fit(fit, target)
    left_out = [{"recording": own.recording, "reason": reason} for own, reason in refused.items()]
    record = {"fingerprint": fingerprint, "left_out": left_out, **fit_record(fit, target)}
    write_text(told, json.dumps(plain(record), indent=2, allow_nan=False) + "\n")
    notes = [f"  left out: {own['reason']}" for own in left_out]
    return "\n".join([table(named, fit, target), *notes])


def _named(target: Path, arguments: argparse.Namespace) -> str:
    return f"{target.parent.name} {target.stem}" if arguments.joint == "vehicle" else target.stem


def _kept(told: Path) -> object:
    try:
        return json.loads(told.read_text(encoding="utf-8")).get("fingerprint")
    except (OSError, ValueError):
        return None


def _source(task: Task, arguments: argparse.Namespace) -> Source:
    start = getattr(arguments, "from") or 0.0
    stop = float("inf") if arguments.to is None else arguments.to
    return Source(task.recording, task.damper, task.signals, start, stop, str(task.facts["recording_checksum"]))
