"""A short soak: the closed loop under faults of every channel, compared with the truth; `make soak` is the long one."""

import re
import subprocess
import sys
import warnings
from pathlib import Path

SOAK = Path(__file__).resolve().parents[2] / "benchmarks" / "soak.py"
KINDS = (
    "displacement NaN", "displacement gap", "displacement jump", "displacement late", "displacement other endianness",
    "current silent", "current wild", "current NaN", "temperature NaN", "temperature silent", "clock forward",
    "desired force NaN", "parameters: refused",
)  # fmt: skip
SECONDS, RATE = 40, 250  # a slow rate, for a machine that runs other tests as well


def soak(*words: str) -> subprocess.CompletedProcess:
    """A campaign of the kinds above."""
    only = [word for kind in KINDS for word in ("--only", kind)]
    command = [sys.executable, SOAK, str(SECONDS), str(RATE), *only, *words]
    return subprocess.run(command, capture_output=True, text=True, timeout=1200)


def test_no_fault_makes_a_wrong_force_good_or_keeps_the_loop_passive(domain):
    """The seed is random. A finding must repeat with the seed, of the same kind under the same faults: a machine
    that runs other tests as well can halt for a second anywhere, which is no fault of the node; the half hour of
    `make soak` is there for what is rare.
    """
    first = soak()
    found = sorts(first)
    if not found:
        return
    seed = re.search(r"seed (\d+)", first.stdout)
    assert seed, first.stdout
    warnings.warn(f"found once: {first.stdout[-2000:]}", stacklevel=1)
    again = soak("--seed", seed[1])
    assert not found & sorts(again), again.stdout[-6000:]


def sorts(done: subprocess.CompletedProcess) -> set[tuple[str, ...]]:
    """What a campaign found, without its numbers, with the faults during which it came."""
    assert "kinds of violations; repeat with" in done.stdout, done.stdout[-6000:] + done.stderr[-3000:]
    texts = re.findall(r"^VIOLATION round \d+, at [\d.]+ s: (.*); during or after (.*)$", done.stdout, re.MULTILINE)
    assert bool(texts) == bool(done.returncode), done.stdout[-6000:] + done.stderr[-3000:]
    return {(re.sub(r"-?\d[\d.]*", "#", what), *(kind for kind in KINDS if kind in faults)) for what, faults in texts}
