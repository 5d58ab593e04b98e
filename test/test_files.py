"""Results never replace what they were made from."""

from pathlib import Path
from shutil import copy

import pytest

from damper_estimator.cli.main import main
from damper_estimator.errors import InputError
from damper_estimator.files import write_text


@pytest.mark.parametrize(
    "name, start", [("a.mcap", b"\x89MCAP0\r\n"), ("a.db3", b"SQLite format 3\0"), ("a.yaml", b"\x89MCAP0")]
)
def test_a_recording_is_not_replaced_by_text(name, start, tmp_path):
    place = tmp_path / name
    place.write_bytes(start + b"samples")
    with pytest.raises(InputError, match="is a recording"):
        write_text(place, "name: model\n")
    assert place.read_bytes() == start + b"samples" and [*tmp_path.iterdir()] == [place]


@pytest.mark.parametrize("text", ["{}\n", "<!doctype html>\n"])
def test_a_model_is_replaced_by_a_model_and_by_nothing_else(text, tmp_path):
    place = tmp_path / "mine.yaml"
    write_text(place, "name: first\n")
    write_text(place, "name: second\n")
    with pytest.raises(InputError, match="YAML file"):
        write_text(place, text)
    assert place.read_text() == "name: second\n"
    write_text(tmp_path / "new.json", text)


@pytest.fixture
def recording(tmp_path):
    """A copy of a sample recording."""
    return Path(copy(Path(__file__).parent.parent / "bags/passenger_random.mcap", tmp_path / "a.mcap"))


def test_a_signal_map_written_onto_its_recording_is_refused_in_one_line(recording, capsys):
    before = recording.read_bytes()
    assert main(["inspect", str(recording), "-o", str(recording)]) == 1
    assert recording.read_bytes() == before
    assert "is a recording" in capsys.readouterr().err.splitlines()[-1]
