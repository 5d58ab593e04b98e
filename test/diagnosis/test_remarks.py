"""What is said of a finding whose parameters stopped at a limit."""

import pytest

from damper_estimator.diagnosis.explanation import at_a_limit
from damper_estimator.effects.discovery import find_effect
from damper_estimator.identification import FittedParameter


def fitted(name: str, value: float, unit: str, stopped: bool) -> FittedParameter:
    return FittedParameter(name, value, float("nan") if stopped else 0.1 * value, unit, stopped)


@pytest.mark.parametrize(
    "effect, rows, remark",
    [
        (
            "oil_spring",
            [("stiffness_rebound", 1e9, "N/m", True), ("stiffness_compression", 3e5, "N/m", False)],
            "stiff",
        ),
        ("oil_spring", [("stiffness_rebound", 6e4, "N/m", True), ("stiffness_compression", 3e5, "N/m", False)], "form"),
        ("rubber_mount", [("stiffness", 1e6, "N/m", False), ("loss", 2e4, "N s/m", True)], "form"),
        ("joint_play", [("stiffness", 1e9, "N/m", True), ("play", 5e-3, "m", True)], "both"),
        ("dahl", [("force", 100.0, "N", False), ("stiffness", 1e8, "N/m", True)], "form"),
        ("dahl", [("force", 100.0, "N", False), ("stiffness", 1e6, "N/m", False)], ""),
    ],
)
def test_only_a_rigid_series_spring_is_no_sign_of_a_wrong_form(effect, rows, remark):
    values = [fitted(f"{effect}.{name}", value, unit, stopped) for name, value, unit, stopped in rows]
    said = at_a_limit(find_effect(effect), values)
    assert ("nothing is seen to deflect" in said) == (remark in ("stiff", "both"))
    assert ("form is not quite" in said) == (remark in ("form", "both"))
    assert bool(said) == bool(remark)
