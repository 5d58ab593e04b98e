"""What can be saved, and how it is written: to a temporary file first, then moved into place."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from damper_estimator.codegen import find_compiler
from damper_estimator.errors import InputError
from damper_estimator.files import write_text
from damper_estimator.model import save_model
from damper_estimator.numbers import number
from damper_estimator.report import (
    Story,
    comparison_page,
    damper_section,
    diagnosis_page,
    diagnosis_section,
    story_page,
)
from damper_estimator.report.diagnosis_wording import step_name
from damper_estimator.signals import save_signal_map
from damper_estimator.studio.session import Session

_NO_BINARY = "sources only: a binary needs a C compiler (cc, gcc or clang), and the studio's machine has none"


@dataclass(frozen=True)
class Kind:
    """A kind of file.

    Attributes:
        label: for people.
        stem, suffix: of the name that is proposed.
        write: writes it from a session to a path, and says what was written.
        further: suffixes of further files of the same name that it writes.
    """

    label: str
    stem: str
    suffix: str
    write: Callable[[Session, Path], str]
    further: tuple[str, ...] = ()


def save(session: Session, kind: str, name: str, replace: bool) -> str:
    """Writes a file of a kind into the session's folder, and says what was written.

    Raises:
        InputError: for a name outside of the folder, a kind that does not exist, and what cannot be written.
        Taken: where there is a file of that name and it was not agreed to ``replace`` it.
    """
    if kind not in KINDS:
        raise InputError("choose what to save")
    chosen = KINDS[kind]
    target = session.folder.target(name, chosen.suffix, replace)
    for suffix in chosen.further:
        session.folder.target(str(Path(name).with_suffix(suffix)), suffix, replace)
    return chosen.write(session, target)


def _model(session: Session, path: Path) -> str:
    save_model(session.model, path)
    session.saved(str(path.relative_to(session.folder.root)))
    return _step(session)


def _step(session: Session) -> str:
    history = session.history
    return f"step {history.at}: {step_name(history.now.step)}, {number(history.now.step.rmse_unseen_n)} N unseen"


def _map(session: Session, path: Path) -> str:
    save_signal_map(session.here.signal_map, path)
    return f"the signal map of {session.stage.damper}"


def _comparison(session: Session, path: Path) -> str:
    compared = [session.comparison(session.shown(model)) for model in session.models()]
    names = ", ".join(session.stage.names)
    write_text(path, comparison_page([damper_section(compared)], f"{session.model.name} against {names}"))
    return f"the comparison of {len(compared)} models" if len(compared) > 1 else "the comparison"


def _diagnosis(session: Session, path: Path) -> str:
    if session.diagnosis is None:
        raise InputError("there is no diagnosis yet: run one under What is missing")
    section = diagnosis_section(session.stage.damper, session.diagnosis)
    names = ", ".join(session.stage.names)
    write_text(path, diagnosis_page([section], f"what {session.diagnosis.model.name} lacks on {names}"))
    return "the diagnosis"


def _report(session: Session, path: Path) -> str:
    history, stage = session.history, session.stage
    models = (history.versions[0].step.model, session.model)
    before, after = (session.comparison(session.shown(model)) for model in models)
    steps, notes = [version.step for version in history.done], [*filter(None, [stage.note]), *stage.warnings]
    left_out = sum(stop - start for _, start, stop in stage.choice.left_out)
    if left_out:
        notes.append(f"{left_out:.3g} s of the recordings were left out of fits and errors.")
    if session.diagnosed:
        notes.append(f"The diagnosis is of the marked {session.diagnosed} alone.")
    story = Story(stage.damper, before, after, steps, session.diagnosis, notes)
    write_text(path, story_page(story, f"{session.model.name} on {', '.join(stage.names)}"))
    count = "one step" if len(steps) == 2 else f"{len(steps) - 1} steps"
    return f"the report of {count}" + ("" if session.diagnosis else ", without a diagnosis")


def _c(session: Session, path: Path) -> str:
    made = session.model.to_c(path.parent, name=path.stem, signals=session.here.signal_map, damper=session.stage.damper)
    inverse = f"no inverse: {made.without_inverse}" if made.without_inverse else "with the inverse"
    return f"and {made.header.name}; {_step(session)}; {made.ram} bytes of state; {inverse}"


def _fmu(version: str) -> Callable[[Session, Path], str]:
    def write(session: Session, path: Path) -> str:
        binary, damper = find_compiler() is not None, session.stage.damper
        session.model.to_fmu(path, version=version, binary=binary, signals=session.here.signal_map, damper=damper)
        inside = "sources and a binary for this platform" if binary else _NO_BINARY
        return f"FMI {version}, {_step(session)}; {inside}"

    return write


KINDS = {
    "model": Kind("model", "model", ".yaml", _model),
    "map": Kind("signal map", "map", ".yaml", _map),
    "report": Kind("report: the whole story", "report", ".html", _report),
    "comparison": Kind("report: comparison", "comparison", ".html", _comparison),
    "diagnosis": Kind("report: diagnosis", "diagnosis", ".html", _diagnosis),
    "c": Kind("C99 for a controller", "damper", ".c", _c, (".h",)),
    "fmu2": Kind("FMU, FMI 2.0", "damper", ".fmu", _fmu("2.0")),
    "fmu3": Kind("FMU, FMI 3.0", "damper", ".fmu", _fmu("3.0")),
}
