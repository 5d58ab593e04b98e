"""A run survives every failure: finished work is kept, nothing is lost, nothing is done twice."""

import os
from collections import Counter
from pathlib import Path

import pytest
from fleet_bags import dies_always, dies_four_times, dies_once, fills_the_disk, has_a_bug, quick, write_drive

from damper_estimator.errors import InputError
from damper_estimator.fleet.cluster import connected
from damper_estimator.fleet.result_rows import read_rows, write_rows
from damper_estimator.fleet.task_execution import execute
from damper_estimator.fleet.verbs import Compare


def rows_of(fleet):
    write_rows(fleet.request.output, "compare", fleet.tasks)
    return read_rows(fleet.request.output)["compare"]


def counted(fleet):
    """How often each task was started, over all runs."""
    return {
        ("/".join(Path(task.recording).parts[-2:]), task.damper): len(
            (Path(task.folder) / f"{task.damper}.attempts").open().readlines()
        )
        for task in fleet.tasks
    }


def test_a_row_per_recording_and_damper_in_order(run, drives):
    rows = rows_of(run(drives / "*" / "*.mcap"))
    key = [(row["recording"].removeprefix(f"{drives}/"), row["vehicle"], row["damper"]) for row in rows]
    assert key == [
        ("car_a/monday.mcap", "car_a", "front_left"),
        ("car_a/tuesday.mcap", "car_a", "front_left"),
        ("car_a/tuesday.mcap", "car_a", "front_right"),
        ("car_b/monday.mcap", "car_b", "front_left"),
    ]
    assert [row["temperature_c"] for row in rows] == [30.0, 40.0, 40.0, 30.0]
    assert {row["status"] for row in rows} == {"done"} and {row["begin"] for row in rows} == {1_700_000_000 * 10**9}


def test_a_second_run_does_nothing(run, drives):
    first = run(drives / "*" / "*.mcap")
    second = run(drives / "*" / "*.mcap")
    assert (first.counts.done, first.counts.kept) == (4, 0) and (second.counts.done, second.counts.kept) == (0, 4)
    assert set(counted(second).values()) == {1}


def test_only_what_changed_is_done_again(run, drives, model):
    run(drives / "*" / "*.mcap")
    os.utime(drives / "car_b" / "monday.mcap")  # touched, but the same
    write_drive(drives / "car_a" / "monday.mcap", seed=9)
    again = run(drives / "*" / "*.mcap")
    assert (again.counts.done, again.counts.kept) == (1, 3)
    assert [name for name, count in counted(again).items() if count == 2] == [("car_a/monday.mcap", "front_left")]
    model.write_text(model.read_text().replace("1400.0", "1300.0"))
    assert run(drives / "*" / "*.mcap").counts.done == 4
    assert run(drives / "*" / "*.mcap", options=Compare(start=1.0)).counts.done == 4


def test_a_new_label_changes_the_table_and_needs_no_work(run, drives, tmp_path):
    run(drives / "car_b" / "*.mcap")
    (tmp_path / "fleet.yaml").write_text(f"- {{recording: {drives}/car_b/monday.mcap, vehicle: seven}}\n")
    again = run(tmp_path / "fleet.yaml")
    assert again.counts.done == 0 and [row["vehicle"] for row in rows_of(again)] == ["seven"]


def test_bad_recordings_are_listed_with_their_reason_and_stop_nothing(run, drives):
    whole = (drives / "car_b" / "monday.mcap").read_bytes()
    (drives / "car_b" / "cut.mcap").write_bytes(whole[:300])
    (drives / "car_b" / "half.mcap").write_bytes(whole[: len(whole) // 2])
    (drives / "car_b" / "foreign.mcap").write_bytes(b"PK\x03\x04" + bytes(500))
    (drives / "car_b" / "empty.mcap").touch()
    fleet = run(drives / "*" / "*.mcap", drives / "gone.mcap")
    rows = {Path(row["recording"]).name: row for row in rows_of(fleet) if row["status"] == "failed"}
    assert set(rows) == {"cut.mcap", "foreign.mcap", "empty.mcap", "gone.mcap"}
    assert all(name in row["reason"] and "\n" not in row["reason"] for name, row in rows.items())
    assert (fleet.counts.failed, fleet.counts.known) == (4, 9)
    # The intact part of a recording is used, with a note that it is not complete.
    assert [row["notes"] != "" for row in rows_of(fleet) if row["status"] == "done"] == [
        False,
        False,
        False,
        True,
        False,
    ]
    # Unchanged failures are not tried again, unless --retry is given.
    again = run(drives / "*" / "*.mcap", drives / "gone.mcap")
    assert (again.counts.done, again.counts.failed) == (0, 4)
    assert run(drives / "*" / "*.mcap", retry=True).counts.done == 3
    (drives / "car_b" / "cut.mcap").write_bytes(whole)
    assert run(drives / "*" / "*.mcap").counts.failed == 2


def test_a_damper_without_a_model_fails_alone(run, drives, tmp_path, model):
    folder = tmp_path / "models"
    folder.mkdir()
    model.rename(folder / "front_left.yaml")
    (tmp_path / "fleet.yaml").write_text(f"- {{recording: {drives}/car_a/tuesday.mcap, model: models}}\n")
    left, right = rows_of(run(tmp_path / "fleet.yaml"))
    assert (left["status"], right["status"]) == ("done", "failed") and "front_right" in right["reason"]


def test_a_worker_that_is_killed_loses_and_repeats_nothing(run, drives):
    write_drive(drives / "car_b" / "deadly.mcap", 5)
    fleet = run(drives / "*" / "*.mcap", work=dies_once)
    rows = rows_of(fleet)
    assert len(rows) == 5 and {row["status"] for row in rows} == {"done"}
    assert max(Counter((row["recording"], row["damper"]) for row in rows).values()) == 1
    assert not list(fleet.request.output.rglob("*.part"))


def test_a_recording_that_kills_every_worker_fails_and_stops_nothing(run, drives):
    write_drive(drives / "car_b" / "deadly.mcap", 5)
    rows = rows_of(run(drives / "*" / "*.mcap", work=dies_always))
    failed = [row for row in rows if row["status"] == "failed"]
    assert len(rows) == 5 and [Path(row["recording"]).name for row in failed] == ["deadly.mcap"]
    assert "killed its worker" in failed[0]["reason"]


def test_a_task_that_dask_gives_up_is_retried_alone(run, drives):
    """Dask counts each death of a worker against every task there, even those that only waited."""
    write_drive(drives / "car_b" / "unlucky.mcap", 5)
    rows = rows_of(run(drives / "*" / "*.mcap", work=dies_four_times))
    assert len(rows) == 5 and {row["status"] for row in rows} == {"done"}


def test_a_worker_that_dask_does_not_restart_is_restarted():
    with connected(None, 1, "auto") as client:
        client.sync(client.cluster.workers[0].close)
        assert client.submit(pow, 2, 3).result(timeout=60) == 8


def test_a_full_disk_ends_the_work_and_keeps_what_was_done(run, drives):
    write_drive(drives / "car_b" / "large.mcap", 5)
    with pytest.raises(InputError, match="No space left on device.*free some space"):
        run(drives / "*" / "*.mcap", work=fills_the_disk)
    after = run(drives / "*" / "*.mcap")
    assert after.counts.failed == 0 and after.counts.known == 5 and after.counts.kept + after.counts.done == 5


def test_an_unexpected_exception_is_one_failure_with_its_traceback_in_a_file(run, drives):
    write_drive(drives / "car_b" / "odd.mcap", 5)
    (failed,) = [row for row in rows_of(run(drives / "*" / "*.mcap", work=has_a_bug)) if row["status"] == "failed"]
    assert failed["reason"].startswith("ZeroDivisionError: in our code (unexpected")
    assert "Traceback" in next((drives.parent / "out").rglob("*.error.txt")).read_text()


def test_an_interruption_keeps_what_was_done(run, drives):
    def interrupt(counts):
        if counts.done == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run(drives / "*" / "*.mcap", progress=interrupt)
    after = run(drives / "*" / "*.mcap")
    assert after.counts.kept >= 2 and after.counts.kept + after.counts.done == 4


def test_no_more_tasks_are_submitted_than_the_workers_need(run, client, tmp_path, monkeypatch):
    for seed in range(24):
        write_drive(tmp_path / "many" / f"{seed}.mcap", seed, seconds=2.0)
    submitted, most = [], []
    submit = client.submit
    monkeypatch.setattr(client, "submit", lambda *a, **k: submitted.append(1) or submit(*a, **k))
    run(tmp_path / "many" / "*.mcap", progress=lambda t: most.append(len(submitted) - t.done - t.looked_at))
    assert len(submitted) == 48 and max(most) <= 8


def test_another_version_on_the_worker_ends_the_work(run, drives):
    (task,) = run(drives / "car_b" / "*.mcap").tasks
    with pytest.raises(InputError, match="install the same"):
        execute(task, quick, "0.0.0")


def test_workers_do_not_profile_themselves(client):
    """Dask would store an hour of samples, which fills the memory."""
    samplers = client.run(lambda dask_worker: [name for name in dask_worker.periodic_callbacks if "profile" in name])
    assert len(samplers) == 2 and not any(samplers.values())
