"""Two published sets of bench data are imported completely, with the shipped column maps."""

import json

import numpy as np
import pytest

from damper_estimator.cli.main import main
from damper_estimator.recordings import open_bag
from damper_estimator.workflows import read

CURRENTS = ("0", "0.25", "0.5", "0.75", "1")
# Amplitude (mm, as measured), frequency (Hz) and rate (Hz) by file, from the data's provenance.
PRESS = {
    "ME2mm5Hz": (1.6, 5.0, 200.0),
    "ME5mm3Hz": (4.6, 3.0, 1000.0),
    "ME10mm2Hz": (9.7, 2.0, 1000.0),
    "ME25mm0x25Hz": (24.7, 0.25, 200.0),
    "ME25mm0x5Hz": (24.7, 0.5, 200.0),
}
VOLTS = {".1": 0.0, ".2.2": 0.87, "B": 1.98}
SAME_SIGN = 0.7  # least share of samples in motion whose force and velocity have the same sign


@pytest.fixture(scope="module")
def press(tmp_path_factory, shared_data):
    return imported(
        tmp_path_factory.mktemp("press"), sorted((shared_data / "utfsm_mr_damper").glob("*.gz")), "utfsm_mr_damper"
    )


@pytest.fixture(scope="module")
def table(tmp_path_factory, shared_data):
    files = sorted((shared_data / "labcontrol_mr_damper").glob("*.mat"))
    return imported(tmp_path_factory.mktemp("table"), files, "labcontrol_mr_damper")


def imported(folder, files, columns):
    report = folder / "report.json"
    assert main(["import", *map(str, files), "--columns", columns, "-o", str(folder), "--json", str(report)]) == 0
    return folder, json.loads(report.read_text())["parts"]


def channels(path):
    with open_bag(path) as bag:
        read = bag.read({
            "suspension/displacement": ["position[mr_damper]"],
            "suspension/force": ["effort[mr_damper]"],
            "suspension/mr_damper/current": ["data"],
        })  # fmt: skip
    position, force, command = read.values()
    assert position.present.all() and (position.stamp == force.stamp).all()
    seconds = (position.stamp - position.stamp[0]) * 1e-9
    return seconds, position.values[:, 0], force.values[:, 0], command.values[:, 0]


def share_of_same_sign(seconds, position, force):
    velocity = np.gradient(position, seconds)
    force = force - (force.max() + force.min()) / 2
    moving = np.abs(velocity) > 0.3 * np.abs(velocity).max()
    return (velocity[moving] * force[moving] > 0).mean()


@pytest.mark.parametrize("rig", ["press", "table"])
def test_no_sample_of_a_rig_is_taken_for_a_spike(rig, request):
    folder, _ = request.getfixturevalue(rig)
    for path in sorted(folder.glob("*.mcap")):
        measurements = read(path).measurements["mr_damper"]
        assert all(not measurement.spikes for measurement in measurements), path.name


def test_every_file_of_the_press_contains_five_currents(press):
    folder, _ = press
    assert {path.stem for path in folder.glob("*.mcap")} == {
        f"{stem}_{current}A" for stem in PRESS for current in CURRENTS
    }


@pytest.mark.parametrize("stem", PRESS)
@pytest.mark.parametrize("current", CURRENTS)
def test_a_block_of_the_press_has_its_amplitude_frequency_rate_and_sign(press, stem, current):
    amplitude, frequency, rate = PRESS[stem]
    seconds, position, force, command = channels(press[0] / f"{stem}_{current}A.mcap")
    assert (command == float(current)).all()
    assert 1 / np.diff(seconds).mean() == pytest.approx(rate, rel=1e-6)
    assert np.ptp(position) / 2 == pytest.approx(amplitude * 1e-3, rel=0.03)
    assert abs(position.max() + position.min()) < 0.1e-3  # m; centred at rest
    crossings = np.flatnonzero(np.diff(np.sign(position[np.abs(position) > 0.2e-3])))
    cycles = len(crossings) / 2
    assert cycles / frequency == pytest.approx(seconds[-1] - 0.4, abs=1.5 / frequency)  # s; 0.2 s of rest at both ends
    assert share_of_same_sign(seconds, position, force) > SAME_SIGN
    assert 150 < np.abs(force).max() < 1700


def test_the_force_of_the_press_grows_with_the_current(press):
    for stem in PRESS:
        peaks = [np.ptp(channels(press[0] / f"{stem}_{current}A.mcap")[2]) for current in CURRENTS]
        assert (np.diff(peaks) > 0).all()


def test_every_recording_of_the_shaking_table_is_imported_with_voltage_and_sign(table):
    folder, parts = table
    assert len(parts) == len(list(folder.glob("*.mcap"))) == 28
    for part in parts:
        stem = part["file"].rsplit("/", 1)[1].removesuffix(".mcap")
        seconds, position, force, command = channels(part["file"])
        volts = VOLTS["B" if ".B." in stem else ".2.2" if stem.endswith(".2.2") else ".1"]
        assert (command == volts).all()
        assert part["dampers"]["mr_damper"]["command"] == {"min": volts, "max": volts, "unit": "V"}
        assert part["rate_hz"] == pytest.approx(100.0, rel=1e-9)
        assert 2e-3 < np.ptp(position) < 45e-3
        assert share_of_same_sign(seconds, position, force) > SAME_SIGN


def test_the_rest_at_the_start_of_the_shaking_table_is_trimmed(table):
    for part in table[1]:
        seconds, position, _, _ = channels(part["file"])
        first = np.flatnonzero(np.abs(position - position[0]) > 0.02 * np.ptp(position))[0]
        assert seconds[first] <= 0.45
