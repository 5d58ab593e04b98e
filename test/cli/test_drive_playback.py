"""synth --play: a plan's drive on the simulated damper; files that are no drive are refused in one line."""

import numpy as np
import pytest

from damper_estimator.cli.main import main
from damper_estimator.recordings import open_bag


def drive(path, amplitude=0.01, header="time_s,displacement_m"):
    time = np.arange(6000) / 1000.0
    x = amplitude * np.sin(2.0 * np.pi * time) * np.sin(np.pi * time / time[-1]) ** 2
    np.savetxt(path, np.column_stack([time, x]), delimiter=",", header=header, comments="", fmt="%.9f")
    return path


def test_the_damper_follows_the_drive(tmp_path):
    out = tmp_path / "case"
    words = ["synth", "-o", str(out), "--seconds", "6", "--play", str(drive(tmp_path / "drive.csv"))]
    assert main(words) == 0
    with open_bag(out / "played.mcap") as bag:
        travel = bag.columns("/suspension/displacement", ("position[passenger_front]",)).values[:, 0]
    assert np.abs(travel).max() == pytest.approx(0.0098, rel=0.05)


@pytest.mark.parametrize(
    ("made", "message"),
    [
        (lambda path: drive(path, amplitude=1.0), "exceeds the stroke"),
        (lambda path: drive(path, header="a,b"), "needs columns time_s (rising)"),
        (lambda path: path.write_text("time_s,displacement_m\nx,y\n"), "is not a table of numbers"),
        (lambda path: None, "cannot be read"),
    ],
)
def test_a_file_that_is_no_drive_is_refused(tmp_path, capsys, made, message):
    made(tmp_path / "drive.csv")
    words = ["synth", "-o", str(tmp_path / "case"), "--seconds", "6", "--play", str(tmp_path / "drive.csv")]
    assert main(words) == 1
    assert message in capsys.readouterr().err
    assert not list((tmp_path / "case").rglob("*.mcap"))
