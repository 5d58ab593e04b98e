"""Where results cannot be written is said before any work."""

import argparse
import os
from pathlib import Path

import pytest

from damper_estimator.cli import improve as improve_verb
from damper_estimator.cli.main import main, parser_of, verbs
from damper_estimator.cli.output_check import FILES, PLACES, check_outputs
from damper_estimator.errors import InputError

READ = {"bags", "bag", "files", "signals", "validate", "subtract", "slow", "diagnosis", "front", "folder", "play"}


def test_every_path_of_every_verb_is_either_read_or_checked():
    paths = {
        (verb, action.dest)
        for verb in verbs()
        for action in _actions(parser_of({verb}), verb)
        if action.type is Path or action.dest in ("json", "html")
    }
    assert {("improve", "output"), ("fleet", "output"), ("export", "fmu")} <= paths
    assert {dest for _, dest in paths} - READ <= {*FILES, *PLACES}


def _actions(parser, verb):
    """All of a verb's arguments, and those of its own verbs."""
    waiting = [next(a for a in parser._actions if isinstance(a, argparse._SubParsersAction)).choices[verb]]
    while waiting:
        for action in waiting.pop()._actions:
            yield action
            if isinstance(action, argparse._SubParsersAction):
                waiting += list(dict.fromkeys(action.choices.values()))


@pytest.mark.parametrize(
    ("given", "fault"),
    [
        ({"output": "file/new.yaml"}, "file/new.yaml: cannot be created (Not a directory)"),
        ({"html": "missing/page.html"}, "there is no folder missing"),
        ({"json": "."}, "is a folder; name a file in it"),
        ({"json": "same", "html": Path("other/../same")}, "is named for two results"),
    ],
)
def test_a_place_that_cannot_be_is_named(given, fault, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").write_text("")
    (tmp_path / "other").mkdir()
    with pytest.raises(InputError) as refused:
        check_outputs(argparse.Namespace(**given))
    assert fault in str(refused.value)


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_a_folder_without_permission_is_named(tmp_path):
    tmp_path.chmod(0o500)
    with pytest.raises(InputError, match="Permission denied"):
        check_outputs(argparse.Namespace(output=tmp_path / "a" / "b.yaml"))


def test_what_can_be_written_is_accepted(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "old.yaml").write_text("")
    for given in ({"output": Path("old.yaml")}, {"output": Path("new/folder")}, {"json": "-"}, {"html": None}, {}):
        check_outputs(argparse.Namespace(**given))


def test_a_search_does_not_begin_without_a_place_for_its_result(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(improve_verb, "run", lambda arguments: pytest.fail("the work has begun"))
    (tmp_path / "file").write_text("")
    words = ["improve", "any.mcap", "-m", "viscous_curve", "-o", str(tmp_path / "file" / "m.yaml")]
    assert main(words) == 1
    assert "cannot be created (Not a directory)" in capsys.readouterr().err
