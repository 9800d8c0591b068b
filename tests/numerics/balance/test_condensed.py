"""Trains condensed onto what their laws see: against the error equation, equations by hand and the general form."""

from typing import NamedTuple

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from three_slopes import three_slopes

import strainwave as sw
from strainwave.compile.jit import run
from strainwave.compile.tree import leaf_of
from strainwave.model.train.filters import around
from strainwave.numerics.balance.choice import balance_of
from strainwave.numerics.balance.condensed.gear import sample_error
from strainwave.numerics.balance.condensed.problem import Condensed
from strainwave.numerics.balance.first_order import FirstOrder, first_order, linearised
from strainwave.numerics.balance.linear_part import STRENGTH
from strainwave.numerics.continuation.trace import solve, trace
from strainwave.numerics.stability.first_order import floquet_of

THREE = sw.PiecewiseLinear(5e4, 1e5, 1.5e5, 10.0, 40.0)
CUBIC = sw.Cubic(1e5, 1e5)
ERROR = sw.KinematicError((sw.Line(2, 1e-3, 0.4), sw.Line(4, 3e-4)))


def train(control, law=CUBIC, error=ERROR, coupling=None, mean=-20.0, lines=(3,)):
    torque = sw.Harmonics(tuple(sw.Harmonic(3.0, k, 0.2, mean / len(lines)) for k in lines))
    load = sw.train.Load(1.2, torque, sw.laws.Viscous(2.0))
    load = load if coupling is None else sw.train.Elastic(0.1, 5.0, coupling, load)
    return sw.DriveTrain(
        sw.train.Motor(4.5e-4, drag=sw.laws.Viscous(1e-4), control=control), 50.0, 15.0, law, load, 100.0, error
    )


CASCADE = sw.train.CascadeLoop(20.0, 0.3, 0.05)
LOOP = sw.train.PositionLoop(30.0, 0.5)
TRAINS = {
    "held": train(sw.train.Held(), THREE),
    "loop without error": train(LOOP, THREE, sw.NoError(), sw.Linear(1.5e5)),
    "speed loop": train(sw.train.SpeedLoop(0.5, 20.0, 1e-5), THREE, ERROR, sw.Linear(1.5e5)),
    "law of the coupling": train(LOOP, CUBIC, ERROR, THREE),
    "encoder of the load": train(around(CASCADE, encoder="load"), CUBIC, ERROR, sw.Linear(1.5e5)),
    "both encoders": train(around(CASCADE, 4e-4, T_p=0.2, encoder="both", mixing_frequency=50.0), THREE, ERROR, THREE),
}


def problem_of(system, harmonics, leaf=None):
    omega = leaf_of(system, "omega")
    return balance_of(system, omega if leaf is None else leaf, omega, harmonics)


@pytest.mark.parametrize("leaf", [None, STRENGTH], ids=["omega", "strength"])
@pytest.mark.parametrize("name", TRAINS)
def test_the_jacobian_is_the_derivative_of_the_residual(name, leaf):
    problem = problem_of(TRAINS[name], 12, leaf)
    assert isinstance(problem, Condensed)
    n, rng = problem.size(), np.random.default_rng(0)
    z = np.append(1e-3 * rng.normal(size=n) / (1 + np.arange(n) % 25), 105.0 if leaf is None else -0.3)
    _, matrix, slope = (part.copy() for part in linearised(problem, z))

    def difference(i, d):
        sides = []
        for sign in (1.0, -1.0):
            moved, r = z.copy(), np.empty(n)
            moved[i] += sign * d
            problem.residual(moved, r)
            sides.append(r)
        return (sides[0] - sides[1]) / (2.0 * d)

    found = np.array([difference(i, 1e-7) for i in range(n)]).T
    assert np.max(np.abs(found - matrix)) < 1e-7 * np.max(np.abs(matrix))
    np.testing.assert_allclose(difference(n, 1e-5 * abs(z[-1])), slope, rtol=1e-6, atol=1e-7 * np.max(np.abs(slope)))


@pytest.mark.parametrize(
    ("law", "mean"),
    [(THREE, 0.0), (THREE, -25.0), (sw.Cubic(1e5, 1e4), -25.0), (sw.Backlash(1e5, 2e-4), -25.0)],
    ids=str,
)
def test_a_held_motor_and_a_rigid_load_have_the_orbits_of_the_error_equation(law, mean):
    drive = sw.Drive(J_m=4.5e-4, J_l=1.2, N=50.0, B=15.0, law=law)
    torques = {"kinematic_error": ERROR, "load_torque": sw.Harmonic(2.0, 2, 0.7, mean=mean), "omega": 150.0}
    whole, equation = drive.train(control=sw.train.Held(), **torques), drive.error_equation(motor="held", **torques)
    for omega in (90.0, 135.0, 150.0):
        one, other = (sw.find_orbit(s._replace(omega=omega), harmonics=20) for s in (whole, equation))
        assert one.status.found
        size = np.max(np.abs(other.coefficients), axis=0)
        assert np.max(np.abs(one.coefficients[:, :2] - other.coefficients) / size) < 1e-9
        assert np.abs(one.multipliers) == pytest.approx(np.abs(other.multipliers), rel=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("mean", [0.0, -20.0])
def test_the_curves_of_both_have_the_same_folds_and_peak(mean):
    drive = sw.Drive(J_m=4e-4, J_l=0.6, N=100.0, B=0.03 * (0.6 * 5e4) ** 0.5, law=THREE._replace(T1=7.0, T2=25.0))
    error, torque = sw.KinematicError((sw.Line(2, 6e-5),)), sw.Harmonic(0.0, mean=mean)
    torques = {"kinematic_error": error, "load_torque": torque, "omega": 150.0}
    whole, equation = drive.train(control=sw.train.Held(), **torques), drive.error_equation(motor="held", **torques)
    one, other = (sw.frequency_response(s, (170.0, 250.0), harmonics=16) for s in (whole, equation))
    assert one.peak.max() == pytest.approx(other.peak.max(), rel=1e-9)
    folds, others = (np.sort([fold.omega for fold in curve.folds])[-2:] for curve in (one, other))
    assert folds == pytest.approx(others, rel=1e-9)  # those of the jump; others lie where the motion grazes a corner
    assert len(folds) == 2


@pytest.mark.slow
def test_machine_code_follows_the_same_curve_as_python(monkeypatch):
    problem = problem_of(TRAINS["law of the coupling"], 22)
    assert problem.size() > 130  # fewer would run as Python
    first = solve(problem, problem.linear_response(60.0))
    found = trace(problem, first, 1.0, 60.0, 140.0, 0.05)
    monkeypatch.setenv("STRAINWAVE_JIT", "0")
    other = trace(problem, first, 1.0, 60.0, 140.0, 0.05)
    assert len(found.points) == len(other.points)
    assert np.max(np.abs(found.points - other.points) / np.max(np.abs(other.points), axis=0)) < 1e-9


class ByHand(NamedTuple):
    """A random train and its equations in the angles of the shafts, as deviations from omega t and omega t/N."""

    train: sw.DriveTrain
    gains: tuple

    def rhs(self, t, y):
        train, (K_p, K_d, inertia), end = self.train, self.gains, self.train.load.end()
        theta, N = train.omega * t + y[0], train.N
        error = sum(a * np.cos(k * theta + p) for k, a, p in train.error.lines)
        slope = -sum(a * k * np.sin(k * theta + p) for k, a, p in train.error.lines)
        du = y[1] / N - y[3] - slope * (train.omega + y[1])
        torque = three_slopes(y[0] / N - y[2] - error, train.law) + train.B * du
        drag = train.motor.drag.B * (train.omega + y[1])
        fast = (-K_p * y[0] - K_d * y[1] - drag - (1.0 / N - slope) * torque) / inertia
        line = end.excitation
        outer = line.mean + line.amplitude * np.cos(2.0 * train.omega * t + line.phase)
        outer -= end.drag.B * (train.omega / N + y[-1])
        if len(y) == 4:
            return [y[1], fast, y[3], (torque + outer) / end.J]
        law, twist = train.load.law, y[2] - y[4]
        passed = law.K * twist if isinstance(law, sw.Linear) else three_slopes(twist, law)
        passed += train.load.B * (y[3] - y[5])
        return [y[1], fast, y[3], (torque - passed) / train.load.J, y[5], (passed + outer) / end.J]

    def angles(self, y):
        """State by hand from the train's."""
        own = [y[2], y[3], y[2] / self.train.N - y[0], y[3] / self.train.N - y[1]]
        return np.array(own + ([own[2] - y[4], own[3] - y[5]] if len(y) == 6 else []))


def random_train(seed, coupling):
    rng = np.random.default_rng(seed)
    N, J_l, K1 = float(rng.choice([50, 80, 100, 120])), rng.uniform(0.3, 2.0), rng.uniform(3e4, 1.2e5)
    law = sw.PiecewiseLinear(K1, 1.6 * K1, 2.5 * K1, rng.uniform(5, 12), rng.uniform(15, 25))
    J_m, bandwidth = rng.uniform(0.5, 3.0) * J_l / N**2, 2.0 * np.pi * rng.uniform(5.0, 200.0)
    B = 2.0 * rng.uniform(0.02, 0.06) * (J_l * K1) ** 0.5
    gains = J_m * bandwidth**2, 2.0 * rng.uniform(0.4, 1.0) * J_m * bandwidth
    speed = rng.integers(0, 2) == 1
    control = sw.train.SpeedLoop(gains[1], gains[0], 0.1 * J_m) if speed else sw.train.PositionLoop(*gains)
    lines = sw.Line(2, rng.uniform(1.5, 3.0) * 1e-4, rng.uniform(0.0, 6.0)), sw.Line(4, rng.uniform(0.0, 5e-5))
    torque = sw.Harmonic(rng.uniform(0.0, 10.0), 2, 0.7, rng.uniform(-20.0, 20.0))
    load = sw.train.Load(J_l, torque, sw.laws.Viscous(rng.uniform(0.0, 3.0)))
    if coupling:
        K = rng.uniform(0.8, 3.0) * K1
        laws = {"linear": sw.Linear(K), "three slopes": sw.PiecewiseLinear(K, 1.5 * K, 2.5 * K, 8.0, 20.0)}
        load = sw.train.Elastic(rng.uniform(0.05, 0.3) * J_l, 0.3 * B, laws[coupling], load)
    omega = 0.5 * (1.5 * K1 / J_l) ** 0.5 * rng.uniform(0.8, 1.1)
    motor = sw.train.Motor(J_m, drag=sw.laws.Viscous(rng.uniform(0.0, 1e-4)), control=control)
    whole = sw.DriveTrain(motor, N, B, law, load, omega, sw.KinematicError(lines))
    return ByHand(whole, (*gains, 1.1 * J_m if speed else J_m))


@pytest.mark.parametrize("coupling", ["", "linear", "three slopes"])
@pytest.mark.parametrize("seed", [2, 3])
def test_random_trains_move_as_their_equations_by_hand(seed, coupling):
    model = random_train(seed, coupling)
    orbit = sw.find_orbit(model.train, harmonics=511)
    assert orbit.status is sw.Status.OK
    phase = np.linspace(0.0, 2.0 * np.pi, 65)
    states, turn = orbit.state(phase), 2.0 * np.pi / model.train.omega
    run = solve_ivp(
        model.rhs, (0.0, turn), model.angles(states[:, 0]), method="DOP853", rtol=1e-12, atol=1e-15,
        t_eval=np.linspace(0.0, turn, len(phase)), max_step=turn / 200.0,
    )  # fmt: skip
    x = run.y[0] / model.train.N - run.y[2]
    assert np.max(np.abs(x - states[0])) < 1e-6 * np.max(np.abs(x))
    assert np.max(np.abs(model.train.torsion(phase, tuple(states)))) > max(model.train.breakpoints())


@pytest.mark.parametrize("control", [LOOP, sw.train.SpeedLoop(0.5, 20.0)], ids=str)
def test_a_smooth_train_moves_as_the_integration_to_rounding(control):
    whole = train(control, CUBIC, ERROR, sw.Cubic(1.5e5, 1e5), lines=(1, 3))
    orbit = sw.find_orbit(whole)
    assert orbit.tail < 1e-10
    start = orbit.state(0.0)
    run = sw.simulate(whole, start, np.array([0.0, 2.0 * np.pi / whole.omega]), method=sw.Dopri5(1e-12, 1e-18))
    assert np.max(np.abs(run.y[:, -1] - start) / np.max(np.abs(orbit.coefficients), axis=0)) < 1e-8


class Lagged(NamedTuple):
    """A position loop whose torque z lags behind its command: rate z' = (command - z) rate."""

    K_p: float
    K_d: float
    rate: float
    states = 1

    def torque(self, x, v, z):
        return z[0] + 0.0 * x

    def z_rate(self, x, v, z):
        return (self.rate * (self.K_p * x + self.K_d * v - z[0]),)


class Saturated(NamedTuple):
    """A position loop with a largest torque."""

    K_p: float
    K_d: float
    most: float

    def torque(self, x, v):
        command = self.K_p * x + self.K_d * v
        return 0.5 * (abs(command + self.most) - abs(command - self.most))


def test_a_control_with_states_of_its_own_is_condensed_with_the_rest():
    whole = train(Lagged(30.0, 0.5, 3e3))
    problem = problem_of(whole, 15)
    assert isinstance(problem, Condensed)
    assert problem.size() == 62  # the torsion and the motor's deviation; the control's state is condensed
    orbit = sw.find_orbit(whole)
    start = orbit.state(0.0)
    run = sw.simulate(whole, start, np.array([0.0, 2.0 * np.pi / whole.omega]), method=sw.Dopri5(1e-12, 1e-18))
    assert np.max(np.abs(run.y[:, -1] - start) / np.max(np.abs(orbit.coefficients), axis=0)) < 1e-8


@pytest.mark.parametrize(
    "general",
    [
        train(Saturated(30.0, 0.5, 1.0)),
        train(LOOP, sw.Parallel(CUBIC, sw.BoucWen(1e4, 0.0, 1e-4))),
        train(LOOP, coupling=sw.Parallel(CUBIC, sw.BoucWen(1e4, 0.0, 1e-4))),
        train(LOOP)._replace(motor=sw.train.Motor(4.5e-4, drag=sw.laws.Coulomb(0.1), control=LOOP)),
        train(LOOP)._replace(load=sw.train.Load(1.2, drag=sw.train.AngleTorque(3.0))),
        train(sw.train.Free()),  # nothing says how much torque keeps its speed
    ],
    ids=["control", "law", "coupling", "friction", "gravity", "free"],
)
def test_what_is_not_linear_around_its_laws_is_left_to_the_general_form(general):
    assert isinstance(problem_of(general, 7), FirstOrder)


def test_another_parameter_than_the_frequency_is_left_to_the_general_form():
    whole = train(LOOP)
    assert isinstance(balance_of(whole, leaf_of(whole, "law.alpha"), leaf_of(whole, "omega"), 7), FirstOrder)


def test_what_drives_three_times_a_turn_has_every_third_harmonic_and_the_multipliers_of_the_whole_turn():
    whole = train(LOOP, error=sw.KinematicError((sw.Line(3, 1e-3),)), coupling=sw.Linear(1.5e5))
    leaf = leaf_of(whole, "omega")
    part, full = (balance_of(whole, leaf, leaf, 21, folded=folded) for folded in (True, False))
    assert (part.size(), full.size()) == (30, 86)
    orbit = sw.find_orbit(whole, harmonics=21)
    points = [problem.point(orbit.coefficients, whole.omega)[None] for problem in (part, full)]
    for problem, point in zip((part, full), points, strict=True):
        assert np.max(np.abs(linearised(problem, point[0])[0])) < 1e-6
    general = first_order(whole, leaf, leaf, 21)
    found = [floquet_of(p, z)[0] for p, z in zip((part, full), points, strict=True)]
    found.append(floquet_of(general, general.point(orbit.coefficients, whole.omega)[None])[0])
    for values in found[1:]:
        assert np.abs(values) == pytest.approx(np.abs(found[0]), rel=1e-5, abs=1e-9)


def test_a_guess_that_does_not_repeat_within_the_turn_is_not_folded():
    whole = train(LOOP, error=sw.KinematicError((sw.Line(2, 1e-4),)), lines=(2,))
    orbit = sw.find_orbit(whole, guess=np.full((15, 4), 1e-6), harmonics=7)
    other = sw.find_orbit(whole, harmonics=7)
    assert orbit.amplitude(2) == pytest.approx(other.amplitude(2), rel=1e-4)
    assert orbit.amplitude(1) < 1e-9 * orbit.amplitude(2)


@pytest.mark.parametrize("order", [3, 64, 128])
def test_a_motor_that_nothing_holds_is_in_balance_under_a_line_of_any_order_without_mean(order):
    free = train(sw.train.Free(), error=sw.NoError(), mean=0.0, lines=(order,))
    smooth = free._replace(
        motor=free.motor._replace(drag=sw.laws.Viscous(0.0)), load=free.load._replace(drag=sw.laws.Viscous(0.0))
    )
    assert smooth.linear_part() is not None
    pulled = smooth.load._replace(excitation=sw.Harmonic(3.0, order, mean=0.1))
    assert smooth._replace(load=pulled).linear_part() is None


@pytest.mark.parametrize("orders", [(2.0,), (2.0, 4.0, 6.0, 7.5, 9.5), (1.0, 3.0, 4.0), (4.0, 2.0)])
def test_an_error_is_sampled_in_machine_code_as_in_numpy(orders):
    rng = np.random.default_rng(len(orders))
    lines = np.array([(0.0, 0.3, 0.0), *((order, *rng.normal(size=2)) for order in orders)])
    angles, deviations = 2.0 * np.pi * np.arange(40) / 40, 1e-2 * rng.normal(size=40)
    as_python, compiled = np.empty((2, 3, 40))
    sample_error(lines, 0.7, angles, deviations, *as_python)
    run(sample_error, lines, 0.7, angles, deviations, *compiled)
    np.testing.assert_allclose(compiled, as_python, atol=1e-12)
