"""A page's session: verbs, steps back and forth, work that is refused, cancelled or goes wrong; and its end."""

import threading
import time
from types import SimpleNamespace

import numpy as np
import pytest
from dash import no_update

from damper_estimator.cli.main import main
from damper_estimator.errors import InputError
from damper_estimator.studio import panels, worker_process
from damper_estimator.studio.callbacks.page_itself import _work as progress_of
from damper_estimator.studio.folder import Folder
from damper_estimator.studio.job import Job
from damper_estimator.studio.model_run import ModelRun
from damper_estimator.studio.page_layout import names_of
from damper_estimator.studio.saving import save
from damper_estimator.studio.session import Session
from damper_estimator.studio.sessions import MOST, Sessions
from damper_estimator.studio.stage import Choice


def error(session):
    return session.shown(session.model).measures.rmse_n


def test_the_agreement_is_that_of_the_comparison(session):
    shown = session.shown(session.model)
    assert shown.measures == session.comparison(shown).measures


def test_adding_lowers_the_error_and_undo_brings_it_back(session):
    before = error(session)
    session.add("oil_spring")
    session.job.wait()
    assert session.job.state == "done", session.job.error
    after = error(session)
    assert after < 0.5 * before
    session.undo()
    assert error(session) == before
    session.redo()
    assert error(session) == after
    steps = [version.step.action for version in session.history.versions]
    assert steps == ["start", "add"]
    assert session.history.now.step.rmse_unseen_n < session.history.versions[0].step.rmse_unseen_n


def test_a_parameter_moved_again_is_one_step_and_what_was_undone_is_forgotten(session):
    address = session.model.slots[0].address
    session.set(address, -900.0)
    session.set(address, -950.0)
    assert [version.step.action for version in session.history.versions] == ["start", "set"]
    session.undo()
    session.set(session.model.slots[1].address, -700.0)
    assert len(session.history.versions) == 2
    assert session.model.slots[0].value != -950.0


def test_values_beyond_their_bounds_are_refused(session):
    with pytest.raises(InputError, match="is outside"):
        session.set(session.model.slots[0].address, 1e9)
    with pytest.raises(InputError, match="no such parameter"):
        session.set("coulomb.force", 1.0)


def test_a_fixed_parameter_keeps_its_value_in_a_refit(session):
    fixed = session.model.slots[0]
    session.fix([fixed.address])
    session.refit()
    session.job.wait()
    values = {slot.address: slot.value for slot in session.model.slots}
    assert values[fixed.address] == fixed.value
    assert (
        sum(values[parameter.address] != parameter.value for parameter in session.history.versions[0].step.model.slots)
        > 5
    )


def test_a_correction_goes_to_the_map_and_not_into_the_model(session):
    before = error(session)
    session.add("force_offset")
    session.job.wait()
    assert session.job.state == "done", session.job.error
    # This gauge's zero is right: identifying its offset finds next to nothing.
    assert error(session) == pytest.approx(before, rel=1e-3)
    assert session.model.uses() == {"viscous_curve"}
    assert session.here.signals != session.stage.signals


def test_the_saved_model_and_map_give_the_same_error_on_the_command_line(session, folder, capsys):
    session.add("force_offset")
    session.job.wait()
    session.set(session.model.slots[0].address, -950.0)
    save(session, "model", "saved.yaml", replace=False)
    save(session, "map", "saved_map.yaml", replace=False)
    bags = [str(folder / name) for name in session.stage.names]
    main(["compare", *bags, "-m", str(folder / "saved.yaml"), "-s", str(folder / "saved_map.yaml"), "--to", "6",
          "--json", str(folder / "expected.json")])  # fmt: skip
    reported = (folder / "expected.json").read_text()
    assert f'"rmse_n": {error(session):.6f}'[:16] in reported


def test_long_work_is_one_at_a_time_and_can_be_cancelled(session):
    session.diagnose("kept")
    with pytest.raises(InputError, match="goes on"):
        session.refit()
    session.job.cancel()
    session.job.wait(30.0)
    assert session.job.state == "cancelled"
    assert session.diagnosis is None and error(session) > 0.0


def test_what_goes_wrong_leaves_what_was_open(session, folder):
    before = error(session)
    (folder / "cut.mcap").write_bytes((folder / "hidden_fit.mcap").read_bytes()[:3000])
    (folder / "wrong.yaml").write_text("dampers: {passenger_front: {force: {topic: /nowhere}}}\n")
    (folder / "odd.yaml").write_text("name: odd\neffects:\n- no_such_effect\n")
    (folder / "code.yaml").write_text("effects:\n- !!python/object/apply:os.system [touch hacked]\n")
    cases = [
        (Choice(("cut.mcap",)), ["before.yaml"], "cut off"),
        (Choice(("hidden_fit.mcap",), signals="wrong.yaml"), ["before.yaml"], "correct the signal map"),
        (Choice(("hidden_fit.mcap",)), ["odd.yaml"], "unknown effect"),
        (Choice(("hidden_fit.mcap",)), ["code.yaml"], "not valid YAML"),
        (Choice(("hidden_fit.mcap",), damper="nobody"), ["before.yaml"], "no damper"),
        (Choice(("gone.mcap",)), ["before.yaml"], "no longer in"),
        (Choice(("../hidden_fit.mcap",)), ["before.yaml"], "not a name"),
        (Choice(("hidden_fit.mcap",)), ["../../etc/x.yaml"], "not a name"),
        (Choice(("hidden_fit.mcap",)), ["bouc_wen_of_nobody"], "neither a model file nor"),
    ]
    for choice, models, said in cases:
        session.open(choice, models)
        session.job.wait()
        assert session.job.state == "failed" and said in session.job.error and "\n" not in session.job.error
        assert error(session) == before
    assert not (folder / "hacked").exists()


def test_a_recording_that_is_cut_off_is_read_as_far_as_it_is_whole_and_the_page_is_reported(session, folder):
    (folder / "cut.mcap").write_bytes((folder / "hidden_fit.mcap").read_bytes()[:400_000])
    session.open(Choice(("cut.mcap",)), ["before.yaml"])
    session.job.wait()
    assert session.job.state == "done", session.job.error
    assert len(session.stage.warnings) == 1 and "cut.mcap: cut off" in session.stage.warnings[0]
    reported = panels.verdict(session.comparison(session.shown(session.model)), "", session.stage.warnings)
    assert "messages are whole" in str(reported)
    session.open(Choice(("hidden_fit.mcap",)), ["before.yaml"])
    session.job.wait()
    assert session.stage.warnings == ()


def test_what_was_saved_is_known_until_the_model_changes(session, folder):
    assert session.saved_as(session.history.now) == ""
    session.set(session.model.slots[0].address, -950.0)
    session.saved("mine.yaml")
    assert session.saved_as(session.history.now) == "mine.yaml"
    session.set(session.model.slots[1].address, -700.0)
    assert session.saved_as(session.history.now) == ""
    session.saved("mine.yaml")  # the same file again: the step before is no longer in it
    session.undo()
    assert session.saved_as(session.history.now) == ""


def test_nothing_can_be_done_before_something_is_open(folder):
    session = Session(Folder(folder))
    for verb in (
        session.refit,
        session.undo,
        session.redo,
        lambda: session.diagnose("kept"),
        lambda: session.add("coulomb"),
    ):
        with pytest.raises(InputError, match="nothing is open yet"):
            verb()
    with pytest.raises(InputError, match="choose a model"):
        session.open(Choice(("hidden_fit.mcap",)), [])


def test_a_bug_in_a_work_is_reported_and_does_not_hang(capsys):
    job = Job("testing", lambda progress: 1 / 0)
    job.wait()
    assert job.state == "failed" and "ZeroDivisionError" in job.error
    assert "Traceback" in capsys.readouterr().err


def test_a_silent_page_ends_its_work_and_is_let_go_later(folder):
    sessions = Sessions(Folder(folder), silence=0.4, kept=4.0)
    page = sessions.new()
    session = sessions.of(page)

    def endless(progress):
        while True:
            progress("on and on", 0.0)
            time.sleep(0.01)

    session.job = Job("testing", endless)
    session.job.wait(5.0)
    assert session.job.state == "cancelled" and len(sessions) == 1
    end = time.monotonic() + 20.0
    while len(sessions) and time.monotonic() < end:
        time.sleep(0.1)
    with pytest.raises(InputError, match="load it again"):
        sessions.of(page)
    sessions.close()


def test_of_too_many_pages_the_most_silent_is_let_go(folder):
    sessions = Sessions(Folder(folder))
    first, second = sessions.new(), sessions.new()
    sessions.of(first)
    for _ in range(MOST - 1):
        sessions.new()
    assert len(sessions) == MOST
    sessions.of(first)
    with pytest.raises(InputError):
        sessions.of(second)
    sessions.close()


def refusing(progress):
    raise InputError("not this way")


def dying(progress):
    import os

    os._exit(3)


def adding(array, progress):
    progress("adding", 0.5)
    return array + 1.0


def test_work_in_a_separate_process_returns_its_result_and_its_refusal():
    reported = []
    done = worker_process.run_in_process(adding, (np.zeros(3),), lambda text, share: reported.append(text))
    assert done.tolist() == [1.0, 1.0, 1.0] and "adding" in reported
    with pytest.raises(InputError, match="not this way"):
        worker_process.run_in_process(refusing, (), lambda text, share: None)
    with pytest.raises(RuntimeError, match="has died"):
        worker_process.run_in_process(dying, (), lambda text, share: None)


def test_models_of_one_name_get_distinct_names():
    models = [SimpleNamespace(name=name) for name in ("soft", "soft", "hard", "soft")]
    assert names_of(models, False) == ["soft (1)", "soft (2)", "hard", "soft (3)"]
    assert names_of(models, True) == ["soft (1)", "soft as given", "hard", "soft (2)"]


def test_the_figures_do_not_wait_for_the_judgement(session, monkeypatch):
    began, go_on = threading.Event(), threading.Event()
    shown = session.shown(session.model)

    def slow(_):
        began.set()
        assert go_on.wait(60.0)

    monkeypatch.setattr(ModelRun, "comparison", slow)
    judging = threading.Thread(target=session.comparison, args=(shown,))
    drawing = threading.Thread(target=session.shown, args=(session.model,))
    judging.start()
    assert began.wait(60.0)
    drawing.start()
    drawing.join(60.0)
    assert not drawing.is_alive() and judging.is_alive()
    go_on.set()
    judging.join()


def test_the_end_of_a_work_is_reported_once_also_when_the_page_looks_while_the_next_begins(session, monkeypatch):
    reported = []

    def tick():
        seen = progress_of(session, reported[-1][0] if reported else 0)
        if seen[4] is not no_update:
            reported.append((seen[4], seen[0].split(":")[0]))

    class Slow(Job):
        def __init__(self, *given):
            tick()
            super().__init__(*given)
            tick()

    monkeypatch.setattr("damper_estimator.studio.page_state.Job", Slow)
    for verb in (lambda: session.add("oil_spring"), session.refit):
        verb()
        session.job.wait()
        assert session.job.state == "done", session.job.error
        tick()
        tick()
    assert [name for _, name in reported] == ["opening", "identifying", "identifying"]
