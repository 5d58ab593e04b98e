"""How an effect shows: the force of a plain damper with the effect and without it, drawn from the effect's declaration.

A linear damper runs through two sines of one peak speed and different frequency, through one at two temperatures, or
through one while the current steps, whichever the effect needs. Its parameters are those with which the diagnosis
begins to look for it; where these show nothing, they are moved towards their upper limit until a twentieth of the force
changes.
"""

import io
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from damper_estimator.effects.contract import Effect, Values
from damper_estimator.effects.discovery import find_effect
from damper_estimator.effects.trial import Ranges, Untestable
from damper_estimator.model import DamperModel, Element, make_element
from damper_estimator.signals.layout import COMMAND, DT, PRESSURE, ROWS, TEMPERATURE, A, T, V, X

SPEED, AMPLITUDE = 0.38, 0.03  # m/s and m of the slow sine
RATE, CYCLES = 2000.0, 4
DAMPING = 1500.0  # N s/m of the plain damper
LEAST = 0.05  # of the force: less cannot be seen
KNOTS = np.array((-1.0, -0.5, -0.2, -0.1, -0.05, -0.02, 0.0, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0))  # m/s, of the curves
RANGES = Ranges(
    compression=-AMPLITUDE, extension=AMPLITUDE, speed=SPEED, acceleration=20.0, force=DAMPING * SPEED / 2**0.5,
    seconds=60.0, command=(0.0, 1.5), temperature=(20.0, 80.0),
)  # fmt: skip
# Where the declaration begins at nothing, or at a straight line: values that show.
EXAMPLES: dict[str, dict[str, object]] = {
    "acceleration_bracket": {"linear": 4e-5},
    "acceleration_decay": {"decay": 3.0},
    "acceleration_hysteresis": {"constant": -8.0},
    "acceleration_saturation": {"saturation": 0.8},
    "command_surface": {
        "speed": (0.1, 0.4), "span": 1.0, "rebound": (80.0, 200.0), "compression": (-80.0, -200.0),
    },
    "direction_curve": {"speed": (0.1, 0.2, 0.4), "force": (15.0, 60.0, 150.0), "side": 0.0},
    "direction_gain": {"gain": -0.4},
    "displacement_bracket": {"linear": 0.01},
    "displacement_decay": {"decay": 0.3},
    "displacement_saturation": {"saturation": 0.3},
    "dissipation_fade": {"fade": 0.03, "capacity": 10.0},
    "end_stop": {"bump_stiffness": 1e6, "bump_position": -0.02, "top_out_stiffness": 1e6, "top_out_position": 0.02},
    "force_gain_error": {"gain": 0.1},
    "force_offset": {"offset": 60.0},
    "force_surface": {"velocity": (-0.4, 0.4), "acceleration": (-20.0, 20.0), "force": (-300.0, -500.0, 500.0, 300.0)},
    "hydraulic_stop": {
        "bump_damping": 4000.0, "bump_position": -0.015, "rebound_damping": 4000.0, "rebound_position": 0.015,
        "depth": 0.01,
    },
    "gain_drift": {"gain": 0.1, "drift": 0.2, "settling": 1.0, "seconds": 1.0},
    "his_saturation": {
        "knee_velocity_rebound": 0.15, "knee_force_rebound": 225.0, "slope_rebound": 500.0,
        "knee_velocity_compression": -0.15, "knee_force_compression": -225.0, "slope_compression": 500.0,
    },
    "lost_gas": {"lost_force": 300.0, "volume": 6e-5},
    "maxwell_slip": {"travel": (2e-3, 5e-3), "force": (40.0, 60.0)},
    "motion_bracket": {"displacement": 0.01},
    "position_surface": {
        "speed": (0.1, 0.4), "reach": 0.02, "extended_rebound": (60.0, 150.0), "extended_compression": (0.0, 0.0),
        "compressed_rebound": (0.0, 0.0), "compressed_compression": (-60.0, -150.0),
    },
    "smooth_curve": {"force": tuple(500.0 * np.tanh(6.0 * KNOTS))},
    "spring_rate_error": {"rate": 4000.0},
    "static_force": {"force": 100.0},
    "temperature_surface": {
        "speed": (0.1, 0.4), "reference": 40.0, "span": 20.0, "rebound": (-60.0, -80.0), "compression": (60.0, 80.0),
    },
    "viscous_curve": {"force": tuple(500.0 * np.tanh(6.0 * KNOTS))},
}  # fmt: skip
# Blue and orange of Okabe and Ito, which all readers can distinguish; dashes distinguish them in grey as well.
COLOURS = {
    "light": {"ink": "#1f2328", "grid": "#d0d7de", "plain": "#6e7781", "lines": ("#0072b2", "#d55e00")},
    "dark": {"ink": "#e6edf3", "grid": "#3d444d", "plain": "#9198a1", "lines": ("#56b4e9", "#e69f00")},
}
DASHES = ("-", (0, (5, 2)))


@dataclass(frozen=True)
class Run:
    """One motion: its name, the sample block (8, n), and which samples are drawn."""

    name: str
    block: np.ndarray
    drawn: slice


@dataclass(frozen=True)
class Signature:
    """What is drawn: per run the block and both forces (n,) in N; over which variable the difference is shsignature."""

    runs: tuple[Run, ...]
    without: tuple[np.ndarray, ...]
    with_it: tuple[np.ndarray, ...]
    over: str
    values: Mapping[str, object]


def sine(name: str, frequency: float, temperature: float = 20.0, steps: tuple[float, float] | None = None) -> Run:
    """A sine of the peak speed ``SPEED`` at a frequency in Hz; a command in A that may step in the middle."""
    n = int(CYCLES / frequency * RATE)
    time = np.arange(n) / RATE
    omega = 2.0 * np.pi * frequency
    block = np.full((ROWS, n), np.nan)
    block[T], block[DT] = time, np.where(np.arange(n) > 0, 1.0 / RATE, 0.0)
    block[X] = -SPEED / omega * np.cos(omega * time)
    block[V] = SPEED * np.sin(omega * time)
    block[A] = SPEED * omega * np.cos(omega * time)
    low, high = steps or (1.0, 1.0)
    block[COMMAND] = np.where(time < time[-1] / 2.0, low, high)
    block[TEMPERATURE], block[PRESSURE] = temperature, 1e6
    whole = steps is not None
    return Run(name, np.ascontiguousarray(block), slice(0 if whole else n * (CYCLES - 1) // CYCLES, n))


def runs_for(effect: Effect) -> tuple[Run, ...]:
    """The motions in which an effect shows best, by the form-free tests that it declares."""
    if "temperature" in effect.tests:
        return sine("20 °C", 2.0, 20.0), sine("80 °C", 2.0, 80.0)
    if "current" in effect.tests:
        return (sine("2 Hz, from 0.3 to 1.3 A", 2.0, steps=(0.3, 1.3)),)
    return sine("2 Hz", 2.0), sine("8 Hz", 8.0)


def variable_for(effect: Effect) -> str:
    """Over what the difference is drawn."""
    if "current" in effect.tests:
        return "time"
    if {"travel", "spring", "stops", "position"} & set(effect.tests):
        return "displacement"
    return "acceleration" if "mass" in effect.tests else "velocity"


def plain(effect: Effect) -> tuple[Element, ...]:
    """The damper without the effect; one whose force follows the current where the effect acts on that."""
    damping = make_element(find_effect("viscous"), {"rate": DAMPING})
    if effect.kind in ("input", "modifier") and "current" in effect.tests:
        return damping, make_element(find_effect("semi_active_squash"))
    return (damping,)


def put(effect: Effect, values: Mapping[str, object], base: tuple[Element, ...]) -> tuple[Element, ...]:
    """The damper with the effect, where its kind belongs."""
    if effect.kind == "series":
        return (make_element(effect, values, base),)
    element = make_element(effect, values)
    return (element, *base) if effect.kind == "input" else (*base, element)


def signature(effect: Effect) -> Signature:
    """Forces with the effect and without it."""
    runs, base = runs_for(effect), plain(effect)
    without = tuple(DamperModel("plain", "", base).force(run.block) for run in runs)
    start, limits = _start(effect)
    values: Mapping[str, object] = start
    for share in (0.0, 0.02, 0.05, 0.1, 0.2, 0.4, 0.7, 1.0):
        values = {**start, **_moved(effect, start, limits, share)}
        model = DamperModel("with", "", put(effect, values, base))
        with_it = tuple(model.force(run.block) for run in runs)
        if share_changed(runs, without, with_it) >= LEAST:
            break
    shown = {slot.address.partition(".")[2]: slot.value for slot in model.slots if slot.address.startswith(effect.name)}
    return Signature(runs, without, with_it, variable_for(effect), shown)


def share_changed(runs, without, with_it) -> float:
    """RMS of the differences over that of the force, over what is drawn."""
    changes = [(b - a)[run.drawn] for run, a, b in zip(runs, without, with_it, strict=True)]
    return float(np.sqrt(np.mean(np.concatenate(changes) ** 2)) / (DAMPING * SPEED / 2**0.5))


def _start(effect: Effect) -> tuple[dict[str, object], dict[str, tuple[float, float]]]:
    if effect.name in EXAMPLES:
        return EXAMPLES[effect.name], {}
    try:
        trial = effect.trial(RANGES) if effect.trial else None
    except Untestable:
        trial = None
    return (dict(trial.values), dict(trial.limits)) if trial else ({}, {})


def _moved(effect: Effect, start: Values, limits: Mapping[str, tuple[float, float]], share: float) -> dict[str, object]:
    """The parameters, a share of the way to what is physically the most."""
    moved: dict[str, object] = {}
    for p in effect.parameters:
        first = start.get(p.name, p.default)
        if share and p.name in limits and not isinstance(first, tuple):
            moved[p.name] = first + share * (limits[p.name][1] - first)
    return moved


def svgs(signature: Signature) -> dict[str, str]:
    """The two pictures, each in both themes, by the end of the file's name; text uses the reader's font."""
    drawn = {"force": _forces, "difference": _differences}
    return {
        f"{name}_{theme}": recoloured(light, COLOURS[theme])
        for name, draw in drawn.items()
        for light in (_light(draw, signature),)
        for theme in COLOURS
    }


def _light(draw: Callable[[Axes, Signature], None], signature: Signature) -> str:
    with mpl.rc_context(
        {"svg.fonttype": "none", "svg.hashsalt": "damper", "font.family": "sans-serif", "font.size": 11}
    ):
        figure = Figure(figsize=(3.9, 3.2))
        figure.subplots_adjust(left=0.22, right=0.97, bottom=0.16, top=0.87)
        axes = figure.subplots()
        draw(axes, signature)
        style(axes, COLOURS["light"])
        handles, labels = axes.get_legend_handles_labels()
        figure.legend(handles, labels, loc="upper center", ncols=3, frameon=False, fontsize=9, columnspacing=1.2,
                      labelcolor=COLOURS["light"]["ink"])  # fmt: skip
        return svg_text(figure)


def svg_text(figure: Figure) -> str:
    """The figure as SVG for a page, without a date."""
    text = io.StringIO()
    figure.savefig(text, format="svg", transparent=True, metadata={"Date": None, "Creator": None})
    return text.getvalue()[text.getvalue().index("<svg") :]


def recoloured(light: str, colours) -> str:
    """The light picture in the colours of another theme."""
    palette = COLOURS["light"]
    pairs = [(palette[role], colours[role]) for role in ("ink", "grid", "plain")]
    for before, after in (*pairs, *zip(palette["lines"], colours["lines"], strict=True)):
        light = light.replace(before, after)
    return light


AXES = {
    "velocity": (V, 1.0, "velocity, m/s"),
    "displacement": (X, 1000.0, "displacement, mm"),
    "acceleration": (A, 1.0, "acceleration, m/s²"),
    "time": (T, 1.0, "time, s"),
}


def _forces(axes: Axes, signature: Signature) -> None:
    colours = COLOURS["light"]
    for k, (run, before, after) in enumerate(zip(signature.runs, signature.without, signature.with_it, strict=True)):
        v = run.block[V, run.drawn]
        if k == 0:
            axes.plot(v, before[run.drawn], color=colours["plain"], linewidth=1.0, label="without it")
        axes.plot(v, after[run.drawn], label=run.name, **_line(k))
    axes.set(xlabel="velocity, m/s", ylabel="force, N")


def _differences(axes: Axes, signature: Signature) -> None:
    row, scale, label = AXES[signature.over]
    for k, (run, before, after) in enumerate(zip(signature.runs, signature.without, signature.with_it, strict=True)):
        axes.plot(scale * run.block[row, run.drawn], (after - before)[run.drawn], label=run.name, **_line(k))
    axes.set(xlabel=label, ylabel="what the model lacks, N")


def _line(k: int) -> dict[str, Any]:
    return {"color": COLOURS["light"]["lines"][k], "linestyle": DASHES[k], "linewidth": 1.6}


def style(axes: Axes, colours: Mapping[str, Any]) -> None:
    """Grid, ticks and letters in the colours of a theme."""
    axes.grid(color=colours["grid"], linewidth=0.6)
    axes.set_axisbelow(True)
    axes.tick_params(colors=colours["ink"])
    axes.xaxis.label.set_color(colours["ink"])
    axes.yaxis.label.set_color(colours["ink"])
    for spine in axes.spines.values():
        spine.set_color(colours["grid"])
