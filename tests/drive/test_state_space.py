"""State space and margins of the motor's loop, against transfer functions written by hand, SciPy, and closed forms."""

import numpy as np
import pytest
from canonical import PLAIN_TRAIN
from scipy import signal

import strainwave as sw

DRIVE = sw.Drive(J_m=5.26e-4, J_l=0.05, N=50.0, B=0.5, law=sw.Cubic(7160.0, 1e4))
J_M, J_L, N, K, B = 5.26e-4, 0.05, 50.0, 7160.0, 0.5
OMEGA = np.geomspace(1.0, 3e3, 60)
# torque on the motor to its angle: two inertias, by hand
TOP = np.array([J_L, B, K])
BOTTOM = np.array([J_M * J_L, (J_M + J_L / N**2) * B, (J_M + J_L / N**2) * K, 0.0, 0.0])


def loop_polynomials(gains):
    """Numerator and denominator of the open loop with K_d s^2 + K_p s + K_i from angle to torque."""
    return np.polymul(gains, TOP), BOTTOM


def by_polynomials(top, bottom):
    """Frequencies where |L| = 1, and where L is real and negative with 1/|L|, as roots of polynomials in omega."""

    def parts(p):
        powers = np.arange(len(p))[::-1]
        return np.real(p * 1j**powers), np.imag(p * 1j**powers)

    (a, b), (c, d) = parts(top), parts(bottom)
    square = np.polysub(np.polyadd(np.polymul(a, a), np.polymul(b, b)), np.polyadd(np.polymul(c, c), np.polymul(d, d)))
    imaginary = np.polysub(np.polymul(b, c), np.polymul(a, d))
    real = np.polyadd(np.polymul(a, c), np.polymul(b, d))

    def positive(p):
        roots = np.roots(np.trim_zeros(p, "f"))
        return np.sort(roots[(abs(roots.imag) < 1e-7 * abs(roots)) & (roots.real > 1e-3)].real)

    crossings = np.array([w for w in positive(imaginary) if np.polyval(real, w) < 0.0])
    sizes = [abs(np.polyval(bottom, 1j * w) / np.polyval(top, 1j * w)) for w in crossings]
    return positive(square), crossings, np.array(sizes)


def test_matrices_are_those_of_two_inertias_by_hand():
    found = sw.state_space(DRIVE.train())
    assert found.states == ("x", "x'", "motor deviation", "motor deviation'")
    assert found.inputs == ("motor torque", "load torque")
    m = 1.0 / (N * J_M)
    expected = [
        [0, 1, 0, 0],
        [-K * (m / N + 1 / J_L), -B * (m / N + 1 / J_L), 0, 0],
        [0, 0, 0, 1],
        [-K * m, -B * m, 0, 0],
    ]
    np.testing.assert_allclose(found.A, expected, rtol=1e-8, atol=1e-6)
    np.testing.assert_allclose(found.B, [[0, 0], [m, -1 / J_L], [0, 0], [1 / J_M, 0]], rtol=1e-12)
    outputs = dict(zip(found.outputs, found.C, strict=True))
    np.testing.assert_allclose(outputs["load speed"], [0, -1, 0, 1 / N], rtol=1e-15)
    np.testing.assert_allclose(outputs["gear torque"], [K, B, 0, 0], rtol=1e-7)
    np.testing.assert_array_equal(outputs["error"], [1, 0, 0, 0])
    assert not np.any(found.D)


@pytest.mark.parametrize("gains", [(0.0, 0.0, 0.0), (1e-4, 0.3, 2.0), (0.0, 0.5, 50.0)])
def test_response_is_that_of_scipy_for_the_transfer_functions_and_that_of_bode(gains):
    train = DRIVE.train(control=sw.train.SpeedLoop(gains[1], gains[2], gains[0]) if any(gains) else sw.train.Free())
    found = sw.state_space(train)
    bottom = np.polyadd(BOTTOM, np.polymul(gains, TOP))
    for output, top in (("motor speed", [*TOP, 0.0]), ("load speed", [B / N, K / N, 0.0])):
        _, y = signal.freqresp(signal.TransferFunction(top, bottom), OMEGA)
        np.testing.assert_allclose(found.response(OMEGA)[found.outputs.index(output), 0], y, rtol=1e-6)
    for i, name in enumerate(found.inputs):
        plot = sw.bode(train, OMEGA, source=name.split()[0])
        np.testing.assert_array_equal(found.response(OMEGA)[:2, i], [plot.motor, plot.load])
    np.testing.assert_array_equal(found.poles, plot.poles)


def test_couplings_friction_and_gravity_are_in_the_matrices():
    load = sw.train.Elastic(0.02, 0.3, sw.Linear(3e4), sw.train.Load(0.03, drag=sw.train.AngleTorque(4.0)))
    train = sw.DriveTrain(
        sw.train.Motor(J_M, drag=sw.laws.Viscous(2e-3), control=sw.train.Held()), N, B, sw.Linear(K), load
    )
    found = sw.state_space(train)
    assert (found.inputs, found.states) == (("load torque",), ("x", "x'", "coupling 1", "coupling 1'"))
    # error of the load x + twist, with both inertias behind a held motor: M q'' + D q' + S q = torque on the last
    stiffness = np.array([[K + 3e4, -3e4], [-3e4, 3e4 + 4.0]])
    damping = np.array([[B + 0.3, -0.3], [-0.3, 0.3]])
    for i, w in enumerate(OMEGA):
        angle = np.linalg.solve(-w * w * np.diag([0.02, 0.03]) + 1j * w * damping + stiffness, [0.0, 1.0])[1]
        assert found.response(OMEGA)[found.outputs.index("error"), 0, i] == pytest.approx(-angle, rel=1e-7)
        assert found.response(OMEGA)[1, 0, i] == pytest.approx(1j * w * angle, rel=1e-7)
    assert found.units(found.states) == ("rad", "rad/s", "rad", "rad/s")


def test_an_operating_point_changes_the_stiffness():
    loaded = DRIVE.train(control=sw.train.PositionLoop(50.0, 0.5), load_torque=sw.Harmonic(0.0, mean=-40.0))
    state = sw.study.operating_state(loaded, 100.0)
    found = sw.state_space(loaded, at=state, speed=100.0)
    np.testing.assert_allclose(found.C[4, 0], DRIVE.law.stiffness(state[0]), rtol=1e-7)
    assert found.C[4, 0] > 1.2 * K


@pytest.mark.parametrize("gains", [(0.0, 0.5, 50.0), (0.0, 0.02, 0.3), (0.0, 3.0, 900.0)])
def test_margins_of_a_pd_loop_are_the_roots_of_its_polynomials(gains):
    found = sw.margins(DRIVE.train(control=sw.train.PositionLoop(gains[2], gains[1])))
    crossings, real, factors = by_polynomials(*loop_polynomials(gains))
    np.testing.assert_allclose(found.gain_crossings, crossings, rtol=1e-7)
    np.testing.assert_allclose(found.phase_crossings, real, rtol=1e-6)
    np.testing.assert_allclose(found.gain_margins, factors, rtol=1e-6)
    top, bottom = loop_polynomials(gains)
    _, values = signal.freqresp(signal.TransferFunction(top, bottom), crossings)
    np.testing.assert_allclose(found.phase_margins, np.angle(-values), rtol=1e-6)
    assert found.stable


def test_margins_of_a_speed_loop_with_inertia_are_the_roots_of_its_polynomials():
    found = sw.margins(DRIVE.train(control=sw.train.SpeedLoop(0.3, 20.0, 2e-4)))
    crossings, _, _ = by_polynomials(*loop_polynomials((2e-4, 0.3, 20.0)))
    np.testing.assert_allclose(found.gain_crossings, crossings, rtol=1e-7)


def test_a_rigid_drive_with_a_pd_loop_has_the_margins_of_the_textbook():
    rigid = DRIVE._replace(law=sw.Linear(1e9), B=1e5)
    K_p, K_d = 50.0, 0.5
    found = sw.margins(rigid.train(control=sw.train.PositionLoop(K_p, K_d)))
    # L = (K_d s + K_p)/(J s^2): (J w^2)^2 = (K_d w)^2 + K_p^2, and the phase margin is atan(K_d w/K_p)
    J = J_M + J_L / N**2
    w = np.sqrt((K_d**2 + np.sqrt(K_d**4 + 4.0 * J**2 * K_p**2)) / (2.0 * J**2))
    # the gear gives way by (w/w_0)^2 = 1e-5 with w_0^2 = K/J_l (and the load has 4 % of the inertia)
    assert found.gain_crossings == pytest.approx([w], rel=1e-5)
    assert found.phase_margin == pytest.approx(np.arctan(K_d * w / K_p), rel=1e-4)
    assert found.delay_margin == pytest.approx(np.arctan(K_d * w / K_p) / w, rel=1e-4)


class Lagged(sw.train.PositionLoop):
    """The same loop with a lag of second order: two states of its own."""

    states = 2
    lag = 5e-4

    def torque(self, x, v, z):
        return z[0]

    def z_rate(self, x, v, z):
        return (z[1] - z[0]) / self.lag, (self.K_p * x + self.K_d * v - z[1]) / self.lag


def test_at_the_gain_margin_a_pole_is_on_the_imaginary_axis():
    train = DRIVE.train(control=Lagged(50.0, 0.5))
    found = sw.margins(train)
    assert found.stable
    assert 1.0 < found.gain_margin < np.inf
    for factor, frequency in zip(found.gain_margins, found.phase_crossings, strict=True):
        control = Lagged(50.0 * factor, 0.5 * factor)
        poles = sw.state_space(train._replace(motor=train.motor._replace(control=control))).poles
        assert np.min(abs(poles - 1j * frequency)) < 1e-5 * frequency
    beyond = Lagged(*(1.05 * found.gain_margin * gain for gain in (50.0, 0.5)))
    assert not sw.margins(train._replace(motor=train.motor._replace(control=beyond))).stable


def test_the_delay_margin_brings_the_loop_to_minus_one():
    gains = (0.0, 0.5, 50.0)
    found = sw.margins(DRIVE.train(control=sw.train.PositionLoop(50.0, 0.5)))
    top, bottom = loop_polynomials(gains)
    s = 1j * found.gain_crossings
    delayed = np.polyval(top, s) / np.polyval(bottom, s) * np.exp(-s * found.delay_margin)
    assert np.min(abs(1.0 + delayed)) < 1e-6
    for shorter in np.linspace(0.0, 0.99, 12) * found.delay_margin:
        w = np.geomspace(1.0, 1e5, 20_001) * 1j
        turns = np.unwrap(np.angle(1.0 + np.polyval(top, w) / np.polyval(bottom, w) * np.exp(-w * shorter)))
        first = np.unwrap(np.angle(1.0 + np.polyval(top, w) / np.polyval(bottom, w)))
        assert abs(turns[-1] - first[-1]) < 1.0  # Nyquist: as many turns around -1 as without delay


def test_margins_agree_with_python_control():
    control = pytest.importorskip("control")
    top, bottom = loop_polynomials((0.0, 0.5, 50.0))
    gain, phase, _, _, crossing, _ = control.stability_margins(control.tf(top, bottom))
    found = sw.margins(DRIVE.train(control=sw.train.PositionLoop(50.0, 0.5)))
    assert found.gain_margin == pytest.approx(gain, rel=1e-5)
    assert np.rad2deg(found.phase_margin) == pytest.approx(phase, rel=1e-5)
    assert crossing > 0.0


@pytest.mark.parametrize("control", [sw.train.Free(), sw.train.Held()], ids=["free", "held"])
def test_a_motor_without_a_loop_has_no_margins(control):
    with pytest.raises(ValueError, match="has no loop; give it a SpeedLoop or a PositionLoop"):
        sw.margins(DRIVE.train(control=control))


def test_bad_input_and_prints():
    with pytest.raises(ValueError, match=r"at is .*; it must be 4 finite numbers"):
        sw.state_space(PLAIN_TRAIN, at=(0.0, 0.0))
    found = sw.state_space(DRIVE.train(control=sw.train.PositionLoop(50.0, 0.5)))
    text = str(found)
    assert "states: x [rad], x' [rad/s], motor deviation [rad], motor deviation' [rad/s]" in text
    assert "inputs: motor torque [N*m], load torque [N*m]" in text
    data = found.to_xarray()
    assert data["A"].sel(state="x", rate="x''").item() == found.A[1, 0]
    assert "closed loop stable" in str(sw.margins(DRIVE.train(control=sw.train.PositionLoop(50.0, 0.5))))


SAMPLED = sw.controllers.Sampling(5e-4, 5e-4)


@pytest.mark.parametrize("sampling", [None, SAMPLED])
def test_a_speed_loop_without_an_integral_is_stable_though_its_angle_stays_where_it_is(sampling):
    """J_m v' = -K_p v decays and the angle is in no torque; sampled every T, K_p above 2 J_m/T is too much."""
    train = DRIVE.train(control=sw.train.SpeedLoop(0.3))
    assert sw.margins(train, sampling=sampling).stable
    poles = sw.state_space(train).poles
    assert np.sum(np.abs(poles) < 1e-9 * np.max(np.abs(poles))) == 1
    assert np.all(np.sort(poles.real)[:-1] < 0.0)
    assert not sw.margins(DRIVE.train(control=sw.train.SpeedLoop(300.0)), sampling=SAMPLED).stable
