"""A record of a fit that nothing can be done with is refused when the model is loaded, in one line."""

from pathlib import Path

import pytest

from damper_estimator import read
from damper_estimator.errors import InputError
from damper_estimator.identification import fit
from damper_estimator.model import load_model, parse_model
from damper_estimator.model.record_faults import record_faults
from damper_estimator.runtime.deployed import deployed

BAGS = Path(__file__).resolve().parents[2] / "bags"
BROKEN = [
    ({"force_stddev": "much"}, "force_stddev = 'much' is not a number from 0"),
    ({"residual_stddev": -3.0}, "residual_stddev = -3.0 is not a number from 0"),
    ({"cutoff": True}, "cutoff = True is not a number from 0"),
    ({"force_rms": float("nan")}, "force_rms = nan is not a number from 0"),
    ({"region": [0, 1]}, "region must be a mapping"),
    ({"region": {"velocity": [1.0, -1.0]}}, "region.velocity must be two numbers, the lower one first"),
    ({"region": {"velocity": [1.0]}}, "region.velocity must be two numbers"),
    ({"standard_errors": {"viscous.rate": "small"}}, "standard_errors.viscous.rate must be a number"),
    ("good", "must be a mapping"),
]


@pytest.mark.parametrize(("record", "fault"), BROKEN)
def test_a_broken_record_is_refused_with_the_file_and_the_remedy(record, fault):
    content = {"name": "m", "source": "s", "effects": [{"viscous": {"rate": 1500.0}}], "fit": record}
    with pytest.raises(InputError) as refused:
        parse_model(content, "mine.yaml")
    message = str(refused.value)
    assert message.startswith("mine.yaml: fit: ") and fault in message and "identify the model again" in message
    assert "\n" not in message


@pytest.mark.parametrize("record", [{}, {"bags": ["a.mcap"], "date": "2026-01-01", "mine": object()}])
def test_what_is_not_there_or_of_others_is_no_fault(record):
    assert not list(record_faults(record))


def test_what_a_fit_writes_has_no_fault():
    (measurement,) = read(BAGS / "hidden_fit.mcap").measurements["passenger_front"]
    model = fit(load_model("linear_viscous"), [measurement]).model
    assert model.fit and not list(record_faults(model.fit))
    assert deployed(model, 60.0, 0.1)
