"""Cases from elsewhere: read, and given a user's model."""

import json

import numpy as np
import pytest
from population import case_records, given_cases

RATE = 200.0


def write(folder, name, hidden, **more):
    time = np.arange(int(12.0 * RATE)) / RATE
    for number, role in enumerate(("base", "fit", "unseen")):
        rng = np.random.default_rng(number)
        x = sum(
            rng.uniform(0.002, 0.01) * np.sin(2.0 * np.pi * f * time + rng.uniform(0.0, 6.0)) for f in (0.9, 2.1, 4.3)
        )
        v = np.gradient(x, time)
        force = 900.0 * v + 20.0 * np.tanh(v / 0.01) + rng.standard_normal(time.size)
        if role != "base" and "gas_spring" in hidden:
            force = force + 900.0 / (1.0 - x / 0.05)
        np.savez(folder / f"{name}_{role}.npz", t=time, x=x, force=force)
    (folder / f"{name}.json").write_text(json.dumps({"hidden": hidden, **more}))


def test_a_case_from_elsewhere_is_judged_like_a_drawn_one(tmp_path):
    given = tmp_path / "given"
    given.mkdir()
    write(
        given,
        "000",
        ["gas_spring"],
        level="strong",
        strength=0.4,
        form="gas above the oil",
        damper="strut",
        drive="sines",
    )
    write(given, "001", [])
    first, second = given_cases.cards(given)
    assert (first.kind, first.hidden, first.level) == ("hidden", ("gas_spring",), "strong")
    assert (second.kind, second.hidden, second.level) == ("nothing", (), "none")
    record = case_records.record(first, 0, tmp_path / "cases", improving=False, given=given)
    assert record["family"] == "strut"
    assert record["forms"] == ["gas above the oil"]
    assert record["before"] > 2.0 * record["base"]
    assert {"gas_spring", "spring_rate_error"} & {one["phenomenon"] for one in record["findings"]}
    undisturbed = case_records.record(second, 0, tmp_path / "cases", improving=False, given=given)
    assert max(undisturbed["growth"]) < 2.0 < min(record["growth"])


def test_an_unknown_phenomenon_or_an_empty_folder_is_refused(tmp_path):
    with pytest.raises(SystemExit, match="has no case"):
        given_cases.cards(tmp_path)
    (tmp_path / "a.json").write_text('{"hidden": ["poltergeist"]}')
    with pytest.raises(SystemExit, match="no phenomenon poltergeist"):
        given_cases.cards(tmp_path)
