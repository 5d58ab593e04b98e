"""The command line as a whole: help, exit status, one line for the user."""

import ast
import errno
import json
import subprocess
import sys
import types
from pathlib import Path

import pytest

from damper_estimator import __version__
from damper_estimator.cli import main as command_line
from damper_estimator.errors import InputError

BAGS = Path(__file__).resolve().parents[2] / "bags"
HEAVY = ("numpy", "scipy", "numba", "plotly", "rosbags", "mcap")


@pytest.fixture
def verb(monkeypatch, tmp_path):
    """Installs a verb ``probe`` that does what the test says."""

    def install(action):
        source = "def add_arguments(parser): ...\ndef run(arguments): ...\n"
        (tmp_path / "probe.py").write_text(f'"""Probes 100 % of it.\n\nMore text."""\n{source}')
        monkeypatch.setattr(command_line, "_FOLDER", tmp_path)
        module = types.ModuleType("damper_estimator.cli.probe")
        module.add_arguments = lambda parser: parser.add_argument("--count", type=int, default=1)
        module.run = action
        monkeypatch.setitem(sys.modules, module.__name__, module)

    return install


def test_every_verb_file_begins_with_a_line_that_help_can_show():
    for module in command_line.verbs().values():
        text = ast.get_docstring(ast.parse((command_line._FOLDER / f"{module}.py").read_text())) or ""
        assert 0 < len(text.partition("\n")[0]) <= 120, module


def test_help_lists_every_verb_and_imports_no_heavy_library():
    script = (
        "import sys\nfrom damper_estimator.cli.main import main\n"
        "try:\n    main(['--help'])\nexcept SystemExit as end:\n    assert end.code == 0\n"
        f"assert not set({HEAVY!r}) & set(sys.modules), set({HEAVY!r}) & set(sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    for name in command_line.verbs():
        assert f" {name} " in done.stdout.replace("\n", " \n")


def test_a_trailing_underscore_keeps_keywords_usable_as_verbs(monkeypatch, tmp_path):
    (tmp_path / "import_.py").write_text('"""Imports."""\ndef add_arguments(parser): ...\ndef run(arguments): ...\n')
    (tmp_path / "helper.py").write_text('"""No verb."""\ndef run(arguments): ...\n')
    monkeypatch.setattr(command_line, "_FOLDER", tmp_path)
    assert command_line.verbs() == {"import": "import_"}


def test_a_verb_gets_its_arguments_and_its_status_is_returned(verb):
    verb(lambda arguments: arguments.count)
    assert command_line.main(["probe", "--count", "7"]) == 7


def test_percent_signs_in_docstrings_survive_help(verb, capsys):
    verb(lambda arguments: 0)
    for words in (["--help"], ["probe", "--help"]):
        with pytest.raises(SystemExit) as end:
            command_line.main(words)
        assert end.value.code == 0
        assert "Probes 100 % of it." in capsys.readouterr().out


@pytest.mark.parametrize(
    "words", [[], ["nonsense"], ["--nonsense"], ["probe", "--count", "x"], ["probe", "--cou", "1"]]
)
def test_wrong_usage_exits_with_2(verb, words, capsys):
    verb(lambda arguments: 0)
    with pytest.raises(SystemExit) as end:
        command_line.main(words)
    assert end.value.code == 2
    assert "usage: damper-estimator" in capsys.readouterr().err


@pytest.mark.parametrize(
    "error, line",
    [
        (InputError("a.mcap: is\n empty; record again"), "damper-estimator: a.mcap: is empty; record again\n"),
        (PermissionError(errno.EACCES, "Permission denied", "b.mcap"), "damper-estimator: b.mcap: Permission denied\n"),
        (OSError(errno.ENOSPC, "No space left on device"), "damper-estimator: No space left on device\n"),
    ],
)
def test_unusable_input_is_one_line_and_status_1(verb, error, line, capsys):
    def fail(arguments):
        raise error

    verb(fail)
    assert command_line.main(["probe"]) == 1
    assert capsys.readouterr() == ("", line)


def test_an_interrupt_is_one_line_and_status_130(verb, capsys):
    def interrupt(arguments):
        raise KeyboardInterrupt

    verb(interrupt)
    assert command_line.main(["probe"]) == 130
    assert capsys.readouterr().err == "damper-estimator: interrupted\n"


@pytest.fixture
def bug(verb, monkeypatch, tmp_path):
    """A verb with a bug, and a home folder and a temporary folder for this test."""
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    monkeypatch.delenv("XDG_STATE_HOME", raising=False)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "temporary"))
    (tmp_path / "temporary").mkdir()
    verb(lambda arguments: 1 // 0)


def details_file(capsys):
    """The one line on standard error, and the file that it names."""
    line = capsys.readouterr().err
    assert line.count("\n") == 1 and line.startswith("damper-estimator: internal error: ZeroDivisionError")
    return Path(line.partition("details are in ")[2].partition(";")[0])


def test_a_bug_of_ours_is_one_line_with_status_1_and_its_details_lie_in_a_file(bug, tmp_path, capsys):
    assert command_line.main(["probe", "--count", "7"]) == 1
    path = details_file(capsys)
    assert path.parent == tmp_path / "home" / ".local" / "state" / "damper_estimator"
    details = path.read_text()
    assert "Traceback" in details and "1 // 0" in details and "'probe' '--count' '7'" in details
    assert __version__ in details


def test_the_details_of_a_bug_are_kept_where_the_home_cannot_be_written_to(bug, tmp_path, capsys):
    (tmp_path / "home").write_text("a file: nothing can be written below it")
    assert command_line.main(["probe"]) == 1
    path = details_file(capsys)
    assert path.parent == tmp_path / "temporary" / "damper_estimator" and "Traceback" in path.read_text()


def test_the_details_of_a_bug_are_printed_where_no_file_can_be_written(bug, tmp_path, capsys):
    (tmp_path / "home").write_text("")
    (tmp_path / "temporary").rmdir()
    (tmp_path / "temporary").write_text("")
    assert command_line.main(["probe"]) == 1
    shown = capsys.readouterr().err
    assert "1 // 0" in shown and shown.splitlines()[-1].endswith("please send them")


def test_a_reader_that_leaves_early_causes_no_complaint():
    listing = (
        "import sys\nfrom damper_estimator.cli import main\nmain._parser = lambda words: "
        "__import__('types').SimpleNamespace("
    )
    listing += (
        "parse_args=lambda words: __import__('types').SimpleNamespace(run=lambda arguments: "
        "print('x\\n' * 100000) or 0))\n"
    )
    listing += "sys.exit(main.main([]))"
    process = subprocess.Popen([sys.executable, "-c", listing], stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    process.stdout.close()
    assert process.stderr.read() == b""
    assert process.wait() == 141
    process.stderr.close()


@pytest.mark.parametrize("errors", [None, subprocess.STDOUT], ids=["text", "text and progress"])
def test_files_are_written_although_the_reader_of_the_text_leaves(tmp_path, errors):
    """As ``| head`` and ``2>&1 | head`` do."""
    target = tmp_path / "diagnosed.json"
    words = ["diagnose", BAGS / "hidden_fit.mcap", "-m", "linear_viscous", "--json", target]
    command = [sys.executable, "-m", "damper_estimator.cli.main", *words]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=errors)
    process.stdout.close()
    assert process.wait() == 141
    assert json.loads(target.read_text())["dampers"]


@pytest.mark.parametrize(
    ("words", "hint"),
    [
        (["prob"], "no verb 'prob'; did you mean probe?"),
        (["nothing_like_it"], "no verb 'nothing_like_it' (damper-estimator --help lists all)"),
        (["probe", "--cout", "1"], "unknown: --cout 1; did you mean --count?"),
        (["probe", "--cout=1"], "unknown: --cout=1; did you mean --count?"),
    ],
)
def test_an_unknown_word_is_answered_with_the_nearest_known_one(verb, words, hint, capsys):
    verb(lambda arguments: 0)
    with pytest.raises(SystemExit) as end:
        command_line.main(words)
    assert end.value.code == 2 and hint in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "hint"),
    [
        (["inspect", "drive_1.mcp"], "drive_1.mcp: does not exist; did you mean drive_1.mcap?"),
        (["inspect", "nowhere/drive.mcap"], "does not exist; give an .mcap file"),
        (["models", "lugree"], "neither a model file nor a model's name; did you mean lugre"),
        (["models", "ours"], "did you mean ours_1.yaml?"),
        (["models", "our_1.yaml"], "did you mean ours_1.yaml?"),
        (["effects", "oil_sprng"], "unknown effect 'oil_sprng'; did you mean oil_spring"),
        (["comfort", "--vehicle", "compact_cr"], "did you mean compact_car?"),
        (["import", "bench_1.csw", "--columns", "map.yaml", "-o", "b.mcap"], "did you mean bench_1.csv?"),
    ],
)
def test_an_unknown_file_or_name_is_answered_with_the_nearest_one(words, hint, tmp_path, monkeypatch, capsys):
    for name in ("drive_1.mcap", "ours_1.yaml", "bench_1.csv"):
        (tmp_path / name).touch()
    columns = "time: {column: t, unit: s}\ndampers: {bench: {displacement: {column: x, unit: mm}}}\n"
    (tmp_path / "map.yaml").write_text(columns)
    monkeypatch.chdir(tmp_path)
    assert command_line.main(words) == 1
    shown = capsys.readouterr().err
    assert hint in shown and shown.count("\n") == 1


def test_it_runs_as_a_module_and_tells_its_version():
    done = subprocess.run([sys.executable, "-m", "damper_estimator", "--version"], capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (0, f"damper-estimator {__version__}\n")
