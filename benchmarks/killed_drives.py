"""A sweep of 2,000 drives that is killed 20 times equals an undisturbed one, bit for bit.

    python benchmarks/killed_drives.py [drives] [kills] [seed]

The response of a whole drive at every point, chunk after chunk, first in processes that are killed with the process
that writes the store, then on a dask cluster whose workers are killed while it goes on.
"""

import os
import random
import signal
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

import strainwave as sw

PROJECT = Path(__file__).parent.parent / "examples" / "projects" / "article.yaml"
RUN = "import sys, killed_drives; killed_drives.swept(sys.argv[1], int(sys.argv[2]), processes=True, workers=2)"
COLUMNS = 40


def swept(store, drives, **how):
    """Sweep inertia of the load and damping of a drive into a store."""
    inertias = [f"{1.3 * (0.8 + 0.4 * i / COLUMNS):.9g} kg*m^2" for i in range(COLUMNS)]
    rows = drives // COLUMNS
    damping = [f"{20.0 * (0.5 + i / rows):.9g} N*m*s/rad" for i in range(rows)]
    grid = {"load.inertia": inertias, "damping.B": damping}
    return sw.sweep(sw.sample.largest, sw.read_project(PROJECT), grid, store=store, chunk=5, **how)


def contents(store):
    """Files of a store by their names."""
    return {str(path.relative_to(store)): path.read_bytes() for path in store.rglob("*") if path.is_file()}


def finished(store):
    """Chunks that are done."""
    return sum(1 for _ in store.glob("done/c/*[0-9]"))  # a file for each, which appears last


def killed(store, drives, kills, rng):
    """Begin the sweep again and again, each time killed with all its processes after some chunks; how often it was."""
    env = os.environ | {"PYTHONPATH": os.pathsep.join([str(Path(__file__).parent), os.environ.get("PYTHONPATH", "")])}
    hits, before = 0, 0
    while hits < kills:
        run = subprocess.Popen([sys.executable, "-c", RUN, store, str(drives)], env=env, start_new_session=True)
        aim = before + rng.randint(1, max(1, drives // 5 // (2 * kills)))
        while run.poll() is None and finished(store) < aim:
            time.sleep(rng.uniform(0.0, 0.05))
        if run.poll() is not None:
            break
        os.killpg(run.pid, signal.SIGKILL)
        run.wait()
        hits, now = hits + 1, finished(store)
        assert now >= before, (now, before)
        before = now
        print(f"  killed {hits} times, {now} chunks", flush=True)
    return hits


def on_cluster(store, drives, kills, rng):
    """Sweep on a cluster while its workers are killed; how many were."""
    from distributed import Client, LocalCluster

    hits, over = [], threading.Event()

    def kill(cluster):
        while len(hits) < kills and not over.is_set():
            if finished(store) > len(hits) * drives // 5 // (kills + 2):
                # those that are connected: a nanny whose worker dies as it starts gives up
                names = [worker.name for worker in [*cluster.scheduler.workers.values()]]
                pids = [cluster.workers[name].pid for name in names if name in cluster.workers]
                if pids:
                    os.kill(rng.choice(pids), signal.SIGKILL)
                    hits.append(1)
            time.sleep(0.2)

    how = {"n_workers": 2, "threads_per_worker": 1, "dashboard_address": None, "silence_logs": 60}
    while not over.is_set():
        with LocalCluster(**how) as cluster, Client(cluster) as client:
            thread = threading.Thread(target=kill, args=(cluster,), daemon=True)
            thread.start()
            try:
                swept(store, drives, client=client)
                over.set()
            except RuntimeError as error:  # no worker is left: the store goes on with another cluster
                print(f"  {error}", flush=True)
    return len(hits)


def main():
    """Say what the kills did."""
    given = [int(text) for text in sys.argv[1:]]
    drives, kills, seed = (*given, *(2000, 20, 0)[len(given) :])
    rng = random.Random(seed)
    with tempfile.TemporaryDirectory() as folder:
        quiet = Path(folder) / "quiet"
        swept(quiet, drives, workers=1)
        for name, run in (("processes", killed), ("cluster", on_cluster)):
            store = Path(folder) / name
            hits = run(store, drives, kills, rng)
            swept(store, drives, workers=1)  # what is left
            same = contents(store) == contents(quiet)
            print(
                f"{name}: killed {hits} times, {drives} drives {'equal' if same else 'NOT equal'} to the bit",
                flush=True,
            )


if __name__ == "__main__":
    main()
