"""A population of hidden-effect cases: dampers, effects, drives, sensors and users' models drawn at random.

The plants share nothing with ``damper_estimator.plant`` nor with the equations of ``damper_estimator.effects``, and the
judge uses only the public Python API. ``benchmarks/bench_diagnosis.py`` runs it.
"""

from contextlib import suppress
from pathlib import Path


def _drop_stale_machine_code(folder: Path) -> None:
    """Removes cached kernels that are older than any source here: numba checks only the kernel's own file."""
    newest = max(path.stat().st_mtime for path in folder.glob("*.py"))
    for index in folder.rglob("*.nbi"):
        with suppress(OSError):
            if index.stat().st_mtime < newest:
                index.unlink()


_drop_stale_machine_code(Path(__file__).parent)
