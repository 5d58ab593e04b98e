"""Makes the recordings of this folder again: `python bags/make.py` (in the project's environment, about a minute)."""

import argparse
from dataclasses import replace
from pathlib import Path

from damper_estimator.plant import (
    DAMPERS,
    Record,
    Sensors,
    Setup,
    current_steps,
    hidden,
    measure,
    record,
    simulate,
    without,
)
from damper_estimator.vehicle import drive
from damper_estimator.workflows import write_record

SEED = 2024
PASSENGER = Setup(DAMPERS["passenger_front"], Sensors())
SEMI_ACTIVE = Setup(DAMPERS["semi_active"], Sensors())


def passenger(folder: Path) -> None:
    """The ordinary damper on benches and on the road."""
    for number, (name, excitation) in enumerate({"random": "random10", "dyno": "dyno", "road": "road"}.items()):
        motion = drive(excitation, PASSENGER.damper, 20.0, SEED + number)
        one = record(PASSENGER, motion, SEED + number)
        write_record(folder / f"passenger_{name}.mcap", {"passenger_front": one}, False)


def hidden_effect(folder: Path) -> None:
    """A damper whose oil has taken up air: base before, fit and unseen after."""
    names = ("oil_compressibility",)
    calm = without(PASSENGER, names).damper
    drives = tuple(
        drive(excitation, calm, 18.0, SEED + 10 + number)
        for number, excitation in enumerate(("random10", "random10", "road"))
    )
    case = hidden(names, PASSENGER, drives, 0.15, SEED + 10)
    for name, one in {"base": case.base, "fit": case.fit, "unseen": case.unseen}.items():
        write_record(folder / f"hidden_{name}.mcap", {"passenger_front": one}, False)


def semi_active(folder: Path) -> None:
    """A magneto-rheological damper with a stepping current; the one to fit on steps from next to nothing to 2 A."""
    for number, (name, excitation) in enumerate({"random": "random", "road": "road"}.items()):
        current = current_steps(14.0, SEED + (23 if name == "random" else 21))
        motion = drive(excitation, SEMI_ACTIVE.damper, 14.0, SEED + 20 + number, current)
        one = record(SEMI_ACTIVE, motion, SEED + 20 + number)
        write_record(folder / f"semi_active_{name}.mcap", {"semi_active": one}, True)


def four_corners(folder: Path) -> None:
    """A car with four dampers in one message; front and rear axle differ, left and right roll on different tracks."""
    corners = {}
    for number, corner in enumerate(("front_left", "front_right", "rear_left", "rear_right")):
        damper = DAMPERS["passenger_front" if corner.startswith("front") else "light_car"]
        motion = drive("road_b", damper, 12.0, SEED + 30 + number)
        setup = Setup(replace(damper, name=corner), Sensors())
        truth = simulate(setup.damper, motion)
        corners[corner] = Record(setup, truth, measure(truth, setup.sensors, SEED + 30 + number, clock_seed=SEED))
    write_record(folder / "four_corners_road.mcap", corners, False)


def main() -> None:
    """Writes all recordings to the folder of this file, or to the one given."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", "--output", type=Path, default=Path(__file__).parent)
    folder = parser.parse_args().output
    folder.mkdir(parents=True, exist_ok=True)
    for group in (passenger, hidden_effect, semi_active, four_corners):
        group(folder)


if __name__ == "__main__":
    main()
