"""What can be saved, and how it is written: beside its place first, then moved into it."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from damper_estimator.errors import InputError
from damper_estimator.files import write_text
from damper_estimator.model import save_model
from damper_estimator.report import comparison_page, damper_section, diagnosis_page, diagnosis_section
from damper_estimator.signals import save_signal_map
from damper_estimator.studio.session import Session


@dataclass(frozen=True)
class Kind:
    """A kind of file: its suffix, and what writes it from a session to a path."""

    suffix: str
    write: Callable[[Session, Path], None]


def _model(session: Session, path: Path) -> None:
    save_model(session.model, path)


def _map(session: Session, path: Path) -> None:
    save_signal_map(session.here.signal_map, path)


def _comparison(session: Session, path: Path) -> None:
    compared = [session.comparison(session.shown(model)) for model in session.models()]
    names = ", ".join(session.stage.names)
    write_text(path, comparison_page([damper_section(compared)], f"{session.model.name} against {names}"))


def _diagnosis(session: Session, path: Path) -> None:
    if session.diagnosis is None:
        raise InputError("there is no diagnosis yet: run one under What is missing")
    section = diagnosis_section(session.stage.damper, session.diagnosis)
    names = ", ".join(session.stage.names)
    write_text(path, diagnosis_page([section], f"what {session.diagnosis.model.name} lacks on {names}"))


KINDS = {
    "model": Kind(".yaml", _model),
    "map": Kind(".yaml", _map),
    "comparison": Kind(".html", _comparison),
    "diagnosis": Kind(".html", _diagnosis),
}
