"""The verdict that follows from what was found, what re-identification explains, and what is left."""

from dataclasses import replace

import numpy as np
import pytest
from planted import FORCE, rounded, tried

from damper_estimator.diagnosis.accepted import Accepted
from damper_estimator.diagnosis.evaluation import errors
from damper_estimator.diagnosis.reidentify import Reidentified
from damper_estimator.diagnosis.search import Search
from damper_estimator.diagnosis.structure import structure
from damper_estimator.diagnosis.thresholds import limits
from damper_estimator.diagnosis.verdict import taken_over, verdict_on
from damper_estimator.signals.layout import X


def found(current, accepted=(), left=100.0) -> Search:
    return Search(current, tuple(accepted), current.baseline.model, left, {}, current.mode)


def accepted_of(current) -> Accepted:
    best = current.best
    return Accepted(current, best, best.fitted_element, (), 1.0, current.gain(best), 100.0, 20.0)


def again_with(current, rmse, enough=True) -> Reidentified:
    return Reidentified(current.baseline.model, (), rmse, 1.0 - (rmse / 100.0) ** 2, enough, frozenset())


def test_a_finding_is_missing_unless_moving_what_is_there_says_as_much(noisy):
    current = rounded(noisy, tried(noisy, "coulomb", 0.8))
    one = accepted_of(current)
    assert verdict_on(found(current, [one], 20.0), None, FORCE, 5.0) == ("missing", None)
    assert verdict_on(found(current, [one], 20.0), again_with(current, 60.0), FORCE, 5.0)[0] == "missing"
    assert verdict_on(found(current, [one], 20.0), again_with(current, 15.0), FORCE, 5.0)[0] == "parameters_changed"
    assert verdict_on(found(current, [one], 20.0), again_with(current, 15.0, enough=False), FORCE, 5.0)[0] == "missing"


def test_moved_parameters_count_only_where_they_take_most_of_it_away(noisy):
    current = rounded(noisy)
    assert verdict_on(found(current), again_with(current, 20.0), FORCE, 5.0)[0] == "parameters_changed"
    assert verdict_on(found(current), again_with(current, 90.0), FORCE, 5.0)[0] != "parameters_changed"


def test_a_finding_that_leaves_more_than_moved_parameters_is_not_missing(noisy):
    current = rounded(noisy, tried(noisy, "coulomb", 0.8))
    one = accepted_of(current)
    assert verdict_on(found(current, [one], 75.0), again_with(current, 70.0), FORCE, 5.0)[0] == "parameters_changed"
    assert verdict_on(found(current, [one], 65.0), again_with(current, 70.0), FORCE, 5.0)[0] == "missing"


def test_parameters_take_a_finding_over_that_is_idle_beside_them(noisy):
    current = rounded(noisy, tried(noisy, "coulomb", 0.8))
    one = accepted_of(current)
    search = found(current, [one, replace(one, before_n=20.0, after_n=15.0)], 15.0)
    name = one.hypothesis.name
    assert taken_over(search, (), again_with(current, 20.0))
    assert not taken_over(search, (name,), again_with(current, 20.0)), "it lowers the error itself"
    assert not taken_over(search, (), again_with(current, 25.0)), "they explain less than it does"
    assert not taken_over(search, (), again_with(current, 20.0, enough=False)), "effects explain much beside them"


def test_what_is_left_is_unexplained_only_far_above_the_noise(noisy):
    plain = replace(noisy, model=replace(noisy.model, fit={}))
    current = rounded(plain)
    assert verdict_on(found(current, left=100.0), None, FORCE, 90.0) == ("nothing_missing", None)
    assert verdict_on(found(current, left=100.0), None, FORCE, 5.0) == ("unexplained", None)
    assert verdict_on(found(current, left=100.0), None, 1e5, 5.0) == ("nothing_missing", None)


def test_what_the_identification_left_excuses_nothing_on_its_own_recordings(noisy):
    usual = replace(noisy, model=replace(noisy.model, fit={"residual_stddev": 40.0}))
    current, left = rounded(usual), 100.0
    assert left < 3.0 * 40.0 and left < 3.0 * limits().notable * 2000.0
    assert verdict_on(found(current, left=left), None, 2000.0, 5.0)[0] == "nothing_missing"
    assert verdict_on(found(current, left=left), None, 2000.0, 5.0, is_identified_here=True)[0] == "unexplained"
    assert verdict_on(found(current, left=left), None, 2000.0, 60.0, is_identified_here=True)[0] == "nothing_missing"


def test_structure_over_the_motion_is_seen_and_put_in_words(noisy):
    def ripple(rows):
        x = np.concatenate([current.measurement.kinematics.block[X][current.picks] for current in rows])
        return 100.0 * np.sign(x - np.median(x))

    rippled = replace(noisy, residual_fit=ripple(noisy.data.fit), residual_unseen=ripple(noisy.data.unseen))
    for current, seen in ((rippled, True), (noisy, False)):
        picture, gain, low = structure(
            current, errors(current.data.blocks, current.residual_fit, current.residual_unseen)
        )
        assert (gain > 0.6) == (low > 0.5) == seen
    picture = structure(rippled, errors(rippled.data.blocks, rippled.residual_fit, rippled.residual_unseen))[0]
    assert "displacement" in picture.words and np.nanmax(np.abs(picture.mean_n)) == pytest.approx(100.0, rel=0.05)
