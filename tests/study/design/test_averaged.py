"""Averaging of many drives at once: against closed forms, the slow flow and harmonic balance of the whole drive."""

import numpy as np
import pytest

import strainwave as sw
from strainwave.drive.train_curve import POINTS, largest_crest
from strainwave.study.design.averaged import Drives, certified_error, impedance, largest

GEAR = sw.catalogue.gear("CSG-40-50")
LINE = sw.KinematicError((sw.Line(2, 1e-4),))
CLASS = sw.gears.accuracy_spectrum(GEAR.accuracy)
J_L = np.array([0.4, 1.3, 6.0])


def held(law=None, error=LINE, torque=0.0, speeds=(50.0, 300.0), zeta=0.03):
    B = 2.0 * zeta * np.sqrt(GEAR.K1 * J_L)
    return Drives(law or GEAR.law, 50.0, torque, error, speeds, np.full(3, 6e-4), J_L, B)


def looped(drives, bandwidth=190.0):
    loop = sw.train.PositionLoop(bandwidth**2, 1.4 * bandwidth)
    return drives._replace(loop=loop, gain=drives.J_m + drives.J_l / 2500.0)


def train(drives, i):
    drive = sw.Drive(float(drives.J_m[i]), float(drives.J_l[i]), drives.N, float(drives.B[i]), drives.law)
    gain = np.broadcast_to(drives.gain, drives.J_l.shape)[i]
    control = sw.train.Held() if drives.loop is None else sw.train.PositionLoop(*(float(gain * v) for v in drives.loop))
    return drive.train(
        load_torque=sw.Harmonics((sw.Harmonic(0.0, mean=-drives.torque),)), kinematic_error=drives.error,
        omega=drives.speeds[0], control=control,
    )  # fmt: skip


def test_of_a_linear_gear_the_peak_is_the_closed_form():
    # x'' + 2 zeta w0 (x' - e') + w0^2 (x - e) = 0: |x/e|^2 = (1 + q)/((1 - r^2)^2 + q), q = (2 zeta r)^2, at the speed
    # at which the torsion, |u/e|^2 = r^4/((1 - r^2)^2 + q), is largest
    drives = held(sw.Linear(GEAR.K1), speeds=(20.0, 600.0))
    found = largest(drives)
    r = np.linspace(0.9, 1.1, 200_001)
    q = (0.06 * r) ** 2
    below = (1.0 - r * r) ** 2 + q
    at = np.argmax(r**4 / below)
    assert found.oscillation == pytest.approx(1e-4 * np.sqrt((1.0 + q) / below)[at], rel=5e-4)
    assert found.amplitude == pytest.approx(1e-4 * np.sqrt(r**4 / below)[at], rel=5e-4)
    assert found.omega == pytest.approx(0.5 * r[at] * np.sqrt(GEAR.K1 / J_L), rel=5e-4)
    assert found.mass == pytest.approx(J_L)
    assert found.low == pytest.approx(found.oscillation)
    assert found.high == pytest.approx(found.oscillation)


def test_the_peak_lies_on_the_backbone_of_the_slow_flow():
    # its backbone is omega_0 + (K(a)/J - omega_0^2)/(2 omega_0); the exact linear part has the peak at sqrt(K(a)/J),
    # where damping alone holds the amplitude: B Omega a = J Omega^2 A
    drives = held(error=sw.KinematicError((sw.Line(2, 3e-5),)))
    found = largest(drives)
    for i in range(3):
        J, B, a = J_L[i], drives.B[i], found.amplitude[i]
        system = sw.Oscillator(J, B, GEAR.law, sw.Harmonic(0.0), found.omega[i], drives.error)
        flow = sw.slow_flow(system, sw.Resonance(2, 1))
        square = flow.omega_0**2 + 2.0 * flow.omega_0 * (float(flow.backbone(a)) - flow.omega_0)
        assert found.omega[i] == pytest.approx(0.5 * np.sqrt(square), rel=2e-3)
        assert a == pytest.approx(np.sqrt(square) * 3e-5 * J / B, rel=2e-3)


def test_a_stiff_loop_is_a_held_motor():
    drives = held(torque=60.0, error=CLASS)
    stiff = looped(drives, 1e5)
    assert largest(stiff).oscillation == pytest.approx(largest(drives).oscillation, rel=1e-3)
    s = np.array([[300.0j]])
    assert np.allclose(impedance(stiff, s), impedance(drives, s), rtol=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize("loop", [None, 190.0, 50.0])
@pytest.mark.parametrize("torque", [0.0, 90.0])
def test_harmonic_balance_of_the_whole_drive_lies_within_the_bounds(loop, torque):
    drives = held(error=CLASS, torque=torque)
    drives = drives if loop is None else looped(drives, loop)
    found = largest(drives)
    for i in range(3):
        exact = largest_crest(train(drives, i), drives.speeds, None, points=POINTS)
        more = 1.0 + certified_error(drives, found, i)
        assert found.low[i] / more <= exact.size <= found.high[i] * more


def test_a_line_of_twice_the_order_widens_the_bounds():
    # order 2 at twice the resonance of order 1 pumps it: one harmonic alone does not know that
    alone = held(error=sw.KinematicError((sw.Line(1, 3e-5),)), torque=60.0, speeds=(60.0, 100.0))._replace(
        J_l=np.full(3, 18.0)
    )
    both = alone._replace(error=sw.KinematicError((sw.Line(1, 3e-5), sw.Line(2, 1.2e-4))))
    spread = [np.max(found.high / found.oscillation) for found in map(largest, (alone, both))]
    assert spread[1] > 1.2 * spread[0]


@pytest.mark.slow
def test_the_response_of_a_project_has_the_same_oscillation(tmp_path):
    path = tmp_path / "drive.yaml"
    path.write_text(
        "gear: CSG-40-50\nmotor: {inertia: 6 kg*cm^2, mode: held}\nload: {inertia: 1.3 kg*m^2}\ndamping: {ratio: 3 %}\n"
        "speed: {from: 50 rad/s, to: 300 rad/s, shaft: motor}\n"
        "excitation: {accuracy: catalogue, load_torque: {mean: -60 N*m}}\n"
    )
    response = sw.read_project(path).response()
    drives = held(error=CLASS, torque=60.0)
    crest = largest_crest(train(drives, 1), drives.speeds, None, points=POINTS)
    assert crest.size == pytest.approx(np.max(response.oscillation), rel=1e-3)
