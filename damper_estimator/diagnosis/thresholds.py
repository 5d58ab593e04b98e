"""Every number that a diagnosis decides by, in one place: what it decides, and why it has this value.

Numerical settings (iterations, steps, knots) are no decisions; they stay where they are used.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field, fields, replace


def _threshold(value: float, unit: str, decides: str, reason: str) -> float:
    return field(default=value, metadata={"unit": unit, "decides": decides, "reason": reason})


_SQUARE = "share of the squared error"
_FORCE = "share of the force's rms about its mean"


@dataclass(frozen=True)
class Thresholds:
    """What decisions turn on."""

    gain: float = _threshold(
        0.25,
        _SQUARE,
        "an effect must explain it on unseen data to be found",
        "errors of good recordings differ by up to a factor of two",
    )
    least_force: float = _threshold(
        0.015, _FORCE, "an effect must be worth it", "gauges of this kind are calibrated to 1 or 2 %"
    )
    penalty: float = _threshold(
        0.003,
        _SQUARE,
        "what an effect must explain more per parameter",
        "settles nested effects on unseen data",
    )
    at_bound: float = _threshold(
        0.005, _SQUARE, "what an effect with a parameter at a limit must explain more", "it is not quite itself there"
    )
    general_margin: float = _threshold(
        0.05, _SQUARE, "what a general effect must explain more than a specific one", "it can take any shape"
    )
    general_share: float = _threshold(
        0.3,
        "share of what is left",
        "at most so much of it is asked for",
        "where 2 % are left, nothing explains 5 % more",
    )
    form_free: float = _threshold(
        0.1,
        "exponent",
        "weight of the form-free test of a phenomenon beside its effects",
        "names most effects rightly on randomly drawn dampers of other physics",
    )
    sharpness: float = _threshold(
        8.0, "1", "how fast probability falls with the error that is left", "fitted together with form_free"
    )
    form_right: float = _threshold(
        0.92,
        "probability",
        "that the phenomenon is right, whatever the evidence",
        "one in ten clear findings on unknown dampers is wrong (make bench-diagnosis)",
    )
    form_share: float = _threshold(
        1.5,
        "probability per share of the squared error",
        "that it is right, where the effect leaves much",
        "a third of the findings that explain less than half of the error are wrong there",
    )
    worse: float = _threshold(
        1.1,
        "times the squared error of a recording",
        "an effect that raises it by more is contradicted by the recording",
        "what is missing never did in the ties of make bench-plan",
    )
    contradicted: float = _threshold(
        0.33, "weight of the recordings", "an effect that so many contradict is not what is missing", "one of three"
    )
    own_part: float = _threshold(
        0.03,
        _SQUARE,
        "what only an effect can change must be expected to explain it, to say something",
        "twice what re-identified parameters miss by chance",
    )
    own_found: float = _threshold(
        0.25,
        "share of what is expected",
        "an effect whose own part explains less imitates changed parameters",
        "most hidden effects find more than 0.7, most imitations less than 0.2",
    )
    named: float = _threshold(
        0.2,
        "probability",
        "a finding must be new and right with it",
        "of nine less probable ones on unknown dampers one was right",
    )
    confident: float = _threshold(
        0.4,
        "probability",
        "confidence that a finding must have",
        "of ten less certain ones on unknown dampers one was right, and two were tied with what was",
    )
    tied: float = _threshold(0.1, "probability", "another phenomenon is a tie", "one wrong name in ten is too many")
    hint: float = _threshold(
        0.1, _SQUARE, "effects of a phenomenon whose tests explain less are not tried", "less than half of gain"
    )
    silent_tests: float = _threshold(
        0.5, _SQUARE, "if no test explains more, all effects are tried", "tests see no memory longer than a reversal"
    )
    accounted: float = _threshold(
        0.9, _SQUARE, "the old error of the model is set aside only if at most this is left", "else it predicts nothing"
    )
    predicts: float = _threshold(
        0.2,
        _SQUARE,
        "the old error is kept with a model if its first part predicts the last by this much",
        "less is noise of the identification",
    )
    least_fall: float = _threshold(
        0.02, "share of the unseen error", "a step must bring it", "smaller changes differ from recording to recording"
    )
    needless: float = _threshold(
        0.01, "share of the unseen error", "an effect without which it grows by less is taken out", "half of least_fall"
    )
    acceptable: float = _threshold(
        0.07,
        _FORCE,
        "an error that has grown, but that the model's known error accounts for, is reported only above it",
        "published models leave 4 to 10 % of the force",
    )
    usual: float = _threshold(
        0.12,
        _FORCE,
        "an error that has not grown since the identification is reported only above it",
        "models of dampers that nobody has modelled before leave as much",
    )
    growth: float = _threshold(
        2.0,
        "times the squared error",
        "an error is new if it is larger than when the model was identified",
        "without any change the errors on recordings of one damper differ by up to as much",
    )
    usual_growth: float = _threshold(
        1.5,
        "times the squared error",
        "the error on other recordings than those of the identification, if nothing has changed",
        "median of unchanged dampers in make bench-diagnosis",
    )
    extrapolated: float = _threshold(
        0.5,
        _SQUARE,
        "if more lies outside the region that the model was identified in, the diagnosis says so",
        "then most of the error is one of extrapolation",
    )
    drift: float = _threshold(
        0.5,
        _SQUARE,
        "if a straight drift of the gauge's zero takes more away, the drift is compared",
        "then most of the error is a force that changes slowly, as that of warm gas",
    )
    poor: float = _threshold(
        0.05, _FORCE, "the parameters of a model that errs by less are kept", "a model that good deserves trust"
    )
    pair: float = _threshold(
        0.6,
        "share of what the best single effect leaves",
        "two effects together must leave less to be preferred to it, both beside what a wrong form leaves (second)",
        "nearly all pairs on randomly drawn dampers with one hidden effect leave more, most with two less",
    )
    second: float = _threshold(
        0.05,
        "share of what the first finding explained",
        "a later finding must explain it",
        "less is a flaw of the first one's form",
    )
    notable: float = _threshold(
        0.03,
        _FORCE,
        "smaller errors, and means of the error, on other recordings than those of the identification are left alone",
        "twice what an effect must be worth; very good models err by as much on another kind of motion, the mean "
        "differs as much on real rigs",
    )
    above: float = _threshold(
        2.0,
        "times the noise floor",
        "an error with structure above it is unexplained",
        "the floor itself is known to some ten percent",
    )
    far_above: float = _threshold(
        3.0, "times the noise floor", "an error without structure above it is unexplained", "model form leaves as much"
    )
    structured: float = _threshold(
        0.3, _SQUARE, "a picture must predict it on unseen data to be shown", "a little more than an effect (gain)"
    )
    refit_most: float = _threshold(
        0.6,
        "share of the explainable squared error",
        "re-identification must take it to be enough",
        "what is left is not larger than what was taken",
    )
    refit_better: float = _threshold(
        0.75,
        "share of the squared error after re-identification",
        "new effects that leave less say more than it",
        "a quarter better, as for an effect",
    )
    moved: float = _threshold(
        3.0, "standard errors", "a parameter must move by it to be named", "one in 400 moves so far by chance"
    )
    moved_share: float = _threshold(0.05, "share of the value", "and by this much", "smaller changes matter to nobody")


_DEFAULT = Thresholds()
_in_force: ContextVar[Thresholds] = ContextVar("thresholds", default=_DEFAULT)


def limits() -> Thresholds:
    """The thresholds that are in force."""
    return _in_force.get()


@contextmanager
def using(**values: float) -> Iterator[Thresholds]:
    """Other values for as long as the context lasts, to see how sensitive verdicts are: ``with using(gain=0.3):``.

    Raises:
        TypeError: for a name that is none.
    """
    token = _in_force.set(replace(limits(), **values))
    try:
        yield limits()
    finally:
        _in_force.reset(token)


def documented() -> list[dict[str, object]]:
    """A row for each: name, value, unit, what it decides, reason."""
    return [{"name": one.name, "value": getattr(limits(), one.name), **one.metadata} for one in fields(Thresholds)]
