"""The steady curve of a drive train against linear algebra, and its operating point against statics."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import minimize_scalar

import strainwave as sw
from strainwave.drive.operating_point import operating_state
from strainwave.drive.train_curve import has_curve, largest_crest, torques_of_angle, train_curve
from strainwave.model.train.train_forms import AtLoad, own_state
from strainwave.numerics.curves.over_a_turn import traced_turn

K, B, K_C, B_C, J_1, J_2, A = 1e5, 15.0, 1.5e5, 5.0, 0.1, 1.2, 1e-4
DRIVE = sw.Drive(J_m=4.5e-4, J_l=J_2, N=50.0, B=B, law=sw.Linear(K))
HELD = sw.train.Held()
ERROR = sw.KinematicError((sw.Line(2, A),))


def train(control=HELD, law=None, mean=0.0, load_drag=None):
    made = DRIVE.train(control=control, kinematic_error=ERROR, omega=100.0)
    load = made.load._replace(excitation=sw.Harmonic(0.0, mean=mean), **({"drag": load_drag} if load_drag else {}))
    return made._replace(load=sw.train.Elastic(J_1, B_C, sw.Linear(K_C), load), **({"law": law} if law else {}))


def phasors(w):
    """Complex amplitudes of x across the gear and at the load, motor held, of a line of the error at w [rad/s]."""
    gear, coupling = K + 1j * w * B, K_C + 1j * w * B_C
    matrix = np.array([[gear + coupling - J_1 * w * w, -coupling], [-coupling, coupling - J_2 * w * w]])
    return np.linalg.solve(matrix, np.array([gear * A, 0.0]))


def at_the_load(omega):
    """Amplitudes of x across the gear and at the load behind the coupling: J q'' + B q' + K q = force."""
    return np.abs(phasors(2.0 * omega))


def test_the_curve_of_a_linear_train_is_that_of_linear_algebra_with_the_twist_of_the_coupling():
    found = train_curve(train(), (80.0, 140.0))
    curve = found.curve
    exact = np.array([at_the_load(w) for w in curve.omega])
    assert curve.peak == pytest.approx(exact[:, 1], rel=1e-6)
    assert found.gear_peak == pytest.approx(np.max(exact[:, 0]), rel=1e-4)
    assert np.max(exact[:, 1]) > 1.3 * found.gear_peak  # the coupling twists as well
    assert curve.stable.all()
    at = found.usage.at_peak
    twist = at_the_load(at)[1]  # the gear bears the inertias of both
    assert found.usage.peak_torque == pytest.approx(4.0 * at * at * (J_2 * twist + J_1 * at_the_load(at)[0]), rel=0.01)


def test_the_largest_oscillation_is_that_of_the_curve():
    speed, size = largest_crest(train(), (90.0, 130.0), 8)[:2]
    exact = minimize_scalar(
        lambda w: -at_the_load(w)[1], bounds=(100.0, 115.0), method="bounded", options={"xatol": 1e-9}
    )
    assert size == pytest.approx(-exact.fun, rel=1e-10)
    assert speed == pytest.approx(exact.x, rel=1e-5)


@pytest.mark.parametrize("law", [sw.Cubic(K, 1e5), sw.Parallel(sw.Linear(K), sw.BoucWen(2e4, 0.0, 2e-5))])
def test_a_crest_tells_the_oscillation_of_another_train_at_its_speed(law):
    loop, stiff = (sw.train.SpeedLoop(0.1 * x, 5.0 * x, 0.0) for x in (1.0, 1.7))
    crest = largest_crest(train(loop, law), (90.0, 130.0), 14, False)
    assert crest.size_of(train(loop, law)) == pytest.approx(crest.size, rel=1e-8)
    orbit = sw.find_orbit(AtLoad(train(stiff, law), 100.0)._replace(omega=crest.speed), harmonics=14)
    angles = np.linspace(0.0, 2.0 * np.pi, 20_001)
    c = orbit.coefficients[:, 0]
    x = sum(c[2 * k - 1] * np.cos(k * angles) + c[2 * k] * np.sin(k * angles) for k in range(1, len(c) // 2 + 1))
    assert crest.size_of(train(stiff, law)) == pytest.approx(np.max(np.abs(x)), rel=1e-6)
    assert abs(crest.size_of(train(stiff, law)) / crest.size - 1.0) > 0.01


def test_the_crests_of_the_error_and_of_its_oscillation_are_on_the_curve():
    twist = 30.0 / K + 30.0 / K_C
    curve = train_curve(train(mean=-30.0), (80.0, 140.0)).curve
    exact = minimize_scalar(
        lambda w: -at_the_load(w)[1], bounds=(100.0, 115.0), method="bounded", options={"xatol": 1e-9}
    )
    assert np.max(curve.oscillation) == pytest.approx(-exact.fun, rel=1e-10)
    assert np.max(curve.peak) == pytest.approx(twist - exact.fun, rel=1e-10)


def test_a_fast_line_of_the_error_is_not_sampled_too_coarsely():
    held = train()._replace(error=sw.KinematicError((sw.Line(62, A),)))
    found = train_curve(held, (2.6, 4.5))
    exact = np.array([at_the_load(31.0 * w) for w in found.omega])
    assert found.across == pytest.approx(exact[:, 0], rel=1e-8)
    w = 62.0 * found.omega
    across = [phasors(x)[0] for x in w]
    torque = np.abs([(K + 1j * x * B) * (q - A) for x, q in zip(w, across, strict=True)])
    assert found.torque == pytest.approx(torque, rel=1e-4)


def test_the_state_at_the_load_moves_as_that_of_the_train():
    whole, y = train(sw.train.SpeedLoop(0.5, 20.0)), np.array([1e-3, 0.2, 1e-3, 0.1, 4e-4, 0.05])
    system = AtLoad(whole, whole.omega)
    own, rates = own_state(system, tuple(y)), np.array(system.rhs(0.3, tuple(y)))
    inner = np.array(system.train.rhs(0.3, own))
    assert system.train.load_error(own) - y[2] / whole.N == pytest.approx(y[0])  # reference/N - theta of the load
    assert system.train.pointing_error(own) == pytest.approx(y[0])
    assert rates[0] == pytest.approx(y[1])
    assert rates[1] == pytest.approx(inner[1] + inner[5] - inner[3] / whole.N)
    assert rates[2:] == pytest.approx(inner[2:])


def test_gravity_is_left_out_of_the_steady_curve_and_that_is_told():
    heavy = train(load_drag=sw.train.AngleTorque(40.0))
    found = train_curve(heavy, (95.0, 120.0))
    assert found.without_angle
    assert found.curve.peak == pytest.approx([at_the_load(w)[1] for w in found.curve.omega], rel=1e-6)


def test_a_free_motor_with_a_coupling_has_the_curve_of_linear_algebra():
    # so small an error that its products with the alternating torque, N e' of the whole, do not show
    small, N, J_m = 1e-8, 50.0, 4.5e-4
    free = train(sw.train.Free(), mean=-30.0)._replace(error=sw.KinematicError((sw.Line(2, small),)))
    curve = train_curve(free, (80.0, 140.0)).curve
    gear, coupling = np.array([1.0 / N, -1.0, 0.0]), np.array([0.0, 1.0, -1.0])

    def at(omega):
        w = 2.0 * omega
        stiff = (K + 1j * w * B) * np.outer(gear, gear) + (K_C + 1j * w * B_C) * np.outer(coupling, coupling)
        force = (K + 1j * w * B) * small * gear + np.array([30.0 * 2j * small, 0.0, 0.0])  # e' times the mean torque
        angles = np.linalg.solve(stiff - w * w * np.diag([J_m, J_1, J_2]), force)
        return abs(angles[0] / N - angles[2])

    alternating = np.hypot(curve.coefficients[:, 3], curve.coefficients[:, 4])
    assert alternating == pytest.approx([at(w) for w in curve.omega], rel=1e-4)
    assert curve.coefficients[:, 0] == pytest.approx(30.0 / K + 30.0 / K_C, rel=1e-6)
    assert curve.stable.all()


def test_a_free_motor_alone_is_left_to_its_error_equation():
    rigid = train(sw.train.Free())
    assert not has_curve(rigid._replace(load=rigid.load.load))
    assert has_curve(rigid)


@pytest.mark.parametrize(
    "control", [sw.train.Held(), sw.train.Free(), sw.train.SpeedLoop(0.5, 20.0), sw.train.PositionLoop(30.0, 0.5)]
)
def test_the_operating_state_carries_load_and_friction(control):
    hardening = sw.Cubic(K, 6.9e4)
    loaded = train(control, law=hardening, mean=-100.0, load_drag=sw.laws.Viscous(3.0))
    state = operating_state(loaded, 150.0)
    torque = 100.0 + 3.0 * 150.0 / 50.0
    assert hardening.torque(state[0]) == pytest.approx(torque, rel=1e-9)
    assert state[loaded.twists()[0]] == pytest.approx(torque / K_C, rel=1e-9)
    if isinstance(control, sw.train.SpeedLoop | sw.train.PositionLoop):  # the loop's spring holds the motor against it
        stiff = control.K_i if isinstance(control, sw.train.SpeedLoop) else control.K_p
        assert state[2] == pytest.approx(-torque / 50.0 / stiff, rel=1e-6)


def test_modes_about_a_mean_torque_are_those_of_the_stiffness_there():
    hardening = sw.Cubic(K, 6.9e4)
    loaded = DRIVE.train(control=sw.train.Held(), load_torque=sw.Harmonic(0.0, mean=-178.0))._replace(law=hardening)
    state = operating_state(loaded, 150.0)
    poles = sw.bode(loaded, [10.0], source="load", at=state, speed=150.0).poles
    assert np.abs(poles) == pytest.approx(np.sqrt(hardening.stiffness(state[0]) / J_2), rel=1e-6)
    assert np.abs(sw.bode(loaded, [10.0], source="load").poles) == pytest.approx(np.sqrt(K / J_2), rel=1e-6)


def test_dry_friction_damps_no_mode_of_a_motor():
    dry = DRIVE.train(control=sw.train.SpeedLoop(0.5, 20.0), motor_drag=sw.laws.Coulomb(0.1))
    still, turning = (sw.bode(dry, [10.0], speed=speed).poles for speed in (0.0, 150.0))
    without = sw.bode(dry._replace(motor=dry.motor._replace(drag=sw.laws.Viscous(0.0))), [10.0]).poles
    assert np.sort_complex(turning) == pytest.approx(np.sort_complex(without), rel=1e-6)
    assert np.sort_complex(still) == pytest.approx(np.sort_complex(without), rel=1e-6)


def test_the_operating_state_lies_behind_a_gap_and_below_the_largest_torque():
    play = sw.Play(1e-4, sw.Cubic(K, 6.9e4))
    state = operating_state(train(law=play, mean=-50.0), 150.0)
    assert play.torque(state[0]) == pytest.approx(50.0, rel=1e-9)
    soft = sw.Cubic(K, -1e6)  # carries 2/3 K/sqrt(3e6) = 0.000385 K
    most = 2.0 / 3.0 * K / math.sqrt(3e6)
    state = operating_state(train(law=soft, mean=-0.999 * most), 150.0)
    assert soft.torque(state[0]) == pytest.approx(0.999 * most, rel=1e-9)
    assert soft.stiffness(state[0]) > 0.0
    with pytest.raises(sw.SolveError, match=r"was found at 150 rad/s: Cubic carries at most .* and the mean torque"):
        operating_state(train(law=soft, mean=-1.01 * most), 150.0)


def test_the_operating_state_of_a_law_with_memory_is_where_a_slow_load_brings_it():
    # n = 1, beta = gamma = 1/2: z = x_y (1 - exp(-x/x_y)) on the way from rest, never beyond x_y
    law = sw.Parallel(sw.Linear(K), sw.BoucWen(5e4, 0.0, 1e-4))
    state = operating_state(train(law=law, mean=-42.0), 150.0)
    z = 1e-4 * (1.0 - math.exp(-state[0] / 1e-4))
    assert state[2] == pytest.approx(z, rel=1e-6)
    assert K * state[0] + 5e4 * z == pytest.approx(42.0, rel=1e-9)


def kinked():
    """Train with an ideally held motor, a gear of three slopes and a rigid load."""
    law, J_l = sw.catalogue.gear("SHG-25-100").law, 0.6
    drive = sw.Drive(J_m=4e-4, J_l=J_l, N=100.0, B=0.06 * np.sqrt(J_l * law.K1), law=law)
    error = sw.KinematicError((sw.Line(2, np.radians(40.0 / 3600.0)),))
    return drive.train(control=HELD, kinematic_error=error, omega=100.0)


@pytest.mark.slow
def test_the_curve_of_a_law_with_corners_has_the_peak_and_the_folds_of_an_integration():
    # DOP853 at 1e-10 with the variational equations, by Newton's method for y(T) = y(0) and det(M - 1) = 0.
    curve = train_curve(kinked(), (130.0, 160.0)).curve
    assert np.max(curve.peak) == pytest.approx(np.radians(867.3998 / 3600.0), rel=1e-4)
    assert [fold.omega for fold in curve.folds] == pytest.approx([148.178377660, 142.312007789], rel=1e-6)


@pytest.mark.slow
def test_a_curve_cut_short_says_so():
    whole = kinked()
    problem, found, tail, _ = traced_turn(AtLoad(whole, whole.omega), (130.0, 160.0), 24, 2)
    assert tail.share > 1e-3
    assert tail.harmonics == 2
    status, message = tail.verdict(sw.Status.OK, "finished", "omega", 130.0)
    assert status is sw.Status.TRUNCATED
    assert "the harmonics left out hold about" in message
    assert problem.highest() == 2
    assert len(found.points)


@pytest.mark.slow
def test_the_curve_of_a_loop_with_hysteresis_takes_few_points_and_is_that_of_an_integration():
    law = sw.Parallel(sw.PiecewiseLinear(67e3, 110e3, 120e3, 29.0, 108.0), sw.BoucWen(134e3, 0.0, 3.636e-5))
    error = sw.KinematicError((sw.Line(2, 8.727e-5), sw.Line(4, 1.939e-5, 1.222)))
    loop = sw.train.Lagged(sw.train.SpeedLoop(0.0911, 4.417), 4e-4)
    drive = sw.Drive(J_m=4.2e-4, J_l=1.6, N=100.0, B=19.64, law=law)
    made = drive.train(control=loop, kinematic_error=error, load_torque=sw.Harmonic(0.0, mean=-30.0), omega=130.0)
    found = train_curve(made, (130.0, 150.0), 16)
    assert len(found.omega) < 60  # sampled at equal steps |v| and |z| cost thousands
    assert found.stable.all()

    def rates(t, y, omega):
        x, v, angle, speed, current, z = y
        turned = omega * t + angle
        u = x - 8.727e-5 * math.cos(2 * turned) - 1.939e-5 * math.cos(4 * turned + 1.222)
        slope = -2 * 8.727e-5 * math.sin(2 * turned) - 4 * 1.939e-5 * math.sin(4 * turned + 1.222)
        rate = v - slope * (omega + speed)
        size = abs(u)
        bent = 67e3 * min(size, 29 / 67e3) + 120e3 * max(0.0, size - 29 / 67e3 - 79 / 110e3)
        bent += 110e3 * min(max(0.0, size - 29 / 67e3), 79 / 110e3)
        torque = math.copysign(bent, u) + 134e3 * z + 19.64 * rate
        motor = (-current - (0.01 - slope) * torque) / 4.2e-4
        slip = abs(z / 3.636e-5) * (0.5 * abs(rate) * np.sign(z) + 0.5 * rate)
        loop = (4.417 * angle + 0.0911 * speed - current) / 4e-4
        return v, motor / 100 - (torque - 30) / 1.6, speed, motor, loop, rate - slip

    omega = 138.0
    turn, start = 2.0 * math.pi / omega, [-3e-4, 0, 0, 0, 0, 0]
    settled = solve_ivp(rates, (0.0, 80 * turn), start, "DOP853", args=(omega,), rtol=1e-8, atol=1e-12)
    times = 80 * turn + turn * np.arange(400) / 400
    last = solve_ivp(
        rates, (80 * turn, 81 * turn), settled.y[:, -1], "DOP853", times, args=(omega,), rtol=1e-9, atol=1e-13
    )
    pointing = last.y[0] - last.y[2] / 100
    here = np.interp(omega, found.omega, found.oscillation)
    assert here == pytest.approx(np.max(np.abs(pointing - pointing.mean())), rel=1e-3)


def test_the_torques_of_an_angle_are_those_between_any_places_of_a_turn():
    cogging = sw.train.AngleTorque(2.0, 360, 0.3)  # 720 places of a turn see two of its cycle
    assert torques_of_angle(cogging) == pytest.approx((-2.0, 2.0), rel=1e-12)
    both = sw.Parallel(sw.train.AngleTorque(3.0, 1), cogging)
    assert torques_of_angle(both) == pytest.approx((-5.0, 5.0), rel=1e-5)
    assert torques_of_angle(sw.Linear(0.0)) == (0.0, 0.0)


FALSE_CREST = """\
gear: {ratio: 50, law: {type: piecewise_linear, K1: 110500 N*m/rad, K2: 165750 N*m/rad, K3: 198900 N*m/rad,
  T1: 40.264 N*m, T2: 88.582 N*m}}
motor: {inertia: 6.5358 kg*cm^2, loop: {type: position_loop, K_p: 8.541359366769088 N*m/rad,
  K_d: 0.19519225051056338 N*m*s/rad, lag: 0.2 ms, filters: [{type: lowpass, frequency: 406.6 Hz},
  {type: notch, frequency: 59.6 Hz, width: 15.74 Hz, depth: 0.2}]}}
load: {inertia: 2.8267 kg*m^2}
damping: {B: 25.746 N*m*s/rad}
speed: {from: 59.3148 rad/s, to: 257.031 rad/s, shaft: motor}
excitation: {kinematic_error: [{order: 1, amplitude: 1.731 arcsec}, {order: 2, amplitude: 3.435 arcsec,
  phase: 40 deg}], load_torque: {mean: -56.15 N*m}}
"""


@pytest.mark.slow
def test_the_crest_of_a_coarse_curve_is_no_false_one_at_a_corner_of_the_law(tmp_path):
    """Fixed-step integration of the whole drive in C: 8.005 arcsec, largest of all speeds; between points 7.762."""
    (tmp_path / "drive.yaml").write_text(FALSE_CREST)
    project = sw.read_project(tmp_path / "drive.yaml")
    crest = largest_crest(project.train, project.speeds.limits, 15, False)
    arcsec = math.pi / 648_000.0
    assert crest.size / arcsec == pytest.approx(8.005, abs=5e-4)
    assert crest.size == pytest.approx(sw.drive_motion(project, crest.speed).oscillation, rel=1e-3)
