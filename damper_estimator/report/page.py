"""Whole pages: a template, styles, scripts, plotly and the data in one file that needs nothing else, no network."""

import json
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from functools import cache
from importlib import resources
from pathlib import Path

from jinja2 import Environment, PackageLoader

from damper_estimator.files import write_text
from damper_estimator.report.theme import themes, variables

_plotly_address: ContextVar[str] = ContextVar("plotly_address", default="")


@contextmanager
def plotly_from(address: str) -> Iterator[None]:
    """Pages rendered inside read plotly from a file at this address, relative to them, instead of holding its 5 MB."""
    token = _plotly_address.set(address)
    try:
        yield
    finally:
        _plotly_address.reset(token)


def render(
    template: str, title: str, sections: Sequence, styles: Sequence[str], script: str, data: object, **more: object
) -> str:
    """The page as HTML.

    Args:
        template: a file of this folder that extends ``base.html``.
        sections: one per damper; the templates read ``damper``, ``headline`` and what is their own.
        styles, script: files of this folder.
        data: for the script, anything that JSON can hold.
        more: further names for the template.
    """
    return (
        _environment()
        .get_template(template)
        .render(
            title=title,
            sections=sections,
            style=variables() + "".join(_asset(name) for name in styles),
            script=_asset("theme.js") + _asset(script),
            files_script=figure_script(),
            plotly="" if _plotly_address.get() else _plotly(),
            plotly_address=_plotly_address.get(),
            data=_json(data),
            themes=_json(themes()),
            **more,
        )
    )


def figure_script() -> str:
    """The script that writes figures to files."""
    return _asset("figure_files.js")


def save_plotly(path: Path) -> None:
    """Writes the file that pages rendered inside ``plotly_from`` read."""
    write_text(path, _plotly())


def _json(data: object) -> str:
    # Inside a script element only "<" could end it early.
    return json.dumps(data, ensure_ascii=False, allow_nan=False).replace("<", "\\u003c")


@cache
def _environment() -> Environment:
    return Environment(
        loader=PackageLoader("damper_estimator.report", "."), autoescape=True, trim_blocks=True, lstrip_blocks=True
    )


def _asset(name: str) -> str:
    return resources.files("damper_estimator.report").joinpath(name).read_text(encoding="utf-8")


@cache
def _plotly() -> str:
    """The library's text; read from plotly's installed files, since importing plotly takes a second."""
    return resources.files("plotly").joinpath("package_data/plotly.min.js").read_text(encoding="utf-8")
