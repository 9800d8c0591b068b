"""Sweeps: what the book-keeping costs, what memory it takes, and whether a sweep survives being killed.

1. `cost`: ten million trajectories (RK4, `--periods` periods of 100 steps, max and rms kept) through a store on the
   disk. The CPU time of the whole process during the sweep, over that of the measure's own calls in it (thread CPU
   time around each), less one; and the largest resident memory of the process.
2. `direct`: the same chunks through `sweep` and by calls of `ensemble` in a plain loop, in turns; CPU time of the
   process, median ratio less one.
3. `kill`: a sweep of a million points (a cheap measure, a whole chunk at a time) killed with SIGKILL at twenty random
   moments and resumed: damaged chunks, finished chunks that were lost, and whether all files equal those of a run
   without interruption.
4. `cluster`: the same sweep on a cluster of two worker processes (extra `cluster`), of which one at a time is killed
   with SIGKILL; whether all files equal those of the quiet run of threads.

    python benchmarks/sweep.py [cost] [direct] [kill] [cluster] [--points 10000000] [--periods 20]
"""

import argparse
import contextlib
import logging
import math
import os
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import zarr

import strainwave as sw

SYSTEM = sw.Oscillator(1.0, 0.1, sw.Cubic(1.0, 0.05), sw.Harmonic(1.0), 1.0)
SPENT = [0.0]
GUARD = threading.Lock()
KILLS = 20
PARTS = ["cost", "direct", "kill", "cluster"]


@dataclass(frozen=True)
class Timed:
    """An ensemble that adds up the CPU time of its calls."""

    measure: sw.EnsembleMeasure
    whole_chunks: ClassVar[bool] = True

    def __call__(self, system: Any, values: Any) -> Any:
        start = time.thread_time()
        found = self.measure(system, values)
        with GUARD:
            SPENT[0] += time.thread_time() - start
        return found


@dataclass(frozen=True)
class Cheap:
    """Closed form of a whole chunk, with the dead time of a short computation."""

    pause: float = 0.05
    whole_chunks: ClassVar[bool] = True

    def __call__(self, system: Any, values: Any, rng: Any) -> Any:
        time.sleep(self.pause)
        w, b = values["omega"], values["B"]
        return {"gain": 1.0 / np.hypot(1.0 - w * w, b * w), "noise": rng.normal(size=len(w))}


def grid(points: int) -> dict[str, Any]:
    """About so many points over alpha, damping and speed."""
    side = round(points ** (1.0 / 3.0))
    return {
        "law.alpha": np.linspace(0.0, 0.1, side),
        "B": np.linspace(0.05, 0.2, side),
        "omega": np.linspace(0.5, 2.0, math.ceil(points / side**2)),
    }


@contextlib.contextmanager
def folder() -> Iterator[Path]:
    """Give a folder on the disk for a moment."""
    path = Path(tempfile.mkdtemp(prefix="sweep-", dir=os.environ.get("TMPDIR")))
    try:
        yield path
    finally:
        shutil.rmtree(path)


def ensemble(periods: int) -> sw.EnsembleMeasure:
    """The measure of every trajectory."""
    return sw.EnsembleMeasure((0.0, 0.0), periods, (sw.Peak(), sw.Rms()), method=sw.Rk4(steps_per_period=100))


def cost(points: int, periods: int) -> None:
    """Print what a large sweep costs beyond its measure, and its memory."""
    measure = Timed(ensemble(periods))
    sw.sweep(measure, SYSTEM, grid(1000))  # compiles
    SPENT[0] = 0.0
    with folder() as path:
        wall, cpu = time.perf_counter(), time.process_time()
        data = sw.sweep(measure, SYSTEM, grid(points), store=path / "s")
        wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
        size = sum(file.stat().st_size for file in path.rglob("*") if file.is_file())
    total = math.prod(data.sizes.values())
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
    print(f"{total} trajectories of {periods} periods: {wall:.0f} s, {cpu:.1f} s of CPU, {size / 1e6:.0f} MB on disk")
    print(f"  beyond the measure's own {SPENT[0]:.1f} s of CPU: {100.0 * (cpu / SPENT[0] - 1.0):.2f} % (bar: 5 %)")
    print(f"  largest resident memory: {memory:.0f} MiB (bar: 600 MiB)")


def direct(periods: int, rounds: int = 5) -> None:
    """Print the CPU time of a sweep over that of a loop over `ensemble`."""
    measure, places = ensemble(periods), grid(1_000_000)
    sw.sweep(measure, SYSTEM, grid(1000))
    ratios = []
    for _ in range(rounds):
        with folder() as path:
            start = time.process_time()
            data = sw.sweep(measure, SYSTEM, places, store=path / "s", workers=1)
            swept = time.process_time() - start
            peak = data["peak"].values.ravel()
        block = zarr_chunk(data)
        start = time.process_time()
        mesh = [a.ravel() for a in np.meshgrid(*places.values(), indexing="ij", copy=False)]
        for first in range(0, len(peak), block):
            values = {path: a[first : first + block] for path, a in zip(places, mesh, strict=True)}
            found = measure(SYSTEM, values)
            assert np.array_equal(found["peak"], peak[first : first + block])
        ratios.append(swept / (time.process_time() - start))
    print(
        f"{len(peak)} trajectories of {periods} periods, sweep over direct calls: median {np.median(ratios) - 1:+.2%}"
    )
    print(f"  rounds: {', '.join(f'{ratio - 1:+.2%}' for ratio in ratios)}")


def zarr_chunk(data: Any) -> int:
    """Points of a chunk."""
    return math.prod(data["peak"].encoding["chunks"])


def kill_grid() -> dict[str, Any]:
    """A million points."""
    return {"B": np.linspace(0.01, 0.2, 1000), "omega": np.linspace(0.5, 2.0, 1000)}


def kill() -> None:
    """Kill a sweep again and again, and compare what becomes of it with a quiet run."""
    random = np.random.default_rng(0)
    with folder() as path:
        quiet, killed = path / "quiet", path / "killed"
        start = time.perf_counter()
        run_cheap(quiet)
        span = time.perf_counter() - start
        before, lost, damaged, kills = np.zeros(0, bool), 0, 0, 0
        shares = []
        while kills < KILLS:
            child = subprocess.Popen(
                [sys.executable, __file__, "run", str(killed)],
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                text=True,
            )
            child.stdout.readline()
            time.sleep(random.uniform(0.0, 0.2 * span))
            child.kill()
            damaged += child.communicate()[1].count("is damaged")
            kills += child.returncode == -9
            if child.returncode == 0:
                raise SystemExit(f"the sweep ended after {kills} kills; give it a longer pause")
            if (killed / "done").exists():
                done = zarr.open_array(killed / "done", mode="r")[:] == 1
                lost += int(np.sum(before[: len(done)] & ~done[: len(before)]))
                before = done
            shares.append(int(before.sum()))
        print(f"killed {kills} times, with so many of {len(before)} chunks done: {', '.join(map(str, shares))}")
        log = logging.getLogger("strainwave.study")
        heard: list[str] = []
        handler = logging.Handler()
        handler.emit = lambda record: heard.append(record.getMessage())  # type: ignore[method-assign]
        log.addHandler(handler)
        run_cheap(killed)
        damaged += sum("is damaged" in text for text in heard)
        same = files(quiet) == files(killed)
        print(f"  damaged chunks: {damaged}; finished chunks lost: {lost}; all files equal a quiet run's: {same}")


def cluster(kills: int = 5) -> None:
    """Kill workers of a cluster, one after the other, during a sweep, and compare it with a quiet run."""
    import dask  # both are optional dependencies, of this part alone
    import distributed

    random, killed, over = np.random.default_rng(0), [], threading.Event()

    def killer(workers: Any) -> None:
        while len(killed) < kills and not over.wait(random.uniform(0.5, 1.5)):
            if alive := [nanny.pid for nanny in workers.workers.values() if nanny.pid]:
                killed.append(int(random.choice(alive)))
                os.kill(killed[-1], signal.SIGKILL)

    with folder() as path:
        run_cheap(path / "quiet")
        settings = {"distributed.comm.timeouts.connect": "10s"}
        with (
            dask.config.set(settings),
            distributed.LocalCluster(2, threads_per_worker=1, host="127.0.0.1", dashboard_address=None) as workers,
            distributed.Client(workers) as client,
        ):
            thread = threading.Thread(target=killer, args=(workers,))
            thread.start()
            run_cheap(path / "killed", client)
            over.set()
            thread.join()
        same = files(path / "quiet") == files(path / "killed")
        print(f"{len(killed)} workers of a cluster killed during the sweep; all files equal a quiet run's: {same}")


def run_cheap(store: Path, client: Any = None) -> None:
    """Sweep a million points."""
    sw.sweep(Cheap(), SYSTEM, kill_grid(), store=store, chunk=4000, client=client)


def files(store: Path) -> dict[str, bytes]:
    """Every file of a store."""
    return {str(p.relative_to(store)): p.read_bytes() for p in store.rglob("*") if p.is_file()}


def main() -> None:
    """Run what the command line asks for."""
    if sys.argv[1:2] == ["run"]:  # the child that is killed
        logging.basicConfig(level=logging.WARNING)
        sw.sweep(Cheap(0.0), SYSTEM, grid(1000))  # all libraries are loaded
        print("begun", flush=True)
        run_cheap(Path(sys.argv[2]))
        return
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("what", nargs="*", choices=PARTS, default=PARTS)
    parser.add_argument("--points", type=int, default=10_000_000)
    parser.add_argument("--periods", type=int, default=20)
    chosen = parser.parse_args()
    if "cost" in chosen.what:
        cost(chosen.points, chosen.periods)
    if "direct" in chosen.what:
        direct(chosen.periods)
    if "kill" in chosen.what:
        kill()
    if "cluster" in chosen.what:
        cluster()


if __name__ == "__main__":
    main()
