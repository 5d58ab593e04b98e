"""A short soak: the closed loop under faults of every channel, held against the truth; `make soak` is the long one."""

import subprocess
import sys
from pathlib import Path

SOAK = Path(__file__).resolve().parents[2] / "benchmarks" / "soak.py"
KINDS = (
    "displacement NaN", "displacement gap", "displacement jump", "displacement late", "displacement other endianness",
    "current silent", "current wild", "current NaN", "temperature NaN", "temperature silent", "clock forward",
    "wish NaN", "parameters: refused",
)  # fmt: skip
SECONDS, RATE = 40, 250  # a slow rate, for a machine that runs other tests beside


def test_no_fault_makes_a_wrong_force_good_or_leaves_the_loop_passive(domain):
    """The seed is drawn; a failure prints it with what was found."""
    only = [word for kind in KINDS for word in ("--only", kind)]
    done = subprocess.run(
        [sys.executable, SOAK, str(SECONDS), str(RATE), *only], capture_output=True, text=True, timeout=1200
    )
    assert done.returncode == 0, done.stdout[-6000:] + done.stderr[-3000:]
    assert "0 sorts of violations" in done.stdout
