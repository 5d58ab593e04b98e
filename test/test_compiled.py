"""Compilation of the kernels where an installation is awkward."""

import subprocess
import sys

import pytest


def test_a_read_only_installation_without_a_home_still_runs():
    pytest.importorskip("numba")
    code = (
        "import numpy as np\nfrom numba.core import caching\ncaching.CacheImpl._locator_classes = []\n"
        "from damper_estimator.signals.admission import Admission\n"
        "print(Admission().block(np.array([1, 1]), np.zeros(2))[0].tolist())"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (0, "[1, 4]\n"), done.stderr
