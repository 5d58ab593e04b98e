"""What the site generates from the code: a page per effect, equations, pictures, references."""

import os
import re
import subprocess
import sys
from xml.etree import ElementTree

import pytest
from pages import ROOT

from damper_estimator.cli.main import verbs
from damper_estimator.effects.discovery import all_effects
from damper_estimator.model import library_models

for library in ("latex2mathml", "matplotlib", "docutils"):
    pytest.importorskip(library, reason=f"{library} is installed by make env")
sys.path.insert(0, str(ROOT / "tools" / "docs"))
check = pytest.importorskip("check")
effect_pages = pytest.importorskip("effect_pages")
equations = pytest.importorskip("equations")
reference_pages = pytest.importorskip("reference_pages")
signatures = pytest.importorskip("signatures")
EFFECTS = sorted(all_effects().values(), key=lambda effect: effect.name)
NAMES = [effect.name for effect in EFFECTS]


@pytest.mark.parametrize("effect", EFFECTS, ids=NAMES)
def test_every_equation_becomes_mathml_and_keeps_its_symbols(effect):
    blocks = re.findall(r"\n\n((?: {4}.*\n)+)", effect.description)
    assert blocks
    for line in (line for block in blocks for line in equations.lines_of(block)):
        tree = ElementTree.fromstring(equations.mathml(line))
        assert tree.get("alttext") == line
        drawn = "".join(tree.itertext())
        assert set(re.findall(r"\d+(?:\.\d+)?", line)) <= set(re.findall(r"\d+(?:\.\d+)?", drawn))


@pytest.mark.parametrize(
    ("plain", "expected"),
    [
        ("F = F_c tanh(v / v_s)", r"F = F_{c} \operatorname{tanh}(v / v_{s})"),
        ("x^(1/n)", "x^{1/n}"),
        ("sqrt(1 + |v| / v_o)", r"\sqrt{1 + |v| / v_{o}}"),
        ("F <- F exp(-b (theta - theta_0))", r"F \leftarrow F \operatorname{exp}(-b (\theta  - \theta _{0}))"),
    ],
)
def test_plain_equations_are_converted(plain, expected):
    assert equations.latex(plain) == expected


@pytest.mark.parametrize("effect", EFFECTS, ids=NAMES)
def test_the_picture_of_every_effect_shows_it(effect):
    signature = signatures.signature(effect)
    assert signatures.share_changed(signature.runs, signature.without, signature.with_it) > 0.01


@pytest.mark.parametrize("effect", EFFECTS, ids=NAMES)
def test_a_page_has_everything_in_the_declaration(effect):
    page = effect_pages.page(effect, {})
    for entry in (*effect.parameters, *effect.settings):
        assert f"`{entry.name}`" in page
    assert all(part in page.replace("&lt;", "<").lower() for part in (effect.shows.lower(), effect.separate.lower()))
    assert "## Source" in page and "## How often it is found" in page


def test_pictures_are_in_two_themes_with_letters_that_can_be_read_by_machines():
    made = signatures.svgs(signatures.signature(all_effects()["coulomb"]))
    assert set(made) == {"force_light", "force_dark", "difference_light", "difference_dark"}
    for name, text in made.items():
        tree = ElementTree.fromstring(text)
        assert "velocity, m/s" in "".join(tree.itertext())
        assert (signatures.COLOURS["dark"]["ink"] in text) == name.endswith("dark")


def test_a_page_reports_a_missing_table_of_the_benchmark(monkeypatch):
    effect = all_effects()["coulomb"]
    monkeypatch.setattr(effect_pages, "bench_rows", dict)
    assert "No measurement is stored for `friction`" in effect_pages.measured(effect)
    monkeypatch.setattr(effect_pages, "bench_rows", lambda: {"friction": {"first": "80 % (70-90)"}})
    assert "80 % (70-90)" in effect_pages.measured(effect)


def test_the_bench_s_table_is_read_by_phenomenon(monkeypatch, tmp_path):
    (tmp_path / "docs").mkdir()
    table = "| hidden | first | in group |\n| --- | --- | --- |\n| friction | 4 of 5 | 5 of 5 |\n"
    text = f"### How far to trust a finding, phenomenon by phenomenon\n\n{table}\n### Next\n"
    (tmp_path / "docs" / "diagnosis_bench.md").write_text(text)
    monkeypatch.setattr(reference_pages, "ROOT", tmp_path)
    assert effect_pages.bench_rows() == {"friction": {"first": "4 of 5", "in group": "5 of 5"}}


def test_references_have_every_verb_and_every_model():
    text = reference_pages.command_line()
    assert all(f"## {verb}\n" in text for verb in verbs())
    text = reference_pages.models()
    assert all(f"## {name}\n" in text for name in library_models())


def test_the_site_builds_without_warnings_and_is_complete(tmp_path):
    """Built as by ``make docs``, without compilation."""
    pytest.importorskip("mkdocs", reason="mkdocs is installed by make env")
    words = [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "--site-dir", str(tmp_path)]
    quiet = os.environ | {"NO_MKDOCS_2_WARNING": "1", "NUMBA_DISABLE_JIT": "1"}
    done = subprocess.run(words, cwd=ROOT, env=quiet, capture_output=True, text=True)
    assert (done.returncode, done.stdout + done.stderr) == (0, "")
    assert check.faults(tmp_path) == []


def test_the_check_of_a_site_finds_faults(tmp_path):
    (tmp_path / "other.html").write_text('<h1 id="here">x</h1>')
    (tmp_path / "index.html").write_text(
        '<a href="other.html#here">a</a><a href="other.html#there">b</a><a href="no.html">c</a><img src="no.png">'
        '<script src="https://elsewhere.example/x.js"></script><a href="https://elsewhere.example">d</a>'
    )
    assert check.faults(tmp_path) == [
        "index.html: other.html#there: has no such anchor",
        "index.html: no.html: does not exist",
        "index.html: no.png: does not exist",
        "index.html: https://elsewhere.example/x.js: is loaded from elsewhere",
    ]
