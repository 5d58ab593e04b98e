"""Bench files as loggers and test rigs write them: their column maps are guessed right, or the guess has doubts."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
import yaml

from damper_estimator.errors import InputError
from damper_estimator.recordings import guess_columns, load_column_maps, read_parts
from damper_estimator.recordings.guess_words import read_title

RATE = 500.0


@dataclass(frozen=True)
class Truth:
    """A damper on a bench: seconds, m (positive in extension), N (positive if it resists extension), deg C, A."""

    t: np.ndarray
    x: np.ndarray
    v: np.ndarray
    f: np.ndarray
    warm: np.ndarray
    current: np.ndarray


def truth(seconds: float = 4.0, gas: float = 180.0, seed: int = 1) -> Truth:
    """Two sines; friction, more damping in rebound than in compression, gas that pushes the rod out."""
    draw = np.random.default_rng(seed)
    t = np.arange(0.0, seconds, 1.0 / RATE)
    phase = 2 * np.pi * 1.3 * t, 2 * np.pi * 4.1 * t
    x = 0.025 * np.sin(phase[0]) + 0.006 * np.sin(phase[1])
    v = np.gradient(x, t)
    f = np.where(v > 0, 2400.0, 1100.0) * v + 60.0 * np.tanh(v / 0.02) - gas + draw.normal(0.0, 2.0, t.size)
    return Truth(t, x, v, f, 31.0 + 0.4 * t, 0.6 + 0.3 * np.sign(np.sin(0.7 * t)))


def rows(*columns: np.ndarray, sep: str = ",", form: str = "{:.6g}", comma: bool = False) -> str:
    cells = [[form.format(value) for value in column] for column in columns]
    cells = [[cell.replace(".", ",") for cell in column] for column in cells] if comma else cells
    return "\n".join(sep.join(row) for row in zip(*cells, strict=True)) + "\n"


def plain_csv(signals: Truth) -> str:
    return "Time [s],Displacement [mm],Force [N]\n" + rows(signals.t, 1e3 * signals.x, signals.f)


def german_logger(signals: Truth) -> str:
    head = "Messung;Daempfer VL\nDatum;12.03.2024\n\nZeit;Weg;Kraft;Temperatur\ns;mm;kN;°C\n"
    return head + rows(signals.t, 1e3 * signals.x, 1e-3 * signals.f, signals.warm, sep=";", form="{:.5f}", comma=True)


def tabs_and_milliseconds(signals: Truth) -> str:
    return "time (ms)\tpos (mm)\tload (lbf)\n" + rows(
        1e3 * signals.t, 1e3 * signals.x, signals.f / 4.4482216152605, sep="\t"
    )


def white_space(signals: Truth) -> str:
    return "# Time(s)   Stroke(mm)   Force(N)\n" + rows(
        signals.t, 1e3 * signals.x, signals.f, sep="   ", form="{:12.5f}"
    )


def inches(signals: Truth) -> str:
    head = '"Time","Axial Displacement","Axial Force"\n"sec","in","lbf"\n'
    return head + rows(signals.t, signals.x / 0.0254, signals.f / 4.4482216152605)


def rate_in_head(signals: Truth) -> str:
    head = "Test name\tShock 7\nSampling rate\t500 Hz\n\nPosition [mm]\tLoad [N]\n"
    return head + rows(1e3 * signals.x, signals.f, sep="\t")


def dates(signals: Truth) -> str:
    stamps = [f"12.03.2024 10:15:{int(t):02d}.{round(t % 1 * 1e6):06d}" for t in signals.t]
    body = rows(1e3 * signals.x, signals.f, sep=";", comma=True).splitlines()
    return "Datum;Weg [mm];Kraft [N]\n" + "\n".join(f"{a};{b}" for a, b in zip(stamps, body, strict=True)) + "\n"


def time_of_day(signals: Truth) -> str:
    stamps = [f"10:15:{int(t):02d}.{round(t % 1 * 1e6):06d}" for t in signals.t]
    body = rows(1e3 * signals.x, signals.f).splitlines()
    return "Clock,Displ_mm,Force_N\n" + "\n".join(f"{a},{b}" for a, b in zip(stamps, body, strict=True)) + "\n"


def with_velocity_and_no_unit(signals: Truth) -> str:
    return "Time [s];Weg;Geschwindigkeit [m/s];Kraft [N]\n" + rows(
        signals.t, 1e3 * signals.x, signals.v, signals.f, sep=";"
    )


def force_reversed(signals: Truth) -> str:
    return "Time [s],Displacement [mm],Force [N]\n" + rows(signals.t, 1e3 * signals.x, -signals.f)


def displacement_reversed(signals: Truth) -> str:
    return "Time [s],Displacement [mm],Force [N]\n" + rows(signals.t, -1e3 * signals.x, signals.f)


def with_setpoint_and_counter(signals: Truth) -> str:
    lag = np.interp(signals.t + 0.004, signals.t, signals.x)
    head = "Sample,Time [s],Position Setpoint [mm],Position Actual [mm],Load Cell [kN],Oil Temp [degC],Current [A]\n"
    counter = np.arange(signals.t.size)
    return head + rows(counter, signals.t, 1e3 * lag, 1e3 * signals.x, 1e-3 * signals.f, signals.warm, signals.current)


def two_dampers(signals: Truth) -> str:
    other = truth(seed=2)
    head = "Time_s,FL_Disp_mm,FL_Force_N,FR_Disp_mm,FR_Force_N\n"
    return head + rows(signals.t, 1e3 * signals.x, signals.f, 700.0 * other.x, 0.8 * other.f)


def several_blocks(signals: Truth) -> str:
    head = "Time [s];Weg [mm];Kraft [N]\n"
    one = head + rows(signals.t, 1e3 * signals.x, signals.f, sep=";", comma=True)
    return f"Block 1\n{one}\nBlock 2\n{one}"


def metadata_table_above(signals: Truth) -> str:
    head = "Operator,Meier\nStroke,50\nSpeed,0.3\nSpecimen,4711\n\nTime,Displacement,Force\n(s),(mm),(N)\n"
    return head + rows(signals.t, 1e3 * signals.x, signals.f)


def quoted_decimal_commas(signals: Truth) -> str:
    body = rows(signals.t, 1e3 * signals.x, signals.f, sep=";", comma=True).splitlines()
    cells = [",".join(f'"{cell}"' for cell in line.split(";")) for line in body]
    return '"Zeit [s]","Weg [mm]","Kraft [N]"\n' + "\n".join(cells) + "\n"


def trailing_separators_and_gaps(signals: Truth) -> str:
    lines = rows(signals.t, signals.x, signals.f, signals.warm + 273.15, sep=";", form="{:.7e}").splitlines()
    slow = [line if i % 50 == 0 else line.rpartition(";")[0] + ";" for i, line in enumerate(lines)]
    return "Time;Disp;Force;Temp;\n[s];[m];[N];[K];\n" + ";\n".join(slow) + ";\n"


def no_titles(signals: Truth) -> str:
    return rows(signals.t, 1e3 * signals.x, signals.f)


def volts(signals: Truth) -> str:
    return "Time [s],LVDT [V],Load cell [V]\n" + rows(signals.t, 200.0 * signals.x, signals.f / 500.0)


def no_units(signals: Truth) -> str:
    return "t,x,F\n" + rows(signals.t, 1e3 * signals.x, signals.f)


SINGLE = {"damper": {"displacement", "force"}}
KINDS: dict[str, Callable[[Truth], str]] = {
    file.__name__: file
    for file in (
        plain_csv, german_logger, tabs_and_milliseconds, white_space, inches, rate_in_head, dates, time_of_day,
        with_velocity_and_no_unit, force_reversed, displacement_reversed, with_setpoint_and_counter,
        two_dampers, several_blocks, metadata_table_above, quoted_decimal_commas, trailing_separators_and_gaps,
        no_titles, volts, no_units,
    )
}  # fmt: skip
TOLD_RIGHT = 17


def guessed(path: Path, signals: Truth):
    """The guess, and whether its import equals the truth."""
    guess = guess_columns(path)
    map_path = path.with_suffix(".yaml")
    map_path.write_text(yaml.safe_dump(guess.content(), sort_keys=False))
    try:
        parts = read_parts(path, load_column_maps(map_path).for_file(path.name))
    except InputError:
        return guess, False
    return guess, all(is_right(part, signals) for part in parts)


def is_right(part, signals: Truth) -> bool:
    if len(part.stamps) != signals.t.size:
        return False
    right = np.allclose((part.stamps - part.stamps[0]) * 1e-9, signals.t, atol=2e-6)
    for name, channels in part.dampers.items():
        if not {"displacement", "force"} <= channels.keys():
            return False
        x, f = (signals.x, signals.f) if name != "front_right" else (0.7 * truth(seed=2).x, 0.8 * truth(seed=2).f)
        right &= np.allclose(channels["displacement"], x, atol=2e-6) and np.allclose(channels["force"], f, atol=0.1)
    return bool(right)


@pytest.fixture(scope="module")
def guesses(tmp_path_factory):
    """The guess of every kind of file, and whether it is right."""
    signals, place = truth(), tmp_path_factory.mktemp("bench")
    found = {}
    for name, write in KINDS.items():
        path = place / f"{name}.csv"
        path.write_text(write(signals), encoding="utf-8")
        found[name] = guessed(path, signals)
    return found


@pytest.mark.parametrize("name", KINDS)
def test_a_guess_is_right_or_has_doubts(guesses, name):
    guess, right = guesses[name]
    assert right or guess.doubts


def test_most_kinds_are_guessed_right_without_a_doubt(guesses):
    assert len(KINDS) == 20
    right = [name for name, (guess, right) in guesses.items() if right and not guess.doubts]
    doubted = {name: guess.doubts for name, (guess, _) in guesses.items() if name not in right}
    assert len(right) >= TOLD_RIGHT, doubted


@pytest.mark.parametrize("gas", [0.0, 180.0, -150.0])
@pytest.mark.parametrize("turned", [(1, 1), (1, -1), (-1, 1), (-1, -1)])
def test_signs_are_right_or_doubted_or_reported_as_assumed(tmp_path, gas, turned):
    signals = truth(gas=gas)
    path = tmp_path / "signs.csv"
    path.write_text(
        "Time [s],Displacement [mm],Force [N]\n" + rows(signals.t, turned[0] * 1e3 * signals.x, turned[1] * signals.f)
    )
    guess, right = guessed(path, signals)
    assert right or guess.doubts or any("nothing in the file confirms it" in text for text in guess.assumed) or gas < 0
    if gas > 0 and turned != (-1, -1):
        assert right and not guess.doubts
    if not right and gas < 0:  # a wrong zero of the gauge looks like gas: the conclusion is reported
        assert guess.doubts or any("gas" in text for text in guess.assumed)


@pytest.mark.parametrize(("unit", "factor", "right"), [("mm", 1e3, True), ("cm", 1e3, False), ("mm", -1e3, False)])
def test_a_displacement_is_checked_against_the_velocity_channel(tmp_path, unit, factor, right):
    signals = truth()
    path = tmp_path / "speed.csv"
    head = f"Time [s],Displacement [{unit}],Velocity [m/s],Force [N]\n"
    path.write_text(head + rows(signals.t, factor * signals.x, signals.v, np.sign(factor) * signals.f))
    assert bool(guess_columns(path).doubts) != right


@pytest.mark.parametrize("seed", range(12))
def test_a_channel_that_is_no_force_is_doubted(tmp_path, seed):
    signals, draw = truth(), np.random.default_rng(seed)
    wrong = np.cumsum(draw.normal(0.0, 20.0, signals.t.size))
    path = tmp_path / "wrong.csv"
    path.write_text("Time [s],Displacement [mm],Force [N]\n" + rows(signals.t, 1e3 * signals.x, wrong))
    guess, _ = guessed(path, signals)
    assert any("hardly related" in text for text in guess.doubts)


@pytest.mark.parametrize(
    ("head", "said"),
    [
        ("Time [s],Displacement [N],Force [mm]", "names displacement, but its unit"),
        ("Time [s],Displacement [m],Force [N]", "not plausible"),
        ("Time [h],Displacement [mm],Force [N]", "a rate of"),
        ("Time [s],Displacement [mm],Displacement 2 [mm]", "no column is clearly the force"),
        ("Note,Displacement [mm],Force [N]", "no line names a rate"),
    ],
)
def test_titles_that_contradict_the_numbers_are_doubted(tmp_path, head, said):
    signals = truth()
    path = tmp_path / "odd.csv"
    body = rows(np.sin(signals.t) if head.startswith("Note") else signals.t, 1e3 * signals.x, signals.f)
    path.write_text(f"{head}\n{body}")
    assert any(said in text for text in guess_columns(path).doubts), guess_columns(path).doubts


@pytest.mark.parametrize("content", ["", "\n\n", "hello\nworld\n", "a,b\n1,2\n", "x" * 5000, "\0" * 300, "1,2\n" * 2])
def test_files_without_a_table_are_refused_in_one_line(tmp_path, content):
    path = tmp_path / "none.csv"
    path.write_text(content)
    with pytest.raises(InputError) as refused:
        guess_columns(path)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("title", "below", "quantity", "unit"),
    [
        ("Force [N]", "", "force", "N"), ("Kraft in kN", "", "force", "kN"), ("F", "N", "force", "N"),
        ("disp_mm", "", "displacement", "mm"), ("Weg/mm", "", "displacement", "mm"), ("x", "", "displacement", ""),
        ("Axial Displacement (in)", "", "displacement", "in"), ("Velocity [mm/s]", "", "velocity", "mm/s"),
        ("Zeit", "[s]", "time", "s"), ("Oil Temp [°C]", "", "temperature", "degC"),
        ("Gas pressure, bar", "", "pressure", "bar"),
        ("Load cell [V]", "", "voltage", "V"), ("Acc [g]", "", "acceleration", "g"), ("Strom", "A", "command", "A"),
        ("DampingForce", "", "force", ""), ("Remark", "", "", ""),
    ],
)  # fmt: skip
def test_titles_are_understood(title, below, quantity, unit):
    found = read_title(title, below)
    assert (found.quantity, found.unit) == (quantity, unit)


def test_a_mat_file_is_guessed_by_the_names_of_its_variables(tmp_path):
    scipy_io = pytest.importorskip("scipy.io", reason="SciPy writes the MAT files of this test")
    signals = truth()
    scipy_io.savemat(
        tmp_path / "run.mat", {"data": {"time_s": signals.t, "disp_mm": 1e3 * signals.x, "force_N": signals.f}}
    )
    guess, right = guessed(tmp_path / "run.mat", signals)
    assert right and not guess.doubts
