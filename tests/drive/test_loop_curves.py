"""Steps of a motor's loop against equations by hand; the margins that its figure marks, against Nyquist's curve."""

import re
from dataclasses import replace

import numpy as np
import pytest
from sampled_axis import Axis, margins_by_hand
from scipy.integrate import solve_ivp
from scipy.linalg import expm

import strainwave as sw
from strainwave.drive.loops.loop_curves import loop_curves
from strainwave.drive.loops.worst_margins import Loaded, WorstMargins
from strainwave.model.train.controls import SpeedLoop
from strainwave.plot.loop import motor_loop_panels

# K_v 40 1/s, K_p 0.3 N*m*s/rad, T_n 16 ms; 0.5 ms of lag, 2 kHz with a delay of 0.7 periods
AXIS = Axis(4.5e-4, 1.3, 100, 1e5, 20.0, 0.0, None, 40.0, 0.3, 16e-3, None, 5e-4, None, "motor", 5e-4, 3.5e-4)


def read(axis, folder, sampled=True):
    text = axis.text() if sampled else re.sub("controller: .*\n", "", axis.text())
    (folder / "axis.yaml").write_text(text, encoding="utf-8")
    return sw.read_project(folder / "axis.yaml")


def by_hand(times, torque):
    """Motor and load in time without samples: after a step of the reference speed to 1, or of a torque on the load."""
    J_m, J_l, N, K, B = AXIS.J_m, AXIS.J_l, AXIS.N, AXIS.K, AXIS.B
    speed = 0.0 if torque else 1.0

    def rates(t, y):
        motor, motor_speed, load, load_speed, integral, given = y
        x, v = motor - speed * t, motor_speed - speed
        w = v + AXIS.K_v * x
        gear = K * (motor / N - load) + B * (motor_speed / N - load_speed)
        wanted = -AXIS.K_p * (w + integral / AXIS.T_n)
        return (
            motor_speed, (given - gear / N) / J_m, load_speed, (gear + torque) / J_l, w, (wanted - given) / AXIS.lag
        )  # fmt: skip

    return solve_ivp(rates, (0.0, times[-1]), np.zeros(6), t_eval=times, rtol=1e-10, atol=1e-16, method="Radau").y


def test_steps_are_those_of_the_equations(tmp_path):
    found = loop_curves(read(AXIS, tmp_path, sampled=False).loop)
    y = by_hand(found.time, 0.0)
    np.testing.assert_allclose(found.speeds[0], y[1], atol=1e-6)
    np.testing.assert_allclose(found.speeds[1], AXIS.N * y[3], atol=1e-6)
    y = by_hand(found.time, 1.0)
    np.testing.assert_allclose(found.angles[0], y[0] / AXIS.N, atol=1e-11)
    np.testing.assert_allclose(found.angles[1], y[2], atol=1e-11)
    assert found.angles[1][-1] == pytest.approx(1.0 / AXIS.K, rel=0.05)  # the integral holds the motor, not the gear


def sampled_by_hand(steps, torque):
    """The same from sample to sample: rows of motor's speed, load's speed, motor's angle, load's angle."""
    A, b, _, _ = AXIS.continuous()  # angles of motor and load, speeds, torque of the lag
    n, T, late = len(A), AXIS.period, AXIS.delay
    on_load = np.zeros(n)
    on_load[3] = torque / AXIS.J_l
    speed = 0.0 if torque else 1.0

    def moved(y, command, time):
        M = np.zeros((n + 1, n + 1))
        M[:n, :n], M[:n, n] = A, b * command + on_load
        return (expm(M * time) @ np.append(y, 1.0))[:n]

    y, before, total, rows = np.zeros(n), 0.0, 0.0, []
    for k in range(steps):
        rows.append(y[[2, 3, 0, 1]])
        w = y[2] - speed + AXIS.K_v * (y[0] - speed * k * T)
        total += T * w
        now = -AXIS.K_p * (w + total / AXIS.T_n)
        y = moved(moved(y, before, late), now, T - late)
        before = now
    return np.array(rows).T


def test_steps_of_a_sampled_loop_are_those_from_sample_to_sample(tmp_path):
    found = loop_curves(read(AXIS, tmp_path).loop)
    every = round(found.time[1] / AXIS.period)
    assert found.time[1] == pytest.approx(every * AXIS.period, rel=1e-12)
    steps = every * (len(found.time) - 1) + 1
    of_reference, of_torque = (sampled_by_hand(steps, torque)[:, ::every] for torque in (0.0, 1.0))
    np.testing.assert_allclose(found.speeds[0], of_reference[0], atol=1e-9)
    np.testing.assert_allclose(found.speeds[1], AXIS.N * of_reference[1], atol=1e-9)
    np.testing.assert_allclose(found.angles[0], of_torque[2] / AXIS.N, atol=1e-14)
    np.testing.assert_allclose(found.angles[1], of_torque[3], atol=1e-14)


def test_a_gain_that_acts_as_inertia_takes_its_part_of_the_reference_at_once(tmp_path):
    train = read(AXIS, tmp_path, sampled=False).train
    K_d = 3e-4
    loop = WorstMargins.of([Loaded("", None, train.with_motor(control=SpeedLoop(0.3, 5.0, K_d)))], None)
    found = loop_curves(loop)
    assert found.speeds[0][0] == pytest.approx(K_d / (AXIS.J_m + K_d), rel=1e-9)
    assert found.speeds[1][0] == pytest.approx(0.0, abs=1e-12)


def test_the_marks_are_the_margins_of_nyquist_and_of_the_library(tmp_path):
    drive = read(AXIS, tmp_path)
    size, phase, *_ = motor_loop_panels(drive.loop)
    (text,) = [note.text for note in phase.notes]
    angle, hertz = map(float, re.fullmatch(r"([\d.]+)° at ([\d.]+) Hz", text).groups())
    library = sw.margins(drive.train, sampling=drive.sampling)
    phases, factors = margins_by_hand(AXIS)
    least = min(phases, key=abs)
    assert angle == pytest.approx(least, abs=0.6)
    assert angle == pytest.approx(np.degrees(library.phase_margin), abs=0.6)
    crossover = 2.0 * np.pi * hertz
    assert abs(AXIS.open_loop([crossover])[0]) == pytest.approx(1.0, abs=0.02)
    marked = [10.0 ** (float(note.text.split()[0].replace("−", "-")) / 20.0) for note in size.notes]
    inside = [factors[factors > 1.0].min(), factors[factors < 1.0].max()]
    assert marked == pytest.approx(inside, rel=0.06)  # two digits of decibels
    assert [library.gain_margin, library.gain_reduction] == pytest.approx(inside, rel=1e-3)


def test_an_unstable_loop_has_a_bode_plot_and_no_steps(tmp_path):
    late = replace(AXIS, K_p=3.0)
    assert np.max(np.abs(late.eigenvalues())) > 1.0
    panels = motor_loop_panels(read(late, tmp_path).loop)
    assert [panel.y.name for panel in panels] == ["magnitude", "phase"]
