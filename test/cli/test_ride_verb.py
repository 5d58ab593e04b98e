"""`ride`: passive, table and identified model over the same roads, in one run."""

import json

import pytest

from damper_estimator.cli.main import main
from damper_estimator.model import load_model

SHORT = ["-d", "soft_mount", "--surface", "pothole", "--seconds", "6", "--training", "12"]


def test_the_identified_model_tracks_with_less_than_half_of_the_tables_error(tmp_path, capsys):
    files = {kind: tmp_path / f"ride.{kind}" for kind in ("json", "html")}
    words = ["-o", str(tmp_path / "kept"), "--json", str(files["json"]), "--html", str(files["html"])]
    assert main(["ride", *SHORT, *words]) == 0
    found = json.loads(files["json"].read_text())
    (scenario,) = found["dampers"]["soft_mount"]["scenarios"]
    assert scenario["ratio"] == pytest.approx(scenario["model"]["tracking_n"] / scenario["table"]["tracking_n"])
    assert scenario["ratio"] < 0.5
    for way in ("passive", "table", "model"):
        assert 0.0 < scenario[way]["weighted_acceleration"] < 3.0
        assert 0.0 < scenario[way]["tyre_load"] < 1.0
        assert 0.0 < scenario[way]["stroke"] < 0.07
    kept = load_model(tmp_path / "kept" / "soft_mount.yaml")
    assert kept.fit["residual_stddev"] == pytest.approx(found["dampers"]["soft_mount"]["rmse_fit_n"], rel=1e-3)
    assert len(list((tmp_path / "kept").glob("*.mcap"))) == 3
    assert f"{scenario['ratio']:.2f}" in capsys.readouterr().out
    page = files["html"].read_text(encoding="utf-8")
    assert "soft_mount" in page
    assert "damper force in N" in page


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["-m", "linear_viscous"], "its force does not depend on the command"),
        (["--seconds", "1", "--seed", "-2"], "seconds 1 is not between 5 and 600; seed -2 is negative"),
    ],
)
def test_unusable_input_is_refused_before_any_simulation(words, message, capsys):
    assert main(["ride", *words]) == 1
    (line,) = capsys.readouterr().err.strip().splitlines()
    assert message in line
