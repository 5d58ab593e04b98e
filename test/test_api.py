"""The public Python API: the tour of docs/python.md line by line, on recordings made for the test."""

import re
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from drives import samples, write_drive

import damper_estimator as de

ROOT = Path(__file__).parents[1]
COLUMNS = """
time: {column: time, unit: s}
dampers: {bench: {displacement: {column: x, unit: mm}, force: {column: load, unit: N}}}
"""


class Frame(dict):
    """What the API uses of a data frame."""

    columns = property(list)


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """A folder with all that the tour reads, a faster model under the name that it fits."""
    folder = tmp_path_factory.mktemp("tour")
    write_drive(folder / "drive.mcap", seconds=8.0)
    write_drive(folder / "another_drive.mcap", seed=5, seconds=8.0)
    time, x, force, _ = samples()
    rows = "\n".join(f"{t:.6f},{1e3 * d:.6f},{f:.6f}" for t, d, f in zip(time, x, force, strict=True))
    (folder / "bench.csv").write_text(f"time,x,load\n{rows}\n")
    (folder / "columns.yaml").write_text(COLUMNS)
    (folder / "map.yaml").write_text("filter: {cutoff: 50.0}\n")
    return folder


@pytest.fixture(scope="module")
def tour(place):
    """The names after all code of docs/python.md was run, in order."""
    code = "\n".join(re.findall(r"```python\n(.*?)```", (ROOT / "docs" / "python.md").read_text(), re.DOTALL))
    code = code.replace('"carrera_akutain"', '"linear_viscous"').replace("start=5, stop=60", "start=1, stop=7")
    time, x, force, _ = samples(seconds=8.0)
    names = {"time": time, "displacement": x, "force": force, "frame": Frame(t=time, x=x, load=force)}
    with pytest.MonkeyPatch.context() as patched:
        patched.chdir(place)
        exec(compile(code, "docs/python.md", "exec"), names)
    return names


def test_the_tour_runs_and_finds_the_friction_that_the_model_lacks(tour):
    assert tour["found"].verdict == "missing" and tour["found"].findings[0].phenomenon == "friction"
    assert tour["better"].steps[-1].rmse_unseen_n < 0.3 * tour["better"].steps[0].rmse_unseen_n
    assert tour["estimates"].force.shape == tour["estimates"].time.shape == tour["estimates"].status.shape


def test_the_files_of_the_tour_are_written(tour, place):
    written = {"mine.mcap", "model.yaml", "report.html", "better.yaml", "map.yaml", "estimates.csv"}
    assert written <= {path.name for path in place.iterdir()}
    assert de.load_model(place / "better.yaml").slots == tour["better"].model.slots
    assert de.read(place / "mine.mcap").dampers == ("damper",)
    assert de.load_signal_map(place / "map.yaml").dampers.keys() == {"damper"}


@pytest.mark.parametrize("name", ["recording", "fitted", "result", "found", "better", "estimates"])
def test_all_results_of_the_tour_have_a_short_display(tour, name):
    result = tour[name]
    assert "\n" not in repr(result) and len(repr(result)) < 300
    table = result._repr_html_()
    assert ElementTree.fromstring(table).tag == "div" and len(table) < 6000
    assert "bags" in result.to_dict() or result.to_dict().keys() == {"output", "dampers"}
    if name != "recording":
        assert result.figure().data


def test_a_model_shows_its_effects_in_one_line(tour):
    assert repr(tour["model"]) == "DamperModel(linear_viscous: linear_viscous, static_force)"


def test_a_result_with_models_can_replace_them(tour):
    expected = de.compare(tour["recording"], tour["fitted"].models)
    found = de.compare(tour["recording"], tour["fitted"])
    assert found.rmse_n == expected.rmse_n and found.request == expected.request
    one = de.fit(tour["recording"], tour["fitted"], fix="*", free="linear_viscous.rebound")
    assert [p.name for p in one.parameters] == ["linear_viscous.rebound"]


def test_tables_report_missing_pandas(tour, monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    for name in ("recording", "fitted", "result", "found", "better", "estimates"):
        with pytest.raises(de.InputError, match="needs pandas, which is not installed: pip install pandas"):
            tour[name].to_dataframe()


def test_tables_are_data_frames_where_pandas_is_installed(tour):
    pytest.importorskip("pandas", reason="pandas is optional and not installed")
    assert list(tour["fitted"].to_dataframe()["name"]) == [p.name for p in tour["fitted"].parameters]
    assert tour["estimates"].to_dataframe()["force"].to_numpy() == pytest.approx(tour["estimates"].force)
    samples_of = tour["recording"].to_dataframe()
    assert {"time", "displacement", "velocity", "force", "judged"} <= set(samples_of.columns)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda place: de.read(place / "nowhere.mcap"), "nowhere.mcap"),
        (lambda place: de.read(place / "drive.mcap", dampers="rear"), "has no damper 'rear'; it has front_left"),
        (lambda place: de.fit(de.read(place / "drive.mcap"), "no_such_model"), "no_such_model"),
        (lambda place: de.diagnose(_without_force(), "coulomb"), "no damper has a measured force; diagnose needs one"),
        (lambda place: de.improve(_without_force(), "coulomb"), "no damper has a measured force; improve needs one"),
        (lambda place: de.diagnose(_without_force(), "coulomb", mode="new"), "choose one of both, kept, refit"),
        (lambda place: de.fit(place / "drive.mcap", "coulomb"), "is not a recording; read it first: read(path)"),
        (
            lambda place: de.diagnose(
                de.Recording.from_arrays(*samples()[:2], force=samples()[2]), "coulomb", validate="a.mcap"
            ),
            "'a.mcap': is not a recording",
        ),
        (lambda place: de.replay("a.mcap", "coulomb"), "'a.mcap': is not a recording"),
    ],
)
def test_errors_are_one_line(call, words, place):
    with pytest.raises(de.InputError, match=re.escape(words)) as refused:
        call(place)
    assert "\n" not in str(refused.value)


def _without_force():
    time, x, *_ = samples()
    return de.Recording.from_arrays(time, x)


def test_importing_the_package_imports_no_library():
    script = (
        "import sys, damper_estimator as de\n"
        "heavy = {'numpy', 'scipy', 'numba', 'plotly', 'mcap', 'rosbags', 'yaml', 'pandas'} & set(sys.modules)\n"
        "assert not heavy, heavy\n"
        "assert {'read', 'fit', 'Recording', 'InputError'} <= set(dir(de))\n"
        "from damper_estimator import *\n"
        "assert read is de.read and de.__version__\n"
    )
    subprocess.run([sys.executable, "-c", script], check=True, cwd=ROOT)


def test_an_unknown_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="module 'damper_estimator' has no attribute 'nonsense'"):
        de.nonsense  # noqa: B018


def test_every_public_name_is_documented():
    for name in de.__all__:
        public = getattr(de, name)
        assert public.__doc__ and public.__doc__.strip(), name
        parts = (
            [part for key, part in vars(public).items() if not key.startswith("_")] if isinstance(public, type) else []
        )
        described = [part for part in parts if callable(part) or isinstance(part, (property, classmethod))]
        assert all(part.__doc__ for part in described), name


def test_arrays_and_the_bag_of_the_same_samples_agree(place):
    bag = de.read(place / "drive.mcap")
    time, x, force, warm = samples(seconds=8.0)
    slow = np.where(np.arange(time.size) % 200 == 0, warm, np.nan)
    memory = de.Recording.from_arrays(time, x, force=force, temperature=slow, damper="front_left")
    for model in ("linear_viscous", "carrera_akutain"):
        one, other = (de.compare(recording, model) for recording in (bag, memory))
        assert one.rmse_n == other.rmse_n and one.noise_floor_n == other.noise_floor_n
