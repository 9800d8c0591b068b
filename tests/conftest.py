"""Settings shared by all tests."""

from pathlib import Path

import pytest
from hypothesis import settings

# The same examples on every run, and no deadline: the first call of a compiled kernel takes seconds.
settings.register_profile("strainwave", derandomize=True, deadline=None)
settings.load_profile("strainwave")

TESTS = Path(__file__).parent
# Files, sentences and figures: what they say does not depend on compiled code.
UNCOMPILED = {TESTS / room for room in ("app", "files", "plot")}


def pytest_collection_modifyitems(items):
    """Mark the fast tests of the uncompiled rooms `interpreted`: they would only compile what others test."""
    for item in items:
        fast = not any(item.iter_markers("slow")) and not any(item.iter_markers("compiled"))
        if fast and UNCOMPILED & set(item.path.parents):
            item.add_marker(pytest.mark.interpreted)
