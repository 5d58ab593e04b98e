"""Real magneto-rheological dampers have the expected diagrams."""

import pytest

from damper_estimator.characterization import characterize
from damper_estimator.cli.main import main
from damper_estimator.recordings import open_bag
from damper_estimator.signals import load_signal_map, measure


@pytest.fixture(scope="module")
def measured(shared_data, tmp_path_factory):
    """Measurements of the files of a data set that match a pattern."""

    def read(data, pattern):
        folder = tmp_path_factory.mktemp(data)
        files = sorted(str(path) for path in (shared_data / data).glob(pattern))
        assert main(["import", *files, "--columns", data, "-o", str(folder)]) == 0
        found = []
        for path in sorted(folder.glob("*.mcap")):
            with open_bag(path) as bag:
                found.append(measure(bag, load_signal_map(None), "mr_damper"))
        return found

    return read


def test_utfsm_grows_with_current_and_hysteresis_widens_with_frequency(measured):
    found = characterize(measured("utfsm_mr_damper", "*.gz"))
    assert len(found.diagrams) == 25
    assert all(d.loop.steady for d in found.diagrams)
    added = [d for d in found.differences if abs(d.loop.frequency - 2.03) < 0.05]
    forces = [d.points["E"].force for d in sorted(added, key=lambda d: d.loop.command)]
    assert forces == sorted(forces) and forces[-1] > 1200.0
    at_1_ampere = sorted(
        (d for d in found.differences if d.loop.command == 1.0 and d.loop.frequency > 0.4),
        key=lambda d: d.loop.frequency,
    )
    lags = [d.pattern.hysteresis_low for d in at_1_ampere]
    assert lags == sorted(lags)
    assert [band.semi_active for band in found.bands] == [5, 5, None]
    assert found.structure.semi_active == "complete"


def test_labcontrol_yields_early_at_every_voltage(measured):
    found = characterize(measured("labcontrol_mr_damper", "*.mat"))
    assert {round(d.loop.command, 2) for d in found.diagrams} == {0.0, 0.87, 1.98}
    assert {d.pattern.type for d in found.diagrams} <= {3, 5}
    assert all(d.pattern.rebound.knee_velocity < 0.02 and d.pattern.rebound.ratio > 4.0 for d in found.diagrams)
    assert found.bands[0].semi_active == 5
    assert found.bands[1].passive is None
