"""Values at one or two cursors in the figure over time, and their differences."""

import numpy as np
from dash import html

from damper_estimator.numbers import number
from damper_estimator.studio.linked_figures import Scene
from damper_estimator.studio.view import TRACE_NAMES, TRACES


def cursor_table(scene: Scene) -> html.Table | str:
    """A row for each cursor and one for the difference, a column for each quantity; "" without cursors."""
    cursors = scene.view.cursors
    if not cursors:
        return ""
    time = scene.whole_time
    at = [min(int(np.searchsorted(time, cursor)), time.size - 1) for cursor in cursors]
    quantities = [("time", "s", time), *scene.at_cursors()]
    values = np.array([[float(values_of[row]) for _, _, values_of in quantities] for row in at])
    lines = [(name, row) for name, row in zip("AB", values, strict=False)]
    if len(at) == 2:
        lines.append(("B − A", values[1] - values[0]))
    rows = [html.Tr([html.Th(name, scope="row"), *(html.Td(_text(value)) for value in row)]) for name, row in lines]
    titles = [html.Th([name, html.Small(f" {unit}")], scope="col") for name, unit, _ in quantities]
    return html.Table([html.Thead(html.Tr([html.Th(""), *titles])), html.Tbody(rows)], className="measures cursors")


def _text(value: float) -> str:
    return number(value, 4) if np.isfinite(value) else "–"


def further_choices(scene_kinematics: object) -> list[dict[str, str]]:
    """What the recording has besides the force, for the list of further traces."""
    there = [name for name in TRACES if np.isfinite(getattr(scene_kinematics, name)).any()]
    return [{"label": TRACE_NAMES[name], "value": name} for name in there]
