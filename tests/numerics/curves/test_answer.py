"""One kernel from the numbers of an oscillator to its curve: the same motions as the verbs find in many calls."""

import numpy as np
import pytest

import strainwave as sw
from strainwave.drive.response import of_equation, turn_response
from strainwave.numerics.curves import answer as kernel
from strainwave.numerics.curves.drive_numbers import answered
from strainwave.numerics.labels import DECAYS, FOLD

pytestmark = pytest.mark.compiled

LAWS = {
    "linear": sw.Linear(1.0),
    "hardening": sw.Cubic(1.0, 0.1),
    "softening": sw.Cubic(1.0, -0.02),
    "three slopes": sw.PiecewiseLinear(1.0, 1.4, 1.8, 0.5, 1.2),
}


def asked(system, low, high, limit=np.inf, points=40):
    curve, bands, about, count = answered(system, (low, high), limit, points)
    return count, curve, bands, about


@pytest.mark.parametrize("law", LAWS)
def test_the_kernel_finds_the_motions_of_the_response(law):
    rng = np.random.default_rng(list(LAWS).index(law))
    for _ in range(2):
        lines = (sw.Line(1, 0.2 * rng.uniform(), 0.0), sw.Line(2, 0.05 * rng.uniform(), 1.0))
        system = sw.Oscillator(
            1.0, rng.uniform(0.05, 0.15), LAWS[law], sw.Harmonic(0.0, 1, 0.0, 0.3 * rng.uniform()), 1.0,
            sw.KinematicError(lines),
        )  # fmt: skip
        count, curve, _, about = asked(system, 0.4, 1.9)
        expected = of_equation(system, turn_response(system, (0.4, 1.9), 40, int(about[0]), False).curve)
        assert count == len(expected.omega)
        np.testing.assert_allclose(curve[:, kernel.OMEGA], expected.omega, rtol=1e-9)
        for column in (kernel.OSCILLATION, kernel.PEAK, kernel.TORQUE):  # sizes change faster than speeds near a fold
            name = {kernel.OSCILLATION: "oscillation", kernel.PEAK: "peak", kernel.TORQUE: "torque"}[column]
            np.testing.assert_allclose(curve[:, column], getattr(expected, name), rtol=1e-8)
        inside = curve[:, kernel.LABEL] != FOLD  # at a fold a multiplier is 1
        np.testing.assert_array_equal(curve[inside, kernel.GROWTH] < DECAYS, expected.stable[inside])
        folds = curve[curve[:, kernel.LABEL] == FOLD, kernel.OMEGA]
        np.testing.assert_allclose(folds, [fold.omega for fold in expected.folds], rtol=1e-9)


def test_the_speeds_above_a_limit_are_those_of_a_linear_spring():
    zeta, limit = 0.1, 3.0
    system = sw.Oscillator(1.0, 2.0 * zeta, sw.Linear(1.0), sw.Harmonic(1.0), 1.0)
    _, curve, bands, about = asked(system, 0.3, 2.0, limit)
    middle = 1.0 - 2.0 * zeta**2  # (1 - w^2)^2 + (2 zeta w)^2 = 1/limit^2
    half = np.sqrt(middle**2 - 1.0 + 1.0 / limit**2)
    np.testing.assert_allclose(bands, [np.sqrt([middle - half, middle + half])], rtol=1e-9)
    top = curve[int(about[kernel.TOP_ROW])]
    assert top[kernel.OSCILLATION] == pytest.approx(0.5 / (zeta * np.sqrt(1.0 - zeta**2)), rel=1e-9)
    assert top[kernel.OMEGA] == pytest.approx(np.sqrt(middle), rel=1e-5)


def test_a_range_that_ends_between_folds_says_that_there_is_another_motion():
    system = sw.Oscillator(1.0, 0.05, sw.Cubic(1.0, 0.5), sw.Harmonic(0.2), 1.0)
    folds = [fold.omega for fold in sw.frequency_response(system, (0.4, 3.0)).folds]
    beyond, between = asked(system, 0.4, 3.0)[3], asked(system, 0.4, sum(folds) / 2.0)[3]
    assert beyond[kernel.OTHERS] == 0.0
    assert between[kernel.OTHERS] == 1.0


def test_all_crests_are_points_however_many():
    orders, zeta, size = np.arange(1, 37), 0.012, 1e-3
    terms = tuple(sw.Harmonic(size, int(k), 2.0 * k * k) for k in orders)
    system = sw.Oscillator(1.0, 2.0 * zeta, sw.Linear(1.0), sw.Harmonics(terms), 1.0)
    _, curve, _, _ = asked(system, 1.0 / 36.5, 1.5, points=10)
    omega, angles = np.geomspace(1.0 / 36.5, 1.5, 12_001), 2.0 * np.pi * np.arange(512) / 512
    w = omega[:, None] * orders  # the linear response, of which `size` is the torque
    waves = size / (1.0 - w * w + 2j * zeta * w) * np.exp(2j * orders * orders)
    samples = (part @ np.exp(1j * np.outer(orders, angles)) for part in np.array_split(waves, 10))
    sizes = np.concatenate([np.max(np.abs(part.real), axis=1) for part in samples])
    inner = sizes[1:-1]
    crests = np.flatnonzero((inner > sizes[:-2]) & (inner > sizes[2:]) & (inner > 0.1 * np.max(sizes))) + 1
    assert len(crests) > 32
    for i in crests:
        beside = np.abs(curve[:, kernel.OMEGA] / omega[i] - 1.0) < 2e-3
        assert np.max(curve[beside, kernel.OSCILLATION]) >= sizes[i]
