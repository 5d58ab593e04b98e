"""What the tests of the characterization share."""

import pytest
from shapes import SHAPES


@pytest.fixture(params=sorted(SHAPES), ids=lambda kind: f"type {kind}")
def kind(request):
    """Every pattern type."""
    return request.param
