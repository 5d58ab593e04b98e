"""The inverse in C against ``control.InverseModel``: the same answers, bit for bit."""

from dataclasses import replace

import numpy as np
import pytest
from c_runner import python_line, rough

from damper_estimator.codegen import Choices, damper_of
from damper_estimator.codegen.build import find_compiler
from damper_estimator.codegen.compiled_damper import CompiledDamper
from damper_estimator.control import InverseModel
from damper_estimator.model import load_model
from damper_estimator.signals.admission import DUPLICATE

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler is installed")
LIMITS = (0.0, 2.0)
NAMES = ("force_min", "force_max", "dforce_dvelocity", "dforce_dcurrent")


def exported(name: str):
    return damper_of(load_model(name), Choices(name="d", limits=LIMITS))[0]


@pytest.mark.parametrize("name", ["semi_active_yield", "semi_active_on_mount", "lozoya_santos_complete"])
@pytest.mark.parametrize("with_reach", [False, True])
def test_currents_and_forces_are_those_of_python(name, with_reach, tmp_path):
    model, given = load_model(name), rough(11, 1500)
    damper = exported(name)
    given["reach"] = with_reach
    given["command_arrived"][:300] = 0  # the inverse then continues with its own answers
    wanted = np.where(np.arange(given.size) % 50 < 45, 900.0 * np.sin(np.arange(given.size) * 0.05), np.nan)
    outputs, verdict, answers = CompiledDamper(damper, tmp_path).invert(given, wanted)
    answered = python_line(damper, given)
    inverse = InverseModel(model, LIMITS)
    for i in np.flatnonzero(verdict < DUPLICATE):
        sample = answered.blocks[0, :, i]
        if with_reach:
            found = inverse.solve(sample, slope=True)
            assert np.array_equal([outputs[i][n] for n in NAMES], [getattr(found, n) for n in NAMES], equal_nan=True)
            found = inverse.again(wanted[i])
        else:
            found = inverse.solve(sample, wanted[i])
        answer = answers[i]
        pairs = [
            (answer[n], getattr(found, n)) for n in ("current", "expected", "force_min", "force_max", "dforce_dcurrent")
        ]
        assert np.array_equal(*np.transpose(pairs), equal_nan=True), i
        assert (answer["reached"] != 0) == found.reached


def test_the_inverse_follows_samples_without_requests(tmp_path):
    damper, given = exported("semi_active_on_mount"), rough(12, 800, trouble=0.0)
    library = CompiledDamper(damper, tmp_path)
    given["reach"] = 1
    asked, verdict = library.run(given)
    given["reach"][:-1] = 0
    once, _ = library.run(given)
    assert verdict[-1] < DUPLICATE
    assert all(once[n][-1] == asked[n][-1] for n in NAMES)
    assert np.isnan(once["force_min"][:-1]).all()


def test_a_damper_without_a_command_has_no_inverse(tmp_path):
    damper, reason = damper_of(load_model("carrera_akutain"), Choices(name="d"))
    assert damper.limits is None and "command" in reason
    made = CompiledDamper(damper, tmp_path).made
    assert "inverse" not in made.header
    outputs, verdict = CompiledDamper(replace(damper, name="e"), tmp_path).run(rough(1, 50))
    assert np.isnan(outputs["force_min"][verdict < DUPLICATE]).all()
