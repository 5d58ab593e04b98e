"""Completion in shells and manual pages: generated from the parsers, and valid for the programs that read them."""

import argparse
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from damper_estimator.cli.main import main, parser_of, verbs
from damper_estimator.cli.man_pages import man_pages
from damper_estimator.cli.parser_description import Command, all_commands
from damper_estimator.model import library_models

ROOT = Path(__file__).resolve().parents[2]
COMPLETE = """\
source "$1"; shift
COMP_WORDS=("$@"); COMP_CWORD=$(( $# - 1 )); COMPREPLY=()
_damper_estimator
printf '%s\\n' "${COMPREPLY[@]}"
"""


@pytest.fixture(scope="module")
def commands() -> list[Command]:
    return all_commands()


@pytest.fixture(scope="module")
def scripts(tmp_path_factory) -> dict[str, Path]:
    """The script of each shell."""
    folder, found = tmp_path_factory.mktemp("completion"), {}
    for shell in ("bash", "zsh"):
        done = subprocess.run(
            [sys.executable, "-m", "damper_estimator", "completion", shell], capture_output=True, text=True, check=True
        )
        found[shell] = folder / shell
        found[shell].write_text(done.stdout)
    return found


def completed(script: Path, folder: Path, *words: str) -> set[str]:
    """The words that bash offers after these."""
    call = ["bash", "-c", COMPLETE, "complete", str(script), "damper-estimator", *words]
    done = subprocess.run(call, capture_output=True, text=True, check=True, cwd=folder)
    assert done.stderr == ""
    return set(done.stdout.split())


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["comp"], {"compare", "completion"}),
        (["compare", "--h"], {"--help", "--html"}),
        (["compare", "-m", "bouc"], {"bouc_wen", "bouc_wen_shifted"}),
        (["compare", "hidden"], {"hidden_fit.mcap"}),
        (["compare", "-m", "dah"], {"dahl", "dahl_of_mine.yaml"}),
        (["fleet", ""], {"compare", "diagnose", "fit", "replay"}),
        (["fleet", "fit", "--joint", ""], {"damper", "vehicle"}),
        (["effects", "oil"], {"oil_spring"}),
        (["models", "spen"], {"spencer"}),
        (["add", "spring_"], {"spring_rate_error"}),
        (["synth", "--hide", "cav"], {"cavitation"}),
        (["completion", ""], {"bash", "zsh"}),
        (["fit", "--seed", ""], set()),
    ],
)
def test_bash_completes_verbs_options_choices_names_and_files(words, expected, scripts, tmp_path):
    if shutil.which("bash") is None:
        pytest.skip("bash is not installed")
    for name in ("hidden_fit.mcap", "dahl_of_mine.yaml"):
        (tmp_path / name).touch()
    assert completed(scripts["bash"], tmp_path, *words) == expected


def test_bash_offers_every_option_of_every_verb(scripts, tmp_path):
    if shutil.which("bash") is None:
        pytest.skip("bash is not installed")
    for verb in verbs():
        (nested,) = (
            action.choices for action in parser_of({verb})._actions if isinstance(action, argparse._SubParsersAction)
        )
        flags = {flag for action in nested[verb]._actions for flag in action.option_strings}
        assert completed(scripts["bash"], tmp_path, verb, "-") == flags, verb


def test_zsh_reads_its_script(scripts):
    zsh = shutil.which("zsh")
    if zsh is None:
        pytest.skip("zsh is not installed")
    done = subprocess.run([zsh, "-n", scripts["zsh"]], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")


def test_the_script_for_zsh_describes_every_option(scripts, commands):
    text = scripts["zsh"].read_text()
    assert text.startswith("#compdef damper-estimator\n")
    for command in commands:
        for flag in (flag for option in command.options for flag in option.flags):
            assert f"*{flag}[" in text


def test_there_is_a_page_for_the_program_and_every_command(commands):
    pages = man_pages(commands)
    assert {f"damper-estimator-{verb}.1" for verb in verbs()} | {"damper-estimator.1"} <= set(pages)
    for command in commands:
        page = pages["-".join(("damper-estimator", *command.words)) + ".1"].replace("\\-", "-").replace("\\:", "")
        for argument in command.arguments:
            assert all(flag in page for flag in argument.flags) and argument.value in page, (command.words, argument)
        assert all(f"damper-estimator {example}\n" in page for example in command.examples)
    assert library_models().keys() & set(pages["damper-estimator.1"].split()) == set()


def test_groff_accepts_the_pages(commands, tmp_path):
    groff = shutil.which("groff")
    if groff is None:
        pytest.skip("groff is not installed")
    for name, text in man_pages(commands).items():
        (tmp_path / name).write_text(text)
        call = [groff, "-man", "-Tutf8", "-ww", "-z", tmp_path / name]
        done = subprocess.run(call, capture_output=True, text=True)
        assert (done.returncode, done.stderr) == (0, ""), name


def test_the_script_in_tools_writes_the_pages(tmp_path, commands):
    (tmp_path / "damper-estimator-of-old.1").touch()
    subprocess.run([sys.executable, ROOT / "tools" / "man_pages", tmp_path], check=True, capture_output=True)
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == man_pages(commands)


def test_the_default_of_an_option_does_not_depend_on_this_machine(commands, monkeypatch):
    monkeypatch.setattr(os, "cpu_count", lambda: 191)
    assert man_pages(all_commands()) == man_pages(commands)


def test_an_unknown_shell_is_wrong_usage(capsys):
    with pytest.raises(SystemExit) as end:
        main(["completion", "fish"])
    assert end.value.code == 2 and "bash" in capsys.readouterr().err
