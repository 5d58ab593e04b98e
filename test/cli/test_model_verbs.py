"""`add`, `effects` and `models`."""

import json

import pytest

from damper_estimator.cli.main import main
from damper_estimator.effects.discovery import all_effects
from damper_estimator.model import library_models, load_model


def output(capsys, *words):
    assert main(words) == 0
    return capsys.readouterr().out


def test_all_effects_and_models_are_listed(capsys):
    effects, models = output(capsys, "effects"), output(capsys, "models")
    assert [line.split()[0] for line in effects.splitlines()[1:]] == list(all_effects())
    assert [line.split()[0] for line in models.splitlines()[1:]] == list(library_models())


@pytest.mark.parametrize("name", all_effects())
def test_every_effect_is_explained(name, capsys):
    effect, text = all_effects()[name], output(capsys, "effects", name)
    assert effect.description.strip() in text and effect.kind in text and effect.shows in text
    for parameter in effect.parameters:
        line = next(line for line in text.splitlines() if line.strip().startswith(f"{parameter.name}: "))
        assert parameter.meaning in line and f"from {parameter.lower:g} to {parameter.upper:g}" in line
    for setting in effect.settings:
        assert setting.meaning in text


@pytest.mark.parametrize("name", library_models())
def test_every_model_is_explained_with_the_equations_of_its_effects(name, capsys):
    model, text = load_model(name), output(capsys, "models", name)
    assert model.source in text and " ".join(model.notes.split()) in " ".join(text.split())
    for slot in model.slots:
        assert slot.address in text and slot.parameter.meaning in text
    for effect in model.uses() - {"path", "scaled"}:
        assert all_effects()[effect].description.strip().splitlines()[2].strip() in text


def test_the_same_in_json(capsys):
    effects = json.loads(output(capsys, "effects", "--json", "-"))["effects"]
    assert {entry["name"] for entry in effects} == set(all_effects())
    coulomb = json.loads(output(capsys, "effects", "coulomb", "--json", "-"))
    assert coulomb["phenomenon"] == "friction" and coulomb["parameters"][0]["unit"] == "N"
    model = json.loads(output(capsys, "models", "carrera_akutain", "--json", "-"))
    assert sum(not p["fixed"] for p in model["parameters"]) == 14
    assert len(json.loads(output(capsys, "models", "--json", "-"))["models"]) == len(library_models())


def test_an_unknown_name_is_refused(capsys):
    assert main(["effects", "coulom"]) == 1
    assert "coulomb" in capsys.readouterr().err
    assert main(["models", "carera"]) == 1


def test_an_effect_is_put_where_its_kind_belongs(tmp_path, capsys):
    out = str(tmp_path / "a.yaml")
    output(capsys, "add", "force_lag", "-m", "coulomb", "-o", out)
    output(capsys, "add", "viscous", "-m", out, "-o", out, "--set", "rate=1234")
    text = output(capsys, "add", "oil_spring", "-m", out, "-o", out, "--set", "stiffness_rebound=1e6")
    model = load_model(out)
    assert [e.effect.name for e in model.effects] == ["oil_spring", "static_force", "force_lag"]
    assert [e.effect.name for e in model.effects[0].path] == ["coulomb", "viscous"]
    values = {slot.address: slot.value for slot in model.slots}
    assert values["viscous.rate"] == 1234.0 and values["oil_spring.stiffness_rebound"] == 1e6
    assert "oil_spring" in text


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (["nothing_known"], "unknown effect"),
        (["channel_skew"], "signal map"),
        (["path"], "write it in the model file"),
        (["coulomb", "--set", "force"], "NAME=VALUE"),
        (["coulomb", "--set", "force=strong"], "NAME=VALUE"),
        (["coulomb", "--set", "mass=3"], "mass"),
        (["coulomb", "--set", "force=-3"], "outside"),
    ],
)
def test_what_cannot_be_added_is_refused(words, reason, tmp_path, capsys):
    assert main(["add", *words, "-m", "linear_viscous", "-o", str(tmp_path / "a.yaml")]) == 1
    assert reason in capsys.readouterr().err and not list(tmp_path.iterdir())
