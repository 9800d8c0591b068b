"""Make docs/images/app.png: the web app in Chromium, at 1280 x 900.

`--views FOLDER` saves every view at the widths of a phone, a laptop and a 4K screen, light and dark, instead.
"""

import argparse
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
from playwright.sync_api import sync_playwright

TARGET = Path(__file__).resolve().parent.parent / "docs/images/app.png"
SIZES = {375: 812, 1280: 900, 3840: 2160}  # width and height [px]
JOBS = ("speed-map", "compensation")  # views that a job fills
LAST = {"response": "torque", "motion": "phase", "move": "move-speed", "log": "log-load_angle"}
PATIENCE = 300_000  # ms


def main() -> None:
    """Start the app, wait for the pictures, and save them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--views", type=Path, metavar="FOLDER", help="save every view into this folder")
    folder = parser.parse_args().views
    path = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
    if path is None:
        sys.exit("screenshot: there is no Chromium on this machine; install the package chromium")
    command = [sys.executable, "-m", "strainwave", "app", "--no-browser"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        address = process.stdout.readline().split()[2]
        with sync_playwright() as playwright:
            browser = playwright.chromium.launch(executable_path=path, args=["--no-sandbox"])
            page = browser.new_page(viewport={"width": 1280, "height": SIZES[1280]})
            page.set_default_timeout(PATIENCE)
            if folder is None:
                page.goto(address)
                wait(page, "torque")
                page.get_by_text("is being computed").wait_for(state="hidden")
                TARGET.parent.mkdir(parents=True, exist_ok=True)
                page.screenshot(path=TARGET)
            else:
                folder.mkdir(parents=True, exist_ok=True)
                every_view(page, address, folder)
            browser.close()
        process.terminate()


def wait(page: Any, name: str) -> None:
    """Wait until a picture is drawn."""
    page.wait_for_selector(f"#plot-{name}[data-drawn]")


def every_view(page: Any, address: str, folder: Path) -> None:
    """Save each view in each size, light and dark."""
    for view in ("response", "motion", "move", "speed-map", "compensation", "log"):
        page.goto("about:blank")
        page.goto(f"{address}#gear=CSG-40-50&view={view}")
        page.wait_for_selector("#title:not(:empty)")
        if view in JOBS:
            page.locator("#begin").click()
        if view == "log":
            page.set_input_files("#log-file", {"name": "run.csv", "mimeType": "text/csv", "buffer": log()})
        wait(page, LAST.get(view, view))
        for width, height in SIZES.items():
            for scheme in ("light", "dark"):
                page.set_viewport_size({"width": width, "height": height})
                page.emulate_media(color_scheme=scheme)
                page.wait_for_timeout(1500)
                page.screenshot(path=folder / f"{view}-{width}-{scheme}.png", full_page=True)
        print(folder / view, flush=True)


def log() -> bytes:
    """A log of both angles and the torque at a constant speed, with errors of orders 1 and 2 [rad, N*m]."""
    t = np.linspace(0.0, 4.0, 4001)
    motor = 31.4 * t
    load = motor / 50.0 + 5e-5 * np.sin(2.0 * motor) + 2e-5 * np.sin(motor)
    torque = 1.0 + 0.2 * np.cos(2.0 * motor)
    rows = "\n".join(f"{a:.6g},{b:.9g},{c:.9g},{d:.9g}" for a, b, c, d in zip(t, motor, load, torque, strict=True))
    return ("time [s],motor_angle [rad],load_angle [rad],motor_torque [N*m]\n" + rows).encode()


if __name__ == "__main__":
    main()
