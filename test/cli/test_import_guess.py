"""``import --guess``: a map and a page next to the output; doubtful guesses are not imported."""

import numpy as np
import pytest

from damper_estimator.cli.main import main
from damper_estimator.recordings import load_column_maps


@pytest.fixture
def bench(tmp_path):
    """Two files: one with titles and units, one without units."""
    t = np.arange(0.0, 4.0, 2e-3)
    x = 0.03 * np.sin(9.0 * t)
    v = np.gradient(x, t)
    f = 1500.0 * v + 40.0 * np.tanh(v / 0.02) - 150.0
    body = "\n".join(f"{a:.4f};{1e3 * b:.5f};{c:.3f}".replace(".", ",") for a, b, c in zip(t, x, f, strict=True))
    (tmp_path / "good.csv").write_text(f"Zeit [s];Weg [mm];Kraft [N]\n{body}\n")
    (tmp_path / "bare.csv").write_text(f"t;x;F\n{body}\n")
    return tmp_path


def test_a_file_that_tells_everything_is_imported(bench, capsys):
    assert main(["import", str(bench / "good.csv"), "--guess", "-o", str(bench / "out")]) == 0
    output = capsys.readouterr().out
    assert (
        "Weg [mm]: damper displacement in mm" in output and "assumed: displacement is positive in extension" in output
    )
    assert sorted(path.name for path in (bench / "out").iterdir()) == [
        "good.mcap",
        "good_columns.yaml",
        "good_preview.html",
    ]
    page = (bench / "out" / "good_preview.html").read_text()
    assert (
        "Kraft [N]" in page
        and "velocity in m/s" in page
        and "both positive in extension" in page
        and "<script src" not in page
    )
    again = ["import", str(bench / "good.csv"), "--columns", str(bench / "out" / "good_columns.yaml"), "-o"]
    assert main([*again, str(bench / "again.mcap")]) == 0
    assert (bench / "again.mcap").read_bytes() == (bench / "out" / "good.mcap").read_bytes()


def test_what_is_in_doubt_is_said_in_one_line_and_not_imported(bench, capsys):
    words = ["import", str(bench / "good.csv"), str(bench / "bare.csv"), "--guess", "-o", str(bench / "out")]
    assert main(words) == 1
    output = capsys.readouterr().err.strip().splitlines()
    assert "the unit of 'x' (displacement) is not named" in output[-1] and "bare_columns.yaml" in output[-1]
    assert not list((bench / "out").glob("*.mcap"))
    text = (bench / "out" / "bare_columns.yaml").read_text()
    assert "# IN DOUBT: the unit of 'F' (force)" in text and load_column_maps(bench / "out" / "bare_columns.yaml")
    corrected = text.replace("unit: m}", "unit: mm}")
    assert corrected != text
    (bench / "mine.yaml").write_text(corrected)
    assert (
        main(["import", str(bench / "bare.csv"), "--columns", str(bench / "mine.yaml"), "-o", str(bench / "b.mcap")])
        == 0
    )


def test_columns_and_guess_exclude_each_other(bench, capsys):
    for words in ([], ["--guess", "--columns", "x.yaml"]):
        with pytest.raises(SystemExit) as ended:
            main(["import", str(bench / "good.csv"), *words, "-o", str(bench / "out")])
        assert ended.value.code == 2


def test_a_map_that_was_corrected_by_hand_is_kept(bench, capsys):
    words = ["import", str(bench / "good.csv"), "--guess", "-o", str(bench / "out")]
    assert main(words) == 0 and main(words) == 0  # an unchanged guess may be written again
    columns = bench / "out" / "good_columns.yaml"
    corrected = columns.read_text().replace("unit: N", "unit: kN")
    columns.write_text(corrected)
    assert main(words) == 1
    assert f"import with --columns {columns}" in capsys.readouterr().err
    assert columns.read_text() == corrected
