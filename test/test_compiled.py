"""Compilation of the kernels where an installation is awkward."""

import os
import resource
import subprocess
import sys

import pytest

USE = (
    "import numpy as np\nfrom damper_estimator.signals.admission import Admission\n"
    "print(Admission().block(np.array([1, 1]), np.zeros(2))[0].tolist())"
)


def test_a_read_only_installation_without_a_home_still_runs():
    pytest.importorskip("numba")
    code = "from numba.core import caching\ncaching.CacheImpl._locator_classes = []\n" + USE
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (0, "[1, 4]\n"), done.stderr


def test_a_disk_without_room_for_the_machine_code_stops_nothing(tmp_path):
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
