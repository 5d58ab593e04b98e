"""Identify a model's parameters from recordings.

All recordings are taken together. With several dampers, -o is a folder that receives one DAMPER.yaml each.
What the model file fixes stays as it is; --fix fixes more, --free then frees (the later word wins: --fix '*' --free
coulomb.force identifies friction alone). Names may be whole effects, whole vectors, or patterns with * and ?.
"""

import argparse
from collections.abc import Sequence
from dataclasses import asdict, fields
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
from damper_estimator.errors import InputError
from damper_estimator.identification import Fit, FittedParameter, all_methods, fit
from damper_estimator.model import DamperModel, load_model, save_model
from damper_estimator.model.element import labels
from damper_estimator.recordings import open_bag
from damper_estimator.signals import Measurement, SignalMap, load_signal_map, measure
from damper_estimator.signals.channels import signals_for


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
    parser.add_argument("--seed", type=int, default=0, help="of the start values that are drawn (default: %(default)s)")
    add_signals(parser)
    add_window(parser)
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    """Fits every damper, then writes all model files."""
    measurements = read(
        arguments.bags, load_signal_map(arguments.signals), arguments.dampers, arguments.start, arguments.stop
    )
    targets = output_paths(arguments.output, list(measurements))
    fits = {}
    for damper, own in measurements.items():
        model = load_model(arguments.model, damper)
        progress(f"{damper}: fitting {model.name} to {len(own)} recording{'s' if len(own) > 1 else ''}")
        fits[damper] = fit(model, own, arguments.free, arguments.fix, arguments.method, arguments.seed)
    for damper, result in fits.items():
        targets[damper].parent.mkdir(parents=True, exist_ok=True)
        save_model(result.model, targets[damper])
        if arguments.json != STANDARD_OUTPUT:
            print(table(damper, result, targets[damper]))
    records = {damper: as_json(result, targets[damper]) for damper, result in fits.items()}
    write_json(arguments.json, {"bags": arguments.bags, "model": arguments.model, "dampers": records})
    return 0


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


def table(damper: str, result: Fit, target: Path) -> str:
    """The result for people."""
    width = max(len(parameter.name) for parameter in result.parameters)
    knots = _knots(result.model)
    lines = [f"{damper}: {result.model.name}, {len(result.parameters)} parameters, {result.samples} judged samples"]
    for p in result.parameters:
        unit = p.unit if p.unit != "1" else ""
        row = f"  {p.name:<{width}}  {p.value:>12.6g} {_uncertainty(p):<14}  {unit}{knots.get(p.name, '')}"
        lines.append(row.rstrip())
    lines += [
        f"  rms error  {result.rmse_before_n:.4g} N -> {result.rmse_n:.4g} N",
        f"  ESR        {result.esr_before:.4g} -> {result.esr:.4g}",
        *(f"  note: {warning}" for warning in result.warnings),
        f"  {result.seconds:.1f} s, {result.evaluations} evaluations; written to {target}",
    ]
    return "\n".join(lines)


def _uncertainty(parameter: FittedParameter) -> str:
    if parameter.at_bound:
        return "at its bound"
    return (
        f"± {parameter.standard_error:.2g}" if parameter.standard_error == parameter.standard_error else "undetermined"
    )


def _knots(model: DamperModel) -> dict[str, str]:
    """Where on its curve each entry of a vector stands, by address."""
    places = {}
    elements = labels(model.effects)
    for slot in model.slots:
        _, element = elements[slot.entry]
        if isinstance(slot.parameter.size, str):
            unit = {setting.name: setting.unit for setting in element.effect.settings}[slot.parameter.size]
            places[slot.address] = f" at {element.settings[slot.parameter.size][slot.index]:.4g} {unit}"
    return places


def as_json(result: Fit, target: Path) -> dict[str, object]:
    """The result for programs: the fields of ``Fit``, with the model's name and file."""
    plain = {
        field.name: getattr(result, field.name) for field in fields(result) if field.name not in ("model", "parameters")
    }
    return {"model": result.model.name, "file": target, **plain, "parameters": [asdict(p) for p in result.parameters]}
