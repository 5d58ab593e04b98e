"""What the site adds to MkDocs: generated pages, and links between files of the repository as links of pages."""

import re

import effect_pages
import reference_pages
from mkdocs.structure.files import File, InclusionLevel

# Files outside docs by the page made from them.
PAGES = {
    "README.md": "index.md",
    "CONTRIBUTING.md": "contributing.md",
    "SECURITY.md": "security.md",
    "CHANGELOG.rst": "changelog.md",
    "bags/README.md": "recordings.md",
    "config/node.yaml": "node_parameters.md",
    "config/controller.yaml": "node_parameters.md",
}
_LINK = re.compile(r"(?<=\]\()(?!https?:|#|mailto:)([^)#\s]+)")
_PICTURE = re.compile(
    r"<picture>.*?srcset=\"([^\"]+)\".*?<img alt=\"([^\"]*)\" src=\"([^\"]+)\".*?</picture>", re.DOTALL
)


def on_config(config):
    """The effects' pages take their place in the navigation."""
    names = sorted(effect_pages.all_effects())
    _fill(config.nav, "effects/", ["effects/index.md", *(f"effects/{name}.md" for name in names)])
    return config


def _fill(entries, placeholder, pages):
    for entry in entries:
        for title, value in entry.items() if isinstance(entry, dict) else ():
            if value == placeholder:
                entry[title] = pages
            elif isinstance(value, list):
                _fill(value, placeholder, pages)


def on_files(files, config):
    """Adds the generated pages and pictures."""
    for made in (*reference_pages.files(), *effect_pages.files()):
        path, content = made
        files.append(File.generated(config, path, content=content, inclusion=InclusionLevel.INCLUDED))
    return files


def on_page_markdown(markdown, page, config, files):
    """Links out of docs lead to pages; a picture in two themes becomes two that the page's theme switch selects."""
    markdown = _PICTURE.sub(r"![\2](\1#only-dark)\n![\2](\3#only-light)", markdown)
    return _LINK.sub(lambda found: _page_of(found[1], page.file.src_uri), markdown)


def _page_of(target: str, source: str) -> str:
    if source in ("index.md", "contributing.md", "security.md"):
        inside = target.removeprefix("docs/")
        return PAGES.get(target, inside)
    outside = target.removeprefix("../")
    return PAGES.get(outside, target) if target.startswith("../") else target
