"""The datasheet's measurements, against closed forms and an integration of the motion; fits of a datasheet."""

import math

import numpy as np
import pytest
from canonical import CSF_40_50

import strainwave as sw

ARCMIN = math.pi / 180.0 / 60.0
RATED = 178.0  # N*m, CSG-40-50: Harmonic Drive SE catalogue


def branch(z, twist, law):
    """Return z after a positive twist, for n = 1: dz/dx = A - (beta + gamma sign z) z/x_y, exponentials."""
    if z < 0.0:
        rate = (law.beta - law.gamma) / law.yield_twist
        to_zero = -z / law.A if rate == 0.0 else math.log(1.0 - z * rate / law.A) / rate
        if twist <= to_zero:
            return z + law.A * twist if rate == 0.0 else law.A / rate + (z - law.A / rate) * math.exp(-rate * twist)
        z, twist = 0.0, twist - to_zero
    rate = (law.beta + law.gamma) / law.yield_twist
    return law.A / rate + (z - law.A / rate) * math.exp(-rate * twist)


@pytest.mark.parametrize("gamma", [0.5, 0.2, -0.3])
def test_loop_follows_the_closed_form_of_bouc_wen(gamma):
    law = sw.BoucWen(1.0, 0.3, 0.4, 1.0, 0.5, gamma, 1)
    loop = sw.hysteresis_loop(law, 1.0)
    n = len(loop.torque) // 3
    x, t = loop.torsion[2 * n :], loop.torque[2 * n :]
    z = (t - 0.3 * x) / 0.7
    exact = [branch(z[0], float(u - x[0]), law) for u in x]
    np.testing.assert_allclose(z, exact, atol=1e-9)
    assert t[-1] == pytest.approx(1.0, abs=1e-9)


@pytest.mark.compiled
def test_loop_of_bouc_wen_is_that_of_the_slow_motion():
    # a light oscillator under one slow period of torque
    law = sw.BoucWen(1.0, 0.3, 0.4)
    loop = sw.hysteresis_loop(law, 1.0)
    system = sw.Oscillator(1e-3, 0.05, law, sw.Harmonic(1.0, phase=-math.pi / 2), 2e-3)
    period = 2.0 * math.pi / 2e-3
    slow = sw.simulate(system, (0.0, 0.0, 0.0), np.array([0.0, 0.5, 1.0, 1.25]) * period)
    assert slow.y[0, 1] - slow.y[0, 2] == pytest.approx(loop.loss, rel=1e-3)  # torque zero on the way down and up
    assert slow.y[0, 3] == pytest.approx(loop.torsion[-1], rel=1e-3)


def test_area_of_the_loop_is_what_bouc_wen_loses():
    law = sw.BoucWen(1.0, 0.3, 0.4)
    loop = sw.hysteresis_loop(law, 1.0)
    n = len(loop.torque) // 3
    x, t = loop.torsion[n:], loop.torque[n:]
    assert loop.energy == pytest.approx(np.sum(0.5 * (t[1:] + t[:-1]) * np.diff(x)), rel=1e-3)
    assert loop.energy > 0.0


def test_spring_has_no_hysteresis_and_twice_its_torsion():
    loop = sw.hysteresis_loop(CSF_40_50, RATED)
    assert abs(loop.loss) < 1e-12
    assert loop.span == pytest.approx(2.0 * (54.0 / 1e5 + (178.0 - 54.0) / 1.4e5), rel=1e-9)  # the vendor's formula
    assert sw.lost_motion(CSF_40_50, RATED) == pytest.approx(0.08 * RATED / 1e5, rel=1e-9)


def test_dry_friction_widens_the_loop_by_twice_its_torque_over_the_stiffness():
    law = sw.Parallel(sw.Linear(1e5), sw.Coulomb(5.0, 1e-9))
    loop = sw.hysteresis_loop(law, RATED, speed=1e-4)
    assert loop.loss == pytest.approx(2.0 * 5.0 / 1e5, rel=1e-6)
    assert loop.energy == pytest.approx(2.0 * 5.0 * loop.span, rel=1e-2)  # the span is shorter by the reversal


def test_law_that_does_not_carry_the_torque_is_refused():
    with pytest.raises(ValueError, match=r"BoucWen carries 0\.4 N\*m at .* and does not reach 1 N\*m; take less"):
        sw.hysteresis_loop(sw.BoucWen(1.0, 0.0, 0.4), 1.0)


@pytest.mark.slow
@pytest.mark.parametrize(("loss", "motion"), [(0.5, 0.3), (0.2, 0.3)])
def test_fit_meets_hysteresis_loss_and_lost_motion(loss, motion):
    fit = sw.fit_hysteresis(CSF_40_50, loss * ARCMIN, motion * ARCMIN, rated_torque=RATED)
    assert sw.hysteresis_loop(fit.law, RATED).loss == pytest.approx(loss * ARCMIN, rel=1e-4)
    assert sw.lost_motion(fit.law, RATED) == pytest.approx(motion * ARCMIN, rel=1e-4)
    assert max(abs(off) for off in fit.misfit.values()) < 0.05
    assert fit.law.first == CSF_40_50


@pytest.mark.slow
def test_datasheet_that_cannot_be_met_is_refused_with_its_misfit():
    # 0.08 * 178 N*m / 1e5 N*m/rad = 0.49 arcmin is the lost motion of the spring alone
    with pytest.raises(sw.SolveError, match=r"lost motion is off by -6.* %; with this spring the lost motion is below"):
        sw.fit_hysteresis(CSF_40_50, ARCMIN, ARCMIN, rated_torque=RATED)
