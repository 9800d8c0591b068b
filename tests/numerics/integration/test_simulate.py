"""Integration in time: order, exact solutions, SciPy as the independent check, divergence and bad input."""

import logging
import math
from functools import partial
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import pytest
from canonical import CSF_40_50
from scipy.integrate import solve_ivp

import strainwave as sw
from strainwave.numerics.integration import methods, record, steps, switches
from strainwave.numerics.integration.workspace import K, Y, workspace

DUFFING = sw.Oscillator(1.0, 0.05, sw.Cubic(1.0, 0.1), sw.Harmonic(0.18), 1.0)
SPRING = sw.Oscillator(1.0, 0.0, sw.Cubic(1.0, 0.0), sw.Harmonic(0.0), 1.0)  # of the type of DUFFING: compiled once
BACKLASH = sw.Oscillator(1.0, 0.1, sw.Backlash(1.0, 0.5), sw.Harmonic(0.6), 0.8)


def by_scipy(system, y0, t, method="DOP853", rtol=1e-13, atol=1e-14):
    """The same system by SciPy, at the times t."""

    def rhs(time, y):
        return system.rhs(system.omega * time, (y[0], y[1]))

    solution = solve_ivp(rhs, (t[0], t[-1]), y0, method=method, t_eval=t, rtol=rtol, atol=atol)
    assert solution.success
    return solution.y


def damped_forced(system, x0, v0, t):
    """Closed form of J x'' + B x' + K x = A cos(omega t) from (x0, v0)."""
    J, B, K, A, w = system.J, system.B, system.law.K, system.excitation.amplitude, system.omega
    forced = A / (K - J * w * w + 1j * B * w)
    wd = math.sqrt(K / J - (B / (2 * J)) ** 2)
    x1 = x0 - forced.real
    v1 = v0 - (1j * w * forced).real
    decay = np.exp(-B / (2 * J) * t)
    free = decay * (x1 * np.cos(wd * t) + (v1 + B / (2 * J) * x1) / wd * np.sin(wd * t))
    return free + (forced * np.exp(1j * w * t)).real


def slope_of_errors(errors, factor=2.0):
    return np.log(np.array(errors[:-1]) / np.array(errors[1:])) / math.log(factor)


@pytest.mark.parametrize(
    ("method", "order", "steps"), [(sw.Rk4, 4, (20, 40, 80, 160)), (sw.Dop8, 8, (8, 12, 18, 27))], ids=["Rk4", "Dop8"]
)
def test_fixed_step_method_has_its_order(method, order, steps):
    period = 2.0 * math.pi
    exact = by_scipy(DUFFING, (1.5, 0.0), np.array([0.0, 2.0 * period]))[:, -1]
    errors = [
        np.max(
            np.abs(sw.simulate(DUFFING, (1.5, 0.0), 2.0 * period, method=method(steps_per_period=n)).y[:, -1] - exact)
        )
        for n in steps
    ]
    assert slope_of_errors(errors, steps[1] / steps[0]) == pytest.approx(order, abs=0.6)


def test_dense_output_of_dopri5_has_order_4():
    # One step of size h from the exact start: the interpolant of a fourth-order continuous extension errs by O(h^5).
    def inside(h):
        y, rate = (1.5, 0.2), DUFFING.rhs(0.0, (1.5, 0.2))
        y1, k1, _, dense = steps.dopri5_step(DUFFING, 0.0, h, y, h, rate)
        places = np.array([[0.25], [0.5], [0.75]])
        there = steps.weighted(steps.dense_weights(places, h), *map(np.array, (y, rate, y1, k1, dense)))
        exact = by_scipy(DUFFING, y, np.array([0.0, 0.25, 0.5, 0.75, 1.0]) * h)[:, 1:4].T
        return np.max(np.abs(there - exact))

    assert slope_of_errors([inside(h) for h in (0.8, 0.4, 0.2, 0.1)]) == pytest.approx(5.0, abs=0.6)


@pytest.mark.slow
@pytest.mark.parametrize("method", [sw.Dopri5(rtol=1e-11), sw.Rk4(steps=1024), sw.Dop8(steps=32)], ids=str)
def test_linear_oscillator_follows_its_closed_form(method):
    system = sw.Oscillator(2.0, 0.3, sw.Cubic(5.0, 0.0), sw.Harmonic(0.7), 1.3)
    t = np.linspace(0.0, 40.0, 200)
    run = sw.simulate(system, (0.4, -0.2), t, method=method)
    assert run.status
    np.testing.assert_allclose(run.y[0], damped_forced(system, 0.4, -0.2, t), rtol=0, atol=3e-10)


@pytest.mark.slow
def test_energy_is_kept_without_damping_and_forcing():
    system = SPRING._replace(law=sw.Cubic(1.0, 0.1))
    run = sw.simulate(system, (2.0, 0.0), 200.0, method=sw.Dopri5(rtol=1e-12, atol=1e-14))
    energy = run.y[1] ** 2 / 2.0 + system.law.energy(run.y[0])
    assert np.max(np.abs(energy / energy[0] - 1.0)) < 1e-9


@pytest.mark.slow
def test_work_of_forcing_and_damping_is_the_change_of_energy():
    t = np.linspace(0.0, 30.0, 6001)
    run = sw.simulate(DUFFING, (0.3, 0.1), t, method=sw.Dopri5(rtol=1e-12, atol=1e-14))
    x, v = run.y
    energy = v**2 / 2.0 + DUFFING.law.energy(x)
    power = (0.18 * np.cos(t) - 0.05 * v) * v
    work = np.trapezoid(power, t)
    assert energy[-1] - energy[0] == pytest.approx(work, abs=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("method", ["RK45", "DOP853"])
@pytest.mark.parametrize("system", [DUFFING, BACKLASH], ids=["Duffing", "backlash"])
def test_scipy_gives_the_same_solution(system, method):
    t = np.linspace(0.0, 30.0, 61)
    ours = sw.simulate(system, (0.2, 0.1), t, method=sw.Dopri5(rtol=1e-11))
    theirs = by_scipy(system, (0.2, 0.1), t, method=method, rtol=1e-11, atol=1e-13)
    np.testing.assert_allclose(ours.y, theirs, rtol=0, atol=3e-8)


@pytest.mark.slow
def test_sampled_times_and_recorded_steps_are_one_solution():
    steps = sw.simulate(DUFFING, (0.5, 0.0), 20.0)
    assert steps.t[0] == 0.0
    assert steps.t[-1] == 20.0
    assert np.all(np.diff(steps.t) > 0.0)
    sampled = sw.simulate(DUFFING, (0.5, 0.0), steps.t)
    np.testing.assert_allclose(sampled.y, steps.y, rtol=0, atol=1e-13)
    np.testing.assert_allclose(sampled.rate, steps.rate, rtol=0, atol=1e-13)
    assert (sampled.steps, sampled.rejected) == (steps.steps, steps.rejected)


@pytest.mark.slow
def test_rate_is_the_rhs_at_every_sample():
    run = sw.simulate(DUFFING, (0.5, 0.0), np.linspace(1.0, 9.0, 17))
    np.testing.assert_allclose(run.rate, DUFFING.rhs(run.t, tuple(run.y)), rtol=0, atol=1e-14)


@pytest.mark.slow
@pytest.mark.parametrize("method", [sw.Dopri5(), sw.Rk4(steps_per_period=50)], ids=["Dopri5", "Rk4"])
def test_pieces_of_any_size_give_one_solution(method, monkeypatch):
    whole = sw.simulate(DUFFING, (0.5, 0.0), 20.0, method=method)
    apart = sw.simulate(DUFFING, (0.5, 0.0), [0.0, 9.0, 20.0], method=method)
    monkeypatch.setattr(methods, "BUDGET", 7)
    monkeypatch.setattr(record, "FIRST_STEPS", 3)
    pieces = sw.simulate(DUFFING, (0.5, 0.0), 20.0, method=method)
    apart_in_pieces = sw.simulate(DUFFING, (0.5, 0.0), [0.0, 9.0, 20.0], method=method)
    np.testing.assert_allclose(pieces.y[:, -1], whole.y[:, -1], rtol=0, atol=1e-7)
    np.testing.assert_allclose(apart_in_pieces.y, apart.y, rtol=0, atol=1e-7)
    assert len(apart_in_pieces.t) == 3


@pytest.mark.slow
def test_peak_is_that_of_the_dense_solution():
    run = sw.simulate(DUFFING, (0.5, 0.0), 60.0)
    dense = sw.simulate(DUFFING, (0.5, 0.0), np.linspace(0.0, 60.0, 200_001))
    assert run.peak() == pytest.approx(np.max(np.abs(dense.y[0])), rel=1e-7)
    assert run.peak(after=30.0) == pytest.approx(np.max(np.abs(dense.y[0, dense.t >= 30.0])), rel=1e-7)
    assert run.peak(-1) == run.peak(1) != run.peak(-2) == run.peak()
    for component in (2, -3):
        with pytest.raises(ValueError, match=rf"component is {component}; it must be from -2 to 1, of 2 states"):
            run.peak(component)


def by_scipy_with_events(system, y0, t_end):
    """DOP853 restarted at every crossing, which SciPy locates by its own events: the last time and state."""

    def away(time, state, b):
        return system.torsion(system.omega * time, (state[0], state[1])) - b

    events = [partial(away, b=b) for b in system.breakpoints()]
    for event in events:
        event.terminal = True
    t, y = 0.0, np.array(y0)

    def rhs(time, state):
        return system.rhs(system.omega * time, (state[0], state[1]))

    while t < t_end:
        part = solve_ivp(rhs, (t, t_end), y, method="DOP853", rtol=1e-13, atol=1e-18, events=events)
        t, y = part.t[-1], part.y[:, -1]
        if part.status == 1:  # leave the breakpoint by one small step
            d = 1e-9 * t_end
            part = solve_ivp(rhs, (t, t + d), y, method="DOP853", rtol=1e-13, atol=1e-18)
            t, y = t + d, part.y[:, -1]
    return t, y


# A CSF-40-50 with kinematic error, its motor held at 150 rad/s.
CSF = sw.Oscillator(0.6, 9.8, CSF_40_50, sw.Harmonic(150.0), 150.0, sw.KinematicError((sw.Line(2, 1.1e-4),)))
PLAY = sw.Oscillator(1.3, 20.0, sw.Play(2e-4, CSF_40_50), sw.Harmonic(60.0, mean=15.0), 180.0)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("system", "y0"),
    [(BACKLASH, (1.5, 0.0)), (CSF, (3e-3, 0.0)), (PLAY, (3e-3, 0.0))],
    ids=["Backlash", "PiecewiseLinear", "Play"],
)
def test_dopri5_keeps_its_order_across_breakpoints(system, y0):
    tolerances = (1e-6, 1e-8, 1e-10, 1e-12)
    t, exact = by_scipy_with_events(system, y0, 12.0 / math.sqrt(system.law.stiffness(10.0) / system.J))
    steps = []
    for rtol in tolerances:
        run = sw.simulate(system, y0, t, method=sw.Dopri5(rtol=rtol, atol=1e-3 * rtol * y0[0]))
        assert abs(run.y[0, -1] - exact[0]) < 20.0 * rtol * y0[0]
        assert run.switches >= 4
        assert run.rejected < 3 * run.switches
        steps.append(run.steps)
    # With order 5, a tolerance of a hundredth costs 100^(1/5) = 2.5 times the steps.
    assert all(later < 3.0 * earlier for earlier, later in pairwise(steps))


@pytest.mark.slow
def test_without_location_of_switches_the_order_is_lost():
    class Unlocated(NamedTuple):
        """The backlash oscillator without word of its breakpoints."""

        oscillator: sw.Oscillator
        omega: float

        def rhs(self, phase, y):
            return self.oscillator.rhs(phase, y)

    blind = Unlocated(BACKLASH, BACKLASH.omega)
    method = sw.Dopri5(rtol=1e-8, atol=1e-11)
    seeing, unseeing = (
        sw.simulate(BACKLASH, (1.5, 0.0), 30.0, method=method),
        sw.simulate(blind, (1.5, 0.0), 30.0, method=method),
    )
    exact = sw.simulate(BACKLASH, (1.5, 0.0), 30.0, method=sw.Dopri5(rtol=1e-13, atol=1e-15)).y[0, -1]
    assert unseeing.switches == 0
    assert abs(unseeing.y[0, -1] - exact) > 10.0 * abs(seeing.y[0, -1] - exact)
    assert unseeing.rejected > 4 * seeing.rejected


@pytest.mark.slow
def test_switches_lie_on_the_breakpoints():
    run = sw.simulate(BACKLASH, (1.5, 0.0), 30.0)
    on = np.min(np.abs(np.abs(run.y[0]) - 0.5)[:, None], axis=1)
    assert np.count_nonzero(on < 1e-12) == run.switches
    assert run.switches >= 4


@pytest.mark.slow
def test_start_on_a_breakpoint_at_rest_goes_where_the_force_points():
    inside = sw.simulate(BACKLASH._replace(excitation=sw.Harmonic(-0.6)), (0.5, 0.0), 0.5)
    assert inside.status
    # In the gap x'' + B x' = -A cos(omega t), from (b, 0).
    theirs = by_scipy(BACKLASH._replace(excitation=sw.Harmonic(-0.6)), (0.5, 0.0), np.array([0.0, 0.5]))
    assert inside.y[0, -1] == pytest.approx(theirs[0, -1], abs=1e-11)


@pytest.mark.slow
@pytest.mark.parametrize("method", [sw.Dopri5(), sw.Rk4(), sw.Dop8(), sw.Rk4(steps_per_period=100)], ids=str)
def test_softening_start_outside_the_well_diverges_with_finite_values(method):
    # The saddles are at x = 1/sqrt(|alpha|) = 1.
    system = DUFFING._replace(law=sw.Cubic(1.0, -1.0))
    run = sw.simulate(system, (3.0, 0.0), 1e4, method=method)
    assert run.status is sw.Status.DIVERGED
    assert "stopped at t = 0." in run.message
    assert np.all(np.isfinite([*run.y, *run.rate]))
    assert math.isfinite(run.peak())
    assert sw.simulate(system, (0.3, 0.0), 50.0, method=method).status


@pytest.mark.slow
def test_resonance_without_damping_grows_linearly():
    # x'' + x = A cos t from rest: x = (A/2) t sin t.
    t = np.linspace(0.0, 2000.0, 501)
    run = sw.simulate(SPRING._replace(excitation=sw.Harmonic(0.2)), (0.0, 0.0), t)
    assert run.status
    np.testing.assert_allclose(run.y[0], 0.1 * t * np.sin(t), rtol=0, atol=1e-4)


@pytest.mark.slow
def test_step_limit_ends_with_what_is_done():
    run = sw.simulate(DUFFING, (0.5, 0.0), 1e6, method=sw.Dopri5(max_steps=1000))
    assert run.status is sw.Status.TOO_MANY_STEPS
    assert run.steps + run.rejected == 1000
    assert run.steps == len(run.t) - 1
    assert f"stopped at t = {run.t[-1]:.6g} s" in run.message
    exactly = sw.simulate(DUFFING, (0.5, 0.0), run.t[-1])
    enough = sw.Dopri5(max_steps=exactly.steps + exactly.rejected)
    assert sw.simulate(DUFFING, (0.5, 0.0), run.t[-1], method=enough).status


@pytest.mark.slow
@pytest.mark.parametrize("method", [sw.Dopri5(), sw.Dop8(steps_per_period=20)], ids=["Dopri5", "Dop8"])
@pytest.mark.parametrize("t", [500.0, np.linspace(0.0, 500.0, 2001)], ids=["every step", "samples"])
def test_interrupt_keeps_what_is_finished(method, t, monkeypatch):
    calls = []

    def interrupted(kernel, *args):
        calls.append(kernel)
        if len(calls) == 4:
            raise KeyboardInterrupt
        return run(kernel, *args)

    run = methods.run
    monkeypatch.setattr(methods, "BUDGET", 300)
    monkeypatch.setattr(methods, "run", interrupted)
    part = sw.simulate(DUFFING, (0.5, 0.0), t, method=method)
    monkeypatch.setattr(methods, "run", run)
    assert part.status is sw.Status.INTERRUPTED
    assert "what was finished is kept" in part.message
    whole = sw.simulate(DUFFING, (0.5, 0.0), t, method=method)
    assert 100 < len(part.t) < len(whole.t)
    np.testing.assert_allclose(part.y, whole.y[:, : len(part.t)], rtol=0, atol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("method", [sw.Dopri5(), sw.Dop8(steps_per_period=20)], ids=["Dopri5", "Dop8"])
def test_long_run_logs_its_progress_once_a_second(method, monkeypatch, caplog):
    seconds = iter(np.arange(0.0, 1000.0, 0.3))
    monkeypatch.setattr(record, "monotonic", lambda: next(seconds))
    monkeypatch.setattr(methods, "BUDGET", 20)
    with caplog.at_level(logging.INFO, "strainwave"):
        run = sw.simulate(DUFFING, (0.5, 0.0), 200.0, method=method)
    pieces = (run.steps + run.rejected) / 20
    assert pieces / 5 < len(caplog.messages) < pieces / 2
    assert all(message.startswith("t = ") and "of 200 s" in message for message in caplog.messages)


@pytest.mark.slow
def test_quick_run_logs_nothing(caplog):
    with caplog.at_level(logging.INFO, "strainwave"):
        sw.simulate(DUFFING, (0.5, 0.0), 20.0)
    assert caplog.messages == []


@pytest.mark.slow
def test_large_start_time_changes_only_the_phase():
    # 1e6 periods later the forcing is the same but for the rounding of the phase, 1e6 * 2 pi * 1e-16.
    later = 1e6 * 2.0 * math.pi
    early = sw.simulate(DUFFING, (0.5, 0.0), 50.0).y[:, -1]
    late = sw.simulate(DUFFING, (0.5, 0.0), (later, later + 50.0)).y[:, -1]
    np.testing.assert_allclose(late, early, rtol=0, atol=1e-7)


@pytest.mark.slow
def test_constant_and_reversed_base_angle_are_allowed():
    still = sw.simulate(DUFFING._replace(omega=0.0), (0.0, 0.0), 400.0)
    x = still.y[0, -1]
    assert DUFFING.law.torque(x) == pytest.approx(0.18, abs=1e-4)
    forward, backward = (sw.simulate(DUFFING._replace(omega=w), (0.1, 0.0), 20.0) for w in (1.0, -1.0))
    np.testing.assert_allclose(backward.y[:, -1], forward.y[:, -1], rtol=0, atol=1e-12)  # cos is even
    assert sw.simulate(DUFFING._replace(omega=-1.0), (0.1, 0.0), 20.0, method=sw.Rk4()).status


@pytest.mark.slow
def test_default_steps_of_fixed_methods_resolve_a_fast_spring_under_slow_forcing():
    # The article's first case: omega_0/omega = 37, 32 steps per forcing period would diverge.
    system = DUFFING._replace(law=sw.Cubic(37.0**2, 0.1), excitation=sw.Harmonic(100.0))
    t = np.linspace(0.0, 10.0, 201)
    exact = sw.simulate(system, (0.0, 0.0), t, method=sw.Dopri5(rtol=1e-12)).y[0]
    for method in (sw.Rk4(), sw.Dop8()):
        error = np.max(np.abs(sw.simulate(system, (0.0, 0.0), t, method=method).y[0] - exact))
        assert error < 1e-3 * np.max(np.abs(exact))
    assert sw.simulate(system, (0.0, 0.0), 10.0, method=sw.Rk4(steps_per_period=32)).status is sw.Status.DIVERGED


@pytest.mark.parametrize(
    ("y0", "t", "sentence"),
    [
        ((math.nan, 0.0), 1.0, r"y0 must be a finite state, for an Oscillator \(x, x'\), not \(nan, 0\.0\)"),
        ([[0.0, 0.0]], 1.0, "y0 must be a finite state"),
        ((), 1.0, "y0 must be a finite state"),
        ((0.0,), 1.0, "y0 has 1 states but Oscillator has 2: x, x'; give each one"),
        ((0.0, 0.0, 0.0), 1.0, "y0 has 3 states but Oscillator has 2: x, x'; give each one"),
        ((1e200, 0.0), 1.0, "start closer to equilibrium"),
        ((0.0, 0.0), 0.0, "t must be an end time or finite increasing times, not 0.0"),
        ((0.0, 0.0), -1.0, "t must be an end time"),
        ((0.0, 0.0), math.inf, "t must be an end time"),
        ((0.0, 0.0), (1.0, 0.5), "t must be an end time"),
        ((0.0, 0.0), [0.0, 1.0, 1.0], "t must be an end time"),
        ((0.0, 0.0), [[0.0, 1.0]], "t must be an end time"),
        ((0.0, 0.0), [], "t must be an end time"),
        ((0.0, 0.0), (1e17, 1e17 + 100.0), "too far from 0"),
        ((0.0, 0.0), 1e300, "stay within"),
    ],
)
def test_bad_start_or_time_is_refused_in_one_sentence(y0, t, sentence):
    with pytest.raises(ValueError, match=sentence) as error:
        sw.simulate(DUFFING, y0, t)
    assert "\n" not in str(error.value)


class Silent(NamedTuple):
    """A user's system without a Jacobian."""

    k: float

    def rhs(self, _, y):
        return (-self.k * y[0],)


def test_what_is_no_system_or_no_method_is_refused():
    with pytest.raises(TypeError, match=r"Drive has no rhs; drive\.error_equation"):
        sw.simulate(sw.HDC_40_050, (0.0, 0.0), 1.0)
    with pytest.raises(TypeError, match="Silent has no jacobian to choose a step from; give steps_per_period"):
        sw.simulate(Silent(1.0), (1.0,), 1.0, method=sw.Rk4())
    with pytest.raises(ValueError, match="with omega = 0 there is no period"):
        sw.simulate(DUFFING._replace(omega=0.0), (0.0, 0.0), 1.0, method=sw.Rk4(steps_per_period=10))


def test_system_of_one_state_and_no_speed_decays_exponentially():
    run = sw.simulate(Silent(2.0), 1.0, 1.0, method=sw.Dopri5(rtol=1e-8))
    assert run.y[0, -1] == pytest.approx(math.exp(-2.0), abs=1e-7)
    fixed = sw.simulate(Silent(2.0), 1.0, 1.0, method=sw.Rk4(steps_per_period=200))
    assert fixed.y[0, -1] == pytest.approx(math.exp(-2.0), abs=1e-6)


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: sw.Dopri5(rtol=0.0), "it needs 1e-14 <= rtol < 1, atol > 0"),
        (lambda: sw.Dopri5(rtol=math.nan), r"Dopri5\.rtol is nan; it must be a finite number"),
        (lambda: sw.Dopri5(max_steps=math.nan), r"Dopri5\.max_steps is nan; it must be a whole number"),
        (lambda: sw.Rk4(steps_per_period=math.inf), r"Rk4\.steps_per_period is inf; it must be a whole number"),
        (lambda: sw.Dopri5(atol=0.0), "it needs 1e-14 <= rtol < 1, atol > 0"),
        (lambda: sw.Dopri5(max_steps=0), r"Dopri5\.max_steps is 0"),
        (lambda: sw.Rk4(steps=0), r"Rk4\.steps is 0; it must be a whole number of at least 1"),
        (lambda: sw.Dop8(steps_per_period=-5), r"Dop8\.steps_per_period is -5"),
    ],
)
def test_method_with_impossible_settings_is_refused(make, sentence):
    with pytest.raises(ValueError, match=sentence):
        make()


def test_torsion_rate_sees_the_kinematic_error():
    system = DUFFING._replace(error=sw.KinematicError((sw.Line(2, 0.1),)), omega=3.0)
    w = workspace((0.2, 0.7))
    w[K] = system.rhs(1.2, (0.2, 0.7))
    rate = switches.torsion_rate(system, 3.0, 0.4, w, Y)
    assert rate == pytest.approx(0.7 - 3.0 * system.error.slope(1.2), rel=1e-7)


# A pulse of torque after a rest of 10 s, much longer than the period of 23 ms.
PULSE = sw.train.TorqueProfile((10.0, 10.01, 10.5, 10.51), (0.0, -100.0, -100.0, 0.0))
DRIVE = sw.Oscillator(1.3, 20.0, sw.Cubic(1e5, 6.8e4), PULSE, 1.0)


def from_corner_to_corner(t):
    """Error x (n,) of DRIVE at times by SciPy's DOP853, begun anew at every corner, and the largest |x|."""
    corners, torques = (0.0, 10.0, 10.01, 10.5, 10.51, 11.0), (0.0, 0.0, -100.0, -100.0, 0.0, 0.0)
    found, largest, y = np.zeros(len(t)), 0.0, np.zeros(2)
    for (a, b), (first, last) in zip(pairwise(corners), pairwise(torques), strict=True):

        def rhs(time, y, a=a, b=b, first=first, last=last):
            torque = first + (last - first) * (time - a) / (b - a)
            return y[1], (torque - 20.0 * y[1] - 1e5 * (y[0] + 6.8e4 * y[0] ** 3)) / 1.3

        part = solve_ivp(rhs, (a, b), y, method="DOP853", rtol=1e-11, atol=1e-16, dense_output=True)
        inside, y = (a <= t) & (t <= b), part.y[:, -1]
        if inside.any():
            found[inside] = part.sol(t[inside])[0]
        largest = max(largest, np.max(np.abs(part.sol(np.linspace(a, b, 5_001))[0])))
    return found, largest


@pytest.mark.parametrize("times", [11.0, [0.0, 5.0, 11.0], [0.0, 10.0, 10.01, 10.3, 10.51, 11.0]], ids=str)
def test_torque_that_begins_after_a_rest_is_met(times):
    run = sw.simulate(DRIVE, (0.0, 0.0), times)
    exact, largest = from_corner_to_corner(run.t)
    np.testing.assert_allclose(run.y[0], exact, rtol=0, atol=1e-7 * largest)
    assert run.peak() == pytest.approx(largest, rel=1e-6)
    assert run.t[-1] == 11.0
    assert np.all(np.diff(run.t) > 0.0)


@pytest.mark.parametrize("method", [sw.Rk4(steps=128), sw.Dop8(steps=24)], ids=["Rk4", "Dop8"])
def test_steps_of_fixed_length_end_at_corners_too(method):
    _, largest = from_corner_to_corner(np.array([0.0]))
    every, seldom = (sw.simulate(DRIVE, (0.0, 0.0), t, method=method) for t in ((9.9, 11.0), [9.9, 10.2, 11.0]))
    exact, _ = from_corner_to_corner(every.t)
    np.testing.assert_allclose(every.y[0], exact, rtol=0, atol=2e-5 * largest)
    assert every.peak() == pytest.approx(largest, rel=2e-5)
    assert seldom.peak() == pytest.approx(largest, rel=1e-4)
    np.testing.assert_allclose(seldom.y[0], from_corner_to_corner(seldom.t)[0], rtol=0, atol=2e-5 * largest)


def test_order_of_a_fixed_step_is_kept_across_a_jump_of_the_acceleration():
    # x'' = -x + s(t), s = 0 before t = 1 and 2 after it: x = 2 (1 - cos(t - 1)).
    class Step(NamedTuple):
        at: float

        def torque(self, t):
            return 1.0 + sw.maths.sign(t - self.at)

        def corners(self):
            return (self.at,)

    system = sw.Oscillator(1.0, 0.0, sw.Linear(1.0), Step(1.0), 1.0)
    errors = []
    for n in (40, 80, 160):
        run = sw.simulate(system, (0.0, 0.0), [0.0, 2.0, 4.0], method=sw.Rk4(steps_per_period=n))
        errors.append(abs(run.y[0, -1] - 2.0 * (1.0 - math.cos(3.0))))
    assert slope_of_errors(errors) == pytest.approx(4.0, abs=0.3)


class Knock(NamedTuple):
    """A user's own torque without corners: constant from `begin` to `end`, else 0."""

    amplitude: float
    begin: float
    end: float

    def torque(self, t):
        return 0.5 * self.amplitude * (sw.maths.sign(t - self.begin) - sw.maths.sign(t - self.end))


def test_knock_without_corners_is_met_from_rest():
    # shorter than a tenth of the period of 22.7 ms, in the middle of a long rest; B = 0: x = 2 F/K sin(w d/2) at most
    d, w = 2e-3, math.sqrt(1e5 / 1.3)
    for begin in (3.0, 7.12345):
        system = sw.Oscillator(1.3, 0.0, sw.Linear(1e5), Knock(100.0, begin, begin + d), 1.0)
        run = sw.simulate(system, (0.0, 0.0), [0.0, 1.0, begin + 0.1], method=sw.Dopri5(rtol=1e-8))
        assert run.peak() == pytest.approx(2e-3 * math.sin(0.5 * w * d), rel=1e-5)


class ListedKnock(NamedTuple):
    """The same torque with its corners."""

    knock: Knock

    def torque(self, t):
        return self.knock.torque(t)

    def corners(self):
        return (self.knock.begin, self.knock.end)


# Where x'' jumps between the second and the third stage of a step, the weights of Dormand and Prince make an error of
# WORST times the one that they estimate. Two jumps, each in a step that the tolerance just takes (its norm is the root
# mean square of two states), leave at most twice that.
WORST = 170.0


@pytest.mark.parametrize("rtol", [1e-9, 1e-11])
def test_largest_step_meets_what_is_shorter_than_all_scales(rtol):
    # nothing restores x'' = F: after the knock x' = F d
    atol, knock = 1e-3 * rtol, Knock(5.0, 6.0, 6.002)
    system = sw.Oscillator(1.0, 0.0, sw.Linear(0.0), knock, 1.0)
    method = sw.Dopri5(rtol=rtol, atol=atol, largest_step=1e-3)
    run = sw.simulate(system, (0.0, 0.0), 10.0, method=method)
    assert run.y[1, -1] == pytest.approx(0.01, abs=2.0 * WORST * math.sqrt(2.0) * (atol + rtol * 0.01), rel=0.0)
    assert np.max(np.diff(run.t)) <= 1e-3 * (1.0 + 1e-9)
    listed = sw.simulate(system._replace(excitation=ListedKnock(knock)), (0.0, 0.0), 10.0, method=method)
    assert listed.y[1, -1] == pytest.approx(0.01, rel=1e-12)  # all of that error is made by steps across a jump


@pytest.mark.parametrize("count", [9, 41])
def test_peak_is_that_of_the_motion_however_few_the_samples(count):
    # from (1, 0) the free vibration decays; forcing off its resonance adds little, so that the largest |x| is the start
    system = sw.Oscillator(1.0, 0.02, sw.Cubic(1.0, 0.05), sw.Harmonic(0.02), 1.7)
    t = np.linspace(0.0, 400.0, 20_001)
    run = sw.simulate(system, (1.0, 0.0), t[:: 20_000 // (count - 1)], method=sw.Dopri5(rtol=1e-7))
    exact = by_scipy(system, (1.0, 0.0), t, rtol=1e-8, atol=1e-11)
    assert run.peak() == pytest.approx(np.max(np.abs(exact[0])), rel=1e-6)
    assert run.peak(1) == pytest.approx(np.max(np.abs(exact[1])), rel=1e-4)
    after = run.t[2]
    assert run.peak(after=after) == pytest.approx(np.max(np.abs(exact[0, t >= after])), rel=1e-4)


@pytest.mark.parametrize("method", [sw.Rk4(steps_per_period=100), sw.Dop8(steps_per_period=40)], ids=["Rk4", "Dop8"])
def test_peak_of_fixed_steps_lies_between_samples_too(method):
    # x = cos t, sampled where it is 0
    run = sw.simulate(SPRING, (1.0, 0.0), np.pi * np.array([0.0, 1.5, 2.5, 3.5]), method=method)
    assert run.peak(after=0.1) == pytest.approx(1.0, rel=1e-5)


def test_corners_that_are_no_angles_are_refused():
    class Odd(NamedTuple):
        at: float

        def torque(self, t):
            return 0.0 * t

        def corners(self):
            return (self.at, math.nan)

    with pytest.raises(ValueError, match=r"Odd\.corners\(\) gives .*; it must give a tuple of finite base angles"):
        sw.simulate(DRIVE._replace(excitation=Odd(1.0)), (0.0, 0.0), 1.0)
    with pytest.raises(ValueError, match=r"Dopri5\.largest_step \[s\] is 0; it must be a positive finite number"):
        sw.Dopri5(largest_step=0)


def test_profile_is_refused_where_motions_must_repeat():
    ripply = sw.gears.VaryingOscillator(1.3, sw.gears.GearDamping(20.0), sw.Cubic(1e5, 6.8e4), PULSE, 1.0)
    for verb, ask in (
        ("find_orbit", lambda: sw.find_orbit(DRIVE)),
        ("shoot", lambda: sw.numerics.shoot(DRIVE, (0.0, 0.0))),
        ("frequency_response", lambda: sw.frequency_response(DRIVE, (1.0, 2.0))),
        ("parameter_response", lambda: sw.numerics.parameter_response(DRIVE, "B", (10.0, 20.0))),
        ("ensemble", lambda: sw.ensemble(DRIVE, {"B": [10.0, 20.0]}, (0.0, 0.0), periods=1)),
        ("response_family", lambda: sw.numerics.response_family(DRIVE, (1.0, 2.0), {"B": [10.0, 20.0]})),
        ("isolas", lambda: sw.isolas(DRIVE, (1.0, 2.0))),
        ("slow_flow", lambda: sw.slow_flow(DRIVE, sw.PRIMARY)),
        ("lyapunov", lambda: sw.lyapunov(DRIVE)),
        ("error_parts", lambda: sw.study.error_parts(DRIVE)),
        ("parametric_resonances", lambda: sw.study.parametric_resonances(ripply, (1.0, 2.0))),
    ):
        with pytest.raises(ValueError, match=f"does not repeat; {verb} takes what repeats with every turn"):
            ask()
