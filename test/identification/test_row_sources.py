"""A problem is the same wherever its rows are: what a source answers adds up over its recordings."""

import numpy as np
import pytest

from damper_estimator.identification import LocalRows, Problem, rows_of
from damper_estimator.identification.excitation_problem import ExcitationProblem
from damper_estimator.identification.methods.least_squares import refine
from damper_estimator.identification.row_sources import Place, added_up
from damper_estimator.identification.samples import samples_of
from damper_estimator.identification.ties import Ties
from damper_estimator.identification.uncertainty import uncertainty
from damper_estimator.identification.unknowns import Unknowns
from damper_estimator.model import DamperModel
from damper_estimator.numerics import order_statistics

SIZE = np.array([30.0, 0.01])


class Apart:
    """Rows of recordings each of which answers separately, as if it were elsewhere."""

    def __init__(self, parts):
        self.parts = parts
        self.recordings = tuple(name for source in parts for name in source.recordings)
        self.totals = added_up([source.totals for source in parts])

    def sums(self, unknowns):
        return ApartSums([source.sums(unknowns) for source in self.parts])

    def thinned(self):
        return Apart([source.thinned() for source in self.parts])

    def excerpts(self, samples, total):
        return Apart([source.excerpts(samples, total) for source in self.parts])

    def cycles(self):
        return [part for source in self.parts for part in source.cycles()]

    def excitations(self, given, split):
        return Apart([source.excitations(given, split) for source in self.parts])

    def group_sizes(self):
        return [np.concatenate(group) for group in zip(*(source.group_sizes() for source in self.parts), strict=True)]

    def weighted(self, weights):
        parts, taken = [], [0 for _ in weights]
        for source in self.parts:
            counts = [sizes.size for sizes in source.group_sizes()]
            mine = [w[t : t + n] for w, t, n in zip(weights, taken, counts, strict=True)]
            taken = [t + n for t, n in zip(taken, counts, strict=True)]
            parts.append(source.weighted(mine))
        return Apart(parts)


class ApartSums:
    def __init__(self, parts):
        self.parts = parts

    def columns(self, searched):
        return np.concatenate([sums.columns(searched) for sums in self.parts])

    def linearised(self, place):
        return np.concatenate([sums.linearised(place) for sums in self.parts])

    def noise(self, place, weights):
        parts = [sums.noise(place, weights) for sums in self.parts]
        return sum(total for total, _ in parts), sum(effective for _, effective in parts)

    def errors(self, vectors):
        parts = [sums.errors(vectors) for sums in self.parts]
        return [[np.concatenate(group) for group in zip(*each, strict=True)] for each in zip(*parts, strict=True)]


@pytest.fixture
def model(entry, model_of) -> DamperModel:
    return model_of(entry("tanh_hysteresis"), entry("viscous"), entry("static_force"))


@pytest.fixture
def rows(entry, model_of, measured):
    """Three recordings of a damper."""
    truth = model_of(
        entry("tanh_hysteresis", force=400.0, steepness=50.0, shift=0.003),
        entry("viscous", rate=1800.0),
        entry("static_force", force=-40.0),
    )
    return [rows_of(measured(truth, seed, noise=0.05)) for seed in range(3)]


@pytest.fixture
def pair(model, rows):
    """The same problem with all rows in one source, and with a source for each."""
    sources = LocalRows(rows), Apart([LocalRows([recording]) for recording in rows])
    return [Problem(model, source, range(len(model.slots))) for source in sources]


def test_a_search_over_separate_sources_ends_where_one_over_all_rows_does(pair):
    one, apart = (refine(problem, problem.start, SIZE)[0] for problem in pair)
    assert apart.cost == pytest.approx(one.cost, rel=1e-10)
    np.testing.assert_allclose(apart.searched, one.searched, rtol=1e-9)
    np.testing.assert_allclose(apart.solved, one.solved, rtol=1e-9)
    free = Ties((), np.eye(len(pair[0].slots)))
    known = [uncertainty(problem, one, problem.linearised(one, SIZE), free) for problem in pair]
    np.testing.assert_allclose(known[1].standard_error, known[0].standard_error, rtol=1e-6)
    assert pair[0].size == pair[1].size and pair[0].natural_sizes() == pytest.approx(pair[1].natural_sizes())


def test_excerpts_of_separate_sources_are_those_of_all_rows(pair):
    one, apart = (problem.excerpts(3000) for problem in pair)
    assert one.size == apart.size < pair[0].size
    searched = np.array([44.0, 0.001])
    assert apart.point(searched).cost == pytest.approx(one.point(searched).cost, rel=1e-10)
    assert pair[0].excerpts(10**9) is pair[0]


def test_excitations_of_separate_sources_are_those_of_all_rows(pair):
    one, apart = (ExcitationProblem(problem, {}) for problem in pair)
    assert one.groups == apart.groups
    assert [sizes.tolist() for sizes in one.sizes] == [sizes.tolist() for sizes in apart.sizes]
    vectors = np.array([slot.value for slot in one.problem.slots]) * np.array([[1.0], [1.3]])
    for mine, theirs in zip(one.errors(vectors), apart.errors(vectors), strict=True):
        for a, b in zip(mine, theirs, strict=True):
            np.testing.assert_allclose(a, b, rtol=1e-12)
    weights = [np.linspace(1.0, 2.0, sizes.size) for sizes in one.sizes]
    costs = [problem.weighted(weights).point(np.array([44.0, 0.001])).cost for problem in (one, apart)]
    assert costs[1] == pytest.approx(costs[0], rel=1e-10)


def test_a_weight_counts_each_squared_row_so_often(pair):
    excited = ExcitationProblem(pair[0], {})
    vector = np.array([slot.value for slot in pair[0].slots])
    searched, solved = vector[pair[0].searched], vector[pair[0].solved]
    (errors,) = excited.errors(vector[None, :])
    weights = [np.full(sizes.size, k + 1.0) for k, sizes in enumerate(excited.sizes)]
    expected = sum(float(w @ (e * n)) for w, e, n in zip(weights, errors, excited.sizes, strict=True))
    assert 2.0 * excited.weighted(weights).point(searched, solved).cost == pytest.approx(expected)


def test_a_source_without_rows_answers_nothing(model):
    sums = LocalRows([]).sums(Unknowns(model, range(len(model.slots))))
    place = Place(np.array([44.0, 0.001]), np.ones(3), SIZE)
    assert sums.columns(place.searched).shape == (0, 4)
    assert sums.linearised(place).shape == (0, 6)
    total, effective = sums.noise(place, np.ones((5, 2)))
    assert total.shape == (2, 2) and not total.any() and effective == 0.0
    assert sums.errors(np.ones((2, 5))) == [[], []]


def test_where_a_model_gives_no_finite_force_the_cost_is_infinite(pair):
    for problem in pair:
        assert problem.point(np.array([np.nan, 0.0])).cost == np.inf


def test_what_was_linearised_last_is_not_run_again(pair, monkeypatch):
    runs = []
    once = DamperModel.force_at
    monkeypatch.setattr(DamperModel, "force_at", lambda model, *given: runs.append(1) or once(model, *given))
    point = pair[0].point(np.array([44.0, 0.001]))
    linear = pair[0].linearised(point, SIZE)
    before = len(runs)
    linear.noise(np.eye(5))
    assert len(runs) == before > 0


@pytest.mark.parametrize("count", [1, 2, 7, 1000])
def test_percentiles_are_those_of_numpy_wherever_the_values_are(count):
    values = np.round(np.random.default_rng(count).standard_normal(count), 2)
    here = samples_of(np.append(values, np.nan))
    shares = (0.0, 0.1, 33.3, 50.0, 99.9, 100.0)
    assert here.size == count and here.percentiles(shares) == np.percentile(values, shares).tolist()
    ranks = range(count)
    assert order_statistics(here.below, here.low, here.high, ranks) == here.smallest(ranks)
