"""The pages of the documentation, their blocks of code, and the commands in them."""

import re
import shlex
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PAGES = [*sorted(ROOT.glob("*.md")), ROOT / "bags" / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
PROGRAMS = {
    "damper-estimator", "make", "ros2", "python", ".venv/bin/python", "pip", "python3", "source", "rosdep", "colcon",
    "cc", "ln", "chromium", "git", "catkin_generate_changelog",
}  # fmt: skip
_FENCED = re.compile(r"^```(\w*)\n(.*?)^```", re.DOTALL | re.MULTILINE)


def fenced(text: str) -> list[tuple[str, str]]:
    """Language and content of the fenced blocks of a page."""
    return _FENCED.findall(text)


def commands(page: Path) -> list[list[str]]:
    """The words of every command in an indented or a shell block, without prompts, comments and variables before it."""
    text = page.read_text(encoding="utf-8")
    blocks = [content for language, content in fenced(text) if language in ("bash", "sh", "console")]
    plain = _FENCED.sub("\n", text)
    blocks += [line[4:] for line in _joined(plain).splitlines() if re.match(r" {4}\S", line)]
    return [words for block in blocks for line in _joined(block).splitlines() if (words := words_of(line))]


def words_of(line: str) -> list[str]:
    """The words of a line that is a command; none for anything else."""
    first = next((word for word in line.split() if not re.match(r"[A-Z_]+=", word)), "")
    if first not in PROGRAMS:
        return []
    words = shlex.split(line, comments=True)
    while re.match(r"[A-Z_]+=", words[0]):
        words = words[1:]
    return words


def _joined(text: str) -> str:
    return re.sub(r"\\\n\s*", " ", text)
