"""A fit over recordings on two workers equals the fit in one process."""

import os
import signal
from importlib import import_module

import numpy as np
import pytest
from fleet_bags import write_drive

from damper_estimator.errors import InputError
from damper_estimator.fleet import distributed_recordings, worker_recordings
from damper_estimator.fleet.distributed_fit import fit_distributed
from damper_estimator.fleet.distributed_recordings import DistributedRecordings
from damper_estimator.fleet.remote_rows import RemoteRows
from damper_estimator.fleet.worker_recordings import Source
from damper_estimator.identification import MethodOptions, fit
from damper_estimator.identification.row_sources import Place
from damper_estimator.identification.samples import channels_of
from damper_estimator.identification.unknowns import Unknowns
from damper_estimator.model import load_model, parse_model
from damper_estimator.recordings import open_bag
from damper_estimator.signals import load_signal_map, measure
from damper_estimator.signals.layout import V, X

CURVE = {
    "name": "curve_and_friction",
    "source": "made for a test",
    "effects": [{"viscous_curve": {}}, {"tanh_hysteresis": {}}],
}


@pytest.fixture
def bags(tmp_path):
    """Three recordings of unequal length and temperature."""
    return [
        write_drive(tmp_path / f"{k}.mcap", k, gain=1500.0 + 40.0 * k, seconds=seconds)
        for k, seconds in enumerate((6.0, 9.0, 7.0))
    ]


def source(path, damper="front_left"):
    return Source(str(path), damper, "", 0.0, float("inf"), "")


def read_here(path):
    with open_bag(path) as bag:
        return measure(bag, load_signal_map(None), "front_left")


def alike(spread, alone):
    """Whether two fits agree to 1e-9."""
    close = pytest.approx
    for name in ("rmse_n", "esr", "rmse_before_n", "esr_before"):
        assert getattr(spread, name) == close(getattr(alone, name), rel=1e-9), name
    assert [p.name for p in spread.parameters] == [p.name for p in alone.parameters]
    for parameter, other in zip(spread.parameters, alone.parameters, strict=True):
        assert parameter.value == close(other.value, rel=1e-9, abs=1e-12), parameter.name
        assert parameter.standard_error == close(other.standard_error, rel=1e-6, nan_ok=True), parameter.name
        assert parameter.at_bound == other.at_bound
    assert (spread.samples, spread.undetermined) == (alone.samples, alone.undetermined)
    assert spread.warnings == alone.warnings
    assert spread.model.fit["region"] == alone.model.fit["region"]
    assert spread.model.fit["bags"] == alone.model.fit["bags"]
    assert spread.model.fit["force_stddev"] == close(alone.model.fit["force_stddev"], rel=1e-5)


# Knots far beyond the recordings depend on the others.
WIDE = {**CURVE, "effects": [{"viscous_curve": {"velocity": [-9.0, -0.1, 0.0, 0.1, 9.0], "force": [5.0] * 5}}]}


@pytest.mark.parametrize("model", ["curve", "wide", "carrera_akutain"])
def test_two_workers_fit_what_one_process_fits(client, bags, model):
    start = {"curve": parse_model(CURVE, "here"), "wide": parse_model(WIDE, "here")}.get(model) or load_model(model)
    spread, refused = fit_distributed(
        client, start, [source(path) for path in bags[::-1]], starts=2, method_options=MethodOptions(seed=3)
    )
    assert not refused
    alike(spread, fit(start, [read_here(path) for path in bags], seed=3, starts=2))


def test_a_worker_that_is_killed_in_the_middle_changes_nothing(client, bags, monkeypatch):
    query_workers, queries = DistributedRecordings._query, []

    def killing(recordings, query, *arguments):
        queries.append(query)
        if len(queries) == 6:
            os.kill(min(client.run(os.getpid).values()), signal.SIGKILL)
        return query_workers(recordings, query, *arguments)

    monkeypatch.setattr(DistributedRecordings, "_query", killing)
    start = parse_model(CURVE, "here")
    spread, refused = fit_distributed(client, start, [source(path) for path in bags], starts=2)
    assert len(queries) > 6 and not refused
    alike(spread, fit(start, [read_here(path) for path in bags], starts=2))


def test_workers_that_die_repeatedly_are_one_line(client, bags, monkeypatch):
    monkeypatch.setattr(distributed_recordings, "CHECK_PERIOD", 1.0)
    recordings = DistributedRecordings(client, [source(path) for path in bags], parse_model(CURVE, "here"))
    for _ in range(2):
        with pytest.raises(InputError, match="--memory") as caught:
            recordings.ask(lambda recording: os.kill(os.getpid(), signal.SIGKILL))
        assert "\n" not in str(caught.value)
        # Neither this nor the blame that Dask assigns affects the next query.
        assert len(recordings.ask(worker_recordings.summary)) == len(bags)


def test_a_query_that_fails_is_not_repeated(client, bags):
    recordings = DistributedRecordings(client, [source(path) for path in bags], parse_model(CURVE, "here"))
    with pytest.raises(ZeroDivisionError):
        recordings.ask(lambda recording: 1 / 0)


def test_excerpts_are_the_same(client, bags, monkeypatch):
    # The package's ``fit`` is the function, which hides the module of that name.
    monkeypatch.setattr(import_module("damper_estimator.identification.fit"), "SKETCH_SAMPLES", 1500)
    start = parse_model(CURVE, "here")
    spread, _ = fit_distributed(client, start, [source(path) for path in bags], starts=2)
    alike(spread, fit(start, [read_here(path) for path in bags], starts=2))


def test_a_front_equals_that_of_one_process(client, bags):
    pytest.importorskip("pymoo")
    start, given = parse_model(CURVE, "here"), {"slow": ("0.mcap",), "fast": ("1.mcap", "2.mcap")}
    method_options = MethodOptions(seed=2, generations=4, population=8, groups=given)
    spread, _ = fit_distributed(
        client, start, [source(path) for path in bags], method="nsga2", method_options=method_options
    )
    alone = fit(start, [read_here(path) for path in bags], method="nsga2", seed=2, method_options=method_options)
    assert spread.front.groups == alone.front.groups == ("slow", "fast")
    assert spread.front.excitations == alone.front.excitations
    np.testing.assert_allclose(spread.front.objectives, alone.front.objectives, rtol=1e-9)
    np.testing.assert_allclose(spread.front.values, alone.front.values, rtol=1e-9, atol=1e-9)
    alike(spread, alone)


def test_percentiles_and_counts_are_exact(client, bags):
    recordings = DistributedRecordings(client, [source(path) for path in bags], load_model("linear_viscous"))
    together = channels_of([read_here(path) for path in bags])
    for row in (X, V):
        spread, alone = recordings.channel(row), together(row)
        assert (spread.size, spread.low, spread.high) == (alone.size, alone.low, alone.high)
        wanted = (0.0, 0.1, 0.5, 33.3, 50.0, 99.5, 99.9, 100.0)
        assert spread.percentiles(wanted) == alone.percentiles(wanted)
        values = np.concatenate([m.kinematics.block[row, m.judged] for m in map(read_here, bags)])
        assert alone.percentiles(wanted) == np.percentile(values, wanted).tolist()
        edges = np.linspace(alone.low, alone.high, 7)
        assert spread.below(edges).tolist() == alone.below(edges).tolist()


def test_the_data_sent_do_not_grow_with_the_recordings(client, tmp_path):
    sizes = []
    for seconds in (6.0, 24.0):
        path = write_drive(tmp_path / f"{seconds}.mcap", 1, seconds=seconds)
        recordings = DistributedRecordings(client, [source(path)], load_model("linear_viscous"))
        model = load_model("linear_viscous")
        sums = RemoteRows(recordings).sums(Unknowns(model, (0, 1)))
        sizes.append(sums.linearised(Place(np.zeros(0), np.ones(2), np.zeros(0))).nbytes)
    assert sizes[0] == sizes[1] == 9 * 8


def test_a_recording_that_cannot_be_used_is_left_out_and_reported(client, bags, tmp_path):
    (tmp_path / "foreign.mcap").write_bytes(b"PK" + bytes(300))
    start = load_model("linear_viscous")
    bad = [source(tmp_path / "foreign.mcap"), source(bags[0], "rear")]
    spread, refused = fit_distributed(client, start, [*map(source, bags), *bad])
    assert set(refused) == set(bad) and all("\n" not in reason for reason in refused.values())
    alike(spread, fit(start, [read_here(path) for path in bags]))
    with pytest.raises(InputError, match="no recording can be used"):
        fit_distributed(client, start, bad)
