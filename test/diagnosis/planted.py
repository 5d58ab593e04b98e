"""Rounds whose errors are known: hypotheses that take a given share of a white residual away."""

from dataclasses import replace

import numpy as np

from damper_estimator.diagnosis.baseline import Baseline
from damper_estimator.diagnosis.hypotheses import Hypothesis, hypotheses_for
from damper_estimator.diagnosis.ranking import Round, round_of
from damper_estimator.diagnosis.trial_fit import TrialFit

FORCE = 500.0  # N rms, of which thresholds are shares


def known(baseline: Baseline) -> dict[str, Hypothesis]:
    """All hypotheses by effect."""
    return {hypothesis.name: hypothesis for hypothesis in hypotheses_for(baseline.model, baseline.data.ranges)[0]}


def tried(baseline: Baseline, effect: str, share: float, unseen: float | None = None) -> Hypothesis:
    """A hypothesis that takes ``share`` of the residual's amplitude away, alike on both parts without ``unseen``."""
    hypothesis, count = known(baseline)[effect], baseline.residual_fit.size
    fit = TrialFit(
        dict(hypothesis.element.parameters), dict(hypothesis.element.settings), (),
        np.zeros((count, 0)), np.zeros((baseline.residual_unseen.size, 0)),
        np.ones(1), -share * baseline.residual_fit,
        -(share if unseen is None else unseen) * baseline.residual_unseen, False,
    )  # fmt: skip
    return replace(hypothesis, fit=fit)


def rounded(baseline: Baseline, *fitted: Hypothesis, mode: str = "kept") -> Round:
    """The round of some hypotheses."""
    return round_of(baseline, fitted, mode)
