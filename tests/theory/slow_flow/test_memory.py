"""Friction and memory in the slow flow: closed forms of their loops, and orbits by independent methods."""

import math
from typing import NamedTuple

import numpy as np
import pytest
from canonical import DISSIPATIVE
from maxwell import Maxwell
from scipy.integrate import quad, solve_ivp

import strainwave as sw
from strainwave.base.law import states_of
from strainwave.compile.jit import run
from strainwave.theory.slow_flow.averages.memory import Loops, closed

DRIVE = sw.Oscillator(1.0, 0.05, sw.Parallel(sw.Linear(1.0), sw.BoucWen(1.0, 0.0, 0.4)), sw.Harmonic(0.4), 1.117)


class Jenkins(NamedTuple):
    """A spring of stiffness K in series with dry friction, which slips at a torsion x_y of the spring."""

    K: float
    x_y: float
    states = 1

    def torque(self, x, v, z):
        return self.K * z[0]

    def z_rate(self, x, v, z):
        stuck = 1.0 - 0.25 * (1.0 + np.sign(abs(z[0]) - self.x_y)) * (1.0 + np.sign(v * z[0]))
        return (stuck * v,)


def on_turn(law, a, points=512, speed=1.0):
    """2 <T exp(-i chi)> along a cos chi: equivalent stiffness and, as imaginary part, speed times damping, times a."""
    loops = Loops(law, 1, points)
    return complex(loops.coefficients(loops.torque(np.array([[0.0, a]], complex), speed))[0, 1])


@pytest.mark.parametrize("a", [0.05, 0.4, 1.3, 20.0])
def test_bouc_wen_loses_the_area_of_its_exact_loop(a):
    """n = 1, beta = gamma = 1/2: straight while it unloads, z = y (1 - exp(-s/y)) after the change of sign."""
    y, top = 0.4, min(a, 0.4)
    for _ in range(300):  # the peak: y (1 - exp(-(2 a - top)/y)) = top
        top = 0.5 * (top + y * (1.0 - math.exp(-(2.0 * a - top) / y)))
    area = 2.0 * (y * (2.0 * a - top) - y * top - 0.5 * top * top)

    def branch(chi):  # from the reversal at +a
        s = a * (1.0 - math.cos(chi))
        return top - s if s < top else -y * (1.0 - math.exp(-(s - top) / y))

    corner = math.acos(1.0 - min(top / a, 2.0))
    in_phase, _ = quad(lambda chi: branch(chi) * math.cos(chi), 0.0, math.pi, points=[corner], epsabs=1e-12)
    expected = 3.0 / math.pi * complex(2.0 * in_phase, area / a)
    assert on_turn(sw.BoucWen(3.0, 0.0, y), a) == pytest.approx(expected, rel=2e-4)


@pytest.mark.parametrize("a", [0.2, 0.6, 2.0])
def test_bilinear_hysteresis_has_caugheys_stiffness_and_damping(a):
    """Caughey 1960, J. Appl. Mech. 27(4), 640-643: theta = acos(1 - 2 y/a); below y a spring."""
    K, y = 3.0, 0.4
    theta = math.acos(1.0 - 2.0 * y / a) if a > y else math.pi
    stiffness = K * a / math.pi * (theta - 0.5 * math.sin(2.0 * theta))
    loss = 4.0 * K * y / math.pi * (1.0 - y / a) if a > y else 0.0

    def branch(chi):
        return max(y - a * (1.0 - math.cos(chi)), -y) if a > y else a * math.cos(chi)

    for weight, expected in ((math.cos, stiffness), (math.sin, -loss)):
        by_quadrature, _ = quad(lambda chi, w=weight: K * branch(chi) * w(chi), 0.0, math.pi, points=[theta])
        assert 2.0 / math.pi * by_quadrature == pytest.approx(expected, abs=1e-9)
    expected = complex(stiffness, loss)
    errors = [abs(on_turn(Jenkins(K, y), a, points) / expected - 1.0) for points in (512, 2048)]
    assert errors[1] < 1e-2  # of first order only, where z_rate jumps
    assert errors[1] < 0.5 * errors[0] or errors[1] < 1e-6
    assert on_turn(sw.BoucWen(K, 0.0, y, n=50), a, 2048) == pytest.approx(expected, rel=2e-2)


def test_coulomb_friction_has_its_equivalent_damping():
    """4 T_c/(pi a) times the speed's inverse where the width vanishes; with a width the same by quadrature."""
    a, speed = 0.3, 2.0
    assert on_turn(sw.laws.Coulomb(0.7, 1e-9), a, 1024, speed).imag == pytest.approx(4.0 * 0.7 / math.pi, rel=1e-5)
    smooth, _ = quad(lambda chi: math.sin(chi) ** 2 / math.hypot(math.sin(chi), 0.1 / (a * speed)), 0.0, math.pi)
    found = on_turn(sw.laws.Coulomb(0.7, 0.1), a, 1024, speed)
    assert found.imag == pytest.approx(0.7 * 2.0 / math.pi * smooth, rel=1e-9)
    assert abs(found.real) < 1e-12


@pytest.mark.slow
@pytest.mark.parametrize("name", ["LuGre", "BoucWen", "BoucWen, n = 3, gamma < 0", "Parallel, nested"])
def test_loops_converge_and_both_forms_agree(name):
    law = DISSIPATIVE[name]
    c = np.array([[0.05, 0.3 - 0.2j, 0.1j, 0.04]])
    found = []
    for points in (256, 512, 1024, 8192):
        loops = Loops(law, 3, points)
        found.append(loops.coefficients(loops.torque(c, 1.3))[0])
    errors = [np.max(np.abs(f - found[-1])) for f in found[:-1]]
    assert errors[2] < 3e-4 * np.max(np.abs(found[-1]))
    assert errors[2] < errors[0] / 6.0  # of second order, where a reversal lies between two points
    n = 64
    chi = 2.0 * np.pi * np.arange(n) / n
    u, v = (0.3 * np.cos(chi) + 0.1 * np.sin(2 * chi))[None], (-0.3 * np.sin(chi) + 0.2 * np.cos(2 * chi))[None]
    results = []
    for call in (run, lambda kernel, *args: kernel(*args)):
        torque, gap = np.empty((1, n)), np.empty(1)
        call(closed, law, u, v, np.array([2.0 * np.pi / n]), (0.0,) * states_of(law), torque, gap)
        results.append(torque)
    np.testing.assert_allclose(results[0], results[1], rtol=0, atol=1e-8 * np.max(np.abs(results[0])))


def test_second_order_is_exact_where_the_memory_is_linear():
    system = sw.Oscillator(2.0, 0.1, Maxwell(3.0, 1.5, 0.7), sw.Harmonic(0.4), 1.3)
    i = 1j * 1.3 * 0.7
    exact = 0.4 / (3.0 + 1.5 * i / (1.0 + i) - 2.0 * 1.3**2 + 0.13j)
    (state,) = sw.slow_flow(system, sw.PRIMARY, order=2).steady_states()
    assert state.z == pytest.approx(exact, rel=1e-4)


def test_second_order_takes_viscous_friction_for_damping():
    plain = sw.Oscillator(1.0, 0.1, sw.Linear(2.0), sw.Harmonic(0.3), 1.3)
    inside = plain._replace(B=0.04, law=sw.Parallel(sw.Linear(2.0), sw.laws.Viscous(0.06)))
    one, other = (sw.slow_flow(s, sw.PRIMARY, order=2).steady_states()[0] for s in (plain, inside))
    assert other.z == pytest.approx(one.z, rel=1e-7)
    assert other.stable


def by_integration(system, periods=60):
    """First harmonic [rad] of the settled motion, by SciPy and the equations written out."""
    law, (K, y) = system.law, (system.law.second.K, system.law.second.yield_twist)

    def rates(t, state):
        x, v, z = state
        bend = v - abs(z / y) * (0.5 * abs(v) * np.sign(z) + 0.5 * v)
        torque = law.first.K * x + K * z
        return v, (system.excitation.amplitude * math.cos(system.omega * t) - system.B * v - torque) / system.J, bend

    period = 2.0 * math.pi / system.omega
    t = period * (periods + np.arange(256) / 256)
    solved = solve_ivp(rates, (0.0, t[-1]), [0.0, 0.0, 0.0], "DOP853", t_eval=t, rtol=1e-8, atol=1e-10)
    return 2.0 * np.mean(solved.y[0] * np.exp(-1j * system.omega * t))


@pytest.mark.slow
def test_hysteretic_drive_agrees_with_scipy_at_its_peak():
    true = by_integration(DRIVE)
    first, second = (sw.slow_flow(DRIVE, sw.PRIMARY, order=order).steady_states()[0] for order in (1, 2))
    assert abs(second.z - true) < 2e-3 * abs(true)
    assert abs(second.z - true) < 0.05 * abs(first.z - true)
    assert first.stable
    assert second.stable


@pytest.mark.slow
@pytest.mark.parametrize("order", [1, 2])
def test_certificate_knows_the_error(order):
    flow = sw.slow_flow(DRIVE, sw.PRIMARY, order=order)
    certificate, orbit = flow.certificate(), sw.find_orbit(DRIVE)
    error = abs(flow.steady_states()[0].amplitude / orbit.amplitude(1) - 1.0)
    assert certificate.amplitude_at_speed == pytest.approx(error, rel=0.1, abs=5e-5)
    assert certificate.valid == (order == 2)


@pytest.mark.slow
def test_curve_has_its_peak_where_harmonic_balance_has_it():
    branch = sw.frequency_response(DRIVE, (1.0, 1.3), harmonics=9)
    top = int(np.argmax(branch.amplitude(1)))
    curve = sw.slow_flow(DRIVE, sw.PRIMARY, order=2).response((1.0, 1.3))
    assert curve.peak[1] == pytest.approx(branch.amplitude(1)[top], rel=3e-3)
    assert curve.peak[0] == pytest.approx(branch.omega[top], rel=3e-3)


@pytest.mark.slow
def test_mean_torsion_is_that_of_the_settled_loop():
    law = sw.Parallel(sw.Cubic(1.0, 0.3), sw.BoucWen(1.0, 0.0, 0.4))
    system = sw.Oscillator(1.0, 0.05, law, sw.Harmonic(0.3, mean=0.4), 1.25)
    flow, orbit = sw.slow_flow(system, sw.PRIMARY, order=2), sw.find_orbit(system, harmonics=15)
    state = flow.steady_states()[0]
    t = 2.0 * np.pi / 1.25 * np.arange(256) / 256
    assert state.amplitude == pytest.approx(orbit.amplitude(1), rel=1e-2)
    assert np.mean(flow.steady_x(state.z, t)) == pytest.approx(orbit.coefficients[0, 0], rel=1e-2)
    # slowly loaded from rest, the hysteresis carries its part of the mean torque; under a vibration the spring alone
    assert flow.mean_torsion < 0.9 * orbit.coefficients[0, 0]


@pytest.mark.slow
def test_transient_ends_on_the_steady_state():
    flow = sw.slow_flow(DRIVE._replace(omega=1.3), sw.PRIMARY)
    assert flow.evolve((0.0, 0.0), 200.0).amplitude[-1] == pytest.approx(flow.steady_states()[0].amplitude, rel=1e-3)


@pytest.mark.parametrize(
    ("system", "resonance", "sentence"),
    [
        (DRIVE, sw.NONRESONANT, "no common period over which its loop could close; name a resonance"),
        (
            DRIVE._replace(law=sw.BoucWen(1.0, 0.0, 0.4), excitation=sw.Harmonic(0.1, mean=0.1)),
            sw.PRIMARY,
            "BoucWen holds the mean torque 0.1 N.m by friction or memory alone, .* put a spring in parallel",
        ),
        (DRIVE._replace(law=sw.laws.Coulomb(0.1, 0.1)), sw.PRIMARY, "the stiffness of Coulomb is 0 N.m/rad"),
    ],
)
def test_what_has_no_average_is_refused(system, resonance, sentence):
    with pytest.raises(ValueError, match=sentence):
        sw.slow_flow(system, resonance)
