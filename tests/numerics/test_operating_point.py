"""The operating point against roots of polynomials, Brent's method, closed forms and SciPy's integrator."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import strainwave as sw
from strainwave.numerics.operating_point import loaded_state, operating_point

SLOPES = sw.PiecewiseLinear(1e5, 1.4e5, 1.8e5, 54.0, 196.0)
SOFT = sw.Cubic(1e5, -1e6)  # largest torque 2/3 K/sqrt(3 |alpha|) = 38.4900 N*m at 1/sqrt(3 |alpha|) = 0.57735 mrad


def smallest_root(K, alpha, mean):
    """Root of K (x + alpha x^3) = mean nearest to zero, in units of mean/K so that all coefficients are near 1."""
    unit = mean / K
    roots = np.roots([alpha * unit * unit, 0.0, 1.0, -1.0])
    real = roots.real[np.abs(roots.imag) < 1e-6]
    return unit * real[np.argmin(np.abs(real))]


def cubics():
    """A thousand softening and hardening laws with mean torques, half of them close to the largest torque."""
    rng = np.random.default_rng(0)
    count = 1000
    a, K = rng.uniform(1e-3, 3e-3, count), rng.uniform(5e4, 2e5, count)
    short = np.where(rng.random(count) < 0.5, rng.uniform(0.05, 0.99, count), 10.0 ** rng.uniform(-10.0, -1.0, count))
    sign = rng.choice([-1.0, 1.0], count)
    alpha = np.where(np.arange(count) < 800, -1.0, 1.0) / a**2
    mean = sign * (1.0 - short) * 2.0 / 3.0 * K * a / math.sqrt(3.0)
    return sw.Cubic(K, alpha), mean, short


def test_operating_points_of_cubic_laws_are_the_roots_of_their_polynomials():
    laws, means, short = cubics()
    wanted = np.array([smallest_root(*numbers) for numbers in zip(*laws, means, strict=True)])
    found = np.array([operating_point(sw.Cubic(*numbers), mean) for *numbers, mean in zip(*laws, means, strict=True)])
    assert np.all(np.abs(found / wanted - 1.0) * np.sqrt(short) < 1e-12)  # two roots meet: rounding counts so much
    assert np.all(laws.stiffness(found) > 0.0)


RISING = {
    "three slopes": SLOPES,
    "rounded": sw.laws.RoundedPiecewiseLinear(*SLOPES, 2e-4),
    "table": sw.tabulated([(-3e-3, -400.0), (-1e-3, -90.0), (0.0, 0.0), (4e-4, 44.0), (1.2e-3, 130.0), (2e-3, 300.0)]),
    "backlash": sw.Backlash(1e5, 4e-4),
    "backlash before slopes": sw.Play(3e-4, SLOPES),
    "polynomial": sw.Polynomial((3.0, 1e5, 2e6, 7e9)),
    "hardening": sw.Cubic(1e5, 6.9e4),
}


@pytest.mark.parametrize("name", RISING)
def test_operating_points_of_rising_laws_are_those_of_brents_method(name):
    law = RISING[name]
    for mean in np.concatenate([-np.geomspace(400.0, 1e-3, 40), np.geomspace(1e-3, 400.0, 40)]):
        low, high = (-0.1, -law.half_gap if hasattr(law, "half_gap") else 0.1)
        if mean > 0.0:
            low, high = (law.half_gap if hasattr(law, "half_gap") else -0.1), 0.1
        wanted = brentq(lambda x, mean=mean: float(law.torque(x)) - mean, low, high, xtol=1e-18, rtol=1e-15)
        assert operating_point(law, mean) == pytest.approx(wanted, rel=1e-12, abs=1e-17)


def test_a_bump_that_no_sample_meets_is_found_at_its_summit():
    law = sw.Cubic(1.0, -1.0)
    largest = 2.0 / 3.0 / math.sqrt(3.0)
    for short in (1e-6, 1e-9, 1e-12):
        # near the summit at 1/sqrt(3), T = largest - sqrt(3) (x - x*)^2
        wanted = 1.0 / math.sqrt(3.0) - math.sqrt(short * largest / math.sqrt(3.0))
        assert operating_point(law, largest * (1.0 - short)) == pytest.approx(wanted, abs=2.0 * short + 1e-9)


@pytest.mark.parametrize(
    ("law", "mean", "sentence"),
    [
        (SOFT, 40.0, r"Cubic carries at most 38\.49 N\*m, at 0\.000577 rad, and the mean torque is 40 N\*m; lower"),
        (SOFT, -40.0, r"Cubic carries at most -38\.49 N\*m, at -0\.000577 rad, and the mean torque is -40 N"),
        (sw.Linear(0.0), 1.0, r"Linear carries at most 0 N\*m"),
        (sw.Play(1e-3, SOFT), 39.0, r"Play carries at most 38\.49 N\*m, at 0\.00158 rad"),
    ],
)
def test_a_torque_beyond_the_largest_is_refused_with_it(law, mean, sentence):
    with pytest.raises(ValueError, match=sentence) as refusal:
        operating_point(law, mean)
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize("short", [0.3, 1e-2, 1e-4])
def test_a_softening_law_with_memory_is_loaded_to_its_first_torque(short):
    """Oracle: dz/dx = 1 - z/x_y (n = 1, beta = gamma = 1/2) has z = x_y (1 - exp(-x/x_y)); Brent below the summit."""
    law = sw.Parallel(SOFT, sw.BoucWen(3e4, 0.0, 1e-4))

    def torque(x):
        return SOFT.torque(x) + 3.0 * (1.0 - np.exp(-x / 1e-4))

    grid = np.linspace(0.0, 1e-3, 100_001)
    top = grid[np.argmax(torque(grid))]
    target = (1.0 - short) * torque(top)
    wanted = brentq(lambda x: torque(x) - target, 0.0, top, xtol=1e-16)
    x, z = loaded_state(law, target)
    assert x == pytest.approx(wanted, rel=1e-6)
    assert z == pytest.approx(1e-4 * (1.0 - math.exp(-wanted / 1e-4)), rel=1e-6)
    assert loaded_state(law, -target) == pytest.approx((-x, -z), rel=1e-9)


def test_a_law_with_memory_without_a_closed_form_is_loaded_as_scipy_does():
    law = sw.Parallel(SLOPES, sw.BoucWen(6e4, 0.1, 8e-5, 1.2, 0.6, 0.2, 3))
    memory = law.second
    path = solve_ivp(
        lambda x, z: memory.z_rate(x, 1.0, z), (0.0, 2e-3), [0.0], "DOP853", rtol=1e-12, atol=1e-18, dense_output=True
    )
    wanted = brentq(lambda x: float(law.torque(x, 1.0, path.sol(x))) - 150.0, 0.0, 2e-3, xtol=1e-16)
    assert loaded_state(law, 150.0) == pytest.approx((wanted, path.sol(wanted)[0]), rel=1e-7)


def test_a_law_with_memory_that_softens_is_refused_with_its_largest_torque():
    law = sw.Parallel(SOFT, sw.BoucWen(3e4, 0.0, 1e-4))
    with pytest.raises(
        ValueError, match=r"Parallel carries at most 41\.4\d+ N\*m, at 0\.0005\d+ rad, and does not reach"
    ):
        loaded_state(law, 42.0)
