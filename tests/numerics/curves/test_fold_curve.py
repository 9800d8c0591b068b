"""Folds against a second parameter: on the folds of single curves, through the cusp, against the closed form."""

import numpy as np
import pytest

import strainwave as sw

pytestmark = pytest.mark.compiled

B, ALPHA = 0.05, 0.1
DUFFING = sw.Oscillator(1.0, B, sw.Cubic(1.0, ALPHA), sw.Harmonic(0.18), 1.0)  # NLvib example 01
PATH = "excitation.amplitude"


def curve_of(harmonics, span=(0.03, 0.3), fold=0):
    folds = sw.frequency_response(DUFFING, (0.5, 1.6), harmonics=harmonics).folds
    return sw.numerics.fold_curve(DUFFING, folds[fold], PATH, span)


@pytest.fixture(scope="module")
def curve():
    return curve_of(7)


def test_one_harmonic_has_its_cusp_where_the_closed_form_has_it():
    # a^2 ((1 - w^2 + c a^2)^2 + B^2 w^2) = A^2 with c = 3 alpha/4: first and second derivative by a^2 vanish at
    # w^2 - sqrt(3) B w - 1 = 0, A^2 = 8 B^3 w^3/(3 sqrt(3) c)
    root3 = np.sqrt(3.0)
    w = (root3 * B + np.sqrt(3.0 * B * B + 4.0)) / 2.0
    A = np.sqrt(8.0 * (B * w) ** 3 / (3.0 * root3 * 0.75 * ALPHA))
    (cusp,) = curve_of(1).cusps
    assert cusp == pytest.approx((A, w), rel=1e-8)


def test_the_curve_holds_both_folds_of_the_given_system(curve):
    folds = sw.frequency_response(DUFFING, (0.5, 1.6), harmonics=7).folds
    other = curve_of(7, fold=1)
    assert other.cusps[0] == pytest.approx(curve.cusps[0], rel=1e-8)
    for fold in folds:
        side = np.sign(curve.values - 0.18)
        near = np.flatnonzero(side[1:] * side[:-1] <= 0)
        there = [np.interp(0.18, *zip(*sorted(zip(curve.values[i : i + 2], curve.omega[i : i + 2], strict=True)),
                                      strict=True)) for i in near]  # fmt: skip
        assert min(abs(w - fold.omega) for w in there) < 1e-3


def test_every_point_is_a_fold_of_the_curve_at_its_own_amplitude(curve):
    for i in (3, len(curve) // 3, len(curve) - 4):
        system = sw.replaced(DUFFING, {PATH: float(curve.values[i])})
        folds = sw.frequency_response(system, (0.5, 1.8), harmonics=7).folds
        nearest = min(folds, key=lambda f: abs(f.omega - curve.omega[i]))
        assert curve.omega[i] == pytest.approx(nearest.omega, rel=1e-8)
        assert curve.amplitude(1)[i] == pytest.approx(nearest.amplitude(1), rel=1e-6)


def test_the_jump_begins_at_the_cusp(curve):
    A, _ = curve.cusps[0]
    for factor, folds in ((0.999, 0), (1.001, 2)):
        system = sw.replaced(DUFFING, {PATH: A * factor})
        assert len(sw.frequency_response(system, (0.9, 1.2), harmonics=7).folds) == folds


def test_a_fold_curve_leaves_the_range_at_its_ends(curve):
    assert curve.status
    assert curve.values[0] == curve.values[-1] == 0.3


def test_folds_of_a_piecewise_law_are_followed_too():
    law = sw.PiecewiseLinear(1.0, 2.0, 3.0, 1.0, 3.0)
    system = sw.Oscillator(1.0, 0.05, law, sw.Harmonic(0.2), 1.0)
    branch = sw.frequency_response(system, (0.7, 1.6), harmonics=9)
    followed = sw.numerics.fold_curve(system, branch.folds[0], PATH, (0.15, 0.25))
    assert followed.status
    end = sw.replaced(system, {PATH: float(followed.values[-1])})
    folds = sw.frequency_response(end, (0.7, 1.8), harmonics=9).folds
    assert min(abs(f.omega - followed.omega[-1]) for f in folds) < 1e-7


def test_only_folds_are_followed():
    with pytest.raises(ValueError, match=r"Branch\.folds"):
        sw.numerics.fold_curve(DUFFING, sw.find_orbit(DUFFING, harmonics=3), PATH, (0.1, 0.3))
    fold = sw.frequency_response(DUFFING, (0.5, 1.6), harmonics=3).folds[0]
    with pytest.raises(ValueError, match="outside the range"):
        sw.numerics.fold_curve(DUFFING, fold, PATH, (0.2, 0.3))
