"""Record a simulated damper, optionally with hidden physical effects of chosen strength.

Without --hide writes one recording per excitation. With --hide writes three: base.mcap without the effects, fit.mcap
and unseen.mcap with them (excitation: the first for base and fit, the last for unseen). truth.json states the hidden
effects and their strength; truth/ has the noise-free signals, which no other verb reads.
"""

import argparse
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from damper_estimator.cli.drive_playback import played_drive
from damper_estimator.cli.verb_support import finite, from_zero, progress, write_json
from damper_estimator.errors import InputError
from damper_estimator.files import plain
from damper_estimator.plant import (
    DAMPERS,
    PHENOMENA,
    Drive,
    Hidden,
    Record,
    Sensors,
    Setup,
    current_steps,
    hidden,
    record,
    without,
)
from damper_estimator.vehicle import EXCITATIONS, drive
from damper_estimator.workflows import write_record, write_signal_map, write_truth

_PLAYED = 900  # added to the seed of the noise

EXAMPLES = (
    "synth -o case --hide oil_compressibility --strength 0.15",
    "synth -o plain --damper semi_active --excitation random road --current",
)
SHORTFALL = 0.9
"""Share of the requested strength below which a note says that the excitation hardly shows the effect."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the arguments."""
    defaults = Sensors()
    parser.add_argument("-o", "--output", metavar="DIR", type=Path, required=True, help="folder for the recordings")
    parser.add_argument("--damper", choices=DAMPERS, default="passenger_front", help="simulated damper")
    parser.add_argument("--excitation", nargs="+", choices=EXCITATIONS, default=["random"], help="excitations")
    parser.add_argument(
        "--hide", nargs="+", action="extend", choices=PHENOMENA, default=[], metavar="PHENOMENON",
        help="effect to hide, absent in the base recording: " + ", ".join(PHENOMENA),
    )  # fmt: skip
    parser.add_argument(
        "--strength",
        type=float,
        default=0.1,
        help="rms change of the force by each effect, relative to the rms force (0.1)",
    )
    parser.add_argument(
        "--play",
        metavar="CSV",
        type=Path,
        help="also play this drive (from plan) on the damper with the hidden effects",
    )
    parser.add_argument("--seconds", type=float, default=60.0, help="length of a recording (60)")
    parser.add_argument("--rate", type=float, default=defaults.rate, help="samples per second (500)")
    parser.add_argument("--seed", type=int, default=1, help="excitations and noise are reproduced from it (1)")
    parser.add_argument("--current", action="store_true", help="record a coil current even if it has no effect")
    parser.add_argument(
        "--spring",
        type=from_zero,
        default=0.0,
        metavar="N/m",
        help="stiffness of a coil spring included in the gauge's force",
    )
    parser.add_argument(
        "--preload", type=finite, default=0.0, metavar="N", help="force of the spring at displacement 0, negative"
    )


def run(arguments: argparse.Namespace) -> int:
    """Simulates, measures, writes."""
    _check(arguments)
    _make_folders(arguments.output)
    setup = Setup(
        DAMPERS[arguments.damper],
        Sensors(rate=arguments.rate, spring_rate=arguments.spring, preload=arguments.preload),
    )
    records, story = _case(arguments, setup) if arguments.hide else _plain(arguments, setup)
    if arguments.play is not None:
        progress(f"playing {arguments.play}")
        played_setup = records["fit"].setup if arguments.hide else setup
        seed = 1000 * arguments.seed + _PLAYED
        records["played"] = record(played_setup, played_drive(arguments.play, played_setup.damper, seed), seed)
    with_current = _has_current(arguments)
    _write(arguments.output, records, with_current)
    if arguments.spring or arguments.preload:
        write_signal_map(arguments.output / "signals.yaml", arguments.damper, setup.sensors, with_current)
    write_json(str(arguments.output / "truth.json"), _truth(arguments, setup, records) | story)
    return 0


def _check(arguments: argparse.Namespace) -> None:
    faults = []
    if not 0.0 < arguments.strength < 1.0:
        faults.append(f"--strength {arguments.strength:g} is not between 0 and 1")
    if not 10.0 <= arguments.rate <= 5000.0:
        faults.append(f"--rate {arguments.rate:g} is not between 10 and 5000 samples per second")
    if not 6.0 <= arguments.seconds <= 3600.0:
        faults.append(f"--seconds {arguments.seconds:g} is not between 6 and 3600")
    if arguments.seed < 0:
        faults.append(f"--seed {arguments.seed} is negative")
    repeated = sorted({name for name in arguments.hide if arguments.hide.count(name) > 1})
    if repeated:
        faults.append(f"--hide names {', '.join(repeated)} twice")
    if faults:
        raise InputError("; ".join(faults) + "")


def _has_current(arguments: argparse.Namespace) -> bool:
    """The current of a damper with a coil is always recorded."""
    return arguments.current or "current" in arguments.hide or DAMPERS[arguments.damper].coil.pressure > 0.0


def _drive(arguments: argparse.Namespace, name: str, setup: Setup, number: int) -> Drive:
    seed = 1000 * arguments.seed + number
    current = current_steps(arguments.seconds, seed) if _has_current(arguments) else None
    return drive(name, setup.damper, arguments.seconds, seed, current)


def _plain(arguments: argparse.Namespace, setup: Setup) -> tuple[dict[str, Record], dict[str, Any]]:
    records = {}
    for number, name in enumerate(dict.fromkeys(arguments.excitation)):
        progress(f"simulating {name}")
        motion = _drive(arguments, name, setup, number)
        records[name] = record(setup, motion, motion.seed)
    return records, {"hidden": []}


def _case(arguments: argparse.Namespace, setup: Setup) -> tuple[dict[str, Record], dict[str, Any]]:
    first, last = arguments.excitation[0], arguments.excitation[-1]
    progress(f"hiding {', '.join(arguments.hide)}")
    base_setup = without(setup, tuple(arguments.hide))
    drives = tuple(_drive(arguments, name, base_setup, number) for number, name in enumerate((first, first, last)))
    case = hidden(tuple(arguments.hide), setup, drives, arguments.strength, drives[0].seed)
    for item in case.calibrations:
        if item.strength < SHORTFALL * arguments.strength:
            reached = f"strength {item.strength:.3f} instead of {arguments.strength:g}"
            progress(f"{first} hardly excites {item.phenomenon}: {reached}")
    return {"base": case.base, "fit": case.fit, "unseen": case.unseen}, _story(case)


def _story(case: Hidden) -> dict[str, Any]:
    return {
        "hidden": [asdict(item) for item in case.calibrations],
        "fit_strength": case.fit_strength,
        "unseen_strength": case.unseen_strength,
    }


def _truth(arguments: argparse.Namespace, setup: Setup, records: Mapping[str, Record]) -> dict[str, Any]:
    return {
        "damper": arguments.damper,
        "seed": arguments.seed,
        "wanted_strength": arguments.strength if arguments.hide else None,
        "recordings": {name: _figures(simulated) for name, simulated in records.items()},
        "truth_bags": {name: f"truth/{name}.mcap" for name in records},
        "sensors": {name: plain(asdict(simulated.setup.sensors)) for name, simulated in records.items()},
        "parameters": {name: plain(_nested(simulated)) for name, simulated in records.items()},
    }


def _nested(simulated: Record) -> dict[str, Any]:
    parts = vars(simulated.setup.damper)
    return {name: part._asdict() if hasattr(part, "_asdict") else part for name, part in parts.items()}


def _figures(simulated: Record) -> dict[str, Any]:
    truth, drive_ = simulated.truth, simulated.truth.drive
    return {
        "excitation": drive_.name,
        "seed": drive_.seed,
        "force_rms_n": truth.rms,
        "force_min_n": truth.force.min(),
        "force_max_n": truth.force.max(),
        "displacement_rms_m": float(np.std(drive_.displacement)),
        "velocity_max_m_s": np.abs(drive_.velocity).max(),
        "lowest_pressure_pa": min(truth.rebound_pressure.min(), truth.compression_pressure.min()),
        "temperature_end_c": truth.temperature[-1],
    }


def _make_folders(folder: Path) -> None:
    try:
        (folder / "truth").mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot be created ({error.strerror}); choose another place with -o") from error


def _write(folder: Path, records: Mapping[str, Record], with_current: bool) -> None:
    for name, simulated in records.items():
        named = {simulated.setup.damper.name: simulated}
        write_record(folder / f"{name}.mcap", named, with_current)
        write_truth(folder / "truth" / f"{name}.mcap", named)
        progress(f"wrote {folder / name}.mcap")
