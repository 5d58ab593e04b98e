"""`comfort`: from any model to the figure and its numbers in one command."""

import json

import numpy as np
import pytest

from damper_estimator.cli.main import main

SHORT = ["--seconds", "10", "--amplitude", "20", "0.5"]


def test_the_modified_bouc_wen_differs_from_its_curve_at_small_excitation_and_agrees_at_large(tmp_path, capsys):
    assert main(["comfort", *SHORT, "--json", str(tmp_path / "c.json"), "--html", str(tmp_path / "c.html")]) == 0
    found = json.loads((tmp_path / "c.json").read_text())
    small, large = found["sweeps"]
    assert (small["amplitude_m"], large["amplitude_m"]) == (0.0005, 0.02)
    for axle in ("front", "rear"):
        assert small["difference"][axle] > 4.0 * large["difference"][axle]
        gain, frequency = (np.array(large["against"][axle][key]) for key in ("gain", "frequency_hz"))
        # A body on springs: more than the posts at its resonance, far less well above it.
        assert 1.0 < frequency[np.argmax(gain)] < 2.0
        assert gain.max() > 1.2
        assert gain[-1] < 0.4
    printed = capsys.readouterr().out
    assert "compact_car" in printed
    assert f"{100 * small['difference']['front']:.1f}" in printed
    page = (tmp_path / "c.html").read_text(encoding="utf-8")
    assert "body over post" in page
    assert "renault_modified_bouc_wen_point_3" in page


def test_any_model_can_be_used_and_a_curve_equals_its_single_curve(capsys):
    assert main(["comfort", "-m", "linear_viscous", *SHORT, "--json", "-"]) == 0
    for sweep in json.loads(capsys.readouterr().out)["sweeps"]:
        assert max(sweep["difference"].values()) < 0.005


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--vehicle", "hovercraft"], "neither a file nor a car's name"),
        (["--amplitude", "0"], "--amplitude must be between 0 and 50 mm"),
        (["-m", "nothing"], "neither a model file nor a model's name"),
    ],
)
def test_unusable_input_is_refused_in_one_line(words, message, capsys):
    assert main(["comfort", *words]) == 1
    assert message in capsys.readouterr().err.strip().splitlines()[-1]
