"""What all results have in common: one entry for each damper, and how they show and save themselves."""

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

One = TypeVar("One")


@dataclass(frozen=True, repr=False, eq=False)
class Results(Mapping[str, "Results[One]"], Generic[One]):
    """Results of a use case: a mapping by damper, whose values are the results of that damper alone. Abstract.

    Attributes of one damper's result can be read where there is one damper.

    Attributes:
        asked: what was asked, for the record: ``bags``, ``model``, ...
        by_damper: what was found for each damper.
    """

    asked: Mapping[str, Any]
    by_damper: Mapping[str, One]

    def __getitem__(self, damper: str) -> Self:
        return replace(self, by_damper={damper: self.by_damper[damper]})

    def __iter__(self) -> Iterator[str]:
        return iter(self.by_damper)

    def __len__(self) -> int:
        return len(self.by_damper)

    @property
    def only(self) -> One:
        """What was found for the only damper.

        Raises:
            InputError: where there are several.
        """
        if len(self.by_damper) != 1:
            first = next(iter(self.by_damper), "NAME")
            raise InputError(
                f"there are results of dampers {', '.join(self.by_damper)}; choose one of them: result[{first!r}]"
            )
        return next(iter(self.by_damper.values()))

    def to_dict(self) -> dict[str, object]:
        """The record as the command line writes it with ``--json``: what was asked, and ``dampers`` by name."""
        return {**self.asked, "dampers": {damper: self._record(own) for damper, own in self.by_damper.items()}}

    def to_dataframe(self) -> pandas.DataFrame:
        """The table behind the result, all dampers in it.

        Raises:
            InputError: where pandas is not installed.
        """
        return data_frame(
            [{"damper": damper, **row} for damper, own in self.by_damper.items() for row in self._rows(own)]
        )

    def figure(self, damper: str | None = None) -> Figure:
        """A Plotly figure of one damper, the only one where none is named.

        Raises:
            InputError: where there are several and none is named, or there is none of that name.
        """
        from damper_estimator.report import plotly_figure

        if damper is not None and damper not in self.by_damper:
            raise InputError(f"there is no result of damper {damper!r}; there are {', '.join(self.by_damper)}")
        return plotly_figure(self._figure(self.only if damper is None else self.by_damper[damper]))

    def save(self, path: str | Path) -> Path:
        """Writes the result: ``.json`` is the record, ``.html`` the page that opens without a network.

        Raises:
            InputError: for another ending, and where it cannot be written.
        """
        path = Path(path)
        if path.suffix == ".json":
            write_text(path, json_text(self.to_dict()))
        elif path.suffix == ".html" and self._has_page():
            write_text(path, self.page())
        else:
            endings = ".json or .html" if self._has_page() else ".json"
            raise InputError(f"{path}: cannot hold this result; give a name that ends in {endings}")
        return path

    def page(self) -> str:
        """The result as one self-contained HTML page, where there is one for it."""
        raise NotImplementedError

    def __repr__(self) -> str:
        told = "; ".join(f"{damper}: {self._line(own)}" for damper, own in self.by_damper.items())
        return f"{type(self).__name__}({told})"

    def _repr_html_(self) -> str:
        rows = [
            [damper, *(_cell(value) for value in row.values())]
            for damper, own in self.by_damper.items()
            for row in self._rows(own)
        ]
        first = next((row for own in self.by_damper.values() for row in self._rows(own)), {})
        return html_table(self._title(), ("damper", *first), rows)

    def _has_page(self) -> bool:
        return type(self).page is not Results.page

    def _title(self) -> str:
        """What stands above the table."""
        return repr(self)

    @abstractmethod
    def _record(self, own: One) -> dict[str, object]:
        """One damper for JSON."""

    @abstractmethod
    def _line(self, own: One) -> str:
        """One damper in a few words."""

    @abstractmethod
    def _rows(self, own: One) -> Sequence[Mapping[str, object]]:
        """One damper as rows of a table, all with the same columns."""

    @abstractmethod
    def _figure(self, own: One) -> Mapping[str, object]:
        """One damper as a figure of the report."""


def _cell(value: object) -> str:
    if isinstance(value, float):
        return f"{value:.4g}"
    return "" if value is None else str(value)
