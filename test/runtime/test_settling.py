"""How long a start is remembered: at least the filter's time, longer if the model remembers, never forever."""

from dataclasses import replace

import numpy as np
import pytest

from damper_estimator.effects.discovery import find_effect
from damper_estimator.model import DamperModel, load_model, make_element
from damper_estimator.runtime import GOOD, WARMING_UP, Line, deployed
from damper_estimator.runtime.memory import LONGEST_SETTLING
from damper_estimator.signals.kinematics import WARM_UP

MS = 1_000_000
FIT = {"residual_stddev": 10.0, "region": {"velocity": [-9.0, 9.0], "displacement": [-0.1, 0.1]}}


def lagging(time_constant):
    effects = (make_element(find_effect("linear_viscous")),
               make_element(find_effect("force_lag"), {"time_constant": time_constant}))  # fmt: skip
    return DamperModel("m", "", effects, fit=FIT)


def test_a_model_without_memory_settles_with_the_filter():
    assert deployed(load_model("linear_viscous"), 60.0, 0.1).settling == WARM_UP
    assert deployed(load_model("linear_viscous"), 2.0, 0.1).settling > 2.0 * WARM_UP


def test_a_slow_model_takes_longer_up_to_the_longest_settling_time():
    found = [deployed(lagging(t), 60.0, 0.1).settling for t in (0.001, 0.06, 0.1)]
    assert found == sorted(found) and found[0] == WARM_UP < found[2]
    # It remembers over travel, so it hardly forgets without motion.
    travels = load_model("bouc_wen")
    assert deployed(travels, 60.0, 0.1).settling > WARM_UP
    still = replace(travels, fit=FIT | {"region": {"velocity": [-1e-3, 1e-3], "displacement": [-1e-4, 1e-4]}})
    assert deployed(still, 60.0, 0.1).settling == pytest.approx(LONGEST_SETTLING, abs=0.01)


@pytest.mark.parametrize("model", [lagging(0.06), lagging(0.1)])
def test_after_the_settling_time_the_force_is_that_of_a_settled_line(model):
    damper = deployed(model, 60.0, 0.1)
    whole, late = Line(), Line()
    for line in (whole, late):
        line.add("one", damper)
    forces, states = [], []
    for i in range(4000):
        x = np.array([0.02 * np.sin(0.012 * i)])
        for line in (whole, late) if i >= 2000 else (whole,):
            line.step(i * MS, x, np.ones(1, bool))
        if i >= 2000:
            forces.append([line.output.modelled[0, 0] for line in (whole, late)])
            states.append(late.output.status[0, 0])
    settled = round(damper.settling * 1000)
    assert set(states[:settled]) == {WARMING_UP} and set(states[settled:]) == {GOOD}
    difference = np.abs(np.diff(forces, axis=1)[:, 0])
    assert difference[settled:].max() < 0.05 * np.max(np.abs(forces))
