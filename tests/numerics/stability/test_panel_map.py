"""Multipliers of trains by long panels against SciPy's DOP853 on variational equations written by hand."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from scipy.optimize import brentq

import strainwave as sw
from strainwave.compile.jit import run
from strainwave.compile.tree import leaf_of
from strainwave.model.train.train_forms import AtLoad
from strainwave.numerics.balance.choice import condensed
from strainwave.numerics.continuation.trace import solve
from strainwave.numerics.stability.first_order import floquet_of
from strainwave.numerics.stability.panel_map import PLACE_SHARES, PLACES, _panels, tables, through_panels

K, J_M, J_1, J_2, N, B, K_C, B_C, A, OMEGA, H = 1e5, 4.5e-4, 0.1, 1.2, 50.0, 15.0, 4e5, 5.0, 1e-4, 150.0, 21
CUBIC = sw.Cubic(K, 5e6)
KINKED = sw.PiecewiseLinear(6e4, 1e5, 1.6e5, 3.0, 9.0)
LOOP = 0.5, 20.0
WEAK = 1e-3 * OMEGA * J_M, 0.125 * 1e-6 * OMEGA**2 * J_M  # gains that hold a free motor's mean angle


def problem_and_point(control, law, coupling):
    drive = sw.Drive(J_m=J_M, J_l=J_2, N=N, B=B, law=sw.Linear(K))
    made = drive.train(control=control, kinematic_error=sw.KinematicError((sw.Line(2, A),)), omega=OMEGA)
    made = made._replace(load=sw.train.Elastic(J_1, B_C, coupling, made.load), law=law)
    system = AtLoad(made, OMEGA)
    leaf = leaf_of(system, "omega")
    problem = condensed(system, leaf, leaf, H)
    return problem, solve(problem, problem.linear_response(OMEGA))


def at(series, angle):
    """Value and derivative by the angle of a series of harmonics 2, 4, ... in blocks."""
    h = len(series) // 2
    k = 2.0 * np.arange(1, h + 1)
    c, s = np.cos(k * angle), np.sin(k * angle)
    even, odd = series[1 : h + 1], series[h + 1 :]
    return series[0] + even @ c + odd @ s, k * odd @ c - k * even @ s


def stiffness(law, u):
    if law == CUBIC:
        return K * (1.0 + 3.0 * 5e6 * u * u)
    return 6e4 if abs(u) < 3.0 / 6e4 else 1e5 if abs(u) < 3.0 / 6e4 + 6.0 / 1e5 else 1.6e5


def by_hand(law, coupling, series, gains):
    """Rates of disturbances of x, the motor's angle and the coupling's twist, with their rates, along an orbit."""
    K_P, K_I = gains

    def rates(t, y):
        x, v, d, w, c, r = y.reshape(6, -1)
        (u, du), (angle, turned) = (at(series[i], OMEGA * t) for i in (0, -1))
        angle, speed = OMEGA * t + angle, OMEGA * (1.0 + turned)
        e1, e2 = -2.0 * A * np.sin(2.0 * angle), -4.0 * A * np.cos(2.0 * angle)
        torque = law.torque(u) + B * OMEGA * du
        change = stiffness(law, u) * (x - e1 * d) + B * (v - e1 * w - e2 * speed * d)
        motor = (-K_I * d - K_P * w - (1.0 / N - e1) * change + e2 * d * torque) / J_M
        soft = K_C if coupling == sw.Linear(K_C) else K_C * (1.0 + 3.0 * 2e7 * at(series[1], OMEGA * t)[0] ** 2)
        passed = soft * c + B_C * r
        before, behind = (change - passed) / J_1, passed / J_2
        return np.concatenate([v, motor / N - before, w, motor, r, before - behind])

    return rates


@pytest.mark.parametrize(
    ("control", "gains", "law", "coupling"),
    [
        (sw.train.SpeedLoop(*LOOP), LOOP, CUBIC, sw.Linear(K_C)),
        (sw.train.SpeedLoop(*LOOP), LOOP, CUBIC, sw.Cubic(K_C, 2e7)),
        (sw.train.SpeedLoop(*LOOP), LOOP, KINKED, sw.Linear(K_C)),
        (sw.train.Free(), WEAK, CUBIC, sw.Linear(K_C)),
    ],
    ids=["cubic", "two laws", "kinked", "free"],
)
def test_the_multipliers_of_a_train_are_those_of_dop853_on_equations_written_by_hand(control, gains, law, coupling):
    problem, point = problem_and_point(control, law, coupling)
    assert problem.every == 2
    series, turn = problem.series(point[None])[0], 2.0 * np.pi / OMEGA
    u = series[0] @ problem.synthesis
    assert np.ptp([stiffness(law, value) for value in u]) > 0.05 * K  # the laws' curvature shows
    rates = by_hand(law, coupling, series, gains)
    cuts = problem.disturbances(point[None]).crossings()[0] / (2.0 * OMEGA)
    ends = np.concatenate([[0.0], cuts, [0.5 * turn]])
    y = np.eye(6).ravel()
    for span in pairwise(ends):
        y = solve_ivp(rates, span, y, method="DOP853", rtol=1e-11, atol=1e-13).y[:, -1]
    half = y.reshape(6, 6)
    expected, found = np.poly(np.linalg.eigvals(half @ half)), np.poly(floquet_of(problem, point[None])[0])
    assert found == pytest.approx(expected, abs=1e-8)


def test_the_map_of_a_constant_feedback_is_the_exponential_of_the_whole():
    rng = np.random.default_rng(3)
    a, b, c, r = (rng.standard_normal(shape) for shape in ((5, 5), (5, 2), (3, 5), (2, 3)))
    feedback = np.broadcast_to(0.3 * r, (10, PLACES, 2, 3))
    flow = through_panels(tables(a, b, c, np.array([0.1])), np.zeros(10, int), feedback, np.array([0, 10]))
    assert flow[0] == pytest.approx(expm(a + b @ (0.3 * r) @ c), rel=1e-12, abs=1e-12)


def test_the_error_of_the_panels_falls_with_the_sixteenth_power_of_their_length():
    # y' = cos(t) S y with S^2 = -16, half of it constant: the map from 0 to t is the rotation by 4 sin(t)
    a = 4.0 * np.array([[0.0, 1.0], [-1.0, 0.0]])

    def error(panels):
        h = 2.0 / panels
        places = h * (np.arange(panels)[:, None] + PLACE_SHARES)
        feedback = (np.cos(places) - 0.5)[..., None, None] * a
        table = tables(0.5 * a, np.eye(2), np.eye(2), np.array([h]))
        flow = through_panels(table, np.zeros(panels, int), feedback, np.array([0, panels]))[0]
        angle = 4.0 * np.sin(2.0)
        return np.max(np.abs(flow - [[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]]))

    assert 2.0**15 < error(2) / error(4) < 2.0**17


@pytest.mark.slow
def test_machine_code_goes_through_panels_as_numpy_does():
    rng = np.random.default_rng(5)
    a, b, c = (rng.standard_normal(shape) for shape in ((6, 6), (6, 2), (4, 6)))
    table, which = tables(a, b, c, np.array([0.1, 0.2])), np.arange(7) % 2
    feedback, first = rng.standard_normal((7, PLACES, 2, 4)), np.array([0, 3, 7])
    one, other = np.empty((2, 2, 6, 6))
    run(_panels, tuple(table), which, feedback, first, one)
    _panels(tuple(table), which, feedback, first, other)
    assert one == pytest.approx(other, rel=1e-11, abs=1e-11)


J, GAP, SPRING = 1.1, 4e-5, sw.Cubic(2.2e4, 4.3e5)


def twist(angle, c):
    """Torsion at angles of a series mean, cos 1, sin 1, ..."""
    turns = np.multiply.outer(angle, np.arange(1, len(c) // 2 + 1))
    return c[0] + np.cos(turns) @ c[1::2] + np.sin(turns) @ c[2::2]


def along(angle, y, c, w, free):
    """Derivatives of a disturbance by the angle, in the gap or outside."""
    stiff = 0.0 if free else SPRING.stiffness(abs(twist(angle, c)) - GAP)
    return [y[1] / w, (-stiff * y[0] - B * y[1]) / J / w]


@pytest.mark.slow
@pytest.mark.parametrize("mean", [3.0, 0.0])
def test_the_multipliers_of_an_oscillator_with_a_gap_are_those_of_steps_that_end_at_its_edges(mean):
    system = sw.Oscillator(J, B, sw.Play(GAP, SPRING), sw.Harmonic(2.5, mean=mean), 140.0)
    curve = sw.frequency_response(system, (60.0, 180.0), harmonics=25)
    grid = np.linspace(0.0, 2.0 * np.pi, 4001)
    for i in range(0, len(curve.omega), len(curve.omega) // 8):
        c, cuts, flow = curve.coefficients[i], [0.0, 2.0 * np.pi], np.eye(2)
        for edge in (-GAP, GAP):
            u = twist(grid, c) - edge
            places = np.flatnonzero(u[:-1] * u[1:] < 0.0)
            cuts += [brentq(lambda a, c, e: twist(a, c) - e, *grid[j : j + 2], (c, edge)) for j in places]
        for span in pairwise(sorted(cuts)):
            more = c, curve.omega[i], abs(twist(np.mean(span), c)) < GAP
            step = [solve_ivp(along, span, y, "DOP853", args=more, rtol=1e-11, atol=1e-13).y[:, -1] for y in np.eye(2)]
            flow = np.transpose(step) @ flow
        expected = np.sort(np.abs(np.linalg.eigvals(flow)))
        np.testing.assert_allclose(np.sort(np.abs(curve.multipliers[i])), expected, rtol=1e-7)
