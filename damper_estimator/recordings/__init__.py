"""Recordings in and out, without ROS.

All data are read here. `open_bag` reads ``.mcap`` files and rosbag2 folders in arrival order and turns fields of
equal-shaped messages into arrays at once; `BagWriter` writes mcap that other tools open; bench and logger files (CSV,
text, MAT) become bags by a column map. Signs, units and time bases belong to the signal map.
"""

from importlib import import_module
from typing import TYPE_CHECKING

from damper_estimator.recordings.definitions import Schema
from damper_estimator.recordings.encode import (
    accelerations,
    damper_forces,
    encode,
    floats,
    joint_states,
    pressures,
    temperatures,
)
from damper_estimator.recordings.field_path import FieldPath, parse_path

if TYPE_CHECKING:
    from damper_estimator.recordings.bag import Bag, Topic, open_bag
    from damper_estimator.recordings.batch import Batch, Columns
    from damper_estimator.recordings.bench import Part, read_parts
    from damper_estimator.recordings.bench_bag import planned_paths, write_part
    from damper_estimator.recordings.column_map import ColumnMap, ColumnMaps, column_map_of, load_column_maps
    from damper_estimator.recordings.guess import ColumnGuess, Guess, guess_columns
    from damper_estimator.recordings.guess_physics import velocity_of
    from damper_estimator.recordings.writer import BagWriter, LiveBagWriter, Stream

__all__ = [
    "Bag",
    "BagWriter",
    "Batch",
    "ColumnGuess",
    "ColumnMap",
    "ColumnMaps",
    "Columns",
    "FieldPath",
    "Guess",
    "LiveBagWriter",
    "Part",
    "Schema",
    "Stream",
    "Topic",
    "accelerations",
    "column_map_of",
    "damper_forces",
    "encode",
    "floats",
    "guess_columns",
    "joint_states",
    "load_column_maps",
    "open_bag",
    "parse_path",
    "planned_paths",
    "pressures",
    "read_parts",
    "temperatures",
    "velocity_of",
    "write_part",
]

# Reading and writing files needs packages (mcap, zstandard) that a node does not need unless it records.
_LOADED_ON_USE = {
    "bag": ("Bag", "Topic", "open_bag"),
    "batch": ("Batch", "Columns"),
    "bench": ("Part", "read_parts"),
    "bench_bag": ("planned_paths", "write_part"),
    "column_map": ("ColumnMap", "ColumnMaps", "column_map_of", "load_column_maps"),
    "guess_physics": ("velocity_of",),
    "guess": ("ColumnGuess", "Guess", "guess_columns"),
    "writer": ("BagWriter", "LiveBagWriter", "Stream"),
}


def __getattr__(name: str) -> object:
    for module, names in _LOADED_ON_USE.items():
        if name in names:
            globals()[name] = value = getattr(import_module(f"{__name__}.{module}"), name)
            return value
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
