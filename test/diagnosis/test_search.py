"""Passes of the search: when a model's parameters are kept, and when they are refitted with every effect."""

from dataclasses import replace

import numpy as np
import pytest
from planted import rounded, tried

from damper_estimator.diagnosis import search as module
from damper_estimator.diagnosis.accepted import accepted_in
from damper_estimator.diagnosis.thresholds import limits

GOOD, POOR = 0.5, 3.0  # times the error from which on a model is poor


@pytest.fixture
def searched(noisy, monkeypatch):
    """A search whose passes are replaced; returns the modes of the passes and the result."""

    def run(mode, error, found, trusted=False, here=False):
        """``error`` in multiples of ``poor``, ``found`` in each pass, ``here``: the model was identified on it."""
        rms = error * limits().poor * noisy.data.force_rms
        scale = rms / np.sqrt(np.mean(noisy.residual_unseen**2))
        start = replace(noisy, residual_fit=scale * noisy.residual_fit, residual_unseen=scale * noisy.residual_unseen)
        passes = []

        def rounds(mode, start, hypotheses, workers, progress, jointly=False):
            # Only a model that was identified here has parameters that hide what is missing.
            assert jointly == (mode == "refit" and here)
            current = rounded(start, tried(start, "coulomb", 0.9), mode=mode)
            accepted = [accepted_in(current, current.best)] if mode in found else []
            changed = current.best.fitted_into(start.model) if accepted else start.model
            passes.append(module._Pass(mode, current, accepted, replace(start, model=changed)))
            return passes[-1]

        monkeypatch.setattr(module, "baseline_of", lambda model, data: start)
        monkeypatch.setattr(module, "_rounds", rounds)
        result = module.search(
            noisy.model, noisy.data, mode, (), 1, lambda text, share: None, trusted=trusted, is_identified_here=here
        )
        assert result.first is passes[-1].first and result.mode == passes[-1].mode
        assert len(result.accepted) == len(passes[-1].accepted)
        return [one.mode for one in passes]

    return run


def test_a_good_model_is_kept_whether_anything_is_found_or_not(searched):
    assert searched("both", GOOD, found=("both",)) == ["both"]
    assert searched("both", GOOD, found=()) == ["both"]


def test_a_poor_model_is_refitted_only_if_nothing_is_found_while_it_is_kept(searched):
    assert searched("both", POOR, found=("both",)) == ["both"]
    assert searched("both", POOR, found=("refit",)) == ["both", "refit"]
    assert searched("both", POOR, found=()) == ["both", "refit"]


def test_a_model_that_was_identified_on_the_same_data_is_refitted_at_once(searched):
    assert searched("both", POOR, found=("both", "refit"), here=True) == ["refit"]
    assert searched("both", GOOD, found=("both",), here=True) == ["both"]


def test_a_trusted_model_and_an_explicit_mode_get_one_pass(searched):
    assert searched("both", POOR, found=(), trusted=True, here=True) == ["both"]
    assert searched("kept", POOR, found=(), here=True) == ["kept"]
    assert searched("refit", GOOD, found=()) == ["refit"]
