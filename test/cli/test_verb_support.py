"""What several verbs share."""

import argparse
import json
from pathlib import Path

import numpy as np
import pytest

from damper_estimator.cli import verb_support
from damper_estimator.errors import InputError


def parse(words, *adders):
    parser = argparse.ArgumentParser()
    for add in adders:
        add(parser)
    return parser.parse_args(words)


def test_common_arguments_have_the_documented_names():
    words = "a.mcap b -m x.yaml -s map.yaml -d fl -d fr --from 1 --to 2.5 --json - --html page.html".split()
    adders = (
        verb_support.add_bags,
        verb_support.add_models,
        verb_support.add_signals,
        verb_support.add_window,
        verb_support.add_json,
        verb_support.add_html,
    )
    assert vars(parse(words, *adders)) == {
        "bags": [Path("a.mcap"), Path("b")],
        "model": "x.yaml",
        "signals": Path("map.yaml"),
        "dampers": ["fl", "fr"],
        "start": 1.0,
        "stop": 2.5,
        "json": "-",
        "html": Path("page.html"),
    }


def test_several_models_are_a_list():
    assert parse(["-m", "a", "-m", "b"], lambda parser: verb_support.add_models(parser, several=True)).models == [
        "a",
        "b",
    ]


def test_json_holds_no_nan_and_no_numpy(tmp_path):
    results = {"a": np.float64("nan"), "b": np.array([1.0, np.inf]), "c": (np.int64(3), Path("d")), 4: np.bool_(True)}
    verb_support.write_json(str(tmp_path / "r.json"), results)
    assert json.loads((tmp_path / "r.json").read_text()) == {"a": None, "b": [1.0, None], "c": [3, "d"], "4": True}


def test_json_goes_to_standard_output_for_a_dash(capsys):
    verb_support.write_json("-", {"a": 1})
    assert json.loads(capsys.readouterr().out) == {"a": 1}


def test_no_destination_writes_nothing(capsys):
    verb_support.write_json(None, {"a": 1})
    assert capsys.readouterr().out == ""


def test_an_unwritable_destination_is_named(tmp_path):
    with pytest.raises(InputError, match=r"r\.json: cannot be written"):
        verb_support.write_json(str(tmp_path / "missing" / "r.json"), {})
