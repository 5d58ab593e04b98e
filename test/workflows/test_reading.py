"""Reading bags, bench files and memory: dampers, omissions, and refused input."""

import numpy as np
import pytest
from drives import samples

from damper_estimator.errors import InputError
from damper_estimator.recordings import open_bag
from damper_estimator.signals import SignalMap, measure
from damper_estimator.workflows import in_words, open_reader, read

COLUMNS = """
time: {column: time, unit: s}
dampers:
  bench:
    displacement: {column: displacement, unit: mm}
    force: {column: force, unit: N}
"""


def test_reading_gives_what_the_signal_code_measures(drive):
    path = drive(dampers=("front_left", "front_right"))
    recording = read(path, start=1.0, stop=4.0)
    with open_bag(path) as bag:
        for damper in ("front_left", "front_right"):
            expected = measure(bag, SignalMap(), damper, 1.0, 4.0)
            (found,) = recording.measurements[damper]
            assert np.array_equal(found.kinematics.block, expected.kinematics.block, equal_nan=True)
            assert np.array_equal(found.force, expected.force) and np.array_equal(found.judged, expected.judged)


def test_several_recordings_are_pooled_by_damper_in_order_of_appearance(drive):
    paths = [drive("a.mcap", dampers=("rear",)), drive("b.mcap", dampers=("front", "rear"), seed=3)]
    recording = read(paths)
    assert recording.dampers == ("rear", "front")
    assert [len(measurements) for measurements in recording.measurements.values()] == [2, 1]
    assert recording.names == tuple(map(str, paths))
    assert in_words(recording.names) == "2 recordings" and in_words(recording.names[:1]) == "a.mcap"


def test_a_requested_damper_is_read_from_the_recordings_that_have_it(drive):
    paths = [drive("a.mcap", dampers=("rear",)), drive("b.mcap", dampers=("front", "rear"))]
    recording = read(paths, dampers="front")
    assert recording.dampers == ("front",) and recording.names == (str(paths[1]),)
    assert recording.notes == (f"{paths[0]}: has no damper front; left out",)
    with pytest.raises(InputError, match=r"a\.mcap: has no damper 'left'; it has rear, front"):
        read(paths, dampers=["left"])


def test_reading_damper_by_damper_equals_reading_all_at_once(drive):
    path = drive(dampers=("front_left", "front_right"))
    whole = read(path)
    with open_reader([path], SignalMap()) as reader:
        assert reader.dampers == whole.dampers
        for damper in reader.dampers:
            (found,), (expected,) = reader.damper(damper).measurements[damper], whole.measurements[damper]
            assert np.array_equal(found.force, expected.force)


def test_a_recording_without_force_can_be_read_and_the_use_that_needs_one_is_named(drive):
    path = drive(force=False)
    recording = read(path)
    assert recording.measurements["front_left"][0].force is None and "no force" in repr(recording)
    for use in ("diagnose", "fit", "compare"):
        with pytest.raises(InputError, match=f"no damper has a measured force; {use} needs one"):
            recording.with_force(use)


def test_a_requested_damper_must_have_a_force_others_are_left_out(drive):
    paths = [drive("with.mcap"), drive("without.mcap", force=False)]
    kept = read(paths).with_force("fit")
    assert len(kept.measurements["front_left"]) == 1
    assert kept.notes == (f"{paths[1]}: the force of front_left was not measured; left out",)
    with pytest.raises(InputError, match=r"without\.mcap: has no measured force of damper 'front_left'"):
        read(paths, dampers="front_left").with_force("fit")


def test_a_bench_file_is_read_like_the_bag_that_import_makes_of_it(tmp_path):
    from damper_estimator.workflows import import_files

    time, x, force, _ = samples()
    rows = "\n".join(f"{t:.6f},{1e3 * d:.9f},{f:.6f}" for t, d, f in zip(time, x, force, strict=True))
    table, columns = tmp_path / "bench.csv", tmp_path / "columns.yaml"
    table.write_text(f"time,displacement,force\n{rows}\n")
    columns.write_text(COLUMNS)
    import_files([table], columns, tmp_path / "bench.mcap", lambda text: None)
    (found,), (expected,) = (
        recording.measurements["bench"] for recording in (read(table, columns=columns), read(tmp_path / "bench.mcap"))
    )
    assert np.array_equal(found.kinematics.block, expected.kinematics.block, equal_nan=True)
    assert np.array_equal(found.force, expected.force) and found.recording == str(table)


def test_no_input_and_a_file_that_is_no_recording_are_one_line(tmp_path):
    (tmp_path / "text.mcap").write_text("time,force\n")
    for paths, words in (([], "no recordings to read"), (tmp_path / "text.mcap", "text.mcap"), ("nowhere", "nowhere")):
        with pytest.raises(InputError, match=words) as refused:
            read(paths)
        assert "\n" not in str(refused.value)
