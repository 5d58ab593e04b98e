"""docs/json.md lists existing keys."""

import json
import re

import pytest
from drives import write_drive
from pages import ROOT

import damper_estimator as de

TEXT = (ROOT / "docs" / "json.md").read_text(encoding="utf-8")


def named(section):
    """The keys in the first column of a section's tables."""
    part = TEXT.partition(f"## {section}\n")[2].partition("\n## ")[0]
    cells = [line.split("|")[1] for line in part.splitlines() if line.startswith("| `")]
    return {key for cell in cells for key in re.findall(r"`(\w+)`", cell)}


def keys(value):
    """All keys of a record, at any depth."""
    if isinstance(value, dict):
        return set(value) | {key for entry in value.values() for key in keys(entry)}
    return {key for entry in value for key in keys(entry)} if isinstance(value, (list, tuple)) else set()


@pytest.fixture(scope="module")
def records(tmp_path_factory):
    """Results of the verbs for a damper with friction, by the sections of the page."""
    folder = tmp_path_factory.mktemp("json")
    drive, other = (de.read(write_drive(folder / f"{k}.mcap", seed=k, seconds=8.0)) for k in (0, 5))
    fitted = de.fit(drive, "linear_viscous")
    found = {
        "`fit`": fitted,
        "`compare`": de.compare(other, fitted.model),
        "`diagnose`": de.diagnose(drive, fitted.model, validate=other),
        "`improve`": de.improve(drive, fitted.model, validate=other),
    }
    diagnosis = folder / "diagnosis.json"
    tie = {"findings": [{"phenomenon": "friction", "tied_with": ["asymmetry"]}]}
    diagnosis.write_text(json.dumps({"dampers": dict.fromkeys(drive.dampers, tie)}))
    plans = (
        de.plan(drive, fitted.model, diagnosis=diagnosis, minutes=0.3),
        de.plan(drive, fitted.model, parameters=True),
    )
    records = {section: keys(result.to_dict()) for section, result in found.items()}
    return records | {"`plan`": set().union(*(keys(entry.to_dict()) for entry in plans))}


@pytest.mark.parametrize("section", ["`fit`", "`compare`", "`diagnose`", "`improve`", "`plan`"])
def test_every_key_of_a_section_is_there(records, section):
    assert named(section) and named(section) <= records[section]


@pytest.mark.parametrize("section", ["`fit`", "`compare`", "`diagnose`", "`improve`"])
def test_every_key_is_explained(records, section):
    named_by_users = {"front_left", "linear_viscous", "static_force"}  # dampers, and effects of a model
    assert records[section] - set(re.findall(r"`(\w+)`", TEXT)) - named_by_users == set()


def test_the_measures_are_there(records):
    assert len(named("Measures")) == 10 and named("Measures") <= records["`compare`"]
