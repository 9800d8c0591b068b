"""A client of the app in this process, and the app as a process of its own with a browser."""

import shutil
import subprocess
import sys
import warnings

import pytest

from strainwave.app.web.server import application

BASE = "http://127.0.0.1:8765"


@pytest.fixture(scope="session")
def client():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # the client of Starlette is to take another library one day
        from starlette.testclient import TestClient
    with TestClient(application(warm=False), base_url=BASE) as found:
        yield found


@pytest.fixture(scope="session")
def address():
    with subprocess.Popen(
        [sys.executable, "-m", "strainwave", "app", "--no-browser", "--port", "8931"],
        stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
    ) as process:  # fmt: skip
        line = process.stdout.readline()
        yield line.split()[2]
        process.terminate()


@pytest.fixture(scope="session")
def browser():
    path = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
    if path is None:
        pytest.skip("there is no Chromium on this machine; install the package chromium")
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        found = playwright.chromium.launch(executable_path=path, args=["--no-sandbox"])
        yield found
        found.close()
