"""Writes a session to its file after every change."""

from collections.abc import Sequence

from damper_estimator.errors import InputError
from damper_estimator.studio.history import History, Version
from damper_estimator.studio.session_files import SessionFiles, Stamp, session_record, step_record
from damper_estimator.studio.stage import Stage


class SessionWriter:
    """Writes a session after every change; final.

    Attributes:
        name: of the file; "" before the first step.
        failed: why it could not be written, else "".
    """

    def __init__(self, files: SessionFiles, owner: str) -> None:
        self.name, self.failed = "", ""
        self._files, self._owner, self._stamp = files, owner, None
        self._records: list[tuple[Version, dict[str, object]]] = []  # made once for each step

    @property
    def file(self) -> tuple[str, Stamp]:
        """Name and stamp of the file, with which ``begin`` continues it later."""
        return self.name, self._stamp

    def begin(self, name: str = "", stamp: Stamp = None) -> None:
        """Another session: its first change creates a file, or continues the one it was read from."""
        self.name, self._stamp, self.failed, self._records = name, stamp, "", []

    def write(
        self, stage: Stage, models: Sequence[str], history: History, saved: Sequence[tuple[Version, str]]
    ) -> None:
        """Writes all steps; ``saved`` are the versions that are in a model file, and the file's name."""
        self._records = [(version, self._record(stage, version)) for version in history.versions]
        files = {id(version): name for version, name in saved}
        steps = [record | {"saved": files.get(id(version), "")} for version, record in self._records]
        try:
            record = session_record(stage, models, history.at, steps, self._owner)
            self.name, self._stamp = self._files.write(self.name, self._stamp, record)
            self.failed = ""
        except (InputError, OSError) as error:
            self.failed = f"The steps of this page are not saved: {error}"

    def _record(self, stage: Stage, version: Version) -> dict[str, object]:
        return next((record for recorded, record in self._records if recorded is version), None) or step_record(
            stage, version
        )
