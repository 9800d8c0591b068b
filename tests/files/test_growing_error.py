"""A kinematic error whose amplitude grows with the mean torque: in the file, in the balance and in time."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import strainwave as sw
from strainwave.app.commands.compensation.order_tables import written_tables
from strainwave.files.reading import ProjectError, from_text
from strainwave.files.specification import read_specification
from strainwave.study.compensation.bench import bench_of

ARCSEC = math.pi / 648_000.0
LINES = "[{order: 2, amplitude: {at_rest: 20 arcsec, per_torque: 0.1 arcsec/(N*m)}, phase: 30 deg}, " \
        "{order: 4, amplitude: 2 arcsec}]"  # fmt: skip
TEXT = f"""\
gear: {{ratio: 50, law: {{type: linear, K: 3e4 N*m/rad}}}}
motor: {{inertia: 5 kg*cm^2, mode: held}}
load: {{inertia: 1.3 kg*m^2}}
damping: {{B: 20 N*m*s/rad}}
speed: {{from: 300 rpm, to: 900 rpm, shaft: motor}}
excitation: {{kinematic_error: {LINES}, load_torque: {{mean: -60 N*m}}}}
"""


def project(text=TEXT):
    return from_text(text, Path("axis.yaml"))


def sizes(error):
    return [line.amplitude / ARCSEC for line in error.lines]


def test_the_error_is_that_under_the_torque_of_the_load():
    axis = project()
    assert sizes(axis.kinematic_error) == pytest.approx([26.0, 2.0])
    assert sizes(axis.whole.error) == pytest.approx([26.0, 2.0])
    assert any("grows with the torque. It is computed for the mean load torque of -60 N*m" in x for x in axis.notes)
    for torque, size in ((0.0, 20.0), (40.0, 16.0), (-200.0, 40.0), (300.0, -10.0)):
        other = axis.under(torque)
        assert sizes(other.kinematic_error) == pytest.approx([size, 2.0])
        assert sizes(other.whole.error) == pytest.approx([size, 2.0])
        assert sizes(axis.equation_of(axis.drive, torque).error) == pytest.approx([size, 2.0])
    turned = project(TEXT.replace("mean: -60 N*m", "mean: {from: -60 N*m, to: 300 N*m}"))
    assert any(x.startswith("Under a load torque of 300 N*m, per_torque makes an amplitude") for x in turned.notes)
    assert not any("per_torque" in x for x in axis.notes)
    middle = project(TEXT.replace("mean: -60 N*m", "mean: {from: -60 N*m, to: 20 N*m}"))
    assert sizes(middle.kinematic_error) == pytest.approx([22.0, 2.0])


def test_it_is_written_back():
    other = replace(project(), title="another")
    again = project(sw.project_text(other))
    assert again.loaded_error == other.loaded_error
    assert again.kinematic_error == other.kinematic_error


@pytest.mark.parametrize("torque", [-60.0, 40.0])
def test_balance_and_integration_have_the_error_of_the_torque(torque):
    """Lagrange's equation of a held motor, J theta_l'' = T_l + K u + B u', u = theta_m/N - theta_l - e, by SciPy."""
    axis, omega, size = project().under(torque), 60.0, (20.0 - 0.1 * torque) * ARCSEC
    K, B, J, phase = 3e4, 20.0, 1.3, math.radians(30.0)
    lines = ((2, size, phase), (4, 2.0 * ARCSEC, 0.0))

    def rates(t, y):
        e = sum(A * math.cos(k * omega * t + p) for k, A, p in lines)
        de = sum(-A * k * omega * math.sin(k * omega * t + p) for k, A, p in lines)
        u, du = omega * t / 50.0 - y[0] - e, omega / 50.0 - y[1] - de
        return [y[1], (torque + K * u + B * du) / J]

    turn = 2.0 * math.pi / omega
    at = np.linspace(30.0 * turn, 31.0 * turn, 400, endpoint=False)
    start = [torque / K, omega / 50.0]
    theta = solve_ivp(rates, (0.0, at[-1]), start, "DOP853", at, rtol=1e-10, atol=1e-13).y[0]
    error = omega * at / 50.0 - theta
    spectrum = 2.0 * np.abs(np.fft.rfft(error)) / len(at)
    orbit = sw.find_orbit(axis.system(omega), harmonics=6)
    assert orbit.amplitude(2) == pytest.approx(spectrum[2], rel=1e-6)
    assert orbit.amplitude(4) == pytest.approx(spectrum[4], rel=1e-5)
    state = [-torque / K, 0.0]
    times = np.append(0.0, at)
    run = sw.simulate(axis.whole._replace(omega=omega), state, times, method=sw.Dopri5(rtol=1e-10, atol=1e-13))
    assert 2.0 * np.abs(np.fft.rfft(run.y[0, 1:]))[2] / len(at) == pytest.approx(spectrum[2], rel=1e-5)


def test_what_knows_one_amplitude_refuses_a_growing_one(tmp_path):
    error = project().kinematic_error
    for per_torque, said in (((1.0,), "has 1 numbers and the error 2 lines"), ((1.0, math.nan), "must be a finite")):
        with pytest.raises(ValueError, match=said):
            sw.gears.LoadedError(error, per_torque).under(1.0)
    for wrong, said in (
        ("{per_torque: 0.1 arcsec/(N*m)}", "at_rest"),
        ("{at_rest: -1 arcsec, per_torque: 0.1 arcsec/(N*m)}", "negative"),
        ("{at_rest: 20 arcsec, per_torque: 0.1 arcsec}", "write for example 1.5 rad/"),
    ):
        with pytest.raises(ProjectError, match=said):
            project(TEXT.replace("{at_rest: 20 arcsec, per_torque: 0.1 arcsec/(N*m)}", wrong))
    design = Path(__file__).parents[2] / "examples" / "projects" / "elbow.yaml"
    text = design.read_text(encoding="utf-8") + f"\nexcitation: {{kinematic_error: {LINES}}}\n"
    (tmp_path / "design.yaml").write_text(text, encoding="utf-8")
    with pytest.raises(ValueError, match="depends on torque or direction; a design needs one amplitude"):
        read_specification(tmp_path / "design.yaml")


def test_its_numbers_scatter_and_change_and_an_export_says_its_torque(tmp_path):
    changed = sw.replaced(project(), {"excitation.kinematic_error.0.amplitude.at_rest": "25 arcsec"})
    assert sizes(changed.kinematic_error) == pytest.approx([31.0, 2.0])
    with pytest.raises(ProjectError, match=r"gives .*kinematic_error\.0\.amplitude\.at_rest"):
        project(TEXT + "scatter: {kinematic_error.0.amplitude: 5 %}\n")
    notes = sw.export(project(), tmp_path / "axis.c", to="c").notes
    assert any("kinematic error is always that of forward motion under the mean torque" in note for note in notes)


BOTH_WAYS = (
    TEXT.replace("0.1 arcsec/(N*m)}", "0.1 arcsec/(N*m), backward: 8 arcsec}")
    + "controller: {period: 500 us, delay: 500 us, load_encoder: 24 bit}\n"
).replace("mode: held", "loop: {bandwidth: 20 Hz}")


@pytest.mark.slow
def test_backward_motion_has_its_own_error():
    axis = project(BOTH_WAYS)
    assert sizes(axis.kinematic_error) == pytest.approx([26.0, 2.0])
    assert sizes(axis.loaded_error.under(60.0, backward=True)) == pytest.approx([14.0, 2.0])
    assert any("differs in backward motion" in note for note in axis.notes)
    again = project(sw.project_text(replace(axis, title="another")))
    assert again.loaded_error == axis.loaded_error
    axis = axis.under(0.0)  # under a torque the motor feels e' T, whose phase depends on the direction
    found = {speed: sw.compensate(axis, "inverse", speed=speed, robust=False) for speed in (40.0, -40.0)}
    ahead, back = (found[speed].amplitude_before[0] for speed in (40.0, -40.0))
    assert back / ahead == pytest.approx(8.0 / 20.0, rel=0.01)  # a linear gear: as the lines
    for one in found.values():
        assert one.after.rms < 0.05 * one.before.rms
    assert sizes(found[-40.0].controller.error) == pytest.approx([8.0, 2.0])
    bench = bench_of(axis)
    tables = {speed: dict(written_tables(bench, one))["angle"].table for speed, one in found.items()}
    assert [tables[speed].direction for speed in (40.0, -40.0)] == ["forward", "backward"]
    assert tables[-40.0].lines[0].amplitude / ARCSEC == pytest.approx(8.0)
    move = sw.move(axis, sw.Trapezoid(-0.3, 0.4))
    assert any("a move uses the error of forward motion throughout" in remark for remark in move.remarks)
