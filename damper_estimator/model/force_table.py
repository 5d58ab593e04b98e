"""A model as force-velocity tables: its steady force at one displacement.

Each force is that of a passage at constant velocity through the chosen displacement: friction and hysteresis are
sliding, lags and delays have settled, the acceleration is zero. This is the middle of the model's loops; at velocity 0
it is the mean of both directions of approach. A table has no memory: hysteresis, dependence on position, and heating
are lost.

Outside the velocities of the fit the table does not use the model, as a polynomial soon reverses there. It continues
linearly from the edge of the region, or constant if the force falls at the edge (see ``model.continuation``). Outside
the fit's commands and temperatures it uses the model.

Files: ``force_velocity.csv`` (velocity_m_s, command, temperature_degc, force_n, in_region; our signs, empty for a
channel without effect; in_region is 1 inside the region of the fit, 0 outside, empty for a model without region) and
for every command and temperature a property file of the kind that ADAMS reads for dampers (``.dpr``): plain text, ``$``
starts a comment, ``[UNITS]`` says mm, N and s, and ``[CURVE]`` lists velocity and force on a line each, rising,
positive in extension and where the force resists it; ADAMS interpolates the points with a spline.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from damper_estimator.effects.discovery import find_effect
from damper_estimator.errors import InputError
from damper_estimator.files import write_text
from damper_estimator.model.continuation import Axis, continuation
from damper_estimator.model.damper_model import DamperModel
from damper_estimator.model.element import Element, make_element, walk
from damper_estimator.signals.layout import COMMAND, DT, PRESSURE, ROWS, TEMPERATURE, A, T, V, X

APPROACH = 0.02  # m, distance at constant velocity: several times the travel that builds up friction
_LONGEST = 5.0  # s, longest duration of an approach
_HOLD = 0.4  # s, in which lags and delays settle
_STEP, _MOST_STEPS = 1e-3, 20_000
_SHARES = (0.005, 0.01, 0.02, 0.035, 0.05, 0.075, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.65, 0.8, 1.0)
_EDGE = 0.1  # of the region: its outer part that determines the slope outside
COLUMNS = ("velocity_m_s", "command", "temperature_degc", "force_n", "in_region")
_WITHOUT_REGION = COLUMNS[:4]  # tables from elsewhere can lack in_region


@dataclass(frozen=True)
class ForceTable:
    """Forces over velocity, command and temperature.

    Attributes:
        velocity: (k,) m/s, rising.
        commands, temperatures: (c,), (t,); a single NaN without such a channel.
        force: (c, t, k) N.
        displacement: m, of the passage.
        inside: (c, t, k) bool, whether in the region of the fit; None for a model without region.
    """

    velocity: np.ndarray
    commands: np.ndarray
    temperatures: np.ndarray
    force: np.ndarray
    displacement: float
    inside: np.ndarray | None = None


def force_table(
    model: DamperModel,
    velocity: np.ndarray | None = None,
    commands: Sequence[float] = (),
    temperatures: Sequence[float] = (),
    displacement: float = 0.0,
) -> ForceTable:
    """The model's steady force on a grid.

    Args:
        velocity: (k,) m/s; None chooses a grid that is fine around zero, over the region of the last fit or to 1 m/s,
            with the knots of the model's curves.
        commands, temperatures: empty chooses five over the region of the last fit, or none without such a channel.
        displacement: m.

    Raises:
        InputError: if the model contains effects of the measurement chain, or has no finite force at a point.
    """
    if model.channel_effects:
        raise InputError(
            f"model {model.name}: {', '.join(model.channel_effects)} belong to the measurement chain; "
            "remove them before the export"
        )
    v = velocity_grid(model) if velocity is None else np.unique(np.asarray(velocity, float))
    levels = [_levels(model, name, given) for name, given in (("command", commands), ("temperature", temperatures))]
    force = np.array([[_curve(model, v, displacement, c, t) for t in levels[1]] for c in levels[0]])
    if not np.isfinite(force).all():
        c, t, k = np.argwhere(~np.isfinite(force))[0]
        raise InputError(
            f"model {model.name}: has no finite force at {v[k]:g} m/s, command {levels[0][c]:g}, temperature "
            f"{levels[1][t]:g}; specify the currents and temperatures that it needs"
        )
    return ForceTable(v, levels[0], levels[1], force, displacement, _inside(model, *levels, v))


def _curve(
    model: DamperModel, velocity: np.ndarray, displacement: float, command: float, temperature: float
) -> np.ndarray:
    """(k,) steady forces; outside the region of the fit they continue the inner ones."""
    low, high = _region(model, "velocity") or (-np.inf, np.inf)
    outside = (velocity < low) | (velocity > high)
    if not (outside.any() and low < high):
        return np.array([steady_force(model, v, displacement, command, temperature) for v in velocity])
    ends = [low, low + _EDGE * (high - low), high - _EDGE * (high - low), high]
    computed = np.concatenate([velocity[~outside], ends])
    force = np.array([steady_force(model, v, displacement, command, temperature) for v in computed])
    inside = computed.size - len(ends)
    knots = np.concatenate([velocity[velocity < low], ends, velocity[velocity > high]])
    known = np.isin(knots, ends)
    values = np.zeros(knots.size)
    values[known] = force[inside:]
    every = np.zeros(velocity.size)
    every[~outside] = force[:inside]
    every[outside] = (continuation([Axis(knots, True)], known, values) @ values)[~known]
    return every


def _inside(model: DamperModel, *axes: np.ndarray) -> np.ndarray | None:
    """(c, t, k) bool: whether commands, temperatures and velocities lie in the region of the fit."""
    if "region" not in model.fit:
        return None
    within = []
    for name, values in zip(("command", "temperature", "velocity"), axes, strict=True):
        low, high = _region(model, name) or (-np.inf, np.inf)
        within.append(~((values < low) | (values > high)))
    return within[0][:, None, None] & within[1][:, None] & within[2]


def velocity_grid(model: DamperModel) -> np.ndarray:
    """Default velocities of tables, m/s, rising."""
    low, high = _region(model, "velocity") or (-1.0, 1.0)
    low, high = min(low, 0.0), max(high, 0.0)
    knots = [k for e in walk(model.effects) for k in _knots(e) if low <= k <= high]
    return np.unique(np.concatenate([low * np.array(_SHARES), [0.0], high * np.array(_SHARES), knots]))


def _knots(element: Element) -> tuple[float, ...]:
    knots = element.settings.get("velocity", ())
    return knots if isinstance(knots, tuple) else ()


def _region(model: DamperModel, name: str) -> tuple[float, float] | None:
    region = model.fit.get("region")
    bounds = region.get(name) if isinstance(region, dict) else None
    return (float(bounds[0]), float(bounds[1])) if bounds else None


def _levels(model: DamperModel, name: str, given: Sequence[float]) -> np.ndarray:
    if len(given):
        return np.unique(np.asarray(given, float))
    bounds = _region(model, name)
    return np.array([np.nan]) if bounds is None else np.unique(np.round(np.linspace(*bounds, 5), 6))


def steady_force(
    model: DamperModel, velocity: float, displacement: float, command: float = np.nan, temperature: float = np.nan
) -> float:
    """Force in N when a passage at constant velocity reaches a displacement; at rest the mean of both directions."""
    if velocity == 0.0:
        slow = min(APPROACH / _LONGEST, 1e-3)
        arrivals = [_arrival(model, sign * slow, 0.0, displacement, command, temperature) for sign in (1.0, -1.0)]
        return 0.5 * sum(arrivals)
    return _arrival(model, velocity, velocity, displacement, command, temperature)


def _arrival(
    model: DamperModel, approach: float, velocity: float, displacement: float, command: float, temperature: float
) -> float:
    seconds = min(APPROACH / abs(approach), _LONGEST)
    steps = int(np.clip(np.ceil(seconds / _STEP), 50, _MOST_STEPS))
    hold = round(_HOLD / _STEP)
    block = np.zeros((ROWS, 1 + steps + hold))
    block[DT, 1 : 1 + steps] = seconds / steps
    block[DT, 1 + steps :] = _STEP
    block[T] = np.cumsum(block[DT])
    # The passage ends at the displacement; the velocity then stays without further motion until lags have settled.
    block[X] = displacement - approach * np.maximum(seconds - block[T], 0.0)
    block[V, : 1 + steps], block[V, 1 + steps :] = approach, velocity
    block[A] = 0.0
    block[COMMAND], block[TEMPERATURE], block[PRESSURE] = command, temperature, np.nan
    return float(model.force(block)[-1])


def table_csv(table: ForceTable) -> str:
    """The table in long form: one line for each velocity, command and temperature."""
    lines = [",".join(COLUMNS)]
    for i, command in enumerate(table.commands):
        for j, temperature in enumerate(table.temperatures):
            for k, velocity in enumerate(table.velocity):
                inside = "" if table.inside is None else f"{table.inside[i, j, k]:d}"
                numbers = (velocity, command, temperature, table.force[i, j, k])
                lines.append(",".join([*map(_number, numbers), inside]))
    return "\n".join(lines) + "\n"


def _number(value: float) -> str:
    return "" if np.isnan(value) else repr(float(value))


def property_text(model: DamperModel, table: ForceTable, command: int, temperature: int) -> str:
    """One curve of a table as a damper property file with a [CURVE] block, in mm/s and N."""
    setting = f"command {table.commands[command]:g}, temperature {table.temperatures[temperature]:g} deg C".replace(
        "nan", "none"
    )
    beyond = [] if table.inside is None else table.velocity[~table.inside[command, temperature]].tolist()
    lines = [
        "$" + "-" * 60 + "HEADER", "[MDI_HEADER]", "FILE_TYPE = 'dpr'", "FILE_VERSION = 4.0", "FILE_FORMAT = 'ASCII'",
        f"$ model {model.name}; {setting}; displacement {1e3 * table.displacement:g} mm",
        "$ steady force at constant velocity, no memory; positive in extension",
        *([f"$ outside the region of the fit: {', '.join(f'{1e3 * v:g}' for v in beyond)} mm/s"] if beyond else []),
        "$" + "-" * 60 + "UNITS", "[UNITS]", "LENGTH = 'mm'", "ANGLE = 'degrees'", "FORCE = 'newton'",
        "MASS = 'kg'", "TIME = 'second'",
        "$" + "-" * 60 + "CURVE", "[CURVE]", "{   vel          force}",
    ]  # fmt: skip
    rows = zip(1e3 * table.velocity, table.force[command, temperature], strict=True)
    return "\n".join([*lines, *(f"{v:14.8g} {f:14.8g}" for v, f in rows)]) + "\n"


def read_table(path: Path) -> ForceTable:
    """A table that ``write_tables`` wrote as CSV.

    Raises:
        InputError: if it is not a table.
    """
    try:
        head, *lines = path.read_text(encoding="utf-8").split()
        rows = np.array([[float(cell or "nan") for cell in line.split(",")] for line in lines])
    except (OSError, ValueError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: cannot be read as a table; it needs the columns {', '.join(COLUMNS)}") from error
    columns = tuple(head.split(","))
    if columns not in (COLUMNS, _WITHOUT_REGION) or rows.ndim != 2 or rows.shape[1] != len(columns):
        raise InputError(f"{path}: is not a force-velocity table; it needs the columns {', '.join(COLUMNS)}")
    axes = [np.unique(rows[:, i]) for i in range(3)]
    velocity, commands, temperatures = axes
    shape = commands.size, temperatures.size, velocity.size
    inside = None if columns != COLUMNS or np.isnan(rows[:, 4]).all() else (rows[:, 4] > 0.0).reshape(shape)
    return ForceTable(
        velocity,
        commands,
        temperatures,
        rows[:, 3].reshape(shape),
        float("nan"),
        inside,
    )


def curve_model(table: ForceTable, command: int = 0, temperature: int = 0) -> DamperModel:
    """One curve of a table as a model: a viscous curve through its points."""
    values = {"velocity": table.velocity.tolist(), "force": table.force[command, temperature].tolist()}
    return DamperModel("table", "an exported table", (make_element(find_effect("viscous_curve"), values),))


def write_tables(model: DamperModel, table: ForceTable, folder: Path) -> list[Path]:
    """Writes the CSV and one property file for every command and temperature into a folder.

    Raises:
        InputError: if it cannot be written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot be created ({error.strerror}); choose another folder") from error
    written = [folder / "force_velocity.csv"]
    write_text(written[0], table_csv(table))
    for i, command in enumerate(table.commands):
        for j, temperature in enumerate(table.temperatures):
            parts = [
                model.name,
                *(f"{v:g}{unit}" for v, unit in ((command, "A"), (temperature, "C")) if not np.isnan(v)),
            ]
            written.append(folder / f"{'_'.join(parts)}.dpr")
            write_text(written[-1], property_text(model, table, i, j))
    return written
