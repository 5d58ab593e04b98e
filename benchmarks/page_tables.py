"""Writes the tables of a benchmark to a page of the docs."""

from pathlib import Path

from damper_estimator import files

BEGIN, END = "<!-- tables -->", "<!-- end of tables -->"


def write_tables(page: Path, text: str) -> None:
    """Writes the tables between the page's marks and keeps the rest."""
    content = page.read_text(encoding="utf-8") if page.exists() else ""
    before, _, rest = content.partition(BEGIN)
    files.write_text(page, f"{before}{BEGIN}\n\n{text}\n\n{END}{rest.partition(END)[2] or chr(10)}")
