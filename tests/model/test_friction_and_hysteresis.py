"""Laws with friction and memory: published formulas, what they store and lose, and what they refuse."""

import math

import numpy as np
import pytest
from canonical import DISSIPATIVE
from scipy.integrate import solve_ivp

import strainwave as sw
from strainwave.base.law import depends, energy_of, losses_of, states_of, torque_of, z_rate_of
from strainwave.base.quantities import checked

each_law = pytest.mark.parametrize("law", DISSIPATIVE.values(), ids=DISSIPATIVE.keys())


def random_states(law, count=50):
    """(x, v, z) that the laws can reach."""
    rng = np.random.default_rng(2)
    for _ in range(count):
        x, v = rng.uniform(-0.7, 0.7, 2)
        yield float(x), float(v), tuple(rng.uniform(-0.015, 0.015, states_of(law)).tolist())


@each_law
def test_torque_times_speed_is_the_rate_of_the_stored_energy_plus_the_losses(law):
    h = 1e-5
    for x, v, z in random_states(law):
        rates = z_rate_of(law, x, v, z)

        def stored(t, x=x, v=v, z=z, rates=rates):
            return energy_of(law, x + v * t, tuple(a + b * t for a, b in zip(z, rates, strict=True)))

        stored_rate = (stored(h) - stored(-h)) / (2.0 * h)
        power = torque_of(law, x, v, z) * v
        assert power == pytest.approx(stored_rate + sum(losses_of(law, x, v, z)), rel=1e-8, abs=1e-10)


@each_law
def test_nothing_creates_energy(law):
    for x, v, z in random_states(law):
        assert all(loss >= 0.0 for loss in losses_of(law, x, v, z))


@each_law
def test_stiffness_is_the_slope_of_the_torque_in_the_first_moment(law):
    rest, h = (0.0,) * states_of(law), 1e-7
    bend = z_rate_of(law, 0.0, 1e-9, rest)  # per 1e-9 rad/s
    ends = [torque_of(law, s * h, 0.0, tuple(s * h * 1e9 * b for b in bend)) for s in (1.0, -1.0)]
    assert (ends[0] - ends[1]) / (2.0 * h) == pytest.approx(law.stiffness(0.0), rel=1e-6, abs=1e-12)


def test_bouc_wen_with_beta_below_gamma_would_create_energy():
    law = sw.BoucWen(1.0, 0.0, 0.4, 1.0, 0.3, -0.5, 1)  # beta = 0.3 < |gamma| = 0.5
    assert law.losses(0.0, 1.0, (0.2,))[0] < 0.0
    with pytest.raises(ValueError, match=r"with \|gamma\| > beta it creates energy, use \|gamma\| <= beta"):
        checked(law)


@pytest.mark.parametrize("n", [1, 2])
def test_bouc_wen_loads_along_its_closed_form(n):
    # from z = 0 with v = 1: z' = A - (beta + gamma) (z/x_y)^n, an exponential for n = 1 and tanh for n = 2
    A, s, x_y = 1.3, 0.9, 0.2
    law = sw.BoucWen(1.0, 0.0, x_y, A, 0.5, 0.4, n)
    found = solve_ivp(lambda t, z: law.z_rate(t, 1.0, z), (0.0, 0.5), [0.0], method="DOP853", rtol=1e-12, atol=1e-14)
    if n == 1:
        exact = x_y * A / s * (1.0 - math.exp(-s * 0.5 / x_y))
    else:
        exact = x_y * math.sqrt(A / s) * math.tanh(math.sqrt(A * s) * 0.5 / x_y)
    assert found.y[0, -1] == pytest.approx(exact, rel=1e-10)


def test_bouc_wen_levels_off_where_the_rate_vanishes():
    for n in (1, 2, 5):
        law = sw.BoucWen(1.0, 0.0, 0.2, 1.3, 0.5, 0.4, n)
        z = 0.2 * (1.3 / 0.9) ** (1.0 / n)  # x_y (A/(beta + gamma))^(1/n)
        assert law.z_rate(0.0, 1.0, (z,))[0] == pytest.approx(0.0, abs=1e-14)


def test_lugre_at_a_steady_speed_is_the_stribeck_curve():
    law = sw.laws.LuGre(100.0, 1.0, 0.2, 0.6, 1.0, 0.1)
    for v in (-0.5, -0.05, 0.02, 0.1, 3.0):
        g = 0.6 + 0.4 * math.exp(-((v / 0.1) ** 2))
        z = g / 100.0 * math.copysign(1.0, v)  # where z' = 0
        assert law.z_rate(0.0, v, (z,))[0] == pytest.approx(0.0, abs=1e-14)
        assert law.torque(0.0, v, (z,)) == pytest.approx(math.copysign(g, v) + 0.2 * v, rel=1e-13)
    stribeck = sw.laws.Stribeck(0.6, 1.0, 0.1, 1e-9)
    assert stribeck.torque(0.0, 0.05) == pytest.approx(0.6 + 0.4 * math.exp(-0.25), rel=1e-12)


def test_lugre_loses_energy_always_if_viscous_friction_is_large_enough():
    # Barahanov & Ortega 2000: sigma_2 >= sigma_1 (T_s - T_c)/T_c, here 1 (1 - 0.6)/0.6 = 2/3
    v, z = np.meshgrid(np.linspace(-300.0, 300.0, 401), np.linspace(-0.01, 0.01, 101))  # |z| <= T_s/sigma_0
    enough, short = (sw.laws.LuGre(100.0, 1.0, s, 0.6, 1.0, 0.1).losses(0.0, v, (z,))[0] for s in (0.667, 0.4))
    assert np.min(enough) >= 0.0
    assert np.min(short) < 0.0


def test_coulomb_has_71_percent_at_its_width_and_99_5_at_ten_widths():
    law = sw.laws.Coulomb(2.0, 0.01)
    assert law.torque(0.0, 0.01) == pytest.approx(2.0 / math.sqrt(2.0), rel=1e-14)
    assert law.torque(0.0, -0.1) == pytest.approx(-2.0 * 0.995037190, rel=1e-9)


def test_viscous_friction_falls_by_3_5_percent_per_kelvin_and_grows_with_the_load():
    cold = sw.laws.Viscous(0.1)
    warm = sw.laws.Viscous(0.1, warming=20.0)
    assert warm.torque(0.0, 3.0) == pytest.approx(cold.torque(0.0, 3.0) * math.exp(-0.7), rel=1e-14)
    assert sw.laws.Viscous(0.1, load=-50.0, per_torque=0.01).torque(0.0, 1.0) == pytest.approx(0.15, rel=1e-14)


def test_parallel_gives_each_law_its_own_states():
    first, second = sw.BoucWen(1.0, 0.3, 0.4), sw.laws.LuGre(3.0, 0.1, 0.1, 0.03, 0.05, 0.3)
    both, x, v = sw.Parallel(first, second), 0.2, -0.1
    assert states_of(both) == 2
    assert depends(both) == 3
    assert both.torque(x, v, (0.1, 0.01)) == first.torque(x, v, (0.1,)) + second.torque(x, v, (0.01,))
    assert both.z_rate(x, v, (0.1, 0.01)) == (*first.z_rate(x, v, (0.1,)), *second.z_rate(x, v, (0.01,)))
    assert sw.Oscillator(1.0, 0.0, both, sw.Harmonic(1.0), 1.0).state_names() == ("x", "x'", "z1", "z2")


BOUC_WEN, LUGRE = sw.BoucWen(1.0, 0.3, 0.4), sw.laws.LuGre(3.0, 0.1, 0.1, 0.03, 0.05, 0.3)


@pytest.mark.parametrize(
    ("law", "sentence"),
    [
        (BOUC_WEN._replace(K=0.0), r"BoucWen\.K is 0; it must be positive"),
        (BOUC_WEN._replace(yield_twist=-1.0), r"BoucWen\.yield_twist is -1; it must be positive"),
        (BOUC_WEN._replace(A=0.0), r"BoucWen\.A is 0; it must be positive"),
        (BOUC_WEN._replace(ratio=1.2), r"BoucWen\.ratio is 1\.2; it is the elastic share of the torque, from 0 to 1"),
        (BOUC_WEN._replace(n=0), r"BoucWen\.n is 0; it must be a whole number of at least 1"),
        (BOUC_WEN._replace(n=51), r"BoucWen\.n is 51; it must be at most 50, whose knee is already within 2 %"),
        (BOUC_WEN._replace(n=1.5), r"BoucWen\.n must be a whole number, not 1\.5"),
        (BOUC_WEN._replace(beta=-0.5), r"with \|gamma\| > beta it creates energy"),
        (LUGRE._replace(T_s=0.02), r"LuGre has T_s = 0\.02 and T_c = 0\.03 N\*m; break-away takes at least"),
        (LUGRE._replace(sigma_0=0.0), r"LuGre\.sigma_0 is 0; it must be positive"),
        (LUGRE._replace(sigma_1=-1.0), r"LuGre\.sigma_1 is -1; it must not be negative"),
        (sw.laws.Coulomb(-1.0, 0.1), r"Coulomb\.T_c is -1; it must not be negative"),
        (sw.laws.Coulomb(1.0, -0.1), r"Coulomb\.width is -0\.1; it must not be negative"),
        (sw.laws.Stribeck(1.0, 2.0, 0.1, 0.2), r"the width must be smaller, or the break-away torque is never seen"),
        (sw.laws.Viscous(-1.0), r"Viscous\.B is -1; it must not be negative"),
        (
            sw.laws.Viscous(1.0, warming=-1e6),
            r"Viscous\.warming is -1e\+06 K, for 0\.035 1/K the factor exp\(3\.5e\+04\)",
        ),
    ],
)
def test_parameters_that_are_no_friction_are_refused_in_one_sentence(law, sentence):
    for model in (law, sw.Parallel(sw.Linear(1.0), law)):
        with pytest.raises(ValueError, match=sentence) as error:
            checked(model)
        assert "\n" not in str(error.value)


def test_the_sharpest_knee_is_within_2_percent_of_elastic_and_plastic():
    # dz/dx = 1 - z^50 from 0: z < min(x, 1), furthest from it at x = 1
    law = sw.BoucWen(1.0, 0.0, 1.0, n=50)
    x = np.linspace(0.0, 2.0, 2001)
    run = solve_ivp(lambda x, z: law.z_rate(x, 1.0, z), (0.0, 2.0), (0.0,), t_eval=x, max_step=0.01, rtol=1e-8)
    away = np.minimum(x, 1.0) - run.y[0]
    assert 0.01 < np.max(away) < 0.02


def test_laws_nested_without_end_are_refused():
    law = sw.Linear(1.0)
    for _ in range(400):
        law = sw.Parallel(sw.Linear(1.0), law)
    with pytest.raises(
        ValueError, match="Oscillator holds models nested more than 64 deep; put fewer laws side by side"
    ):
        sw.simulate(sw.Oscillator(1.0, 0.1, law, sw.Harmonic(1.0), 1.0), (0.0, 0.0), 1.0)
