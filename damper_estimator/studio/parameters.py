"""The list of a model's parameters: a slider, a number, bounds, unit, and whether identification may move it."""

from dash import dcc, html

from damper_estimator.model import DamperModel
from damper_estimator.model.damper_model import Slot
from damper_estimator.model.element import labels
from damper_estimator.numbers import plus_minus
from damper_estimator.studio.scale import to_place

_MOST = 60  # sliders; the numbers of a longer model (a force surface) are counted, not moved by hand
_UNITS = {"1": "", "m/s^2": "m/s²", "deg C": "°C"}


def parameter_list(model: DamperModel) -> list:
    """One group per entry of the model, in order."""
    groups = []
    errors, places = model.standard_errors, model.knots
    movable = len(model.slots) <= _MOST
    for index, (label, element) in enumerate(labels(model.effects)):
        slots = [slot for slot in model.slots if slot.entry == index]
        title = [html.H3(label, title=element.effect.description.strip().partition("\n")[0])]
        if len(model.effects) > 1:
            title.append(
                html.Button("take out", id={"type": "remove", "label": label}, title=f"take {label} out of the model")
            )
        rows = [_row(slot, _certainty(slot, errors), places.get(slot.address, "")) for slot in slots]
        rows = rows if movable else [_too_many(slots)]
        groups.append(html.Section([html.Div(title, className="title"), *rows], className="entry"))
    return groups


def _too_many(slots: list[Slot]) -> html.P:
    return html.P(f"{len(slots)} numbers: too many to move by hand; refit them instead.", className="hint")


def _certainty(slot: Slot, errors: dict[str, float]) -> str:
    """What the last identification says of a value; nothing where there was none."""
    if slot.is_at_bound:
        return "at its bound"
    return plus_minus(slot.value, errors.get(slot.address, float("nan"))) if errors and not slot.fixed else ""


def _row(slot: Slot, certain: str, place: str) -> html.Div:
    low, high = slot.parameter.lower, slot.parameter.upper
    unit = _UNITS.get(slot.parameter.unit, slot.parameter.unit)
    name = slot.address.partition(".")[2]
    hint = f"{slot.parameter.meaning}; {low:g} to {high:g} {unit}"
    return html.Div(
        [
            html.Label([name, html.Small(f" {place}")], title=hint),
            html.Small(f"{low:g} … {high:g}  {certain}", className="bounds"),
            dcc.Checklist(
                [{"label": "free", "value": slot.address}], [] if slot.fixed else [slot.address],
                id={"type": "free", "address": slot.address},
            ),
            html.Div(_slider(slot), role="group", **{"aria-label": f"{slot.address}, {unit}"}),
            dcc.Input(
                type="number", value=float(f"{slot.value:.6g}"), debounce=True, step="any",
                id={"type": "number", "address": slot.address}, className="value",
            ),
            html.Small(unit, className="unit"),
        ],
        className="parameter",
    )  # fmt: skip


def _slider(slot: Slot) -> dcc.Slider:
    place = to_place(slot.value, slot.value, slot.parameter.lower, slot.parameter.upper)
    return dcc.Slider(
        0.0, 1.0, value=place, step=0.0025, marks=None, updatemode="mouseup", allow_direct_input=False,
        id={"type": "slider", "address": slot.address},
    )  # fmt: skip
