"""Compare the effect of two damper models on ride comfort: a car on four posts, swept from 0.5 to 6 Hz.

The posts move in phase at each of several amplitudes. The transfer functions from post to body above the front and the
rear axle are compared between the model and a second one: without --against, the model's single force-velocity curve
from peaks of sines as on a test bench. Prints the differences by axle and amplitude. Method of Gao et al., section 5;
the page shows the transfer functions and the dampers' loops.
"""

import argparse
from collections.abc import Mapping, Sequence

import numpy as np

from damper_estimator.cli.verb_support import add_html, add_json, progress, write_page, write_results
from damper_estimator.errors import InputError
from damper_estimator.model import DamperModel, load_model
from damper_estimator.vehicle import FullCar, load_car, single_curve
from damper_estimator.vehicle.comfort import AMPLITUDES, AXLES, ComfortRun, comfort_run, differences, resonance

EXAMPLES = (
    "comfort --amplitude 2 8 --html comfort.html",
    "comfort -m bouc_wen --against linear_viscous --vehicle compact_car --json comfort.json",
)
BAND = (0.5, 6.0)
"""Hz."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the arguments."""
    default = "renault_modified_bouc_wen_point_3"
    parser.add_argument(
        "-m", "--model", default=default, metavar="MODEL",
        help=f"of the dampers: a name, a file, or a folder with front.yaml and rear.yaml ({default})",
    )  # fmt: skip
    parser.add_argument(
        "--against", metavar="MODEL", help="the second model, as for -m (default: single curve of the first)"
    )
    parser.add_argument("--vehicle", default="compact_car", metavar="CAR", help="a name, or a car's file (compact_car)")
    parser.add_argument(
        "--amplitude", nargs="+", type=float, metavar="MM", default=[1e3 * a for a in AMPLITUDES],
        help="of the posts, mm (" + " ".join(f"{1e3 * a:g}" for a in AMPLITUDES) + ")",
    )  # fmt: skip
    parser.add_argument("--seconds", type=float, default=60.0, help="duration of a sweep (60)")
    add_json(parser)
    add_html(parser)


def run(arguments: argparse.Namespace) -> int:
    """Sweeps both models at every amplitude, prints, writes."""
    if not all(0.0 < a <= 50.0 for a in arguments.amplitude) or not 10.0 <= arguments.seconds <= 600.0:
        raise InputError("--amplitude must be between 0 and 50 mm and --seconds between 10 and 600")
    car = load_car(arguments.vehicle)
    models = _by_axle(arguments.model)
    others = {axle: single_curve(model) for axle, model in models.items()} if not arguments.against else None
    others = others or _by_axle(arguments.against)
    amplitudes = sorted({1e-3 * a for a in arguments.amplitude})
    runs = _runs(car, models, amplitudes, arguments.seconds)
    other_runs = _runs(car, others, amplitudes, arguments.seconds)
    text = _text(car, models, others, runs, other_runs)
    write_results(arguments, text, _record(car, models, others, runs, other_runs))
    if arguments.html:
        from damper_estimator.report.comfort_page import comfort_page

        names = [_named(each) for each in (models, others)]
        write_page(arguments.html, comfort_page(car.name, names, runs, other_runs))
    return 0


def _by_axle(name: str) -> dict[str, DamperModel]:
    return {axle: load_model(name, axle) for axle in AXLES}


def _named(models: Mapping[str, DamperModel]) -> str:
    return " / ".join(dict.fromkeys(model.name for model in models.values()))


def _runs(
    car: FullCar, models: Mapping[str, DamperModel], amplitudes: Sequence[float], seconds: float
) -> list[ComfortRun]:
    found = []
    for amplitude in amplitudes:
        progress(f"{_named(models)}: {1e3 * amplitude:g} mm")
        try:
            found.append(comfort_run(car, models, amplitude, BAND, seconds))
        except FloatingPointError as error:
            raise InputError(f"{_named(models)} on {car.name}: {error}") from error
    return found


def _text(
    car: FullCar,
    models: Mapping[str, DamperModel],
    others: Mapping[str, DamperModel],
    runs: Sequence[ComfortRun],
    other_runs: Sequence[ComfortRun],
) -> str:
    """The results as text."""
    rms = differences(runs, other_runs)
    lines = [
        f"{car.name} on four posts, {BAND[0]:g} to {BAND[1]:g} Hz: {_named(models)} against {_named(others)}",
        "  body over post; difference: rms of the complex difference over the band, relative to the rms of the second",
        "  posts mm   axle    difference %   resonance Hz    times     second: Hz    times",
    ]
    for k, (first, second) in enumerate(zip(runs, other_runs, strict=True)):
        for axle in AXLES:
            peak, second_peak = resonance(first.transfer[axle]), resonance(second.transfer[axle])
            lines.append(
                f"  {1e3 * first.amplitude:8.3g}   {axle:<6}  {100 * rms[axle][k]:12.1f}   "
                f"{peak[0]:12.2f} {peak[1]:8.2f}   {second_peak[0]:12.2f} {second_peak[1]:8.2f}"
            )
    return "\n".join(lines)


def _record(
    car: FullCar,
    models: Mapping[str, DamperModel],
    others: Mapping[str, DamperModel],
    runs: Sequence[ComfortRun],
    other_runs: Sequence[ComfortRun],
) -> dict[str, object]:
    rms = differences(runs, other_runs)

    def curves(run: ComfortRun) -> dict[str, object]:
        return {
            axle: {
                "frequency_hz": transfer.frequency,
                "gain": np.abs(transfer.value),
                "phase_rad": np.angle(transfer.value),
            }
            for axle, transfer in run.transfer.items()
        }

    return {
        "vehicle": car.name,
        "model": _named(models),
        "against": _named(others),
        "sweeps": [
            {
                "amplitude_m": first.amplitude,
                "difference": {axle: rms[axle][k] for axle in AXLES},
                "model": curves(first),
                "against": curves(second),
            }
            for k, (first, second) in enumerate(zip(runs, other_runs, strict=True))
        ],
    }
