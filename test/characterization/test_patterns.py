"""Pattern types: each shape by formula is classified correctly, also after irrelevant changes."""

import numpy as np
import pytest
from shapes import SHAPES, loop_of

from damper_estimator.characterization.patterns import classify


def test_a_shape_is_classified_as_its_type(kind):
    assert classify(loop_of(SHAPES[kind])).type == kind


def test_asymmetric_dampers_have_the_same_types(kind):
    pattern = classify(loop_of(SHAPES[kind], rebound=1.6))
    assert pattern.type == kind
    assert not pattern.symmetric


def test_symmetry_is_detected(kind):
    assert classify(loop_of(SHAPES[kind])).symmetric


@pytest.mark.parametrize("seed", range(5))
def test_one_per_cent_noise_changes_no_type(kind, seed):
    assert classify(loop_of(SHAPES[kind], noise=0.01, seed=seed)).type == kind


@pytest.mark.parametrize("scale", [1e-3, 0.5, 40.0])
def test_scaling_the_force_changes_no_type(kind, scale):
    assert classify(loop_of(lambda u, a: scale * SHAPES[kind](u, a))).type == kind


@pytest.mark.parametrize("motion", [{"frequency": 0.6}, {"frequency": 14.0, "amplitude": 0.002}])
def test_frequency_and_stroke_change_no_type(kind, motion):
    assert classify(loop_of(SHAPES[kind], **motion)).type == kind


def test_a_constant_force_is_offset_and_not_shape(kind):
    pattern = classify(loop_of(SHAPES[kind], offset=-350.0))
    assert pattern.type == kind
    assert pattern.offset == pytest.approx(-350.0, abs=1.0)


def test_the_other_sign_convention_swaps_rebound_and_compression(kind):
    loop = loop_of(SHAPES[kind], rebound=1.6)
    other = classify(loop_of(SHAPES[kind], compression=1.6))
    pattern = classify(loop)
    assert pattern.type == other.type
    assert pattern.rebound.high_damping == pytest.approx(other.compression.high_damping, rel=1e-6)
    assert pattern.compression.hysteresis_high == pytest.approx(other.rebound.hysteresis_high, abs=1e-9)


@pytest.mark.parametrize(("stiffness", "word"), [(15000.0, "spring of 1.5e+04 N/m"), (-12000.0, "a mass of")])
@pytest.mark.parametrize("kind", [0, 1, 4])
def test_a_spring_or_a_mass_parallel_to_the_damper_is_reported_and_excluded_from_the_type(kind, stiffness, word):
    loop = loop_of(SHAPES[kind])
    with_spring = type(loop)(**{**vars_of(loop), "force": loop.force + stiffness * loop.displacement})
    pattern = classify(with_spring)
    assert pattern.type == kind
    assert pattern.stiffness == pytest.approx(stiffness, rel=0.01)
    assert word in pattern.because


def test_measures_are_those_of_the_shape():
    pattern = classify(loop_of(SHAPES[1], amplitude=0.02, frequency=2.0))
    peak = 0.02 * 2.0 * np.pi * 2.0
    assert pattern.rebound.knee_velocity == pytest.approx(0.4 * peak, rel=0.03)
    assert pattern.rebound.high_damping == pytest.approx(700.0 / (0.4 * peak), rel=0.02)
    assert pattern.rebound.low_damping == pytest.approx(300.0 / (0.6 * peak), rel=0.02)
    assert pattern.compression.rise == pytest.approx(0.3, abs=0.02)


def vars_of(loop):
    """Fields of a loop by name."""
    return {name: getattr(loop, name) for name in type(loop).__dataclass_fields__}
