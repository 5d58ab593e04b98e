"""The entry with which an effect is put into a model from the page."""

from collections.abc import Sequence
from dataclasses import replace

from damper_estimator.diagnosis import Diagnosis, ranges_of
from damper_estimator.effects.contract import Effect
from damper_estimator.effects.trial import Untestable
from damper_estimator.errors import InputError
from damper_estimator.model import DamperModel, Element
from damper_estimator.model.element import new_element
from damper_estimator.signals import Measurement


def element_for(effect: Effect, model: DamperModel, fit: Sequence[Measurement], found: Diagnosis | None) -> Element:
    """As the diagnosis found it, else with the values that it would be tried with on these recordings.

    Raises:
        InputError: where the recordings lack what the effect needs.
    """
    for finding, element in zip(found.findings, found.elements, strict=True) if found is not None else ():
        if finding.effect == effect.name:
            return replace(element, path=()) if effect.kind == "series" else element
    values: dict[str, object] = {}
    if effect.trial is not None:
        try:
            values |= effect.trial(ranges_of(fit, model)).values
        except Untestable as error:
            raise InputError(f"{effect.name}: cannot be identified on these recordings: {error}") from None
    for tried in found.ranking if found is not None else ():
        if tried.effect == effect.name:
            values |= {p.name.rpartition(".")[2]: p.value for p in tried.parameters if "[" not in p.name}
    return new_element(effect, model.effects, values)
