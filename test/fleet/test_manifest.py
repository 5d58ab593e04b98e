"""The recordings that a manifest, a pattern or a path names."""

import pytest

from damper_estimator.errors import InputError
from damper_estimator.fleet.manifest import find_recordings


@pytest.fixture
def files(tmp_path):
    """Recordings as files and folders among other files; only their names matter here."""
    for name in ("car_a/one.mcap", "car_a/two.mcap", "car_b/one.mcap", "car_b/notes.txt", "car_b/log/log_0.mcap"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).touch()
    (tmp_path / "car_b/log/metadata.yaml").touch()
    return tmp_path


def test_a_pattern_finds_files_and_folders_and_names_the_vehicle_after_the_folder(files):
    found = find_recordings([str(files / "**" / "*")])
    assert [(recording.path.removeprefix(f"{files}/"), recording.vehicle) for recording in found] == [
        ("car_a/one.mcap", "car_a"),
        ("car_a/two.mcap", "car_a"),
        ("car_b/log", "car_b"),
        ("car_b/one.mcap", "car_b"),
    ]


def test_the_order_of_sources_does_not_matter(files):
    sources = [str(files / "car_b" / "*.mcap"), str(files / "car_a" / "two.mcap"), str(files / "car_a" / "one.mcap")]
    assert find_recordings(sources) == find_recordings(sources[::-1])


def test_a_manifest_describes_each_recording(files):
    (files / "map.yaml").touch()
    (files / "special.yaml").touch()
    entry = "{recording: car_a/one.mcap, vehicle: A 1, dampers: [left], signals: map.yaml, model: special.yaml}"
    (files / "fleet.yaml").write_text(f"recordings:\n  - {entry}\n  - {{recording: 'car_b/*.mcap', model: guo}}\n")
    first, second = find_recordings([str(files / "fleet.yaml")], dampers=["right"])
    assert (first.vehicle, first.dampers, second.vehicle, second.dampers) == ("A 1", ("left",), "car_b", ("right",))
    assert (first.signals, first.model) == (str(files / "map.yaml"), str(files / "special.yaml"))
    assert (second.signals, second.model) == ("", "guo")


def test_a_table_says_the_same_as_yaml(files):
    (files / "fleet.csv").write_text("recording,vehicle,dampers\ncar_a/one.mcap,A 1,left right\ncar_b/one.mcap,,\n")
    (files / "fleet.yaml").write_text(
        "- {recording: car_a/one.mcap, vehicle: A 1, dampers: [left, right]}\n- car_b/one.mcap\n"
    )
    assert find_recordings([str(files / "fleet.csv")]) == find_recordings([str(files / "fleet.yaml")])


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("a.yaml", "recordings: 3", "not a manifest"),
        ("a.yaml", "recordings: []", "names no recording"),
        ("a.yaml", "- {recording: x.mcap, car: 1}", "entry 1 has car; allowed are recording, vehicle"),
        ("a.yaml", "- {vehicle: 1}", "entry 1 names no recording"),
        ("a.yaml", "- {recording: x.mcap, dampers: left}", "'left' is not a list"),
        ("a.yaml", "- x.mcap\n- x.mcap", "twice"),
        ("a.yaml", "- '*.mcap'", "no recording"),
        ("a.yaml", "[1", "not valid YAML"),
        ("a.csv", "recording,colour\nx.mcap,red\n", "colour"),
        ("a.csv", "recording\nx.mcap,red\n", "more"),
        ("missing.csv", None, "cannot be read"),
    ],
)
def test_a_faulty_manifest_is_reported_in_one_line(tmp_path, name, text, message):
    path = tmp_path / name
    if text is not None:
        path.write_text(text)
    with pytest.raises(InputError) as refused:
        find_recordings([str(path)])
    assert message in str(refused.value) and "\n" not in str(refused.value) and str(path) in str(refused.value)
