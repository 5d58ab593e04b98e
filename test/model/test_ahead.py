"""What takes longest to compile is compiled in other processes while a recording is read or a node starts."""

import os
import subprocess
import sys

import pytest

from damper_estimator.compiled import COMPILED

BEGIN = (
    "from damper_estimator import compiled\nfrom damper_estimator.compiled import is_kept\n"
    "from damper_estimator.model import ahead, chain\n"
)
LOOPS = "(chain.run_with_resets, chain.sample_loop)"


def run(code: str, cache: object) -> None:
    environment = os.environ | {"NUMBA_CACHE_DIR": str(cache)}
    done = subprocess.run([sys.executable, "-c", BEGIN + code], env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


@pytest.mark.skipif(not COMPILED or (os.cpu_count() or 1) < 2, reason="needs numba and two cores")
def test_what_was_compiled_ahead_is_kept_and_not_compiled_again(tmp_path):
    run(
        f"assert not any(map(is_kept, {LOOPS}))\n"
        "ahead.compile_loops_ahead()\nahead.wait_for_loops(True)\n"
        f"assert all(map(is_kept, {LOOPS}))\n",
        tmp_path,
    )
    run("ahead.compile_loops_ahead()\nassert not compiled._UNDERWAY", tmp_path)


@pytest.mark.skipif(not COMPILED or (os.cpu_count() or 1) < 2, reason="needs numba and two cores")
def test_the_node_compiles_only_what_others_did_not_compile_ahead(tmp_path):
    """The types with which the parts are compiled ahead are those with which the line calls them."""
    run(
        "import numpy as np\nfrom damper_estimator.model import load_model\n"
        "from damper_estimator.runtime import Line, compile_line_ahead, deployed, line\n"
        "compile_line_ahead()\nassert compiled._UNDERWAY\n"
        "running = Line()\nrunning.add('one', deployed(load_model('linear_viscous'), 60.0, 0.1))\n"
        "assert not compiled._UNDERWAY\n"
        "running.step(10**9, np.zeros(1), np.ones(1, bool))\n"
        "assert sum(line._step.stats.cache_hits.values()) == 1 and not line._step.stats.cache_misses\n",
        tmp_path,
    )


def test_an_interpreter_that_cannot_be_started_costs_only_time(tmp_path):
    run(
        "import sys\nsys.executable = '/nowhere/python'\n"
        "ahead.compile_loops_ahead()\nassert not compiled._UNDERWAY\nahead.wait_for_loops(True)",
        tmp_path,
    )
