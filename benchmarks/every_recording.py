"""Every verb on real recordings, whole and in windows, from library models: no traceback, no contradiction.

    python benchmarks/every_recording.py                  # 120 draws of recording, window and model, a new seed
    python benchmarks/every_recording.py --seed 7 --draws 40
    FULL=1 python benchmarks/every_recording.py           # every recording with every model

Recordings are those of ``../shared/data`` (or DAMPER_SHARED_DATA) and the shipped bags. Each draw runs the verbs as a
user does; JSON is checked with ``contradictions``. Prints one line per problem, and counts.
"""

import argparse
import contextlib
import io
import json
import os
import random
import secrets
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from contradictions import between, in_diagnosis, in_improvement
from real_data import DATA, ROOT, import_all

from damper_estimator.cli.main import main as damper_estimator
from damper_estimator.model import library_models
from damper_estimator.workflows import read

DRAWS = 120
WHOLE = 0.4  # share of draws without a window
SHORTEST, LONGEST = 5.0, 30.0  # s, of a window


@dataclass(frozen=True)
class Draw:
    """A recording, a window in s (None: all of it), and a model."""

    path: Path
    window: tuple[float, float] | None
    model: str

    @property
    def words(self) -> str:
        """For people."""
        part = "whole" if self.window is None else f"{self.window[0]:.1f} to {self.window[1]:.1f} s"
        return f"{self.path.name}, {part}, {self.model}"

    @property
    def options(self) -> list[str]:
        """For a verb that accepts a window."""
        return [] if self.window is None else ["--from", f"{self.window[0]:.3f}", "--to", f"{self.window[1]:.3f}"]


def draws(recordings: list[Path], models: list[str], seed: int, count: int) -> Iterator[Draw]:
    """Draws at random."""
    chance = random.Random(seed)
    for _ in range(count):
        path = chance.choice(recordings)
        seconds = length_of(path)
        window = None
        if seconds > SHORTEST and chance.random() > WHOLE:
            length = min(chance.uniform(SHORTEST, LONGEST), seconds)
            start = chance.uniform(0.0, seconds - length)
            window = (start, start + length)
        yield Draw(path, window, chance.choice(models))


@cache
def length_of(path: Path) -> float:
    """Length of a recording, s."""
    measurement = next(iter(read(path).measurements.values()))[0]
    stamp = measurement.kinematics.stamp
    return 1e-9 * float(stamp[-1] - stamp[0])


def problems(draw: Draw) -> tuple[list[str], Counter]:
    """What is wrong with the verbs' answers, and how many verbs were refused or answered."""
    found: list[str] = []
    counts: Counter = Counter()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)

        def verb(*words: object) -> Path | None:
            target = folder / f"{words[0]}.json"
            status, report = _run([*map(str, words), "--json", str(target)])
            counts["answered" if status == 0 else "refused"] += 1
            lines = report.strip().splitlines()
            if status not in (0, 1) or "internal error" in report or "Traceback" in report:
                found.append(f"{words[0]}: {lines[-1] if lines else status}")
            elif status == 1 and len([line for line in lines if line.startswith("damper-estimator: error")]) > 1:
                found.append(f"{words[0]}: {len(lines)} lines of errors")
            return target if status == 0 else None

        model = ["-m", draw.model]
        verb("inspect", draw.path)
        verb("compare", draw.path, *model, *draw.options)
        verb("fit", draw.path, *model, *draw.options, "-o", folder / "fitted.yaml")
        start = ["-m", folder / "fitted.yaml"] if (folder / "fitted.yaml").exists() else model
        for words in (model, start) if start != model else (model,):
            diagnosed = verb("diagnose", draw.path, *words, *draw.options)
            improved = verb("improve", draw.path, *words, *draw.options, "-o", folder / "better.yaml")
            found += _contradictions(diagnosed, improved)
        verb("characterize", draw.path)
    return found, counts


def _run(words: list[str]) -> tuple[int, str]:
    """Status and standard error of a command."""
    errors = io.StringIO()
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(errors):
        try:
            status = damper_estimator(words)
        except SystemExit as left:
            status = int(left.code or 0)
    return status, errors.getvalue()


def _contradictions(diagnosed: Path | None, improved: Path | None) -> Iterator[str]:
    dampers, others = (json.loads(path.read_text())["dampers"] if path else {} for path in (diagnosed, improved))
    for name, record in dampers.items():
        yield from (f"diagnose {name}: {text}" for text in in_diagnosis(record))
        if name in others:
            yield from (f"diagnose and improve {name}: {text}" for text in between(record, others[name]))
    for name, record in others.items():
        yield from (f"improve {name}: {text}" for text in in_improvement(record))


def main() -> int:
    """Draws, runs, prints."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int)
    parser.add_argument("--draws", type=int, default=DRAWS, metavar="N")
    parser.add_argument("--workers", type=int, default=os.cpu_count(), metavar="N")
    arguments = parser.parse_args()
    seed = secrets.randbelow(1_000_000) if arguments.seed is None else arguments.seed
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        recordings = sorted((ROOT / "bags").glob("*.mcap"))
        if DATA.is_dir():
            import_all(folder)
            recordings += sorted(folder.rglob("*.mcap"))
        else:
            print(f"{DATA}: not there; only the shipped bags are used", file=sys.stderr)
        models = list(library_models())
        if os.environ.get("FULL", "") not in ("", "0"):
            drawn = [Draw(path, None, model) for path in recordings for model in models]
        else:
            drawn = list(draws(recordings, models, seed, arguments.draws))
        print(f"seed {seed}: {len(drawn)} draws of {len(recordings)} recordings and {len(models)} models", flush=True)
        counts, wrong = Counter(), 0
        with ProcessPoolExecutor(arguments.workers) as pool:
            for draw, (found, counted) in zip(drawn, pool.map(problems, drawn), strict=True):
                counts += counted
                wrong += bool(found)
                for text in found:
                    print(f"{draw.words}: {text}", flush=True)
    print(f"{wrong} of {len(drawn)} draws have problems; {counts['answered']} commands answered, "
          f"{counts['refused']} refused in a line")  # fmt: skip
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
