"""The web app: visitors at the same time, kills, and the time to the first picture.

    python benchmarks/app.py sessions [--count 50] [--seconds 20]
    python benchmarks/app.py kill [--count 30] [--seed 1]
    python benchmarks/app.py start [--rounds 5] [--cold]

Each starts `strainwave app` as a process of its own on a free port; the visitors are in this process, on the same
cores. `sessions`: everybody has a gear of his own and drags its sliders: the next position is sent 100 to 150 ms after
the last one, or when its answer has come, whichever is later. No two requests are equal. `kill`:
SIGKILL at random while visitors save curves, project files, scripts and reports; then every saved file is whole, no
process of the app is left, and the next app gives the same answer. `start` measures from the start of the process until
the picture is drawn, with a browser that runs already and with one that has to be started; it needs playwright and
Chromium. With `--cold` the folder of compiled code is empty at every start. The others need psutil. `app_hostile.py`
sends hostile requests.
"""

import argparse
import asyncio
import contextlib
import json
import os
import random
import shutil
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

GEAR = {"gear": "CSG-40-50"}
SLIDERS = {
    "load.inertia": (0.3, 3.0, "kg*m^2"),
    "damping.ratio": (1.0, 6.0, "%"),
    "limit.oscillation": (20, 300, "arcsec"),
}
PATIENCE = 120.0  # seconds for an answer: the first one may have to be compiled


@contextlib.contextmanager
def app() -> Iterator[tuple[subprocess.Popen[str], int]]:
    """The app as a process, and its port; it is killed at the end."""
    command = [sys.executable, "-m", "strainwave", "app", "--no-browser", "--port", "8790"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as process:
        assert process.stdout is not None
        line = process.stdout.readline()
        try:
            yield process, int(line.split(":")[3].split("/")[0])
        finally:
            process.terminate()


def request(port: int, path: str, body: bytes = b"", method: str = "POST", **headers: str) -> bytes:
    """A request in the bytes of HTTP."""
    host = {"host": f"127.0.0.1:{port}", "content-length": str(len(body))} | headers
    head = "".join(f"{name.replace('_', '-')}: {value}\r\n" for name, value in host.items())
    return f"{method} {path} HTTP/1.1\r\n{head}\r\n".encode("latin-1") + body


async def answer(reader: asyncio.StreamReader) -> tuple[int, dict[str, str], bytes]:
    """Status, headers and body of an answer."""
    first, *lines = (await reader.readuntil(b"\r\n\r\n")).decode("latin-1").split("\r\n")[:-2]
    headers = {name.lower(): value.strip() for name, _, value in (line.partition(":") for line in lines)}
    return int(first.split()[1]), headers, await reader.readexactly(int(headers.get("content-length", "0")))


async def asked(port: int, raw: bytes) -> tuple[int, dict[str, str], bytes]:
    """Answer to one request on a connection of its own."""
    reader, writer = await asyncio.open_connection("127.0.0.1", port)
    try:
        with contextlib.suppress(ConnectionError):  # a body that is too large is not read to its end
            writer.write(raw)
            await writer.drain()
        return await asyncio.wait_for(answer(reader), PATIENCE)
    finally:
        writer.close()


async def visit(
    port: int, gear: str, end: float, seed: int, took: list[float], cpu: list[float], wrong: Counter[Any]
) -> None:
    """One visitor, who drags one slider after another."""
    rng = random.Random(seed)
    values: dict[str, str] = {}
    reader, writer = await asyncio.open_connection("127.0.0.1", port)
    await asyncio.sleep(rng.uniform(0.0, 0.15))
    while time.monotonic() < end:
        name = rng.choice(list(SLIDERS))
        low, high, unit = SLIDERS[name]
        for _ in range(20):
            if time.monotonic() > end:
                break
            values[name] = f"{rng.uniform(low, high):.6g} {unit}"
            body = json.dumps({"state": {"gear": gear, "values": values}}).encode()
            begun = time.monotonic()
            writer.write(request(port, "/api/response", body, content_type="application/json"))
            status, headers, content = await asyncio.wait_for(answer(reader), PATIENCE)
            took.append(time.monotonic() - begun)
            cpu.append(float(headers.get("server-timing", "dur=0").partition("dur=")[2]))
            if status != 200:
                wrong[status, content[:200]] += 1
            await asyncio.sleep(max(0.0, begun + rng.uniform(0.100, 0.150) - time.monotonic()))
    writer.close()


def processor_time(pid: int) -> tuple[float, float, float]:
    """Processor time [s] of the server, of the processes that it has started, and of this process."""
    import psutil

    server = psutil.Process(pid)
    own, *others = (sum(one.cpu_times()[:2]) for one in (server, *server.children()))
    return own, sum(others), time.process_time()


def quantile(values: list[float], share: float) -> float:
    """The value below which a share of the values is."""
    return sorted(values)[min(len(values) - 1, int(share * len(values)))]


async def sessions(port: int, pid: int, count: int, seconds: float) -> None:
    """Print how long the answers take when so many drag at the same time."""
    _, _, content = await asked(port, request(port, "/api/gears", method="GET"))
    gears = [gear["name"] for gear in json.loads(content)]
    spread = [gears[i * len(gears) // count] for i in range(count)]
    for people, length in ((4, 5.0), (1, 5.0), (count, seconds)):  # the first ones warm the processes
        took: list[float] = []
        cpu: list[float] = []
        wrong: Counter[Any] = Counter()
        end = time.monotonic() + length
        visitors = (visit(port, gear, end, i + people, took, cpu, wrong) for i, gear in enumerate(spread[:people]))
        before = processor_time(pid)
        await asyncio.gather(*visitors)
        used = [1e3 * (b - a) / len(took) for a, b in zip(before, processor_time(pid), strict=True)]
        if people != 4:
            print(
                f"{people} sessions, {len(took)} answers in {length:g} s ({len(took) / length:.0f}/s), "
                f"{sum(wrong.values())} errors: median {1e3 * statistics.median(took):.0f} ms, "
                f"95 % under {1e3 * quantile(took, 0.95):.0f} ms, largest {1e3 * max(took):.0f} ms; "
                f"of processor time an answer takes {statistics.median(cpu):.1f} ms of computing (median), in the mean "
                f"{used[0]:.1f} ms of the server, {used[1]:.1f} ms of its processes, {used[2]:.1f} ms of the visitor; "
                f"load {os.getloadavg()[0]:.1f}"
            )
            for what, times in wrong.most_common(5):
                print(f"  {times} x {what}")


async def load(port: int, folder: Path, seed: int, saved: dict[Path, bytes]) -> None:
    """Visitors who save what they get until the server has gone."""
    rng = random.Random(seed)

    async def saving(path: str, body: dict[str, Any], suffix: str) -> None:
        with contextlib.suppress(OSError, asyncio.IncompleteReadError):
            for i in range(10**6):
                changed = {"state": {**GEAR, "values": {"load.inertia": f"{rng.uniform(0.5, 2):.6g} kg*m^2"}}, **body}
                status, _, content = await asked(port, request(port, path, json.dumps(changed).encode()))
                if path == "/api/jobs" and status == 201:
                    content = await finished(port, json.loads(content)["id"])
                if status < 300:
                    file = folder / f"{seed}-{path.rpartition('/')[2]}-{i}{suffix}"
                    file.write_bytes(content)
                    saved[file] = content

    await asyncio.gather(
        saving("/api/response", {}, ".json"), saving("/api/export/project", {}, ".yaml"),
        saving("/api/export/script", {}, ".py"), saving("/api/jobs", {"kind": "report"}, ".html"),
    )  # fmt: skip


async def finished(port: int, job: str) -> bytes:
    """Result of a job, when it has come to its end."""
    while True:
        _, _, content = await asked(port, request(port, f"/api/jobs/{job}", method="GET"))
        told = json.loads(content)
        if told["state"] not in ("waiting", "running"):
            return str(told["result"]).encode()
        await asyncio.sleep(0.1)


def kill(count: int, seed: int) -> None:
    """Kill the app at random under load, and look at what is left."""
    import psutil

    rng, saved, faults, reports = random.Random(seed), dict[Path, bytes](), Counter[str](), 0
    folder = Path(tempfile.mkdtemp(prefix="strainwave-bench-"))
    os.environ["TMPDIR"] = str(folder / "tmp")
    (folder / "tmp").mkdir()
    wanted = None
    for i in range(count):
        with app() as (process, port):

            async def killed(process: Any = process, port: int = port, i: int = i) -> bytes:
                _, _, content = await asked(port, request(port, "/api/response", json.dumps({"state": GEAR}).encode()))
                loading = asyncio.create_task(load(port, folder, i, saved))
                await asyncio.sleep(rng.uniform(0.0, 4.0))
                process.send_signal(signal.SIGKILL)
                await loading
                return content

            content = asyncio.run(killed())
            wanted = wanted or content
            faults["the first answer after a kill is another one"] += content != wanted
        deadline = time.monotonic() + 20.0
        while alive := [p for p in psutil.process_iter(["cmdline"]) if str(folder) in " ".join(_environment(p))]:
            if time.monotonic() > deadline:
                faults["a process is left"] += len(alive)
                for one in alive:
                    one.kill()
                break
            time.sleep(0.1)
    for file, content in saved.items():
        faults["a saved file is not what was answered"] += file.read_bytes() != content
        whole = {".json": b"}", ".yaml": b"\n", ".py": b"main()\n", ".html": b"</html>"}[file.suffix]
        faults["a saved file is not whole"] += not content.rstrip(b"\n").endswith(whole.rstrip(b"\n"))
        reports += file.suffix == ".html"
    left = list((folder / "tmp").iterdir())
    print(
        f"{count} kills, {len(saved)} saved files ({reports} reports), {sum(faults.values())} faults; "
        f"{len(left)} temporary folders left"
    )
    for what, times in (+faults).most_common():
        print(f"  {times} x {what}")
    shutil.rmtree(folder)


def _environment(process: Any) -> list[str]:
    """What a process of the app has as its folder for temporary files."""
    try:
        return [process.environ().get("TMPDIR", "")] if "strainwave.app.web.worker" in process.cmdline() else []
    except Exception:  # it is another user's, or it has ended meanwhile
        return []


def start(rounds: int, empty: bool) -> None:
    """Print the time from the start of the process to the first picture; `empty`: without compiled code."""
    from playwright.sync_api import sync_playwright

    chromium = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))))
    running, started = [], []
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        for i in range(rounds + 1):
            for cold, times in ((False, running), (True, started)):
                if empty:
                    os.environ["STRAINWAVE_CACHE_DIR"] = tempfile.mkdtemp(prefix="strainwave-bench-", dir=folder)
                browser = None if cold else playwright.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
                begun = time.monotonic()
                with app() as (_, port):
                    browser = browser or playwright.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
                    page = browser.new_page()
                    page.goto(f"http://127.0.0.1:{port}/")
                    page.wait_for_selector("#plot-torque[data-drawn]")
                    if i:  # the first round fills the caches
                        times.append(time.monotonic() - begun)
                    browser.close()
    for what, times in (("runs already", running), ("is started, too", started)):
        print(
            f"first picture after {statistics.median(times):.2f} s ({min(times):.2f} to {max(times):.2f}) where the "
            f"browser {what}; load {os.getloadavg()[0]:.1f}"
        )


def main() -> None:
    """Run one of the three."""
    parser = argparse.ArgumentParser()
    parser.add_argument("what", choices=["sessions", "kill", "start"])
    parser.add_argument("--count", type=int)
    parser.add_argument("--seconds", type=float, default=20.0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--cold", action="store_true")
    given = parser.parse_args()
    if given.what == "start":
        start(given.rounds, given.cold)
    elif given.what == "kill":
        kill(given.count or 30, given.seed)
    else:
        with app() as (process, port):
            asyncio.run(sessions(port, process.pid, given.count or 50, given.seconds))


if __name__ == "__main__":
    main()
