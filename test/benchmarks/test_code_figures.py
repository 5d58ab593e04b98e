"""The figures of a small package are those that can be counted by hand."""

import pytest

code_figures = pytest.importorskip("code_figures")

FILES = {
    "damper_estimator/__init__.py": "",
    "damper_estimator/a/__init__.py": "",
    "damper_estimator/a/rows.py": "from damper_estimator.b.rows import f\n\n\ndef g(self, x, *, y):\n    return f(x)\n",
    "damper_estimator/b/__init__.py": "",
    "damper_estimator/b/rows.py": '"""Docstring."""\n\n\ndef f(x):\n    # comment\n    return x\n',
    "test/test_a.py": "def test():\n    pass\n",
}
BLOCK = "".join(f"x{k} = {k}\n" for k in range(code_figures.BLOCK))


@pytest.fixture
def root(tmp_path):
    for name, text in FILES.items():
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return tmp_path


def test_sizes_names_and_imports_are_counted(root):
    found = code_figures.figures(root)
    assert (found["files of the package"], found["lines of the package"]) == (5, 11)
    assert (found["files of the tests"], found["lines of the tests"]) == (1, 2)
    assert (found["packages"], found["imports between packages"], found["repeated file names"]) == (2, 1, 1)
    assert (found["longest function, lines"], found["longest parameter list"]) == (3, 2)


def test_only_repeated_code_counts_as_repeated(root):
    title = f"lines in repeated blocks of {code_figures.BLOCK} and more"
    assert code_figures.figures(root)[title] == 0
    for package in "ab":
        (root / "damper_estimator" / package / "same.py").write_text(f'"""Text."""\nimport os\n{BLOCK}')
    assert code_figures.figures(root)[title] == 2 * code_figures.BLOCK


def test_the_table_has_a_column_for_each_revision():
    lines = code_figures.table({"old": {"files": 1}, "new": {"files": 2}}).splitlines()
    assert lines == ["|  | old | new |", "| --- | ---: | ---: |", "| files | 1 | 2 |"]
