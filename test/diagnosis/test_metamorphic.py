"""What must not matter to a diagnosis: units, signs, when and how a recording was cut, names, rate, the gauge's zero.

A damper of equations of its own is sampled at 3 kHz; a mass is hidden in it, or nothing.
"""

from dataclasses import dataclass, replace

import numpy as np
import pytest

import damper_estimator as de
from damper_estimator.model import parse_model
from damper_estimator.signals import default_signals

RATE, SECONDS = 3000, 15.0
HIDDEN = ("inertia", None)


@dataclass(frozen=True)
class Arrays:
    """What a logger wrote: s, m, N, each (n,)."""

    time: np.ndarray
    x: np.ndarray
    force: np.ndarray

    def every(self, step: int) -> "Arrays":
        """Each ``step``-th sample."""
        return Arrays(self.time[::step], self.x[::step], self.force[::step])

    def halves(self) -> tuple["Arrays", "Arrays"]:
        """Cut in the middle; the second starts its own time."""
        half = self.time.size // 2
        first, second = slice(0, half), slice(half, None)
        return (
            Arrays(self.time[first], self.x[first], self.force[first]),
            Arrays(self.time[second] - self.time[half], self.x[second], self.force[second]),
        )


def logged(seed: int, hidden: str | None) -> Arrays:
    """A drive over a digressive damper whose gas pushes with a constant force, in ordinary noise."""
    rng = np.random.default_rng(seed)
    count = round(RATE * SECONDS)
    frequency = np.fft.rfftfreq(count, 1.0 / RATE)
    inside = (frequency > 0.2) & (frequency < 18.0)
    spectrum = np.where(inside, np.exp(2j * np.pi * rng.random(frequency.size)), 0.0) / (1.0 + (frequency / 2.0) ** 2)
    x = np.fft.irfft(spectrum, count)
    x *= 0.012 / x.std()
    v = np.gradient(x, 1.0 / RATE)
    a = np.gradient(v, 1.0 / RATE)
    force = 600.0 * v + 350.0 * np.arctan(v / 0.08) + 40.0 * v * np.abs(v) - 180.0
    if hidden == "inertia":
        force += 9.0 * a
    time = np.arange(count) / RATE
    noise = rng.standard_normal((2, count))
    return Arrays(time, x + 4e-6 * noise[0], force + 3.0 * noise[1])


def recording(*several: Arrays, damper: str = "damper", scale: tuple[float, float] = (1.0, 1.0)) -> de.Recording:
    """The arrays as recordings that are pooled; ``scale``: how many of the logger's units are a metre, and a newton."""
    plain = default_signals(damper)
    scaled = replace(
        plain,
        displacement=replace(plain.displacement, scale=1.0 / scale[0]),
        force=replace(plain.force, scale=1.0 / scale[1]),
    )
    signals = de.SignalMap(dampers={damper: scaled})
    each = [
        de.Recording.from_arrays(
            one.time, scale[0] * one.x, force=scale[1] * one.force, damper=damper, name=f"part {n}", signals=signals
        )
        for n, one in enumerate(several)
    ]  # fmt: skip
    measurements = {damper: tuple(one.measurements[damper][0] for one in each)}
    return replace(each[0], sources=tuple(one.sources[0] for one in each), measurements=measurements)


@dataclass(frozen=True)
class Scene:
    """Recordings at 1 kHz and 3 kHz, the model identified without what is hidden, and what is said of it."""

    hidden: str | None
    base: Arrays
    fit: Arrays
    unseen: Arrays
    model: de.DamperModel
    found: de.DiagnosisResults

    @property
    def slow(self) -> tuple[Arrays, Arrays]:
        """Fit and unseen recording at 1 kHz."""
        return self.fit.every(3), self.unseen.every(3)


def user_model(base: Arrays) -> de.DamperModel:
    """A curve with knots dense at low speed, identified on the recording without what is hidden."""
    speeds = (0.02, 0.05, 0.09, 0.15, 0.25, 0.4, 0.7, 1.2)
    knots = [*(-v for v in reversed(speeds)), 0.0, *speeds]
    curve = {"viscous_curve": {"velocity": knots, "force": [0.0] * len(knots)}}
    start = parse_model({"name": "user", "source": "test", "effects": [curve]}, "test")
    return de.fit(recording(base.every(3)), start).model


@pytest.fixture(scope="module", params=HIDDEN, ids=lambda hidden: hidden or "nothing")
def scene(request) -> Scene:
    base, fit, unseen = (logged(seed, hidden) for seed, hidden in ((1, None), (2, request.param), (3, request.param)))
    model = user_model(base)
    found = de.diagnose(recording(fit.every(3)), model, validate=recording(unseen.every(3)))
    return Scene(request.param, base, fit, unseen, model, found)


def alike(one: de.DiagnosisResults, other: de.DiagnosisResults, *, rmse: float = 0.03, noise: float = 0.0) -> None:
    """Same verdict, same findings in the same order, same numbers within their uncertainty; ``noise`` in N."""
    a, b = one.diagnosis, other.diagnosis
    assert b.verdict == a.verdict
    assert [finding.phenomenon for finding in b.findings] == [finding.phenomenon for finding in a.findings]
    assert [set(finding.tied_with) for finding in b.findings] == [set(finding.tied_with) for finding in a.findings]
    assert b.rmse_n == pytest.approx(a.rmse_n, rel=rmse, abs=noise)
    for mine, its in zip(a.findings, b.findings, strict=True):
        assert min(mine.low, its.low) - 0.02 <= its.gain <= max(mine.high, its.high) + 0.02
        assert its.confidence == pytest.approx(mine.confidence, abs=0.1)
        for p, q in zip(mine.parameters, its.parameters, strict=True) if mine.effect == its.effect else ():
            assert abs(q.value - p.value) <= 3.0 * np.hypot(p.standard_error, q.standard_error) + 0.02 * abs(p.value)


def diagnosed(scene: Scene, fit: de.Recording, unseen: de.Recording) -> de.DiagnosisResults:
    return de.diagnose(fit, scene.model, validate=unseen)


def test_what_is_hidden_is_found(scene):
    """Without this the others would compare errors."""
    if scene.hidden:
        assert scene.found.findings[0].phenomenon == scene.hidden
    else:
        assert scene.found.verdict == "nothing_missing"


def spoiled(arrays: Arrays) -> Arrays:
    """With dropouts and glitches of a few samples in both channels."""
    x, force = arrays.x.copy(), arrays.force.copy()
    x[2000], x[4000:4003], x[4020], x[9000] = 5.0, 0.0, -0.2, x[9000] + 0.02
    force[3000], force[7000:7002] = -60e3, 2e4
    return replace(arrays, x=x, force=force)


def test_spikes_in_both_channels(scene):
    fit, unseen = (spoiled(arrays) for arrays in scene.slow)
    found = diagnosed(scene, recording(fit), recording(unseen))
    alike(scene.found, found)
    assert {finding.kind for finding in found.diagnosis.data} == {"spikes"}
    assert len(found.diagnosis.data) == 2, "of each channel, in recordings of one name"


def test_units_through_the_map(scene):
    units = (1e-1, 1e-3)  # in 10 m and in kN
    again = diagnosed(scene, *(recording(slow, scale=units) for slow in scene.slow))
    alike(scene.found, again, rmse=1e-6)


def test_both_signs_turned_through_the_map(scene):
    again = diagnosed(scene, *(recording(slow, scale=(-1.0, -1.0)) for slow in scene.slow))
    alike(scene.found, again, rmse=1e-9)


def test_shifted_in_time(scene):
    later = [replace(slow, time=slow.time + 12_345.0) for slow in scene.slow]
    alike(scene.found, diagnosed(scene, *map(recording, later)), rmse=1e-3)


def test_split_in_two(scene):
    fit, unseen = scene.slow
    alike(scene.found, diagnosed(scene, recording(*fit.halves()), recording(*unseen.halves())))


def test_files_in_another_order(scene):
    fit, unseen = scene.slow
    one = diagnosed(scene, recording(*fit.halves()), recording(*unseen.halves()))
    other = diagnosed(scene, recording(*fit.halves()[::-1]), recording(*unseen.halves()[::-1]))
    alike(one, other, rmse=1e-6)


def test_another_name_of_the_damper(scene):
    again = diagnosed(scene, *(recording(slow, damper="rear_left") for slow in scene.slow))
    alike(scene.found, again, rmse=1e-9)


def test_thinned_from_3_to_1_khz(scene):
    again = diagnosed(scene, recording(scene.fit), recording(scene.unseen))
    # A third of the samples has three times the noise in band.
    alike(scene.found, again, noise=0.5)


def test_a_constant_added_to_the_force_of_all_recordings(scene):
    """The gauge's zero was as wrong when the model was identified."""
    more = [
        replace(logged_once, force=logged_once.force + 150.0) for logged_once in (scene.base, scene.fit, scene.unseen)
    ]
    shifted = replace(scene, model=user_model(more[0]))
    again = diagnosed(shifted, *(recording(slow.every(3)) for slow in more[1:]))
    alike(scene.found, again)


def test_another_zero_of_the_displacement(scene):
    """Nothing says that a displacement of 0 is the middle of the stroke."""
    moved = [replace(one, x=one.x + 0.08) for one in (scene.fit, scene.unseen)]
    again = diagnosed(scene, *(recording(slow.every(3)) for slow in moved))
    alike(scene.found, again)
