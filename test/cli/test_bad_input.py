"""Every verb with every kind of unusable input: one line, status 1, no partial output."""

import numpy as np
import pytest

from damper_estimator.cli.main import main

MODEL = "effects:\n  - linear_viscous: {rebound: 1500.0, compression: 1200.0}\n"
FAULTY_BAGS = {
    "truncated.mcap": "truncated",
    "empty.mcap": "empty",
    "text.mcap": "mcap",
    "nowhere.mcap": "nowhere.mcap",
    "folder": "metadata.yaml",
}
FAULTY_MODELS = {
    "effects: [no_such_effect]": "unknown effect 'no_such_effect'",
    "effects: [{coulomb: {force: -1}}]": "outside 0 to 10000 N",
    "": "not a model file",
}
FAULTY_MAPS = {
    "dampers: {left: {displacement: {field: 'position[left].x'}}}": "position[left].x",
    "dampers: {left: {displacement: {colour: red}}}": "'colour'",
    "dampers: {nobody: {displacement: {scale: 1.0}}}": "nobody",
    "dampers: {left: {force: {topic: /no/such/topic}}}": "/no/such/topic",
    "filter: {cutoff: -1}": "filter.cutoff",
}


def motion():
    """Stamps, displacement and force of a damper that rests for two seconds and then moves."""
    time = np.arange(3000) * 0.002
    moving = time > 2.0
    x = np.where(moving, 0.02 * np.sin(12.0 * (time - 2.0)), 0.0)
    force = np.where(moving, 1500.0 * 0.24 * np.cos(12.0 * (time - 2.0)), 0.0)
    return 10**18 + np.arange(3000) * 2_000_000, x.reshape(-1, 1), force.reshape(-1, 1)


@pytest.fixture
def good(write_bag, tmp_path):
    """A usable bag and model; the folder's content is compared before and after each refusal."""
    bag = write_bag("good.mcap", ["left"], *motion())
    (tmp_path / "model.yaml").write_text(MODEL)
    (tmp_path / "truncated.mcap").write_bytes(bag.read_bytes()[: bag.stat().st_size // 3])
    (tmp_path / "empty.mcap").write_bytes(b"")
    (tmp_path / "text.mcap").write_text("time,force\n0,1\n" * 50)
    (tmp_path / "folder").mkdir()
    return tmp_path


def words(verb, bag, folder, model="model.yaml", output=None):
    """The verb's command line."""
    line = [verb, str(folder / bag)]
    if verb in ("compare", "fit", "replay"):
        line += ["-m", str(folder / model)]
    outputs = {"fit": "out.yaml", "replay": "out.mcap", "tare": "map.yaml"}
    if verb in outputs:
        line += ["-o", str(output or folder / outputs[verb])]
    return line


def refused(line, folder, capsys):
    """Runs it; the one line on standard error, after checking that the folder is unchanged."""
    before = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    assert main(line) == 1
    captured = capsys.readouterr()
    last = captured.err.strip().splitlines()[-1]
    assert captured.out == "" and "Traceback" not in captured.err
    assert last.startswith("damper-estimator: ")
    assert {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()} == before
    return last


@pytest.mark.parametrize("verb", ["inspect", "compare", "fit", "replay", "tare"])
@pytest.mark.parametrize("bag", FAULTY_BAGS)
def test_a_recording_that_cannot_be_read(verb, bag, good, capsys):
    line = refused(words(verb, bag, good), good, capsys)
    assert bag in line and FAULTY_BAGS[bag] in line


@pytest.mark.parametrize("verb", ["compare", "fit", "replay"])
@pytest.mark.parametrize("content", FAULTY_MODELS)
def test_a_model_that_cannot_be_used(verb, content, good, capsys):
    (good / "bad.yaml").write_text(content)
    assert FAULTY_MODELS[content] in refused(words(verb, "good.mcap", good, "bad.yaml"), good, capsys)


def test_a_model_with_effects_of_the_measurement_chain_is_not_deployed(good, capsys):
    (good / "bad.yaml").write_text("effects: [coulomb, force_offset]")
    line = refused(words("replay", "good.mcap", good, "bad.yaml"), good, capsys)
    assert "force_offset" in line and "signal map" in line


@pytest.mark.parametrize("verb", ["compare", "fit", "replay", "tare"])
@pytest.mark.parametrize("content", FAULTY_MAPS)
def test_a_signal_map_that_does_not_fit_the_recording(verb, content, good, capsys):
    (good / "map.yml").write_text(content)
    line = refused([*words(verb, "good.mcap", good), "-s", str(good / "map.yml")], good, capsys)
    assert FAULTY_MAPS[content] in line


@pytest.mark.parametrize("verb", ["compare", "fit", "replay", "tare"])
def test_a_damper_that_is_not_in_the_messages(verb, good, capsys):
    line = refused([*words(verb, "good.mcap", good), "-d", "rear"], good, capsys)
    assert "rear" in line and "left" in line


@pytest.mark.parametrize("verb", ["compare", "fit", "replay", "tare"])
def test_a_recording_without_displacement(verb, good, write_bag, capsys):
    stamp = 10**18 + np.arange(100) * 2_000_000
    write_bag("other.mcap", ["left"], stamp, np.zeros((100, 1)), prefix="/chassis/roll")
    line = refused(words(verb, "other.mcap", good), good, capsys)
    assert "suspension/displacement" in line and "/chassis/roll/displacement" in line


@pytest.mark.parametrize("verb", ["compare", "fit", "diagnose", "improve", "characterize"])
def test_a_recording_without_force_is_refused_by_the_verb_in_use(verb, good, write_bag, capsys):
    stamp, x, _ = motion()
    write_bag("moved.mcap", ["left"], stamp, x)
    line = [verb, str(good / "moved.mcap")]
    line += [] if verb == "characterize" else ["-m", str(good / "model.yaml")]
    line += ["-o", str(good / "out.yaml")] if verb in ("fit", "improve") else []
    message = refused(line, good, capsys)
    assert message.endswith(
        f"moved.mcap: no damper has a measured force; {verb} needs one (name its topic in a signal map)"
    )


@pytest.mark.parametrize(("verb", "place"), [("fit", "model.yaml/out.yaml"), ("replay", "model.yaml/out.mcap"),
                                              ("tare", "model.yaml/out.yaml"), ("replay", "folder"), ("tare", "folder"),
                                              ("replay", "/dev/full/out.mcap")])  # fmt: skip
def test_an_output_that_cannot_be_written(verb, place, good, capsys):
    target = good / place
    before = sorted(str(path) for path in good.rglob("*"))
    assert main(words(verb, "good.mcap", good, output=target)) == 1
    last = capsys.readouterr().err.strip().splitlines()[-1]
    assert last.startswith("damper-estimator: ") and str(target.parent) in last
    assert sorted(str(path) for path in good.rglob("*")) == before


@pytest.mark.parametrize("verb", ["inspect", "compare", "fit", "replay"])
def test_displacement_that_is_not_a_number_is_counted_and_tolerated(verb, good, write_bag, capsys):
    stamp, x, force = motion()
    x[1500:1505] = np.nan
    force[1800] = np.inf
    write_bag("nan.mcap", ["left"], stamp, x, force)
    assert main(words(verb, "nan.mcap", good)) == 0
    shown = capsys.readouterr().out
    assert "nan" not in shown.replace("nan.mcap", "").lower()
