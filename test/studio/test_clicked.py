"""Which button a callback answers, when others trigger it because they have just been drawn."""

from contextvars import copy_context

import pytest
from dash._callback_context import context_value
from dash._utils import AttributeDict
from dash.exceptions import PreventUpdate

from damper_estimator.studio.callbacks.common import clicked

DRAWN = {"prop_id": '{"effect":"dahl","type":"add"}.n_clicks', "value": None}


def answer(*triggered):
    def run():
        context_value.set(AttributeDict(triggered_inputs=list(triggered)))
        return clicked()

    return copy_context().run(run)


@pytest.mark.parametrize("before", [[], [DRAWN], [DRAWN, DRAWN]])
def test_a_click_counts_beside_buttons_that_were_just_drawn(before):
    assert answer(*before, {"prop_id": "refit.n_clicks", "value": 1}) == "refit"
    one = {"prop_id": '{"effect":"inertia","type":"add"}.n_clicks', "value": 2}
    assert answer(*before, one, *before) == {"effect": "inertia", "type": "add"}


def test_buttons_that_were_just_drawn_are_no_click():
    with pytest.raises(PreventUpdate):
        answer(DRAWN)
