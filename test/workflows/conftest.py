"""Small recordings in the temporary folder of a test."""

import pytest
from drives import write_drive


@pytest.fixture
def drive(tmp_path):
    """Writes a bag of viscous dampers with friction; arguments as ``drives.write_drive``."""

    def make(name="drive.mcap", **more):
        return write_drive(tmp_path / name, **more)

    return make
