"""A short soak: the closed loop under faults of every channel, held against the truth; `make soak` is the long one."""

import re
import subprocess
import sys
import warnings
from pathlib import Path

SOAK = Path(__file__).resolve().parents[2] / "benchmarks" / "soak.py"
KINDS = (
    "displacement NaN", "displacement gap", "displacement jump", "displacement late", "displacement other endianness",
    "current silent", "current wild", "current NaN", "temperature NaN", "temperature silent", "clock forward",
    "wish NaN", "parameters: refused",
)  # fmt: skip
SECONDS, RATE = 40, 250  # a slow rate, for a machine that runs other tests beside


def soak(*words: str) -> subprocess.CompletedProcess:
    """A campaign of the kinds above."""
    only = [word for kind in KINDS for word in ("--only", kind)]
    command = [sys.executable, SOAK, str(SECONDS), str(RATE), *only, *words]
    return subprocess.run(command, capture_output=True, text=True, timeout=1200)


def test_no_fault_makes_a_wrong_force_good_or_leaves_the_loop_passive(domain):
    """The seed is drawn. What is found must come again with the seed: a machine that runs other tests beside may halt
    for a second, which is no fault of the node's; the half hour of `make soak` is there for what is rare.
    """
    done = soak()
    if done.returncode:
        seed = re.search(r"seed (\d+)", done.stdout)
        assert seed, done.stdout[-6000:] + done.stderr[-3000:]
        warnings.warn(f"found once: {done.stdout[-2000:]}", stacklevel=1)
        done = soak("--seed", seed[1])
    assert done.returncode == 0, done.stdout[-6000:] + done.stderr[-3000:]
    assert "0 sorts of violations" in done.stdout
