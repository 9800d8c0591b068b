"""A CSF-40-50 with the vendors' three slopes: free period in closed form, and its resonance under kinematic error.

Stiffness: Harmonic Drive LLC, CSF/CSG catalogue, p. 50. The forced case (J_m = 4.5e-4, J_l = 1.3 kg m^2, N = 50;
damping 9.82317898446; e = 1.1e-4 cos 2 theta; theta = motor speed times t; no load) was solved twice independently, by
the exact flow of the segments and by DOP853 with located switches, which agree to 2e-10.
"""

import math

import numpy as np
import pytest
from canonical import CSF_40_50 as LAW

import strainwave as sw

DRIVE = sw.Drive(J_m=4.5e-4, J_l=1.3, N=50.0, B=9.82317898446, law=LAW)
TIGHT = sw.Dopri5(rtol=1e-12, atol=1e-18)


def driven(omega, amplitude=1.1e-4):
    return DRIVE.error_equation(kinematic_error=sw.KinematicError((sw.Line(2, amplitude),)), omega=omega)


def settled(omega, y0, seconds=5.0):
    """Largest torsion on the steady orbit that y0 leads to (what disturbs it decays as exp(-8 t)), and its start."""
    system = driven(omega)
    turns = math.ceil(seconds * omega / (2.0 * math.pi))
    y = sw.simulate(system, y0, [0.0, 1e-9, turns * 2.0 * math.pi / omega], method=TIGHT).y[:, -1]
    t = np.linspace(0.0, 2.0 * math.pi / omega, 4001)
    run = sw.simulate(system, y, t, method=TIGHT)
    np.testing.assert_allclose(run.y[0, -1], y[0], rtol=0, atol=1e-13)  # one turn later: the same
    return refined_peak(np.abs(system.torsion(omega * t, run.y))), y


def refined_peak(u):
    """Largest of dense samples, by the parabola through the largest three."""
    i = 1 + int(np.argmax(u[1:-1]))
    a, b, c = u[i - 1 : i + 2]
    return b + (a - c) ** 2 / (8.0 * (2.0 * b - a - c))


def free_period(amplitude):
    """Closed form: on each straight piece cosine of its own frequency about its own centre, four quarters alike."""
    total, x2, slopes = 0.0, LAW.breakpoints()[3], (LAW.K3, LAW.K2, LAW.K1)
    edges = (amplitude, x2, LAW.breakpoints()[2], 0.0)
    speed = 0.0
    for start, end, K in zip(edges[:-1], edges[1:], slopes, strict=True):
        w = math.sqrt(K / DRIVE.J)
        centre = start - LAW.torque(start) / K
        radius = math.hypot(start - centre, speed / w)
        total += (math.acos((end - centre) / radius) - math.acos((start - centre) / radius)) / w
        speed = w * math.sqrt(radius**2 - (end - centre) ** 2)
    return 4.0 * total


def test_printed_free_period_is_the_closed_form():
    assert free_period(3e-3) == pytest.approx(0.0127889662624, abs=0.5e-13)


@pytest.mark.slow
def test_integration_gives_the_free_period():
    period = free_period(3e-3)
    run = sw.simulate(driven(1.0, amplitude=0.0)._replace(B=0.0), (3e-3, 0.0), 10.0 * period, method=TIGHT)
    late = run.y[1, -1] / run.rate[1, -1]
    assert (10.0 * period - late) / 10.0 == pytest.approx(0.0127889662624, abs=0.5e-13)
    assert run.switches == 80  # eight crossings of four breakpoints in each period
    assert run.y[0, -1] == pytest.approx(3e-3, rel=1e-9)


@pytest.mark.slow
def test_two_stable_orbits_coexist_at_235_rad_per_s():
    small, y_small = settled(235.0, (0.0, 0.0))
    assert small == pytest.approx(0.00043689558, abs=0.5e-11)
    # The large orbit is reached by stepping the speed up from where it is the only one.
    y = (0.0, 0.0)
    for omega in (220.0, 225.0, 230.0, 235.0):
        large, y = settled(omega, y)
    assert large == pytest.approx(0.00236525454, abs=0.5e-11)
    assert np.max(np.abs(y - y_small)) > 1e-4


@pytest.mark.slow
def test_peak_of_the_resonance_is_reached_from_below():
    y = (0.0, 0.0)
    for omega in (220.0, 228.0, 234.0, 239.0, 243.0, 246.0, 248.0):
        _, y = settled(omega, y)
    peak, _ = settled(248.740684, y, seconds=20.0)
    assert peak == pytest.approx(0.00337858345, abs=0.5e-11)
    assert LAW.torque(peak) == pytest.approx(524.3736, abs=0.5e-4)
    assert 248.740684 * 60.0 / (2.0 * math.pi) == pytest.approx(2375.29856, abs=0.5e-5)
    # Beyond the fold at 249.057291 rad/s the large orbit is gone.
    beyond, _ = settled(249.2, y, seconds=20.0)
    assert beyond < 0.1 * peak


def test_inertia_is_that_of_the_drive_with_a_free_motor():
    assert DRIVE.J == pytest.approx(0.6030927835, abs=0.5e-10)  # noqa: SIM300 (DRIVE.J is not a constant)
