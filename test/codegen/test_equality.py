"""The C against the Python line: forces, motion, status and verdicts bit for bit, for any input."""

import ctypes
import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from c_runner import python_line, random_model, recorded, rough

from damper_estimator.cli.main import main
from damper_estimator.codegen import Choices, damper_of, one_sample
from damper_estimator.codegen.build import FLAGS, find_compiler
from damper_estimator.codegen.c_source import Damper
from damper_estimator.codegen.compiled_damper import CompiledDamper, inputs
from damper_estimator.effects.discovery import find_effect
from damper_estimator.model import library_models, load_model
from damper_estimator.model.element import new_element
from damper_estimator.recordings import open_bag
from damper_estimator.runtime import deployed
from damper_estimator.runtime.damper_record import GOOD, STALE
from damper_estimator.runtime.estimates import FIELDS
from damper_estimator.signals.admission import DUPLICATE
from damper_estimator.signals.fusion import Fusion

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler is installed")
REGION = {"displacement": [-0.05, 0.05], "velocity": [-2.0, 2.0], "command": [0.0, 1.2], "temperature": [10.0, 80.0]}
BAGS = Path(__file__).parents[2] / "bags"
CHAINS = int(os.environ.get("DAMPER_C_CHAINS", "25"))


def fitted(model):
    return replace(model, fit={"residual_stddev": 12.0, "region": REGION})


def assert_equal(damper: Damper, given: np.ndarray, folder: Path) -> np.ndarray:
    """All numbers of the C equal those of Python; returns the C's outputs for the used samples."""
    outputs, verdict = CompiledDamper(damper, folder, None, (*FLAGS, "-O0")).run(given)  # quick to compile
    answered = python_line(damper, given)
    assert np.array_equal(verdict, answered.verdict[:, 0])
    good = verdict < DUPLICATE
    for i, name in enumerate(FIELDS[:5]):
        assert np.array_equal(outputs[name][good], answered.numbers[good, i, 0], equal_nan=True), name
    assert np.array_equal(outputs["status"][good], answered.status[good, 0])
    assert np.array_equal(outputs["trusted"][good], answered.trusted[good, 0])
    return outputs[good]


@pytest.mark.parametrize("name", library_models())
def test_every_library_model_on_all_kinds_of_faults(name, tmp_path):
    model = fitted(load_model(name))
    damper = Damper("d", deployed(model, 0.0 if name.endswith("unfiltered") else 60.0, 0.1))
    found = assert_equal(damper, rough(len(name), 2500), tmp_path)
    assert np.isfinite(found["force"]).all()


def test_a_mount_in_front_of_the_oil_is_solved_alike(tmp_path):
    model = load_model("mr_damper_on_mount")
    model = model.with_missing(new_element(find_effect("oil_spring"), model.effects))
    assert len(model.springs) == 2
    found = assert_equal(Damper("d", deployed(fitted(model), 60.0, 0.1)), rough(5, 2500), tmp_path)
    assert np.isfinite(found["force"]).all()


def test_all_statuses_occur_in_the_comparison(tmp_path):
    damper = Damper("d", deployed(fitted(load_model("semi_active_on_mount")), 60.0, 0.1))
    found = assert_equal(damper, rough(3, 20_000, trouble=0.02), tmp_path)
    assert set(np.unique(found["status"])) == {0, 1, 2, 3}


@pytest.mark.parametrize("seed", range(CHAINS))
def test_random_chains(seed, tmp_path):
    model = fitted(random_model(seed))
    assert_equal(Damper("d", deployed(model, 45.0, 0.1)), rough(seed, 1200), tmp_path)


def test_an_old_estimate_is_stale(tmp_path):
    exported = Damper("d", deployed(fitted(load_model("carrera_akutain")), 60.0, 0.1), stale_after=0.05)
    library = ctypes.CDLL(str(CompiledDamper(exported, tmp_path).library))
    state, output = ctypes.create_string_buffer(8192), np.zeros(1, one_sample.OUTPUT)
    library.d_init(state)

    def status(at: int) -> int:
        return library.d_status_at(state, ctypes.c_int64(at)) & 0xFF

    assert status(0) == STALE  # before the first sample
    pointer = output.ctypes.data_as(ctypes.c_void_p)
    for stamp in range(0, 10**9, 10**6):
        given = inputs(np.array([stamp]), np.zeros(1), command=np.ones(1), temperature=np.full(1, 40.0))
        library.d_step(state, given.ctypes.data_as(ctypes.c_void_p), pointer)
    assert status(stamp) == status(stamp + 50_000_000) == output["status"][0] == GOOD
    assert status(stamp + 50_000_001) == STALE
    library.d_reset(state)
    assert status(stamp) == STALE


def test_fusion_with_an_accelerometer_and_a_lead(tmp_path):
    model = fitted(load_model("carrera_akutain"))
    assert_equal(Damper("d", deployed(model, 60.0, 0.1, fusion=Fusion())), rough(5, 3000), tmp_path / "fusion")
    assert_equal(Damper("d", deployed(model, 60.0, 0.1, lead=0.004)), rough(6, 3000), tmp_path / "lead")


@pytest.mark.parametrize(
    ("bag", "damper", "model"),
    [("passenger_road", "passenger_front", "carrera_akutain"),
     ("semi_active_road", "semi_active", "semi_active_on_mount"),
     ("four_corners_road", "rear_left", "renault_modified_bouc_wen")],
)  # fmt: skip
def test_replay_of_the_shipped_recordings(bag, damper, model, tmp_path):
    path = BAGS / f"{bag}.mcap"
    exported, _ = damper_of(load_model(model), Choices(name="d", cutoff=60.0))
    outputs, verdict = CompiledDamper(exported, tmp_path).run(recorded(path, damper))
    words = [
        "replay",
        str(path),
        "-m",
        model,
        "-d",
        damper,
        "-o",
        str(tmp_path / "out.mcap"),
        "--json",
        str(tmp_path / "n"),
    ]
    assert main(words) == 0
    with open_bag(tmp_path / "out.mcap") as written:
        force = written.columns("/damper_estimator/force", ("force[0]", "velocity[0]", "status[0]")).values
    good = verdict < DUPLICATE
    assert np.array_equal(force[:, 0], outputs["force"][good])
    assert np.array_equal(force[:, 1], outputs["velocity"][good])
    assert np.array_equal(force[:, 2], outputs["status"][good])
