"""Sweeps: what every point gets, what an interruption or a fault costs, and who is refused."""

import errno
import json
import math
import os
import signal
import subprocess
import sys
import threading
import time
from dataclasses import dataclass
from functools import partial
from typing import ClassVar

import numpy as np
import pytest
import xarray as xr
import zarr
from hypothesis import given
from hypothesis import strategies as st

import strainwave as sw
from strainwave.sample import store as sweep_store
from strainwave.sample.chunks import chunk_size, layout_of
from strainwave.sample.sampling import GridPoints
from strainwave.sample.store_lock import StoreLock

SYSTEM = sw.Oscillator(1.0, 0.1, sw.Cubic(1.0, 0.1), sw.Harmonic(1.0), 1.0)
ALPHA, OMEGA = np.array([0.5, 1.0, 2.0]), np.linspace(1.0, 2.0, 20)
GRID = {"law.alpha": ALPHA, "omega": OMEGA}


class Notes(list):
    """What measures note as they run; what it holds is no part of their identity."""

    def __reduce__(self):
        return Notes, ()


CALLS, AT_CALL = Notes(), Notes()  # AT_CALL: pairs of a number of calls and what happens at it


def product(system):
    CALLS.append((system.law.alpha, system.omega))
    for pair in [pair for pair in AT_CALL if pair[0] == len(CALLS)]:
        AT_CALL.remove(pair)
        pair[1]()
    return {"product": system.law.alpha * system.omega, "J": system.J}


def noise(system, rng):
    return system.omega + rng.normal()


def picky(system):
    if system.omega == OMEGA[3]:
        raise ZeroDivisionError("division of\n the indivisible")
    if system.omega == OMEGA[5]:
        return [1.0, 2.0]
    if system.omega == OMEGA[6]:
        return {"another": 1.0}
    if system.omega == OMEGA[7]:
        return 1j
    return system.omega


@dataclass(frozen=True)
class Chunkwise:
    """A whole chunk at a time; raises wherever omega is in `bad`."""

    bad: tuple[float, ...] = ()
    whole_chunks: ClassVar[bool] = True

    def __call__(self, system, values):
        CALLS.append(len(values["omega"]))
        if np.isin(values["omega"], self.bad).any():
            raise ArithmeticError("bad speed")
        return {"twice": 2.0 * values["omega"], "pair": np.stack([values["omega"], -values["omega"]], axis=1)}


@dataclass(frozen=True)
class Slow:
    """A whole chunk at a time, that of `at` for ever."""

    at: float
    whole_chunks: ClassVar[bool] = True

    def __call__(self, system, values):
        try:
            if self.at in values["omega"]:
                signal.pthread_kill(threading.main_thread().ident, signal.SIGINT)
            while self.at in values["omega"]:
                time.sleep(0.01)
        except KeyboardInterrupt:
            CALLS.append("given up")
            raise
        return {"omega": values["omega"]}


@pytest.fixture(autouse=True)
def fresh():
    CALLS.clear()
    AT_CALL.clear()


def files_of(store):
    """Every file of a store by its path, as it lies on the disk."""
    return {str(path.relative_to(store)): path.read_bytes() for path in store.rglob("*") if path.is_file()}


def test_every_point_of_a_grid_gets_its_measure():
    result = sw.sweep(product, SYSTEM, GRID, units={"product": "rad/s"})
    assert result["product"].dims == ("law.alpha", "omega")
    assert np.array_equal(result["product"], ALPHA[:, None] * OMEGA)
    assert np.array_equal(result["J"], np.ones((3, 20)))
    assert np.array_equal(result["omega"], OMEGA)
    assert result["omega"].attrs["units"] == "rad/s"
    assert result["product"].attrs["units"] == "rad/s"
    assert not result["point_status"].any()
    assert (result.attrs["strainwave"], result.attrs["measure"]) == (sw.__version__, "product")


def test_the_points_of_a_sample_carry_their_parameters(tmp_path):
    sample = sw.sample.Sobol(64, {"law.alpha": sw.Normal(1.0, 0.1), "omega": sw.Uniform(1.0, 2.0)})
    result = sw.sweep(product, SYSTEM, sample, store=tmp_path / "s", chunk=10)
    assert result["product"].dims == ("point",)
    assert np.array_equal(result["product"], result["law.alpha"] * result["omega"])
    assert len(np.unique(result["omega"])) == 64
    assert set(result.coords) == {"law.alpha", "omega"}
    assert result.identical(sw.sweep(product, SYSTEM, sample, store=tmp_path / "s", chunk=10))


def test_the_store_is_read_through_xarray_when_its_values_are_used(tmp_path):
    result = sw.sweep(product, SYSTEM, GRID, store=tmp_path / "s")
    assert not result["product"].variable._in_memory
    opened = xr.open_zarr(tmp_path / "s", consolidated=False, chunks=None)
    assert np.array_equal(opened["product"], ALPHA[:, None] * OMEGA)
    assert opened.attrs["spec"] == result.attrs["spec"]


@pytest.mark.parametrize(
    ("measure", "grid"),
    [
        (product, GRID),
        (picky, {"omega": OMEGA}),
        (
            lambda system: {"law": system.law.K, "lists": np.arange(3.0)},
            sw.sample.Sobol(8, {"J": sw.Uniform(1.0, 2.0)}),
        ),
        (lambda system: system.B, {("J", "B"): [0.9, 1.0, 1.1]}),
        (sw.EnsembleMeasure((0.0, 0.0), 2, (sw.Peak(), sw.Final())), {"omega": OMEGA[:4]}),
    ],
)
def test_results_are_written_as_netcdf_and_read_back_equal(tmp_path, measure, grid):
    for store in (None, tmp_path / "s"):
        result = sw.sweep(measure, SYSTEM, grid, store=store)
        result.to_netcdf(tmp_path / "s.nc", engine="scipy")  # which holds neither lists of text nor 64-bit integers
        with xr.open_dataset(tmp_path / "s.nc", engine="scipy") as back:
            assert back.identical(result)
            assert set(back.attrs["parameters"].split(", ")) == set(result.coords) - {"state"}


def test_points_that_fail_are_told_and_the_sweep_goes_on():
    result = sw.sweep(picky, SYSTEM, {"omega": OMEGA})
    status = np.zeros(20, int)
    status[[3, 5, 6, 7]] = 1, 2, 2, 2
    assert np.array_equal(result["point_status"], status)
    assert np.array_equal(np.isnan(result["value"]), status > 0)
    assert np.array_equal(result["value"][status == 0], OMEGA[status == 0])
    assert result.attrs["failed_points"] == 4
    first = f"point 3 (omega = {OMEGA[3]:.9g}): ZeroDivisionError: division of the indivisible"
    assert result.attrs["errors"].splitlines() == [first]


class Unspeakable(Exception):
    def __str__(self):
        raise ValueError("no words")


@pytest.mark.parametrize(
    ("error", "words"), [(SystemExit(3), "SystemExit: 3"), (Unspeakable(), "Unspeakable: no reason given")]
)
@pytest.mark.parametrize("workers", [{"workers": 1}, {"workers": 2}])
def test_whatever_a_measure_raises_is_told(error, words, workers):
    def rude(system):
        if system.omega == OMEGA[3]:
            raise error
        return system.omega

    result = sw.sweep(rude, SYSTEM, {"omega": OMEGA}, **workers)
    assert np.flatnonzero(result["point_status"]).tolist() == [3]
    assert result.attrs["errors"].splitlines()[0].endswith(words)


def test_a_measure_that_always_fails_gives_a_store_without_variables(tmp_path):
    def hopeless(system):
        assert not system

    result = sw.sweep(hopeless, SYSTEM, GRID, store=tmp_path / "s", chunk=7)
    assert result.attrs["failed_points"] == 60
    assert "AssertionError" in result.attrs["errors"].splitlines()[0]
    assert set(result) == {"point_status"}
    assert result.identical(sw.sweep(hopeless, SYSTEM, GRID, store=tmp_path / "s", chunk=7))


def test_a_measure_may_take_whole_chunks():
    result = sw.sweep(Chunkwise(), SYSTEM, GRID, chunk=20)
    assert CALLS == [20, 20, 20]
    assert np.array_equal(result["twice"], np.tile(2.0 * OMEGA, (3, 1)))
    assert result["pair"].dims == ("law.alpha", "omega", "pair_1")
    assert np.array_equal(result["pair"][1], np.stack([OMEGA, -OMEGA], axis=1))


def test_in_a_whole_chunk_that_fails_the_points_are_found():
    result = sw.sweep(Chunkwise(bad=(OMEGA[4], OMEGA[17])), SYSTEM, {"omega": OMEGA}, workers=1)
    assert np.flatnonzero(result["point_status"]).tolist() == [4, 17]
    assert np.array_equal(np.isnan(result["twice"]), result["point_status"] == 1)
    assert "ArithmeticError: bad speed" in result.attrs["errors"].splitlines()[0]


def test_a_whole_chunk_that_always_fails_costs_a_bounded_number_of_calls():
    omega = np.linspace(1.0, 2.0, 5000)
    result = sw.sweep(Chunkwise(bad=tuple(omega)), SYSTEM, {"omega": omega}, workers=1, chunk=5000)
    assert result.attrs["failed_points"] == 5000
    assert len(CALLS) < 100


def test_random_numbers_depend_on_the_seed_and_the_point_alone():
    few, many = (sw.sweep(noise, SYSTEM, GRID, seed=7, chunk=n) for n in (3, 60))
    assert np.array_equal(few["value"], many["value"])
    children = np.random.SeedSequence(7).spawn(60)
    expected = np.tile(OMEGA, 3) + [np.random.default_rng(child).normal() for child in children]
    assert np.array_equal(few["value"].values.ravel(), expected)
    assert not np.any(few["value"] == sw.sweep(noise, SYSTEM, GRID, seed=8)["value"])


def test_an_interrupted_sweep_goes_on_where_it_stopped(tmp_path):
    whole = tmp_path / "whole"
    sw.sweep(product, SYSTEM, GRID, store=whole, chunk=10)
    CALLS.clear()
    main = threading.main_thread().ident
    AT_CALL.append((30, partial(signal.pthread_kill, main, signal.SIGINT)))
    with pytest.raises(KeyboardInterrupt, match=r"interrupted; \d+ of 6 chunks are kept .* run the same sweep again"):
        sw.sweep(product, SYSTEM, GRID, store=tmp_path / "s", chunk=10, workers=1)
    kept = int(zarr.open_array(tmp_path / "s" / "done")[:].sum())
    assert 1 <= kept < 6
    CALLS.clear()
    sw.sweep(product, SYSTEM, GRID, store=tmp_path / "s", chunk=10)
    assert len(CALLS) == 10 * (6 - kept)
    assert files_of(tmp_path / "s") == files_of(whole)
    assert not (tmp_path / "s.lock").exists()


def test_on_ctrl_c_chunks_under_way_are_given_up_and_not_waited_for(tmp_path, caplog):
    grid = {"omega": np.linspace(1.0, 2.0, 1024)}
    with pytest.raises(KeyboardInterrupt, match=r"interrupted; 3 of 4 chunks are kept"):
        sw.sweep(Slow(2.0), SYSTEM, grid, store=tmp_path / "s", workers=1)
    assert CALLS == ["given up"]
    assert caplog.text == ""  # nor does a thread die of it


def nothing(system):
    CALLS.append(system.omega)
    return {"some": system.omega, "none": float("nan")}


def test_a_chunk_of_nan_is_a_result_and_not_a_damaged_one(tmp_path, caplog):
    sw.sweep(nothing, SYSTEM, GRID, store=tmp_path / "s", chunk=10)
    CALLS.clear()
    assert np.isnan(sw.sweep(nothing, SYSTEM, GRID, store=tmp_path / "s", chunk=10)["none"]).all()
    assert (CALLS, caplog.text) == ([], "")


def damaged(path):
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(content)


@pytest.mark.parametrize(
    ("name", "harm"),
    [
        ("product", damaged),
        ("product", lambda path: path.write_bytes(b"")),
        ("product", lambda path: path.unlink()),
        ("point_status", damaged),
        ("point_status", lambda path: path.unlink()),
    ],
)
def test_a_damaged_chunk_is_computed_again(tmp_path, caplog, name, harm):
    store = tmp_path / "s"
    sw.sweep(product, SYSTEM, GRID, store=store, chunk=10)
    before = files_of(store)
    harm(store / name / "c" / "1" / "1")
    CALLS.clear()
    sw.sweep(product, SYSTEM, GRID, store=store, chunk=10)
    assert [(1.0, omega) for omega in OMEGA[10:20]] == CALLS
    assert files_of(store) == before
    assert "chunk 3 of" in caplog.text
    assert "computed again" in caplog.text


MASSES = np.array([1.0, -1.0, 2.0, 1e70])


def test_an_impossible_point_has_the_sentence_of_a_single_system():
    result = sw.sweep(product, SYSTEM, {"J": MASSES})
    assert result["point_status"].values.tolist() == [0, 1, 0, 1]
    assert (
        "point 1 (J = -1): ValueError: Oscillator.J is -1 kg*m**2; an inertia must be"
        in result.attrs["errors"].splitlines()[0]
    )
    assert len(CALLS) == 2


@pytest.mark.parametrize("order", [("J", "omega"), ("omega", "J")])
def test_impossible_points_of_a_whole_chunk_leave_the_others_alone(order):
    grid = {"J": MASSES, "omega": OMEGA}
    result = sw.sweep(Chunkwise(), SYSTEM, {path: grid[path] for path in order}, workers=1)
    bad = (result["J"] < 0.0) | (result["J"] > 1e60)
    assert np.array_equal(result["point_status"].transpose("J", "omega"), np.repeat(bad.values[:, None], 20, axis=1))
    assert np.array_equal(result["twice"].sel(J=2.0), 2.0 * OMEGA)
    assert "J = -1" in result.attrs["errors"].splitlines()[0]
    assert "): Oscillator.J is -1 kg*m**2; an inertia must be" in result.attrs["errors"].splitlines()[0]
    assert max(CALLS) == 40


def test_lanes_that_an_ensemble_refuses_leave_the_others_alone():
    measure = sw.EnsembleMeasure((0.0, 0.0), 1, method=sw.Rk4(steps_per_period=16))
    omega = np.tile([1.0, -1.0, 2.0, 0.0], 100)  # more pieces than a search by halves would find
    result = sw.sweep(measure, SYSTEM, {"omega": omega}, workers=1)
    assert np.array_equal(result["point_status"], omega <= 0.0)
    assert np.array_equal(np.isfinite(result["peak"]), omega > 0.0)
    assert "point 1 (omega = -1): omega is -1 rad/s; it must be positive" in result.attrs["errors"].splitlines()[0]


def test_parameters_that_share_a_factor_are_scaled_together(tmp_path):
    law = sw.PiecewiseLinear(1.0, 1.4, 1.8, 0.5, 1.2)
    grid = {("law.K1", "law.K2", "law.K3"): [0.5, 1.0, 2.0], "omega": [1.0, 3.0]}

    def stiffnesses(system):
        return dict(zip("abc", (system.law.K1, system.law.K2, system.law.K3), strict=True)) | {"w": system.omega}

    for _ in range(2):  # computed, and read again
        result = sw.sweep(stiffnesses, SYSTEM._replace(law=law), grid, store=tmp_path / "s")
        assert result["a"].dims == ("law.K1 & law.K2 & law.K3", "omega")
        assert result["law.K1 & law.K2 & law.K3"].attrs["units"] == ""
        np.testing.assert_allclose(result["b"][:, 1], [0.7, 1.4, 2.8])
        np.testing.assert_allclose(result["c"] / result["a"], 1.8)
    sample = sw.sample.LatinHypercube(50, {("law.K1", "law.K2"): sw.Normal(1.0, 0.1)})
    result = sw.sweep(stiffnesses, SYSTEM._replace(law=law), sample)
    np.testing.assert_allclose(result["a"], result["law.K1 & law.K2"])
    np.testing.assert_allclose(result["b"] / result["a"], 1.4)


def test_units_of_nothing_are_refused_before_anything_is_kept_and_on_resuming(tmp_path):
    def again(**more):
        return sw.sweep(product, SYSTEM, GRID, store=tmp_path / "s", chunk=10, **more)

    for _ in range(2):
        with pytest.raises(ValueError, match="units has 'peek', which the measure does not return"):
            again(units={"peek": "rad"})
        assert not again()["point_status"].any()
        (tmp_path / "s" / "done" / "c" / "3").unlink()


def test_a_chunk_beyond_the_memory_is_one_sentence(tmp_path, monkeypatch):
    def full(*_):
        raise MemoryError("Unable to allocate 8.00 GiB for an array")

    monkeypatch.setattr(GridPoints, "values", full)
    with pytest.raises(RuntimeError, match=r"a chunk has up to 10 points, too many .* 0 of 6 chunks are kept"):
        sw.sweep(product, SYSTEM, GRID, store=tmp_path / "s", chunk=10)


def test_results_that_fit_nowhere_are_refused_after_the_first_chunk(tmp_path, monkeypatch):
    assert 0.0 < sweep_store._room(tmp_path) < math.inf
    assert sweep_store._room(None) > 1e8
    monkeypatch.setattr(sweep_store, "_room", lambda _: 1019.0)  # and 60 points take 1 + 2 * 8 bytes each
    for store, words in ((tmp_path / "s", "the disk of .* has free"), (None, "memory; .* or give the sweep a store")):
        with pytest.raises(ValueError, match=r"the results of 60 points take 1.02e-06 GB, more than .*" + words):
            sw.sweep(product, SYSTEM, GRID, store=store, chunk=10)
        assert len(CALLS) == 10
        CALLS.clear()


def test_what_a_killed_write_leaves_behind_is_removed(tmp_path):
    store = tmp_path / "s"
    sw.sweep(product, SYSTEM, GRID, store=store, chunk=10)
    before = files_of(store)
    (store / "done" / "c" / "3").unlink()
    (store / "product" / "c" / "1" / "1.0123.partial").write_bytes(b"half")
    (tmp_path / "s.partial").mkdir()
    sw.sweep(product, SYSTEM, GRID, store=store, chunk=10)
    assert files_of(store) == before
    assert [path.name for path in tmp_path.iterdir()] == ["s"]


def test_a_complete_store_is_read_where_nothing_can_be_written(tmp_path, monkeypatch):
    store = tmp_path / "s"
    first = sw.sweep(product, SYSTEM, GRID, store=store, chunk=10)
    before = files_of(store)
    CALLS.clear()

    def refused(*_args, **_more):
        raise OSError(errno.EROFS, "Read-only file system")

    monkeypatch.setattr(os, "open", refused)
    assert first.identical(sw.sweep(product, SYSTEM, GRID, store=store, chunk=10))
    assert files_of(store) == before
    (store / "done" / "c" / "3").unlink()
    with pytest.raises(RuntimeError, match=r"cannot be opened \(read-only file system\)"):
        sw.sweep(product, SYSTEM, GRID, store=store, chunk=10)
    with pytest.raises(RuntimeError, match=r"cannot be opened \(read-only file system\)"):
        sw.sweep(product, SYSTEM, GRID, store=tmp_path / "new", chunk=10)
    assert CALLS == []


@pytest.mark.parametrize("harm", [lambda file: file.unlink(), lambda file: file.write_bytes(b"garbled")])
def test_damaged_values_of_the_grid_are_written_again(tmp_path, harm, caplog):
    store = tmp_path / "s"
    sw.sweep(product, SYSTEM, GRID, store=store, chunk=10)
    before = files_of(store)
    harm(store / next(iter(GRID)) / "c" / "0")
    again = sw.sweep(product, SYSTEM, GRID, store=store, chunk=10)
    assert np.array_equal(again[next(iter(GRID))], GRID[next(iter(GRID))])
    assert files_of(store) == before
    assert "are rewritten" in caplog.text


def test_the_store_of_another_sweep_is_refused_and_stays_as_it_is(tmp_path):
    call = {"measure": product, "system": SYSTEM, "grid": GRID, "chunk": 10}
    sw.sweep(**call, store=tmp_path / "s")
    before = files_of(tmp_path / "s")
    others = [
        {"system": SYSTEM._replace(J=2.0)}, {"grid": GRID | {"omega": OMEGA + 1e-12}}, {"measure": noise}, {"seed": 1},
        {"chunk": 5},
    ]  # fmt: skip
    for other in others:
        with pytest.raises(ValueError, match=r"holds another sweep \(product over law.alpha, omega"):
            sw.sweep(**call | other, store=tmp_path / "s")
    assert files_of(tmp_path / "s") == before


def test_a_sweep_begun_by_another_version_is_not_mixed(tmp_path):
    store = tmp_path / "s"
    sw.sweep(product, SYSTEM, GRID, store=store, chunk=10)
    group = zarr.open_group(store)
    group.attrs["strainwave"] = "0.0.1"
    assert sw.sweep(product, SYSTEM, GRID, store=store, chunk=10).attrs["strainwave"] == "0.0.1"
    (store / "done" / "c" / "3").unlink()
    with pytest.raises(ValueError, match=r"begun with strainwave 0.0.1"):
        sw.sweep(product, SYSTEM, GRID, store=store, chunk=10)


def test_a_folder_that_is_no_store_is_refused_and_an_empty_one_taken(tmp_path):
    full, empty = tmp_path / "full", tmp_path / "empty"
    full.mkdir()
    empty.mkdir()
    (full / "thesis.txt").write_text("all of it")
    with pytest.raises(ValueError, match="not a store of a sweep"):
        sw.sweep(product, SYSTEM, GRID, store=full)
    assert (full / "thesis.txt").read_text() == "all of it"
    assert not sw.sweep(product, SYSTEM, GRID, store=empty)["point_status"].any()


HOLD = """
import sys, pathlib
from strainwave.sample.store_lock import StoreLock
lock = StoreLock(pathlib.Path(sys.argv[1]))
print("held", flush=True)
sys.stdin.read()
"""


def test_a_second_process_is_refused_and_a_dead_one_is_not(tmp_path, caplog):
    store = tmp_path / "s"
    holder = subprocess.Popen([sys.executable, "-c", HOLD, store], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    try:
        assert holder.stdout.readline() == b"held\n"
        with pytest.raises(RuntimeError, match=f"process {holder.pid} on .* is working on this store"):
            sw.sweep(product, SYSTEM, GRID, store=store)
        assert not store.exists()
    finally:
        holder.kill()
        holder.communicate()
    assert sw.sweep(product, SYSTEM, GRID, store=store).attrs["failed_points"] == 0
    assert f"the lock of process {holder.pid}, which no longer runs, is taken over" in caplog.text


def test_a_lock_of_another_machine_is_respected(tmp_path):
    (tmp_path / "s.lock").write_text(json.dumps({"pid": 1, "host": "another"}))
    with pytest.raises(RuntimeError, match=r"process 1 on another .* delete .*s\.lock"):
        sw.sweep(product, SYSTEM, GRID, store=tmp_path / "s")
    assert (tmp_path / "s.lock").exists()


def test_the_lock_is_free_for_others_after_its_release(tmp_path):
    first = StoreLock(tmp_path / "s")
    with pytest.raises(RuntimeError, match=f"process {os.getpid()} on"):
        StoreLock(tmp_path / "s")
    first.release()
    StoreLock(tmp_path / "s").release()
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("writes", [0, 3, 15])
def test_a_full_disk_ends_the_sweep_with_one_sentence_and_loses_nothing(tmp_path, monkeypatch, writes):
    whole, store = tmp_path / "whole", tmp_path / "s"
    sw.sweep(product, SYSTEM, GRID, store=whole, chunk=10)
    put, done = zarr.storage._local._put, []

    def full(*args, **keywords):
        done.append(1)
        if len(done) > writes:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return put(*args, **keywords)

    with monkeypatch.context() as patch:
        patch.setattr(zarr.storage._local, "_put", full)
        with pytest.raises(RuntimeError, match=r"no space left on device.*free some space and run the same sweep"):
            sw.sweep(product, SYSTEM, GRID, store=store, chunk=10)
    sw.sweep(product, SYSTEM, GRID, store=store, chunk=10)
    assert files_of(store) == files_of(whole)


def test_a_folder_that_cannot_be_written_is_told_in_one_sentence(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(RuntimeError, match="cannot be opened") as refusal:
        sw.sweep(product, SYSTEM, GRID, store=tmp_path / "file" / "s")
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"grid": {"law.beta": [1.0]}}, "no parameter 'law.beta'; it has J, B"),
        ({"grid": {"law": [1.0]}}, "no parameter 'law'; it has J, B"),
        ({"grid": {("law.K",): [1.0]}}, r"\('law.K',\) is not a parameter; give a path .* or a tuple of several"),
        ({"grid": {("law.K", "law.alpha"): [1.0], "law.K": [1.0]}}, "law.K is given twice"),
        ({"grid": {("law.K", "excitation.order"): [1.0]}}, "excitation.order is a whole number"),
        (
            {"grid": {p: np.ones(10**4) for p in ("J", "B", "law.K", "omega")}},
            r"the sweep has 1e\+16 points, .* chunks",
        ),
        ({"chunk": 1, "grid": sw.sample.Sobol(2**30, {"J": sw.Uniform(1.0, 2.0)})}, "or a larger chunk"),
        (
            {"chunk": 2**40, "grid": sw.sample.Sobol(2**30, {"J": sw.Uniform(1.0, 2.0)})},
            r"chunk has 1\.074e\+09 points",
        ),
        ({"chunk": 0}, "chunk is 0"),
        ({"workers": 0}, "workers is 0"),
        ({"workers": 10**9}, "workers is 1000000000; it must be at most 1024"),
        ({"store": ""}, "store is ''; it must name a folder"),
        ({"store": "s\0"}, "it must name a folder"),
        ({"store": "table.CSV"}, "store is 'table.CSV'; a sweep is kept in a folder.* such as 'table.zarr'"),
        ({"seed": -1}, "seed is -1"),
        ({"measure": lambda system: system.J, "processes": True}, "cannot be sent to another process"),
    ],
)
def test_wrong_arguments_are_refused_before_anything_is_computed(change, words):
    with pytest.raises((TypeError, ValueError), match=words):
        sw.sweep(**{"measure": product, "system": SYSTEM, "grid": GRID} | change)
    assert CALLS == []


CELL = """
import strainwave as sw
def measure(system): return system.J
system = sw.Oscillator(1.0, 0.1, sw.Linear(1.0), sw.Harmonic(1.0), 1.0)
for how in ({}, {"processes": True}):
    try:
        print(sw.sweep(measure, system, {"J": [1.0, 2.0]}, workers=1, **how)["value"].values.tolist())
    except TypeError as error:
        print(error)
"""


@pytest.mark.parametrize(
    ("call", "why"),
    [
        (["-c", CELL], "it is defined at the prompt or in a notebook cell"),
        (["-"], "this program is no file that a process can read: <stdin>"),
    ],
)
def test_a_measure_of_a_notebook_cell_is_swept_in_threads_and_refused_for_processes(call, why):
    run = subprocess.run([sys.executable, *call], input=CELL, capture_output=True, text=True, check=True)
    values, refusal = run.stdout.splitlines()
    assert values == "[1.0, 2.0]"
    assert refusal == (
        f"the measure or the system cannot be sent to another process ({why}); define it at the top level of a module, "
        "or leave out processes=True"
    )


def test_progress_tells_the_chunks_and_their_share():
    told = []
    sw.sweep(product, SYSTEM, GRID, chunk=20, workers=1, progress=lambda stage, share: told.append((stage, share)))
    shares = [share for _, share in told]
    assert shares == sorted(shares)
    assert told[-1] == ("3 of 3 chunks", 1.0)


@given(st.lists(st.integers(1, 9), min_size=1, max_size=4), st.integers(1, 50))
def test_chunks_are_consecutive_points_and_cover_all(shape, target):
    layout = layout_of(tuple(shape), target)
    numbers = np.arange(layout.points).reshape(shape)
    found = []
    for chunk in range(layout.chunks):
        stretch = layout.stretch(chunk)
        assert 1 <= stretch.points <= target
        block = numbers[stretch.region].ravel()
        assert np.array_equal(block, np.arange(stretch.first, stretch.first + stretch.points))
        found += block.tolist()
    assert found == list(range(layout.points))


def test_a_grid_of_a_million_million_points_is_cut_without_making_them():
    from strainwave.sample.sampling import points_of

    points = points_of({"J": range(1, 10_001), "B": range(10_000), "omega": range(10_000)})
    layout = layout_of(points.shape, 65536)
    assert layout.points == 10**12
    last = layout.stretch(layout.chunks - 1)
    values = points.values(last.first, last.points)
    assert last.points <= 65536
    assert [values[path][-1] for path in ("J", "B", "omega")] == [10_000, 9_999, 9_999]


@pytest.mark.parametrize(
    ("shape", "least", "block"),
    [
        ((4096,), None, (32,)),
        ((1 << 20,), None, (256,)),
        ((200,), 256, (200,)),
        ((1024,), 256, (256,)),
        ((100, 150), 256, (3, 150)),  # one row of 150 would leave 106 of 256 lanes empty
        ((100, 150), 8192, (50, 150)),
        ((1 << 20,), 256, (1 << 14,)),
        ((1 << 20,), 1 << 17, (1 << 17,)),
        ((10**7,), 256, (129871,)),
    ],
)
def test_chunks_of_whole_blocks_are_a_64th_of_the_points(shape, least, block):
    assert layout_of(shape, chunk_size(shape, least)).block == block


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"y0": (0.0,)}, "y0 has 1 states; Oscillator has 2"),
        ({"periods": 0}, "periods is 0"),
        ({"settle": -1}, "settle is -1"),
        ({"measures": (3,)}, "3 is no measure"),
        ({"method": "rk4"}, "method is 'rk4'"),
    ],
)
def test_a_measure_that_would_fail_everywhere_is_refused_before_there_is_a_store(change, words, tmp_path):
    measure = sw.EnsembleMeasure(**{"y0": (0.0, 0.0), "periods": 2} | change)
    with pytest.raises((TypeError, ValueError), match=words):
        sw.sweep(measure, SYSTEM, GRID, store=tmp_path / "s")
    assert list(tmp_path.iterdir()) == []


def test_the_least_chunk_is_what_the_steps_need():
    kinked = SYSTEM._replace(law=sw.Backlash(1.0, 0.1))
    assert sw.EnsembleMeasure((0.0, 0.0), 1).least_chunk(kinked) == 256
    assert sw.EnsembleMeasure((0.0, 0.0), 1).least_chunk(SYSTEM) == 8192


@pytest.mark.slow
def test_an_ensemble_in_chunks_is_the_ensemble_as_a_whole(tmp_path):
    method, kept = sw.Rk4(steps_per_period=20), (sw.Peak(), sw.Final())
    measure = sw.EnsembleMeasure((0.1, 0.0), 2, kept, settle=1, method=method)
    swept = sw.sweep(measure, SYSTEM, GRID, store=tmp_path / "s", chunk=20)
    alpha, omega = (mesh.ravel() for mesh in np.meshgrid(ALPHA, OMEGA, indexing="ij"))
    whole = sw.ensemble(
        SYSTEM, {"law.alpha": alpha, "omega": omega}, (0.1, 0.0), periods=2, settle=1, measures=kept, method=method
    )
    assert np.array_equal(swept["peak"].values.ravel(), whole["peak"])
    assert np.array_equal(swept["final"].values.reshape(60, 2), whole["final"].transpose("lane", "state"))
    assert swept["final"].dims == ("law.alpha", "omega", "state")
    assert list(swept["state"].values) == list(whole["state"].values)
    assert swept["peak"].attrs["units"] == "rad"
    # the largest estimate of the chunks, each from 16 of its 20 lanes: all of the same size here
    assert swept["peak"].attrs["error_estimate"] == pytest.approx(whole["peak"].attrs["error_estimate"], rel=0.5)
    estimates = zarr.open_array(tmp_path / "s" / "error_estimate")[:]
    assert swept["peak"].attrs["error_estimate"] == estimates[:, 0].max()
