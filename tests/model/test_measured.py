"""Laws of real gears against independent ones: SciPy's monotone cubic, the exact straight lines, `Backlash`."""

import math
from typing import NamedTuple

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator

import strainwave as sw
from strainwave.base.quantities import checked
from strainwave.numerics.balance.piecewise import is_piecewise_linear

# (K1, K2, K3) and (T1, T2) of a CSF-40-50: Harmonic Drive LLC, CSF/CSG catalogue, p. 50.
SLOPES = sw.PiecewiseLinear(1e5, 1.4e5, 1.8e5, 54.0, 196.0)
TABLES = {
    "uneven": ([-3.0, -1.0, -0.9, 0.2, 2.0, 2.1], [-4.0, -3.9, -1.0, 0.0, 0.1, 5.0]),
    "with a plateau": ([-1.0, 0.0, 1.0, 2.0, 3.0], [-1.0, 0.0, 0.0, 0.0, 2.0]),
    "three points": ([0.0, 1.0, 4.0], [0.0, 3.0, 3.5]),
    "beside zero": ([1.0, 2.0, 2.5, 4.0], [1.0, 1.5, 3.5, 3.6]),
}
each_table = pytest.mark.parametrize(("x", "T"), TABLES.values(), ids=TABLES.keys())


@each_table
def test_a_table_is_scipys_monotone_cubic_between_its_points(x, T):
    law, peer = checked(sw.tabulated(list(zip(x, T, strict=True)))), PchipInterpolator(x, T)
    inside = np.linspace(x[0], x[-1], 997)
    np.testing.assert_allclose(law.torque(inside), peer(inside), rtol=0, atol=1e-13)
    np.testing.assert_allclose(law.stiffness(inside), peer(inside, 1), rtol=0, atol=1e-11)
    work = peer.antiderivative()(inside)
    np.testing.assert_allclose(law.energy(inside) - law.energy(x[0]), work, rtol=0, atol=1e-13)


@each_table
def test_a_table_goes_on_straight_beyond_its_points(x, T):
    law = sw.tabulated(list(zip(x, T, strict=True)))
    for end, beyond in ((0, x[0] - 1.5), (-1, x[-1] + 1.5)):
        slope = law.knots[end].K
        assert law.torque(beyond) == pytest.approx(T[end] + slope * (beyond - x[end]), rel=1e-13)
        steepest = max(knot.K for knot in law.knots)
        assert law.stiffness(beyond) == pytest.approx(slope, abs=1e-14 * steepest * len(x))
        rise = T[end] * (beyond - x[end]) + 0.5 * slope * (beyond - x[end]) ** 2
        assert law.energy(beyond) - law.energy(x[end]) == pytest.approx(rise, rel=1e-13)


@each_table
def test_a_table_never_falls(x, T):
    law = sw.tabulated(list(zip(x, T, strict=True)))
    everywhere = np.linspace(x[0] - 1.0, x[-1] + 1.0, 2003)
    assert np.min(np.diff(law.torque(everywhere))) >= -1e-14
    assert np.min(law.stiffness(everywhere)) >= -1e-12


def test_an_odd_table_adds_the_origin_and_its_mirror_image():
    half = [(5.4e-4, 54.0), (15.54e-4, 196.0), (21.0e-4, 294.0)]
    law = sw.tabulated(half, odd=True)
    assert law == sw.tabulated([*((-x, -T) for x, T in half[::-1]), (0.0, 0.0), *half])
    assert law.torque(0.0) == 0.0
    assert [law.torque(x) for x, _ in half] == pytest.approx([T for _, T in half], rel=1e-15)
    assert law.torque(-1e-3) == pytest.approx(-law.torque(1e-3), rel=1e-14)


@pytest.mark.parametrize(
    ("points", "sentence"),
    [
        (
            [(0.0, 0.0), (1.0, 1.0)],
            "a table of 2 points is given; it needs 3 to 64; two make a straight line: use Linear",
        ),
        ([(i, i) for i in range(65)], "a table of 65 points .* average neighbouring points"),
        ([], "a table of 0 points"),
        ([(0.0, 0.0), (2.0, 1.0), (1.0, 2.0)], "the torsion 1 rad stands after 2 rad; sort the points"),
        ([(0.0, 0.0), (1.0, 1.0), (1.0, 2.0)], "the torsion 1 rad appears twice; average the two torques 1 and 2 N"),
        (
            [(0.0, 0.0), (1.0, 2.0), (2.0, 1.0)],
            r"the torque falls from 2 to 1 N\*m between 1 and 2 rad \(negative stiff",
        ),
        ([(0.0, 1.0), (1.0, 1.0), (2.0, 1.0)], "the torque is 1 N[*]m at every point"),
        ([(0.0, 0.0), (1.0, math.nan), (2.0, 1.0)], "the point .* is not finite"),
        (
            [(0.0, 0.0), (1e-300, 1.0), (2e-300, 2.0)],
            "between 0 and 1e-300 rad, more than 1e[+]60 N[*]m/rad; give the tor",
        ),
        ([(0.0, 0.0), (1.0, 1.0), (1e62, 1e62)], "Knot.x is 1e[+]62; it must not exceed"),
    ],
)
def test_a_bad_table_is_refused(points, sentence):
    with pytest.raises(ValueError, match=sentence):
        sw.tabulated(points)


def test_an_odd_table_of_points_on_both_sides_is_refused():
    with pytest.raises(ValueError, match="positive torsions and has one at -1 rad"):
        sw.tabulated([(-1.0, -1.0), (0.0, 0.0), (1.0, 1.0)], odd=True)


def test_knots_that_would_overshoot_are_refused():
    knots = (sw.laws.Knot(0.0, 0.0, 3.5), sw.laws.Knot(1.0, 1.0, 1.0), sw.laws.Knot(2.0, 2.0, 1.0))
    with pytest.raises(ValueError, match=r"slopes 3.5 and 1 N[*]m/rad at 0 and 1 rad, whose points rise with 1 N"):
        checked(sw.laws.Tabulated(knots))


def test_rounded_corners_are_exact_outside_and_off_by_an_eighth_of_width_and_change_at_the_corner():
    width = 2e-4
    law = checked(sw.laws.RoundedPiecewiseLinear(*SLOPES, width))
    corners = SLOPES.breakpoints()
    x = np.linspace(-3e-3, 3e-3, 4001)
    outside = np.all(np.abs(x[:, None] - corners) >= 0.5 * width, axis=1)
    np.testing.assert_allclose(law.torque(x[outside]), SLOPES.torque(x[outside]), rtol=1e-13)
    np.testing.assert_allclose(law.stiffness(x[outside]), SLOPES.stiffness(x[outside]), rtol=1e-13)
    # the parabola lies above two lines that meet with slopes K1 < K2 by (K2 - K1) width/8 at the corner
    assert law.torque(corners[2]) - 54.0 == pytest.approx((1.4e5 - 1e5) * width / 8.0, rel=1e-10)
    assert np.max(np.abs(law.torque(x) - SLOPES.torque(x))) <= 0.4e5 * width / 8.0 * (1.0 + 1e-9)


@pytest.mark.parametrize("width", [0.0, -1e-5, 1.02e-3, math.pi])
def test_rounded_corners_that_meet_are_refused(width):
    with pytest.raises(ValueError, match=r"RoundedPiecewiseLinear.width is .* at most 0.00101429 rad"):
        checked(sw.laws.RoundedPiecewiseLinear(*SLOPES, width))


def test_play_in_series_with_a_straight_spring_is_backlash():
    play, backlash = sw.Play(0.5, sw.Linear(1.7)), sw.Backlash(1.7, 0.5)
    x = np.concatenate([np.linspace(-2.0, 2.0, 41), [-0.5, 0.0, 0.5]])
    assert play.breakpoints() == backlash.breakpoints()
    for method in ("torque", "stiffness", "energy"):
        assert np.array_equal(getattr(play, method)(x), getattr(backlash, method)(x))


def test_play_moves_the_law_outwards_by_half_the_gap():
    play = checked(sw.Play(2e-4, SLOPES))
    assert play.breakpoints() == pytest.approx((-17.542857e-4, -7.4e-4, -2e-4, 2e-4, 7.4e-4, 17.542857e-4), rel=1e-7)
    assert play.torque(12e-4) == pytest.approx(SLOPES.torque(10e-4), rel=1e-14)
    assert (play.torque(1.9e-4), play.stiffness(-1.9e-4), play.energy(1e-4)) == (0.0, 0.0, 0.0)
    assert is_piecewise_linear(play)
    assert not is_piecewise_linear(sw.Play(2e-4, sw.Cubic(1e5, 7e4)))


@pytest.mark.parametrize(
    ("play", "sentence"),
    [
        (sw.Play(-1e-4, sw.Linear(1e5)), "Play.half_gap is -0.0001 rad"),
        (sw.Play(1e-4, sw.Polynomial((0.3, 1.0))), "Polynomial with the torque 0.3 N[*]m at zero torsion"),
        (sw.Play(1e-4, sw.Backlash(1e5, 0.0)), "Backlash with a corner at zero torsion"),
        (sw.Play(1e-4, sw.Linear(math.inf)), "Linear.K is inf"),
        (sw.Play(1e-4, sw.Linear(-1e5)), "Linear with the stiffness -100000 N[*]m/rad at zero torsion; behind a gap"),
    ],
)
def test_bad_play_is_refused(play, sentence):
    with pytest.raises(ValueError, match=sentence):
        checked(play)


class Hard(NamedTuple):
    """A user's spring that is smooth and says nothing of breakpoints."""

    K: float

    def torque(self, x):
        return self.K * x * (1.0 + x * x)

    def stiffness(self, x):
        return self.K * (1.0 + 3.0 * x * x)


def test_play_takes_a_users_law_without_breakpoints():
    play = checked(sw.Play(0.1, Hard(2.0)))
    assert play.breakpoints() == (-0.1, 0.1)
    assert play.torque(0.6) == pytest.approx(2.0 * 0.5 * 1.25, rel=1e-15)


@pytest.mark.slow
def test_compiled_play_takes_a_users_law_without_breakpoints():
    run = sw.simulate(sw.Oscillator(1.0, 0.1, sw.Play(0.1, Hard(2.0)), sw.Harmonic(0.5), 1.3), (0.0, 0.0), 20.0)
    assert run.status
    assert run.switches > 5


def test_the_orbit_of_play_is_the_published_one_of_backlash():
    # J = K = 1, half gap .5, B .1, A .6, omega .8: exact flow of the segments, and DOP853 with located switches.
    orbit = sw.find_orbit(sw.Oscillator(1.0, 0.1, sw.Play(0.5, sw.Linear(1.0)), sw.Harmonic(0.6), 0.8))
    assert orbit.peak == pytest.approx(3.297722874, abs=5e-9)
    assert orbit.amplitude(1) == pytest.approx(3.260846925, abs=5e-9)
    assert orbit.amplitude(3) == pytest.approx(0.042768294, abs=5e-9)
    assert abs(orbit.multipliers[0]) == pytest.approx(0.675231907, abs=5e-9)
