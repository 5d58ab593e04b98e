"""Damaged bench files and column maps end in one line or in a recording, never in a traceback."""

import gzip
import random
from pathlib import Path

import numpy as np
import pytest
import scipy.io

from damper_estimator.errors import InputError
from damper_estimator.recordings.bench import read_parts
from damper_estimator.recordings.bench_bag import planned_paths, write_part
from damper_estimator.recordings.column_map import load_column_maps

CASES = 120
MAP = """
dampers:
  d:
    displacement: {column: Position, unit: mm, scale: 2.0}
    force: {column: Load, unit: N}
    command: {values: [1, 2], unit: A}
time: {column: Time, unit: ms}
split: {column: Event, equals: b}
trim_rest: {margin: 0.1}
center: rest
name: "{stem}_{command}"
files: {"*.csv": {text: {separator: semicolon}}}
"""
ROWS = np.column_stack([np.arange(60) * 10.0, np.sin(np.arange(60)), np.cos(np.arange(60))]).tolist()
CSV = "rig 7\nTime;Position;Load;Event\n" + "".join(f"{t};{x};{f};{'b' if t == 300 else ''}\n" for t, x, f in ROWS)


def survives(path: Path, rules: Path) -> bool:
    try:
        found = load_column_maps(rules).for_file(path.name)
        parts = read_parts(path, found)
        folder = path.parent / "out"
        folder.mkdir(exist_ok=True)
        for part, target in zip(parts, planned_paths(parts, [found.name] * len(parts), folder), strict=True):
            write_part(part, target)
    except InputError as error:
        assert "\n" not in str(error)
        return False
    return True


def damaged(content: bytes, chance: random.Random) -> bytes:
    result = bytearray(content)
    for _ in range(chance.choice((1, 1, 3, 30))):
        start = chance.randrange(len(result))
        how = chance.random()
        if how < 0.6:
            result[start] = (
                chance.choice(b'\0\n;,."0 -eE:{}[]&*\xff') if chance.random() < 0.7 else chance.randrange(256)
            )
        elif how < 0.8:
            del result[start : start + chance.randrange(1, 20)]
        else:
            result[start:start] = result[: chance.randrange(40)]
        if not result:
            break
    return bytes(result[: chance.randrange(len(result) + 1)] if chance.random() < 0.2 else result)


@pytest.fixture
def rules(tmp_path):
    path = tmp_path / "map.yaml"
    path.write_text(MAP)
    return path


def test_the_undamaged_files_are_read(tmp_path, rules):
    (tmp_path / "x.csv").write_text(CSV)
    assert survives(tmp_path / "x.csv", rules)


@pytest.mark.parametrize("pack", [bytes, gzip.compress], ids=["text", "gzip"])
def test_damaged_text(tmp_path, rules, pack):
    chance = random.Random(1)
    for _ in range(CASES):
        (tmp_path / "x.csv").write_bytes(damaged(pack(CSV.encode()), chance))
        survives(tmp_path / "x.csv", rules)


def test_random_bytes(tmp_path, rules):
    chance = random.Random(2)
    for _ in range(CASES):
        (tmp_path / "x.csv").write_bytes(chance.randbytes(chance.randrange(400)))
        survives(tmp_path / "x.csv", rules)


@pytest.mark.parametrize("compressed", [False, True])
def test_damaged_mat_files(tmp_path, rules, compressed):
    rules.write_text(MAP.replace("split: {column: Event, equals: b}\n", "").replace("[1, 2]", "[1]"))
    chance = random.Random(3)
    columns = dict(zip(("Time", "Position", "Load"), np.transpose(ROWS), strict=True))
    scipy.io.savemat(tmp_path / "x.mat", columns, do_compression=compressed)
    assert survives(tmp_path / "x.mat", rules)
    good = (tmp_path / "x.mat").read_bytes()
    for _ in range(CASES):
        (tmp_path / "x.mat").write_bytes(damaged(good, chance))
        survives(tmp_path / "x.mat", rules)


def test_damaged_column_maps(tmp_path, rules):
    chance = random.Random(4)
    (tmp_path / "x.csv").write_text(CSV)
    verdicts = []
    for _ in range(CASES):
        rules.write_bytes(damaged(MAP.encode(), chance))
        verdicts.append(survives(tmp_path / "x.csv", rules))
    assert verdicts.count(False) > CASES // 2
