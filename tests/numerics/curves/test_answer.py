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
