"""Base class of all results: a mapping by damper with text, table, figure and file output."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, Self, TypeVar

from damper_estimator.errors import InputError
from damper_estimator.files import json_text, write_text
from damper_estimator.workflows.tables import data_frame, html_table

if TYPE_CHECKING:
    import pandas
    from plotly.graph_objects import Figure

DamperResult = TypeVar("DamperResult")


@dataclass(frozen=True, repr=False, eq=False)
class Results(Mapping[str, "Results[DamperResult]"], Generic[DamperResult]):
    """Results of a use case: a mapping from each damper to its own results. Abstract.

    Properties of a damper's result are available if there is a single damper.

    Attributes:
        request: the inputs, for JSON: ``bags``, ``model``, ...
        by_damper: the result of each damper.
    """

    request: Mapping[str, Any]
    by_damper: Mapping[str, DamperResult]

    def __getitem__(self, damper: str) -> Self:
        return replace(self, by_damper={damper: self.by_damper[damper]})

    def __iter__(self) -> Iterator[str]:
        return iter(self.by_damper)

    def __len__(self) -> int:
        return len(self.by_damper)

    @property
    def only(self) -> DamperResult:
        """The result of a single damper.

        Raises:
            InputError: if there are several.
        """
        if len(self.by_damper) != 1:
            first = next(iter(self.by_damper), "NAME")
            raise InputError(f"the results are of dampers {', '.join(self.by_damper)}; select one: result[{first!r}]")
        return next(iter(self.by_damper.values()))

    def to_dict(self) -> dict[str, object]:
        """The content of the command line's ``--json`` file: the inputs, and ``dampers`` by name."""
        return {**self.request, "dampers": {damper: self._record(result) for damper, result in self.by_damper.items()}}

    def to_dataframe(self) -> pandas.DataFrame:
        """The results of all dampers as a table.

        Raises:
            InputError: if pandas is not installed.
        """
        return data_frame(
            [{"damper": damper, **row} for damper, result in self.by_damper.items() for row in self._rows(result)]
        )

    def figure(self, damper: str | None = None) -> Figure:
        """A Plotly figure of one damper; ``damper`` is required if there are several.

        Raises:
            InputError: if there are several and none is named, or the name is unknown.
        """
        from damper_estimator.report import plotly_figure

        return plotly_figure(self._figure(self._of(damper)))

    def _of(self, damper: str | None) -> DamperResult:
        """The result of one damper, of the only one without a name.

        Raises:
            InputError: as ``figure``.
        """
        if damper is not None and damper not in self.by_damper:
            raise InputError(f"no result of damper {damper!r}; the results are of {', '.join(self.by_damper)}")
        return self.only if damper is None else self.by_damper[damper]

    def save(self, path: str | Path) -> Path:
        """Writes the result: ``.json`` as in ``to_dict``, ``.html`` the page that opens without a network.

        Raises:
            InputError: for another file extension, and if it cannot be written.
        """
        path = Path(path)
        if path.suffix == ".json":
            write_text(path, json_text(self.to_dict()))
        elif path.suffix == ".html" and self._has_page():
            write_text(path, self.page())
        else:
            endings = ".json or .html" if self._has_page() else ".json"
            raise InputError(f"{path}: cannot hold this result; choose a name ending in {endings}")
        return path

    def page(self) -> str:
        """The result as one self-contained HTML page, if this kind of result has one."""
        raise NotImplementedError

    def __repr__(self) -> str:
        lines = "; ".join(f"{damper}: {self._line(result)}" for damper, result in self.by_damper.items())
        return f"{type(self).__name__}({lines})"

    def _repr_html_(self) -> str:
        rows = [
            [damper, *(_cell(value) for value in row.values())]
            for damper, result in self.by_damper.items()
            for row in self._rows(result)
        ]
        first = next((row for result in self.by_damper.values() for row in self._rows(result)), {})
        return html_table(self._title(), ("damper", *first), rows)

    def _has_page(self) -> bool:
        return type(self).page is not Results.page

    def _title(self) -> str:
        """Title of the table."""
        return repr(self)

    @abstractmethod
    def _record(self, result: DamperResult) -> dict[str, object]:
        """One damper for JSON."""

    @abstractmethod
    def _line(self, result: DamperResult) -> str:
        """One damper in a few words."""

    @abstractmethod
    def _rows(self, result: DamperResult) -> Sequence[Mapping[str, object]]:
        """One damper as rows of a table, all with the same columns."""

    @abstractmethod
    def _figure(self, result: DamperResult) -> Mapping[str, object]:
        """One damper as a figure of the report."""


def _cell(value: object) -> str:
    if isinstance(value, float):
        return f"{value:.4g}"
    return "" if value is None else str(value)
