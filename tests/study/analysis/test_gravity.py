"""Speeds to avoid of a joint under gravity: its steady curve has constant torques, its run-up has the whole one."""

import html
import json
import math
import re

import numpy as np
import pytest
from click.testing import CliRunner
from scipy.integrate import solve_ivp
from three_slopes import three_slopes

import strainwave as sw
from strainwave.app.commands import cli as command
from strainwave.files.reading import read_project
from strainwave.study.analysis.load_cases import avoid_under_all, load_cases
from strainwave.study.speed_map import under_load
from strainwave.study.speed_map.decide import decide
from strainwave.study.speed_map.rules import complement, rules_of
from strainwave.study.speed_map.under_load import seeks_coexisting

RPM = 30.0 / math.pi
GEAR = (1e5, 1.4e5, 1.8e5, 54.0, 196.0)
N, J, B, WEIGHT, A = 50.0, 1.0, 60.0, 150.0, 10.0 * math.pi / 648000.0
PROJECT = f"""\
title: Joint under gravity
gear:
  ratio: {N:g}
  law:
    {{type: piecewise_linear, K1: {GEAR[0]} N*m/rad, K2: {GEAR[1]} N*m/rad, K3: {GEAR[2]} N*m/rad, T1: {GEAR[3]} N*m,
     T2: {GEAR[4]} N*m}}
motor: {{inertia: 5 kg*cm^2, mode: held}}
load: {{inertia: {J} kg*m^2, drag: {{type: angle_torque, amplitude: {WEIGHT} N*m}}}}
damping: {{B: {B} N*m*s/rad}}
speed: {{from: 1100 rpm, to: 2200 rpm, shaft: motor}}
excitation: {{kinematic_error: [{{order: 2, amplitude: 10 arcsec}}]}}
"""


def decided(project):
    return decide(project, rules_of(None, None, None, project.limit), search=False, threads=1)


def run_up(payload=0.0):
    """Motor speeds [rpm] and oscillations [rad] of the ramp, by DOP853: x about the mean of its turns.

    `payload` is the load's angle [rad] at the start.
    """
    low, high = 1100.0 / RPM, 2200.0 / RPM
    length, begin, onset = 40.0 * J / B, 8.0 * J / B, 8.0 * J / B

    def motor(t):
        early = np.clip(t - begin, 0.0, onset)  # while the acceleration begins
        late, rate = np.maximum(t - begin - onset, 0.0), (high - low) / (length - 0.5 * onset)
        angle = early**3 / (6.0 * onset) + 0.5 * late * (onset + late)
        return low * t + rate * angle, low + rate * (0.5 * early**2 / onset + late), rate * early / onset

    def rates(t, y):
        angle, speed, acceleration = motor(t)
        u, du = y[0] - A * math.cos(2.0 * angle), y[1] + 2.0 * A * speed * math.sin(2.0 * angle)
        torque = three_slopes(u, GEAR) + B * du
        load = angle / N - y[0]
        return y[1], acceleration / N - (torque - WEIGHT * math.sin(load + payload)) / J

    t = np.linspace(0.0, begin + length, 20001)
    found = solve_ivp(rates, (0.0, t[-1]), (0.0, 0.0), "DOP853", t_eval=t, rtol=1e-8, atol=1e-12, max_step=1e-3)
    angle, speed, _ = motor(t)
    inside = t >= begin
    x, turned = found.y[0, inside], angle[inside] - angle[inside][0]
    starts = np.flatnonzero(np.diff(np.floor(turned / (2.0 * math.pi)), prepend=-1.0))
    means, middles = np.add.reduceat(x, starts)[:-1] / np.diff(starts), 0.5 * (starts[1:] + starts[:-1] - 1)
    between = slice(int(middles[0]), int(middles[-1]))  # a line through the mean of each turn at its middle
    size = np.abs(x - np.interp(np.arange(len(x)), middles, means))
    return speed[inside][between] * RPM, size[between]


@pytest.mark.slow
def test_the_run_ups_own_peak_is_avoided_and_what_the_speeds_are_for_is_said_beside_them(tmp_path):
    (tmp_path / "joint.yaml").write_text(PROJECT)
    options = ["analyze", str(tmp_path / "joint.yaml"), "-o", str(tmp_path / "out")]
    result = CliRunner().invoke(command.cli, options)
    assert result.exit_code == 0, result.stderr
    results = json.loads((tmp_path / "out" / "results.json").read_text(encoding="utf-8"))
    advice = results["advice"]
    speed, size = run_up()
    peak = speed[np.argmax(size)]
    bands = [(band["from_rpm"], band["to_rpm"]) for key in ("bands", "run_up_bands") for band in advice[key]]
    assert any(low < peak < high for low, high in bands)
    assert any(low < results["train"]["run_up"]["at_rpm"] < high for low, high in bands)
    torques = [case["load_torque_Nm"] for case in advice["by_load_torque"]]
    said = f"cover {len(torques)} load torques from −150 to 150 N·m and the gaps between their bands: at −150 N·m"
    assert said in advice["about"]
    assert torques == sorted(torques)
    assert (torques[0], torques[-1]) == pytest.approx((-150.0, 150.0))
    assert len(torques) >= 9
    told = re.search(r"about the mean of each turn up to ([0-9.]+) arcsec at ([0-9]+)", advice["about"])
    assert float(told[1]) == pytest.approx(np.max(size) * 648000.0 / math.pi, rel=0.02)
    assert float(told[2]) == pytest.approx(peak, rel=0.03)
    page = html.unescape((tmp_path / "out" / "report.html").read_text(encoding="utf-8"))
    first, second = page.index(advice["sentence"]), page.index(advice["about"])
    assert first < second


def test_the_bands_of_a_range_of_torques_hold_the_largest_error_of_run_ups_at_random_payload_angles(tmp_path):
    (tmp_path / "joint.yaml").write_text(PROJECT)
    project = read_project(tmp_path / "joint.yaml")
    assert project.load_torques == pytest.approx((-WEIGHT, WEIGHT), rel=1e-3)
    bands = complement(decided(project).quiet, project.speeds.limits)
    for payload in np.random.default_rng(3).uniform(-math.pi, math.pi, 10):
        speed, size = run_up(payload)
        peak = speed[np.argmax(size)] / RPM
        assert any(low <= peak <= high for low, high in bands), f"payload at {payload:.2f} rad: {peak * RPM:.0f} rpm"


@pytest.mark.slow
def test_jumps_that_move_with_the_load_are_avoided_between_the_torques_that_are_computed(tmp_path):
    (tmp_path / "worn.yaml").write_text(
        """gear: CSF-25-80
backlash: {half_gap: 15 arcsec}
motor:
  {inertia: 1.3 kg*cm^2, drag: {type: viscous, B: 3e-4 N*m*s/rad}, loop: {type: speed_loop, K_p: 0.06 N*m*s/rad,
   K_i: 2 N*m/rad}}
load: {inertia: 0.9 kg*m^2}
damping: {B: 12 N*m*s/rad}
speed: {from: 300 rpm, to: 2400 rpm, shaft: motor}
excitation: {accuracy: catalogue, load_torque: {mean: {from: -12 N*m, to: 2 N*m}}}
"""
    )
    project = read_project(tmp_path / "worn.yaml")
    bands = complement(decided(project).quiet, project.speeds.limits)
    allowed = sw.speed_map(project, search=False, threads=1).windows
    jumps = [band for torque in (-2.2, -1.8, -1.2, -0.9, -0.7)
             for band in project.under(torque).response(coexisting=False).sweep.jumping]  # fmt: skip
    assert len(jumps) == 5
    for jump in jumps:
        assert any(low <= jump.low and jump.high <= high for low, high in bands)
        assert not any(low < jump.high and jump.low < high for low, high in allowed)


def test_no_speed_is_allowed_under_a_torque_of_the_range_that_leaves_no_stable_motion(tmp_path):
    (tmp_path / "gap.yaml").write_text(
        """gear: {ratio: 100, law: {type: linear, K: 1.1e5 N*m/rad}}
backlash: {half_gap: 0.2 mrad}
motor: {inertia: 4 kg*cm^2, mode: held}
load: {inertia: 3 kg*m^2}
damping: {B: 90 N*m*s/rad}
speed: {from: 300 rpm, to: 900 rpm, shaft: motor}
excitation: {kinematic_error: [{order: 3, amplitude: 7 arcsec}], load_torque: {mean: {from: -90 N*m, to: 0 N*m}}}
limit: {oscillation: 340 arcsec}
"""
    )
    project = read_project(tmp_path / "gap.yaml")
    drive, found = project.response(coexisting=False), decided(project)
    cases = load_cases(project, found)
    curve = sw.speed_map(project, loads=[case.torque for case in cases], search=False, threads=1)
    for case, forbidden in zip(cases, curve.forbidden, strict=True):
        assert np.array(case.bands).reshape(-1, 2) == pytest.approx(forbidden), case.torque
    assert curve.allowed[-1].size == 0  # without a load nothing holds the teeth together
    whole = avoid_under_all(drive, found, cases, project.limit, None)
    assert whole.bands == whole.unstable == (project.speeds.limits,)


def test_no_speed_is_allowed_where_the_error_equation_has_stable_motions_and_the_whole_drive_has_none(
    tmp_path, monkeypatch
):
    (tmp_path / "loop.yaml").write_text(PROJECT.replace("mode: held", "loop: {bandwidth: 60 Hz, damping: 0.7}"))
    project = read_project(tmp_path / "loop.yaml")
    reduced = project.under(0.0).equation_response(coexisting=False)
    assert np.any(reduced.curve.stable)
    monkeypatch.setattr(under_load, "train_motions", lambda *_, **__: None)
    cases = load_cases(project, decided(project))
    assert len(cases) == 9
    assert all(case.bands == case.unstable == (project.speeds.limits,) for case in cases)


def test_under_the_torques_of_a_range_a_gap_or_a_memory_is_spared_the_search_for_other_motions():
    hysteresis = sw.BoucWen(1e4, 0.0, 1e-4)
    assert seeks_coexisting(sw.PiecewiseLinear(6.7e4, 1.1e5, 1.2e5, 29.0, 108.0))
    assert not seeks_coexisting(sw.Backlash(1e5, 5e-5))
    assert not seeks_coexisting(sw.Play(5e-5, sw.Linear(1e5)))
    assert not seeks_coexisting(sw.Parallel(sw.Linear(1e5), hysteresis))
