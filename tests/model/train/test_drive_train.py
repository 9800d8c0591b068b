"""The drive train: Lagrange's equations, its power balance, its reductions, and what it refuses."""

import numpy as np
import pytest
import sympy as sp
from canonical import BALANCED, PLAIN_TRAIN, REFERENCES, TRAINS
from scipy.integrate import solve_ivp

import strainwave as sw
from strainwave.base.quantities import checked
from strainwave.compile.address import kind_of

ERROR = sw.KinematicError((sw.Line(2, 1.1e-4, 0.3), sw.Line(4, 2e-5)))
HARD = sw.Cubic(7160.0, 1e4)
DRIVE = sw.Drive(sw.HDC_40_050.J_m, sw.HDC_40_050.J_l, sw.HDC_40_050.N, 5.0, HARD)
TIGHT = sw.Dopri5(rtol=1e-12, atol=1e-16)


def some_state(train, seed=3):
    return tuple(np.random.default_rng(seed).uniform(-0.05, 0.05, len(train.state_names())).tolist())


def accelerations(train, phase, y):
    """(theta_m'', theta_l'') of a train without coupling, x'' = theta_m''/N - theta_l''."""
    rates = train.rhs(phase, y)
    return rates[3], rates[3] / train.N - rates[1]


@pytest.mark.slow
def test_train_is_what_lagrange_gives_with_kinematic_error():
    derived = sw.theory.derive()
    s = derived.symbols
    a, phase = sp.symbols("a phi", real=True)
    error, law = sw.KinematicError((sw.Line(2, a, phase),)), sw.Cubic(s.K, s.alpha)
    motor = sw.train.Motor(s.J_m, sw.Harmonic(0, 1, 0, s.T_m))
    train = sw.DriveTrain(
        motor, s.N, s.B, law, sw.train.Load(s.J_l, sw.Harmonic(0, 1, 0, s.T_l)), 1, error, sw.train.AtRest()
    )
    y = (s.theta_m / s.N - s.theta_l, s.theta_m_rate / s.N - s.theta_l_rate, s.theta_m, s.theta_m_rate)
    by_model = accelerations(train, sp.Symbol("t"), y)
    for equation, name, found in zip(
        (derived.motor_equation, derived.load_equation), ("theta_m", "theta_l"), by_model, strict=True
    ):
        exact = sp.solve(equation, getattr(s, name + "_acceleration"))[0].doit()
        exact = exact.subs(sp.diff(s.e(s.theta_m), s.theta_m), error.slope(s.theta_m))
        exact = exact.replace(s.f, lambda u: law.torque(u) / s.K).subs(s.e(s.theta_m), error.value(s.theta_m))
        assert sp.simplify(sp.nsimplify(exact - found)) == 0
        # the comparison sees an error: without its torque it fails
        torque = {s.T_m: 0} if name == "theta_m" else {s.T_l: 0}
        assert sp.expand(sp.nsimplify(exact.subs(torque) - found)) != 0


@pytest.mark.slow
def test_lines_of_two_turns_and_gravity_run_as_their_own_equations():
    N, J_m, J_l, K, B, omega = 51.0, 2e-4, 1.3, 2e4, 2.0, 90.0
    error = sw.KinematicError((sw.Line(2, 1e-4), sw.Line(2 - 2 / N, 8e-5, 0.3)))
    load = sw.train.Load(J_l, drag=sw.train.AngleTorque(30.0, 1, 0.2))
    motor = sw.train.Motor(J_m, control=sw.train.PositionLoop(40.0, 0.3))
    train = sw.DriveTrain(motor, N, B, sw.Cubic(K, 5e3), load, omega, error)
    orders, sizes, phases = np.array([2.0, 2.0 - 2.0 / N]), np.array([1e-4, 8e-5]), np.array([0.0, 0.3])

    def rates(t, y):
        x, v, d, w = y
        angle = orders * (omega * t + d) + phases
        u, slope = x - sizes @ np.cos(angle), -(sizes * orders) @ np.sin(angle)
        torque = K * (u + 5e3 * u**3) + B * (v - slope * (omega + w))
        fast = (-(1.0 / N - slope) * torque - 40.0 * d - 0.3 * w) / J_m
        slow = (torque - 30.0 * np.sin((omega * t + d) / N - x + 0.2)) / J_l
        return [v, fast / N - slow, w, fast]

    t = np.linspace(0.0, 2.0 * np.pi * N / omega, 300)
    run = sw.simulate(train, (0.0,) * 4, t, method=TIGHT)
    own = solve_ivp(rates, t[[0, -1]], (0.0,) * 4, "DOP853", t_eval=t, rtol=1e-12, atol=1e-16)
    size = np.max(np.abs(own.y), axis=1, keepdims=True)
    np.testing.assert_allclose(run.y / size, own.y / size, rtol=0, atol=1e-9)


def test_free_error_equation_is_the_train_without_kinematic_error_symbolically():
    J_m, J_l, N, B, K, alpha, w, c, d = sp.symbols("J_m J_l N B K alpha omega c d", positive=True)
    x, v, theta, rate, phase = sp.symbols("x v theta r phi", real=True)
    drive = sw.Drive(J_m, J_l, N, B, sw.Cubic(K, alpha))
    torques = {"motor_torque": sw.Harmonic(c, 1), "load_torque": sw.Harmonic(d, 2)}
    whole = drive.train(omega=w, **torques).rhs(phase, (x, v, theta, rate))
    reduced = drive.error_equation(omega=w, **torques).rhs(phase, (x, v))
    assert sp.simplify(sp.nsimplify(whole[1] - reduced[1])) == 0


def test_held_error_equation_is_the_held_train_symbolically():
    J_m, J_l, N, B, K, alpha, w, a, d = sp.symbols("J_m J_l N B K alpha omega a d", positive=True)
    x, v, phase = sp.symbols("x v phi", real=True)
    drive, error = sw.Drive(J_m, J_l, N, B, sw.Cubic(K, alpha)), sw.KinematicError((sw.Line(2, a),))
    load = sw.Harmonic(d, 1)
    whole = drive.train(omega=w, load_torque=load, kinematic_error=error, control=sw.train.Held()).rhs(phase, (x, v))
    reduced = drive.error_equation(omega=w, load_torque=load, kinematic_error=error, motor="held").rhs(phase, (x, v))
    assert sp.simplify(sp.nsimplify(whole[1] - reduced[1])) == 0


@pytest.mark.parametrize("name", BALANCED)
def test_energy_changes_by_what_is_put_in_less_what_is_lost(name):
    train = TRAINS[name]
    h = 1e-5
    for seed in range(5):
        y = some_state(train, seed)
        rates = train.rhs(0.4, y)

        def energy(t, y=y, rates=rates):
            moved = tuple(a + b * t for a, b in zip(y, rates, strict=True))
            return train.energy(0.4 + train.omega * t, moved)

        powers = train.losses(0.4, y)
        change = (8 * (energy(h) - energy(-h)) - (energy(2 * h) - energy(-2 * h))) / (12 * h)
        assert change == pytest.approx(sum(powers[:3]) - sum(powers[3:]), rel=1e-8, abs=1e-9)
        assert len(powers) == len(train.power_names())


@pytest.mark.parametrize("reference", REFERENCES.values(), ids=REFERENCES.keys())
def test_reference_motion_has_its_own_derivatives(reference):
    phase, h = np.array([-3.0, -1.3, 0.2, 1.7, 4.0]), 1e-3  # away from the corners

    def derivative(of):  # five points: exact for cubics
        return (8.0 * (of(phase + h) - of(phase - h)) - (of(phase + 2 * h) - of(phase - 2 * h))) / (12.0 * h)

    np.testing.assert_allclose(derivative(reference.value), reference.slope(phase), atol=1e-11)
    np.testing.assert_allclose(derivative(reference.slope), reference.curvature(phase), atol=1e-11)


def test_speed_profile_goes_through_its_points():
    profile = sw.train.SpeedProfile((0.0, 2.0, 3.0, 4.0), (0.0, 100.0, 100.0, 0.0))
    np.testing.assert_allclose(profile.slope(np.array([-1.0, 0.0, 1.0, 2.5, 3.5, 9.0])), [0, 0, 50, 100, 50, 0])
    # areas of the trapezium: 100 to t = 2, 100 to t = 3, 50 to t = 4
    np.testing.assert_allclose(profile.value(np.array([0.0, 2.0, 3.0, 4.0, 9.0])), [0, 100, 200, 250, 250])
    torque = sw.train.TorqueProfile((0.0, 1.0), (0.0, -5.0))
    np.testing.assert_allclose(torque.torque(np.array([-1.0, 0.5, 2.0])), [0.0, -2.5, -5.0])


def test_gravity_is_a_spring_of_the_loads_own_angle():
    # m g r = 3 N m on a horizontal axis: small swings of two inertias, the load hanging down
    J_m, J_l, N, K = 1e-4, 0.05, 10.0, 800.0
    load = sw.train.Load(J_l, drag=sw.train.AngleTorque(3.0))
    pendulum = sw.DriveTrain(sw.train.Motor(J_m), N, 0.0, sw.Linear(K), load, reference=sw.train.AtRest())
    stiffness = np.array([[K / N**2, -K / N], [-K / N, K + 3.0]])
    squares = np.linalg.eigvals(np.diag([1 / J_m, 1 / J_l]) @ stiffness)
    poles = sw.bode(pendulum, 1.0).poles
    np.testing.assert_allclose(np.sort(poles.imag)[2:], np.sort(np.sqrt(squares)), rtol=1e-9)
    # upside down it falls
    inverted = pendulum._replace(load=sw.train.Load(J_l, drag=sw.train.AngleTorque(3.0, phase=np.pi)))
    assert np.max(sw.bode(inverted, 1.0).poles.real) > 1.0


def test_two_couplings_in_series_are_the_chain_of_a_textbook():
    chain = sw.DriveTrain(
        sw.train.Motor(2.0),
        1.0,
        0.0,
        sw.Linear(3.0),
        sw.train.Elastic(0.7, 0.1, sw.Linear(5.0), sw.train.Elastic(0.4, 0.2, sw.Linear(2.0), sw.train.Load(1.1))),
        reference=sw.train.AtRest(),
    )
    assert chain.state_names()[4:] == ("coupling 1", "coupling 1'", "coupling 2", "coupling 2'")
    q, dq = np.array([0.1, -0.2, 0.3, 0.05]), np.array([0.4, 0.1, -0.3, 0.2])
    stiff, damped, inertia = np.array([3.0, 5.0, 2.0]), np.array([0.0, 0.1, 0.2]), np.array([2.0, 0.7, 0.4, 1.1])
    passed = stiff * -np.diff(q) + damped * -np.diff(dq)
    acceleration = (np.append(0.0, passed) - np.append(passed, 0.0)) / inertia
    y = (q[0] - q[1], dq[0] - dq[1], q[0], dq[0], q[1] - q[2], dq[1] - dq[2], q[2] - q[3], dq[2] - dq[3])
    expected = -np.diff(acceleration)
    rates = chain.rhs(0.0, y)
    np.testing.assert_allclose([rates[1], rates[5], rates[7]], expected, rtol=1e-13)
    assert rates[3] == pytest.approx(acceleration[0], rel=1e-13)
    assert chain.load_speed(0.0, y) == pytest.approx(dq[3])
    assert chain.load_error(y) == pytest.approx(q[0] - q[3])


def test_integration_agrees_with_scipy_in_absolute_angles():
    train = DRIVE.train(
        motor_torque=sw.Harmonic(1.0, mean=0.1), load_torque=sw.Harmonic(2.0, order=2), kinematic_error=ERROR,
        omega=150.0, motor_drag=sw.laws.Viscous(2e-4), load_drag=sw.laws.Viscous(0.3), reference=sw.train.AtRest(),
    )  # fmt: skip

    def textbook(t, y):
        theta_m, theta_l, speed_m, speed_l = y
        u = theta_m / 50 - theta_l - ERROR.value(theta_m)
        du = speed_m / 50 - speed_l - ERROR.slope(theta_m) * speed_m
        torque = HARD.torque(u) + 5.0 * du
        motor = 0.1 + np.cos(150 * t) - 2e-4 * speed_m - (1 / 50 - ERROR.slope(theta_m)) * torque
        return [speed_m, speed_l, motor / DRIVE.J_m, (2 * np.cos(300 * t) - 0.3 * speed_l + torque) / DRIVE.J_l]

    start = ERROR.value(0.0)
    run = sw.simulate(train, (start, 0.0, 0.0, 0.0), 0.05, method=TIGHT)
    other = solve_ivp(textbook, (0, 0.05), [0.0, -start, 0.0, 0.0], "DOP853", rtol=1e-12, atol=1e-14).y[:, -1]
    x, v, theta_m, speed_m = run.y[:, -1]
    found = [theta_m, theta_m / 50 - x, speed_m, speed_m / 50 - v]
    np.testing.assert_allclose(found, other, rtol=1e-9, atol=1e-12)


# T_m = 1 N m cos(omega t), no kinematic error, damping across the gear alone: Taylor integration of the four states
# and harmonic balance of the reduced equation agree to 1e-8 on amplitude(1) and amplitude(3) of x.
FORCED = {
    200.0: (3.43352996e-4, 6.834634e-8),
    380.0: (9.55480228e-4, 2.8065585e-7),
    420.0: (7.40370108e-4, 1.0446450e-7),
}


@pytest.mark.parametrize(("omega", "printed"), FORCED.items())
def test_error_equation_and_train_in_relative_coordinates_give_the_reference_amplitudes(omega, printed):
    torque = sw.Harmonic(1.0)
    reduced = sw.find_orbit(DRIVE.error_equation(motor_torque=torque, omega=omega))
    whole = sw.find_orbit(sw.train.SteadyTrain(DRIVE.train(motor_torque=torque), omega, by_angle=0, bandwidth=1e-10))
    for orbit, accuracy in ((reduced, 1e-12), (whole, 1e-9)):
        # half of the last digit printed
        assert orbit.amplitude(1) == pytest.approx(printed[0], abs=0.5e-12)
        assert orbit.amplitude(3) == pytest.approx(printed[1], abs=0.5e-13)
        assert orbit.amplitude(1) == pytest.approx(reduced.amplitude(1), rel=accuracy)
        assert orbit.amplitude(3) == pytest.approx(reduced.amplitude(3), rel=10 * accuracy)


@pytest.mark.slow
@pytest.mark.parametrize(("omega", "printed"), FORCED.items())
def test_settled_motion_of_the_four_states_has_the_reference_amplitudes(omega, printed):
    train = DRIVE.train(motor_torque=sw.Harmonic(1.0), omega=omega)
    period = 2 * np.pi / omega
    settled = period * np.ceil(0.5 / period)  # exp(-mu t/2) < 1e-11 with mu = B/J = 103.8 1/s
    samples = np.append(0.0, settled + period * np.arange(32) / 32)
    x = sw.simulate(train, (0.0,) * 4, samples, method=TIGHT).y[0, 1:]
    amplitudes = 2 * abs(np.fft.rfft(x)) / 32
    assert amplitudes[1] == pytest.approx(printed[0], abs=0.5e-12)
    assert amplitudes[3] == pytest.approx(printed[1], abs=0.5e-13)


@pytest.mark.slow
def test_stiff_speed_loop_approaches_the_held_motor():
    given = {"kinematic_error": sw.KinematicError((sw.Line(2, 1.1e-4),)), "omega": 190.0}
    held = sw.find_orbit(DRIVE.error_equation(motor="held", **given)).peak
    gaps = []
    for stiff in (0.5, 2.0, 8.0):
        loop = sw.train.SpeedLoop(K_p=stiff, K_i=10.0 * stiff)
        gaps.append(abs(sw.find_orbit(DRIVE.train(control=loop, **given), harmonics=6).peak / held - 1.0))
    assert gaps[0] > 3 * gaps[1] > 9 * gaps[2]  # in proportion to 1/K_p
    assert gaps[2] < 0.01


def test_position_loop_keeps_the_motor_on_its_profile():
    profile = sw.train.SpeedProfile((0.0, 0.05, 0.15), (0.0, 50.0, 50.0))
    train = DRIVE.train(control=sw.train.PositionLoop(K_p=50.0, K_d=0.5), reference=profile)
    run = sw.simulate(train, (0.0,) * 4, 0.15)
    assert run.y[3, -1] == pytest.approx(0.0, abs=1e-3 * 50.0)
    assert train.motor_speed(0.15, tuple(run.y[:, -1])) == pytest.approx(50.0, rel=1e-3)


def test_derivative_gain_of_the_speed_loop_acts_as_inertia():
    plain = PLAIN_TRAIN._replace(motor=sw.train.Motor(0.2, sw.Harmonic(0.3), control=sw.train.SpeedLoop(0.1, 0.0, 0.3)))
    heavy = PLAIN_TRAIN._replace(motor=sw.train.Motor(0.5, sw.Harmonic(0.3), control=sw.train.SpeedLoop(0.1)))
    assert plain.rhs(0.4, some_state(plain)) == pytest.approx(heavy.rhs(0.4, some_state(heavy)), rel=1e-13)


@pytest.mark.slow
def test_free_train_at_constant_mean_speed_is_the_simulated_motion():
    # its mean torque p, given to the motor, keeps the mean speed: after many periods the state is still on the orbit
    omega = 180.0
    orbit = sw.find_orbit(sw.train.SteadyTrain(DRIVE.train(kinematic_error=ERROR), omega, bandwidth=1e-6))
    x, v, w, p = orbit.state(0.0)
    torque = sw.Harmonic(0.0, mean=float(p))
    train = DRIVE.train(kinematic_error=ERROR, motor_torque=torque, reference=sw.train.AtRest())
    period = 2 * np.pi / omega
    run = sw.simulate(train, (x, v, 0.0, omega + w), np.array([0.0, 1.0, 20.0]) * period, method=TIGHT)
    np.testing.assert_allclose(run.y[0, 1:], x, rtol=1e-5)
    assert run.y[2, -1] == pytest.approx(20 * 2 * np.pi, rel=1e-9)  # the mean speed is omega
    assert p > 0.0  # it pays for the damping


@pytest.mark.parametrize(
    ("train", "sentence"),
    [
        (PLAIN_TRAIN._replace(N=0.0), "DriveTrain.N is 0; a ratio must be positive"),
        (PLAIN_TRAIN._replace(motor=sw.train.Motor(-1.0)), r"Motor.J is -1 kg\*m\*\*2; an inertia must be positive"),
        (PLAIN_TRAIN._replace(load=sw.train.Load(0.0)), r"Load.J is 0 kg\*m\*\*2; an inertia must be positive"),
        (
            PLAIN_TRAIN._replace(motor=sw.train.Motor(1.0, control=sw.train.PositionLoop(-5.0, 0.1))),
            "PositionLoop.K_p is -5; with a negative gain the loop pushes the motor away",
        ),
        (
            PLAIN_TRAIN._replace(motor=sw.train.Motor(1.0, control=sw.train.SpeedLoop(1.0, K_d=-0.1))),
            "SpeedLoop.K_d is -0.1; with a negative gain",
        ),
        (
            PLAIN_TRAIN._replace(reference=sw.train.SpeedProfile((0.0, 0.0), (1.0, 2.0))),
            "SpeedProfile.times are 0, 0 s; they must increase",
        ),
        (
            PLAIN_TRAIN._replace(reference=sw.train.SpeedProfile((0.0, 1.0), (1.0, 2.0, 3.0))),
            "SpeedProfile has 2 times and 3 values; it needs from 2 to 16 of both, equally many",
        ),
        (
            sw.train.SteadyTrain(PLAIN_TRAIN._replace(motor=sw.train.Motor(1.0, control=sw.train.Held())), 1.0),
            "SteadyTrain takes a free motor, not Held()",
        ),
        (
            sw.train.SteadyTrain(PLAIN_TRAIN._replace(error=ERROR), 1.0, by_angle=0),
            "a kinematic error follows the motor's angle; take by_angle=1",
        ),
        (
            sw.train.SteadyTrain(PLAIN_TRAIN._replace(reference=sw.train.AtRest()), 1.0),
            "SteadyTrain needs the reference Steady",
        ),
        (sw.train.SteadyTrain(PLAIN_TRAIN, -1.0), "SteadyTrain has omega -1 rad/s"),
        (sw.train.SteadyTrain(PLAIN_TRAIN, 1.0, by_angle=2), "by_angle is 2; it must be 1"),
    ],
)
def test_bad_numbers_are_refused_in_one_sentence(train, sentence):
    with pytest.raises(ValueError, match=sentence):
        checked(train)


@pytest.mark.slow
@pytest.mark.parametrize(("omega", "stays"), [(200.0, True), (240.0, False)])
def test_behind_the_resonance_a_constant_torque_does_not_keep_the_speed(omega, stays):
    # Sommerfeld effect: the mean torque p(omega) that keeps the speed falls there, and the mean speed grows away at the
    # rate -p'(omega)/(J_m + J_l/N^2). The resonance of order 2 is at omega_0/2 = 212 rad/s.
    law = sw.Cubic(1.089e5, 6.85e4)
    drive = sw.Drive(4.5e-4, 1.3, 50.0, 2 * 0.03 * (1.3 * law.K) ** 0.5, law)
    train = drive.train(kinematic_error=sw.KinematicError((sw.Line(2, 1.115e-4),)))
    before, here, after = (
        sw.find_orbit(sw.train.SteadyTrain(train, omega + d, bandwidth=1e-8), harmonics=10) for d in (-0.5, 0.0, 0.5)
    )
    growth = np.log(abs(here.multipliers)) * omega / (2 * np.pi)
    slope = after.coefficients[0, 3] - before.coefficients[0, 3]
    predicted = -slope / (drive.J_m + drive.J_l / drive.N**2)
    found = growth[0] if not stays else growth[1]  # the other one, nearly 0, is that of p itself
    assert found == pytest.approx(predicted, rel=5e-3)
    assert (found < 0.0) == stays


@pytest.mark.slow
def test_curve_of_the_whole_train_has_the_folds_of_the_error_equation_nearby():
    law = sw.Cubic(1.089e5, 6.85e4)
    drive = sw.Drive(4.5e-4, 1.3, 50.0, 15.4, law)  # 3 % damping with the motor free
    error = sw.KinematicError((sw.Line(2, 1.115e-4),))
    systems = (
        sw.train.SteadyTrain(drive.train(kinematic_error=error), 200.0),
        drive.error_equation(kinematic_error=error),
    )
    whole, reduced = (sw.frequency_response(s, (150.0, 260.0), harmonics=10, points=40) for s in systems)
    assert whole.status is sw.Status.OK
    assert len(whole.folds) == len(reduced.folds) == 2
    for exact, near in zip(whole.folds, reduced.folds, strict=True):
        assert near.omega == pytest.approx(exact.omega, rel=2e-3)
        assert near.omega != pytest.approx(exact.omega, rel=1e-5)


def test_motor_starts_from_rest_under_a_torque_profile():
    # rigid-body motion: (J_m + J_l/N^2) omega' = T - b omega, from rest to T/b with the time constant J/b
    b, inertia = 5e-3, DRIVE.J_m + DRIVE.J_l / DRIVE.N**2
    train = DRIVE.train(
        motor_torque=sw.train.TorqueProfile((0.0, 1e-4), (0.0, 1.0)),
        motor_drag=sw.laws.Viscous(b),
        reference=sw.train.AtRest(),
    )
    run = sw.simulate(train, (0.0,) * 4, 0.3, method=sw.Dopri5(rtol=1e-7))
    expected = 1.0 / b * (1.0 - np.exp(-(0.3 - 0.5e-4) * b / inertia))
    assert run.y[3, -1] == pytest.approx(expected, rel=2e-3)


def test_a_drive_is_of_one_kind_with_and_without_a_mean_torque():
    """Each kind compiles anew: under every torque of a load the train is of the classes of the train without one."""
    drive = sw.Drive(1e-3, 1.0, 50.0, 5.0, sw.Linear(1e4))
    loaded = drive.train(load_torque=sw.Harmonics((sw.Harmonic(0.0, mean=3.0),)))
    assert loaded.load.excitation == sw.Harmonic(0.0, mean=3.0)
    assert kind_of(loaded) == kind_of(drive.train())
    two = sw.Harmonics((sw.Harmonic(1.0, 2), sw.Harmonic(0.5, 4)))
    assert drive.train(motor_torque=two).motor.excitation == two
