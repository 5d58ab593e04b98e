"""Further traces, cursors, loops and density, and figures as files."""

import csv
import shutil

import numpy as np
import pytest
from browser import needs_browser, needs_playwright
from studio_page import BAGS, open_page, served

from damper_estimator.studio.cursors import cursor_table, further_choices
from damper_estimator.studio.drawn_rows import cloud_rows, density_rows
from damper_estimator.studio.linked_figures import LOOP_SAMPLES, Scene, cloud_figure, stacked, time_figure
from damper_estimator.studio.view import View, parsed_view


@pytest.mark.parametrize("further", range(7))
def test_figures_below_each_other_do_not_overlap_and_fill_the_height(further):
    domains = stacked(further)
    assert len(domains) == 2 + further
    assert domains[0][1] == 1.0 and domains[-1][0] == pytest.approx(0.0, abs=1e-9)
    assert all(upper[0] > lower[1] > lower[0] for upper, lower in zip(domains, domains[1:], strict=False))


def test_the_parts_of_a_cloud_are_the_cloud_and_dense_cells_are_in_the_last():
    rng = np.random.default_rng(3)
    x, y = rng.normal(size=(2, 15_000))
    parts = density_rows(x, y)
    assert np.array_equal(np.unique(np.concatenate(parts)), cloud_rows(x, y))
    spread = [np.median(np.hypot(x[rows], y[rows])) for rows in parts]
    assert spread[2] < spread[1] < spread[0]


def test_zoomed_in_force_is_a_loop_and_zoomed_out_a_density(session):
    models = [session.shown(model) for model in session.models()]
    near = Scene(models, ["a", "b"], View(0, 1.0, 2.0))
    far = Scene(models, ["a", "b"], View(0))
    assert near.measured.size < LOOP_SAMPLES < far.measured.size
    assert {trace["mode"] for trace in cloud_figure(near, "velocity")["data"]} == {"lines"}
    assert {trace["mode"] for trace in cloud_figure(far, "velocity")["data"]} == {"none"}


def test_cursors_read_the_nearest_sample_and_their_difference(session):
    models = [session.shown(session.model)]
    scene = Scene(models, ["a"], View(0, cursors=(1.0, 1.5)), further=("velocity",))
    rows = cursor_table(scene).children[1].children
    measured = models[0].traces[0].measured
    at = np.searchsorted(scene.whole_time, [1.0, 1.5])
    shown = [float(row.children[2].children.replace("−", "-").replace("\u2009", "")) for row in rows]
    expected = [*measured[at], measured[at[1]] - measured[at[0]]]
    assert shown == pytest.approx(expected, rel=2e-3, abs=0.1)
    layout = time_figure(scene)["layout"]
    assert len(layout["shapes"]) == 2 and "yaxis3" in layout
    assert parsed_view({"cursors": [1, 2, 3]}, 1).cursors == (1.0, 2.0)


def test_only_what_was_recorded_is_offered(session):
    offered = [choice["value"] for choice in further_choices(session.stage.whole[0].kinematics)]
    assert offered == ["displacement", "velocity", "acceleration", "temperature"]


@needs_browser
@needs_playwright
def test_in_the_browser(tmp_path):
    shutil.copy(BAGS / "semi_active_road.mcap", tmp_path)
    with served(tmp_path) as (_, url), open_page(url, 1400, 900) as user:
        page = user.page
        user.open(["semi_active_road.mcap"], ["linear_viscous"], stop=10.0)
        user.choose("traces", "current", "displacement")
        names = lambda: [trace["name"] for trace in user.figure("time")["data"]]  # noqa: E731
        user.until(lambda: {"current", "displacement"} <= set(names()))
        page.locator("#tool").get_by_text("cursors").click()
        user.until(lambda: user.figure("time")["layout"]["dragmode"] is False)
        for place, rows in ((0.3, 1), (0.6, 3)):
            box = page.locator(".figure.time .nsewdrag").first.bounding_box()
            page.mouse.move(box["x"] + place * box["width"], box["y"] + 0.3 * box["height"])
            page.mouse.click(box["x"] + place * box["width"], box["y"] + 0.3 * box["height"])
            user.until(lambda rows=rows: page.locator("#cursor-values tbody tr").count() == rows)
        assert "current" in user.text_of("cursor-values")
        for kind, head in (("svg", b"<svg"), ("png", b"\x89PNG"), ("csv", b"trace,")):
            with page.expect_download() as loaded:
                page.locator(".figure.velocity .files summary").click()
                page.locator(f".figure.velocity [data-save={kind}]").click()
            content = open(loaded.value.path(), "rb").read()
            assert content.startswith(head), kind
        rows = list(csv.reader(content.decode().splitlines()))
        assert rows[0] == ["trace", "velocity in m/s", "force in N"] and len(rows) > 100
        assert not user.faults and not user.foreign
