"""Basins: a published fraction, another integrator on the same states, attractors as orbits, chaos, escape."""

from typing import NamedTuple

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import strainwave as sw
from strainwave.numerics.attractors import settle
from strainwave.numerics.attractors.basins import CHAOTIC, DIVERGED, UNSETTLED
from strainwave.numerics.attractors.settle import Bounded, stretching

TWO_WELLS = sw.Oscillator(1.0, 0.15, sw.Cubic(-1.0, -1.0), sw.Harmonic(0.2), 1.0)
LINEAR = sw.Cubic(2.0, 0.0)  # of a class that other tests compile
BOX = ((-2.2, 2.2), (-2.2, 2.2))


@pytest.mark.slow
def test_two_wells_have_the_published_fractions():
    """Attractors.jl, test/mapping/attractor_mapping.jl, "Duffing oscillator: stroboscopic map".

    Its fractions of 0.489 for the attractor through (-0.8, 0) and 0.511 for that through (1.8, 0) are those of 1000
    random states, known to a standard error of 0.016; ours, of 20 000, to 0.0035.
    """
    found = sw.basins(TWO_WELLS, *BOX, samples=20_000, seed=4)
    left, right = sorted(found.attractors, key=lambda a: a.points[0, 0])
    assert left.points[0, 0] == pytest.approx(-0.779, abs=1e-3)
    assert right.points[0, 0] == pytest.approx(1.210, abs=1e-3)
    fractions = [found.fractions[found.attractors.index(a)] for a in (left, right)]
    error = np.hypot(np.sqrt(0.489 * 0.511 / 1000), found.standard_errors[0])
    assert abs(fractions[0] - 0.489) < 2.0 * error
    assert np.sum(found.fractions) == 1.0


@pytest.mark.slow
def test_states_that_settle_fast_end_where_another_integrator_says():
    found = sw.basins(TWO_WELLS, *BOX, samples=60, seed=1)
    compared = 0
    for x, v, label in zip(found.x, found.v, found.label, strict=True):
        run = solve_ivp(
            lambda t, y: (y[1], -0.15 * y[1] + y[0] - y[0] ** 3 + 0.2 * np.cos(t)),
            (0.0, 60.0 * np.pi),
            (x, v),
            method="DOP853",
            rtol=1e-10,
            atol=1e-12,
            t_eval=2.0 * np.pi * np.arange(20, 31),
        )
        near = [np.all(np.abs(run.y.T - a.points[0]) < 0.2, axis=None) for a in found.attractors]
        if any(near):  # others hop between the wells for long, so that any rounding decides where they end
            compared += 1
            assert near.index(True) == label
    assert compared > 25


@pytest.mark.slow
def test_attractors_are_orbits_with_their_multipliers():
    found = sw.basins(TWO_WELLS, *BOX, resolution=12)
    assert len(found.attractors) == 2
    for attractor in found.attractors:
        assert (attractor.period, attractor.stable) == (1, True)
        # complex multipliers of modulus exp(-B/(2J) T)
        assert attractor.multiplier == pytest.approx(np.exp(-0.075 * 2.0 * np.pi), rel=1e-6)
        run = sw.simulate(TWO_WELLS, attractor.points[0], (0.0, 2.0 * np.pi))
        np.testing.assert_allclose(run.y[:, -1], attractor.points[0], atol=1e-7)
        assert run.peak() == pytest.approx(attractor.peak, rel=1e-5)
        assert f"{attractor.amplitude:.5g}" in str(found)


@pytest.mark.slow
def test_a_subharmonic_attractor_has_its_period():
    """Nayfeh & Mook 4.1.4: beside the trivial orbit a stable one of three turns, which is one attractor, not three."""
    system = sw.Oscillator(1.0, 0.05, sw.Cubic(1.0, 0.2), sw.Harmonic(6.0), 4.0)
    isola = sw.isolas(system, (3.5, 4.5))[0]
    here = system._replace(omega=float(np.mean([np.min(isola.omega), np.max(isola.omega)])))
    found = sw.basins(here, (-4.0, 4.0), (-8.0, 8.0), resolution=16, settle=300)
    assert sorted(a.period for a in found.attractors) == [1, 3]
    assert all(a.stable for a in found.attractors)
    assert np.sum(found.fractions) == 1.0


@pytest.mark.slow
def test_chaos_and_escape_are_counted_as_such():
    ueda = sw.Oscillator(1.0, 0.05, sw.Polynomial((0.0, 0.0, 0.0, 1.0)), sw.Harmonic(7.5), 1.0)
    chaos = sw.basins(ueda, (-1.0, 1.0), (-1.0, 1.0), resolution=4, settle=50, longest=200)
    assert set(chaos.label) == {CHAOTIC}
    assert chaos.attractors == ()
    assert "chaotic" in str(chaos)
    soft = sw.Oscillator(1.0, 0.2, sw.Cubic(1.0, -1.0), sw.Harmonic(0.05), 0.5)
    escape = sw.basins(soft, (-3.0, 3.0), (-0.1, 0.1), resolution=(6, 1))
    assert escape.label.tolist() == [DIVERGED, DIVERGED, 0, 0, DIVERGED, DIVERGED]
    assert escape.share(DIVERGED)[0] == pytest.approx(2.0 / 3.0)


class Lorenz(NamedTuple):
    """Three states, no jacobian, no base frequency."""

    sigma: float
    rho: float
    beta: float

    def rhs(self, phase, y):
        a, b, c = y
        return self.sigma * (b - a), a * (self.rho - c) - b, a * b - self.beta * c


@pytest.mark.slow
def test_neighbours_drift_apart_at_the_known_rates():
    """-B/(2J) of a linear oscillator; 0.905630 of Lorenz's system (Viswanath 1998, thesis, Cornell)."""
    linear = sw.Oscillator(2.0, 0.3, sw.Linear(5.0), sw.Harmonic(1.0), 1.3)
    assert np.mean(stretching(linear, np.array([[0.1], [0.0]]))) == pytest.approx(-0.075, abs=1e-4)
    starts = np.array([[1.0], [1.0], [20.0]]) + np.random.default_rng(0).normal(size=(3, 64))
    means = np.mean(stretching(Lorenz(10.0, 28.0, 8.0 / 3.0), starts), axis=0)
    error = np.std(means, ddof=1) / 8.0
    assert error < 0.002
    assert abs(np.mean(means) - 0.90563) < 3.0 * error


def test_turns_that_take_minutes_are_refused_before_they_are_marched(monkeypatch):
    monkeypatch.setattr(settle, "MOST_STRETCHED", 10)
    system = sw.Oscillator(1.0, 0.05, sw.Cubic(1.0, 0.1), sw.Harmonic(0.5), 1.2)
    with pytest.raises(sw.SolveError, match=r"110 turns of [0-9]+ steps, .* are too many: at most 10 steps a turn; "):
        stretching(system, np.array([[0.1], [0.0]]))


@pytest.mark.slow
def test_a_bound_ends_a_trajectory_that_yields_on_its_way_out_and_changes_no_other():
    law = sw.Parallel(sw.Cubic(1.0, -1.0), sw.BoucWen(K=0.2, ratio=0.0, yield_twist=0.01))
    soft = sw.Oscillator(1.0, 0.2, law, sw.Harmonic(0.05), 0.5)
    start, method = (np.array([3.0, 0.1]), np.zeros(2), np.zeros(2)), sw.Dopri5(rtol=1e-5, max_steps=20_000)
    free, bounded = [
        sw.ensemble(system, {}, start, periods=2, measures=(sw.numerics.Extremes(),), method=method, threads=1)
        for system in (soft, Bounded(soft, 10.0))
    ]
    assert free["status"].values.tolist() == [2, 0]
    assert bounded["status"].values.tolist() == [1, 0]
    assert float(bounded["highest"][1]) == float(free["highest"][1]) < 0.2


@pytest.mark.slow
def test_a_slow_transient_is_counted_as_not_settled():
    light = sw.Oscillator(1.0, 1e-6, LINEAR, sw.Harmonic(1.0), 1.0)
    found = sw.basins(light, (-1.0, 1.0), (-1.0, 1.0), resolution=2, settle=10, longest=30)
    assert set(found.label) == {UNSETTLED}
    assert float(found.dataset()["label"].max()) == UNSETTLED


@pytest.mark.slow
def test_a_sample_is_reproducible_and_its_dataset_complete():
    damped = sw.Oscillator(1.0, 0.5, LINEAR, sw.Harmonic(1.0), 1.0)
    one, two = (sw.basins(damped, (-1.0, 1.0), (-1.0, 1.0), samples=20, seed=5) for _ in range(2))
    assert np.array_equal(one.x, two.x)
    data = one.dataset()
    assert data["fraction"].values.tolist() == [1.0]
    assert data["label"].dims == ("lane",)
    # x = cos(t - p)/|2 - 1 + 0.5i|
    assert float(data["peak"][0]) == pytest.approx(1.0 / abs(1.0 + 0.5j), rel=1e-6)


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"x_span": (1.0, -1.0)}, "low < high"),
        ({"x_span": (-1e308, 1e308)}, r"x_span is -1e\+308 .. 1e\+308; its ends must be from 1e-60 to 1e\+60"),
        ({"resolution": 0}, "resolution is 0"),
        ({"resolution": 9999}, "at most 4000000"),
        ({"resolution": (3, 4, 5)}, "one number of cells"),
        ({"resolution": 5, "samples": 5}, "give one of them"),
        ({"samples": -1}, "samples is -1"),
        ({"samples": 5, "seed": -1}, "seed is -1"),
        ({"settle": 0}, "settle is 0"),
        ({"longest": 3}, "at least settle"),
    ],
)
def test_bad_input_is_one_sentence(change, sentence):
    arguments = {"system": TWO_WELLS, "x_span": BOX[0], "v_span": BOX[1]} | change
    with pytest.raises((ValueError, TypeError), match=sentence):
        sw.basins(arguments.pop("system"), arguments.pop("x_span"), arguments.pop("v_span"), **arguments)
