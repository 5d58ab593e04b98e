"""Recordings of the node can be replayed to the same forces, survive a kill, and are rotated by size."""

import time

import numpy as np
import pytest
from rig import MS

from damper_estimator.cli.main import main
from damper_estimator.recordings import floats, open_bag, temperatures

FORCE = "/damper_estimator/force"
FIELDS = ("displacement", "velocity", "acceleration", "force", "force_stddev", "status")


def forces(path):
    with open_bag(path) as bag:
        columns = bag.columns(FORCE, [f"{field}[{side}]" for field in FIELDS for side in ("left", "right")])
        return columns.stamp, columns.values


@pytest.mark.parametrize("end", ["terminate", "kill"])
def test_its_own_recording_replays_to_the_same_bits(end, start, rig, tmp_path, caplog):
    model = tmp_path / "model.yaml"
    model.write_text("effects: [{viscous_curve: {}}, {temperature_gain: {fade: 0.01}}]")
    process = start(model=model, dampers="[left, right]", record=tmp_path / "bags", stale_after=60.0)
    rig.ready()
    warm = rig.publisher("/suspension/left/temperature", "sensor_msgs/msg/Temperature")
    for celsius in (20.0, 60.0, 90.0):
        rig.drive(150, ["left", "right"])
        warm.publish(temperatures(np.array([rig.stamp]), np.array([celsius]))[0])
        rig.send([0.001], ["left"])
        rig.send([np.nan, 0.002], ["left", "right"])
        rig.send([0.01, 0.01], ["left", "right"], stamp=rig.stamp - 3 * MS)
    answered = 3 * 152
    rig.wait(lambda: len(rig.forces) >= answered, "all answers")
    if end == "kill":
        rig.listen(1.5)  # more than the time between chunks
        rig.drive(20, ["left", "right"])
    getattr(process, end)()
    process.wait()
    (file,) = (tmp_path / "bags").glob("*.mcap")
    stamps, values = forces(file)
    assert stamps.size >= answered and (end == "kill" or stamps.size == answered)
    assert ("cut off" in caplog.text) == (end == "kill")
    assert main(["replay", str(file), "-m", str(model), "-o", str(tmp_path / "again.mcap")]) == 0
    again_stamps, again = forces(tmp_path / "again.mcap")
    assert np.array_equal(stamps, again_stamps[: stamps.size]) and np.array_equal(
        values, again[: stamps.size], equal_nan=True
    )
    assert again_stamps.size - stamps.size <= 1  # the input is recorded before its answer


def test_files_are_rotated_by_size_and_only_the_newest_are_kept(tmp_path):
    from damper_estimator.node.recorder import Recorder

    recorder = Recorder(str(tmp_path), 1, 2)
    recorder.start()
    noise = np.random.default_rng(0)
    for _ in range(10):
        for message in floats(noise.standard_normal(20_000)):
            recorder.keep("/x", "std_msgs/msg/Float64", message)
        time.sleep(0.6)
    recorder.stop()
    files = sorted(tmp_path.glob("*.mcap"))
    assert len(files) == 2 and all(file.stat().st_size < 3_000_000 for file in files)
    assert recorder.health()[2]["messages"] == 200_000 and recorder.health()[2]["not recorded"] == 0
    for file in files:
        with open_bag(file) as bag:
            assert bag.topics[0].messages > 0


def test_a_folder_that_cannot_be_written_is_refused(start, tmp_path):
    (tmp_path / "file").write_text("")
    process = start(model="coulomb", dampers="[left]", record=tmp_path / "file" / "bags")
    said = process.communicate(timeout=90.0)[1]
    assert process.returncode == 1 and "parameter record" in said.splitlines()[-1]
