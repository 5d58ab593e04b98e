"""What one page works on: recordings, models side by side, the steps of the first of them, a diagnosis, a job."""

import os
from dataclasses import replace

from damper_estimator.diagnosis import corrected_signals
from damper_estimator.effects.discovery import find_effect
from damper_estimator.errors import InputError
from damper_estimator.model import DamperModel, Element, save_model
from damper_estimator.studio.corners import TASKS, Corner, Task, place, worked_on
from damper_estimator.studio.effect_entry import element_for
from damper_estimator.studio.history import History, Version
from damper_estimator.studio.long_tasks import (
    Case,
    Change,
    diagnose_case,
    identified_alone,
    improve_case,
    judged,
    refitted,
)
from damper_estimator.studio.marking import in_words, marked_alone, parted, stretches
from damper_estimator.studio.opening import Opened, read_choice, read_session_file
from damper_estimator.studio.page_state import OtherDamper, PageState
from damper_estimator.studio.session_files import SavedSession, SessionFiles, Stamp
from damper_estimator.studio.session_writer import SessionWriter
from damper_estimator.studio.stage import Choice
from damper_estimator.studio.view import View
from damper_estimator.studio.worker_process import Progress, run_in_process

_MOST_LEFT_OUT = 2000  # stretches


class Session(PageState):
    """One page; final. Its verbs raise InputError where something cannot be done."""

    def open(self, choice: Choice, models: list[str]) -> None:
        """Reads recordings and models; what was open before stays until all is well."""
        if not models:
            raise InputError("choose a model to compare")
        self.start("opening", lambda progress: self._take(read_choice(self.folder, choice, models, progress)))

    def resume(self, name: str, step: int | None = None, alone: bool = True) -> SavedSession:
        """Opens a session from its file, at a step of it; the tab that wrote it goes on in that file.

        Args:
            alone: whether no other page has it open; a page that is not alone writes to a file of its own.

        Raises:
            InputError: where there is no such file, or it is damaged.
        """
        kept = SessionFiles(self.folder).read(name)
        file = (name, kept.stamp) if alone and kept.owner == self.owner else ("", None)
        self.start(
            "opening", lambda progress: self._take(read_session_file(self.folder, name, kept, step, progress), *file)
        )
        return kept

    def work_on_all(self, kind: str, mode: str) -> None:
        """Compares, diagnoses or improves all dampers of the recordings in one go; ``kind`` is a key of ``TASKS``."""
        if kind not in TASKS:
            raise InputError("choose what to do with all dampers")
        self._now()

        def work(progress: Progress) -> None:
            self._worked_on_all(kind, mode, progress)

        self.start(TASKS[kind], work)

    def open_and_diagnose(self, recording: str, model: str, mode: str) -> None:
        """Opens a recording and diagnoses all its dampers in one go."""

        def work(progress: Progress) -> None:
            self._take(read_choice(self.folder, Choice((recording,)), [model], progress))
            self._worked_on_all("diagnose", mode, progress)

        self.start(TASKS["diagnose"], work)

    def _worked_on_all(self, kind: str, mode: str, progress: Progress) -> None:
        histories, workers = self.histories(), os.cpu_count() or 1
        choices = {name: self.choice_of(name) for name in sorted(self.stage.signal_map.dampers, key=place)}
        task = Task(self.folder.root, choices, self.names[0], kind, mode, workers, histories)
        corners = run_in_process(worked_on, (task,), progress)
        with self._lock:
            for corner in corners:
                self._further(corner, histories.get(corner.damper))
            self.corners = {corner.damper: corner for corner in corners}
            self._changed()

    def open_damper(self, damper: str) -> None:
        """Opens another damper of the same recordings, with the steps that were made on it."""
        self._now()
        if damper not in self.corners:
            raise InputError(f"{str(damper)[:60]}: is not a damper of these recordings")
        if damper == self.stage.damper:
            return
        choice, corner = self.choice_of(damper), self.corners[damper]
        if corner.failed:
            raise InputError(corner.failed)
        left, came = self.stage.damper, self.other_dampers.get(damper)

        def work(progress: Progress) -> None:
            given = read_choice(self.folder, choice, self.names, progress, came.history if came else None)
            with self._lock:
                left_out = self.stage.choice.left_out
                self.other_dampers[left] = OtherDamper(self.history, tuple(self._saved), self.writer.file, left_out)
                self._take(replace(given, saved=came.saved if came else ()), *(came.file if came else ()), same=True)
                if corner.history is not None and len(corner.history.versions) == len(given.history.versions):
                    self.diagnosis = corner.diagnosis

        self.start("opening", work)

    def save_all(self) -> str:
        """Writes the model of every damper into a folder that verbs take as a model, and says where."""
        self._now()
        taken = next(n for n in range(1, 1000) if not self.folder.path(_improved(n)).exists())
        for damper, history in self.histories().items():
            name = f"{_improved(taken)}/{damper}.yaml"
            save_model(history.now.step.model, self.folder.target(name, ".yaml", False))
        count = len(self.histories())
        return f"saved {count} models in {_improved(taken)}; give that folder as the model on the command line"

    def _further(self, corner: Corner, before: History | None) -> None:
        """Takes over the steps that were made on a damper."""
        if corner.history is None or corner.stage is None:
            return
        history = before or corner.history
        for version in corner.history.versions[history.at + 1 :]:
            history = history.then(version)
        if corner.damper == self.stage.damper:
            self.history = history
            self.diagnosis = corner.diagnosis or self.diagnosis
            return
        other = self.other_dampers.get(corner.damper, OtherDamper(history))
        if history is not other.history or history.at:
            writer = SessionWriter(SessionFiles(self.folder), self.owner)
            writer.begin(*other.file)
            writer.write(corner.stage, self.names, history, other.saved)
            other = replace(other, history=history, file=writer.file)
        self.other_dampers[corner.damper] = other

    def _take(self, given: Opened, file: str = "", stamp: Stamp = None, same: bool = False) -> None:
        """Puts what was read on view; with ``same`` it is another damper of the same recordings."""
        with self._lock:
            if not same:
                self.corners, self.other_dampers = {}, {}
            self.stage, self.history, self.others, self.names = given.stage, given.history, given.others, given.names
            self.diagnosis, self.diagnosed = None, ""
            self._shown, self._compared, self._saved = list(given.views), [], list(given.saved)
            self.opened += 1
            self.writer.begin(file, stamp)
            self._changed(kept=False)

    def diagnose(self, mode: str) -> None:
        """Looks for what the model lacks."""
        self._diagnose(self._case(), mode, "")

    def diagnose_marked(self, view: View, mode: str) -> None:
        """The same in a marked region alone: parameters on the first 60 % of its samples, judged on the others."""
        run = self.shown(self.model)
        fit, unseen = parted(marked_alone(run, view))
        case = replace(self._case(), fit=(fit,), unseen=(unseen,))
        self._diagnose(case, mode, in_words(run, view))

    def _diagnose(self, case: Case, mode: str, of: str) -> None:

        def work(progress: Progress) -> None:
            found = run_in_process(diagnose_case, (case, mode, os.cpu_count() or 1), progress)
            with self._lock:
                self.diagnosis, self.diagnosed = found, of
                self._changed(kept=False)

        self.start("diagnosing", work)

    def improve(self, mode: str) -> None:
        """Adds all that is justified, one step after the other."""
        case = self._case()

        def work(progress: Progress) -> None:
            found = run_in_process(improve_case, (case, mode, os.cpu_count() or 1), progress)
            with self._lock:
                for step in found.steps[1:]:
                    signals = found.signals if step.action == "correct" else self._now().signals
                    self.history = self.history.then(Version(step, signals))
                self.diagnosis, self.diagnosed = found.final, ""
                self._changed()

        self.start("improving", work)

    def add(self, name: str) -> None:
        """Puts an effect in and identifies all free parameters together; a correction goes to the signal map."""
        effect = find_effect(name)
        self._now()
        element = element_for(effect, self.model, self.here.fit, self.diagnosis)
        if effect.correct is not None:
            self._correct(element, Change("correct", name, effect.phenomenon))
            return
        model = self.model.with_missing(element)
        self._refit(model, Change("add", name, effect.phenomenon or name))

    def refit(self) -> None:
        """Identifies the free parameters again."""
        self._refit(self.model, Change("refit"))

    def refit_marked(self, view: View) -> None:
        """Identifies the free parameters on a marked region alone; judged as all steps are."""
        run = self.shown(self.model)
        case = replace(self._case(), fit=(marked_alone(run, view),))
        self._refit(self.model, Change("refit", None, f"on the marked {in_words(run, view)}"), case)

    def leave_out(self, view: View) -> None:
        """Takes a marked region out of all that is fitted to and judged on."""
        more = stretches(self.shown(self.model), view)
        left_out = (*self.stage.choice.left_out, *more)
        if len(left_out) > _MOST_LEFT_OUT:
            raise InputError(f"more than {_MOST_LEFT_OUT} stretches would be left out; mark passages over time instead")
        stage = self.stage.without(left_out)
        self.start("judging", lambda progress: self._restaged(stage))

    def take_back(self) -> None:
        """Nothing is left out any longer."""
        self._now()
        stage = self.stage.without(())
        self.start("judging", lambda progress: self._restaged(stage))

    def remove(self, label: str) -> None:
        """Takes an entry out of the model."""
        self._then_judged(self.model.without(label), Change("prune", label))

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
            self._then_judged(model, Change("set", address, address), rebuilt=False)

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

    def _refit(self, model: DamperModel, change: Change, case: Case | None = None) -> None:
        now, case = self._now(), case or self.here.case(model)

        def work(progress: Progress) -> None:
            step = run_in_process(refitted, (case, change), progress)
            self._then(Version(step, now.signals))

        self.start("identifying", work)

    def _correct(self, element: Element, change: Change) -> None:
        now, case = self._now(), self._case()

        def work(progress: Progress) -> None:
            fitted = run_in_process(identified_alone, (case, element), progress)
            signals = corrected_signals(now.signals, fitted)
            stage = self.stage.corrected(signals)
            self._then(Version(judged(stage.case(case.model), change), signals))

        self.start("identifying", work)


def _improved(number: int) -> str:
    return "improved" if number == 1 else f"improved_{number}"
