"""Period doublings and symmetry breaking: where multipliers pass -1 and +1, and the branches that leave there."""

import numpy as np
import pytest

import strainwave as sw

# a biased hardening spring, whose 1:2 resonance doubles the period
BIASED = sw.Oscillator(1.0, 0.1, sw.Cubic(1.0, 0.2), sw.Harmonic(2.0, mean=0.6), 1.0)
# a symmetric one, driven hard: the superharmonic of order two breaks the symmetry
SYMMETRIC = sw.Oscillator(1.0, 0.1, sw.Cubic(1.0, 1.0), sw.Harmonic(5.0), 1.0)


@pytest.fixture(scope="module")
def biased():
    return sw.frequency_response(BIASED, (1.9, 2.6))


@pytest.fixture(scope="module")
def symmetric():
    return sw.frequency_response(SYMMETRIC, (0.85, 1.4), harmonics=31)


def shot(system, orbit, omega):
    return sw.numerics.shoot(system._replace(omega=omega), orbit.state(0.0), period=orbit.period)


def test_multipliers_at_a_doubling_are_minus_one_and_its_partner(biased):
    assert len(biased.doublings) == 2
    for d in biased.doublings:
        assert d.label == "period doubling"
        assert d.multipliers[0] == pytest.approx(-1.0, abs=1e-6)
        # Liouville: the product is exp(-B period/J)
        product = np.exp(-0.1 * 2.0 * np.pi / d.omega)
        assert np.prod(d.multipliers).real == pytest.approx(product, rel=1e-12)


@pytest.mark.slow
def test_doublings_agree_with_shooting_to_1e_8(biased):
    for d in biased.doublings:
        left, right = (shot(BIASED, d, d.omega * (1.0 + side * 1e-8)) for side in (-1.0, 1.0))
        products = [float(np.prod(1.0 + orbit.multipliers).real) for orbit in (left, right)]
        assert products[0] * products[1] < 0.0


def test_stability_changes_at_the_doublings(biased):
    low, high = (d.omega for d in biased.doublings)
    inside = (biased.omega > low) & (biased.omega < high)
    assert not biased.stable[inside & (biased.peak < 2.0)].any()


def test_symmetry_breaks_where_a_multiplier_passes_one_without_a_fold(symmetric):
    assert len(symmetric.branch_points) == 2
    assert symmetric.folds == []
    for p in symmetric.branch_points:
        assert p.label.startswith("symmetry breaking")
        assert p.multipliers[0] == pytest.approx(1.0, abs=1e-6)
    low, high = (p.omega for p in symmetric.branch_points)
    unstable = symmetric.omega[~symmetric.stable]
    assert low - 1e-9 <= unstable.min() <= unstable.max() <= high + 1e-9


def test_a_curve_without_crossings_has_none():
    curve = sw.frequency_response(BIASED._replace(law=sw.Cubic(1.0, 0.0)), (0.3, 3.0), harmonics=3)
    assert curve.folds == curve.doublings == curve.branch_points == []


@pytest.mark.slow
def test_the_branch_of_doubled_orbits_joins_both_doublings(biased):
    doubled = sw.numerics.switch_branch(BIASED, biased.doublings[0])
    assert doubled.period == 2
    assert doubled.status
    assert doubled.amplitude(1).max() > 0.1  # half the base frequency
    assert doubled.omega[0] == pytest.approx(biased.doublings[0].omega, rel=1e-4)
    assert doubled.omega[-1] == pytest.approx(biased.doublings[1].omega, rel=1e-4)
    assert doubled.stable.any()


@pytest.mark.slow
def test_a_doubled_orbit_repeats_after_two_turns_and_not_after_one(biased):
    doubled = sw.numerics.switch_branch(BIASED, biased.doublings[0])
    i = int(np.flatnonzero(doubled.stable)[np.argmax(doubled.amplitude(1)[doubled.stable])])
    system = BIASED._replace(omega=float(doubled.omega[i]))
    x = np.stack([doubled.coefficients[i], 0.0 * doubled.coefficients[i]], axis=1)
    orbit = sw.find_orbit(system, guess=x, period=2)
    turn = 2.0 * np.pi / system.omega
    run = sw.simulate(system, orbit.state(0.0), [0.0, turn, 2.0 * turn], method=sw.Dopri5(rtol=1e-11))
    assert np.linalg.norm(run.y[:, 2] - run.y[:, 0]) < 1e-7
    assert np.linalg.norm(run.y[:, 1] - run.y[:, 0]) > 0.1


@pytest.mark.slow
def test_the_branch_of_broken_symmetry_has_a_mean_and_comes_back(symmetric):
    broken = sw.numerics.switch_branch(SYMMETRIC, symmetric.branch_points[0], harmonics=31)
    assert broken.period == 1
    assert np.abs(broken.amplitude(0)).max() > 0.1
    assert np.abs(symmetric.amplitude(0)).max() < 1e-6
    assert broken.omega[-1] == pytest.approx(symmetric.branch_points[1].omega, rel=1e-2)
    assert "returns to the branch" in broken.message


@pytest.mark.slow
def test_no_branch_leaves_at_an_ordinary_orbit():
    with pytest.raises(ValueError, match=r"Branch\.doublings"):
        sw.numerics.switch_branch(BIASED, sw.find_orbit(BIASED, harmonics=5))
