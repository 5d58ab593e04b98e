"""Recordings at one current or temperature, of a model that was identified at another one."""

import numpy as np
import pytest

import damper_estimator as de
from damper_estimator.cli.main import main
from damper_estimator.diagnosis import diagnose
from damper_estimator.identification import fit
from damper_estimator.model import load_model
from damper_estimator.recordings import open_bag
from damper_estimator.signals import Measurement, load_signal_map, measure

PRESS = ("ME25mm0x25Hz", "ME10mm2Hz", "ME25mm0x5Hz", "ME5mm3Hz")


@pytest.fixture(scope="module")
def press(shared_data, tmp_path_factory) -> dict[str, list[Measurement]]:
    """Recordings of a real magneto-rheological damper by its current in A, which is constant in each."""
    folder = tmp_path_factory.mktemp("press")
    files = [str(shared_data / "utfsm_mr_damper" / f"{name}.txt.gz") for name in PRESS]
    assert main(["import", *files, "--columns", "utfsm_mr_damper", "-o", str(folder)]) == 0
    found: dict[str, list[Measurement]] = {}
    for path in sorted(folder.glob("*.mcap")):
        with open_bag(path) as bag:
            one = measure(bag, load_signal_map(None), "mr_damper")
        found.setdefault(f"{np.nanmedian(one.kinematics.command):.2f}", []).append(one)
    return found


@pytest.mark.parametrize(("before", "now"), [("0.00", "0.50"), ("0.25", "1.00"), ("1.00", "0.25")])
def test_the_current_is_missing_where_it_is_not_that_of_the_identification(press, before, now):
    base = press[before]
    model = fit(load_model("bouc_wen"), base[:2], starts=1).model
    found = diagnose(model, press[now][:2], press[now][2:])
    first = found.findings[0]
    assert found.verdict == "missing" and first.phenomenon == "current", found.sentence
    assert f"{float(now):.3g} A here" in first.evidence and f"{float(before):.3g} A when" in first.evidence
    assert first.rmse_after_n < 0.35 * first.rmse_before_n
    (_, step), *_ = found.steps
    changed = step.model.force(base[2].kinematics.block) - model.force(base[2].kinematics.block)
    assert np.nanmax(np.abs(changed)) < 1e-6 * np.nanstd(base[2].force), "it holds where it was identified"


def test_the_temperature_may_be_what_changed_between_two_recordings(base):
    k, rng = base.kinematics, np.random.default_rng(4)
    half = k.time.size // 2

    def recorded(part: slice, degrees: float, thinner: float) -> de.Recording:
        """The shipped damper, with less force where the oil flows slowly."""
        v = k.velocity[part]
        force = base.force[part] * (1.0 - thinner / (1.0 + np.abs(v) / 0.3))
        warm = degrees + 0.1 * rng.standard_normal(v.size)
        time = k.time[part] - k.time[part][0]
        return de.Recording.from_arrays(time, k.displacement[part], force=force, temperature=warm)

    first, second = slice(0, half), slice(half, None)
    model = de.fit(recorded(first, 24.0, 0.0), "viscous_curve").model
    found = de.diagnose(recorded(first, 58.0, 0.4), model, validate=recorded(second, 58.0, 0.4)).diagnosis
    same = de.diagnose(recorded(first, 24.0, 0.4), model, validate=recorded(second, 24.0, 0.4)).diagnosis
    assert "temperature_fade" in (found.findings[0].phenomenon, *found.findings[0].tied_with), found.sentence
    assert all("temperature_fade" not in (one.phenomenon, *one.tied_with) for one in same.findings)
    assert "changed by only" in same.untestable["temperature_gain"]
