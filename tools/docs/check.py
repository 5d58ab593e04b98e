"""Checks a built site: every link, anchor and picture inside it exists, and no page loads anything from elsewhere.

python tools/docs/check.py out/site
"""

import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

LOADED = {("script", "src"), ("img", "src"), ("source", "srcset"), ("iframe", "src"), ("link", "href")}
NAMES_ONLY = {"canonical", "next", "prev", "edit"}  # links of the head that load nothing


class Page(HTMLParser):
    """What a page refers to, and the places in it that others can refer to."""

    def __init__(self, text: str):
        super().__init__()
        self.targets: list[tuple[str, bool]] = []
        self.anchors: set[str] = set()
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Keeps links, sources and anchors."""
        attributes = {name: value or "" for name, value in attrs}
        self.anchors |= {attributes[name] for name in ("id", "name") if attributes.get(name)}
        for name in ("href", "src", "srcset"):
            if attributes.get(name):
                loads = (tag, name) in LOADED and attributes.get("rel") not in NAMES_ONLY
                self.targets.append((attributes[name], loads))


def faults(site: Path) -> list[str]:
    """What is wrong, a line each."""
    pages = {path: Page(path.read_text(encoding="utf-8")) for path in sorted(site.resolve().rglob("*.html"))}
    found = []
    for path, page in pages.items():
        if path.name == "404.html":
            continue
        for target, loads in page.targets:
            reason = fault(path, target, loads, pages)
            if reason:
                found.append(f"{path.relative_to(site.resolve())}: {target}: {reason}")
    return found


def fault(path: Path, target: str, loads: bool, pages: dict[Path, Page]) -> str:
    """What is wrong with one reference of a page; empty where nothing is."""
    parts = urlsplit(target)
    if parts.scheme == "data":
        return ""
    if parts.scheme or parts.netloc:
        return "is loaded from elsewhere" if loads else ""
    aim = (path.parent / unquote(parts.path)).resolve() if parts.path else path.resolve()
    aim = aim / "index.html" if aim.is_dir() else aim
    if not aim.exists():
        return "does not exist"
    known = pages.get(aim) if parts.fragment else None
    if known and not target.endswith(("#only-light", "#only-dark")) and unquote(parts.fragment) not in known.anchors:
        return "has no such anchor"
    return ""


def main() -> int:
    """Prints the faults of the site that is named."""
    site = Path(sys.argv[1])
    found = faults(site)
    for line in found:
        print(line, file=sys.stderr)
    if not found:
        print(f"{site}/index.html is ready; its search works behind a server: python -m http.server -d {site}")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
