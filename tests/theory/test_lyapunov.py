"""Lyapunov's method: V' is -B v^2, the claims stand up to sampled motions, and what cannot be claimed is refused."""

import math
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import strainwave as sw
from strainwave import maths

CSF = sw.PiecewiseLinear(2.0, 3.0, 4.0, 0.5, 1.5)
LAWS = {
    "linear": sw.Linear(1.0),
    "hardening": sw.Cubic(1.0, 0.3),
    "softening": sw.Cubic(1.0, -0.5),
    "one-sided": sw.Polynomial((0.0, 1.0, 0.4)),
    "quintic": sw.Polynomial((0.0, 1.0, 0.0, -0.4, 0.0, 0.1)),
    "piecewise": CSF,
    "backlash": sw.Backlash(1.0, 0.5),
    "play": sw.Play(0.3, sw.Cubic(1.0, 0.3)),
    "rounded": sw.laws.RoundedPiecewiseLinear(*CSF, 0.1),
    "table": sw.tabulated([(-1.0, -2.0), (0.0, 0.0), (0.4, 0.0), (1.5, 1.0)]),
}


class Tanh(NamedTuple):
    """A user's own law: T = K b tanh(x/b), of which the package knows nothing."""

    K: float
    b: float

    def torque(self, x):
        e = maths.exp(-2.0 * x / self.b)
        return self.K * self.b * (1.0 - e) / (1.0 + e)

    def stiffness(self, x):
        t = self.torque(x) / (self.K * self.b)
        return self.K * (1.0 - t * t)

    def energy(self, x):
        return self.K * self.b**2 * math.log(math.cosh(x / self.b))


def oscillator(law, B=0.1, mean=0.0):
    return sw.Oscillator(1.5, B, law, sw.Harmonic(0.7, mean=mean), 1.3)


PARTS = st.integers(0, 10**9).map(lambda part: part / 1e9)  # models refuse numbers next to nothing

# --- V and V' ---


@pytest.mark.parametrize("name", sorted(LAWS))
@given(x=st.floats(-2, 2), v=st.floats(-3, 3), part=PARTS, other=PARTS)
def test_rate_of_v_along_the_flow_is_minus_b_v_squared(name, x, v, part, other):
    B, mean = 2.0 * part, 0.1 * other - 0.05
    proof = sw.lyapunov(oscillator(LAWS[name], B, mean))
    assert proof.holds
    rate_x, rate_v = proof.system.rhs(0.0, (x, v))
    h = 1e-5
    along = proof.V(x + h * rate_x, v + h * rate_v) - proof.V(x - h * rate_x, v - h * rate_v)
    # central difference: second order inside a smooth piece, first order across a breakpoint
    assert along / (2 * h) == pytest.approx(proof.dissipation(x, v), abs=1e-3)
    assert proof.dissipation(x, v) == pytest.approx(-B * v * v)


@pytest.mark.parametrize("name", sorted(LAWS))
def test_v_is_zero_at_rest_and_positive_inside_the_region(name):
    proof = sw.lyapunov(oscillator(LAWS[name], mean=0.02))
    rest = proof.rest[0]
    assert proof.V(rest, 0.0) == pytest.approx(0.0, abs=1e-15)
    x, v = np.meshgrid(np.linspace(-1, 1, 41), np.linspace(-1, 1, 21))
    inside = (np.abs(x - rest) > 1e-3) & (proof.region.x_low < x) & (x < proof.region.x_high)
    assert np.sum(inside) > 300
    assert np.all(proof.V(x, v)[inside] > 0.0)


def test_periodic_torque_and_kinematic_error_are_set_aside():
    error = sw.KinematicError((sw.Line(2, 0.1),))
    terms = sw.Harmonics((sw.Harmonic(1.0, 2, mean=0.2), sw.Harmonic(3.0, 1, 0.4, mean=0.1)))
    proof = sw.lyapunov(sw.Oscillator(1.0, 0.1, sw.Linear(2.0), terms, 1.0, error))
    assert proof.tau_0 == pytest.approx(0.3)
    assert proof.rest == pytest.approx((0.15, 0.15))
    assert "set aside" in str(proof)
    phases = np.linspace(0.0, 6.0, 7)
    assert np.allclose(proof.system.rhs(phases, (0.15, 0.0))[1], 0.0)


def test_mean_of_an_unknown_excitation_is_taken_over_a_turn():
    class Clipped(NamedTuple):
        level: float

        def torque(self, angle):
            return self.level + maths.cos(angle) + 0.5 * maths.cos(2 * angle)

    proof = sw.lyapunov(sw.Oscillator(1.0, 0.1, sw.Linear(2.0), Clipped(0.5), 1.0))
    assert proof.tau_0 == pytest.approx(0.5, abs=1e-13)


# --- scopes and regions ---


@pytest.mark.parametrize("law", [sw.Linear(3), sw.Cubic(1, 0), sw.Cubic(1, 2), CSF, sw.Polynomial((0, 1, 0, 1, 0, 1))])
@pytest.mark.parametrize("mean", [0.0, 0.8, -2.5])
def test_hardening_laws_are_globally_asymptotically_stable(law, mean):
    proof = sw.lyapunov(oscillator(law, mean=mean))
    assert (proof.holds, proof.scope, proof.asymptotic) == (True, "global", True)
    assert law.torque(proof.rest[0]) == pytest.approx(mean, abs=1e-14)
    assert (proof.region.x_low, proof.region.x_high, proof.region.energy_limit) == (-math.inf, math.inf, math.inf)
    assert "radially unbounded" in proof.reason
    assert "LaSalle" in proof.reason


def test_the_drive_of_the_article_is_globally_stable():
    proof = sw.lyapunov(sw.HDC_40_050.error_equation(motor_torque=sw.Harmonic(10.0)))
    assert (proof.scope, proof.rest) == ("global", (0.0, 0.0))


@given(K=st.floats(1e-2, 1e6), alpha=st.floats(-1e6, -1e-4))
def test_softening_region_ends_at_the_saddles(K, alpha):
    proof = sw.lyapunov(oscillator(sw.Cubic(K, alpha)))
    edge = 1.0 / math.sqrt(-alpha)
    assert (proof.holds, proof.scope, proof.asymptotic) == (True, "local", True)
    assert proof.region.x_low == pytest.approx(-edge, rel=1e-12)
    assert proof.region.x_high == pytest.approx(edge, rel=1e-12)
    assert proof.region.energy_limit == pytest.approx(K / (4.0 * -alpha), rel=1e-12)
    assert proof.contains(0.999 * edge, 0.0)
    assert not proof.contains(1.001 * edge, 0.0)


def test_mean_torque_lowers_the_saddle_of_a_softening_law_on_its_side():
    balanced, pulled = (sw.lyapunov(oscillator(sw.Cubic(1.0, -0.5), mean=mean)) for mean in (0.0, 0.2))
    law = sw.Cubic(1.0, -0.5)
    for x in (*pulled.equilibria, pulled.rest[0]):
        assert law.torque(x) == pytest.approx(0.2, abs=1e-14)
    assert pulled.region.x_high < balanced.region.x_high
    assert pulled.region.energy_limit == pytest.approx(pulled.V(pulled.region.x_high, 0.0))
    assert pulled.region.energy_limit < min(balanced.region.energy_limit, pulled.V(pulled.region.x_low, 0.0))


def test_one_saddle_bounds_one_side_only():
    # T = x + 0.4 x^2: saddle at x = -2.5, U there = 2.5^2/2 - 0.4 2.5^3/3
    proof = sw.lyapunov(oscillator(LAWS["one-sided"]))
    assert (proof.scope, proof.region.x_high) == ("local", math.inf)
    assert proof.region.x_low == pytest.approx(-2.5)
    assert proof.region.energy_limit == pytest.approx(2.5**2 / 2 - 0.4 * 2.5**3 / 3)


def test_a_law_that_softens_but_never_turns_is_global():
    # T = x - 0.4 x^3 + 0.1 x^5: x^4 - 4 x^2 + 10 has no real root
    assert sw.lyapunov(oscillator(LAWS["quintic"])).scope == "global"


@pytest.mark.parametrize("coefficients", [(0, 0, 0, 1.0), (-1.0, 3.0, -3.0, 1.0), (-0.027, 0.27, -0.9, 1.0)])
def test_a_triple_root_is_one_rest(coefficients):
    # (x - 1)^3 and (x - 0.3)^3: numpy spreads the roots by the cube root of the rounding error
    proof = sw.lyapunov(oscillator(sw.Polynomial(coefficients)))
    assert proof.scope == "global"
    assert len(proof.equilibria) == 1


def test_small_root_beside_large_ones_is_exact():
    proof = sw.lyapunov(oscillator(sw.Cubic(1.0, -1e-14), mean=1e-6))
    assert proof.rest[0] == pytest.approx(1e-6, rel=1e-14)


def test_backlash_converges_to_the_gap_as_a_set():
    proof = sw.lyapunov(oscillator(sw.Backlash(2.0, 0.3)))
    assert (proof.holds, proof.scope, proof.rest) == (True, "set", (-0.3, 0.3))
    assert proof.region.energy_limit == math.inf
    assert proof.V(np.array([-0.3, 0.0, 0.2]), 0.0) == pytest.approx(0.0)


def test_backlash_under_a_mean_torque_rests_at_a_point():
    proof = sw.lyapunov(oscillator(sw.Backlash(2.0, 0.3), mean=-0.5))
    assert (proof.scope, proof.rest) == ("global", pytest.approx((-0.55, -0.55)))


def test_backlash_without_gap_is_a_linear_spring():
    assert sw.lyapunov(oscillator(sw.Backlash(2.0, 0.0))).scope == "global"


@pytest.mark.parametrize("name", sorted(LAWS))
def test_without_damping_rest_is_stable_but_nothing_decays(name):
    proof = sw.lyapunov(oscillator(LAWS[name], B=0.0))
    assert proof.holds
    assert not proof.asymptotic
    assert "not asymptotically" in proof.claim
    assert "V' = 0" in proof.reason
    assert "decays" not in proof.claim


def test_proof_prints_function_region_and_argument():
    text = str(sw.lyapunov(oscillator(sw.Cubic(1.0, -0.25), mean=0.01)))
    for part in ("J v^2/2 + U(x) - tau_0 x", "V' = -B v^2", "claim (local)", "region:", "LaSalle", "mean torque 0.01"):
        assert part in text


# --- what is refused ---


def refusal(law, B=0.1, mean=0.0, **options):
    proof = sw.lyapunov(oscillator(law, B, mean), **options)
    assert (proof.holds, proof.scope, proof.region, proof.rest) == (False, "none", None, None)
    assert not proof.contains(0.0, 0.0)
    assert "nothing is claimed" in str(proof)
    return proof


def test_negative_damping_is_refused():
    assert "gain energy" in refusal(sw.Linear(1.0), B=-0.01).reason


@pytest.mark.parametrize(
    "law", [sw.Linear(-1.0), sw.Cubic(-1.0, 1.0), sw.Polynomial((0.0, -3.0)), sw.Backlash(-1.0, 0.0)]
)
def test_negative_stiffness_at_the_equilibrium_is_refused(law):
    proof = refusal(law)
    assert "stiffness at the equilibrium x = 0 rad is -" in proof.reason
    assert proof.equilibria == (0.0,)


def test_two_wells_are_refused_and_named():
    proof = refusal(sw.Cubic(-1.0, -1.0))
    assert proof.equilibria == pytest.approx((-1.0, 0.0, 1.0))
    assert "2 wells, at x = -1 rad, x = 1 rad" in proof.reason
    assert "near=" in proof.reason


def test_one_of_several_wells_can_be_asked_for():
    proof = sw.lyapunov(oscillator(sw.Cubic(-1.0, -1.0)), near=0.4)
    assert (proof.scope, proof.rest, proof.region.x_low) == ("local", pytest.approx((1.0, 1.0)), pytest.approx(0.0))
    assert proof.region.energy_limit == pytest.approx(0.25)  # U = -x^2/2 + x^4/4


def test_a_torsion_outside_every_well_is_refused():
    assert "lies in no well" in refusal(sw.Cubic(1.0, -0.25), near=3.0).reason


def test_torque_beyond_the_strength_of_the_law_is_refused():
    # largest torque of x - x^3/2: 2/3 sqrt(2/3) = 0.544
    assert sw.lyapunov(oscillator(sw.Cubic(1.0, -0.5), mean=0.54)).holds
    assert "0.55 N*m" in refusal(sw.Cubic(1.0, -0.5), mean=0.55).reason
    assert "no equilibrium" in refusal(sw.Polynomial((0.0, 1.0, 1.0)), mean=-0.5).reason


@pytest.mark.parametrize("law", [sw.Linear(0.0), sw.Cubic(0.0, 1.0), sw.Polynomial((0.0,)), sw.Backlash(0.0, 0.2)])
def test_a_law_without_torque_is_refused(law):
    assert "no restoring torque" in refusal(law).reason
    assert "no equilibrium" in refusal(law, mean=1.0).reason


def test_a_rest_that_attracts_from_one_side_only_is_refused():
    assert "pushes back from both sides" in refusal(sw.Polynomial((0.0, 0.0, 1.0))).reason


def test_parameters_that_are_not_finite_or_out_of_range_are_named():
    with pytest.raises(ValueError, match=r"Cubic\.alpha"):
        sw.lyapunov(oscillator(sw.Cubic(1.0, math.nan)))
    with pytest.raises(ValueError, match="inertia must be positive"):
        sw.lyapunov(oscillator(sw.Linear(1.0))._replace(J=0.0))
    with pytest.raises(ValueError, match=r"near \(a torsion in rad\) is nan; it must be a finite number"):
        sw.lyapunov(oscillator(sw.Linear(1.0)), near=math.nan)


# --- a law that the package does not know ---


def test_own_law_is_claimed_locally_and_only_as_checked():
    proof = sw.lyapunov(oscillator(Tanh(1.0, 0.5), mean=0.1), span=2.0)
    assert (proof.holds, proof.scope) == (True, "local")
    assert proof.rest[0] == pytest.approx(0.5 * math.atanh(0.2), rel=1e-12)
    assert (proof.region.x_low, proof.region.x_high) == (-2.0, 2.0)
    assert proof.region.energy_limit == pytest.approx(proof.V(2.0, 0.0))
    assert "not proved" in proof.reason
    assert "4001 samples" in proof.reason


def test_own_law_needs_a_span():
    assert "span=" in refusal(Tanh(1.0, 0.5)).reason
    for span in (0.0, -1.0, math.inf, math.nan):
        with pytest.raises(ValueError, match="span"):
            sw.lyapunov(oscillator(Tanh(1.0, 0.5)), span=span)


def test_own_law_that_never_balances_the_torque_is_refused():
    assert "on |x| <= 2 rad" in refusal(Tanh(1.0, 0.5), mean=0.6, span=2.0).reason


def test_own_law_without_energy_or_with_a_wrong_one_is_refused():
    class NoEnergy(NamedTuple):
        K: float

        def torque(self, x):
            return self.K * x

    class WrongEnergy(NamedTuple):
        K: float

        def torque(self, x):
            return self.K * x

        def energy(self, x):
            return self.K * x * x

    assert "no method energy" in refusal(NoEnergy(1.0), span=1.0).reason
    assert "not the integral of its torque" in refusal(WrongEnergy(1.0), span=1.0).reason


class Quintic(NamedTuple):
    """A user's own law that says its coefficients."""

    K: float
    a3: float
    a5: float

    def torque(self, x):
        return x * (self.K + x * x * (self.a3 + x * x * self.a5))

    def stiffness(self, x):
        return self.K + x * x * (3.0 * self.a3 + 5.0 * x * x * self.a5)

    def polynomial(self):
        return (0.0, self.K, 0.0, self.a3, 0.0, self.a5)


class Rising(Tanh):
    """A user's own law that says that it never falls."""

    def torque(self, x):
        return self.K * self.b * maths.tanh(x / self.b)

    def turning_points(self):
        return ()


@pytest.mark.parametrize("mean", [0.0, 0.02, 0.9])
@pytest.mark.parametrize("a3", [0.3, -0.4, -1.1])
def test_own_law_that_says_its_coefficients_is_proved_as_the_polynomial(a3, mean):
    own = sw.lyapunov(oscillator(Quintic(1.0, a3, 0.1), mean=mean), near=0.0)
    known = sw.lyapunov(oscillator(sw.Polynomial((0.0, 1.0, 0.0, a3, 0.0, 0.1)), mean=mean), near=0.0)
    assert (own.scope, own.claim, own.reason) == (known.scope, known.claim, known.reason)
    assert own.equilibria == pytest.approx(known.equilibria, rel=1e-12)
    assert own.V(0.3, 0.2) == pytest.approx(known.V(0.3, 0.2), rel=1e-12)
    assert sw.small_signal(Quintic(1.0, a3, 0.1), 0.0).cubic == pytest.approx(a3, rel=1e-12)


def test_own_law_that_says_that_it_never_falls_is_proved_for_all_starts():
    proof = sw.lyapunov(oscillator(Rising(1.0, 0.5), mean=0.1))
    assert (proof.holds, proof.scope) == (True, "global")
    assert proof.rest[0] == pytest.approx(0.5 * math.atanh(0.2), rel=1e-12)
    assert "never balances" in refusal(Rising(1.0, 0.5), mean=0.6).reason


def test_own_law_that_says_what_its_torque_does_not_is_refused():
    class Falling(Quintic):
        def energy(self, x):
            return x * x * (self.K / 2.0 + x * x * (self.a3 / 4.0 + x * x * self.a5 / 6.0))

        def torque(self, x):
            return super().torque(x)

        def turning_points(self):
            return ()

    assert "turns at another torsion" in refusal(Falling(1.0, -3e4, 0.0)).reason

    class Wrong(Quintic):
        def torque(self, x):
            return super().torque(x)

        def polynomial(self):
            return (0.0, self.K)

    with pytest.raises(ValueError, match=r"polynomial gives .* its torque is .* must give the coefficients"):
        sw.lyapunov(oscillator(Wrong(1.0, 0.3, 0.1)))


def test_a_changed_subclass_is_not_taken_for_the_package_s_law():
    class Changed(sw.Linear):
        def torque(self, x):
            return -self.K * x

        def stiffness(self, x):
            return -self.K

        def energy(self, x):
            return -self.K * x * x / 2

    assert refusal(Changed(1.0), span=1.0).equilibria == (0.0,)


def test_own_law_with_a_gap_converges_to_the_whole_gap():
    class Play(NamedTuple):
        K: float
        gap: float

        def torque(self, x):
            return self.K * (x - 0.5 * (abs(x + self.gap) - abs(x - self.gap)))

        def energy(self, x):
            return 0.5 * self.torque(x) ** 2 / self.K

    proof = sw.lyapunov(oscillator(Play(2.0, 0.123456)), span=1.0)
    assert proof.rest == pytest.approx((-0.123456, 0.123456), abs=1e-12)


# --- attack by sampling ---


def starts(proof, count, level, seed):
    """States at the fraction `level` of the energy limit (of 2 J where there is none), in the region, all around."""
    rng = np.random.default_rng(seed)
    limit = level * min(proof.region.energy_limit, 2.0)
    found = []
    while len(found) < count:
        x = rng.uniform(max(proof.region.x_low, -3.0), min(proof.region.x_high, 3.0))
        potential = proof.V(x, 0.0)
        if potential < limit:
            v = math.sqrt(2.0 * (limit - potential) / proof.system.J) * rng.choice([-1.0, 1.0])
            found.append((x, v))
    return found


@pytest.mark.slow
@pytest.mark.parametrize("mean", [0.0, 0.1])
@pytest.mark.parametrize("name", sorted(LAWS))
def test_every_sampled_motion_from_the_region_decays_to_the_claimed_rest(name, mean):
    proof = sw.lyapunov(oscillator(LAWS[name], B=0.15, mean=mean))
    for x, v in starts(proof, 20, 0.5, seed=1) + starts(proof, 40, 0.9999, seed=2):
        assert proof.contains(x, v)
        motion = sw.simulate(proof.system, (x, v), 300.0)
        assert motion.status
        energy = proof.V(*motion.y)
        assert np.max(np.diff(energy)) <= 1e-8 * energy[0]
        assert energy[-1] <= 1e-6 * energy[0]
        assert proof.rest[0] - 1e-2 <= motion.y[0, -1] <= proof.rest[1] + 1e-2
        assert abs(motion.y[1, -1]) < 1e-2


@pytest.mark.slow
@pytest.mark.parametrize("mean", [0.0, 0.1])
def test_motions_started_just_outside_the_softening_region_escape(mean):
    proof = sw.lyapunov(oscillator(LAWS["softening"], B=1e-4, mean=mean))
    saddle = proof.region.x_high
    assert proof.V(saddle, 0.0) == pytest.approx(proof.region.energy_limit)
    beyond = [(1.001 * saddle, 0.0)]
    for x in np.linspace(-0.5, 0.99, 9) * saddle:  # outwards with 0.5 % more energy than the saddle
        beyond.append((x, math.sqrt(2.0 * (1.005 * proof.region.energy_limit - proof.V(x, 0.0)) / proof.system.J)))
    for x, v in beyond:
        assert not proof.contains(x, v)
        motion = sw.simulate(proof.system, (x, v), 300.0)
        assert motion.status is sw.Status.DIVERGED
    # with 0.5 % less they stay
    x, v = proof.rest[0], math.sqrt(2.0 * 0.995 * proof.region.energy_limit / proof.system.J)
    assert sw.simulate(proof.system, (x, v), 300.0).status


@pytest.mark.slow
def test_one_well_of_two_keeps_its_motions_and_loses_those_above_its_saddle():
    proof = sw.lyapunov(oscillator(sw.Cubic(-1.0, -1.0), B=0.01), near=1.0)
    fast = [math.sqrt(2.0 * share * proof.region.energy_limit / proof.system.J) for share in (0.99, 1.2)]
    kept, lost = (sw.simulate(proof.system, (1.0, -v), 10.0) for v in fast)
    assert np.min(kept.y[0]) > 0.0
    assert np.min(lost.y[0]) < 0.0
