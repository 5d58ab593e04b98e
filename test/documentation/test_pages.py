"""Every link, picture and block of code in README and docs is right: run where a test can run it, parsed where not."""

import importlib
import importlib.util
import re
import subprocess

import numpy as np
import pytest
import yaml
from pages import PAGES, ROOT, commands, fenced

from damper_estimator.cli.main import main, verbs
from damper_estimator.model import load_model, parse_model
from damper_estimator.signals.layout import COMMAND, DT, ROWS, V

# Pages whose Python and C is run by other tests, from the page itself.
RUN_ELSEWHERE = {"python.md": "test/test_api.py", "export.md": "test/codegen/test_documented.py",
                 "adding_an_effect.md": "test/effects/test_adding_an_effect.py"}  # fmt: skip
# Pages that `make docs` makes.
GENERATED = {"command_line.md", "messages.md", "models.md", "node_parameters.md", "recordings.md", "changelog.md",
             "contributing.md", "index.md", "effects/index.md"}  # fmt: skip
NAMES = [str(page.relative_to(ROOT)) for page in PAGES]
ALL = [(page, words) for page in PAGES for words in commands(page)]
IDS = [f"{page.name}-{i}-{'-'.join(words[:2])}" for i, (page, words) in enumerate(ALL)]


def anchors(text: str) -> set[str]:
    """Anchors of a page's headings, as GitHub and the site make them."""
    headings = re.findall(r"^#+ (.+)$", re.sub(r"^```.*?^```", "", text, flags=re.DOTALL | re.MULTILINE), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).strip().replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("page", PAGES, ids=NAMES)
def test_every_link_and_picture_of_a_page_exists(page):
    text = page.read_text(encoding="utf-8")
    targets = re.findall(r"\]\(([^)\s]+)\)", text) + re.findall(r'(?:src|srcset)="([^"]+)"', text)
    for target in targets:
        path, _, anchor = target.partition("#")
        if re.match(r"https?:|mailto:", target) or (page.parent.name == "docs" and path in GENERATED):
            continue
        aim = (page.parent / path) if path else page
        assert aim.exists(), f"{page.name}: {target}"
        assert not anchor or anchor in anchors(aim.read_text(encoding="utf-8")), f"{page.name}: {target}"


def test_every_picture_in_docs_is_shown_somewhere():
    shown = "".join(page.read_text(encoding="utf-8") for page in PAGES)
    unused = [path.name for path in (ROOT / "docs" / "images").iterdir() if path.name not in shown]
    assert unused == []


@pytest.mark.parametrize(("page", "words"), ALL, ids=IDS)
def test_every_command_is_one_that_exists(page, words, monkeypatch):
    program, *rest = words
    if program == "damper-estimator":
        if rest[0] != "VERB":
            parse(rest, monkeypatch)
    elif program == "make":
        targets = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(), re.MULTILINE))
        assert {word for word in rest if "=" not in word} <= targets
    elif program in ("python", ".venv/bin/python", "python3"):
        module = rest[1] if rest[0] == "-m" else None
        assert importlib.util.find_spec(module) if module else (ROOT / rest[0]).exists()
    elif words[:3] == ["ros2", "launch", "damper_estimator"]:
        launched(rest[2:])
    else:
        done = subprocess.run(["bash", "-n", "-c", " ".join(words)], capture_output=True, text=True)
        assert done.returncode == 0, done.stderr


def parse(words, monkeypatch):
    """The command line takes these words; nothing is run."""
    cut = next((i for i, word in enumerate(words) if word in ("&&", "|", ";", ">")), len(words))
    words = [word.strip("[]") for word in words[:cut]]
    verb = words[0]
    if verb.startswith("--"):
        return
    assert verb in verbs(), f"no verb {verb}"
    module = importlib.import_module(f"damper_estimator.cli.{verbs()[verb]}")
    monkeypatch.setattr(module, "run", lambda arguments: 0)
    monkeypatch.setattr("damper_estimator.cli.main.check_outputs", lambda arguments: None)  # of earlier commands
    try:
        status = main(words)
    except SystemExit as end:
        status = end.code
    assert status == 0, " ".join(words)


def launched(words):
    """The launch file exists, and its arguments are known to it or are parameters of the nodes."""
    file, *arguments = words
    path = ROOT / "launch" / file
    known = path.read_text() + "".join(
        (ROOT / "config" / f"{name}.yaml").read_text() for name in ("node", "controller")
    )
    known += (ROOT / "damper_estimator" / "node" / "launch_arguments.py").read_text()
    for argument in arguments:
        assert argument.partition(":=")[0] in known, argument


@pytest.mark.parametrize("page", PAGES, ids=NAMES)
def test_every_yaml_block_is_yaml_and_every_model_a_model(page):
    for language, content in fenced(page.read_text(encoding="utf-8")):
        if language == "yaml":
            given = yaml.safe_load(content)
            if "square_orifice" not in content and isinstance(given, dict) and {"name", "effects"} <= given.keys():
                assert parse_model(given, page.name).effects


@pytest.mark.parametrize("page", PAGES, ids=NAMES)
def test_every_python_block_runs(page):
    blocks = [content for language, content in fenced(page.read_text(encoding="utf-8")) if language == "python"]
    if page.name in RUN_ELSEWHERE:
        test = (ROOT / RUN_ELSEWHERE[page.name]).read_text(encoding="utf-8")
        assert page.name in test and blocks
        return
    sample = np.zeros(ROWS)
    sample[V], sample[DT], sample[COMMAND] = 0.2, 0.002, 0.5
    names = {"model": load_model("semi_active_yield"), "sample": sample}
    for block in blocks:
        exec(compile(block, page.name, "exec"), names)


def test_the_lines_of_the_readme_are_those_of_the_tutorial():
    """``test_tutorials`` runs the commands of the tutorials, other tests run `demo` and `doctor`."""
    tutorial = [" ".join(words) for words in commands(ROOT / "docs" / "hidden_effect.md")]
    for words in commands(ROOT / "README.md"):
        if words[0] == "damper-estimator" and words[1] not in ("demo", "doctor"):
            line = " ".join(words).replace("bags/", "").replace("page.html", "diagnosis.html")
            assert any(command.startswith(line) for command in tutorial), line


def test_the_readme_is_short():
    assert (ROOT / "README.md").read_text(encoding="utf-8").count("\n") < 120
