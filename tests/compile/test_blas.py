"""BLAS on one thread while the package computes, and on the user's number before and after."""

from threading import Event, Thread

import numpy as np
import pytest

import strainwave as sw
from strainwave.base.blas import one_thread, threads_of

np.linalg.inv(np.eye(2))
NUMPY = threads_of("numpy.linalg._umath_linalg")
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(NUMPY is None, reason="NumPy has another BLAS here, whose threads are left alone"),
]


@pytest.fixture
def count():
    """Number of threads, three of them by the user's setting."""
    get, put = NUMPY
    before = get()
    put(3)
    yield get
    put(before)


def test_inside_there_is_one_thread_and_afterwards_the_users_number(count):
    with one_thread:
        assert count() == 1
        with one_thread:
            assert count() == 1
        assert count() == 1
    assert count() == 3


def test_an_error_inside_leaves_the_users_number(count):
    @one_thread
    def fails():
        assert count() == 1
        raise KeyError

    with pytest.raises(KeyError):
        fails()
    assert count() == 3


def test_the_last_of_two_threads_to_leave_lets_go(count):
    entered, leave = Event(), Event()

    def stay():
        with one_thread:
            entered.set()
            leave.wait(10.0)

    other = Thread(target=stay)
    with one_thread:
        other.start()
        assert entered.wait(10.0)
    assert count() == 1
    leave.set()
    other.join()
    assert count() == 3


def test_a_number_that_somebody_sets_inside_stays(count):
    with one_thread:
        NUMPY[1](2)
    assert count() == 2


def test_a_module_that_is_not_loaded_has_no_threads():
    assert threads_of("no_module") is None


def test_a_response_of_the_slow_flow_is_computed_on_one_thread(count, monkeypatch):
    system = sw.Oscillator(J=1.0, B=10.0, law=sw.Cubic(1e4, 0.1), excitation=sw.Harmonic(1.0), omega=100.0)
    flow = sw.slow_flow(system, sw.Resonance(1, 1))
    seen = []
    monkeypatch.setattr("strainwave.theory.slow_flow.response.states", lambda *_: seen.append(count()) or 1 / 0)
    with pytest.raises(ZeroDivisionError):
        flow.response((80.0, 120.0))
    assert seen == [1]
    assert count() == 3
