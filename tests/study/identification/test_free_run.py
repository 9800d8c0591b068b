"""A free run of what was identified: what it needs, and what it refuses; delays that only a common one tells."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import strainwave as sw

RATE, SAMPLES = 200.0, 1200
J, B, K = 2e-4, 4e-3, 1.0
GUESS = sw.Oscillator(1.6e-4, 6e-3, sw.Linear(0.9), sw.Harmonic(0.0), 1.0)
FREE = ("J", "B", "law.K")
pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def log():
    """J x'' + B x' + K x = a force of straight lines between samples."""
    t = np.arange(SAMPLES) / RATE
    force = sum(np.cos(2.0 * np.pi * f * t + 3.0 * f) for f in (2.0, 5.0, 8.5, 11.0, 13.5, 17.0, 21.0))

    def rhs(s, y):
        return y[1], (np.interp(s, t, force) - B * y[1] - K * y[0]) / J

    x = solve_ivp(rhs, (0.0, t[-1]), (0.2, 0.0), "DOP853", t, rtol=1e-9, atol=1e-11, max_step=1.0 / RATE).y[0]
    return {"time": t, "input": force, "output": x}


@pytest.fixture(scope="module")
def found(log):
    return sw.identify(GUESS, log, FREE, between="linear")


def test_samples_that_were_measured_in_turn_tell_the_same(log, found):
    sparse = np.where(np.arange(SAMPLES) % 3 == 0, log["output"], np.nan)
    part = sw.identify(GUESS, log | {"output": sparse}, FREE, between="linear")
    assert part.values == pytest.approx((J, B, K), rel=1e-4)
    assert found.values == pytest.approx((J, B, K), rel=1e-4)


@pytest.mark.parametrize("start", [[0.2, 0.0], np.array([0.2, 0.0]), {"output": [0.2]}, {"output": "gaps"}])
def test_a_start_is_a_state_or_measured_samples_with_gaps(log, found, start):
    if isinstance(start, dict) and start["output"] == "gaps":
        start = {"output": np.where(np.arange(SAMPLES) % 4 == 1, np.nan, log["output"])}
    run = found.simulate(log, start)["output"]
    assert run == pytest.approx(log["output"], abs=2e-3 * np.max(np.abs(log["output"])))


@pytest.mark.parametrize(
    ("change", "start", "said"),
    [
        (lambda t, u: (np.append(t[:-1] ** 1.01 * t[-2] ** -0.01, t[-1]), u), (0.2, 0.0), "resample to equal steps"),
        (lambda t, u: (t[:10], u), (0.2, 0.0), f"input has {SAMPLES} samples and time 10; give equally many"),
        (lambda t, u: (t[::-1], u), (0.2, 0.0), "times must ascend"),
        (lambda t, u: (t[:1], u[:1]), (0.2, 0.0), "inputs have 1 samples; give 2 at least"),
        (lambda t, u: (t, u), {"output": [np.nan, np.nan]}, "start has no measured sample"),
    ],
)
def test_inputs_that_do_not_fit_are_refused(log, found, change, start, said):
    time, force = change(log["time"], log["input"])
    with pytest.raises(ValueError, match=said):
        found.simulate({"time": time, "input": force}, start)


def test_a_motion_that_leaves_every_bound_is_no_result(log):
    falling = sw.Oscillator(1.6e-4, 6e-3, sw.Cubic(0.9, 0.0), sw.Harmonic(0.0), 1.0)
    found = sw.identify(falling, log, (*FREE, "law.alpha"), between="linear")
    with pytest.raises(sw.SolveError, match=r"diverges before sample 1, 0\.005 s"):
        found.simulate(log, (1e59, 0.0))


def test_an_interval_of_what_is_no_number_is_refused(found):
    with pytest.raises(ValueError, match="give one that has a finite number there"):
        found.interval_of(lambda _system: np.nan)


def test_delays_of_all_signals_are_refused_together(log):
    with pytest.raises(ValueError, match="a common delay changes nothing; fix one of them"):
        sw.identify(GUESS, log, (*FREE, "excitation.delay", "x.delay"))
    error = sw.KinematicError((sw.Line(2, 0.05, 0.3),))  # tells the time
    by_time = sw.identify(
        GUESS._replace(omega=12.0, error=error), log, (*FREE, "excitation.delay", "x.delay"), between="linear"
    )
    assert len(by_time.names) == 5


def test_a_delay_of_many_samples_asks_for_the_channel_to_be_shifted(log):
    late = {"time": log["time"][:-3], "input": log["input"][3:], "output": log["output"][:-3]}  # 15 ms
    guess = GUESS._replace(J=J, B=B, law=sw.Linear(K))
    found = sw.identify(guess, late, ("law.K", "excitation.delay"), between="linear")
    assert found.value("excitation.delay") == pytest.approx(0.015, abs=1e-4)
    assert "excitation.delay is 3 samples" in found.notes[0]
    assert "shift the channel by 3 samples and cut the log" in found.notes[0]
