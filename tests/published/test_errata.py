"""Errata of the source article, one by one: the printed formula fails an independent check, the corrected one passes.

The article studies the nonlinear dynamic error of a strain wave gear drive (two inertias, a cubic spring, HDC-40-050)
with Lagrange's equations, Lyapunov's direct method and multiple scales in four regimes of resonance.
The numbers E1 to E8 are those of the table of errata in the documentation's theory page.
"""

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp

import strainwave as sw

# --- E1: the forcing of the error equation; E7: the reach of the stability claim ---


def test_e1_printed_forcing_lacks_the_ratio_in_front_of_the_load_torque():
    derived = sw.derivation()
    s = derived.symbols
    printed = (s.T_m * s.J_l - s.T_l * s.J_m) / (s.N * s.J_m * s.J_l)
    corrected = (s.T_m * s.J_l - s.N * s.T_l * s.J_m) / (s.N * s.J_m * s.J_l)
    assert sp.simplify(derived.F - corrected) == 0
    assert sp.simplify(derived.F - s.T_m / (s.N * s.J_m) + s.T_l / s.J_l) == 0
    assert sp.simplify(derived.F_printed - printed) == 0
    assert sp.simplify(derived.F - printed + (s.N - 1) * s.T_l / (s.N * s.J_l)) == 0  # wrong by (N - 1)/N of T_l/J_l


@pytest.mark.parametrize("seed", range(3))
def test_e1_corrected_forcing_agrees_with_both_inertias_and_the_printed_one_does_not(seed):
    rng = np.random.default_rng(seed)
    J_m, J_l, N, B, K, alpha = rng.uniform((0.01, 1.0, 3.0, 0.2, 20.0, 5.0), (0.05, 3.0, 8.0, 0.6, 60.0, 20.0))
    shape = rng.uniform((0.5, 0.0, -1.0), (2.0, 6.0, 1.0), (2, 3))
    # the load torque is on the slow side: N times the motor's, and some more for the large inertia there
    motor, load = (sw.Harmonic(c * a, phase=p, mean=c * m) for c, (a, p, m) in zip((1.0, 10.0 * N), shape, strict=True))
    omega = rng.uniform(2.0, 5.0)
    drive = sw.Drive(J_m, J_l, N, B, sw.Cubic(K, alpha))
    times = np.linspace(0.0, 6.0, 61)

    def two_inertias(t, y):
        """The article's own equations of motion."""
        theta_m, theta_l, rate_m, rate_l = y
        spring = drive.law.torque(theta_m / N - theta_l) + B * (rate_m / N - rate_l)
        torque_m, torque_l = motor.torque(omega * t), load.torque(omega * t)
        return rate_m, rate_l, (torque_m - spring / N) / J_m, (torque_l + spring) / J_l

    def error_by(forcing):
        def rate(t, y):
            x, v = y
            F = forcing(motor.torque(omega * t), load.torque(omega * t))
            return v, F - drive.mu * v - drive.law.torque(x) / drive.J

        return solve_ivp(rate, (0.0, 6.0), (0.01, 0.0), t_eval=times, method="DOP853", rtol=1e-10, atol=1e-13).y[0]

    start = (N * 0.01, 0.0, 0.0, 0.0)
    both = solve_ivp(two_inertias, (0.0, 6.0), start, t_eval=times, method="DOP853", rtol=1e-10, atol=1e-13).y
    x = both[0] / N - both[1]
    corrected = error_by(lambda T_m, T_l: T_m / (N * J_m) - T_l / J_l)
    printed = error_by(lambda T_m, T_l: (T_m * J_l - T_l * J_m) / (N * J_m * J_l))
    scale = np.max(np.abs(x))
    assert np.max(np.abs(corrected - x)) < 1e-7 * scale
    assert np.max(np.abs(printed - x)) > 0.02 * scale
    system = drive.error_equation(motor_torque=motor, load_torque=load, omega=omega)
    for t, state in ((0.0, (0.01, 0.0)), (1.3, (-0.02, 0.4))):
        F = motor.torque(omega * t) / (N * J_m) - load.torque(omega * t) / J_l
        expected = F - drive.mu * state[1] - drive.law.torque(state[0]) / drive.J
        assert system.rhs(omega * t, state)[1] == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("alpha", [0.0, 0.1, 30.0])
def test_e7_stability_is_global_for_hardening(alpha):
    proof = sw.lyapunov(sw.HDC_40_050._replace(law=sw.Cubic(7160.0, alpha)).error_equation())
    assert (proof.holds, proof.scope, proof.asymptotic) == (True, "global", True)


def test_e7_v_of_a_softening_law_is_not_radially_unbounded():
    proof = sw.lyapunov(sw.HDC_40_050._replace(law=sw.Cubic(7160.0, -0.1)).error_equation())
    assert proof.V(10.0, 0.0) < 0.0
    assert proof.V(100.0, 0.0) < proof.V(10.0, 0.0)


@pytest.mark.parametrize("alpha", [-0.1, -4.0, -6.9e4])
def test_e7_stability_is_local_for_softening(alpha):
    drive = sw.HDC_40_050._replace(law=sw.Cubic(7160.0, alpha))
    proof = sw.lyapunov(drive.error_equation())
    assert (proof.holds, proof.scope) == (True, "local")
    edge = 1.0 / np.sqrt(abs(alpha))
    assert (proof.region.x_low, proof.region.x_high) == pytest.approx((-edge, edge), rel=1e-12)
    # energy per inertia: omega_0^2/(4 |alpha|), the level of the saddles
    assert proof.region.energy_limit / drive.J == pytest.approx(drive.omega_0**2 / (4.0 * abs(alpha)), rel=1e-12)
    assert proof.V(edge, 0.0) == pytest.approx(proof.region.energy_limit, rel=1e-12)
    assert drive.law.torque(edge) == pytest.approx(0.0, abs=1e-9 * 7160.0 * edge)
    assert drive.law.stiffness(edge) == pytest.approx(-2.0 * 7160.0)  # a saddle


def test_e7_a_softening_start_beyond_the_saddle_never_comes_back():
    system = sw.Oscillator(1.0, 0.3, sw.Cubic(1.0, -0.25), sw.Harmonic(0.0), 1.0)
    proof = sw.lyapunov(system)

    def rate(t, y):
        return system.rhs(t, y)

    def far(_, y):
        return abs(y[0]) - 20.0

    far.terminal = True
    for x, v, inside in (
        (1.98, 0.0, True),
        (-1.98, 0.0, True),
        (2.02, 0.0, False),
        (-2.02, 0.0, False),
        (1.9, 0.6, False),
    ):
        assert proof.contains(x, v) is inside
        motion = solve_ivp(rate, (0.0, 80.0), (x, v), events=far, rtol=1e-8, atol=1e-10)
        assert (motion.status == 1) is not inside
        if inside:
            assert abs(motion.y[0, -1]) < 1e-3
