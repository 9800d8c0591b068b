"""What a run-up and a run-down do: jump frequencies, landings, and a simulated sweep beside them."""

import math
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import strainwave as sw

pytestmark = pytest.mark.slow

HARDENING = sw.Oscillator(1.0, 0.05, sw.Cubic(1.0, 0.1), sw.Harmonic(0.18), 1.0)  # NLvib example 01


@pytest.fixture(scope="module")
def branch():
    return sw.frequency_response(HARDENING, (0.5, 1.6))


def test_a_hardening_drive_drops_late_on_the_way_up_and_rises_early_on_the_way_down(branch):
    told = sw.jumps(branch)
    high, low = (f.omega for f in branch.folds)  # T1: 1.269602 and 1.115700
    assert told.jump_down == high == pytest.approx(1.269602, abs=0.5e-6)
    assert told.jump_up == low == pytest.approx(1.115700, abs=0.5e-6)
    assert told.width == high - low
    assert told.finished_up
    assert told.finished_down
    assert [j.cause for j in (*told.on_run_up, *told.on_run_down)] == ["fold", "fold"]
    assert "run-up" in told.sentence
    assert "Hysteresis 0.1539" in told.sentence


def test_the_sweeps_visit_stable_orbits_in_the_order_of_frequency(branch):
    told = sw.jumps(branch)
    assert np.all(np.diff(branch.omega[told.run_up]) > 0.0)
    assert np.all(np.diff(branch.omega[told.run_down]) < 0.0)
    folds = {f.omega for f in branch.folds}
    for run in (told.run_up, told.run_down):
        assert all(branch.stable[i] or branch.omega[i] in folds for i in run)


def test_a_softening_drive_jumps_the_other_way_round():
    system = HARDENING._replace(law=sw.Cubic(1.0, -0.05), excitation=sw.Harmonic(0.1))
    told = sw.jumps(sw.frequency_response(system, (0.4, 1.6)))
    assert told.on_run_up[0].after > told.on_run_up[0].before
    assert told.on_run_down[0].after < told.on_run_down[0].before
    assert told.jump_down < told.jump_up


def test_a_linear_drive_does_not_jump():
    told = sw.jumps(sw.frequency_response(HARDENING._replace(law=sw.Cubic(1.0, 0.0)), (0.5, 1.6)))
    assert math.isnan(told.jump_up)
    assert told.width == 0.0
    assert "without a jump" in told.sentence
    assert "No bistable range" in told.sentence


@pytest.mark.parametrize("twice", [0, 3, 6])
def test_a_point_listed_twice_neither_ends_a_sweep_nor_makes_it_jump(twice):
    values = np.insert(np.linspace(1.0, 2.0, 7), twice, np.linspace(1.0, 2.0, 7)[twice])
    peak, nothing = 0.1 + 0.1 * values, []
    told = sw.jumps(
        SimpleNamespace(
            parameter="omega", values=values, peak=peak, stable=np.ones(8, bool), multipliers=np.empty((8, 0)),
            folds=nothing, doublings=nothing, branch_points=nothing, closed=False, span=(values.min(), values.max()),
        )
    )  # fmt: skip
    assert told.finished_up
    assert told.finished_down
    assert not told.on_run_up
    assert not told.on_run_down
    assert {*values[told.run_up].tolist()} == {*values[told.run_down].tolist()} == {*values.tolist()}


def test_a_sweep_of_the_amplitude_jumps_at_its_folds():
    sweep = sw.numerics.parameter_response(HARDENING._replace(omega=1.2), "excitation.amplitude", (0.0, 0.5))
    told = sw.jumps(sweep)
    assert told.parameter == "excitation.amplitude"
    assert told.jump_up == max(f.value for f in sweep.folds)
    assert told.jump_down == min(f.value for f in sweep.folds)


@pytest.mark.slow
@pytest.mark.parametrize("sign", [1, -1])
def test_a_simulated_sweep_jumps_where_it_is_told_to(branch, sign):
    told = sw.jumps(branch)
    at = told.jump_down if sign > 0 else told.jump_up
    run = told.run_up if sign > 0 else told.run_down
    speeds = at + sign * 0.004 * (np.arange(10) - 4.5)
    y, levels = np.zeros(2), []
    start = sw.find_orbit(HARDENING._replace(omega=float(speeds[0])), guess=_orbit(branch, run, speeds[0]))
    y = start.state(0.0)
    for omega in speeds:
        turn = 2.0 * math.pi / omega
        # 60 periods: the transient falls to exp(-60 pi B/omega) = 6e-4
        motion = sw.simulate(HARDENING._replace(omega=float(omega)), y, [0.0, 60 * turn, 61 * turn])
        levels.append(sw.simulate(HARDENING._replace(omega=float(omega)), motion.y[:, 1], turn).peak())
        y = motion.y[:, 1]  # whole turns: the phase goes on smoothly
    after = sign * branch.omega[run] > sign * at
    expected = [np.interp(omega, *sorted_curve(branch, run[after == (sign * omega > sign * at)])) for omega in speeds]
    # the fold itself is slow: leave out the points right after it
    use = np.array([0, 1, 2, 3, 7, 8, 9])
    np.testing.assert_allclose(np.array(levels)[use], np.array(expected)[use], rtol=0.05)


def sorted_curve(branch, run):
    order = np.argsort(branch.omega[run])
    return branch.omega[run][order], branch.peak[run][order]


def _orbit(branch, run, omega):
    i = run[np.argmin(np.abs(branch.omega[run] - omega))]
    return np.stack([branch.coefficients[i], 0.0 * branch.coefficients[i]], axis=1)


def test_a_sweep_starts_and_ends_at_the_ends_of_the_range_where_the_branch_goes_beyond_it():
    """Folds 1.2704388305 and 1.5863944025 (AUTO-07p): a range that ends between them has the run-down's jump alone."""
    duffing = sw.Oscillator(1.0, 0.1, sw.Cubic(1.0, 0.05), sw.Harmonic(1.0), 1.0)
    told = sw.jumps(sw.frequency_response(duffing, (0.25, 1.4), harmonics=7))
    assert [j.value for j in told.on_run_up] == []
    assert [j.value for j in told.on_run_down] == pytest.approx([1.2704388305], rel=1e-9)
    assert told.jump_up == pytest.approx(1.2704388305, rel=1e-9)
    assert "outside the range" in str(told)


@pytest.mark.slow
def test_a_sweep_goes_through_a_period_doubling_and_jumps_at_the_fold():
    law = sw.Polynomial((0.0, 1.0, -0.4309207001008153, 0.3))
    torque = sw.Harmonic(1.3513329439648971, 1, 0.0, 0.26952212508194395)
    system = sw.Oscillator(1.0, 0.06911691821306883, law, torque, 1.0)
    branch = sw.frequency_response(system, (0.92425, 3.38605))
    told = sw.jumps(branch)
    assert branch.doublings
    assert [j.cause for j in told.on_run_down] == ["fold"]
    assert "has twice the period" in " ".join(str(told).split())
    # a slow run-down by integration: small on both sides of the doubling, large beyond the fold alone
    y, peaks = (-0.5, 0.0), {}
    for omega in (2.1, 2.0, 1.95, 1.91, 1.88, 1.8, 1.7, 1.6, 1.5, 0.99 * told.on_run_down[0].value):
        here, turn = system._replace(omega=omega), 2.0 * math.pi / omega
        y = sw.simulate(here, y, [0.0, 80 * turn]).y[:, -1]
        peaks[omega] = sw.simulate(here, y, 2 * turn).peak()
    *before, after = peaks.values()
    assert max(before) < 2.0 < 3.0 < after


TWO_LINES = sw.Oscillator(
    1.0, 0.05, sw.Cubic(1.0, 0.3), sw.Harmonic(0.0), 1.0, sw.KinematicError((sw.Line(1, 0.04), sw.Line(2, 0.0405)))
)


def test_two_bands_have_each_their_own_pair_of_jumps():
    """Slow sweeps by RK4 in C drop at 0.54338(9) and 1.0851(2), and rise at 0.53155(9) and 1.0629(2)."""
    told = sw.jumps(sw.frequency_response(TWO_LINES, (0.4, 1.4)))
    first, second = told.bands
    assert (first.jump_up, second.jump_up) == pytest.approx((0.53155, 1.0629), rel=1e-3)
    assert (first.jump_down, second.jump_down) == pytest.approx((0.54338, 1.0851), rel=1e-3)
    for band in told.bands:
        assert (band.low, band.high, band.whole) == (band.jump_up, band.jump_down, True)
        assert [len(jumps) for jumps in (band.on_run_up, band.on_run_down)] == [1, 1]
    # of the band with the largest jump, .610; the largest rise, .361 against .356, is in the other one
    assert (told.jump_up, told.jump_down) == (first.jump_up, first.jump_down)
    assert told.width == first.high - first.low < 0.02
    assert str(told).count("Hysteresis") == 2


def settled(omega, y):
    """Largest |x| of the motion that follows y by DOP853, and its state 60 periods later."""
    error = TWO_LINES.error

    def rates(t, y):
        x, v = y[0] - error.value(omega * t), y[1] - omega * error.slope(omega * t)
        return y[1], -0.05 * v - x - 0.3 * x**3

    turn = 2.0 * math.pi / omega
    far = solve_ivp(rates, (0.0, 60 * turn), y, method="DOP853", rtol=1e-8).y[:, -1]
    return np.max(np.abs(solve_ivp(rates, (0.0, turn), far, method="DOP853", rtol=1e-8, max_step=turn / 200).y[0])), far


@pytest.mark.slow
def test_between_two_bands_an_integrated_run_up_and_run_down_are_on_one_motion():
    speeds, apart = (0.52, 0.536, 0.55, 0.8, 1.0, 1.05, 1.074, 1.1), {}
    for order in (speeds, speeds[::-1]):
        y = (0.0, 0.0)
        for omega in order:
            peak, y = settled(omega, y)
            apart.setdefault(omega, []).append(peak)
    differ = {omega for omega, (up, down) in apart.items() if abs(up / down - 1.0) > 0.01}
    told = sw.jumps(sw.frequency_response(TWO_LINES, (0.4, 1.4)))
    assert differ == {w for w in speeds if any(band.low < w < band.high for band in told.bands)} == {0.536, 1.074}


@pytest.mark.parametrize(("span", "ends"), [((0.4, 0.537), "high"), ((0.536, 0.9), "low")])
def test_a_band_that_the_range_cuts_ends_with_it(span, ends):
    told = sw.jumps(sw.frequency_response(TWO_LINES, span))
    (band,) = told.bands
    assert getattr(band, ends) == span[ends == "high"]
    assert not band.whole
    assert band.width == told.width == 0.0
    assert "outside the range" in str(told)


def drawn(path, points=40):
    """An open branch through corners (omega, peak, stable towards the next one)."""
    corners = [np.array(corner[:2]) for corner in path]
    pieces = [a + np.linspace(0.0, 1.0, points)[:, None] * (b - a) for a, b in pairwise(corners)]
    line = np.concatenate([piece[1:] if i else piece for i, piece in enumerate(pieces)])
    stable = np.repeat([corner[2] for corner in path[:-1]], [len(p) - (i > 0) for i, p in enumerate(pieces)])
    folds = [SimpleNamespace(value=c[0], label="fold") for c in corners[1:-1]]
    return SimpleNamespace(
        parameter="omega", values=line[:, 0], peak=line[:, 1], stable=stable, folds=folds, doublings=[],
        branch_points=[], multipliers=np.zeros((len(line), 0)), closed=False, span=(corners[0][0], corners[-1][0]),
    )  # fmt: skip


def test_a_motion_that_goes_on_where_it_turns_stable_again_does_not_jump():
    told = sw.jumps(drawn([(0, 1, True), (4, 2, False), (4 - 1e-7, 2, True), (9, 3, True)]))
    assert (told.on_run_up, told.on_run_down, told.bands) == ((), (), ())
    assert told.finished_up
    assert told.finished_down
    apart = sw.jumps(drawn([(0, 1, True), (4, 2, False), (4 - 1e-7, 2.1, True), (9, 3, True)]))
    assert [jump.after - jump.before for jump in apart.on_run_up] == pytest.approx([0.1], rel=1e-5)


def test_bands_that_overlap_have_each_a_jump_and_its_way_back():
    branch = drawn([(0, 1, True), (4, 2, False), (1, 3, True), (6, 4, False), (3, 5, True), (9, 6, True)])
    told = sw.jumps(branch)
    assert [(band.low, band.high) for band in told.bands] == [(1.0, 4.0), (3.0, 6.0)]


def test_a_jump_of_a_sweep_that_the_other_one_does_not_reach_is_in_no_band():
    # no motion is stable between 6 and 7: the run-up jumps at 4 and ends at 6, the run-down ends at 7
    branch = drawn([(0, 1, True), (4, 2, False), (3, 3, True), (6, 4, False), (7, 5, True), (9, 6, True)])
    told = sw.jumps(branch)
    assert told.bands == ()
    assert [jump.value for jump in told.alone] == [4.0]
    assert not told.finished_up
    assert not told.finished_down


def test_a_sweep_that_passes_over_a_motion_of_the_other_one_has_one_band_with_three_jumps():
    # up: from the lowest motion at 6 to the highest one; down: at 3 to the middle one, which ends at 1
    branch = drawn([(0, 1, True), (6, 2, False), (1, 3, True), (4, 4, False), (3, 5, True), (9, 6, True)])
    (band,) = sw.jumps(branch).bands
    assert (band.low, band.high, band.whole) == (1.0, 6.0, True)
    assert ([j.value for j in band.on_run_up], [j.value for j in band.on_run_down]) == ([6.0], [3.0, 1.0])


def test_a_sweep_keeps_to_the_range_where_only_motions_outside_join_its_beginning():
    # asked for 3 to 7: stable from 2 to 0 on an excursion, and from 5 to 7
    branch = drawn([(3, 1, False), (2, 2, True), (0, 3, False), (5, 4, True), (7, 5, True)])
    told = sw.jumps(branch)
    for run in (told.run_up, told.run_down):
        assert (branch.values[run].min(), branch.values[run].max()) == (5.0, 7.0)
    assert told.finished_up
    assert not told.finished_down


def test_a_sweep_begins_at_the_range_on_a_motion_that_comes_from_outside():
    branch = drawn([(3, 1, False), (4, 2, False), (1, 3, True), (7, 5, True)])
    told = sw.jumps(branch)
    assert 3.0 <= branch.values[told.run_up].min() < 3.2
    assert told.bands == ()


def test_without_a_stable_motion_in_the_range_there_is_no_sweep():
    with pytest.raises(ValueError, match="no stable motion"):
        sw.jumps(drawn([(3, 1, False), (2, 2, True), (0, 3, False), (7, 4, False)]))
