"""What a plan says of its chances: that a tie can be broken, that it will probably stay, or that nothing breaks it."""

import pytest

from damper_estimator.planning import HOPELESS, LIKELY
from damper_estimator.planning.criterion import Chances
from damper_estimator.planning.result import sentence_of


def said(oil: float, mount: float = 0.0) -> str:
    chances = Chances(
        0.5 * (oil + mount), 0.01, 1.0, (("oil_compressibility", oil, 0.01), ("mount_compliance", mount, 0.0))
    )
    return sentence_of(("oil_compressibility", "mount_compliance"), chances, 2.5, None)


@pytest.mark.parametrize("likely", [0.0, 0.8 * HOPELESS])
def test_only_what_can_hardly_be_decided_is_called_impossible(likely):
    assert said(likely).startswith(
        "No drive within these limits can tell oil compressibility and mount compliance apart"
    )


@pytest.mark.parametrize("likely", [HOPELESS, 0.3, 0.98 * LIKELY])
def test_a_tie_that_may_be_broken_is_said_to_stay_probably(likely):
    assert said(likely).startswith("Oil compressibility and mount compliance will probably stay tied")
    assert said(0.0, likely).startswith("Oil compressibility and mount compliance will probably stay tied")


@pytest.mark.parametrize("likely", [LIKELY, 0.9])
def test_a_test_that_separates_says_for_which_truth(likely):
    assert f"{100.0 * likely:.0f} % if it is oil compressibility, 0 % if it is mount compliance" in said(likely)
