"""Predictions against runs of the loop, by branch; and a torque over speed that cancels a run-up."""

from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import strainwave as sw
from strainwave.files.reading import from_text
from strainwave.study.compensation.bench import bench_of
from strainwave.study.compensation.prediction import PredictionTable

TEXT = """
gear: {ratio: 50, law: {type: linear, K: 1e5 N*m/rad}}
motor: {inertia: 14.5 kg*cm^2, loop: {bandwidth: 30 Hz}}
load: {inertia: 10 kg*m^2}
damping: {ratio: 3 %}
speed: {from: 20 rad/s, to: 70 rad/s, shaft: motor}
excitation: {kinematic_error: [{order: 2, amplitude: 23 arcsec}, {order: 4, amplitude: 6 arcsec, phase: 40 deg}]}
"""
HARDENING = """
gear: {ratio: 50, law: {type: cubic, K: 1e5 N*m/rad, alpha: 2e4 1/rad^2}}
motor: {inertia: 14.5 kg*cm^2}
load: {inertia: 10 kg*m^2}
damping: {ratio: 2 %}
speed: {from: 20 rad/s, to: 30 rad/s, shaft: motor}
excitation: {kinematic_error: [{order: 2, amplitude: 23 arcsec}]}
"""
QUICK = sw.controllers.Sampling(2e-5, 0.0)


def project():
    return from_text(TEXT, Path("axis.yaml"))


@pytest.mark.slow
def test_a_prediction_is_what_the_loop_does():
    table, bench = sw.prediction_table(project(), np.array([2, 4])), bench_of(project(), QUICK)
    assert table.orders.tolist() == [2, 4]
    for speed in (25.0, 40.0, 55.0):
        amplitudes, flag = table.at(speed)
        assert flag == ""
        run = sw.numerics.loop_ensemble(
            bench.closed(bench.loop, speed), {}, 3.0 + 10.0 * np.pi / speed, settle=3.0, orders=[2, 4]
        )
        seen = run.amplitude[:, 0] * np.exp(1j * run.phase[:, 0])
        np.testing.assert_allclose(amplitudes, seen, atol=0.01 * np.max(np.abs(seen)))


@pytest.mark.slow
def test_a_table_over_speed_cancels_a_run_up():
    sampling = sw.controllers.Sampling(2.5e-4, 2.5e-4)
    bench = bench_of(project(), sampling)
    controller = sw.study.speed_table(project(), (22.0, 68.0), sampling=sampling)
    motion = sw.train.SpeedProfile((0.0, 2.0, 22.0), (25.0, 25.0, 65.0))
    closed = bench.closed(bench.loop, 1.0)
    closed = closed._replace(train=closed.train._replace(reference=motion))
    plain, better = (
        sw.numerics.run_loop(closed._replace(controller=c), 22.0, y0=bench.start(25.0))
        for c in (bench.loop, controller)
    )
    assert better.rms(4.0) < 0.15 * plain.rms(4.0)


def hardening(omega, start):
    """Amplitude of order 2 of the load's error that SciPy finds on the way from a speed to another, and its end."""
    J, K, alpha, B, e = 10.0, 1e5, 2e4, 2.0 * 0.02 * np.sqrt(1e5 * 10.0), 23.0 * np.pi / 648000.0
    ramp, wait = 24.0, 8.0

    def rhs(t, y):
        s = min(t / ramp, 1.0)
        speed = start + (omega - start) * s
        angle = start * t + (omega - start) * (0.5 * min(t, ramp) * s + max(t - ramp, 0.0))
        u, du = y[0] - e * np.cos(2 * angle), y[1] + 2 * speed * e * np.sin(2 * angle)
        return [y[1], -(K * (u + alpha * u**3) + B * du) / J]

    end = ramp + wait
    t = end - np.arange(64)[::-1] / 64 * 2.0 * np.pi / omega
    x = solve_ivp(rhs, (0.0, end), [0.0, 0.0], method="DOP853", t_eval=t, rtol=1e-9, atol=1e-13).y[0]
    angle = 0.5 * (start + omega) * ramp + omega * (t - ramp)
    return 2.0 / 64.0 * np.sum(x * np.exp(-2j * angle))


@pytest.mark.slow
def test_both_motions_of_a_hardening_gear_are_those_of_scipy():
    table = sw.prediction_table(from_text(HARDENING, Path("axis.yaml")), speeds=(40.0, 60.0))
    (up,), (down,) = table.jumps_up, table.jumps_down
    for direction, start, (a, b) in zip((1, -1), (46.0, 58.0), table.runs(), strict=True):
        point = float(table.omega[a + np.argmin(np.abs(table.omega[a:b] - 0.5 * (up + down)))])
        assert down < point < up
        exact = hardening(point, start)
        for closed, error in ((False, 1e-4), (True, 1e-3)):
            amplitudes, flag = table.at(point, direction, closed=closed)
            assert flag == ""
            assert abs(amplitudes[0] - exact) < error * abs(exact)
        across = up + 0.15 if direction > 0 else down - 0.15
        other = table.at(across, direction)[0][0]
        assert abs(hardening(across, start) - other) < 5e-3 * abs(other)
        assert (abs(other) < abs(exact)) == (direction > 0)


def test_a_run_reaches_the_fold():
    table = sw.prediction_table(from_text(HARDENING, Path("axis.yaml")), speeds=(40.0, 60.0), closed=False)
    (first, last), (other, _) = table.runs()
    assert table.omega[last - 1] == table.jumps_up[0]
    assert table.omega[other] == table.jumps_down[0]
    up, down = table.jumps_up[0], table.jumps_down[0]
    assert abs(table.at(up)[0][0]) > 3.0 * abs(table.at(up + 1e-6)[0][0])
    assert abs(table.at(down - 1e-6, -1)[0][0]) > 1.5 * abs(table.at(down, -1)[0][0])
    assert first == 0
    assert table.closed is None


def test_a_closed_form_is_flagged_where_the_vibration_is_beyond_it():
    """A gear whose cubic torque comes near its linear one, beyond what second order holds."""
    stiff = HARDENING.replace("2e4 1/rad^2", "1e6 1/rad^2").replace("23 arcsec", "200 arcsec").replace("2 %", "10 %")
    table = sw.prediction_table(from_text(stiff, Path("axis.yaml")), speeds=(30.0, 75.0))
    beyond = np.isfinite(table.closed[0]) & ~table.valid
    assert np.any(beyond)
    assert np.any(table.valid)
    assert np.max(np.abs(table.amplitudes[0, table.valid])) < np.max(np.abs(table.amplitudes[0, beyond]))
    assert any("the closed form is not valid: the vibration is larger" in text for text in table.remarks)
    speed = float(table.omega[np.flatnonzero(beyond & table.stable)[-1]])
    assert "not valid at this speed" in table.at(speed, closed=True)[1]


def test_closed_forms_are_those_of_a_held_motor():
    table = sw.prediction_table(project(), speeds=(45.0, 65.0))
    assert any("to a held motor" in text for text in table.remarks)
    u, e = 65.0 * 2.0, 23.0 * np.pi / 648000.0
    c = 2.0 * 0.03 * 100.0
    exact = e * (1e4 + 1j * c * u) / (1e4 - u * u + 1j * c * u)  # of x'' + c (x - e)' + 1e4 (x - e) = 0
    assert abs(table.closed[0, -1] - exact) < 1e-6 * abs(exact)


def test_each_direction_stays_on_its_motion_until_it_ends():
    """A hardening curve: up to 5, back to 3 unstable, on from 3."""
    omega = np.array([1.0, 2.0, 3.0, 4.0, 5.0, 4.5, 4.0, 3.5, 3.0, 4.0, 5.0, 6.0])
    size = np.array([1.0, 2.0, 3.0, 4.0, 5.0, 4.0, 3.5, 3.0, 1.5, 1.0, 0.8, 0.6])
    stable = np.array([1, 1, 1, 1, 1, 0, 0, 0, 1, 1, 1, 1], bool)
    table = PredictionTable(omega, np.array([2]), size[None].astype(complex), stable)
    assert table.at(4.0)[0][0] == 4.0
    assert table.at(4.0, -1)[0][0] == 1.0
    assert table.at(5.5)[0][0] == pytest.approx(0.7)
    assert table.at(2.5, -1)[0][0] == 2.5
    assert np.isnan(table.at(7.0)[0][0])
    assert "outside of the table" in table.at(7.0)[1]
    with pytest.raises(ValueError, match="direction is 2"):
        table.at(4.0, 2)


def test_what_has_no_prediction_gets_a_sentence():
    for orders in ((0,), (-2,), (1.5,), (100_000,)):
        with pytest.raises(ValueError, match="give integers from 1 to"):
            sw.prediction_table(project(), orders)
    table = PredictionTable(np.array([30.0, 40.0]), np.array([2]), np.ones((1, 2), complex), np.ones(2, bool))
    assert "has no closed forms" in table.at(35.0, closed=True)[1]
    with pytest.raises(ValueError, match=r"speeds \[rad/s\]"):
        sw.prediction_table(project(), speeds=(50.0, 40.0))
    with pytest.raises(ValueError, match="no prediction at"):
        sw.study.speed_table(project(), (30.0, 50.0), table=table)
