"""What one page works on: recordings, models side by side, the steps of the first of them, a diagnosis, a job."""

import os
import threading
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from damper_estimator.diagnosis import Diagnosis
from damper_estimator.diagnosis.mend import mended_signals
from damper_estimator.effects.discovery import find_effect
from damper_estimator.errors import InputError
from damper_estimator.identification import usable
from damper_estimator.model import DamperModel, Element, load_model
from damper_estimator.studio.apart import Tell, run_apart
from damper_estimator.studio.element import element_for
from damper_estimator.studio.folder import Folder
from damper_estimator.studio.history import History, Version
from damper_estimator.studio.job import Job
from damper_estimator.studio.shown import Shown, shown
from damper_estimator.studio.stage import Choice, Stage, opened
from damper_estimator.studio.work import Case, Deed, diagnose_case, identified_alone, improve_case, judged, refitted
from damper_estimator.validation import Comparison

_KEPT = 6  # models whose forces are kept


class Session:
    """The state of one page; final. Its verbs raise InputError where something cannot be done.

    Attributes:
        stage, history, others: None, None and () until something is open; ``others`` are models to look at beside.
        diagnosis: of which version of the model, and what was found; None until one was made.
        job, jobs: the long work that goes on, or the last one, and how many there were.
        opened: counts what was opened.
        centres: value of every parameter by address when the list of parameters last changed: its slider's middle.
        generation: counts changes of what is on view.
        rebuilt: counts changes after which the list of parameters is another one.
    """

    def __init__(self, folder: Folder) -> None:
        self.folder = folder
        self.stage: Stage | None = None
        self.history: History | None = None
        self.others: tuple[DamperModel, ...] = ()
        self.diagnosis: Diagnosis | None = None
        self.job: Job | None = None
        self.centres: dict[str, float] = {}
        self.opened = self.generation = self.rebuilt = 0
        self._lock, self._judging = threading.RLock(), threading.Lock()
        self._shown: list[Shown] = []
        self._compared: list[tuple[Shown, Comparison]] = []
        self._saved: list[tuple[Version, str]] = []

    @property
    def model(self) -> DamperModel:
        """The model that is worked on.

        Raises:
            InputError: while nothing is open.
        """
        return self._now().step.model

    @property
    def here(self) -> Stage:
        """What is open, with the mends of the version on view.

        Raises:
            InputError: while nothing is open.
        """
        now = self._now()
        return self.stage.mended(now.signals)

    def models(self) -> list[DamperModel]:
        """The models on view: the one that is worked on, the same as given where it was changed, the others."""
        given = [self.history.versions[0].step.model] if self.history and self.history.at else []
        return [self.model, *given, *self.others]

    def shown(self, model: DamperModel) -> Shown:
        """A model's forces over what is open; kept for the last few."""
        with self._lock:
            stage = self.here if model is self.model else self.stage
            for own in self._shown:
                if own.model is model and own.stage.signals == stage.signals:
                    return own
            own = shown(model, stage)
            self._shown = [*self._shown[1 - _KEPT :], own]
            return own

    def comparison(self, shown: Shown) -> Comparison:
        """Where a model fails; kept for the last few. Long recordings take seconds, in which the page is looked at."""
        with self._judging:
            for own, comparison in self._compared:
                if own is shown:
                    return comparison
            comparison = shown.comparison()
            self._compared = [*self._compared[1 - _KEPT :], (shown, comparison)]
            return comparison

    def open(self, choice: Choice, models: list[str]) -> None:
        """Reads recordings and models; what was open before stays until all is well."""
        if not models:
            raise InputError("choose a model to compare")

        def work(tell: Tell) -> None:
            stage = opened(self.folder, choice, tell)
            first, *others = (self._load(name, stage.damper) for name in models)
            tell(f"running {first.name}", 0.9)
            for measurement in (*stage.fit, *stage.unseen):
                usable(first, measurement)
            step = judged(stage.case(first), Deed("start"))
            views = [shown(model, stage) for model in (first, *others)]
            with self._lock:
                self.stage, self.others, self.diagnosis = stage, tuple(others), None
                self._shown, self._compared, self._saved = views, [], []
                self.opened += 1
                self.history = History((Version(step, stage.signals),))
                self._changed()

        self._start("opening", work)

    def _load(self, name: str, damper: str) -> DamperModel:
        inside = Path(name).suffix in (".yaml", ".yml")
        model = load_model(self.folder.existing(name) if inside else name, damper)
        return model

    def diagnose(self, mode: str) -> None:
        """Looks for what the model lacks."""
        case = self._case()

        def work(tell: Tell) -> None:
            found = run_apart(diagnose_case, (case, mode, os.cpu_count() or 1), tell)
            with self._lock:
                self.diagnosis = found
                self._changed()

        self._start("diagnosing", work)

    def improve(self, mode: str) -> None:
        """Adds all that is justified, one step after the other."""
        case = self._case()

        def work(tell: Tell) -> None:
            found = run_apart(improve_case, (case, mode, os.cpu_count() or 1), tell)
            with self._lock:
                for step in found.steps[1:]:
                    own = found.signals if step.action == "mend" else self._now().signals
                    self.history = self.history.then(Version(step, own))
                self.diagnosis = found.final
                self._changed()

        self._start("improving", work)

    def add(self, name: str) -> None:
        """Puts an effect in and identifies all free parameters together; a mend goes to the signal map instead."""
        effect = find_effect(name)
        self._now()
        element = element_for(effect, self.model, self.here.fit, self.diagnosis)
        if effect.mend is not None:
            self._mend(element, Deed("mend", name, effect.phenomenon))
            return
        model = self.model.with_effect(element)
        self._refit(model, Deed("add", name, effect.phenomenon or name))

    def refit(self) -> None:
        """Identifies the free parameters anew."""
        self._refit(self.model, Deed("refit"))

    def remove(self, label: str) -> None:
        """Takes an entry out of the model."""
        self._then_judged(self.model.without(label), Deed("prune", label))

    def set(self, address: str, value: float) -> None:
        """Gives a parameter a value, by hand."""
        slot = next((slot for slot in self.model.slots if slot.address == address), None)
        if slot is None:
            raise InputError(f"{address}: the model has no such parameter any longer")
        low, high = slot.parameter.lower, slot.parameter.upper
        if not low <= value <= high:
            raise InputError(f"{address}: {value:g} is outside {low:g} to {high:g} {slot.parameter.unit}")
        if value != slot.value:
            model = replace(self.model.with_values({address: value}), fixed=self.model.fixed)
            self._then_judged(model, Deed("set", address, address), rebuilt=False)

    def fix(self, addresses: list[str]) -> None:
        """The parameters that identification leaves alone; no step of its own."""
        now = self._now()
        model = replace(now.step.model, fixed=tuple(addresses))
        with self._lock:
            self.history = self.history.instead(replace(now, step=replace(now.step, model=model)))
            self._changed(rebuilt=False)

    def undo(self) -> None:
        """One step back."""
        self._now()
        with self._lock:
            self.history = self.history.undone()
            self._changed()

    def redo(self) -> None:
        """One step forth."""
        self._now()
        with self._lock:
            self.history = self.history.redone()
            self._changed()

    def saved(self, name: str) -> None:
        """The model on view was written to a file of the folder."""
        with self._lock:
            self._saved = [*((own, file) for own, file in self._saved if file != name), (self._now(), name)]
            self._changed(rebuilt=False)

    def saved_as(self, version: Version) -> str:
        """The file that a version's model was written to last; "" where there is none."""
        return next((file for own, file in reversed(self._saved) if own is version), "")

    def rest(self) -> None:
        """Ends the work that goes on."""
        if self.job is not None:
            self.job.cancel()

    def close(self) -> None:
        """Ends the work that goes on and lets go of all that was read."""
        self.rest()
        self.stage, self.history, self.diagnosis = None, None, None
        self._shown, self._compared, self._saved = [], [], []

    def _case(self) -> Case:
        return self.here.case(self.model)

    def _refit(self, model: DamperModel, deed: Deed) -> None:
        now, stage = self._now(), self.here

        def work(tell: Tell) -> None:
            step = run_apart(refitted, (stage.case(model), deed), tell)
            self._then(Version(step, now.signals))

        self._start("identifying", work)

    def _mend(self, element: Element, deed: Deed) -> None:
        now, case = self._now(), self._case()

        def work(tell: Tell) -> None:
            own = run_apart(identified_alone, (case, element), tell)
            signals = mended_signals(now.signals, own)
            stage = self.stage.mended(signals)
            self._then(Version(judged(stage.case(case.model), deed), signals))

        self._start("identifying", work)

    def _then_judged(self, model: DamperModel, deed: Deed, rebuilt: bool = True) -> None:
        stage = self.here
        self._then(Version(judged(stage.case(model), deed), self._now().signals), rebuilt)

    def _then(self, version: Version, rebuilt: bool = True) -> None:
        with self._lock:
            self.history = self.history.then(version)
            self._changed(rebuilt)

    def _now(self) -> Version:
        if self.history is None:
            raise InputError("nothing is open yet: choose a recording and a model, then open them")
        return self.history.now

    def _start(self, name: str, work: Callable[[Tell], None]) -> None:
        with self._lock:
            if self.job is not None and self.job.running:
                raise InputError(f"{self.job.name} goes on; cancel it first, or wait")
            self.job = Job(name, work, self.job.number + 1 if self.job else 1)

    def _changed(self, rebuilt: bool = True) -> None:
        self.generation += 1
        if rebuilt:
            self.rebuilt += 1
            self.centres = {slot.address: slot.value for slot in self.model.slots}
