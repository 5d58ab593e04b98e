"""Tables of a model: the steady force, written and read back."""

import numpy as np
import pytest

from damper_estimator.cli.main import main
from damper_estimator.errors import InputError
from damper_estimator.model import load_model
from damper_estimator.model.force_table import (
    COLUMNS,
    curve_model,
    force_table,
    property_text,
    read_table,
    steady_force,
    velocity_grid,
    write_tables,
)
from damper_estimator.model.model_files import parse_model
from damper_estimator.signals.layout import ROWS, V


def model_of(*effects, **more):
    return parse_model({"name": "made", "source": "test", "effects": list(effects), **more}, "made")


CURVE = {"viscous_curve": {"velocity": [-0.8, -0.13, 0.0, 0.21, 0.9], "force": [-900.0, -400.0, 10.0, 700.0, 1500.0]}}


def at(model, velocities):
    """Forces of a memoryless model, each velocity from a new start."""
    block = np.zeros((ROWS, len(velocities)))
    block[V] = velocities
    return model.force(block)


def test_tables_read_into_a_viscous_curve_have_the_same_force(tmp_path):
    model = model_of(CURVE)
    write_tables(model, force_table(model), tmp_path)
    again = curve_model(read_table(tmp_path / "force_velocity.csv"))
    v = np.linspace(-1.0, 1.0, 401)
    assert at(again, v) == pytest.approx(at(model, v), rel=1e-12, abs=1e-9)


def test_the_property_file_contains_the_same_curve_in_millimetres():
    model = model_of(CURVE)
    table = force_table(model)
    text = property_text(model, table, 0, 0)
    rows = np.array([line.split() for line in text.partition("force}\n")[2].splitlines()], float)
    assert rows[:, 0] == pytest.approx(1e3 * table.velocity, rel=1e-7)
    assert rows[:, 1] == pytest.approx(table.force[0, 0], rel=1e-7)
    assert all(name in text for name in ("[MDI_HEADER]", "[UNITS]", "[CURVE]"))


def test_the_grid_contains_the_knots_of_the_models_curves():
    assert set(CURVE["viscous_curve"]["velocity"]) <= set(velocity_grid(model_of(CURVE)))


@pytest.mark.parametrize("velocity", [0.004, 0.05, 0.7, -0.3])
def test_friction_is_sliding(velocity):
    model = model_of(CURVE, {"dahl": {"force": 80.0, "stiffness": 1e6}})
    expected = at(model_of(CURVE), [velocity])[0] + 80.0 * np.sign(velocity)
    assert steady_force(model, velocity, 0.0) == pytest.approx(expected, abs=0.1)


def test_at_rest_the_table_has_the_middle_of_the_loop():
    assert steady_force(model_of(CURVE, {"dahl": {"force": 80.0}}), 0.0, 0.0) == pytest.approx(10.0, abs=0.5)


def test_lags_have_settled():
    lagged = model_of(CURVE, {"force_lag": {}})
    assert steady_force(lagged, 0.5, 0.0) == pytest.approx(at(model_of(CURVE), [0.5])[0], rel=1e-6)


def test_the_position_is_the_requested_one():
    model = model_of({"gas_spring": {"static_force": 200.0, "volume": 0.00015, "rod_area": 0.00015, "exponent": 1.4}})
    forces = [steady_force(model, 0.1, x) for x in (-0.03, 0.0, 0.03)]
    assert forces == pytest.approx([-200.0 * (1.0 / (1.0 + x)) ** 1.4 for x in (-0.03, 0.0, 0.03)], rel=1e-6)


def test_every_command_has_its_curve(tmp_path):
    model = load_model("lozoya_santos_complete")
    table = force_table(model, commands=(0.0, 1.0, 2.0))
    top = table.force[:, 0, -1]
    assert top[0] < top[1] < top[2]
    names = {path.name for path in write_tables(model, table, tmp_path)}
    assert {"force_velocity.csv", "lozoya_santos_complete_0A.dpr", "lozoya_santos_complete_2A.dpr"} <= names


def test_the_region_of_the_fit_gives_the_grid():
    model = model_of(CURVE, fit={"region": {"velocity": [-0.4, 0.6], "command": [0.0, 2.0]}})
    table = force_table(model)
    assert (table.velocity[0], table.velocity[-1]) == (-0.4, 0.6)
    assert table.commands == pytest.approx([0.0, 0.5, 1.0, 1.5, 2.0])


def test_channel_effects_are_refused():
    with pytest.raises(InputError, match="force_offset belong"):
        force_table(model_of(CURVE, "force_offset"))


def test_the_verb_writes_the_files_and_says_that_hysteresis_is_lost(tmp_path, capsys):
    assert main(["export", "bouc_wen", "--tables", str(tmp_path / "out"), "--velocity=-0.5,0,0.5"]) == 0
    assert "without hysteresis" in capsys.readouterr().out
    assert (tmp_path / "out" / "bouc_wen.dpr").exists()
    assert (tmp_path / "out" / "force_velocity.csv").read_text().splitlines()[0] == ",".join(COLUMNS)


def test_a_file_that_is_not_a_table_is_refused(tmp_path):
    (tmp_path / "x.csv").write_text("a,b\n1,2\n")
    with pytest.raises(InputError, match=r"x\.csv: is not a force-velocity table"):
        read_table(tmp_path / "x.csv")


def test_a_folder_that_cannot_be_created_is_refused(tmp_path, capsys):
    (tmp_path / "file").write_text("")
    assert main(["export", "bouc_wen", "--tables", str(tmp_path / "file" / "x"), "--velocity=0.1"]) == 1
    assert "cannot be created" in capsys.readouterr().err


REGION = {"region": {"velocity": [-0.4, 0.6], "command": [0.0, 2.0]}}
# F = 2000 v - 2400 v^3 peaks at 0.53 m/s and changes sign at 0.91 m/s.
TURNING = {"velocity_polynomial": {"linear": 2.0, "cubic": -2.4e-6}}


def test_outside_the_region_a_table_continues_linearly_from_its_edge():
    curve = {"viscous_curve": {"velocity": [-0.4, 0.0, 0.6], "force": [-900.0, 0.0, 600.0]}}
    table = force_table(model_of(curve, fit=REGION), np.array([-2.0, -0.4, 0.0, 0.3, 0.6, 1.2]))
    assert table.force[0, 0] == pytest.approx([-4500.0, -900.0, 0.0, 300.0, 600.0, 1200.0])


@pytest.mark.parametrize("edge", [0.3, 0.45, 0.5])
def test_no_table_reverses_outside_the_region_though_its_model_does(edge):
    model = model_of(TURNING, fit={"region": {"velocity": [-edge, edge]}})
    v = np.array([-3.0, -1.0, -0.2, 0.0, 0.2, 1.0, 3.0])
    assert at(model, [1.0, 3.0]).max() < 0.0
    force = force_table(model, v).force[0, 0]
    assert (force * v >= 0.0).all() and (np.diff(force) >= -1e-9).all()


def test_inside_the_region_a_table_equals_the_model_whatever_the_outer_points():
    v = np.array([-0.3, -0.1, 0.2, 0.5])
    model = model_of(CURVE, fit=REGION)
    wide = force_table(model, np.concatenate([[-2.0], v, [2.0]]))
    assert wide.force[..., 1:-1] == pytest.approx(force_table(model, v).force, rel=1e-12)


def test_points_outside_the_region_are_marked_in_the_files(tmp_path):
    model = model_of(CURVE, fit=REGION)
    table = force_table(model, np.array([-1.0, -0.2, 0.2, 0.8]), commands=(1.0, 3.0))
    assert table.inside[:, 0].tolist() == [[False, True, True, False], [False] * 4]
    paths = write_tables(model, table, tmp_path)
    again = read_table(paths[0])
    assert np.array_equal(again.inside, table.inside) and np.array_equal(again.force, table.force)
    assert "$ outside the region of the fit: -1000, 800 mm/s" in (tmp_path / "made_1A.dpr").read_text()


def test_a_model_without_a_region_marks_nothing(tmp_path):
    table = force_table(model_of(CURVE), np.array([-2.0, 2.0]))
    path = write_tables(model_of(CURVE), table, tmp_path)[0]
    assert table.inside is None and read_table(path).inside is None


def test_a_table_without_the_mark_is_read(tmp_path):
    (tmp_path / "x.csv").write_text("velocity_m_s,command,temperature_degc,force_n\n-1,,,-5\n1,,,5\n")
    table = read_table(tmp_path / "x.csv")
    assert table.force[0, 0].tolist() == [-5.0, 5.0] and table.inside is None
