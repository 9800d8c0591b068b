"""Crests of a curve of orbits: the largest |x| and |x - mean| among their neighbours."""

import math
from itertools import cycle

import numpy as np
import pytest

import strainwave as sw
from strainwave.base.branch_labels import FOLD, RUNNING, STEP, TOP
from strainwave.base.series import highest_between, largest_size
from strainwave.compile.tree import leaf_of
from strainwave.drive.train_curve import PEAK_POINTS, at_load
from strainwave.numerics.balance.choice import balance_of
from strainwave.numerics.continuation import trace
from strainwave.numerics.continuation.trace import put_in_order, series_of, solve, with_crests
from strainwave.numerics.curves import response
from strainwave.numerics.curves.over_a_turn import traced_turn


def test_the_crests_of_x_and_of_its_oscillation_at_one_speed_are_one_point():
    ratio = 0.05  # under a constant torque as well: both crests of a linear drive are at sqrt(1 - 2 ratio^2)
    linear = sw.Oscillator(1.0, 2.0 * ratio, sw.Linear(1.0), sw.Harmonic(0.1, mean=0.3), 1.0)
    leaf = leaf_of(linear, "omega")
    problem = balance_of(linear, leaf, leaf, 3)
    speeds = np.linspace(0.97, 1.03, 8)
    points = np.array([solve(problem, problem.linear_response(w)) for w in speeds])
    found, labels, _ = with_crests(problem, points, np.full(len(points), STEP))
    assert len(found) == len(points) + 1
    assert found[labels == TOP, -1] == pytest.approx([math.sqrt(1.0 - 2.0 * ratio**2)], abs=1e-6)


@pytest.mark.parametrize("close", [[], [0.99505]])
def test_a_crest_beside_a_short_step_or_far_from_the_polynomial_is_found(close):
    # the phase turns by most of pi between the points, so that a polynomial through five is far from the motions
    ratio = 0.05
    linear = sw.Oscillator(1.0, 2.0 * ratio, sw.Linear(1.0), sw.Harmonic(0.1), 1.0)
    leaf = leaf_of(linear, "omega")
    problem = balance_of(linear, leaf, leaf, 3)
    speeds = sorted([0.86, 0.93, 0.995, 1.06, 1.13, *close])
    points = np.array([solve(problem, problem.linear_response(w)) for w in speeds])
    found, labels, _ = with_crests(problem, points, np.full(len(points), STEP))
    sizes = largest_size(series_of(problem, found[labels == TOP]))
    assert sizes == pytest.approx([0.1 / (2.0 * ratio * math.sqrt(1.0 - ratio**2))], rel=1e-10)


def test_a_fold_listed_after_the_step_that_passed_it_comes_before_it_whatever_the_units():
    arc = np.array([-1.2, 0.3, 0.0, 1.0])  # of a small motion at a high speed, with the fold at 0
    points = np.column_stack([5e-4 * (1.0 + 0.05 * arc), 2e-5 * arc, 101.0 * (1.0 - 1.7e-3 * arc**2)])
    labels, wanted = np.array([STEP, STEP, FOLD, STEP]), points[[0, 2, 1, 3]]
    put_in_order(points, labels)
    assert labels.tolist() == [STEP, FOLD, STEP, STEP]
    assert points == pytest.approx(wanted, rel=1e-12)


def test_a_crest_is_not_refined_beyond_the_digits_of_its_size(monkeypatch):
    # a polynomial through points that rounding cannot tell apart has no digits left: its crest is anywhere
    def noisy(*given):
        place, size = highest_between(*given)
        return place + next(off), size * (1.0 + 1e-10)

    def solved(problem, guess):
        point = solve(problem, guess)
        sizes.append(float(largest_size(series_of(problem, point[None]))[0]))
        return point

    off = cycle((3e-7, -3e-7, 6e-7, -6e-7, 9e-7, -9e-7))
    control = sw.train.Lagged(sw.train.CascadeLoop(13.0, 0.09, 0.0146), 5e-4)
    error, load = sw.KinematicError((sw.Line(2, 1.1e-4),)), sw.Harmonics((sw.Harmonic(0.0, mean=-38.8),))
    drive = sw.Drive(4.5e-4, 0.65, 50.0, 11.4, sw.Cubic(3e4, 1e4))
    train = drive.train(control=control, load_torque=load, kinematic_error=error, omega=150.0)
    problem, found, _, _ = traced_turn(at_load(train), (50.0, 310.0), PEAK_POINTS, 16, False)
    series = series_of(problem, found.points)
    values = largest_size(series)
    monkeypatch.setattr(trace, "highest_between", noisy)
    monkeypatch.setattr(trace, "solve", solved)
    for i in trace.crests_of(values):
        sizes = []
        trace._crest(problem, found.points, i, series, values, largest_size)
        assert np.all(np.abs(np.diff(sizes[:-1])) > 1e-12 * values[i]), sizes


def test_of_more_crests_than_a_curve_has_the_highest_count():
    values = 1.0 + 0.1 * np.sin(0.01 * np.arange(3001)) + 0.002 * (np.arange(3001) % 2)
    places = trace.crests_of(values)
    assert places == sorted(places)
    assert len(places) == 200
    others = np.setdiff1d(np.arange(1, 3001, 2), places)  # each second value is a crest
    assert len(others) == 1300
    assert np.min(values[places]) > np.max(values[others])


def test_a_curve_that_is_cut_is_not_followed_again_with_more_harmonics(monkeypatch):
    asked = []

    def problem_with(harmonics):
        asked.append(harmonics)
        system = sw.Oscillator(1.0, 0.05, sw.Cubic(1.0, 0.1), sw.Harmonic(0.5), 1.2)
        return balance_of(system, leaf_of(system, "omega"), leaf_of(system, "omega"), harmonics)

    def across(problem, *_):
        return problem, trace.Trace(np.ones((5, problem.size() + 1)), np.full(5, STEP), RUNNING), ""

    monkeypatch.setattr(response, "symmetric_across", across)
    found = response.traced(problem_with, 0.9, 1.8, (7, 127), 1e-9, 100, False, lambda tail: tail.worst)[1]
    assert found.is_cut
    assert asked == [7]
