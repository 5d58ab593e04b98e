"""The line of progress: written over on a terminal, one line per kind of work elsewhere."""

import io

import pytest

from damper_estimator.cli.progress_line import ProgressLine


class Terminal(io.StringIO):
    def isatty(self):
        return True


def test_on_a_terminal_there_is_one_line_and_it_is_gone_at_the_end(monkeypatch):
    clock = iter(range(100))
    monkeypatch.setattr("damper_estimator.cli.progress_line.monotonic", lambda: float(next(clock)))
    out = Terminal()
    with ProgressLine("front", out) as line:
        line("trying effects", 0.25)
        line("trying effects", 0.5)
        assert "\n" not in out.getvalue() and out.getvalue().count("\r") == 2
        assert "front:  50 %  trying effects  (2 s)" in out.getvalue()
    assert out.getvalue().endswith("\r\x1b[K")


def test_a_line_that_was_written_is_gone_before_an_error_is_shown():
    out = Terminal()
    with pytest.raises(KeyboardInterrupt), ProgressLine("front", out) as line:
        line("trying effects", 0.25)
        raise KeyboardInterrupt
    assert out.getvalue().endswith("\r\x1b[K")


def test_elsewhere_each_kind_of_work_is_one_line():
    out = io.StringIO()
    with ProgressLine("front", out) as line:
        for share in (0.1, 0.2, 0.3):
            line("trying effects", share)
        line("done", 1.0)
    lines = out.getvalue().splitlines()
    assert len(lines) == 2 and "trying effects" in lines[0] and lines[1].startswith("front: 100 %  done")


def test_a_terminal_is_not_flooded(monkeypatch):
    monkeypatch.setattr("damper_estimator.cli.progress_line.monotonic", lambda: 5.0)
    out = Terminal()
    with ProgressLine("front", out) as line:
        for k in range(1000):
            line("trying effects", k / 1000)
    assert out.getvalue().count("\r") == 2
