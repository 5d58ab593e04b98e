"""One sample at a time, several dampers in one call: the same bits as blocks, one damper after the other."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from damper_estimator.model import load_model
from damper_estimator.runtime import ABSENT, FIELDS, DamperEstimator, HeldValues, Line, deployed
from damper_estimator.signals import Fusion
from damper_estimator.signals.admission import DUPLICATE

MS = 1_000_000
NAMES = ("carrera_akutain", "bouc_wen", "lozoya_santos_complete", "mr_damper_on_mount")
MODELS = [load_model(name) for name in NAMES]


def faulty(size, seed):
    """Stamps (n,), displacement (n, 4), presence (n, 4) and command (n,) with every fault of an input."""
    random = np.random.default_rng(seed)
    step = random.choice([1, 2, 3, 0, -5, 150, -400], size, p=[0.5, 0.2, 0.2, 0.04, 0.04, 0.01, 0.01]) * MS
    stamp = 1_700_000_000 * 10**9 + np.cumsum(step)
    displacement = 0.02 * np.sin(np.arange(size) * 0.05)[:, None] * [1.0, 0.5, -1.0, 2.0]
    displacement += random.choice([0.0, 0.05], (size, 4), p=[0.99, 0.01])
    displacement[random.random((size, 4)) < 0.02] = np.nan
    command = random.choice([np.nan, 0.0, 1.0], 6).repeat(-(-size // 6))[:size]
    return stamp, displacement, random.random((size, 4)) < 0.97, command


@given(
    st.integers(0, 500),
    st.sampled_from([0.0, 30.0, 60.0]),
    st.sampled_from([0.0, 0.004]),
    st.sampled_from([None, Fusion()]),
)
@settings(max_examples=25, deadline=None)
def test_live_equals_blocks_bit_for_bit_under_every_fault(seed, cutoff, lead, fusion):
    stamp, displacement, present, command = faulty(300, seed)
    felt, felt_at = np.random.default_rng(seed).standard_normal(300), stamp.copy()
    felt[50:80], felt_at[200:] = np.nan, felt_at[199]  # unknown for a while, then silent
    line, heard = Line(), np.cumsum(np.random.default_rng(seed).random(300) < 0.3)
    for name, model in zip(NAMES, MODELS, strict=True):
        line.add(name, deployed(model, cutoff, 0.1, lead, fusion))
    verdicts, status, numbers = [], [], []
    for i in range(stamp.size):
        arrived = line.input
        arrived.slow[0, 0], arrived.received[0, 0] = command[i], heard[i]
        arrived.acceleration[0], arrived.acceleration_stamp[0] = felt[i], felt_at[i]
        count = line.step(stamp[i], displacement[i], present[i])
        verdict = line.output.verdict[0]
        verdicts.append(verdict.copy())
        status.append(line.output.status[0].copy())
        numbers.append(line.output.numbers[0].copy())
        assert count == np.count_nonzero((verdict >= 0) & (verdict < DUPLICATE))
    verdicts, status, numbers = np.array(verdicts), np.array(status), np.array(numbers)
    for d, model in enumerate(MODELS):
        there = present[:, d]
        estimator = DamperEstimator(deployed(model, cutoff, 0.1, lead, fusion))
        held = {
            "command": HeldValues(command[there], heard[there]),
            "acceleration": HeldValues(felt[there], 0, felt_at[there]),
        }
        whole = estimator.take(stamp[there], displacement[there, d], held)
        assert (verdicts[~there, d] == ABSENT).all() and np.array_equal(verdicts[there, d], whole.verdict)
        good = there & (verdicts[:, d] < DUPLICATE)
        assert np.array_equal(status[good, d], whole.status)
        for row, field in enumerate(FIELDS):
            assert np.array_equal(numbers[good, row, d], whole.fields()[field], equal_nan=True), field
        assert np.isfinite(numbers[good, FIELDS.index("force"), d]).all()


def test_an_added_damper_leaves_the_others_unchanged():
    stamp, displacement, _, _ = faulty(200, 1)
    everyone, alone, grown = (Line() for _ in range(3))
    for name, model in zip(NAMES[:2], MODELS, strict=False):
        everyone.add(name, deployed(model, 60.0, 0.1))
    alone.add(NAMES[0], deployed(MODELS[0], 60.0, 0.1))
    grown.add(NAMES[0], deployed(MODELS[0], 60.0, 0.1))
    for i in range(200):
        if i == 100:
            grown.add(NAMES[1], deployed(MODELS[1], 60.0, 0.1))
            everyone = Line()
            everyone.add(NAMES[1], deployed(MODELS[1], 60.0, 0.1))
        for line in (alone, grown):
            line.step(stamp[i], displacement[i, : len(line.names)], np.ones(len(line.names), bool))
        assert np.array_equal(grown.output.numbers[0, :, 0], alone.output.numbers[0, :, 0], equal_nan=True)
        if i >= 100:
            everyone.step(stamp[i], displacement[i, 1:2], np.ones(1, bool))
            assert np.array_equal(grown.output.numbers[0, :, 1], everyone.output.numbers[0, :, 0], equal_nan=True)


def test_two_lines_share_a_model_but_no_state():
    one, other = Line(), Line()
    for line in (one, other):
        line.add("a", deployed(MODELS[1], 60.0, 0.1))
        line.add("b", deployed(MODELS[1], 60.0, 0.1))
    for i in range(50):
        one.step(i * MS, np.full(2, 0.001 * i), np.ones(2, bool))
    assert len(MODELS[1].program.functions) == len(kernels_of(MODELS[1]))
    other.step(50 * MS, np.full(2, 0.05), np.ones(2, bool))
    fresh = DamperEstimator(deployed(MODELS[1], 60.0, 0.1)).block(np.array([50 * MS]), np.array([0.05]))
    assert other.output.numbers[0, FIELDS.index("force")].tolist() == [fresh.published[0]] * 2


def kernels_of(model):
    """The kernels of a model compiled again."""
    from damper_estimator.model.program import compile_program

    return compile_program(model.effects).functions
