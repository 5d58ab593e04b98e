"""The linters of ROS, set to the project's style, find nothing.

They belong to the system or to a sourced ROS 2, not to ``.venv``. Where they are missing the tests are skipped with the
reason; ``DAMPER_TEST_LINTERS=required``, which ``.ci/run`` sets, makes that a failure.
"""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
CODE = ("bags", "benchmarks", "damper_estimator", "launch", "setup.py", "test", "tools")
# Docstrings are not demanded where names explain (D1..); nor are arguments that names explain (D417). A summary may
# take two lines (D205, D209, D415), and begin with a symbol or a formula (D402, D403).
NOT_OURS = "D100 D101 D102 D103 D104 D105 D106 D107 D205 D209 D402 D403 D415 D417".split()
COMMANDS = {
    # The licence is stated once; no file carries a notice.
    "ament_copyright": ["LICENSE", "CONTRIBUTING.md"],
    "ament_flake8": ["--config", "setup.cfg", *CODE],
    "ament_pep257": ["--convention", "google", "--add-ignore", *NOT_OURS, "--", *CODE],
}


@pytest.mark.parametrize("linter", COMMANDS)
def test_a_ros_linter_finds_nothing(linter):
    program = shutil.which(linter)
    if program is None:
        assert os.environ.get("DAMPER_TEST_LINTERS") != "required", f"{linter} is not installed"
        pytest.skip(f"{linter} is not installed (apt install python3-{linter.replace('_', '-')}, or source ROS 2)")
    done = subprocess.run([program, *COMMANDS[linter]], cwd=ROOT, capture_output=True, text=True)
    found = [line for line in (done.stdout + done.stderr).splitlines() if not line.startswith(("checking", "*"))]
    assert done.returncode == 0, "\n".join(found[-50:])
