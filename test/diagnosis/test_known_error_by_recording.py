"""The error that a model has always had is subtracted in the recordings in which it accounts for part of the error."""

import numpy as np
from roads import road

import damper_estimator as de
from damper_estimator.diagnosis.diagnosis_data import data_of
from damper_estimator.diagnosis.known_error import accounted_for, without_misfit

SECONDS, RATE = 24.0, 500.0


def recorded(name: str, seed: int, bend: float) -> de.Recording:
    """A damper whose curve bends: downwards with a positive ``bend``, upwards with a negative one."""
    random, time = np.random.default_rng(seed), np.arange(round(SECONDS * RATE)) / RATE
    x = road(random, time, 12.0, slope=1.2)
    v = np.gradient(x, time)
    force = 1500.0 * v + bend * np.tanh(v / 0.1) + 2.0 * random.standard_normal(time.size)
    return de.Recording.from_arrays(time, x, force=force, name=name)


def test_recordings_judge_one_by_one():
    """A line for a bent curve errs as on another road, and the other way round on a damper that bends upwards."""
    model = de.fit(recorded("base", 1, 400.0), "linear_viscous").model
    measurements = [
        next(iter(one.measurements.values()))[0]
        for one in (recorded("same", 2, 400.0), recorded("opposite", 3, -200.0))
    ]
    whole = data_of(model, measurements, measurements)
    less = [without_misfit(model, one) for one in measurements]
    accounted, others = accounted_for(model, whole.unseen, data_of(model, less, less).unseen)
    assert (accounted, others) == ({"same"}, {"opposite"})
