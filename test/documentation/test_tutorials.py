"""The tutorials' commands do what the pages say, one after the other, on the recordings that come with the project."""

import shutil

import numpy as np
import pytest
from drives import samples
from pages import ROOT, commands

from damper_estimator.cli.main import main
from damper_estimator.model import load_model

# Verbs with separate long tests; the commands are parsed by ``test_pages``.
ELSEWHERE = {"ride", "fleet"}


def run(page, folder, monkeypatch, **replaced):
    """All commands of a tutorial that need no ROS, in its order; the files that they left."""
    monkeypatch.chdir(folder)
    for words in commands(ROOT / "docs" / page):
        if words[0] == "damper-estimator" and words[1] not in ELSEWHERE:
            arguments = [replaced.get(word, word) for word in words[1:]]
            assert main(arguments) == 0, " ".join(words)
    return {path.name for path in folder.iterdir()}


def test_the_hidden_effect_is_found_and_put_in(tmp_path, monkeypatch):
    for name in ("base", "fit", "unseen"):
        shutil.copy(ROOT / "bags" / f"hidden_{name}.mcap", tmp_path)
    left = run("hidden_effect.md", tmp_path, monkeypatch)
    assert {"comparison.html", "diagnosis.html", "improvement.html", "replayed.mcap"} <= left
    assert {"oil_spring"} <= {entry.effect.name for entry in load_model(tmp_path / "better.yaml").effects}


def test_a_bench_file_becomes_a_model(tmp_path, monkeypatch):
    time, x, force, _ = samples(seconds=20.0)
    noise = np.random.default_rng(1)
    rest = np.arange(400) * 0.005
    rows = np.column_stack(
        [
            np.concatenate([rest, 2.0 + time - time[0]]),
            np.concatenate([1e-3 * noise.standard_normal(400), 1e3 * x]),
            np.concatenate([3.0 * noise.standard_normal(400), force]),
        ]
    )
    titles = "Time [s],Travel [mm],Load [N]"
    np.savetxt(tmp_path / "run.csv", rows, delimiter=",", header=titles, comments="", fmt="%.6f")
    left = run("bench_file.md", tmp_path, monkeypatch, carrera_akutain="coulomb")
    assert {"run_columns.yaml", "run_preview.html", "run.mcap", "mine.yaml", "page.html", "diagnosis.html"} <= left


def test_a_semi_active_damper_is_identified(tmp_path, monkeypatch):
    for name in ("random", "road"):
        shutil.copy(ROOT / "bags" / f"semi_active_{name}.mcap", tmp_path)
    assert "mine.yaml" in run("semi_active.md", tmp_path, monkeypatch)


@pytest.mark.parametrize("name", ["first_fleet.md", "vehicle.md"])
def test_the_other_tutorials_name_recordings_or_files_that_the_reader_has(name):
    named = [word for words in commands(ROOT / "docs" / name) for word in words if word.startswith("bags/")]
    assert all(list(ROOT.glob(pattern)) for pattern in named)
