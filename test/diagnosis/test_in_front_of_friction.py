"""A compliance in front of a yield force that has no memory in the model."""

import numpy as np
import pytest

import damper_estimator as de
from damper_estimator.diagnosis.baseline import baseline_of
from damper_estimator.diagnosis.diagnosis_data import data_of
from damper_estimator.diagnosis.hypotheses import hypotheses_for
from damper_estimator.model import load_model


@pytest.fixture(scope="module")
def on_mount(base):
    """Both halves of a motion, with the forces of a yield behind a mount; noise of 0.5 %."""
    k = base.kinematics
    force = load_model("mr_damper_on_mount").force(k.block)
    force = force + 5e-3 * force.std() * np.random.default_rng(1).standard_normal(force.size)
    half = k.time.size // 2
    return [
        de.Recording.from_arrays(k.time[part] - k.time[part][0], k.displacement[part], force=force[part])
        for part in (slice(0, half), slice(half, None))
    ]


def test_what_is_missing_is_found_although_no_rate_of_the_force_shows_it(on_mount):
    fit, unseen = on_mount
    rigid = de.fit(fit, load_model("mr_damper_on_mount").without("rubber_mount")).model
    found = de.diagnose(fit, rigid, validate=unseen).diagnosis
    first = found.findings[0]
    assert "mount_compliance" in {first.phenomenon, *first.tied_with}, found.sentence
    assert first.phenomenon in ("mount_compliance", "oil_compressibility")
    assert first.rmse_after_n < 0.5 * first.rmse_before_n


def test_the_memory_of_the_way_speaks_for_compliances_and_for_what_names_it_only(on_mount):
    parts = [one.measurements["damper"] for one in on_mount]
    model = load_model("mr_damper_on_mount").without("rubber_mount")
    data = data_of(model, *parts)

    def supported(memory: float) -> set:
        baseline = baseline_of(model, data)
        silent = dict.fromkeys((one.test.name for one in baseline.tests), 0.0)
        vars(baseline)["hints"] = silent | {"curve": 0.9, "memory": memory}
        return {one.effect for one in hypotheses_for(model, data.ranges)[0] if baseline.suggests(one)}

    by_memory = supported(0.9) - supported(0.0)
    assert {"rubber_mount", "oil_spring", "bouc_wen"} <= {effect.name for effect in by_memory}
    assert all(effect.kind == "series" or "memory" in effect.tests for effect in by_memory)
