"""The loops over a model are compiled in processes of their own while a recording is read."""

import os
import subprocess
import sys

import pytest

from damper_estimator.compiled import COMPILED

BEGIN = "from damper_estimator.compiled import is_kept\nfrom damper_estimator.model import ahead, chain\n"
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
    run("ahead.compile_loops_ahead()\nassert not ahead._underway", tmp_path)


def test_a_process_with_threads_is_not_forked(tmp_path):
    run(
        "import threading\nblocked = threading.Event()\nthreading.Thread(target=blocked.wait).start()\n"
        "ahead.compile_loops_ahead()\nassert not ahead._underway\nblocked.set()",
        tmp_path,
    )
