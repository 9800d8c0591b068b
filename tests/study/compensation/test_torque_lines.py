"""Torque lines cancelled: the article's drive in four regimes, and in a loop, against loops that are written out here.

The article forces its error equation x'' = (T_m + T_c)/(N J_m) - T_l/J_l - B x'/J - K (x + alpha x^3)/J with T_m = 10
N*m cos(omega t). Between samples it is integrated by Runge-Kutta steps, four in every sample. With the one step that
the package takes a sample of 250 us has a forcing of 1157 rad/s to a hundred-thousandth (`FORCED`), (omega h)^4/800.
"""

import json
import math
from pathlib import Path

import numba
import numpy as np
import pytest
from article_cases import CASES
from article_equation import ALPHA, J_L, J_M, T_M, B, K, N
from click.testing import CliRunner

import strainwave as sw
from strainwave.app.commands import cli as command
from strainwave.study.compensation.bench import bench_of, lines_in
from strainwave.study.compensation.gains import times_of
from strainwave.study.compensation.specimens import unit_of

ARTICLE = Path(__file__).parents[3] / "examples/projects/article.yaml"
J = N**2 * J_M * J_L / (N**2 * J_M + J_L)
MU, OMEGA_0 = B / J, math.sqrt(K / J)
H = 250e-6
IDEAL = sw.controllers.Sampling(H, H)
FORCED = 1e-5  # of the error before
LEAD = 1.5 * H  # delay and half a sample
REGIMES = {"non-resonant": 10.47, "primary": OMEGA_0, "superharmonic": OMEGA_0 / 3.0, "subharmonic": 3.0 * OMEGA_0}
STEADY = {regime: float(CASES[f"derived, {regime}"].at_omega) for regime in REGIMES}  # T_m = 10 N*m, by integration


@numba.njit
def equation(omega, a, b, gain, phase, samples):
    """Error at every sample from rest, under T_c = a cos + b sin of the forcing, and a, b following the error."""
    x = v = held = 0.0
    seen = np.empty(samples)
    for k in range(samples):
        t, acting = k * H, held
        angle = omega * t
        held = a * math.cos(angle) + b * math.sin(angle)
        a -= H * gain * x * math.cos(angle + phase)
        b -= H * gain * x * math.sin(angle + phase)
        seen[k] = x
        h = H / 4
        for i in range(4):
            dx = dv = fast = slow = 0.0
            for part, weight in ((0.0, 1.0), (0.5, 2.0), (0.5, 2.0), (1.0, 1.0)):
                p, q = x + part * h * fast, v + part * h * slow
                force = T_M * math.cos(omega * (t + (i + part) * h)) + acting
                fast, slow = q, force / (N * J_M) - MU * q - OMEGA_0**2 * (p + ALPHA * p**3)
                dx, dv = dx + weight * fast, dv + weight * slow
            x, v = x + h / 6 * dx, v + h / 6 * dv
    return seen


def spread(error):
    return float(np.std(error))


def window(project, omega, rate=0.0):
    settle, end = times_of(bench_of(project, IDEAL), omega, rate)
    return round(settle / H), round(end / H)


@pytest.fixture(scope="module")
def article():
    return sw.read_project(ARTICLE)


@pytest.mark.slow
@pytest.mark.parametrize("regime", REGIMES)
def test_what_is_known_of_the_torque_is_taken_away_in_every_regime(article, regime):
    """The inverse is -T_m ahead of the delay; the table divides the steady error by the response at its size."""
    omega = REGIMES[regime]
    first, last = window(article, omega)
    plain = equation(omega, 0.0, 0.0, 0.0, 0.0, last)
    for name in ("inverse", "predicted-table", "measured-table"):
        found = sw.compensate(article, name, speed=omega, sampling=IDEAL, robust=False)
        line = found.controller.table.terms[0]
        turn = line.phase + found.controller.lead * omega
        left = equation(omega, line.amplitude * math.cos(turn), -line.amplitude * math.sin(turn), 0.0, 0.0, last)
        assert found.before.rms == pytest.approx(spread(plain[first:]), rel=0.01)
        assert found.after.rms == pytest.approx(spread(left[first:]), rel=0.02, abs=FORCED * found.before.rms)
        assert found.amplitude_before[0] == pytest.approx(STEADY[regime], rel=1e-3)
        assert found.after.rms < 0.005 * found.before.rms
        if name == "inverse":
            assert (line.amplitude, line.phase, found.controller.lead) == (-T_M, 0.0, LEAD)


@pytest.mark.slow
@pytest.mark.parametrize("regime", REGIMES)
def test_adaptation_converges_in_every_regime_and_says_how_fast(article, regime):
    """Its phase lies between those of the response in the small and at the steady error, where the gear is stiffer."""
    omega, amplitude = REGIMES[regime], STEADY[regime]
    found = sw.compensate(article, "adaptive", speed=omega, sampling=IDEAL, robust=False)
    own, square = found.controller, OMEGA_0**2 * (1.0 + 0.75 * ALPHA * np.array([0.0, amplitude]) ** 2)
    held = np.sinc(0.5 * omega * H / math.pi) * np.exp(-1j * LEAD * omega)
    small, large = held / (N * J_M) / (square - omega**2 + 1j * MU * omega)
    middle = np.angle(small / abs(small) + large / abs(large))
    assert own.phase == pytest.approx(middle, abs=2e-3)
    assert own.gain == pytest.approx(2.0 * 0.3 * MU / 2.0 / abs(small), rel=1e-3)  # 0.3 of the vibration's rate mu/2
    slowest = min(0.5 * own.gain * abs(g) * math.cos(np.angle(g) - middle) for g in (small, large))
    assert found.rate == pytest.approx(slowest, rel=0.01)

    first, last = window(article, omega, found.rate)
    left = equation(omega, 0.0, 0.0, own.gain, own.phase, last)
    before = spread(equation(omega, 0.0, 0.0, 0.0, 0.0, last)[first:])
    assert found.after.rms == pytest.approx(spread(left[first:]), rel=0.02, abs=1e-9 * before)
    assert found.after.rms < 1e-5 * before
    turn = max(1, round(2.0 * math.pi / omega / H))
    sizes = np.std(left[: len(left) // turn * turn].reshape(-1, turn), axis=1)
    settled = H * turn * (1 + np.flatnonzero(sizes > 0.1 * before)[-1])
    assert found.converged == pytest.approx(settled, rel=0.02)
    assert f"after {found.converged:.3g} s" in str(found)
    if regime != "primary":  # nothing bends: the error falls by the rate
        early, late = (round(t / H) // turn for t in (100.0, 150.0))
        assert math.log(sizes[early] / sizes[late]) / 50.0 == pytest.approx(found.rate, rel=0.03)


@numba.njit
def train(omega, gains, line, twist, table, samples):
    """Pointing error of motor and load under a sampled PD loop, with T_l = line cos(2 angle) beside T_m cos(angle).

    `table` is a torque of orders 1 and 2, `twist` an angle of the motor over N of order 2, as cosine and sine.
    """
    y, held, last, begun = np.zeros(4), 0.0, 0.0, 0.0
    seen = np.empty(samples)
    for k in range(samples):
        t, acting = k * H, held
        angle = omega * t
        seen[k] = -y[2]
        aim = N * (twist[0] * math.cos(2.0 * angle) + twist[1] * math.sin(2.0 * angle))
        deviation = y[0] - aim
        held = -gains[0] * deviation - gains[1] * begun * (deviation - last) / H
        for order in (1, 2):
            held += table[order - 1, 0] * math.cos(order * angle) + table[order - 1, 1] * math.sin(order * angle)
        last, begun = deviation, 1.0
        h = H / 4
        for i in range(4):
            total, slope = np.zeros(4), np.zeros(4)
            for part, weight in ((0.0, 1.0), (0.5, 2.0), (0.5, 2.0), (1.0, 1.0)):
                at = y + part * h * slope
                now = omega * (t + (i + part) * h)
                x, v = at[0] / N - at[2], at[1] / N - at[3]
                gear = K * (x + ALPHA * x**3) + B * v
                motor = (T_M * math.cos(now) + acting - gear / N) / J_M
                slope = np.array([at[1], motor, at[3], (gear + line * math.cos(2.0 * now)) / J_L])
                total = total + weight * slope
            y = y + h / 6 * total
    return seen


@pytest.mark.slow
@pytest.mark.parametrize("omega", [100.0, 385.5])
def test_lines_of_motor_and_load_are_taken_away_in_a_loop(omega):
    """The gear bears T_l with the twist -T_l/(K + i 2 omega B), along which the motor has to move."""
    line, loop = 4.0, sw.train.from_bandwidth(60.0 * math.pi, J_M + J_L / N**2)
    drive = sw.HDC_40_050.train(
        motor_torque=sw.Harmonic(T_M), load_torque=sw.Harmonic(line, order=2), control=loop, omega=omega
    )
    found = sw.compensate(drive, "inverse", speed=omega, sampling=IDEAL, robust=False)
    settle, end = times_of(bench_of(drive, IDEAL), omega)
    first, last, gains = round(settle / H), round(end / H), (loop.K_p, loop.K_d)
    nothing = np.zeros((2, 2))
    plain = train(omega, gains, line, nothing[0], nothing, last)
    u = -line / (K + 2j * omega * B)
    ahead = np.exp(1j * omega * LEAD * np.array([1.0, 2.0]))
    torque = ahead * np.array([-T_M, -line / N - J_M * N * (2.0 * omega) ** 2 * u])
    left = train(
        omega, gains, line, np.array([u.real, -u.imag]), np.column_stack([torque.real, -torque.imag]), last
    )  # fmt: skip
    assert found.before.rms == pytest.approx(spread(plain[first:]), rel=0.01)
    assert found.after.rms == pytest.approx(spread(left[first:]), rel=0.02)
    assert found.after.rms < 0.01 * found.before.rms
    np.testing.assert_array_equal(found.orders, [1.0, 2.0])
    seeing = sw.compensate(drive, "adaptive", speed=omega, sampling=IDEAL, robust=False)
    assert seeing.after.rms < 1e-3 * found.before.rms


def test_a_torque_of_the_load_is_cancelled_by_the_motor_over_both_inertias():
    """x'' = T_m/(N J_m) - T_l/J_l: against T_l stands N J_m/J_l of it."""
    free = sw.HDC_40_050.train(
        motor_torque=sw.Harmonic(10.0, phase=0.4), load_torque=sw.Harmonic(3.0, order=2, mean=5.0),
        control=sw.train.TorqueDriven(),
    )  # fmt: skip
    bench = bench_of(free, IDEAL)
    assert bench.against[0] == sw.Harmonic(-10.0, phase=0.4)
    assert bench.against[1] == (pytest.approx(3.0 * N * J_M / J_L), 2, 0.0, 0.0)
    assert bench.start(100.0)[0] == pytest.approx(-J * 5.0 / J_L / K, rel=1e-6)  # K x = J F of the means
    equation = sw.HDC_40_050.error_equation(
        motor_torque=sw.Harmonic(10.0, phase=0.4), load_torque=sw.Harmonic(3.0, order=2, mean=5.0), omega=100.0
    )  # fmt: skip
    state = (0.02, 0.3, 0.0, 0.0, 0.0)
    moved = bench.model._replace(omega=100.0).rhs(0.7, state)
    np.testing.assert_allclose(moved[:2], equation.rhs(0.7, state[:2]), rtol=1e-12)
    assert moved[2:] == (0.0, 0.0, 0.0)  # the motor's own motion is left out


def test_units_scatter_in_torque_lines_as_in_lines_of_an_error():
    error = sw.KinematicError((sw.Line(2, 1e-4),))
    drive = sw.HDC_40_050.train(kinematic_error=error, motor_torque=sw.Harmonic(10.0, mean=1.0))
    unit = unit_of(drive, 1.1, 0.5, [0.2, 0.3])
    assert unit.error.lines == (sw.Line(2, 5e-5, 0.2),)
    assert unit.motor.excitation == sw.Harmonic(5.0, phase=0.3, mean=1.0)
    assert unit.law.torque(0.0) == 0.0
    assert unit.law.stiffness(0.0) == pytest.approx(1.1 * K)
    assert [line.order for line in lines_in(unit)] == [2, 1]


@pytest.mark.slow
def test_a_prediction_over_the_speed_becomes_the_torque_that_cancels(article):
    """By harmonic balance and by the closed forms: it is -T_m, ahead of the delay, wherever the drive is predicted."""
    table = sw.prediction_table(article)
    assert table.orders.tolist() == [1]
    assert abs(table.at(OMEGA_0)[0][0]) == pytest.approx(STEADY["primary"], rel=2e-3)
    assert "at 459 rad/s" in str(table)
    assert "rpm" not in str(table)
    for closed in (False, True):
        found = sw.study.speed_table(article, (100.0, 350.0), table=table, closed=closed, sampling=IDEAL)
        torque = np.array(found.cosines) - 1j * np.array(found.sines)
        wanted = -T_M * np.exp(1j * LEAD * np.array(found.speeds)) / np.sinc(0.5 * H * np.array(found.speeds) / np.pi)
        np.testing.assert_allclose(torque, wanted, rtol=5e-3)


@pytest.mark.slow
def test_the_command_speaks_of_the_forcing(tmp_path):
    asked = ["--controller", "inverse", "--controller", "angle", "--speed", "300 rad/s"]
    run = CliRunner().invoke(command.cli, ["compensate", str(ARTICLE), *asked, "-o", str(tmp_path)])
    assert run.exit_code == 0, run.output
    assert run.stdout.splitlines()[1].split() == ["forcing", "rad/s", "300"]
    assert "rpm" not in run.stdout
    assert "38.02 rad/s^2 per N*m to x''" in run.stdout
    assert "angle needs a motor that follows a reference, which the error equation lacks" in run.stdout
    row = json.loads((tmp_path / "compensation.json").read_text())["results"][1]
    assert (row["shaft"], row["speed_rad_per_s"]) == ("forcing", 300.0)
    assert "rpm" not in (tmp_path / "orders.svg").read_text()
    assert not list(tmp_path.glob("order-table*"))  # a forcing's phase is no angle that a drive knows


def test_what_no_torque_or_angle_of_the_motor_cancels_gets_a_sentence():
    loop = sw.train.from_bandwidth(60.0 * math.pi, J_M + J_L / N**2)
    with pytest.raises(ValueError, match="only a torque does; use 'inverse'"):
        sw.compensate(sw.HDC_40_050.train(motor_torque=sw.Harmonic(T_M), control=loop), "angle", speed=100.0)
    with pytest.raises(ValueError, match="neither a kinematic error nor a periodic torque: there is nothing to"):
        sw.compensate(sw.HDC_40_050.train(motor_torque=sw.Harmonic(0.0, mean=1.0), control=loop), speed=100.0)
