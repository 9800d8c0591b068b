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

MACHINE_CODE = ("compile", "numerics/ensemble")  # rooms whose fast tests run compiled too


def pytest_collection_modifyitems(items):
    """Mark what runs `compiled`, what long.txt and slow.txt list and what drives the app in a browser, which is slow.

    Sort files by their slow and compiled tests, for xdist too.
    The last files are short, so that no worker is left alone.
    """
    here = Path(__file__).parent
    rooms = {here / room for room in MACHINE_CODE}
    for item in items:
        if "blank" in item.fixturenames:  # the app has processes of its own
            item.add_marker(pytest.mark.slow)
            item.add_marker(pytest.mark.interpreted)
    for marks, file in ((("long",), "long.txt"), (("slow", "interpreted"), "slow.txt")):
        listed = {line for line in (here / file).read_text(encoding="utf-8").splitlines() if line[:1] != "#"}
        for item in items:
            name = f"{item.path.relative_to(here).as_posix()}::{item.name}"
            if listed & {name, name.partition("[")[0]}:
                for mark in marks:
                    item.add_marker(mark)
    slow = Counter(item.path for item in items if item.get_closest_marker("slow"))
    for item in items:
        of_machine_code = item.get_closest_marker("slow") or rooms & {*item.path.parents}
        if of_machine_code and not item.get_closest_marker("interpreted"):
            item.add_marker(pytest.mark.compiled)
    compiled = Counter(item.path for item in items if item.get_closest_marker("compiled"))
    items.sort(key=lambda item: (-slow[item.path], -compiled[item.path]))


def pytest_collection_finish():
    """Leave the million objects of the collection out of every search for garbage."""
    gc.freeze()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item):
    """Run a test, and make its fixtures, with machine code where it or its file is `compiled`, as Python otherwise."""
    as_machine_code = item.get_closest_marker("compiled") and not item.get_closest_marker("interpreted")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("STRAINWAVE_JIT", "1" if as_machine_code else "0")
        return (yield)
