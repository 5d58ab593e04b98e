"""Where a diagnosis stands is read from its file, and only where it speaks of the same round."""

import json

import pytest

from damper_estimator.workflows.planning import Tie, _tied_of


@pytest.fixture
def written(tmp_path):
    def write(findings, phenomena):
        rows = [{"phenomenon": name, "left": 0.2, "probability": share} for name, share in phenomena.items()]
        entries = [{"phenomenon": group[0], "tied_with": list(group[1:])} for group in findings]
        place = tmp_path / "diagnosis.json"
        place.write_text(json.dumps({"dampers": {"left": {"findings": entries, "phenomena": rows}}}))
        return _tied_of(place)["left"]

    return write


def test_the_probabilities_of_the_first_finding_go_with_its_tie(written):
    shares = {"gas_spring": 0.6, "spring_rate_error": 0.3, "friction": 0.1}
    found = written([("gas_spring", "spring_rate_error")], shares)
    assert found == Tie(("gas_spring", "spring_rate_error"), shares)


def test_those_of_a_later_finding_are_unknown(written):
    found = written([("friction",), ("gas_spring", "spring_rate_error")], {"gas_spring": 0.6, "spring_rate_error": 0.3})
    assert found == Tie(("gas_spring", "spring_rate_error"))


def test_a_file_without_probabilities_still_names_the_tie(written):
    assert written([("gas_spring", "spring_rate_error")], {}) == Tie(("gas_spring", "spring_rate_error"))


def test_a_diagnosis_without_a_tie_has_none(written):
    assert written([("gas_spring",)], {"gas_spring": 0.9}) is None
