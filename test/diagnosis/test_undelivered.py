"""What is done where nothing that a search found delivers what it promised."""

from importlib import import_module
from types import SimpleNamespace

import pytest

outcome = import_module("damper_estimator.diagnosis.outcome")


def result(name: str, *, verdict: str = "unexplained", steps: bool = False, beyond_known: bool = False):
    """An outcome of ``_searched`` with one finding."""
    one = SimpleNamespace(
        element=SimpleNamespace(effect=SimpleNamespace(name=name)), hypothesis=SimpleNamespace(region=None), partner=""
    )
    found = SimpleNamespace(accepted=(one,), beyond_known=beyond_known)
    return outcome.Outcome(found, None, verdict, steps=((one, None, 2.0, 1.0),) if steps else ())


@pytest.fixture
def searched(monkeypatch):
    """Runs ``outcome_of`` with given results of its searches; returns the outcome, and what each search was asked."""
    monkeypatch.setattr(outcome, "ranking_of", lambda found, names: ())

    def run(*results):
        asked, left = [], list(results)

        def search(state, beyond, floor_n, mode, skip, workers, progress, *, as_measured=False):
            asked.append((set(skip), as_measured))
            return left.pop(0)

        monkeypatch.setattr(outcome, "_searched", search)
        return outcome.outcome_of(None, None, 1.0, "both", (), 1, lambda text, share: None), asked

    return run


def test_what_delivers_is_not_searched_again(searched):
    first = result("coulomb", verdict="missing", steps=True, beyond_known=True)
    assert searched(first) == (first, [(set(), False)])


def test_what_delivers_nothing_beyond_the_known_error_is_looked_for_as_measured(searched):
    first = result("coulomb", verdict="nothing_missing", beyond_known=True)
    again = result("gas_spring", verdict="missing", steps=True)
    assert searched(first, again) == (again, [(set(), False), (set(), True)])


def test_what_delivers_nothing_as_measured_is_set_aside(searched):
    again = result("gas_spring", verdict="missing", steps=True)
    found, asked = searched(result("coulomb"), again)
    assert found.steps == again.steps and asked == [(set(), False), ({"coulomb"}, False)]


def test_without_anything_that_delivers_the_first_search_counts(searched):
    first, others = result("coulomb", beyond_known=True), (result("dahl"), result("lugre"))
    found, asked = searched(first, *others)
    assert found is first and asked == [(set(), False), (set(), True), ({"coulomb"}, False)]
