"""Compilation of the kernels where an installation is awkward."""

import os
import resource
import subprocess
import sys

import pytest

from damper_estimator import compiled

USE = (
    "import numpy as np\nfrom damper_estimator.signals.admission import Admission\n"
    "print(Admission().block(np.array([1, 1]), np.zeros(2))[0].tolist())"
)


def test_a_read_only_installation_without_a_home_runs():
    pytest.importorskip("numba")
    code = "from numba.core import caching\ncaching.CacheImpl._locator_classes = []\n" + USE
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (0, "[1, 4]\n"), done.stderr


def test_a_full_disk_does_not_stop_a_computation(tmp_path):
    """A limit on the size of files acts like a disk that is full."""
    pytest.importorskip("numba")
    done = subprocess.run(
        [sys.executable, "-c", USE],
        env=os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)},
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (10, 10)),
        capture_output=True,
        text=True,
    )
    assert (done.returncode, done.stdout) == (0, "[1, 4]\n"), done.stderr


@pytest.mark.parametrize(
    ("edited", "dropped"), [("kernel", True), ("helper", True), ("constants", True), ("page", False)]
)
def test_machine_code_is_dropped_when_a_file_it_can_depend_on_is_edited(tmp_path, edited, dropped):
    package = tmp_path / "damper_estimator"
    (package / "parts" / "__pycache__").mkdir(parents=True)
    files = {
        "parts/kernel": "from damper_estimator.parts import (\n    helper,\n)\n",
        "parts/helper": "from damper_estimator.constants import G\n",
        "constants": "G = 9.81\n",
        "page": "from damper_estimator.parts import kernel\n",
    }
    for name, text in files.items():
        (package / f"{name}.py").write_text(text, encoding="utf-8")
        os.utime(package / f"{name}.py", (100, 300 if name.endswith(edited) else 100))
    index = package / "parts" / "__pycache__" / "kernel.force-7.py312.nbi"
    index.touch()
    os.utime(index, (200, 200))
    compiled._drop_stale_machine_code(package)
    assert index.exists() != dropped
