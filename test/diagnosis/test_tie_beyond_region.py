"""A tie inside the region of the identification is broken by a test that was driven beyond it."""

from dataclasses import replace

import numpy as np
import pytest

import damper_estimator as de
from damper_estimator.diagnosis.beyond_region import extrapolation
from damper_estimator.diagnosis.diagnose import begun

VOLUME, ROD, PRESSURE, EXPONENT = 6.0e-5, 2.0e-4, 8.0e6, 1.25  # m^3, m^2, Pa


def driven(waves, seconds, name, gas) -> de.Recording:
    """A damper with a curve, and perhaps with gas behind its piston."""
    time = np.arange(0.0, seconds, 1.0 / 400.0)
    x = sum(1e-3 * a * np.sin(2.0 * np.pi * f * time + p) for f, a, p in waves)
    v = sum(1e-3 * a * 2.0 * np.pi * f * np.cos(2.0 * np.pi * f * time + p) for f, a, p in waves)
    spring = -PRESSURE * ROD * ((VOLUME / (VOLUME + ROD * x)) ** EXPONENT - 1.0)
    noise = np.random.default_rng(len(name)).standard_normal(time.size)
    return de.Recording.from_arrays(time, x, force=900.0 * np.tanh(v / 0.4) + gas * spring + 8.0 * noise, name=name)


SHORT = ((0.9, 9.0, 0.2), (2.6, 4.0, 1.0), (6.1, 2.0, 2.0), (11.0, 0.9, 0.4))
LONG = ((0.25, 55.0, 0.0), (1.3, 7.0, 0.5))


@pytest.fixture(scope="module")
def found():
    """Of the short recording alone, and of both."""
    model = de.fit(driven(SHORT, 60.0, "base", gas=0.0), "viscous_curve").model
    short, long = driven(SHORT, 40.0, "short", gas=1.0), driven(LONG, 60.0, "long test", gas=1.0)
    both = replace(short, sources=(*short.sources, *long.sources), measurements={
        "damper": (*short.measurements["damper"], *long.measurements["damper"])
    })  # fmt: skip
    assert extrapolation(begun(model, list(both.measurements["damper"]), ())).channel == "displacement"
    return [de.diagnose(recording, model).only for recording in (short, both)]


def test_they_are_tied_where_the_stroke_is_short(found):
    first = found[0].findings[0]
    assert {"gas_spring", "spring_rate_error"} <= {first.phenomenon, *first.tied_with}


def test_the_long_stroke_tells_them_apart(found):
    first = found[1].findings[0]
    assert first.phenomenon == "gas_spring" and not first.tied_with
