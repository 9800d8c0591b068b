"""Harmonic balance of a user's own systems with `rhs(phase, y)`: internal states, laws with memory, Neimark-Sacker."""

from typing import NamedTuple

import numpy as np
import pytest
from canonical import DISSIPATIVE

import strainwave as sw
from strainwave.compile.tree import leaf_of
from strainwave.maths import cos, sign
from strainwave.numerics.balance.choice import balance_of
from strainwave.numerics.balance.first_order import FirstOrder, first_order
from strainwave.numerics.balance.fourier import analysis, derivative, synthesis
from strainwave.numerics.balance.rates import jacobians_at, number_of_states, rates_at
from strainwave.numerics.continuation.trace import solve
from strainwave.numerics.stability.first_order import multipliers_of, period_maps


class Duffing(NamedTuple):
    """J = K = 1; written as a user would, without a Jacobian."""

    B: float
    alpha: float
    mean: float
    amplitude: float
    omega: float

    def rhs(self, phase, y):
        x, v = y
        return v, self.mean + self.amplitude * cos(phase) - self.B * v - x - self.alpha * x * x * x


class Zener(NamedTuple):
    """A spring beside a Maxwell element (spring G, relaxation time r); s is the torque of the latter."""

    J: float
    K: float
    G: float
    r: float
    mean: float
    amplitude: float
    omega: float

    def rhs(self, phase, y):
        x, v, s = y
        return v, (self.mean + self.amplitude * cos(phase) - self.K * x - s) / self.J, self.G * v - s / self.r

    def jacobian(self, phase, y):
        one = 1.0 + 0.0 * y[0]
        return (
            (0.0 * one, one, 0.0 * one),
            (-self.K / self.J * one, 0.0 * one, -one / self.J),
            (0.0 * one, self.G * one, -one / self.r),
        )


class BoucWen(NamedTuple):
    """T = a K x + (1 - a) K z, z' = A v - |z/x_y|^n (beta |v| sign z + gamma v) with n = 1; x_y is the yield twist."""

    J: float
    B: float
    K: float
    a: float
    x_y: float
    A: float
    beta: float
    gamma: float
    amplitude: float
    omega: float

    def rhs(self, phase, y):
        x, v, z = y
        torque = self.a * self.K * x + (1.0 - self.a) * self.K * z
        memory = self.A * v - abs(z / self.x_y) * (self.beta * abs(v) * sign(z) + self.gamma * v)
        return v, (self.amplitude * cos(phase) - self.B * v - torque) / self.J, memory


class VanDerPol(NamedTuple):
    """x'' - mu (1 - x^2) x' + x = F cos(phase)."""

    mu: float
    F: float
    omega: float

    def rhs(self, phase, y):
        x, v = y
        return v, self.mu * (1.0 - x * x) * v - x + self.F * cos(phase)


DUFFING = Duffing(0.1, 0.05, 0.0, 1.0, 1.0)
ZENER = Zener(0.6, 1e5, 6e4, 2e-3, 40.0, 25.0, 350.0)
BOUC_WEN = BoucWen(1.0, 0.05, 1.0, 0.3, 0.5, 1.0, 0.6, 0.4, 0.3, 0.9)


def same_oscillator(system):
    excitation = sw.Harmonic(system.amplitude, mean=system.mean)
    return sw.Oscillator(1.0, system.B, sw.Cubic(1.0, system.alpha), excitation, system.omega)


def test_states_are_counted_by_trying():
    assert number_of_states(DUFFING) == 2
    assert number_of_states(ZENER) == 3


def test_a_system_of_the_form_of_an_oscillator_is_balanced_on_its_torsion_alone():
    assert isinstance(balance_of(DUFFING, 4, 4, 5), FirstOrder)
    oscillator = same_oscillator(DUFFING)
    leaf = leaf_of(oscillator, "omega")
    assert not isinstance(balance_of(oscillator, leaf, leaf, 5), FirstOrder)


def test_the_jacobian_is_the_derivative_of_the_residual():
    problem = first_order(BOUC_WEN, 9, 9, 6)
    rng = np.random.default_rng(1)
    z = np.append(0.3 * rng.standard_normal(problem.size()), 0.9)
    a, slope = np.empty((len(z) - 1, len(z) - 1)), np.empty(len(z) - 1)
    problem.linearise(z, a, slope)
    full, d = np.column_stack([a, slope]), 1e-6
    for j in range(len(z)):
        r = np.empty((2, len(z) - 1))
        for i, step in enumerate((d, -d)):
            moved = z.copy()
            moved[j] += step
            problem.residual(moved, r[i])
        # |v| and |z| have kinks, which samples near them show in the difference quotient
        assert (r[0] - r[1]) / (2.0 * d) == pytest.approx(full[:, j], abs=2e-4)


@pytest.mark.parametrize("law", [DISSIPATIVE["BoucWen"], DISSIPATIVE["LuGre"]])
def test_the_residual_of_a_law_with_memory_is_its_integral_however_few_the_harmonics(law):
    system = sw.Oscillator(1.0, 0.05, sw.Parallel(sw.Linear(1.0), law), sw.Harmonic(0.4), 1.2)
    leaf = leaf_of(system, "omega")
    problem = first_order(system, leaf, leaf, 3)
    z = np.append(np.random.default_rng(4).standard_normal(problem.size()), 1.2)
    r = np.empty(problem.size())
    problem.residual(z, r)
    fine = 1 << 16
    y = problem.series(z[None])[0]
    angles = 2.0 * np.pi * np.arange(fine) / fine
    rates = rates_at(system, angles, y @ synthesis(3, fine)) @ analysis(3, fine)
    assert np.ptp(np.sign((y @ synthesis(3, fine))[1])) > 0.0  # the rate changes its sign
    whole = ((1.2 * derivative(y) - rates) / problem.sizes[:, None]).ravel()
    assert r == pytest.approx(whole, rel=1e-7, abs=1e-7 * np.max(np.abs(whole)))


@pytest.mark.slow
@pytest.mark.parametrize("mean", [0.0, 0.7])
def test_duffing_with_two_states_has_the_folds_of_the_oscillator(mean):
    system = DUFFING._replace(mean=mean)
    general = sw.frequency_response(system, (0.3, 3.0), harmonics=9)
    torsion = sw.frequency_response(same_oscillator(system), (0.3, 3.0), harmonics=9)
    assert general.status
    assert [f.value for f in general.folds] == pytest.approx([f.value for f in torsion.folds], rel=1e-9)
    for one, other in zip(general.folds, torsion.folds, strict=True):
        # the frequency is flat in the amplitude there, which is therefore known to half as many digits
        assert one.coefficients == pytest.approx(other.coefficients, rel=1e-5, abs=1e-5)


def test_duffing_with_two_states_has_the_orbit_of_the_oscillator():
    general, torsion = (first_order(DUFFING._replace(mean=0.4), 4, 4, 9), same_oscillator(DUFFING._replace(mean=0.4)))
    orbit = sw.find_orbit(torsion._replace(omega=2.0), harmonics=9)
    point = solve(general, general.linear_response(2.0))
    series = general.series(point[None])[0]
    assert np.hypot(series[0, 1], series[0, 10]) == pytest.approx(orbit.amplitude(1), rel=1e-9)
    assert series[0, 0] == pytest.approx(orbit.amplitude(0), rel=1e-9)
    found = multipliers_of(period_maps(general, point[None, :])[0])[0]
    assert np.sort_complex(found) == pytest.approx(np.sort_complex(orbit.multipliers), abs=1e-7)


def test_zener_element_has_its_closed_form():
    branch = sw.frequency_response(ZENER, (100.0, 900.0), harmonics=3)
    w = branch.omega
    maxwell = ZENER.G * 1j * w * ZENER.r / (1.0 + 1j * w * ZENER.r)
    x = ZENER.amplitude / (ZENER.K - ZENER.J * w * w + maxwell)
    assert branch.status
    assert branch.coefficients[:, 1] == pytest.approx(x.real, rel=1e-9, abs=1e-9 * np.max(np.abs(x)))
    assert branch.coefficients[:, 2] == pytest.approx(-x.imag, rel=1e-9, abs=1e-9 * np.max(np.abs(x)))
    assert branch.amplitude(0) == pytest.approx(ZENER.mean / ZENER.K, rel=1e-9)
    # the exact multipliers are those of a constant matrix
    rates = np.linalg.eigvals(np.array(ZENER.jacobian(0.0, (0.0, 0.0, 0.0))))
    exact = np.exp(rates * 2.0 * np.pi / w[0])
    assert np.sort(np.abs(branch.multipliers[0])) == pytest.approx(np.sort(np.abs(exact)), rel=1e-8)


@pytest.mark.slow
def test_bouc_wen_agrees_with_integration():
    orbit = sw.find_orbit(BOUC_WEN, harmonics=31)
    turn = 2.0 * np.pi / BOUC_WEN.omega
    motion = sw.simulate(BOUC_WEN, (0.0, 0.0, 0.0), [0.0, *(turn * (60.0 + np.arange(64) / 64))])
    assert orbit.status
    # the kinks of |v| and |z| in z' leave harmonics of z that fall as 1/k^2 to 1/k^3
    assert orbit.state(2.0 * np.pi * np.arange(64) / 64) == pytest.approx(motion.y[:, 1:], abs=2e-4)
    assert orbit.stable


@pytest.mark.parametrize("system", [DUFFING, ZENER, BOUC_WEN], ids=["Duffing", "Zener", "Bouc-Wen"])
def test_the_period_map_has_liouvilles_determinant(system):
    leaf = leaf_of(system, "omega")
    problem = first_order(system, leaf, leaf, 15)
    point = solve(problem, problem.linear_response(system.omega))
    samples = 4096
    y = problem.series(point[None])[0] @ synthesis(15, samples)
    matrices = jacobians_at(system, 2.0 * np.pi * np.arange(samples) / samples, y, problem.sizes)
    trace = np.mean(np.trace(matrices)) * 2.0 * np.pi / system.omega
    tolerance = 2e-2 if system is BOUC_WEN else 1e-9  # the Jacobian of Bouc-Wen jumps, which no step resolves
    assert np.linalg.det(period_maps(problem, point[None, :])[0][0]) == pytest.approx(np.exp(trace), rel=tolerance)


@pytest.mark.slow
def test_neimark_sacker_points_of_van_der_pol_lie_where_averaging_puts_them():
    # averaging x = A cos: the trace of the slow flow is mu (1 - A^2/2); the torus is born at A = sqrt 2 up to O(mu^2)
    found = {}
    for mu in (0.1, 0.05):
        branch = sw.frequency_response(VanDerPol(mu, 3.0 * mu, 1.0), (0.6, 1.5), harmonics=7)
        assert branch.status
        assert len(branch.tori) == 2
        for orbit in branch.tori:
            assert orbit.label == "Neimark-Sacker"
            assert np.abs(orbit.multipliers) == pytest.approx([1.0, 1.0], abs=1e-8)
            assert abs(orbit.multipliers[0].imag) > 1e-3
        found[mu] = [orbit.amplitude(1) for orbit in branch.tori]
    for coarse, fine in zip(found[0.1], found[0.05], strict=True):
        assert fine == pytest.approx(np.sqrt(2.0), rel=2e-2)
        assert abs(fine - np.sqrt(2.0)) < 0.6 * abs(coarse - np.sqrt(2.0))


@pytest.mark.slow
def test_stability_changes_at_the_neimark_sacker_points():
    branch = sw.frequency_response(VanDerPol(0.1, 0.3, 1.0), (0.6, 1.5), harmonics=7)
    low, high = sorted(orbit.value for orbit in branch.tori)
    clear = np.abs((branch.values - low) * (branch.values - high)) > 1e-6
    inside = (branch.values > low) & (branch.values < high)
    assert np.array_equal(branch.stable[clear], inside[clear])


class Cornered(NamedTuple):
    """J = 1 with a spring of slope 1 up to |x| = 1 and 3 beyond."""

    B: float
    amplitude: float
    omega: float

    def rhs(self, phase, y):
        x, v = y
        outer = abs(x - 1.0) - abs(x + 1.0)
        return v, self.amplitude * cos(phase) - self.B * v - 3.0 * x - outer

    def breakpoints(self):
        return (-1.0, 1.0)


@pytest.mark.slow
def test_a_general_system_with_corners_has_the_folds_and_multipliers_of_its_error_equation():
    """The crossings of an oscillator are integrated in closed form; here by Gauss's rule between them."""
    general = Cornered(0.1, 0.5, 1.0)
    law = sw.PiecewiseLinear(1.0, 3.0 - 1e-12, 3.0, 1.0, 1e6)
    oscillator = sw.Oscillator(1.0, 0.1, law, sw.Harmonic(0.5), 1.0)
    exact = sw.frequency_response(oscillator, (0.6, 2.0), harmonics=9)
    curve = sw.frequency_response(general, (0.6, 2.0), harmonics=9, points=60)
    assert [f.omega for f in curve.folds] == pytest.approx([f.omega for f in exact.folds], rel=1e-8)
    assert len(exact.folds) == 2
    for omega in (1.0, 1.2, 1.9):
        orbit = sw.find_orbit(general._replace(omega=omega), harmonics=9)
        other = sw.find_orbit(oscillator._replace(omega=omega), harmonics=9)
        assert orbit.peak == pytest.approx(other.peak, rel=1e-8)
        assert np.sort_complex(orbit.multipliers) == pytest.approx(np.sort_complex(other.multipliers), rel=1e-7)


class Undefined(NamedTuple):
    """Has no rates at rest."""

    omega: float

    def rhs(self, phase, y):
        x, v = y
        return v, -0.1 * v - np.sqrt(x - 1.0) + 0.1 * cos(phase)


def test_where_the_linear_response_is_no_number_the_guess_is_rest():
    # LAPACK raised LinAlgError and printed: `analyze` of a drive with hysteresis and a gap ended with it
    z = first_order(Undefined(2.0), 0, 0, 3).linear_response(2.0)
    assert z.tolist() == [0.0] * 14 + [2.0]
