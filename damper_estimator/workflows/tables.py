"""Results as tables: short HTML for notebooks, and data frames where pandas is installed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from typing import TYPE_CHECKING

import numpy as np

from damper_estimator.errors import InputError
from damper_estimator.signals import Measurement

if TYPE_CHECKING:
    import pandas

_MOST_ROWS = 12  # shown in a notebook


def html_table(title: str, head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A small table as HTML; texts are escaped, long tables truncated.

    Args:
        title: of the table.
        head, rows: plain texts.
    """
    shown = [_row("td", row) for row in rows[:_MOST_ROWS]]
    more = len(rows) - len(shown)
    note = f"<p>and {more} more; see to_dict()</p>" if more else ""
    return (
        f"<div><p><b>{escape(title)}</b></p><table><thead>{_row('th', head)}</thead>"
        f"<tbody>{''.join(shown)}</tbody></table>{note}</div>"
    )


def _row(cell: str, texts: Sequence[str]) -> str:
    return f"<tr>{''.join(f'<{cell}>{escape(text)}</{cell}>' for text in texts)}</tr>"


def data_frame(rows: Sequence[Mapping[str, object]] | Mapping[str, np.ndarray]) -> pandas.DataFrame:
    """A data frame of rows, or of columns.

    Raises:
        InputError: if pandas is not installed.
    """
    try:
        import pandas
    except ModuleNotFoundError as error:
        raise InputError("to_dataframe needs pandas, which is not installed: pip install pandas") from error
    return pandas.DataFrame(rows)


def sample_table(measurements: Sequence[Measurement]) -> pandas.DataFrame:
    """Filtered samples of one damper, a row each; ``force`` in N is NaN if none was measured.

    Raises:
        InputError: if pandas is not installed.
    """
    columns: dict[str, list[np.ndarray]] = {}
    for measurement in measurements:
        k = measurement.kinematics
        force = np.full(len(k), np.nan) if measurement.force is None else measurement.force
        values = {
            "recording": np.full(len(k), measurement.recording), "stamp_ns": k.stamp, "time": k.time,
            "displacement": k.displacement, "velocity": k.velocity, "acceleration": k.acceleration,
            "command": k.command, "temperature": k.temperature, "pressure": k.pressure, "force": force,
            "judged": measurement.judged,
        }  # fmt: skip
        for name, column in values.items():
            columns.setdefault(name, []).append(column)
    return data_frame({name: np.concatenate(parts) for name, parts in columns.items()})
