"""Fixtures shared by all tests."""

import os
from contextlib import suppress
from pathlib import Path

import pytest

with suppress(ImportError):
    from hypothesis import settings

    # The duration of an example depends on the load of the machine.
    settings.register_profile("untimed", deadline=None)
    settings.load_profile("untimed")


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """Folder of the real recordings; tests that need it are skipped with the reason if it is missing."""
    folder = Path(os.environ.get("DAMPER_SHARED_DATA", Path(__file__).resolve().parents[2] / "shared" / "data"))
    if not folder.is_dir():
        pytest.skip(f"real recordings are not at {folder} (set DAMPER_SHARED_DATA)")
    return folder
