"""Real dampers: import, fit on some recordings, judge on others; prints the tables of docs/real_data.md.

    python benchmarks/real_data.py [--models NAME ...] [--jobs 2] [--part each|together] [-o docs/real_data.md]

Two sets of recordings of magneto-rheological dampers, which are not part of the project, are read from
``../shared/data`` (or DAMPER_SHARED_DATA). Unseen means other recordings: another frequency, another amplitude.
"""

import argparse
import os
import sys
import tempfile
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import redirect_stdout
from dataclasses import dataclass
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from time import perf_counter, process_time

import numpy as np
import peers

from damper_estimator import files
from damper_estimator.cli.main import main as damper_estimator
from damper_estimator.errors import InputError
from damper_estimator.identification import fit
from damper_estimator.model import DamperModel, load_model
from damper_estimator.recordings import open_bag
from damper_estimator.signals import Measurement, SignalMap, measure
from damper_estimator.signals.channels import damper_names
from damper_estimator.validation.comparison import compare, per_recording

ROOT = Path(__file__).resolve().parents[1]
DATA = Path(os.environ.get("DAMPER_SHARED_DATA", ROOT.parent / "shared" / "data"))
BASELINE = "memoryless_baseline"
MODELS = (
    BASELINE, "linear_viscous", "coulomb", "viscous_curve", "carrera_akutain", "dahl", "lugre", "bouc_wen",
    "bouc_wen_shifted", "kwok", "guo", "cesmeci", "lozoya_santos_simple_symmetric",
    "lozoya_santos_stiff_simple_symmetric", "lozoya_santos_inertial_simple_symmetric", "black_box_3", "black_box_6",
    "black_box_12", "mr_damper_on_mount", "mr_damper_with_play", "semi_active_on_mount", "mr_damper_with_creep",
)  # fmt: skip

MODELS_TOGETHER = ("mr_damper_current", "mr_damper_with_creep", "semi_active_on_mount", "semi_active_yield", "spencer")
CONSTANT = ("command_lag", "command_yield.time_constant")
"""Parameters that recordings at constant commands do not determine."""


@dataclass(frozen=True)
class Setting:
    """One command of one damper: recordings to fit and recordings to judge on."""

    name: str
    fitted: tuple[str, ...]
    unseen: tuple[str, ...]


@dataclass(frozen=True)
class Score:
    """One model at one setting."""

    setting: str
    model: str
    parameters: int
    esr: float
    correlation: float
    each: tuple[float, ...]
    seconds: float


UTFSM = tuple(
    Setting(
        f"{amperes} A",
        tuple(f"utfsm/{stem}_{amperes}A.mcap" for stem in ("ME25mm0x25Hz", "ME10mm2Hz")),
        tuple(f"utfsm/{stem}_{amperes}A.mcap" for stem in ("ME25mm0x5Hz", "ME5mm3Hz", "ME2mm5Hz")),
    )
    for amperes in ("0", "0.25", "0.5", "0.75", "1")
)
LABCONTROL = (
    Setting("0 V", ("lab/ensaio1.1.mcap", "lab/ensaio6.1.mcap"), tuple(f"lab/ensaio{k}.1.mcap" for k in (2, 4, 8, 10))),
    Setting(
        "0.87 V",
        ("lab/ensaio1.2.2.mcap", "lab/ensaio6.2.2.mcap"),
        tuple(f"lab/ensaio{k}.2.2.mcap" for k in (2, 4, 8, 10)),
    ),
    Setting(
        "1.98 V", ("lab/ensaio.B.1.mcap", "lab/ensaio.B.6.mcap"), tuple(f"lab/ensaio.B.{k}.mcap" for k in (3, 5, 7, 9))
    ),
)
PLANT = (
    Setting("passenger", ("bags/passenger_random.mcap",), ("bags/passenger_road.mcap", "bags/passenger_dyno.mcap")),
    Setting("semi-active", ("bags/semi_active_random.mcap",), ("bags/semi_active_road.mcap",)),
)


def installed_peers() -> list[str]:
    """The black-box peers whose libraries are installed (pip install sysidentpy scikit-learn)."""
    if find_spec("sysidentpy") and find_spec("sklearn"):
        return list(peers.PEERS)
    print("sysidentpy or scikit-learn is not installed: the table lacks the black-box peers", file=sys.stderr)
    return []


def import_all(folder: Path) -> None:
    """Converts both sets to bags under ``folder``."""
    for name, target, pattern in (("utfsm_mr_damper", "utfsm", "*.gz"), ("labcontrol_mr_damper", "lab", "*.mat")):
        inputs = sorted(str(path) for path in (DATA / name).glob(pattern))
        columns = ROOT / "config" / "columns" / f"{name}.yaml"
        with redirect_stdout(sys.stderr):
            status = damper_estimator(["import", *inputs, "--columns", str(columns), "-o", str(folder / target)])
        if status:
            raise SystemExit(status)


def read(folder: Path, paths: Sequence[str]) -> list[Measurement]:
    """The recordings; those of ``bags/`` from the project."""
    measurements = []
    for path in paths:
        with open_bag((ROOT if path.startswith("bags/") else folder) / path) as bag:
            measurements.append(measure(bag, SignalMap(), damper_names(bag)[0]))
    return measurements


def score(folder: Path, setting: Setting, name: str) -> Score:
    """Fits one model and judges it on the unseen recordings, together and one by one."""
    began = perf_counter()
    if name in peers.PEERS:
        force, count = peers.PEERS[name](read(folder, setting.fitted))
        seconds = perf_counter() - began
        return Score(setting.name, name, count, *_judged(force, read(folder, setting.unseen)), seconds)
    try:
        fitted = fit(load_model(name), read(folder, setting.fitted))
    except InputError:  # the model needs a channel that these recordings lack
        return Score(
            setting.name, name, 0, float("nan"), float("nan"), (float("nan"),) * len(setting.unseen), float("nan")
        )
    seconds = perf_counter() - began
    judged = compare(fitted.model, *read(folder, setting.unseen))
    each = tuple(part.measures.esr for part in per_recording(judged))
    measures = judged.measures
    return Score(setting.name, name, len(fitted.parameters), measures.esr, measures.correlation, each, seconds)


def _judged(force: peers.Peer, measurements: Sequence) -> tuple[float, float, tuple[float, ...]]:
    """ESR and correlation over all recordings, and ESR of each, of a peer; in band, as ``compare`` judges models."""
    pairs = [(m.in_band(m.force)[m.judged], m.in_band(force(m))[m.judged]) for m in measurements]
    each = tuple(float(np.var(modelled - measured) / np.var(measured)) for measured, modelled in pairs)
    measured, modelled = (np.concatenate(column) for column in zip(*pairs, strict=True))
    esr = float(np.var(modelled - measured) / np.var(measured))
    return esr, float(np.corrcoef(measured, modelled)[0, 1]), each


def together(folder: Path, settings: Sequence[Setting]) -> str:
    """Each model fitted once to the recordings of all commands: ESR on the unseen ones of each command, and the rms
    error of all of them."""
    seen = [measurement for setting in settings for measurement in read(folder, setting.fitted)]
    unseen = [read(folder, setting.unseen) for setting in settings]
    head = ["one model for all", "parameters", *(s.name for s in settings), "together", "fit"]
    rows = [head, ["---"] + ["---:"] * (len(head) - 1)]
    boosting = peers.PEERS_WITH_COMMAND if find_spec("sklearn") else {}
    for name in (*MODELS_TOGETHER, *boosting):
        began = process_time()
        if name in boosting:
            force, count = boosting[name](seen)
        else:
            model = load_model(name)
            fixed = [word for word in CONSTANT if any(slot.address.startswith(word) for slot in model.slots)]
            fitted = fit(model, seen, fix=fixed)
            force, count = partial(_force, fitted.model), len(fitted.parameters)
        seconds = process_time() - began
        errors = [_judged(force, measurements)[0] for measurements in unseen]
        every = [m for measurements in unseen for m in measurements]
        square = np.concatenate([(m.in_band(m.force) - m.in_band(force(m)))[m.judged] ** 2 for m in every])
        rows.append([name, str(count), *(f"{error:.4f}" for error in errors), f"{np.sqrt(square.mean()):.0f} N",
                     f"{seconds:.0f} s"])  # fmt: skip
    return "\n".join("| " + " | ".join(row) + " |" for row in rows)


def _force(model: DamperModel, measurement: Measurement) -> np.ndarray:
    return model.force(measurement.kinematics.block)


def table(settings: Sequence[Setting], scores: Sequence[Score]) -> str:
    """Models by ESR on unseen recordings (median over the settings), best first."""
    by_model: dict[str, dict[str, Score]] = {}
    for by_setting in scores:
        by_model.setdefault(by_setting.model, {})[by_setting.setting] = by_setting
    ranked = sorted(by_model.items(), key=lambda item: np.nanmedian([s.esr for s in item[1].values()]))
    head = ["model", "parameters", *(s.name for s in settings), "median", "correlation", "fit"]
    rows = [head, ["---"] + ["---:"] * (len(head) - 1)]
    for name, by_setting in ranked:
        values = [by_setting[s.name] for s in settings]
        rows.append([
            f"**{name}**" if name == BASELINE else name,
            str(max(v.parameters for v in values)),
            *(_marked(v, settings, by_model) for v in values),
            f"{np.nanmedian([v.esr for v in values]):.4f}",
            f"{np.nanmin([v.correlation for v in values]):.3f}",
            f"{np.nanmedian([v.seconds for v in values]):.1f} s",
        ])  # fmt: skip
    return "\n".join("| " + " | ".join(row) + " |" for row in rows)


def _marked(score: Score, settings: Sequence[Setting], by_model: dict[str, dict[str, Score]]) -> str:
    """The ESR, marked if the model is worse than the baseline; a dash if the model does not apply."""
    if np.isnan(score.esr):
        return "–"
    baseline = by_model.get(BASELINE, {}).get(score.setting)
    worse = baseline is not None and score.model != BASELINE and score.esr > baseline.esr
    return f"{score.esr:.4f}{' ▲' if worse else ''}"


def detail(setting: Setting, scores: Sequence[Score], names: Sequence[str]) -> str:
    """ESR of some models on each unseen recording of one setting."""
    head = ["model", *(Path(path).stem for path in setting.unseen)]
    rows = [head, ["---"] + ["---:"] * len(setting.unseen)]
    for score in scores:
        if score.setting == setting.name and score.model in names:
            rows.append([score.model, *(f"{value:.4f}" for value in score.each)])
    return "\n".join("| " + " | ".join(row) + " |" for row in rows)


def main() -> None:
    """Runs everything and writes the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--models", nargs="+", default=[*MODELS, *installed_peers()])
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--part", choices=("each", "together"), help="fits of each command alone, or of all together")
    parser.add_argument("-o", "--output", type=Path)
    arguments = parser.parse_args()
    if not DATA.is_dir():
        raise SystemExit(f"{DATA}: the real recordings are missing; set DAMPER_SHARED_DATA")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        import_all(folder)
        if arguments.part != "each":
            sets = (("utfsm_mr_damper", UTFSM), ("labcontrol_mr_damper", LABCONTROL))
            pages = [f"**{title}**\n\n{together(folder, settings)}" for title, settings in sets]
            write("together", pages, arguments.output)
        if arguments.part != "together":
            write("tables", tables(folder, arguments.models, arguments.jobs), arguments.output)


def tables(folder: Path, models: Sequence[str], jobs: int) -> list[str]:
    """Each model fitted to each command alone, on the real and on the simulated dampers."""
    parts = []
    sets = (("utfsm_mr_damper", UTFSM), ("labcontrol_mr_damper", LABCONTROL), ("simulated dampers (bags/)", PLANT))
    for title, settings in sets:
        tasks = [(folder, setting, model) for setting in settings for model in models]
        with ProcessPoolExecutor(jobs) as pool:
            scores = list(pool.map(score, *zip(*tasks, strict=True)))
        best = min((s for s in scores if s.model != BASELINE), key=lambda s: s.esr).model
        parts += [f"### {title}", table(settings, scores)]
        parts += [f"{s.name}, recording by recording:\n\n{detail(s, scores, (BASELINE, best))}" for s in settings[-1:]]
    return parts


def write(name: str, parts: Sequence[str], page: Path | None) -> None:
    """Prints the parts and puts them between the marks of that name of a page."""
    text = "\n\n".join(parts) + "\n"
    print(text, flush=True)
    if page:
        whole = page.read_text(encoding="utf-8") if page.exists() else ""
        begin, end = f"<!-- {name} -->", f"<!-- end of {name} -->"
        before, _, rest = whole.partition(begin)
        files.write_text(page, f"{before}{begin}\n\n{text}\n{end}{rest.partition(end)[2] or chr(10)}")


if __name__ == "__main__":
    main()
