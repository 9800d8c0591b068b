"""Errata of the source article, one by one: the printed formula fails an independent check, the corrected one passes.

The article studies the nonlinear dynamic error of a strain wave gear drive (two inertias, a cubic spring, HDC-40-050)
with Lagrange's equations, Lyapunov's direct method and multiple scales in four regimes of resonance.
The numbers E1 to E11 are those of the table of errata in the documentation's theory page.
"""

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp
from scipy.optimize import fsolve

import strainwave as sw
from strainwave.theory.article import FORMS, printed_steady, printed_x, without_alpha

# --- E1: the forcing of the error equation; E7: the reach of the stability claim ---


@pytest.mark.slow
def test_e1_printed_forcing_lacks_the_ratio_in_front_of_the_load_torque():
    derived = sw.theory.derive()
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

        return solve_ivp(rate, (0.0, 6.0), (0.01, 0.0), t_eval=times, method="DOP853", rtol=1e-12, atol=1e-13).y[0]

    # x is a difference of angles up to 1200 times as large, to which the tolerance is relative: 1e-9 of x in each step
    start = (N * 0.01, 0.0, 0.0, 0.0)
    both = solve_ivp(two_inertias, (0.0, 6.0), start, t_eval=times, method="DOP853", rtol=1e-12, atol=1e-13).y
    x = both[0] / N - both[1]
    corrected = error_by(lambda T_m, T_l: T_m / (N * J_m) - T_l / J_l)
    printed = error_by(lambda T_m, T_l: (T_m * J_l - T_l * J_m) / (N * J_m * J_l))
    scale = np.max(np.abs(x))
    assert np.max(np.abs(corrected - x)) < 1e-8 * scale
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


# --- E2 to E6 and E8: the slow flow of the cubic law ---

# omega_0 = 2 and J = K/4 make every power of omega_0 visible
OMEGA_0, MU, ALPHA, C_AMPLITUDE = 2.0, 0.03, 0.05, 0.7


def cubic_system(omega, forcing):
    """x'' + mu x' + omega_0^2 (x + alpha x^3) = forcing cos(omega t)."""
    return sw.Oscillator(1.0, MU, sw.Cubic(OMEGA_0**2, ALPHA), sw.Harmonic(forcing), omega)


def forced_system(omega):
    """The same, with a forcing that gives C = C_AMPLITUDE at the actual omega."""
    return cubic_system(omega, C_AMPLITUDE * (OMEGA_0**2 - omega**2))


@pytest.mark.parametrize("alpha", [0.0, 0.1, 0.2])
@pytest.mark.parametrize(
    ("omega", "resonance"),
    [(0.3, sw.NONRESONANT), (2.0, sw.PRIMARY), (2.0 / 3.0, sw.SUPERHARMONIC), (6.0, sw.SUBHARMONIC)],
)
def test_e2_every_cubic_term_carries_alpha(alpha, omega, resonance):
    def beyond_linear(value):
        system = cubic_system(omega, 0.8)._replace(law=sw.Cubic(OMEGA_0**2, value))
        if value == 0.0 and resonance in (sw.SUPERHARMONIC, sw.SUBHARMONIC):
            return 0.0  # such a resonance does not exist without alpha: refused
        z = 0.4 * np.exp(-0.3j)
        linear = sw.slow_flow(system._replace(law=sw.Cubic(OMEGA_0**2, 1e-30)), resonance)
        return complex(sw.slow_flow(system, resonance).rates(z) - linear.rates(z))

    at_one_tenth = beyond_linear(0.1)
    assert abs(at_one_tenth) > 1e-4
    assert beyond_linear(alpha) == pytest.approx(10.0 * alpha * at_one_tenth, rel=1e-9, abs=1e-15)


def test_e3_phase_rate_without_resonance():
    a, flow = 0.4, sw.slow_flow(forced_system(0.5), sw.NONRESONANT)
    rate = complex(flow.rates(a + 0j))
    assert rate.real == pytest.approx(-0.5 * MU * a, rel=1e-12)
    corrected = ALPHA * OMEGA_0 * (3.0 / 8.0 * a**2 + 3.0 / 4.0 * C_AMPLITUDE**2)
    printed = OMEGA_0 * (3.0 / 8.0 * a**2 + 3.0 / 4.0 * C_AMPLITUDE**2)
    assert rate.imag / a == pytest.approx(corrected, rel=1e-12)
    assert abs(rate.imag / a - printed) > 10.0 * corrected


@pytest.mark.slow
def test_e3_phase_rate_is_that_of_the_integrated_motion():
    """Without damping the free part of the motion turns at omega_0 + beta'."""
    system = forced_system(0.5)._replace(B=0.0)
    end, t = 500.0, np.linspace(0.0, 500.0, 10001)
    start = (C_AMPLITUDE + 0.4, 0.0)
    run = solve_ivp(lambda s, y: system.rhs(0.5 * s, y), (0.0, end), start, "DOP853", t, rtol=1e-8, atol=1e-10)
    turning = (run.y[0] - C_AMPLITUDE * np.cos(0.5 * t)) * np.exp(-1j * OMEGA_0 * t)
    window = np.hanning(2001)
    phase = np.unwrap(np.angle(np.convolve(turning, window, "valid")))
    measured = (phase[-1] - phase[0]) / (end - 100.0)
    corrected = ALPHA * OMEGA_0 * (3.0 / 8.0 * 0.4**2 + 3.0 / 4.0 * C_AMPLITUDE**2)
    assert measured == pytest.approx(corrected, rel=0.06)  # alpha C^2 = 0.025 is what first order neglects


@pytest.mark.parametrize("omega", [1.95, 2.0, 2.05, 2.1])
def test_e4_primary_resonance(omega):
    f, sigma = 0.05, omega - OMEGA_0
    states = sw.slow_flow(cubic_system(omega, f), sw.PRIMARY).steady_states()
    assert states
    for state in states:
        a = state.amplitude
        left = (MU**2 / 4.0 + (sigma - 3.0 / 8.0 * ALPHA * OMEGA_0 * a**2) ** 2) * a**2
        assert left == pytest.approx(f**2 / (4.0 * OMEGA_0**2), rel=1e-10)


@pytest.mark.parametrize("omega", [0.66, 2.0 / 3.0, 0.68, 0.7])
def test_e5_superharmonic_resonance(omega):
    C, sigma = C_AMPLITUDE, 3.0 * omega - OMEGA_0
    states = sw.slow_flow(forced_system(omega), sw.SUPERHARMONIC).steady_states()
    assert states
    for state in states:
        a = state.amplitude
        shift = ALPHA * OMEGA_0 * (3.0 / 4.0 * C**2 + 3.0 / 8.0 * a**2)
        right, printed = (ALPHA * OMEGA_0 * C**3 / 8.0) ** 2, (OMEGA_0 * C**3 / 8.0) ** 2
        left = (MU**2 / 4.0 + (sigma - shift) ** 2) * a**2
        assert left == pytest.approx(right, rel=1e-10)
        assert left < 0.01 * printed


@pytest.mark.parametrize("omega", [6.8, 7.0, 7.4])
def test_e6_subharmonic_resonance(omega):
    C, sigma = C_AMPLITUDE, omega - 3.0 * OMEGA_0
    states = sw.slow_flow(forced_system(omega), sw.SUBHARMONIC).steady_states()
    assert [state.stable for state in states] == [True, False, True]
    assert states[2].amplitude == 0.0
    for state in states[:2]:
        a = state.amplitude
        rest = sigma - 9.0 / 4.0 * ALPHA * OMEGA_0 * C**2 - 9.0 / 8.0 * ALPHA * OMEGA_0 * a**2
        printed = sigma - 9.0 / 8.0 * OMEGA_0 * C**2 - 9.0 / 4.0 * OMEGA_0**2 * a**2
        right = (9.0 / 8.0 * ALPHA * OMEGA_0 * C * a) ** 2
        assert 9.0 / 4.0 * MU**2 + rest**2 == pytest.approx(right, rel=1e-9)
        assert abs(9.0 / 4.0 * MU**2 + printed**2 - right) > 100.0 * right


T18 = sw.Oscillator(1.0, 0.002, sw.Cubic(1.0, 0.05), sw.Harmonic(8.0), 3.4)


def test_e6_subharmonic_amplitudes_are_the_corrected_ones():
    """omega_0 1, mu .002, alpha .05, A 8, omega 3.4: 2.850 stable, 2.093 unstable; as printed 2.007."""
    states = sw.slow_flow(T18, sw.SUBHARMONIC).steady_states()
    assert [state.amplitude for state in states] == pytest.approx([2.850, 2.093, 0.0], abs=5e-4)
    assert [state.stable for state in states] == [True, False, True]
    # the printed coefficients, swapped, with omega_0 = 1 and alpha put where E2 wants it
    C, mu, sigma, k = 8.0 / (1.0 - 3.4**2), 0.002, 0.4, 0.05 * 9.0 / 8.0
    roots = np.roots(
        [4.0 * k * k, -4.0 * k * (sigma - k * C**2) - (k * C) ** 2, 9.0 / 4.0 * mu**2 + (sigma - k * C**2) ** 2]
    )
    assert np.sqrt(max(roots.real)) == pytest.approx(2.007, abs=5e-4)


def closed_orbit(system, guess, turns=1, samples=4096):
    """x over so many turns of the forcing [rad] and the multipliers, by shooting with SciPy's DOP853."""
    period, tight = turns * 2.0 * np.pi / system.omega, {"method": "DOP853", "rtol": 1e-12, "atol": 1e-14}

    def run(y, t):
        return solve_ivp(lambda s, y: system.rhs(system.omega * s, y), (0.0, period), y, t_eval=t, **tight).y

    start, _, found, _ = fsolve(lambda y: run(y, [period])[:, 0] - y, guess, xtol=1e-12, full_output=True)
    assert found == 1
    steps = 1e-5 * np.eye(2)
    ends = [(run(start + step, [period]) - run(start - step, [period]))[:, 0] / 2e-5 for step in steps]
    x = run(start, np.linspace(0.0, period, samples, endpoint=False))[0]
    return x, np.abs(np.linalg.eigvals(np.transpose(ends)))


def test_e6_orbits_with_omega_over_three_are_those_of_shooting():
    """2.9418, stable, and 2.1434, unstable: found by shooting from the states of the slow flow."""
    C, orbits = 8.0 / (1.0 - 3.4**2), []
    for state in sw.slow_flow(T18, sw.SUBHARMONIC).steady_states()[:2]:
        x, multipliers = closed_orbit(T18, (state.z.real + C, (1j * 3.4 / 3.0 * state.z).real), turns=3)
        orbits.append((2.0 * abs(np.fft.rfft(x)[1]) / len(x), bool(np.all(multipliers < 1.0))))
    assert orbits == [(pytest.approx(2.9418, abs=5e-5), True), (pytest.approx(2.1434, abs=5e-5), False)]
    second = sw.slow_flow(T18, sw.SUBHARMONIC, order=2).steady_states()
    assert second[0].amplitude == pytest.approx(orbits[0][0], rel=1e-4)
    first = sw.slow_flow(T18, sw.SUBHARMONIC).certificate().amplitude
    assert first == pytest.approx(1.0 - 2.850 / orbits[0][0], abs=2e-4)


@pytest.mark.slow
def test_e6_branches_of_harmonic_balance_go_through_these_orbits():
    branches = sw.isolas(T18, (3.2, 3.6))
    found = [float(np.interp(3.4, branch.omega, branch.amplitude(1))) for branch in branches]
    assert found == [pytest.approx(2.9418, rel=1e-4), pytest.approx(2.1434, rel=1e-4)]
    assert [bool(np.all(branch.stable)) for branch in branches] == [True, False]


@pytest.mark.parametrize("sigma", [-0.4, 0.1, 0.4, 1.5])
def test_e6_as_printed_is_what_the_code_calls_printed(sigma):
    system = T18._replace(omega=3.0 + sigma)
    a, _ = printed_steady(system, sw.SUBHARMONIC)
    C, mu = 8.0 / (1.0 - system.omega**2), 0.002
    sizes = np.linspace(1e-3, 3.0, 300001)
    left = 9.0 / 4.0 * mu**2 + (sigma - 9.0 / 8.0 * C**2 - 9.0 / 4.0 * sizes**2) ** 2 - (9.0 / 8.0 * C * sizes) ** 2
    crossings = sizes[np.flatnonzero(np.diff(np.sign(left)))]
    assert (a is None) == (len(crossings) == 0)
    if a is not None:
        assert a == pytest.approx(crossings[-1], abs=2e-5)


@pytest.mark.parametrize(("omega", "resonance"), [(1.95, sw.PRIMARY), (2.1, sw.PRIMARY), (0.68, sw.SUPERHARMONIC)])
def test_e4_and_e5_as_printed_are_what_the_code_calls_printed(omega, resonance):
    system = cubic_system(omega, 0.05) if resonance == sw.PRIMARY else forced_system(omega)
    a, _ = printed_steady(system, resonance)
    C = system.excitation.amplitude / (OMEGA_0**2 - omega**2) if resonance != sw.PRIMARY else 0.0
    sigma = resonance.p * omega - OMEGA_0
    right = (OMEGA_0 * C**3 / 8.0) ** 2 if C else 0.05**2 / (4.0 * OMEGA_0**2)
    left = MU**2 / 4.0 * a**2 + (sigma - 3.0 / 4.0 * OMEGA_0 * C**2 - 3.0 / 8.0 * OMEGA_0 * a**2) ** 2 * a**2
    assert left == pytest.approx(right, rel=1e-9)


@pytest.mark.slow
def test_e6_corrected_subharmonic_is_near_the_integrated_one():
    """Started from the corrected state the motion stays near it, as far off as the certificate says."""
    flow = sw.slow_flow(T18, sw.SUBHARMONIC)
    state = flow.steady_states()[0]
    z, C = state.amplitude * np.exp(-1j * state.phase), 8.0 / (1.0 - 3.4**2)
    period = 3.0 * 2.0 * np.pi / 3.4
    t = np.concatenate([[0.0], (2000.0 + np.arange(64 * 4) / 64.0) * period])
    run = sw.simulate(T18, (z.real + C, (1j * 3.4 / 3.0 * z).real), t)
    settled = abs(2.0 * np.mean(run.y[0][1:] * np.exp(-1j * 3.4 / 3.0 * t[1:])))
    error = 1.0 - state.amplitude / settled
    assert 0.0 < error < 0.04
    assert flow.certificate().amplitude == pytest.approx(error, rel=1e-4)


def test_e8_primary_peak_is_the_same_for_every_alpha_and_moves_along_the_backbone():
    f = 0.05
    for alpha in (0.02, 0.05, 0.1):
        system = cubic_system(2.0, f)._replace(law=sw.Cubic(OMEGA_0**2, alpha))
        omega, a = sw.slow_flow(system, sw.PRIMARY).response((1.8, 2.4)).peak
        assert a == pytest.approx(f / (MU * OMEGA_0), rel=1e-10)
        assert omega - OMEGA_0 == pytest.approx(3.0 / 8.0 * alpha * OMEGA_0 * a**2, rel=1e-8)


def test_e8_at_a_fixed_speed_near_omega_0_alpha_lowers_the_primary_amplitude():
    system = cubic_system(OMEGA_0, 0.05)
    flows = [sw.slow_flow(system._replace(law=sw.Cubic(OMEGA_0**2, alpha)), sw.PRIMARY) for alpha in (0.02, 0.05, 0.1)]
    amplitudes = [flow.steady_states()[0].amplitude for flow in flows]
    assert amplitudes == sorted(amplitudes, reverse=True)


def test_e8_superharmonic_peak_is_proportional_to_alpha():
    for alpha in (0.02, 0.05):
        system = sw.Oscillator(1.0, MU, sw.Cubic(OMEGA_0**2, alpha), sw.Harmonic(2.0), 0.67)
        omega, a = sw.slow_flow(system, sw.SUPERHARMONIC).response((0.6, 0.75)).peak
        # C at the actual omega varies along the curve: the vertex formula holds to the width of the peak
        C = 2.0 / (OMEGA_0**2 - omega**2)
        assert a == pytest.approx(alpha * OMEGA_0 * C**3 / (4.0 * MU), rel=2e-3)


# --- E9 to E11 and N5 ---


def test_e9_the_carrier_of_primary_resonance_is_omega():
    """A steady a cos(omega t - phi) stays on the orbit of shooting, a cos(omega_0 t - phi) drifts off it."""
    omega, mu = 1.0 + 1.5e-5, 1e-5
    system = sw.Oscillator(1.0, mu, sw.Cubic(1.0, 1.0), sw.Harmonic(7.3e-8), omega)
    state = sw.slow_flow(system, sw.PRIMARY).steady_states()[0]
    exact, multipliers = closed_orbit(system, (state.z.real, (1j * omega * state.z).real), samples=256)
    assert state.stable
    assert np.all(multipliers < 1.0)
    turns = round(np.pi / (omega - 1.0) * omega / (2.0 * np.pi))  # after which (omega - omega_0) t is pi
    t = (turns + np.arange(256) / 256) * 2.0 * np.pi / omega
    corrected, printed = [state.amplitude * np.cos(w * t - state.phase) for w in (omega, 1.0)]
    size = np.sqrt(np.mean(exact**2))
    assert np.sqrt(np.mean((corrected - exact) ** 2)) < 1e-4 * size
    assert np.sqrt(np.mean((printed + exact) ** 2)) < 1e-4 * size  # the opposite


def test_e10_the_phase_of_the_free_vibration_drifts_without_resonance():
    """With the printed mu and omega_0, 0 to 5/mu from rest: 54.6 % RMS difference with beta_0, 4.2 % with its drift."""
    mu, omega_0, alpha, omega, A = 0.129, 37.2, 0.1, 10.47, 10.0 / (50.0 * 5.26e-4)
    system = sw.Oscillator(1.0, mu, sw.Cubic(omega_0**2, alpha), sw.Harmonic(A), omega)
    t = np.linspace(0.0, 5.0 / mu, 64 * 240)

    def rate(s, y):
        return y[1], A * np.cos(omega * s) - mu * y[1] - omega_0**2 * (y[0] + alpha * y[0] ** 3)

    exact = solve_ivp(rate, (0.0, t[-1]), (0.0, 0.0), "DOP853", t, rtol=1e-11, atol=1e-13).y[0]
    C = A / (omega_0**2 - omega**2)
    z = complex(-C, 0.5 * mu * C / omega_0)  # at rest
    drift = alpha * omega_0 * (3.0 / 8.0 * abs(z) ** 2 * (1.0 - np.exp(-mu * t)) / mu + 3.0 / 4.0 * C**2 * t)
    free = z * np.exp((1j * omega_0 - 0.5 * mu) * t)
    printed, corrected = free.real, (free * np.exp(1j * drift)).real
    forced = C * np.cos(omega * t)

    def rms(x):
        return 100.0 * np.sqrt(np.mean((x - exact) ** 2) / np.mean(exact**2))

    assert rms(printed + forced) == pytest.approx(54.6, abs=0.05)
    assert printed_x(system, t) == pytest.approx(printed + forced, abs=1e-12)
    assert rms(corrected + forced) == pytest.approx(4.2, abs=0.05)
    assert rms(sw.slow_flow(system, sw.NONRESONANT).x(t)) == pytest.approx(rms(corrected + forced), rel=1e-2)


@pytest.mark.parametrize(("mu", "is_focus"), [(0.3, True), (3.8, True), (4.2, False)])
def test_e11_rest_is_a_focus_only_for_mu_below_two_omega_0(mu, is_focus):
    """From x = 0 the motion comes back through 0 where it turns about the rest; omega_0 is 2 rad/s."""
    system = cubic_system(1.0, 0.0)._replace(B=mu)
    motion = solve_ivp(system.rhs, (0.0, 30.0), (0.0, 1.0), "DOP853", rtol=1e-10, atol=1e-30, max_step=0.01)
    assert (np.min(motion.y[0]) < 0.0) == is_focus


def test_n5_the_printed_0_15_rad_is_primary_resonance_with_alpha_1():
    """Table 3 with alpha = 1 at omega_0: 0.15052 rad by shooting, 0.15045 rad by the formula as printed (E2)."""
    drive = sw.HDC_40_050
    system = without_alpha(drive.error_equation(motor_torque=sw.Harmonic(10.0), omega=drive.omega_0))
    f = 10.0 / (50.0 * 5.26e-4)
    slope = 9.0 / 64.0 * drive.omega_0**2
    (square,) = [
        r.real for r in np.roots([slope, 0.0, drive.mu**2 / 4.0, -(f**2) / (4.0 * drive.omega_0**2)]) if not r.imag
    ]
    printed, peak = printed_steady(system, sw.PRIMARY)
    assert (printed, peak) == (pytest.approx(np.sqrt(square), rel=1e-9), pytest.approx(0.15045, abs=5e-6))
    state = sw.slow_flow(system, sw.PRIMARY).steady_states()[0]
    x, _ = closed_orbit(system, (state.z.real, (1j * drive.omega_0 * state.z).real))
    assert np.max(np.abs(x)) == pytest.approx(0.15052, abs=5e-6)


def test_every_erratum_of_a_formula_stands_among_the_printed_forms():
    """E8 is about words."""
    assert {erratum for *_, erratum in FORMS} == {f"E{i}" for i in range(1, 12)} - {"E8"}
