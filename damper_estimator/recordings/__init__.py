"""Recordings in and out, without ROS.

Data enters the product here and nowhere else. `open_bag` reads ``.mcap`` files and rosbag2 folders in arrival order and
turns fields of equal-shaped messages into arrays at once; `BagWriter` writes mcap that other tools open; bench and
logger files (CSV, text, MAT) become bags by a column map. Signs, units and time bases are the signal map's business.
"""

from damper_estimator.recordings.bag import Bag, Topic, open_bag
from damper_estimator.recordings.batch import Batch, Columns
from damper_estimator.recordings.bench import Part, read_parts
from damper_estimator.recordings.bench_bag import planned_paths, write_part
from damper_estimator.recordings.column_map import ColumnMap, ColumnMaps, load_column_maps
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
from damper_estimator.recordings.writer import BagWriter, LiveBagWriter, Stream

__all__ = [
    "Bag",
    "BagWriter",
    "Batch",
    "ColumnMap",
    "ColumnMaps",
    "Columns",
    "FieldPath",
    "LiveBagWriter",
    "Part",
    "Schema",
    "Stream",
    "Topic",
    "accelerations",
    "damper_forces",
    "encode",
    "floats",
    "joint_states",
    "load_column_maps",
    "open_bag",
    "parse_path",
    "planned_paths",
    "pressures",
    "read_parts",
    "temperatures",
    "write_part",
]
