"""Settings shared by all tests."""

import signal
from collections import Counter
from pathlib import Path

import pytest
from hypothesis import settings

# The same examples on every run, and no deadline: the first call of a compiled kernel takes seconds.
settings.register_profile("strainwave", derandomize=True, deadline=None)
settings.load_profile("strainwave")

# Under nohup Ctrl-C is ignored, here and in every process that the tests start; some tests send it.
signal.signal(signal.SIGINT, signal.default_int_handler)

# Whose fast tests would compile nothing, or only what others test: examples, documentation and slow tests run compiled.
UNCOMPILED = (
    "app",
    "files",
    "model/gears",
    "plot",
    "study",
    "test_records.py",
    "theory/slow_flow/test_predictor.py",
    "theory/slow_flow/test_response.py",
    "theory/slow_flow/test_second_order.py",
)


def pytest_collection_modifyitems(items):
    """Mark those `interpreted`, and those of long.txt; begin with the files of many slow tests, as xdist does then."""
    here = Path(__file__).parent
    slow = Counter(item.path for item in items if item.get_closest_marker("slow"))
    alone = {here / place for place in UNCOMPILED}
    long = {line for line in (here / "long.txt").read_text(encoding="utf-8").splitlines() if line[:1] != "#"}
    for item in items:
        name = f"{item.path.relative_to(here).as_posix()}::{item.name}"
        if long & {name, name.partition("[")[0]}:
            item.add_marker(pytest.mark.long)
        marked = item.get_closest_marker("slow") or item.get_closest_marker("compiled")
        if not marked and alone & {item.path, *item.path.parents}:
            item.add_marker(pytest.mark.interpreted)
    items.sort(key=lambda item: -slow[item.path])
