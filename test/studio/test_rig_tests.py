"""Tests from the studio: diagrams, the next test on a rig, simulated rides, their pages and files."""

import shutil
from concurrent.futures import ThreadPoolExecutor
from types import SimpleNamespace

import pytest
from browser import needs_browser, needs_playwright
from studio_page import BAGS, open_page, served

from damper_estimator.cli.main import main
from damper_estimator.errors import InputError
from damper_estimator.model import load_model
from damper_estimator.studio import rig_tests
from damper_estimator.studio.folder import Folder
from damper_estimator.studio.guard import SANDBOX, ServerAddress
from damper_estimator.studio.rig_tasks import _new_folder
from damper_estimator.studio.rig_tests import SHARPEN, aims
from damper_estimator.studio.server import application
from damper_estimator.studio.session import Session
from damper_estimator.studio.stage import Choice
from damper_estimator.workflows import ride

HOST = {"Host": "127.0.0.1:8050"}


@pytest.fixture
def bench(tmp_path):
    """The session that has the shipped recording of a dynamometer open."""
    shutil.copy(BAGS / "passenger_dyno.mcap", tmp_path)
    session = Session(Folder(tmp_path))
    session.open(Choice(("passenger_dyno.mcap",)), ["viscous_curve"])
    session.job.wait()
    assert session.job.state == "done", session.job.error
    return session


def test_diagrams_are_written_next_to_earlier_ones(bench):
    for name in ("diagrams", "diagrams_2"):
        rig_tests.characterize(bench)
        bench.job.wait()
        assert bench.job.state == "done", bench.job.error
        test = bench.tests[-1]
        assert test.folder == name and "operating points" in test.sentence
        assert (bench.folder.root / name / "diagrams.html").stat().st_size > 10_000
        assert "structure.yaml" in test.files and (bench.folder.root / name / "structure.yaml").is_file()
    assert f"{name}/structure.yaml" in bench.folder.models()


def test_two_pages_never_write_into_one_folder(tmp_path):
    with ThreadPoolExecutor(8) as pool:
        made = list(pool.map(lambda _: _new_folder(tmp_path, "test"), range(40)))
    assert len(set(made)) == 40 and all(folder.is_dir() for folder in made)
    (tmp_path / "plans").symlink_to("/tmp")
    assert _new_folder(tmp_path, "plans").name == "plans_2"  # never through a link
    with pytest.raises(InputError, match="cannot be made"):
        _new_folder(tmp_path / "missing", "test")


def test_a_test_for_the_parameters_is_planned_on_the_chosen_rig(bench):
    rig_tests.plan(bench, SHARPEN, "servo_hydraulic", 0.5)
    bench.job.wait()
    assert bench.job.state == "done", bench.job.error
    test = bench.tests[-1]
    assert test.page == "plan.html" and set(test.files) == {"drive.csv", "plan.yaml"} and test.sentence
    assert all((bench.folder.root / test.folder / name).is_file() for name in (test.page, *test.files))


@pytest.mark.parametrize(
    ("aim", "rig", "minutes", "reason"),
    [
        ("friction+inertia", "crank", None, "choose what the test is for"),
        (None, "crank", None, "choose what the test is for"),
        (SHARPEN, "../secret.yaml", None, "choose a rig"),
        (SHARPEN, "/etc/passwd", None, "choose a rig"),
        (SHARPEN, None, None, "choose a rig"),
        (SHARPEN, "crank", -1.0, "minutes"),
        (SHARPEN, "crank", float("nan"), "minutes"),
        (SHARPEN, "crank", "1", "minutes"),
    ],
)
def test_what_is_not_offered_is_refused_in_one_line(bench, aim, rig, minutes, reason):
    with pytest.raises(InputError, match=reason):
        rig_tests.plan(bench, aim, rig, minutes)
    assert not bench.tests


def test_a_damaged_rig_file_of_the_folder_is_refused_in_one_line(bench):
    (bench.folder.root / "mine.yaml").write_text("kind: crank\nrate: much\n")
    assert rig_tests.rigs(bench.folder)[-1] == "mine.yaml"
    rig_tests.plan(bench, SHARPEN, "mine.yaml", None)
    bench.job.wait()
    assert bench.job.state == "failed" and "mine.yaml" in bench.job.error and "\n" not in bench.job.error
    assert not bench.tests and not (bench.folder.root / "test").exists()


@pytest.mark.parametrize(
    ("damper", "seconds"), [("../x", 12.0), (None, 12.0), ("soft_mount", 1.0), ("soft_mount", None)]
)
def test_a_ride_that_is_not_offered_is_refused_in_one_line(bench, damper, seconds):
    with pytest.raises(InputError, match="choose a simulated damper|5 to 120"):
        rig_tests.ride(bench, damper, seconds)


def test_a_model_without_current_cannot_ride(bench):
    rig_tests.ride(bench, "soft_mount", 5.0)
    bench.job.wait()
    assert bench.job.state == "failed" and "does not depend on the command" in bench.job.error
    assert not bench.tests and not (bench.folder.root / "ride").exists()


def test_a_ride_is_that_of_the_command_line(tmp_path):
    shutil.copy(BAGS / "semi_active_road.mcap", tmp_path)
    session = Session(Folder(tmp_path))
    session.open(Choice(("semi_active_road.mcap",)), ["semi_active_yield"])
    session.job.wait()
    rig_tests.ride(session, "soft_mount", 5.0)
    session.job.wait()
    assert session.job.state == "done", session.job.error
    (made,) = session.tests
    assert made.sentence == ride("semi_active_yield", ["soft_mount"], seconds=5.0).sentence
    assert "damper force in N" in (tmp_path / "ride" / "ride.html").read_text(encoding="utf-8")
    assert load_model(tmp_path / "ride" / "soft_mount.yaml").fit


def test_ties_of_the_diagnosis_come_first_among_the_aims():
    findings = [
        SimpleNamespace(phenomenon="friction", tied_with=()),
        SimpleNamespace(phenomenon="inertia", tied_with=("channel_skew",)),
    ]
    offered = aims(SimpleNamespace(findings=findings))
    assert (
        list(offered) == ["inertia+channel_skew", SHARPEN]
        and "inertia or channel skew" in offered["inertia+channel_skew"]
    )
    assert list(aims(None)) == [SHARPEN]


def test_the_page_of_a_test_is_served_in_a_sandbox(bench, tmp_path):
    rig_tests.characterize(bench)
    bench.job.wait()
    app, sessions = application(Folder(tmp_path), ServerAddress("127.0.0.1", 8050))
    client = app.server.test_client()
    sessions._open["known"] = (bench, float("inf"))
    answer = client.get("/test/known/0", headers=HOST)
    assert answer.status_code == 200 and answer.headers["Content-Security-Policy"] == SANDBOX
    for path in ("/test/known/1", "/test/unknown/0", "/test/known/-1", "/test/known/0/../x"):
        assert client.get(path, headers=HOST).status_code in (404, 200)
        assert b"operating" not in client.get(path, headers=HOST).data
    (tmp_path / "diagrams" / "diagrams.html").unlink()
    assert client.get("/test/known/0", headers=HOST).status_code == 404
    sessions._open.clear()
    sessions.close()


@needs_browser
@needs_playwright
def test_diagrams_from_the_tab_to_their_page(tmp_path):
    shutil.copy(BAGS / "passenger_dyno.mcap", tmp_path)
    with served(tmp_path) as (_, url), open_page(url) as user:
        page = user.page
        user.open(["passenger_dyno.mcap"], ["viscous_curve"])
        user.until(lambda: user.text_of("regions"))
        user.tab("Tests")
        page.click("#characterize")
        user.done("characterizing")
        user.until(lambda: "operating points" in user.text_of("tests-done"))
        with page.context.expect_page() as opened:
            page.locator(".test-result a").first.click()
        made = opened.value
        made.wait_for_selector(".js-plotly-plot .main-svg")
        assert "passenger_front" in made.inner_text("body")
        page.fill("#minutes", "100")
        page.click("#plan")
        user.until(lambda: "minutes" in user.text_of("tests-message"))
        page.click("#ride")
        user.done("riding", "failed")
        user.until(lambda: "does not depend on the command" in user.text_of("tests-message"))
        assert not user.faults and not user.foreign


@needs_browser
@needs_playwright
def test_from_a_tie_to_the_drive_that_decides(tmp_path):
    hidden = ["--hide", "gas_spring", "--strength", "0.04", "--seconds", "20", "--excitation", "road"]
    assert main(["synth", "-o", str(tmp_path), *hidden]) == 0
    assert main(["fit", str(tmp_path / "base.mcap"), "-m", "viscous_curve", "-o", str(tmp_path / "mine.yaml")]) == 0
    with served(tmp_path) as (_, url), open_page(url) as user:
        page = user.page
        user.open(["fit.mcap"], ["mine.yaml"])
        user.tab("What is missing")
        page.click("#diagnose")
        user.done("diagnosing")
        page.locator("button", has_text="Plan the test that decides").first.click()
        user.until(lambda: "gas spring" in user.text_of("aim"))
        page.click("#plan")
        user.done("planning")
        user.until(lambda: "drive.csv" in user.text_of("tests-done"))
        page.locator(".test-result summary").first.click()
        assert page.locator(".test-result li").count() >= 1
        with page.context.expect_page() as opened:
            page.locator(".test-result a").first.click()
        opened.value.wait_for_selector(".js-plotly-plot .main-svg")
        assert "gas spring" in opened.value.inner_text("body")
        assert not user.faults and not user.foreign
    assert (tmp_path / "test" / "drive.csv").stat().st_size > 10_000
