"""Writes the tables of a benchmark to a page of the docs."""

from pathlib import Path

from damper_estimator import files


def write_tables(page: Path, text: str, name: str = "tables") -> None:
    """Writes the tables between the page's marks of that name and keeps the rest."""
    begin, end = f"<!-- {name} -->", f"<!-- end of {name} -->"
    content = page.read_text(encoding="utf-8") if page.exists() else ""
    before, _, rest = content.partition(begin)
    files.write_text(page, f"{before}{begin}\n\n{text}\n\n{end}{rest.partition(end)[2] or chr(10)}")
