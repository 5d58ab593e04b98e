"""Pages that are made of other files: command line, models, messages, the node's parameters, recordings, changelog."""

import io
import os
from collections.abc import Iterator
from contextlib import redirect_stdout
from pathlib import Path
from unittest import mock

from docutils.core import publish_parts

from damper_estimator.cli.main import main, verbs
from damper_estimator.model import DamperModel, library_models, load_model
from damper_estimator.model.element import walk

ROOT = Path(__file__).resolve().parents[2]


def files() -> Iterator[tuple[str, str]]:
    """Path in the site and content."""
    yield "command_line.md", command_line()
    yield "models.md", models()
    yield "messages.md", messages()
    yield "node_parameters.md", node_parameters()
    yield "changelog.md", changelog()
    for path in sorted((ROOT / "docs" / "notebooks").glob("*.py")):
        yield f"notebooks/{path.stem}.md", notebook(path.read_text(encoding="utf-8"))
    for source, page in (
        ("README.md", "index.md"),
        ("CONTRIBUTING.md", "contributing.md"),
        ("SECURITY.md", "security.md"),
        ("bags/README.md", "recordings.md"),
    ):
        if (ROOT / source).exists():
            yield page, (ROOT / source).read_text(encoding="utf-8")


def help_of(*words: str) -> str:
    """What the command line prints for ``--help``."""
    text = io.StringIO()
    with redirect_stdout(text), mock.patch.dict(os.environ, {"COLUMNS": "100", "NO_COLOR": "1"}):
        try:
            main([*words, "--help"])
        except SystemExit:
            pass
    return text.getvalue().rstrip()


def command_line() -> str:
    """Every verb's help."""
    parts = ["# Command line", "What `--help` prints.", f"```text\n{help_of()}\n```"]
    for verb in verbs():
        parts += [f"## {verb}", f"```text\n{help_of(verb)}\n```"]
    return "\n\n".join(parts)


def models() -> str:
    """Every model of the library with its source, notes and effects."""
    library = [load_model(path) for path in library_models().values()]
    parts = [
        "# Models",
        "A model is a list of [effects](effects/index.md), in a YAML file of `config/models`. Values are published "
        "ones or starts; `damper-estimator fit` identifies them for your damper. `damper-estimator models NAME` "
        "prints all parameters.",
    ]
    for model in library:
        parts += [f"## {model.name}", *described(model)]
    return "\n\n".join(parts)


def described(model: DamperModel) -> Iterator[str]:
    """Source, notes and effects of a model."""
    names = dict.fromkeys(e.effect.name for e in walk(model.effects) if e.effect.kind not in ("path", "scaled"))
    linked = ", ".join(f"[{name}](effects/{name}.md)" for name in names)
    free = sum(not slot.fixed for slot in model.slots)
    yield f"{model.source.rstrip('.')}. {len(model.slots)} parameters, {free} of them identified."
    if model.notes:
        yield " ".join(model.notes.split()).replace("<", "&lt;").replace("*", r"\*").replace("_", r"\_")
    yield f"Effects: {linked}."


def messages() -> str:
    """The definitions of the messages."""
    parts = ["# Messages", "Definitions of the package `damper_msgs`, as they are in `msg_defs/msg`."]
    for path in sorted((ROOT / "msg_defs" / "msg").glob("*.msg")):
        parts += [f"## {path.stem}", f"```text\n{path.read_text(encoding='utf-8').rstrip()}\n```"]
    return "\n\n".join(parts)


def node_parameters() -> str:
    """The node's parameters, each explained with its default."""
    parts = ["# Parameters of the nodes"]
    for name, what in (("node", "The estimator"), ("controller", "The example controller")):
        text = (ROOT / "config" / f"{name}.yaml").read_text(encoding="utf-8").rstrip()
        parts += [f"## {what}", f"`config/{name}.yaml`, with the defaults:", f"```yaml\n{text}\n```"]
    return "\n\n".join(parts)


def changelog() -> str:
    """CHANGELOG.rst, which ROS tools read, as a page."""
    text = (ROOT / "CHANGELOG.rst").read_text(encoding="utf-8")
    body = publish_parts(text, writer="html5", settings_overrides={"initial_header_level": 2})["body"]
    return f"# Changelog\n\n<div>{body}</div>"


def notebook(text: str) -> str:
    """A notebook in the percent format as a page."""
    parts = []
    for cell in text.split("# %%")[1:]:
        kind, _, body = cell.partition("\n")
        if "[markdown]" in kind:
            parts.append("\n".join(line.removeprefix("#").removeprefix(" ") for line in body.strip().splitlines()))
        else:
            parts.append(f"```python\n{body.strip()}\n```")
    return "\n\n".join(parts)
