"""The largest oscillation is that of the stable motions of a curve, in every face, and the verdict knows where it ends.

Own equation J x'' + B u' + K (u + alpha u^3) = -T_l, u = x - e, by SciPy and by a fixed step in NumPy.
"""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import strainwave as sw
from strainwave.drive.train_curve import largest_crest
from strainwave.files.variants.project_sweep import largest
from strainwave.study.analysis.verdict import judged

ARCSEC, RPM = math.pi / 648_000.0, math.pi / 30.0
DRIVE = """\
gear: {{ratio: {N}, law: {{type: cubic, K: {K} N*m/rad, alpha: {alpha} 1/rad^2}}}}
motor: {{inertia: 1 kg*cm^2, mode: held}}
load: {{inertia: {J} kg*m^2}}
damping: {{B: {B} N*m*s/rad}}
speed: {{from: {low} rad/s, to: {high} rad/s, shaft: motor}}
limit: {{oscillation: 51.18 arcsec}}
excitation:
  kinematic_error: [{{order: 1, amplitude: {a1} arcsec}}, {{order: 2, amplitude: {a2} arcsec, phase: 40 deg}}]
  load_torque: {{mean: {T} N*m}}
"""
ESCAPING = {
    "N": 50, "K": 31759.78522506807, "alpha": -1743335.04, "J": 8.185693972027412, "B": 35.892, "low": 35.5541,
    "high": 163.7574, "a1": 6.921757478661179, "a2": 8.383, "T": -3.298,
}  # fmt: skip
FOLDED = {
    "N": 160, "K": 55636.4, "alpha": 10005400, "J": 4.0204, "B": 35.7608, "low": 141.1656, "high": 611.716,
    "a1": 1.08025, "a2": 8.816, "T": -64.38,
}  # fmt: skip


def project(tmp_path, of):
    path = tmp_path / "drive.yaml"
    path.write_text(DRIVE.format(**of))
    return sw.read_project(path)


def equation(of, omega):
    a1, a2 = of["a1"] * ARCSEC, of["a2"] * ARCSEC

    def rates(t, y):
        first, second = omega * t, 2.0 * omega * t + math.radians(40.0)
        u = y[0] - a1 * np.cos(first) - a2 * np.cos(second)
        du = y[1] + omega * (a1 * np.sin(first) + 2.0 * a2 * np.sin(second))
        return np.array([y[1], (-of["T"] - of["B"] * du - of["K"] * (u + of["alpha"] * u**3)) / of["J"]])

    return rates


def oscillation(x):
    return float(np.max(np.abs(x - np.mean(x[:-1])))) / ARCSEC


@pytest.fixture(scope="module")
def escaping(tmp_path_factory):
    return project(tmp_path_factory.mktemp("escaping"), ESCAPING)


def gone(_, y):
    return abs(y[0]) - 4.0 / math.sqrt(-3.0 * ESCAPING["alpha"])  # far beyond the hump of the torque


gone.terminal = True


def run_down(rpms, turns=60):
    """Oscillation [arcsec] in the last two turns at every speed, from one to the next; inf where the load escapes."""
    y, sizes = np.zeros(2), []
    for rpm in rpms:
        omega = rpm * RPM
        turn = 2.0 * math.pi / omega
        times = np.linspace((turns - 2) * turn, turns * turn, 401)
        found = solve_ivp(equation(ESCAPING, omega), (0.0, times[-1]), y, "DOP853", times, gone, rtol=1e-9, atol=1e-13)
        if found.status:
            return [*sizes, math.inf]
        y = found.y[:, -1]
        sizes.append(oscillation(found.y[0]))
    return sizes


def test_the_largest_is_where_the_motion_flips_and_the_verdict_says_that_the_drive_leaves_it(escaping):
    found = escaping.response()
    top = found.oscillation[found.top] / ARCSEC
    flip = found.curve.doublings[-1].omega
    assert found.omega[found.top] == flip
    before, *_, last, left = run_down([560.0, 530.0, 500.0, 480.0, 475.5, 473.0, 470.0, 468.0, 465.0])[3:]
    assert before < top
    assert top == pytest.approx(last, rel=2e-2)  # a motion of two turns from the flip on, which grows
    assert left < 0.3 * top or left == math.inf  # it jumps, or the load escapes: the basins decide
    said = judged(escaping, found)
    assert said.leaves in said.failures
    assert "the drive jumps to another motion" in said.leaves
    assert any(low * 1.0001 < flip <= high * 1.0001 for low, high in said.avoid.unstable)
    assert not said.covered


def test_every_face_has_the_same_largest(escaping):
    found = escaping.response()
    top = found.oscillation[found.top]
    assert largest(escaping)["oscillation"] == top
    assert f"{top:.6g} rad" in str(found)
    at, size = largest_crest(escaping.system(reduced=True), escaping.speeds.limits, 14, False)[:2]
    assert (at, size) == pytest.approx((found.omega[found.top], top), rel=1e-6)


def test_a_stable_motion_counts_that_no_slow_sweep_comes_to(tmp_path):
    folded = project(tmp_path, FOLDED)
    found = folded.response()
    top = found.top
    assert top not in {*found.sweep.run_up, *found.sweep.run_down}
    omega = 0.99 * found.omega[top]
    rates, steps, turns = equation(FOLDED, omega), 128, 100
    h = 2.0 * math.pi / omega / steps
    generator = np.random.default_rng(3)
    y = 300.0 * ARCSEC * generator.uniform(-1.0, 1.0, (2, 400)) * [[1.0], [2.0 * omega]]
    rows = []
    for i in range(steps * turns):  # the classical Runge-Kutta method
        t = i * h
        k1 = rates(t, y)
        k2 = rates(t + h / 2, y + h / 2 * k1)
        k3 = rates(t + h / 2, y + h / 2 * k2)
        y = y + h / 6 * (k1 + 2 * k2 + 2 * k3 + rates(t + h, y + h * k3))
        rows += [y[0]] if i >= steps * (turns - 1) else []
    sizes = np.array([oscillation(x) for x in np.array(rows + rows[:1]).T])
    near = np.arange(top - 20, top + 1)
    near = near[np.argsort(found.omega[near])]
    there = np.interp(omega, found.omega[near], found.oscillation[near]) / ARCSEC
    assert np.min(np.abs(sizes / there - 1.0)) < 5e-3
