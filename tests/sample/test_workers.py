"""Sweeps in processes and on a cluster, killed in the middle: the results are those of a quiet run, bit for bit."""

import contextlib
import os
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest
import zarr

import strainwave as sw

distributed = pytest.importorskip("distributed")
dask = pytest.importorskip("dask")

pytestmark = pytest.mark.slow

SYSTEM = sw.Oscillator(1.0, 0.1, sw.Cubic(1.0, 0.1), sw.Harmonic(1.0), 1.0)
GRID = {"law.alpha": [0.5, 1.0, 2.0], "omega": np.linspace(1.0, 2.0, 20)}
MODULE = """
import os, signal, time

def noise(system, rng):
    time.sleep(0.005)
    return {"noise": system.omega * system.law.alpha + rng.normal(), "J": system.J}

def murderous(system):
    if system.law.alpha == 1.0 and system.omega < 1.02:
        os.kill(os.getpid(), signal.SIGKILL)
    return system.omega
"""


@pytest.fixture
def measures(tmp_path, monkeypatch):
    (tmp_path / "sweep_measures.py").write_text(MODULE)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(tmp_path), os.environ.get("PYTHONPATH", "")]))
    import sweep_measures

    yield sweep_measures
    del sys.modules["sweep_measures"]


def files_of(store):
    return {str(path.relative_to(store)): path.read_bytes() for path in store.rglob("*") if path.is_file()}


@pytest.fixture
def serial(measures, tmp_path):
    sw.sweep(measures.noise, SYSTEM, GRID, store=tmp_path / "serial", chunk=4, workers=1)
    return files_of(tmp_path / "serial")


@contextlib.contextmanager
def cluster():
    settings = {"distributed.scheduler.allowed-failures": 0, "distributed.comm.timeouts.connect": "10s"}
    with (
        dask.config.set(settings),
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, processes=True, host="127.0.0.1", protocol="tcp://",
            dashboard_address=None, silence_logs=60,
        ) as local,
        distributed.Client(local) as client,
    ):  # fmt: skip
        yield local, client


@contextlib.contextmanager
def once_begun(store, action):
    """Do something in another thread as soon as the store has a few chunks."""

    def wait():
        for _ in range(3000):
            with contextlib.suppress(Exception):
                if zarr.open_array(store / "done", mode="r")[:].sum() >= 3:
                    acted.append(True)
                    action()
                    return
            time.sleep(0.01)

    acted = []
    thread = threading.Thread(target=wait)
    thread.start()
    yield acted
    thread.join()


def test_processes_give_what_threads_give(measures, serial, tmp_path):
    sw.sweep(measures.noise, SYSTEM, GRID, store=tmp_path / "s", chunk=4, processes=True, workers=2)
    assert files_of(tmp_path / "s") == serial


def test_a_chunk_that_kills_its_process_is_reported_and_the_others_are_done(measures, tmp_path):
    result = sw.sweep(measures.murderous, SYSTEM, GRID, store=tmp_path / "s", chunk=5, processes=True, workers=2)
    lost = np.zeros((3, 20), bool)
    lost[1, :5] = True
    assert np.array_equal(result["point_status"], 3 * lost)
    assert np.array_equal(np.isnan(result["value"]), lost)
    assert "the worker process ended each time" in result.attrs["errors"].splitlines()[0]
    assert zarr.open_array(tmp_path / "s" / "done")[:].sum() == 11  # the next run tries it again


def test_a_cluster_gives_what_threads_give_though_a_worker_is_killed(measures, serial, tmp_path):
    store = tmp_path / "s"
    with cluster() as (local, client):
        victim = next(iter(local.workers.values())).pid
        with once_begun(store, lambda: os.kill(victim, signal.SIGKILL)) as killed:
            sw.sweep(measures.noise, SYSTEM, GRID, store=store, chunk=4, client=client)
    assert killed
    assert files_of(store) == serial


def test_a_chunk_that_kills_cluster_workers_is_reported_and_the_others_are_done(measures):
    with cluster() as (_, client):
        result = sw.sweep(measures.murderous, SYSTEM, GRID, chunk=5, client=client)
    assert np.flatnonzero(result["point_status"]).tolist() == [20, 21, 22, 23, 24]
    assert result.attrs["failed_points"] == 5


SCHEDULER = """
import asyncio, distributed

async def main():
    async with distributed.Scheduler(host="127.0.0.1", port=0, dashboard=False) as scheduler:
        print(scheduler.address, flush=True)
        await scheduler.finished()

asyncio.run(main())
"""


def test_a_scheduler_that_dies_is_one_sentence_and_the_store_goes_on(measures, serial, tmp_path):
    store, quiet = tmp_path / "s", {"stderr": subprocess.DEVNULL}
    scheduler = subprocess.Popen([sys.executable, "-c", SCHEDULER], stdout=subprocess.PIPE, text=True, **quiet)
    worker = None
    try:
        address = scheduler.stdout.readline().strip()
        command = "import sys; from distributed.cli.dask_worker import main; main()"
        worker = subprocess.Popen(
            [sys.executable, "-c", command, address, "--host", "127.0.0.1", "--no-nanny", "--no-dashboard"], **quiet
        )
        with distributed.Client(address, set_as_default=False) as client:
            client.wait_for_workers(1, timeout=60)
            with (
                once_begun(store, scheduler.kill) as killed,
                pytest.raises(RuntimeError, match=r"scheduler cannot be reached any more; \d+ of 15 chunks are kept"),
            ):
                sw.sweep(measures.noise, SYSTEM, GRID, store=store, chunk=4, client=client)
        assert killed
    finally:
        for process in (scheduler, worker):
            if process is not None:
                process.kill()
                process.communicate()
    sw.sweep(measures.noise, SYSTEM, GRID, store=store, chunk=4)
    assert files_of(store) == serial


RUN = """
import sys, numpy as np, strainwave as sw, sweep_measures
system = sw.Oscillator(1.0, 0.1, sw.Cubic(1.0, 0.1), sw.Harmonic(1.0), 1.0)
grid = {"law.alpha": [0.5, 1.0, 2.0], "omega": np.linspace(1.0, 2.0, 20)}
print("started", flush=True)
sw.sweep(sweep_measures.noise, system, grid, store=sys.argv[1], chunk=4, workers=1)
"""


def test_killed_at_any_moment_no_finished_chunk_is_lost_or_damaged(measures, serial, tmp_path, caplog):
    store, random = tmp_path / "s", np.random.default_rng(1)
    before = np.zeros(15, bool)
    for _ in range(5):
        run = subprocess.Popen([sys.executable, "-c", RUN, store], stdout=subprocess.PIPE)
        run.stdout.readline()
        time.sleep(random.uniform(0.4, 0.9))
        run.kill()
        run.communicate()
        if (store / "done").exists():
            done = zarr.open_array(store / "done", mode="r")[:] == 1
            assert not np.any(before & ~done)
            before = done
    sw.sweep(measures.noise, SYSTEM, GRID, store=store, chunk=4)
    assert "damaged" not in caplog.text
    assert files_of(store) == serial
