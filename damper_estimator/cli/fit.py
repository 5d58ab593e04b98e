"""Identify a model's parameters from recordings.

All recordings are taken together. With several dampers, -o is a folder that receives one DAMPER.yaml each.
What the model file fixes stays as it is; --fix fixes more, --free then frees (the later word wins: --fix '*' --free
coulomb.force identifies friction alone). Names may be whole effects, whole vectors, or patterns with * and ?.
"""

import argparse
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
from damper_estimator.identification import Fit, all_methods, fit
from damper_estimator.model import load_model, save_model
from damper_estimator.recordings import open_bag
from damper_estimator.signals import Measurement, SignalMap, load_signal_map, measure
from damper_estimator.signals.channels import signals_for


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the verb's arguments."""
    add_bags(parser)
    add_models(parser)
    parser.add_argument(
        "-o", "--output", metavar="MODEL.yaml", type=Path, required=True, help="where the fitted model goes; a folder for several dampers"
    )
    parser.add_argument("--method", default="least_squares", help=f"one of {', '.join(all_methods())} (default: %(default)s)")
    parser.add_argument("--free", metavar="NAME", action="append", default=[], help="identify this parameter although it is fixed; may be repeated")
    parser.add_argument("--fix", metavar="NAME", action="append", default=[], help="leave this parameter as it is; may be repeated")
    parser.add_argument("--seed", type=int, default=0, help="of the start values that are drawn (default: %(default)s)")
    add_signals(parser)
    add_window(parser)
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    """Fits every damper, then writes all model files."""
    signal_map = load_signal_map(arguments.signals)
    measurements = read(arguments, signal_map)
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
        for damper, result in fits.items():
            print(table(damper, result, targets[damper]))
    results = {damper: as_json(damper, result, targets[damper]) for damper, result in fits.items()}
    write_json(arguments.json, next(iter(results.values())) if len(results) == 1 else {"dampers": results})
    return 0


def read(arguments: argparse.Namespace, signal_map: SignalMap) -> dict[str, list[Measurement]]:
    """Measurements of every wanted damper, one per bag; a damper that one of the bags lacks is an error there."""
    start = 0.0 if arguments.start is None else arguments.start
    stop = float("inf") if arguments.stop is None else arguments.stop
    measurements: dict[str, list[Measurement]] = {damper: [] for damper in arguments.dampers}
    for path in arguments.bags:
        with open_bag(path) as bag:
            if not measurements:
                measurements = {damper: [] for damper in signals_for(bag, signal_map).dampers}
            for damper, own in measurements.items():
                own.append(measure(bag, signal_map, damper, start, stop))
    return measurements


def output_paths(output: Path, dampers: list[str]) -> dict[str, Path]:
    """Where each damper's model goes: into the folder ``output``, or to the file ``output`` where there is one damper.

    Raises:
        InputError: for one file and several dampers.
    """
    if output.is_dir() or (len(dampers) > 1 and output.suffix not in (".yaml", ".yml")):
        return {damper: output / f"{damper}.yaml" for damper in dampers}
    if len(dampers) > 1:
        raise InputError(f"{output}: is one file, but there are dampers {', '.join(dampers)}; name a folder, or choose one with -d")
    return {dampers[0]: output}


def table(damper: str, result: Fit, target: Path) -> str:
    """The result for people."""
    width = max(len(parameter.name) for parameter in result.parameters)
    lines = [f"{damper}: {result.model.name}, {len(result.parameters)} parameters, {result.samples} judged samples"]
    for p in result.parameters:
        error = "  at its bound" if p.at_bound else f"± {p.standard_error:.2g}" if p.standard_error == p.standard_error else "± unknown"
        lines.append(f"  {p.name:<{width}}  {p.value:>12.6g} {error:<12} {p.unit}".rstrip())
    lines += [
        f"  rms error  {result.rmse_before_n:.4g} N -> {result.rmse_n:.4g} N",
        f"  ESR        {result.esr_before:.4g} -> {result.esr:.4g}",
        *(f"  warning: {warning}" for warning in result.warnings),
        f"  {result.seconds:.1f} s, {result.evaluations} evaluations; written to {target}",
    ]
    return "\n".join(lines)


def as_json(damper: str, result: Fit, target: Path) -> dict[str, object]:
    """The result for programs."""
    return {
        "damper": damper,
        "model": result.model.name,
        "file": target,
        "rmse_n": result.rmse_n,
        "esr": result.esr,
        "rmse_before_n": result.rmse_before_n,
        "esr_before": result.esr_before,
        "samples": result.samples,
        "parameters": [
            {
                "name": p.name,
                "value": p.value,
                "standard_error": p.standard_error,
                "unit": p.unit,
                "at_bound": p.at_bound,
            }
            for p in result.parameters
        ],
        "undetermined": result.undetermined,
        "converged": result.converged,
        "warnings": result.warnings,
        "seconds": result.seconds,
        "evaluations": result.evaluations,
    }
