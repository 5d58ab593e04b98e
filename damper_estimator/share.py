"""Finds the files that are installed beside the code: models, signal maps, message definitions."""

from pathlib import Path

from damper_estimator.errors import InputError

_PACKAGE = Path(__file__).resolve().parent


def share_path(relative: str) -> Path:
    """Path of an installed data file or folder, such as ``config/models``.

    Looks beside the package (a checkout) and then under ``share/damper_estimator`` of every folder above it, which
    is where pip (``<prefix>/share``) and colcon (``install/damper_estimator/share``) put it.

    Raises:
        InputError: where the installation lacks it.
    """
    for folder in _PACKAGE.parents:
        for candidate in (folder / relative, folder / "share" / "damper_estimator" / relative):
            if candidate.exists():
                return candidate
    raise InputError(f"{relative}: not found beside {_PACKAGE}; install the package again (pip install .)")
