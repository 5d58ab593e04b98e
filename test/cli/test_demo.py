"""demo: the example on the shipped recordings, in a separate folder."""

import json
from pathlib import Path

import pytest

from damper_estimator.cli import demo
from damper_estimator.cli.main import main

BAGS = Path(__file__).resolve().parents[2] / "bags"


def test_the_story_finds_the_hidden_effect_and_the_error_falls(tmp_path, capsys):
    folder = tmp_path / "story"
    assert main(["demo", "-o", str(folder), "--json", "-"]) == 0
    captured = capsys.readouterr()
    found = json.loads(captured.out)
    assert found["verdict"] == "missing"
    assert "oil_compressibility" in (found["found"], *found["tied_with"])
    assert found["noise_floor_n"] < found["rmse_after_n"] < 0.3 * found["rmse_before_n"]
    assert f"before   rms error on the road {found['rmse_before_n']:.1f} N" in captured.err
    for name in (*demo.PAGES, demo.BEFORE, demo.FINDING, demo.AFTER, "mine.yaml", "better.yaml"):
        assert (folder / name).stat().st_size > 0
    commands = [command for _, group in demo.STORY for command in group]
    assert [line[2:] for line in captured.err.splitlines() if line.startswith("$ ")] == [
        f"damper-estimator {command}" for command in commands
    ]


def test_the_recordings_are_the_shipped_ones(tmp_path):
    demo.copy_recordings(tmp_path / "story")
    for path in BAGS.glob("*.mcap"):
        assert (tmp_path / "story" / path.name).read_bytes() == path.read_bytes()


def test_a_folder_of_an_earlier_demo_is_used_again(tmp_path):
    demo.copy_recordings(tmp_path)
    (tmp_path / "mine.yaml").touch()
    (tmp_path / "hidden_fit.mcap").write_bytes(b"")
    demo.copy_recordings(tmp_path)
    assert (tmp_path / "hidden_fit.mcap").stat().st_size > 0 and (tmp_path / "mine.yaml").exists()


@pytest.mark.parametrize("name", ["folder", "folder/mine.yaml"])
def test_a_folder_with_other_content_is_not_changed(name, tmp_path, refused):
    (tmp_path / "folder").mkdir()
    (tmp_path / "folder" / "mine.yaml").write_text("mine")
    assert "is not the folder of an earlier demo" in refused("demo", "-o", tmp_path / name)
    assert (tmp_path / "folder" / "mine.yaml").read_text() == "mine"
    assert [path.name for path in (tmp_path / "folder").iterdir()] == ["mine.yaml"]


def test_a_command_that_fails_ends_the_story_with_its_status(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(demo, "STORY", (("Nothing to read", ["inspect nowhere.mcap", "effects"]),))
    assert main(["demo", "-o", str(tmp_path / "story")]) == 1
    captured = capsys.readouterr()
    assert "nowhere.mcap" in captured.err and "damper-estimator effects" not in captured.out
