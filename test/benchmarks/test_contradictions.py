"""The judge of contradictions: it sees each kind, and the verbs' answers on shipped recordings have none."""

import copy
import json
from pathlib import Path

import pytest
from contradictions import between, in_diagnosis, in_improvement
from every_recording import Draw, problems
from real_data import LABCONTROL, UTFSM, import_all, read

from damper_estimator.cli.main import main
from damper_estimator.validation import data_findings

BAGS = Path(__file__).resolve().parents[2] / "bags"


@pytest.fixture(scope="module")
def answers(tmp_path_factory):
    """A diagnosis and an improvement of the same model on the same recording."""
    folder = tmp_path_factory.mktemp("answers")
    words = [str(BAGS / "hidden_fit.mcap"), "-m", "linear_viscous", "--json"]
    assert main(["diagnose", *words, str(folder / "diagnosis.json")]) == 0
    assert main(["improve", *words, str(folder / "improvement.json"), "-o", str(folder / "better.yaml")]) == 0
    return [json.loads((folder / f"{name}.json").read_text())["dampers"]["passenger_front"]
            for name in ("diagnosis", "improvement")]  # fmt: skip


@pytest.fixture
def found(answers):
    """A copy to spoil."""
    return copy.deepcopy(answers)


def test_the_verbs_do_not_contradict_themselves_or_each_other(answers):
    diagnosis, improvement = answers
    assert diagnosis["findings"] and len(improvement["steps"]) > 1
    assert not in_diagnosis(diagnosis) and not in_improvement(improvement) and not between(diagnosis, improvement)


@pytest.mark.parametrize(
    ("spoil", "text"),
    [
        (lambda d: d.update(findings=[]), "there is no finding"),
        (lambda d: d.update(verdict="nothing_missing"), "is found"),
        (lambda d: d.update(verdict="nothing_missing", findings=[], noise_floor_n=1.0), "nothing is missing, but"),
        (lambda d: d["findings"][0].update(rmse_after_n=1e4), "is found, but the unseen error goes from"),
        (lambda d: d["findings"][0].update(confidence=1.2), "confidence 1.2"),
        (lambda d: d["findings"][0].update(tied_with=[d["findings"][0]["phenomenon"]]), "tied with itself"),
        (lambda d: d.update(noise_floor_n=1e5), "the noise floor"),
        (lambda d: d["rejected"][0].update(reason="explains nothing on unseen data"), "explains nothing, but"),
        (lambda d: d["rejected"][0].update(reason="explains 30 % of the error; 25 % required"), "25 % required"),
    ],
)
def test_it_sees_a_contradiction_in_a_diagnosis(found, spoil, text):
    diagnosis, _ = found
    spoil(diagnosis)
    assert any(text in line for line in in_diagnosis(diagnosis))


def test_it_sees_a_step_that_raises_the_error_and_a_promise_that_is_not_kept(found):
    diagnosis, improvement = found
    worse = dict(improvement["steps"][-1], action="add", rmse_unseen_n=2.0 * improvement["steps"][-1]["rmse_unseen_n"])
    assert any("raises" in line for line in in_improvement({**improvement, "steps": [*improvement["steps"], worse]}))
    diagnosis["findings"][-1]["rmse_after_n"] *= 0.5
    assert any("promised" in line for line in between(diagnosis, improvement))


@pytest.mark.parametrize(
    ("bag", "window", "model"),
    [
        ("passenger_road.mcap", (2.0, 10.0), "viscous_curve"),
        # A bound between -0.5 and 0 % was once written as -0 %.
        ("semi_active_road.mcap", None, "force_surface"),
    ],
)
def test_every_verb_answers_or_refuses_in_a_line(bag, window, model):
    found, counts = problems(Draw(BAGS / bag, window, model))
    assert not found and counts["answered"] >= 5


@pytest.fixture(scope="module")
def real_recordings(shared_data, tmp_path_factory):
    """The recordings of other labs as bags."""
    folder = tmp_path_factory.mktemp("real")
    import_all(folder)
    return folder


@pytest.mark.parametrize(
    ("bag", "window", "model"),
    [
        # Columns that are all alike once stopped the decomposition into singular values.
        ("lab/ensaio2.1.mcap", None, "semi_active_gap"),
        # A pair that is not worth its place leaves changed parameters, which need a name as well.
        ("utfsm/ME25mm0x25Hz_1A.mcap", (8.884, 15.030), "lozoya_santos_complete"),
    ],
)
def test_drawn_recordings_that_once_failed(real_recordings, bag, window, model):
    found, counts = problems(Draw(real_recordings / bag, window, model))
    assert not found and counts["answered"] >= 5


def test_zeros_differ_only_where_the_mean_force_does(real_recordings):
    """On the press the means at one current differ by up to 36 N; on the table one is 0 N, others 120 N."""

    def found(paths):
        findings = data_findings(None, read(real_recordings, paths))
        return [finding.sentence for finding in findings if finding.kind == "zero_differs"]

    press = [path for setting in UTFSM for path in (*setting.fitted, *setting.unseen)]
    table = [path for setting in LABCONTROL for path in setting.unseen]
    assert found(press) == []
    (sentence,) = found(table)
    assert "than in" in sentence and "ensaio.B.5" in sentence.partition("than in")[2]
