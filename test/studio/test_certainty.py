"""What the studio says of a parameter's certainty is what the report's page says."""

import json
from dataclasses import replace

from damper_estimator.model import parse_model
from damper_estimator.studio.parameters import parameter_list


def said(model):
    """By parameter, the text behind its bounds."""
    (section,) = json.loads(json.dumps(parameter_list(model), default=lambda one: one.to_plotly_json()))
    rows = section["props"]["children"][1:]
    found = {}
    for row in rows:
        label, bounds = row["props"]["children"][:2]
        found[label["props"]["children"][0]] = bounds["props"]["children"].partition("  ")[2]
    return found


def test_a_value_has_its_error_is_undetermined_or_at_its_bound():
    dahl = {"force": 40.0, "stiffness": 2e5, "exponent": 0.2}
    model = parse_model({"name": "m", "source": "s", "effects": [{"dahl": dahl}]}, "test")
    assert said(model) == {"force": "", "stiffness": "", "exponent": "at its bound"}
    fitted = replace(model, fit={"standard_errors": {"dahl.force": 3.0}})
    assert said(fitted) == {"force": "± 3", "stiffness": "undetermined", "exponent": "at its bound"}
    fixed = replace(fitted, fixed=("dahl.stiffness",))
    assert said(fixed)["stiffness"] == ""
