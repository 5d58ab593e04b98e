"""Folders with recordings as a user has them, and the studio without a browser."""

import shutil
from pathlib import Path

import pytest
from studio_page import BAGS

pytest.importorskip("dash", reason="the studio is not installed (pip install 'damper_estimator[studio]')")
pytest.importorskip("dash", reason="the studio is not installed (pip install 'damper_estimator[studio]')")

from damper_estimator.model import parse_model, save_model
from damper_estimator.studio.folder import Folder
from damper_estimator.studio.session import Session
from damper_estimator.studio.stage import Choice

# The curve that hidden_base.mcap gives, before the damper's oil took up air.
CURVE = {
    "velocity": [-0.76, -0.38, -0.15, -0.076, -0.038, -0.015, 0.0, 0.015, 0.039, 0.078, 0.156, 0.39, 0.78],
    "force": [-986.0, -763.0, -612.0, -456.0, -386.0, -301.0, -234.0, -150.0, 5.4, 121.0, 365.0, 633.0, 980.0],
}


@pytest.fixture
def folder(tmp_path) -> Path:
    """A folder with the shipped recordings of a damper in which something has changed, and its model from before."""
    for name in ("hidden_fit", "hidden_unseen"):
        shutil.copy(BAGS / f"{name}.mcap", tmp_path)
    content = {"name": "before", "source": "hidden_base.mcap", "effects": [{"viscous_curve": CURVE}]}
    save_model(parse_model(content, "before.yaml"), tmp_path / "before.yaml")
    return tmp_path


@pytest.fixture
def session(folder) -> Session:
    """Four seconds of both recordings, open."""
    session = Session(Folder(folder))
    session.open(Choice(("hidden_fit.mcap",), ("hidden_unseen.mcap",), stop=6.0), ["before.yaml", "linear_viscous"])
    session.job.wait()
    assert session.job.state == "done", session.job.error
    yield session
    session.close()
