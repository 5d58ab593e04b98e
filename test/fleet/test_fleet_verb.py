"""The verb as users call it: the same results as the single verbs, on any worker and in any order."""

import json
import os
import resource
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import pyarrow.parquet as parquet
import pytest
from fleet_bags import write_drive

from damper_estimator import __version__
from damper_estimator.cli.main import main
from damper_estimator.fleet import cluster
from damper_estimator.fleet.result_rows import write_rows
from damper_estimator.fleet.task_execution import execute
from damper_estimator.fleet.verbs import Compare, Replay, work
from damper_estimator.model import load_model

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def fleet(client, model, tmp_path, capsys):
    """Runs ``fleet`` on the tests' cluster; returns the exit status, the JSON results and standard error."""

    def call(verb, *sources, output="out", options=()):
        words = ["fleet", verb, *map(str, sources), "-m", str(model), "-o", str(tmp_path / output), "--json", "-"]
        status = main([*words, "--scheduler", client.scheduler.address, *options])
        captured = capsys.readouterr()
        return status, json.loads(captured.out) if captured.out else None, captured.err

    return call


def command(*words):
    return [sys.executable, "-m", "damper_estimator", "fleet", *map(str, words)]


def environment():
    return os.environ | {"PYTHONPATH": str(ROOT)}


def results(folder):
    """Bytes of every result, by path inside the folder."""
    return {
        str(path.relative_to(folder)): path.read_bytes().replace(str(folder).encode(), b"DIR")
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


@pytest.mark.parametrize("options", [Compare(), Replay()])
def test_two_workers_write_the_same_bytes_as_one_process_in_another_order(run, drives, tmp_path, options):
    spread = run(drives / "*" / "*.mcap", work=work, options=options)
    there, here = tmp_path / "out", tmp_path / "here"
    alone = [replace(task, folder=task.folder.replace(str(there), str(here))) for task in spread.tasks[::-1]]
    for task in alone:
        Path(task.folder).mkdir(parents=True, exist_ok=True)
        assert execute(task, work, __version__).reason == ""
    for output, tasks in ((there, spread.tasks), (here, alone)):
        write_rows(output, options.verb, tasks)
    expected = results(here)
    assert f"rows/{options.verb}.parquet" in expected and len(expected) == 1 + 4 * 3
    found = results(there)
    assert {name: found[name] for name in expected} == expected


def test_a_task_writes_what_the_single_verb_writes(fleet, drives, model, tmp_path):
    status, record, _ = fleet("compare", drives / "car_b" / "*.mcap")
    assert (status, record["done"]) == (0, 1)
    bag, single, page = drives / "car_b" / "monday.mcap", tmp_path / "single.json", tmp_path / "single.html"
    main(["compare", str(bag), "-m", str(model), "-d", "front_left", "--json", str(single), "--html", str(page)])
    (folder,) = (tmp_path / "out" / "tasks").iterdir()
    assert (folder / "front_left.compare.json").read_text() == single.read_text()
    assert (folder / "front_left.compare.html").read_text() in without_plotly(page.read_text())
    (row,) = parquet.read_table(tmp_path / "out" / "rows").to_pylist()
    expected = json.loads(single.read_text())["dampers"]["front_left"]
    assert {name: row[name] for name in ("rmse_n", "esr", "samples", "bias_n")} == {
        name: expected[name] for name in ("rmse_n", "esr", "samples", "bias_n")
    }


def without_plotly(page):
    """A single page that loads plotly from a file."""
    head, rest = page.split("<script>", 1)
    return f'{head}<script src="../../plotly.min.js"></script>{rest.split("</script>", 1)[1]}'


def test_all_verbs_together_are_one_dataset(fleet, drives, tmp_path):
    for verb, options in {"compare": [], "diagnose": ["--keep-parameters"], "fit": [], "replay": []}.items():
        status, record, _ = fleet(verb, drives / "car_b" / "*.mcap", options=options)
        assert (status, record["failed"]) == (0, 0)
    rows = {row["verb"]: row for row in parquet.read_table(tmp_path / "out" / "rows").to_pylist()}
    assert set(rows) == {"compare", "diagnose", "fit", "replay"}
    assert rows["diagnose"]["verdict"] and len(rows["diagnose"]["missing"]) == len(rows["diagnose"]["confidence"])
    assert rows["fit"]["rmse_n"] < rows["fit"]["rmse_before_n"] == pytest.approx(rows["compare"]["rmse_n"])
    assert dict(rows["fit"]["parameters"])["linear_viscous.rebound"] == pytest.approx(1500.0, rel=0.02)
    assert rows["replay"]["estimates"] == 1200 and rows["replay"]["residual_rms_n"] > 0.0
    assert all(row["version"] and row["model_checksum"] and row["recording_checksum"] for row in rows.values())


def test_a_joint_fit_makes_a_model_per_damper_and_compares_with_it(fleet, drives, tmp_path):
    status, record, _ = fleet("fit", drives / "*" / "*.mcap", options=["--joint", "damper", "--fix", "tanh_hysteresis"])
    assert (status, record["verb"], record["failed"]) == (0, "compare", 0)
    models = tmp_path / "out" / "models"
    assert sorted(path.name for path in models.glob("*.yaml")) == ["front_left.yaml", "front_right.yaml"]
    assert load_model(models, "front_left").fit["bags"] == sorted(map(str, drives.glob("*/*.mcap")))
    rows = parquet.read_table(tmp_path / "out" / "rows").to_pylist()
    assert {row["model_file"] for row in rows} == {str(models)} and len(rows) == 4
    changed = (models / "front_left.yaml").stat().st_mtime_ns
    status, record, _ = fleet("fit", drives / "*" / "*.mcap", options=["--joint", "damper", "--fix", "tanh_hysteresis"])
    assert record["kept"] == 4 and (models / "front_left.yaml").stat().st_mtime_ns == changed


def test_a_signal_map_and_options_reach_the_tasks(fleet, drives, tmp_path):
    (tmp_path / "map.yaml").write_text("filter: {cutoff: 40.0}\n")
    fleet("compare", drives / "car_b" / "*.mcap", options=["--from=2", "-s", str(tmp_path / "map.yaml")])
    (row,) = parquet.read_table(tmp_path / "out" / "rows").to_pylist()
    assert row["settings"] == "--from=2.0" and row["signals_checksum"] and 700 < row["samples"] <= 800
    assert fleet("compare", drives / "car_b" / "*.mcap", options=["--from=2"])[1]["done"] == 1


@pytest.mark.parametrize("verb", ["compare", "diagnose", "fit"])
def test_a_recording_in_another_unit_is_listed_and_the_others_are_not(fleet, drives, tmp_path, verb):
    write_drive(drives / "car_c" / "rig.mcap", seed=7, scale=1000.0)
    status, record, _ = fleet(verb, drives / "car_[bc]" / "*.mcap")
    assert (status, record["failed"]) == (0, 0)
    (spoiled,) = record["spoiled"]
    assert spoiled["recording"].endswith("rig.mcap") and "probably the displacement is in mm" in spoiled["spoiled"]
    rows = {Path(row["recording"]).name: row for row in parquet.read_table(tmp_path / "out" / "rows").to_pylist()}
    assert [text.split(":")[0] for text in rows["rig.mcap"]["data_findings"]] == ["unit"]
    assert rows["monday.mcap"]["data_findings"] == [] and rows["monday.mcap"]["spoiled"] == ""


def test_failures_are_listed_and_the_status_is_1_only_if_all_failed(fleet, drives):
    (drives / "car_b" / "foreign.mcap").write_bytes(b"PK\x03\x04" + bytes(500))
    status, record, _ = fleet("compare", drives / "car_b" / "*.mcap")
    assert status == 0 and [Path(failure["recording"]).name for failure in record["failures"]] == ["foreign.mcap"]
    status, record, _ = fleet("compare", drives / "car_b" / "foreign.mcap", output="none")
    assert status == 1 and record["failed"] == record["tasks"] == 1


def test_a_scheduler_that_cannot_be_reached_is_one_line(drives, model, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(cluster, "_TIMEOUT", 1)
    words = ["fleet", "compare", str(drives / "*" / "*.mcap"), "-m", str(model), "-o", str(tmp_path / "out")]
    assert main([*words, "--scheduler", "tcp://127.0.0.1:9"]) == 1
    (line,) = capsys.readouterr().err.strip().splitlines()
    assert line == (
        "damper-estimator: tcp://127.0.0.1:9: no scheduler answers; start one (dask scheduler) or omit --scheduler"
    )


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["-m", "no_such_model"], "no_such_model: is neither a model file nor"),
        (["-m", "guo", "--memory", "much"], "--memory much: is not an amount of memory"),
    ],
)
def test_a_run_that_cannot_start_is_one_line(drives, tmp_path, capsys, options, message):
    assert main(["fleet", "compare", str(drives / "*" / "*.mcap"), "-o", str(tmp_path / "out"), *options]) == 1
    assert message in capsys.readouterr().err.strip().splitlines()[-1]


def test_a_killed_run_is_continued_by_the_next(model, tmp_path):
    for seed in range(8):
        write_drive(tmp_path / "many" / f"{seed:02}.mcap", seed, seconds=8.0)
    output = tmp_path / "out"
    words = command("compare", tmp_path / "many" / "*.mcap", "-m", model, "-o", output, "--workers", 1, "--json", "-")
    first = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=environment())
    deadline = time.monotonic() + 300.0
    while len(list(output.glob("tasks/*/*.row.json"))) < 2 and time.monotonic() < deadline:
        time.sleep(0.02)
    first.send_signal(signal.SIGKILL)
    first.communicate()
    assert not (output / "rows").exists()
    second = subprocess.run(words, capture_output=True, env=environment())
    record = json.loads(second.stdout)
    assert (second.returncode, record["tasks"], record["failed"]) == (0, 8, 0)
    assert record["kept"] >= 2 and record["kept"] + record["done"] == 8
    assert parquet.read_table(output / "rows").num_rows == 8


def test_a_full_disk_is_one_line_and_leaves_nothing_half_written(drives, model, tmp_path):
    """A limit on the size of files acts like a full disk, also in the workers."""
    output = tmp_path / "out"
    words = command("compare", drives / "*" / "*.mcap", "-m", model, "-o", output, "--workers", 1, "--no-pages")
    limited = subprocess.run(
        words,
        capture_output=True,
        text=True,
        env=environment(),
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (9000, 9000)),
    )
    assert limited.returncode == 1
    assert "File too large" in limited.stderr.splitlines()[-1] and "Traceback" not in limited.stderr
    assert not list(output.rglob("*.part"))
