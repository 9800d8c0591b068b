"""The loop as its controller samples it: eigenvalues and Nyquist curves by hand, and what every face makes of them."""

import html
import json

import numpy as np
import pytest
from click.testing import CliRunner
from sampled_axis import Axis, edges, margins_by_hand, within

import strainwave as sw
from strainwave.app.commands import cli
from strainwave.app.commands.response import facts
from strainwave.base.facts import data
from strainwave.drive.loops.linear_control import control_parts
from strainwave.drive.loops.margins import loop_of
from strainwave.drive.loops.worst_margins import loaded_trains
from strainwave.drive.operating_point import mean_state
from strainwave.study.compensation.bench import bench_of
from strainwave.study.tuning.open_loop import UNSTABLE, OpenLoop

# cascade K_v 60, K_p 0.5, T_n 8 ms at 1 kHz with 1 ms of delay: |eigenvalue| 1.153, gain margin 0.74 at 933 rad/s
LATE = Axis(4.5e-4, 1.3, 100, 1e5, 20.0, 0.0, None, 60.0, 0.5, 8e-3, None, 0.0, None, "motor", 1e-3, 1e-3)
# a telescope on a mount, 18 kg m^2 behind 0.4: 0.99972 with 1 ms of lag as a lag; it is no dead time
MOUNT = Axis(
    0.00025, 18.0, 100, 67e3, 44.41261082170244, 0.0, (0.4, 2.5e5, 60.0), 31.41592653589793, 0.26263714584010667,
    0.015597184423005742, None, 1e-3, None, "motor", 5e-4, 5e-4,
)  # fmt: skip
MOVE = "move: {profile: [{type: trapezoid, angle: 20 deg, time: 0.4 s}]}\n"


def project(axis, folder, more=""):
    path = folder / "axis.yaml"
    path.write_text(axis.text(more), encoding="utf-8")
    return sw.read_project(path)


def poles(drive):
    one = next(iter(loaded_trains(drive)))
    return loop_of(one.train, mean_state(one.train), one.train.omega, drive.sampling).poles


@pytest.mark.parametrize("axis", edges(8, seed=5), ids=lambda a: f"{a.encoder}-{a.filter and a.filter[0]}-{a.lag:.1g}")
def test_a_loop_at_the_edge_is_stable_where_its_eigenvalues_by_hand_say_so(axis, tmp_path):
    own, drive = np.max(np.abs(axis.eigenvalues())), project(axis, tmp_path)
    assert abs(own - 1.0) < 1e-3
    assert np.max(np.abs(poles(drive))) == pytest.approx(own, abs=2e-8)
    assert drive.loop.stable == (own < 1.0)
    assert bool(drive.loop_fault) == (own > 1.0)
    train = drive.train
    figures = OpenLoop(train, 0.0, drive.sampling).figures(control_parts(train.motor.control), train.motor.control)
    assert (figures != UNSTABLE) == (own < 1.0)
    judged = drive.judged(drive.response(coexisting=False, points=20))
    assert any("loop is unstable" in text for text in judged.failures) == (own > 1.0)


@pytest.mark.parametrize("axis", within(4), ids=lambda a: f"{a.encoder}-{a.filter and a.filter[0]}-{a.lag:.1g}")
def test_margins_are_those_of_the_nyquist_curve_by_its_aliases(axis, tmp_path):
    drive = project(axis, tmp_path)
    found, (phases, factors) = drive.loop.margins[0], margins_by_hand(axis)
    np.testing.assert_allclose(np.degrees(found.phase_margins), phases, atol=0.1)
    np.testing.assert_allclose(found.gain_margins, factors, rtol=1e-3)
    # what the search for gains goes by
    train = drive.train
    linear = OpenLoop(train, 0.0, drive.sampling).figures(control_parts(train.motor.control), train.motor.control)
    assert linear.phase_margin == pytest.approx(abs(found.phase_margin), abs=2e-3)
    assert linear.gain_margin == pytest.approx(found.gain_margin, rel=2e-3)
    assert linear.peak_sensitivity == pytest.approx(found.peak_sensitivity, rel=1e-3)


def test_a_lag_is_no_dead_time(tmp_path):
    drive = project(MOUNT, tmp_path)
    assert np.max(np.abs(MOUNT.eigenvalues())) == pytest.approx(0.99972, abs=5e-6)
    assert np.max(np.abs(poles(drive))) == pytest.approx(0.99972, abs=5e-6)
    assert drive.loop.stable
    assert drive.loop.weak.startswith("The loop is close to instability: peak sensitivity 7.81 (at most 2), phase ")
    told = data(facts(drive, drive.response(coexisting=False, points=20)))
    assert told["loop_margins"]["weak"] == drive.loop.weak
    # compensate goes on with the same lag; the speed of its loop is the difference of two angles
    loop = bench_of(drive).response(50.0)
    np.testing.assert_allclose(
        np.max(np.abs(loop.poles)), np.max(np.abs(MOUNT.eigenvalues(speed_by_difference=True))), rtol=1e-6
    )


@pytest.mark.slow
def test_an_unstable_loop_is_the_headline_of_every_face(tmp_path):
    drive = project(LATE, tmp_path, MOVE)
    assert np.max(np.abs(poles(drive))) == pytest.approx(1.1533832, abs=1e-7)
    margins = sw.margins(drive.train, sampling=drive.sampling)
    assert not margins.stable
    assert margins.gain_reduction == pytest.approx(0.7363, abs=1e-4)
    path, said = (
        str(tmp_path / "axis.yaml"),
        "loop is unstable with this gear: a vibration of 165 Hz grows by a factor e",
    )

    def told(*words):
        return json.loads(CliRunner().invoke(cli.cli, [*words, "--json"], catch_exceptions=False).stdout)

    response, mapped = told("response", path), told("speed-map", path)
    moved = told("move", path, "-o", str(tmp_path / "move"))
    for found in (response, mapped, moved):
        assert said in found["failures"][0]
        assert found["loop_margins"]["stable"] is False
    assert mapped["allowed_under_every_load_rpm"] == []
    assert response["passes"] is moved["passes"] is False
    verdict = told("analyze", path, "-o", str(tmp_path / "report"))["verdict"]
    assert verdict["headline"].startswith(f"Fail at every speed; the motor's {said}")
    assert verdict["allowed_speeds"] == []
    page = (tmp_path / "report" / "report.html").read_text(encoding="utf-8")
    assert f"Fail at every speed; the motor's {said}" in html.unescape(page)


def test_a_gear_that_is_stiffer_under_a_load_may_make_its_loop_unstable(tmp_path):
    text = LATE.text().replace(
        "controller: {period: 0.001 s, delay: 0.001 s}", "controller: {period: 0.001 s, delay: 0 s}"
    )
    law = "{type: piecewise_linear, K1: 1e5 N*m/rad, K2: 3e5 N*m/rad, K3: 3e5 N*m/rad, T1: 20 N*m, T2: 60 N*m}"
    text = text.replace("{type: linear, K: 100000.0 N*m/rad}", law).replace("K_p: 0.5", "K_p: 0.47")
    (tmp_path / "rest.yaml").write_text(text, encoding="utf-8")
    held = text.replace("excitation: {", "excitation: {load_torque: {mean: {from: -50 N*m, to: 0 N*m}}, ")
    (tmp_path / "held.yaml").write_text(held, encoding="utf-8")
    rest, loaded = sw.read_project(tmp_path / "rest.yaml"), sw.read_project(tmp_path / "held.yaml")
    assert len(rest.loop.loads) == 1
    assert len(loaded.loop.loads) == 2
    soft, stiff = (np.max(np.abs(Axis(*(LATE.__dict__ | {"K": K, "K_p": 0.47, "delay": 0.0}).values()).eigenvalues()))
                   for K in (1e5, 3e5))  # fmt: skip
    sizes = [np.exp(found.slowest.real * found.period) for found in loaded.loop.margins]
    assert sorted(sizes) == pytest.approx(sorted([soft, stiff]), abs=1e-8)
    assert loaded.loop.stable == (max(soft, stiff) < 1.0)
