"""Settings shared by all tests."""

import gc
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

GUARD = Path(__file__).with_name("guard.txt")


def pytest_collection_modifyitems(items):
    """Mark tests in a browser `slow` and those that guard.txt names `guard`; files with slow tests come first."""
    named = {line for line in GUARD.read_text(encoding="utf-8").splitlines() if line[:1] != "#"}
    for item in items:
        if "blank" in item.fixturenames:
            item.add_marker(pytest.mark.slow)
        name = f"{item.path.relative_to(GUARD.parent).as_posix()}::{item.name}"
        if named & {name, name.partition("[")[0], name.partition("::")[0]}:
            item.add_marker(pytest.mark.guard)
    slow = Counter(item.path for item in items if item.get_closest_marker("slow"))
    items.sort(key=lambda item: -slow[item.path])


def pytest_collection_finish():
    """Leave the million objects of the collection out of every search for garbage."""
    gc.freeze()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item):
    """Run a slow test, and make its fixtures, with machine code, any other and those in a browser as Python."""
    as_machine_code = item.get_closest_marker("slow") and "blank" not in item.fixturenames
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("STRAINWAVE_JIT", "1" if as_machine_code else "0")
        return (yield)
