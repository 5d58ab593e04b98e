"""The look-up table of force over velocity and current."""

import numpy as np
import pytest

from damper_estimator.control import CurrentTable, load_table, table_from_samples
from damper_estimator.errors import InputError

V, C = np.array([-1.0, -0.2, 0.0, 0.2, 1.0]), np.array([0.0, 1.0, 2.0])


def example_table() -> CurrentTable:
    return CurrentTable(V, C, 800.0 * V[:, None] + 500.0 * np.sign(V)[:, None] * np.array([0.0, 0.7, 1.0]))


def test_the_current_reproduces_the_force():
    table = example_table()
    for velocity in (-0.9, -0.15, 0.05, 0.3, 2.0):
        for current in (0.0, 0.3, 1.0, 1.7, 2.0):
            found = table.current_for(velocity, table.force_at(velocity, current))
            assert found == pytest.approx(current, abs=1e-9)


def test_a_force_out_of_reach_gives_the_nearer_limit():
    table = example_table()
    assert table.current_for(0.5, 5000.0) == 2.0
    assert table.current_for(0.5, -5000.0) == 0.0
    assert table.current_for(-0.5, 5000.0) == 0.0


def test_samples_of_a_table_give_the_table():
    random = np.random.default_rng(1)
    velocity, current = random.uniform(-1.0, 1.0, 4000), random.uniform(0.0, 2.0, 4000)
    truth = example_table()
    force = np.array([truth.force_at(v, c) for v, c in zip(velocity, current, strict=True)])
    table = table_from_samples(velocity, current, force + random.normal(0.0, 5.0, 4000), V, C)
    assert table.force == pytest.approx(truth.force, abs=12.0)
    knocked = np.where(random.random(4000) < 0.01, np.nan, force)
    assert table_from_samples(velocity, current, knocked, V, C).force == pytest.approx(truth.force, abs=12.0)


def test_cells_without_samples_follow_their_neighbours():
    random = np.random.default_rng(2)
    velocity, current = random.uniform(-0.5, 0.5, 3000), random.uniform(0.0, 2.0, 3000)
    table = table_from_samples(velocity, current, 1000.0 * velocity + 100.0 * current, (-1.0, -0.5, 0.0, 0.5, 1.0), C)
    assert table.force[0] == pytest.approx(-1000.0 + 100.0 * C, abs=30.0)


def test_too_few_samples_are_refused():
    with pytest.raises(InputError, match="3 samples are too few for a table of 5 x 3"):
        table_from_samples(np.zeros(3), np.zeros(3), np.zeros(3), V, C)


def test_a_table_is_read_from_the_file_that_export_writes(tmp_path):
    from damper_estimator.model import load_model
    from damper_estimator.model.force_table import force_table, write_tables

    model = load_model("semi_active_on_mount")
    written = force_table(model, np.array([-0.6, -0.4, -0.2, 0.0, 0.2, 0.4, 0.6]), commands=(0.0, 0.7, 1.4))
    table = load_table(write_tables(model, written, tmp_path)[0])
    assert table.force.shape == (7, 3)
    for velocity, current in ((0.4, 0.7), (-0.2, 1.4)):
        (k,), (c,) = np.flatnonzero(written.velocity == velocity), np.flatnonzero(written.commands == current)
        assert table.force_at(velocity, current) == written.force[c, 0, k]
    assert table.current_for(0.4, table.force_at(0.4, 1.0)) == pytest.approx(1.0)
    single = write_tables(model, force_table(model, np.array([-0.1, 0.1]), commands=(1.0,)), tmp_path / "one")[0]
    with pytest.raises(InputError, match="has only one command"):
        load_table(single)


@pytest.mark.parametrize("velocity, wanted", [(0.2, float("nan")), (0.2, float("inf")), (float("nan"), 100.0)])
def test_values_that_are_not_finite_have_no_current(velocity, wanted):
    table = CurrentTable(np.array([-1.0, 1.0]), np.array([0.0, 1.0]), np.array([[-1.0, -2.0], [1.0, 2.0]]))
    assert np.isnan(table.current_for(velocity, wanted))
