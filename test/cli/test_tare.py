"""tare: rest becomes zero in the signal map."""

import json

import numpy as np
import pytest

from damper_estimator.cli.main import main
from damper_estimator.recordings import open_bag
from damper_estimator.signals import load_signal_map, measure


@pytest.fixture
def standing(driven, write_bag):
    """Two seconds of rest at 3 mm and 250 N, then motion."""
    _, stamp, x, force = driven("before.mcap", rest=2.0)
    return write_bag("standing.mcap", ["a"], stamp, x[:, :1] + 0.003, force[:, :1] + 250.0)


def test_displacement_and_force_are_zero_at_rest_afterwards(standing, tmp_path, capsys):
    path = tmp_path / "map.yaml"
    assert main(["tare", str(standing), "-o", str(path)]) == 0
    with open_bag(standing) as bag:
        m = measure(bag, load_signal_map(path), "a", end=1.8)
    assert np.median(m.kinematics.displacement) == pytest.approx(0.0, abs=1e-5)
    assert np.median(m.force[m.judged]) == pytest.approx(0.0, abs=1.0)
    assert "rest from 0.0 to 2." in capsys.readouterr().out


@pytest.mark.parametrize("place", [0.7, 5.0])
def test_a_glitch_neither_cuts_a_rest_nor_makes_motion_look_quiet(driven, write_bag, tmp_path, place):
    _, stamp, x, force = driven("before.mcap", rest=2.0)
    wild_x, wild_force = x[:, :1] + 0.003, force[:, :1] + 250.0
    at = np.searchsorted(stamp, stamp[0] + round(place * 1e9))
    wild_x[at], wild_force[at] = 8.0, 9e5
    rests = {}
    for name, values in (("clean", (x[:, :1] + 0.003, force[:, :1] + 250.0)), ("wild", (wild_x, wild_force))):
        bag, report = write_bag(f"{name}.mcap", ["a"], stamp, *values), tmp_path / f"{name}.json"
        assert main(["tare", str(bag), "-o", str(tmp_path / f"{name}.yaml"), "--json", str(report)]) == 0
        rests[name] = json.loads(report.read_text())["dampers"]["a"]["rest"]
    assert rests["wild"]["from"] == pytest.approx(rests["clean"]["from"], abs=0.11)
    assert rests["wild"]["to"] == pytest.approx(rests["clean"]["to"], abs=0.11)


def test_the_rest_of_a_given_map_is_kept(standing, tmp_path):
    (tmp_path / "given.yaml").write_text(
        "filter: {cutoff: 45.0, band: 25.0}\ndampers:\n  a:\n    displacement: {skew: 0.001}\n"
        "    force: {scale: 2.0, offset: 5.0, spring_rate: 20000.0, preload: -300.0}\n  b: {}\n"
        "use: [{from: 1.0, to: 7.0}]\n"
    )
    path = tmp_path / "map.yaml"
    assert main(["tare", str(standing), "-s", str(tmp_path / "given.yaml"), "-d", "a", "-o", str(path)]) == 0
    given, tared = load_signal_map(tmp_path / "given.yaml"), load_signal_map(path)
    assert (tared.cutoff, tared.band, tared.windows, list(tared.dampers)) == (45.0, 25.0, given.windows, ["a", "b"])
    force = tared.dampers["a"].force
    assert (force.scale, tared.dampers["a"].spring_rate, tared.dampers["a"].preload) == (2.0, 20000.0, -300.0)
    assert force.offset == pytest.approx(-300.0 - 2.0 * 250.0, abs=2.0)
    assert tared.dampers["a"].displacement.skew == 0.001
    with open_bag(standing) as bag:
        m = measure(bag, tared, "a", start=1.0, end=1.8)
    assert np.median(m.force[m.judged]) == pytest.approx(0.0, abs=2.0)


def test_a_table_is_shifted(standing, tmp_path):
    (tmp_path / "given.yaml").write_text(
        "dampers: {a: {displacement: {table: {raw: [-1.0, 1.0], value: [-0.5, 0.5]}}}}"
    )
    path = tmp_path / "map.yaml"
    assert main(["tare", str(standing), "-s", str(tmp_path / "given.yaml"), "-o", str(path)]) == 0
    assert load_signal_map(path).dampers["a"].displacement.value(np.array(0.003)) == pytest.approx(0.0, abs=1e-5)


def test_where_and_how_long_is_in_the_json(standing, tmp_path):
    assert main(["tare", str(standing), "-o", str(tmp_path / "map.yaml"), "--json", str(tmp_path / "r.json")]) == 0
    record = json.loads((tmp_path / "r.json").read_text())["dampers"]["a"]
    assert record["rest"]["from"] == 0.0 and record["rest"]["to"] == pytest.approx(2.0, abs=0.3)
    assert record["force_was_n"] == pytest.approx(250.0, abs=1.0) and record["displacement_was_m"] == pytest.approx(
        0.003, abs=1e-5
    )


def test_a_recording_without_rest_is_refused_and_no_map_is_left(driven, tmp_path, refused):
    line = refused("tare", driven()[0], "-o", tmp_path / "map.yaml")
    assert "never at rest" in line and "front_left" in line and not (tmp_path / "map.yaml").exists()


def test_a_displacement_in_millimetres_is_named_with_the_entry_that_corrects_it(standing, tmp_path, refused):
    (tmp_path / "given.yaml").write_text("dampers: {a: {displacement: {scale: 1000.0}}}")
    line = refused("tare", standing, "-s", tmp_path / "given.yaml", "-o", tmp_path / "map.yaml")
    assert "probably it is in mm" in line and "displacement: {" in line and not (tmp_path / "map.yaml").exists()


def test_an_unknown_damper_is_refused(standing, tmp_path, refused):
    assert "'rear'" in refused("tare", standing, "-d", "rear", "-o", tmp_path / "map.yaml")
