"""Sessions are files: nothing of what was done is lost, whoever ends a page and however."""

import json
import os

import numpy as np
import pytest

from damper_estimator.errors import InputError
from damper_estimator.studio.address import LONGEST, fields_of, parsed_address
from damper_estimator.studio.folder import Folder
from damper_estimator.studio.session import Session
from damper_estimator.studio.session_files import PLACE, SessionFiles
from damper_estimator.studio.sessions import MOST, Sessions
from damper_estimator.studio.stage import Choice


def error(session):
    return session.shown(session.model).measures.rmse_n


def resumed(folder, name, owner="", **how):
    session = Session(Folder(folder), owner)
    session.resume(name, **how)
    session.job.wait()
    assert session.job.state == "done", session.job.error
    return session


def changed(session, *values):
    """Moves parameters by hand, one after the other."""
    for slot, value in zip(session.model.slots, values, strict=False):
        session.set(slot.address, value)


def test_a_session_is_written_at_its_first_step_and_not_before(session, folder):
    assert not (folder / PLACE).exists() and session.writer.name == ""
    changed(session, -950.0)
    assert [path.stem for path in (folder / PLACE).iterdir()] == [session.writer.name]


def test_everything_comes_back(session, folder):
    session.add("force_offset")
    session.job.wait()
    changed(session, -950.0, -700.0)
    session.fix([session.model.slots[3].address])
    session.saved("mine.yaml")
    session.undo()
    again = resumed(folder, session.writer.name)
    assert again.stage.choice == Choice(("hidden_fit.mcap",), ("hidden_unseen.mcap",), "passenger_front", stop=6.0)
    assert again.names == ("before.yaml", "linear_viscous") and len(again.others) == 1
    assert again.history.at == session.history.at == 2 and len(again.history.versions) == 4
    for mine, other in zip(again.history.versions, session.history.versions, strict=True):
        assert mine.step.model == other.step.model and mine.step.action == other.step.action
        assert np.isclose(mine.step.rmse_unseen_n, other.step.rmse_unseen_n, rtol=1e-12)
        assert again.saved_as(mine) == session.saved_as(other)
    assert error(again) == pytest.approx(error(session), rel=1e-9)
    again.redo()
    session.redo()
    assert again.model == session.model and error(again) == pytest.approx(error(session), rel=1e-9)
    assert again.here.signals == session.here.signals != again.stage.signals
    assert resumed(folder, session.writer.name, step=1).history.at == 1


def test_another_recording_leaves_the_steps_before_in_their_file(session, folder):
    changed(session, -950.0)
    first = session.writer.name
    session.open(Choice(("hidden_unseen.mcap",), stop=6.0), ["before.yaml"])
    session.job.wait()
    assert session.writer.name == ""
    changed(session, -800.0)
    assert session.writer.name not in ("", first)
    assert resumed(folder, first).model.slots[0].value == -950.0
    assert {name for name, *_ in SessionFiles(Folder(folder)).listed()} == {first, session.writer.name}


def test_the_tab_that_wrote_a_file_goes_on_in_it_and_others_get_their_own(session, folder):
    session.writer._owner = "tab"
    changed(session, -950.0)
    name = session.writer.name
    mine, colleague = resumed(folder, name, "tab"), resumed(folder, name, "other")
    crowded = resumed(folder, name, "tab", alone=False)
    for other in (colleague, crowded):
        other.undo()
        changed(other, -800.0)
        assert other.writer.name not in ("", name)
    assert resumed(folder, name).model.slots[0].value == -950.0
    changed(mine, -900.0)
    assert mine.writer.name == name


def test_a_file_that_was_written_by_somebody_else_is_never_overwritten(session, folder):
    session.writer._owner = "tab"
    changed(session, -950.0)
    name = session.writer.name
    other = resumed(folder, name, "tab")  # a tab that was duplicated, or another studio on the same folder
    changed(other, -900.0)
    assert other.writer.name == name
    changed(session, -850.0)
    assert session.writer.name != name
    assert resumed(folder, name).model.slots[0].value == -900.0
    assert resumed(folder, session.writer.name).model.slots[0].value == -850.0


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_a_folder_that_cannot_be_written_is_said_by_rights(session, folder):
    folder.chmod(0o555)
    changed(session, -950.0)
    folder.chmod(0o755)
    assert "not kept" in session.writer.failed


def test_what_cannot_be_kept_is_said_and_the_steps_go_on(session, folder):
    (folder / PLACE).write_text("a file where the folder should be")
    changed(session, -950.0)
    assert "The steps of this page are not saved" in session.writer.failed and "\n" not in session.writer.failed
    assert session.model.slots[0].value == -950.0
    (folder / PLACE).unlink()
    changed(session, -900.0)
    assert session.writer.failed == "" and session.writer.name


@pytest.mark.parametrize("place", [".damper_studio", ".damper_studio/{name}.json"])
def test_sessions_are_not_written_through_a_link_out_of_the_folder(session, folder, tmp_path_factory, place):
    outside = tmp_path_factory.mktemp("outside")
    changed(session, -950.0)
    path = folder / place.format(name=session.writer.name)
    path.rename(folder / "away")
    path.symlink_to(outside if place == PLACE else outside / "secret.json")
    changed(session, -900.0)
    assert "leads out" in session.writer.failed and not list(outside.iterdir())


@pytest.mark.parametrize("name", ["../../etc/passwd", "/etc/passwd", "", "a" * 41, "short", "a/b/c/d/e/f/g", None, 3])
def test_a_session_of_a_hostile_name_is_refused(folder, name):
    with pytest.raises(InputError, match="is not the name of a session"):
        Session(Folder(folder)).resume(name)


def test_a_damaged_or_hostile_file_is_refused_in_one_line(session, folder):
    changed(session, -950.0)
    path = folder / PLACE / f"{session.writer.name}.json"
    whole = json.loads(path.read_text())
    spoiled = [
        "", "[]", "null", "{", "{}", "[" * 100_000, json.dumps(whole)[:-40],
        json.dumps(whole | {"steps": []}), json.dumps(whole | {"models": []}), json.dumps(whole | {"choice": None}),
        json.dumps(whole | {"at": "x"}), json.dumps(whole | {"choice": whole["choice"] | {"start": "x"}}),
    ]  # fmt: skip
    for text in spoiled:
        path.write_text(text)
        with pytest.raises(InputError, match="its file is damaged"):
            Session(Folder(folder)).resume(path.stem)
    assert SessionFiles(Folder(folder)).listed() == []
    first, last = whole["steps"]
    code = "effects:\n- !!python/object/apply:os.system [touch hacked]\n"
    for model in (code, "effects: 3", "&a [*a]", "x"):
        path.write_text(json.dumps(whole | {"steps": [first, last | {"model": model}]}))
        writing = Session(Folder(folder))
        writing.resume(path.stem)
        writing.job.wait()
        assert (
            writing.job.state == "failed"
            and "\n" not in writing.job.error
            and "should not have happened" not in writing.job.error
        )
    path.write_text(json.dumps(whole | {"choice": whole["choice"] | {"fit": ["../secret.mcap"]}}))
    writing = Session(Folder(folder))
    writing.resume(path.stem)
    writing.job.wait()
    assert "is not a name in the studio's folder" in writing.job.error
    assert not list(folder.glob("**/hacked"))


def test_a_step_that_the_file_does_not_have_is_the_last_one(session, folder):
    changed(session, -950.0)
    for step in (7, -1, None):
        assert resumed(folder, session.writer.name, step=step).history.at == 1


def test_a_page_with_unsaved_steps_is_never_let_go_for_another(session, folder):
    sessions = Sessions(Folder(folder))
    page = sessions.new()
    changed(session, -950.0)
    sessions.of(page).resume(session.writer.name)
    sessions.of(page).job.wait()
    assert sessions.of(page).unsaved
    for _ in range(3 * MOST):
        sessions.new()
    assert sessions.of(page).unsaved and len(sessions) == MOST
    sessions.close()


def test_where_all_pages_have_unsaved_steps_a_further_one_is_refused(folder, monkeypatch):
    sessions = Sessions(Folder(folder))
    monkeypatch.setattr(Session, "unsaved", True)
    pages = [sessions.new() for _ in range(MOST)]
    with pytest.raises(InputError, match="pages with unsaved steps are open"):
        sessions.new()
    assert len(sessions) == MOST
    sessions.leave(pages[0])
    sessions.new()
    sessions.close()


def test_an_address_names_what_is_open():
    choice = Choice(("a.mcap", "b & c.mcap"), ("d.mcap",), "", "map.yaml", 1.5, None)
    fields = fields_of(choice, "front", ("m.yaml", "coulomb"), "abcdefgh", 2)
    pairs = [(name, item) for name, value in fields.items() for item in (value if isinstance(value, list) else [value])]
    from urllib.parse import urlencode

    text = urlencode([(name, item) for name, item in pairs if item not in (None, "")])
    found = parsed_address(f"?{text}&from=1&to=2.5&show=1&tab=steps")
    assert found.choice == Choice(choice.fit, choice.unseen, "front", "map.yaml", 1.5, None)
    assert (found.models, found.session, found.step) == (("m.yaml", "coulomb"), "abcdefgh", 2)
    assert found.view == (1, 1.0, 2.5) and found.tab == "steps" and found.opens


@pytest.mark.parametrize(
    "query", [None, 3, [], "?" + "x" * LONGEST, "?" + "a=1&" * 500, "?step=x&from=nan&to=inf&show=-1"]
)
def test_an_address_that_says_nothing_opens_nothing(query):
    found = parsed_address(query)
    assert not found.opens and found.step is None and found.view == (0, None, None)
