"""Text files of people and loggers."""

import gzip
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from damper_estimator.errors import InputError
from damper_estimator.recordings.bench_table import file_content
from damper_estimator.recordings.column_map import TextFormat
from damper_estimator.recordings.text_table import TextTable

PATH = Path("bench.csv")
VALUES = np.array([[0.0, 1.5, -200.25], [0.1, -2.5, 300.0], [0.2, 3.0, 1e-3]])
TITLES = ["Time", "Position", "Load"]
SEPARATORS = {"comma": ",", "semicolon": ";", "tab": "\t", "spaces": "   ", "comma_space": ",  "}


def table(text: str | bytes, needed=("Position", "Load"), named=(), **known) -> TextTable:
    content = text if isinstance(text, bytes) else text.encode()
    return TextTable(PATH, content, TextFormat(**known), needed, named)


def rows(separator: str = ",", decimal: str = ".", titles=TITLES, end: str = "\n", tail: str = "") -> str:
    lines = [separator.join(titles) + tail] if titles else []
    lines += [separator.join(f"{value:g}".replace(".", decimal) for value in row) + tail for row in VALUES]
    return end.join(lines) + end


@pytest.mark.parametrize("separator", SEPARATORS.values(), ids=SEPARATORS.keys())
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"], ids=["lf", "crlf", "cr"])
def test_separator_and_line_ends_are_found(separator, end):
    read = table(rows(separator, end=end))
    assert read.numbers("Position").tolist() == VALUES[:, 1].tolist()
    assert read.numbers("Load").tolist() == VALUES[:, 2].tolist()


@pytest.mark.parametrize("separator", [";", "\t", " "])
def test_decimal_commas_are_found(separator):
    assert table(rows(separator, ",")).numbers("Load").tolist() == VALUES[:, 2].tolist()


@given(
    st.lists(st.lists(st.floats(-1e9, 1e9), min_size=3, max_size=3), min_size=1, max_size=30),
    st.sampled_from([(",", "."), (";", ","), (";", "."), ("\t", ","), (" ", ".")]),
    st.integers(0, 5),
)
@settings(max_examples=60, deadline=None)
def test_numbers_survive_any_layout(values, layout, comments):
    separator, decimal = layout
    lines = [f"Line {number} of: comments" for number in range(comments)] + [separator.join(TITLES)]
    lines += [separator.join(repr(value).replace(".", decimal) for value in row) for row in values]
    known = {"separator": separator, "decimal": decimal}
    read = table("\n".join(lines), needed=("Time", "Position", "Load"), **known)
    assert np.column_stack([read.numbers(title) for title in TITLES]).tolist() == values


def test_header_lines_titles_and_a_row_of_units_are_skipped():
    text = "Rig 7\nSampling Rate:  1000\nOperator, somebody, else\n\n" + rows().replace("Load\n", "Load\ns,mm,kN\n\n")
    read = table(text)
    assert read.rows == 3
    assert read.header_number("sampling rate") == 1000.0


def test_columns_by_number_need_no_titles():
    assert table(rows(titles=None), needed=(3, 1)).numbers(3).tolist() == VALUES[:, 2].tolist()
    assert table("made by rig\n" + rows(titles=None), needed=(2,)).rows == 3


def test_trailing_separators_and_empty_lines_add_nothing():
    read = table(rows(tail=",,") + ",,,,\n\n  \n")
    assert read.rows == 3 and np.isfinite(read.numbers("Load")).all()


@pytest.mark.parametrize("title", ["Position", "position", "Position [mm]", '"Position"', "# Position"])
def test_titles_are_found_without_unit_quotes_and_case(title):
    text = rows(titles=["Position [mm]", "Load (kN)", "x"])
    assert table(text, needed=(title, "load")).numbers(title).tolist() == VALUES[:, 0].tolist()


def test_quoted_cells_can_contain_the_separator():
    text = 'Time,"Load, upper",Note\n0,1.5,"a, b"\n1,2.5,""\n'
    read = table(text, needed=("Load, upper",), named=("Note",))
    assert read.numbers("Load, upper").tolist() == [1.5, 2.5]
    assert read.texts("Note") == ["a, b", ""]


def test_rows_that_end_early_and_words_between_numbers_are_not_numbers():
    read = table("Position,Load,Event\n1,2\n3\noverflow,4,Pause\n5,6,Resume\n", named=("Event",))
    assert np.isnan(read.numbers("Position")).tolist() == [False, False, True, False]
    assert np.isnan(read.numbers("Load")).tolist() == [False, True, False, False]
    assert read.texts("Event") == ["", "", "Pause", "Resume"]


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "cp1252"])
def test_encodings_are_found(encoding):
    text = rows(titles=["Öltemperatur °C", "Weg µm", "Load"])
    assert table(text.encode(encoding), needed=("Weg µm",)).numbers("Weg µm").tolist() == VALUES[:, 1].tolist()


def test_gzip_is_unpacked_by_content(tmp_path):
    path = tmp_path / "bench.csv"
    path.write_bytes(gzip.compress(rows().encode()))
    assert table(file_content(path)).rows == 3
    path.write_bytes(gzip.compress(rows().encode())[:-9])
    with pytest.raises(InputError, match="bench.csv: damaged"):
        file_content(path)


@pytest.mark.parametrize("content", [b"", b"\n \r\n", gzip.compress(b"", mtime=0)])
def test_an_empty_file_is_reported(tmp_path, content):
    (tmp_path / "bench.csv").write_bytes(content)
    with pytest.raises(InputError, match="bench.csv: empty; export or copy it again"):
        file_content(tmp_path / "bench.csv")


def test_a_missing_column_is_answered_with_the_titles():
    with pytest.raises(InputError, match="has no column 'Force'; there are: Time, Position, Load"):
        table(rows(), needed=("Position", "Force"))
    with pytest.raises(InputError, match="has no column 'Force'; there are: Time, Position, Load"):
        table("rig 7\n" + rows(), needed=("Force",))
    with pytest.raises(InputError, match="has no column 9; there are 3"):
        table(rows(), needed=(9,))


def test_two_columns_of_one_title_are_not_guessed():
    with pytest.raises(InputError, match="several columns are titled 'Load'; give the column's number"):
        table(rows(titles=["Load", "Position", "Load"]))


def test_titles_without_rows_are_refused():
    with pytest.raises(InputError, match="has no rows of numbers"):
        table("Position,Load\n")


def test_a_quote_that_never_closes_is_refused():
    with pytest.raises(InputError, match="a quote that is not closed"):
        table('Position,Load\n1,"2\n' + "1,2\n" * 50_000)


def test_a_header_without_the_rate_is_refused():
    with pytest.raises(InputError, match="no header line begins with 'sampling rate' and contains a number"):
        table("Sampling Rate: fast\n" + rows()).header_number("Sampling Rate")


@pytest.mark.parametrize(
    ("cells", "resolution"), [(["0.0000", "0.0003"], 1e-4), (["1", "2"], 1.0), (["1e-3", "2e-3"], 0.0)]
)
def test_the_notation_determines_the_resolution(cells, resolution):
    read = table("Position;Load\n" + "\n".join(f"{cell};0" for cell in cells))
    assert read.resolution("Position") == pytest.approx(resolution)
