"""Finds installed data files: models, signal maps, message definitions."""

from pathlib import Path

from damper_estimator.errors import InputError

_PACKAGE = Path(__file__).resolve().parent


def share_path(relative: str) -> Path:
    """Path of an installed data file or folder, such as ``config/models``.

    Searches the folder of the package (a checkout), then ``share/damper_estimator`` in every folder above it, as
    installed by pip (``<prefix>/share``) and colcon (``install/damper_estimator/share``).

    Raises:
        InputError: if the installation lacks it.
    """
    for folder in _PACKAGE.parents:
        for candidate in (folder / relative, folder / "share" / "damper_estimator" / relative):
            if candidate.exists():
                return candidate
    raise InputError(f"{relative}: not found next to {_PACKAGE}; install the package again (pip install .)")
