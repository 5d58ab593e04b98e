"""The browser of the tests: the system's Chromium.

Where it or playwright is missing, tests in a browser are skipped with the reason. ``DAMPER_TEST_BROWSER=required``,
which ``.ci/run`` sets, makes that a failure.
"""

import os
import shutil
from importlib.util import find_spec

import pytest

BROWSER = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
# For pages that walk through themselves and are read when they have come to rest.
PAGE_FLAGS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync", "--virtual-time-budget=20000",
    "--window-size=1280,720", "--dump-dom",
)  # fmt: skip

_MISSING = [name for name, found in (("chromium", BROWSER), ("playwright", find_spec("playwright"))) if found is None]
if _MISSING and os.environ.get("DAMPER_TEST_BROWSER") == "required":
    raise RuntimeError(f"DAMPER_TEST_BROWSER=required, but not installed here: {', '.join(_MISSING)}")

needs_browser = pytest.mark.skipif("chromium" in _MISSING, reason="no chromium on this machine (apt install chromium)")
needs_playwright = pytest.mark.skipif("playwright" in _MISSING, reason="playwright is not installed")
