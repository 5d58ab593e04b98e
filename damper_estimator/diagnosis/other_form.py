"""Another form of a phenomenon that a model has already, in the place of what represents it there.

Beside a yield of the wrong form a better one explains little: the old one has taken what both could explain. A form of
another phenomenon is tried as well if its form-free test contains that of the present one, as memory contains friction.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from damper_estimator.diagnosis.apply_finding import ModelState, identified
from damper_estimator.diagnosis.atlas_terms import TESTS
from damper_estimator.diagnosis.diagnosis_data import ranges_of
from damper_estimator.diagnosis.hypotheses import Hypothesis, are_themselves, hypotheses_for
from damper_estimator.diagnosis.thresholds import limits
from damper_estimator.effects.contract import Effect
from damper_estimator.model import DamperModel
from damper_estimator.model.element import labels

_CONTAINED = {test.name: test.contains for test in TESTS}


def in_another_form(state: ModelState) -> tuple[ModelState, str, Hypothesis] | None:
    """The model with the form that leaves least, what it replaces, and the form; None where none explains as much more
    as an effect that is missing has to.
    """
    best = None
    for label, less, form in _replacements(state):
        changed, _ = form.added_to(less)
        kept = {name: region for name, region in state.added.items() if name in _names(less)}
        after = replace(state, added={**kept, form.name: form.region})
        after = after.with_model(identified(after, changed), f"in place of {label}")
        if not are_themselves(after.model, after.added):
            continue
        if best is None or after.rmse_unseen_n < best[0].rmse_unseen_n:
            best = after, label, form
    most = np.sqrt(1.0 - limits().gain) * state.rmse_unseen_n
    return best if best is not None and best[0].rmse_unseen_n <= most else None


def _replacements(state: ModelState) -> Iterator[tuple[str, DamperModel, Hypothesis]]:
    """Label of a source, the model without it, and another form."""
    model = state.model
    ranges = ranges_of(state.fit_part, model)
    for label, element in labels(model.effects):
        effect = element.effect
        if effect.kind == "source" and effect.phenomenon:
            less = model.without(label)
            for form in hypotheses_for(less, ranges)[0]:
                if form.effect.kind == "source" and form.name not in _names(model) and _replaces(form.effect, effect):
                    yield label, less, form


def _replaces(form: Effect, present: Effect) -> bool:
    contained = {name for test in form.tests for name in _CONTAINED[test]}
    return form.phenomenon == present.phenomenon or not contained.isdisjoint(present.tests)


def _names(model: DamperModel) -> set[str]:
    return {element.effect.name for _, element in labels(model.effects)}
