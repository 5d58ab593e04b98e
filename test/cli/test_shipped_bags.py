"""The recordings in bags/ are what their table says, and the script makes them again."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest

from damper_estimator.recordings import Bag, open_bag

FOLDER = Path(__file__).resolve().parents[2] / "bags"
LARGEST = 10e6
CORNERS = ("front_left", "front_right", "rear_left", "rear_right")


def value(bag: Bag, topic: str, fields: tuple[str, ...]) -> np.ndarray:
    return bag.columns(topic, fields).values


def test_the_table_lists_every_recording_and_all_are_small() -> None:
    listed = {line.split("`")[1] for line in (FOLDER / "README.md").read_text().splitlines() if line.startswith("| `")}
    assert listed == {path.name for path in FOLDER.glob("*.mcap")}
    assert sum(path.stat().st_size for path in FOLDER.glob("*.mcap")) < LARGEST


@pytest.mark.parametrize("path", sorted(FOLDER.glob("*.mcap")), ids=lambda path: path.stem)
def test_every_recording_has_displacement_and_force_of_its_dampers_and_begins_at_rest(path: Path) -> None:
    kinds = {"four": CORNERS, "semi": ("semi_active",)}
    names = kinds.get(path.stem.split("_")[0], ("passenger_front",))
    with open_bag(path) as bag:
        travel = value(bag, "/suspension/displacement", tuple(f"position[{name}]" for name in names))
        force = value(bag, "/suspension/force", tuple(f"effort[{name}]" for name in names))
    assert np.isfinite(travel).all() and np.isfinite(force).all()
    assert (np.ptp(travel[:900], axis=0) < 2e-4).all()
    assert (np.ptp(travel, axis=0) > 5e-3).all()
    assert (np.ptp(force[:900], axis=0) < 60.0).all()


def test_the_script_makes_the_same_recording_again(tmp_path: Path) -> None:
    specification = importlib.util.spec_from_file_location("make_bags", FOLDER / "make.py")
    make = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(make)
    make.four_corners(tmp_path)
    fields = tuple(f"position[{name}]" for name in CORNERS), tuple(f"effort[{name}]" for name in CORNERS)
    with open_bag(tmp_path / "four_corners_road.mcap") as again, open_bag(FOLDER / "four_corners_road.mcap") as shipped:
        for topic, paths, quantum in zip(("displacement", "force"), fields, (1e-5, 1.0), strict=True):
            fresh, old = (value(bag, f"/suspension/{topic}", paths) for bag in (again, shipped))
            assert fresh.shape == old.shape
            # Other processors round otherwise in the last bit; that can move a sample by one quantum.
            assert np.abs(fresh - old).max() < 1.5 * quantum
