"""Exact averages of piecewise-linear torques: against closed forms and quadrature, compiled and as Python."""

import math

import numpy as np
import pytest

import strainwave as sw
from strainwave.compile.jit import run
from strainwave.numerics.balance.piecewise import pieces_of
from strainwave.theory.slow_flow.averages.piecewise_averages import averages, grid_table

GEAR = sw.PiecewiseLinear(1e5, 1.4e5, 1.8e5, 54.0, 196.0)
PLAY = sw.Backlash(2.0, 0.5)


def averaged(law, mean, z, fast=1, lines=(), call=run):
    """Averages of T exp(-i f psi), T' and T' exp(-2 i f psi)."""
    pieces = pieces_of(law)
    table = np.reshape(np.array(lines, float), (-1, 3))
    z = np.asarray(z, complex)
    force, stiffness, twice = np.empty(len(z), complex), np.empty(len(z)), np.empty(len(z), complex)
    call(
        averages, pieces.breaks, pieces.slopes, np.asarray(mean, float), z.real.copy(), z.imag.copy(), float(fast),
        table, grid_table(fast, [int(k) for k in table[:, 0]], table), force, stiffness, twice,
    )  # fmt: skip
    return force, stiffness, twice


def as_python(kernel, *args):
    kernel(*args)


def quadrature(law, mean, z, fast, lines, points=1 << 19):
    psi = 2.0 * np.pi * (np.arange(points) + 0.5) / points
    u = mean + (z * np.exp(1j * fast * psi)).real + sum(a * np.cos(k * psi) + b * np.sin(k * psi) for k, a, b in lines)
    torque, stiffness = law.torque(u), law.stiffness(u)
    turn = np.exp(-1j * fast * psi)
    return np.mean(torque * turn), np.mean(stiffness), np.mean(stiffness * turn * turn)


def test_play_has_its_describing_function():
    """Gelb & Vander Velde 1968, Multiple-Input Describing Functions, app. B: 1 - (2/pi)(asin g + g sqrt(1 - g^2))."""
    for a in (0.500001, 0.6, 1.0, 30.0):
        g = 0.5 / a
        expected = 2.0 * (1.0 - 2.0 / math.pi * (math.asin(g) + g * math.sqrt(1.0 - g * g)))
        force, stiffness, _ = averaged(PLAY, [0.0], [a])
        # torques of order 1 cancel down to 7e-9 at the smallest amplitude
        assert 2.0 * force[0] / a == pytest.approx(expected, rel=0, abs=5e-14)
        assert stiffness[0] == pytest.approx(2.0 * (1.0 - 2.0 / math.pi * math.asin(g)), rel=1e-10)


def test_small_motion_sees_the_slope_where_it_is():
    force, stiffness, twice = averaged(GEAR, [0.0, 7e-4, -5e-3], [1e-4j, 1e-4, -1e-4])
    assert stiffness.tolist() == [1e5, 1.4e5, 1.8e5]
    assert force == pytest.approx(0.5 * np.array([1e5j * 1e-4, 14.0, -18.0]), rel=1e-15)
    assert np.all(twice == 0.0)


LINES = [(2, 3e-4, 1e-4), (5, 1e-4, -2e-4)]


@pytest.mark.parametrize(("law", "scale"), [(GEAR, 1e-3), (PLAY, 0.7)])
def test_averages_agree_with_quadrature(law, scale):
    rng = np.random.default_rng(7)
    lines = [(k, a * scale / 1e-3, b * scale / 1e-3) for k, a, b in LINES]
    mean = 0.3 * scale * rng.normal(size=6)
    z = scale * (rng.normal(size=6) + 1j * rng.normal(size=6))
    found = averaged(law, mean, z, 3, lines)
    top = float(np.max(law.stiffness(np.linspace(-9.0 * scale, 9.0 * scale, 99))))
    for i in range(len(z)):
        force, stiffness, twice = quadrature(law, mean[i], z[i], 3, lines)
        # the midpoint rule is right to (spacing)^2 where T has kinks, to one spacing where T' jumps
        assert abs(found[0][i] - force) < 4e-9 * top * scale
        assert abs(found[1][i] - stiffness) < 4e-5 * top
        assert abs(found[2][i] - twice) < 4e-5 * top


def test_shortest_visit_beyond_a_breakpoint_is_seen():
    """The peak of u passes the breakpoint by 1e-9 of its height: T' then averages 1 - width/(2 pi) of a jump."""
    a = 0.5 * (1.0 + 1e-9)
    for turn in np.exp(1j * np.linspace(0.0, 6.0, 23)):
        _, stiffness, _ = averaged(PLAY, [0.0], [a * turn])
        assert stiffness[0] == pytest.approx(2.0 * 2.0 / math.pi * math.acos(0.5 / a), rel=1e-4)


def test_compiled_and_python_agree():
    rng = np.random.default_rng(8)
    mean, z = 3e-4 * rng.normal(size=50), 2e-3 * (rng.normal(size=50) + 1j * rng.normal(size=50))
    for compiled, plain in zip(
        averaged(GEAR, mean, z, 3, LINES), averaged(GEAR, mean, z, 3, LINES, call=as_python), strict=True
    ):
        assert compiled == pytest.approx(plain, rel=1e-11, abs=1e-11 * np.max(np.abs(plain)))


def test_derivatives_of_the_average_are_those_of_its_stiffness():
    z, d = np.array([1.1e-3 - 0.7e-3j]), 1e-9
    _, mean, twice = averaged(GEAR, [2e-4], z, 3, LINES)
    numeric = [
        (averaged(GEAR, [2e-4], z + s, 3, LINES)[0] - averaged(GEAR, [2e-4], z - s, 3, LINES)[0]) / (2.0 * d)
        for s in (d, 1j * d)
    ]
    assert numeric[0] == pytest.approx(0.5 * (mean + twice), rel=1e-6)
    assert numeric[1] == pytest.approx(0.5j * (mean - twice), rel=1e-6)


def test_laws_that_bend_between_breakpoints_have_no_pieces():
    assert pieces_of(sw.Cubic(1.0, 0.1)) is None
    assert pieces_of(sw.Linear(1.0)) is None
    assert pieces_of(GEAR).slopes.tolist() == pytest.approx([1.8e5, 1.4e5, 1e5, 1.4e5, 1.8e5])
