"""A phenomenon that nobody knew of is one new file, and is then found on data."""

import pytest
from faults import changed, halves

from damper_estimator import effects
from damper_estimator.diagnosis import diagnose
from damper_estimator.effects.discovery import all_effects

FILE = '''"""Magnet at mid-stroke that holds the rod.

    F = h exp(-(x / w)^2) x / w

h in N, w in m. No state. Source: test.
"""

from math import exp

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter
from damper_estimator.signals.layout import X


@compiled
def kernel(parameters, settings, kinematics, state, force):
    for i in range(force.size):
        u = kinematics[X, i] / parameters[1]
        force[i] += parameters[0] * exp(-u * u) * u


EFFECT = Effect(
    kernel=kernel,
    kind="source",
    phenomenon="latch",
    parameters=(
        Parameter("hold", "N", 50.0, 0.0, 5000.0, "holding force", linear=True),
        Parameter("width", "m", 0.004, 1e-4, 0.1, "width of the field"),
    ),
    shows="the force has a wiggle about mid-stroke, at any speed",
    separate="a slow stroke through the middle",
)
'''


@pytest.fixture
def latch(tmp_path, monkeypatch):
    (tmp_path / "magnet_latch.py").write_text(FILE, encoding="utf-8")
    monkeypatch.setattr(effects, "__path__", [*effects.__path__, str(tmp_path)])
    all_effects.cache_clear()
    yield
    monkeypatch.undo()
    all_effects.cache_clear()


def test_one_new_file_is_found_on_data(latch, user_model, base):
    # Not its own equation: a field that falls off as a dipole's.
    def held(kinematics):
        u = kinematics.displacement / 0.005
        return 140.0 * u / (1.0 + u * u) ** 2

    fit, unseen = halves(changed(base, held))
    found = diagnose(user_model, [fit], [unseen])
    assert found.verdict == "missing"
    assert found.findings[0].phenomenon == "latch" and found.findings[0].effect == "magnet_latch"
    assert "slow stroke" in found.findings[0].test_to_separate
