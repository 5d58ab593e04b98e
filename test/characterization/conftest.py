"""Fixtures of the characterization tests."""

import pytest
from shapes import SHAPES


@pytest.fixture(params=sorted(SHAPES), ids=lambda kind: f"type {kind}")
def kind(request):
    """Each pattern type."""
    return request.param
