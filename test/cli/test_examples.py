"""The examples that end each verb's help run on the shipped recordings, as they are."""

import shlex
import signal
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

from damper_estimator.cli.main import PROGRAM, main, parser_of, verbs
from damper_estimator.recordings import open_bag

BAGS = Path(__file__).resolve().parents[2] / "bags"
# Their examples run in test_demo and test_doctor; those of the studio, which runs until it is stopped, below.
ELSEWHERE = {"demo", "doctor", "studio"}
RUN = sorted(set(verbs()) - ELSEWHERE)
OPENED = 300.0  # s in which the studio opens its page on a busy machine


def examples(verb: str) -> tuple[str, ...]:
    return import_module(f"damper_estimator.cli.{verbs()[verb]}").EXAMPLES


def words(example: str) -> list[str]:
    """The command line after the program's name, without what only a shell understands."""
    return shlex.split(example.partition(" > ")[0])


@pytest.fixture(scope="module")
def place(tmp_path_factory) -> Path:
    """A folder with the recordings and files that the examples name."""
    folder = tmp_path_factory.mktemp("examples")
    for path in BAGS.glob("*.mcap"):
        (folder / path.name).symlink_to(path)
    main(["fit", str(BAGS / "hidden_base.mcap"), "-m", "linear_viscous", "-o", str(folder / "mine.yaml")])
    with open_bag(BAGS / "hidden_fit.mcap") as bag:
        travel = bag.columns("/suspension/displacement", ("position[passenger_front]",))
        force = bag.columns("/suspension/force", ("effort[passenger_front]",))
    count = min(len(travel.values), len(force.values))
    rows = np.column_stack([0.002 * np.arange(count), 1e3 * travel.values[:count, 0], force.values[:count, 0]])
    table = "\n".join(",".join(f"{value:.6f}" for value in row) for row in rows)
    for car, recordings in {"1": ("hidden_base", "hidden_fit"), "2": ("hidden_unseen",)}.items():
        (folder / "cars" / car).mkdir(parents=True)
        for name in recordings:
            (folder / "cars" / car / f"{name}.mcap").symlink_to(BAGS / f"{name}.mcap")
    (folder / "recordings").mkdir()
    (folder / "bench.csv").write_text(f"Time [s],Displacement [mm],Force [N]\n{table}\n")
    return folder


@pytest.mark.parametrize("verb", verbs())
def test_every_verb_ends_its_help_with_two_examples_that_parse(verb, capsys):
    with pytest.raises(SystemExit) as end:
        main([verb, "--help"])
    assert end.value.code == 0
    shown = capsys.readouterr().out
    two = examples(verb)
    assert len(two) == 2 and shown.endswith("examples:\n" + "".join(f"  {PROGRAM} {example}\n" for example in two))
    for example in two:
        assert parser_of({verb}).parse_args(words(example)).verb == verb


@pytest.mark.parametrize("verb", RUN)
def test_the_examples_of_a_verb_run(verb, place, monkeypatch, capsys):
    monkeypatch.chdir(place)
    for example in examples(verb):
        assert main(words(example)) == 0, capsys.readouterr().err


@pytest.mark.parametrize("example", examples("studio"))
def test_the_examples_of_the_studio_open_a_page_and_end_with_a_signal(example, place):
    options = [] if "--port" in example else ["--port", "0"]  # the usual one may be in use
    command = [sys.executable, "-m", "damper_estimator", *words(example), *options]
    if "--no-browser" not in command:
        command.append("--no-browser")
    studio = subprocess.Popen(command, cwd=place, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    try:
        line = next(line for line in studio.stdout if "http://" in line)
    finally:
        studio.send_signal(signal.SIGINT)
        assert studio.wait(OPENED) in (0, 130)
    assert "http://" in line
