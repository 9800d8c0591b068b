"""A client of the app in this process, and the app as a process of its own with a browser."""

import os
import subprocess
import sys
import warnings
from collections import defaultdict
from contextlib import ExitStack

import pytest
from app_page import PATIENCE, address_of, shown
from one_joint import HELD

from strainwave.app.web.server import application

BASE = "http://127.0.0.1:8765"
PAUSES = "window.pauses = 0; document.addEventListener('pause', () => { window.pauses += 1; });"
SHORT = "const wait = window.setTimeout; window.setTimeout = (what, ms, ...more) => wait(what, ms / 5, ...more);"


@pytest.fixture(scope="session")
def clients():
    """A client for the tests that run as Python and one for those compiled: its processes keep what they began with."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # the client of Starlette is to take another library one day
        from starlette.testclient import TestClient
    with ExitStack() as stack:
        yield defaultdict(lambda: stack.enter_context(TestClient(application(warm=False), base_url=BASE)))


@pytest.fixture
def client(clients):
    return clients[os.environ["STRAINWAVE_JIT"]]


@pytest.fixture(scope="session")
def address():
    with subprocess.Popen(
        [sys.executable, "-m", "strainwave", "app", "--no-browser", "--port", "8931"],
        stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, env=os.environ | {"STRAINWAVE_JIT": "1"},
    ) as process:  # fmt: skip
        line = process.stdout.readline()
        yield line.split()[2]
        process.terminate()


@pytest.fixture
def blank(browser, address):
    """A page that is still empty."""
    context = browser.new_context(viewport={"width": 1280, "height": 900}, accept_downloads=True)
    page = context.new_page()
    page.set_default_timeout(PATIENCE)
    page.base = address
    wrong, asked = [], []
    page.on("console", lambda message: message.type in ("error", "warning", "trace") and wrong.append(message.text))
    page.on("pageerror", lambda error: wrong.append(str(error)))
    page.on("request", lambda request: asked.append(request.url))
    page.add_init_script(PAUSES + SHORT)  # no test measures a pause
    yield page
    context.close()
    assert [text for text in wrong if "status of 422" not in text] == []  # the browser's own note of a refusal
    assert [url for url in asked if not url.startswith((address, "data:", "blob:"))] == []


@pytest.fixture
def page(blank):
    """The drive of a first visit."""
    blank.goto(blank.base)
    shown(blank)
    return blank


@pytest.fixture
def held_page(blank):
    """A drive whose motor is held: its maps take seconds, it jumps, and its limit is far below its oscillation."""
    blank.goto(address_of(blank.base, HELD))
    shown(blank)
    return blank
