"""The pictures of the README, light and dark, into docs/images.

    python tools/docs/pictures.py [story] [accuracy] [speed]

``story`` runs the hidden-effect recordings of bags/ through fit and improve. ``accuracy`` draws the table of
docs/real_data.md that `make real-data` writes, ``speed`` the table of docs/real_time.md that `make bench-node` prints.
"""

import re
import sys
from pathlib import Path

import matplotlib as mpl
from matplotlib.figure import Figure
from signatures import COLOURS, recoloured, style, svg_text

import damper_estimator as de

ROOT = Path(__file__).resolve().parents[2]
IMAGES = ROOT / "docs" / "images"
SHOWN, LIMITS = (8.0, 12.0), (-400.0, 400.0)  # s of the road that the story shows, and N
LIGHT = COLOURS["light"]
BLUE, ORANGE = LIGHT["lines"]
PEERS = ("gradient boosting", "SysIdentPy FROLS, free run")  # no models of the library


def story() -> Figure:
    """Before, the finding, after: the recordings of docs/hidden_effect.md."""
    base, fit, unseen = (de.read(ROOT / "bags" / f"hidden_{name}.mcap") for name in ("base", "fit", "unseen"))
    model = de.fit(base, "viscous_curve").model
    better = de.improve(fit, model, validate=unseen)
    figure = Figure(figsize=(11.0, 3.5))
    figure.subplots_adjust(left=0.075, right=0.985, bottom=0.15, top=0.88, wspace=0.55)
    before, finding, after = figure.subplots(1, 3, width_ratios=(1.0, 0.75, 1.0))
    for axes, each, words in ((before, model, "Before"), (after, better.model, "After")):
        _errors(axes, de.replay(unseen, each))
        axes.set_title(f"{words}: {de.compare(unseen, each).rmse_n:.0f} N rms error on the road", color=LIGHT["ink"])
    _candidates(finding, better.only.first)
    return figure


def _errors(axes, estimates) -> None:
    result = estimates.only
    time = (result.residual_stamp - result.residual_stamp[0]) * 1e-9
    shown = (time >= SHOWN[0]) & (time <= SHOWN[1])
    axes.fill_between(time[shown], result.residual[shown], color=BLUE, lw=0.8)
    axes.set(xlabel="time, s", ylabel="model - measured, N", ylim=LIMITS)


def _candidates(axes, diagnosis) -> None:
    """What the candidates take away of the squared error, each phenomenon by its best effect."""
    best: dict[str, object] = {}
    for judged in diagnosis.ranking:
        judgement = judged.refitted or judged.kept
        if judgement is not None and judged.phenomenon not in best and judgement.gain > 0.0:
            best[judged.phenomenon] = judgement
    rows = sorted(best.items(), key=lambda row: row[1].gain)[-6:]
    named = {name for one in diagnosis.findings for name in (one.phenomenon, *one.tied_with)}
    for i, (name, judgement) in enumerate(rows):
        colour = ORANGE if name in named else LIGHT["plain"]
        axes.plot([100.0 * judgement.low, 100.0 * judgement.high], [i, i], color=colour, lw=3.0, alpha=0.5)
        axes.plot([100.0 * judgement.gain], [i], color=colour, marker="o" if name in named else "s", ms=7)
    axes.set_yticks(range(len(rows)), [name.replace("_", " ") for name, _ in rows], fontsize=8.5)
    axes.set(xlabel="squared error it explains, %", xlim=(0.0, 102.0))
    axes.set_title("Finding", color=LIGHT["ink"])


def accuracy() -> Figure:
    """Error of every model on unseen recordings of a real MR damper, as `make real-data` printed it."""
    text = (ROOT / "docs" / "real_data.md").read_text(encoding="utf-8")
    table = text.partition("### utfsm_mr_damper\n\n| model |")[2].partition("\n\n")[0]
    cells = [[cell.strip(" *▲") for cell in line.strip("| ").split("|")] for line in table.splitlines()[2:]]
    rows = sorted(((float(row[-3]), row[0]) for row in cells), reverse=True)
    figure = Figure(figsize=(7.6, 5.4))
    figure.subplots_adjust(left=0.42, right=0.97, bottom=0.1, top=0.97)
    axes = figure.subplots()
    for i, (esr, name) in enumerate(rows):
        colour = ORANGE if name in PEERS else BLUE
        axes.plot([0.002, 100.0 * esr], [i, i], color=LIGHT["grid"], lw=0.8)
        axes.plot([100.0 * esr], [i], color=colour, marker="s" if name in PEERS else "o", ms=6)
    axes.set_yticks(range(len(rows)), [name for _, name in rows], fontsize=8)
    axes.set(xscale="log", xlim=(0.25, 50.0), xlabel="error variance over force variance, unseen recordings, %")
    axes.set_xticks([0.3, 1.0, 3.0, 10.0, 30.0], ["0.3", "1", "3", "10", "30"])
    return figure


def speed() -> Figure:
    """Round trip of the node compared with a relay that only republishes, as `make bench-node` printed it."""
    text = (ROOT / "docs" / "real_time.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| (\d.*?) \| ([\d.]+) ms, ([\d.]+) x.*? \| ([\d.]+) ms, ([\d.]+) x", text, re.MULTILINE)
    figure = Figure(figsize=(7.6, 2.6))
    figure.subplots_adjust(left=0.22, right=0.97, bottom=0.2, top=0.86)
    axes = figure.subplots()
    for i, (_, median, over, late, late_over) in enumerate(reversed(rows)):
        for shift, colour, dash, ends, name in (
            (0.16, BLUE, "-", (float(median), float(late)), "node: median to 99 %"),
            (-0.16, LIGHT["plain"], (0, (3, 1)), (float(median) / float(over), float(late) / float(late_over)),
             "relay in Python that only republishes"),
        ):  # fmt: skip
            axes.plot(
                ends, [i + shift] * 2, color=colour, ls=dash, lw=2.0, marker="|", ms=10, label=name if i == 0 else None
            )
    axes.set_yticks(
        range(len(rows)), [f"{row[0].split(', ')[0]} dampers, {row[0].split(', ')[1]}" for row in reversed(rows)]
    )
    axes.set(xlim=(0.0, None), ylim=(-0.5, len(rows) - 0.5), xlabel="round trip over DDS, ms")
    figure.legend(loc="upper center", ncols=2, frameon=False, labelcolor=LIGHT["ink"])
    return figure


def saved(name: str, figure: Figure) -> None:
    """Writes the picture in both themes."""
    for axes in figure.axes:
        style(axes, LIGHT)
    light = svg_text(figure)
    for theme, colours in COLOURS.items():
        path = IMAGES / f"{name}_{theme}.svg"
        path.write_text(recoloured(light, colours), encoding="utf-8")
        print(f"wrote {path.relative_to(ROOT)}")


def main() -> None:
    """Draws what is named, or all."""
    made = {"story": story, "accuracy": accuracy, "speed": speed}
    fonts = {"svg.fonttype": "none", "svg.hashsalt": "damper", "font.family": "sans-serif", "font.size": 10}
    with mpl.rc_context(fonts):
        for name in sys.argv[1:] or made:
            saved(name, made[name]())


if __name__ == "__main__":
    main()
