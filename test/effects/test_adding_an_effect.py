"""The page about adding an effect is correct: its file is discovered and runs."""

import re
from pathlib import Path

import numpy as np
import pytest
import yaml

from damper_estimator import effects
from damper_estimator.effects.discovery import all_effects
from damper_estimator.model import parse_model
from damper_estimator.signals.layout import DT, ROWS, V

PAGE = (Path(__file__).resolve().parents[2] / "docs" / "adding_an_effect.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```(\w+)\n(.*?)```", PAGE, re.DOTALL)


@pytest.fixture
def added(tmp_path, monkeypatch):
    """The page's effect, as one new file in a folder that discovery searches."""
    code = next(text for kind, text in BLOCKS if kind == "python" and "EFFECT" in text)
    (tmp_path / "square_orifice.py").write_text(code)
    monkeypatch.setattr(effects, "__path__", [*effects.__path__, str(tmp_path)])
    all_effects.cache_clear()
    yield
    all_effects.cache_clear()


def test_the_new_file_is_found_and_nothing_else_is_edited(added):
    effect = all_effects()["square_orifice"]
    assert effect.kind == "source" and "F = k v |v|" in effect.description


def test_the_pages_model_runs(added):
    text = next(text for kind, text in BLOCKS if kind == "yaml")
    model = parse_model(yaml.safe_load(text), "page")
    block = np.zeros((ROWS, 3))
    block[V], block[DT] = [-0.5, 0.0, 0.5], [0.0, 0.001, 0.001]
    assert model.force(block) == pytest.approx([-240.0, 0.0, 240.0])
