"""Numbers of a system from signals: against records that SciPy made from equations written by hand."""

import math
from typing import Any, NamedTuple

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

import strainwave as sw
from strainwave.study.identification.experiment import Record, experiment
from strainwave.study.identification.input_signals import Signal, pieces
from strainwave.study.identification.lane_march import lanes_of
from strainwave.study.identification.window_fit import LeastSquares, Window

RATE = 200.0
J, B, K, ALPHA, D = 2.0e-4, 4.0e-3, 1.0, 0.6, 3e-5  # a resonance at 11.3 Hz, damping .14
GUESS = sw.Oscillator(
    1.5e-4, 8e-3, sw.Parallel(sw.Cubic(0.8, 0.0), sw.laws.QuadraticDamping(0.0)), sw.Harmonic(0.0), 1.0
)
FREE = ("J", "B", "law.first.K", "law.first.alpha")


def band_limited(samples, seed, rms=0.8, highest=30.0, fine=32):
    """A periodic signal without content above `highest` Hz: its samples, and a function of time."""
    rng = np.random.default_rng(seed)
    k = np.arange(samples * fine // 2 + 1)
    spectrum = np.where((k > 0) & (k * RATE / samples <= highest), np.exp(2j * np.pi * rng.random(len(k))), 0.0)
    u = np.fft.irfft(spectrum)
    u *= rms / np.sqrt(np.mean(u * u))
    t = np.arange(len(u) + 1) / (fine * RATE)
    return u[::fine], CubicSpline(t, np.append(u, u[0]), bc_type="periodic")


def record(samples, seed, *, offset=0.0, delay=0.0, d=D, start=(0.3, 0.0)):
    """Input and clean output of J x'' + B x' + D |x'| x' + K (x + alpha x^3) = u(t - delay) + offset."""
    u, force = band_limited(samples, seed)
    t = np.arange(samples) / RATE

    def rhs(s, y):
        drive = force(s - delay) + offset
        return y[1], (drive - B * y[1] - d * abs(y[1]) * y[1] - K * (y[0] + ALPHA * y[0] ** 3)) / J

    x = solve_ivp(rhs, (0.0, t[-1]), start, "DOP853", t, rtol=1e-10, atol=1e-12, max_step=1.0 / RATE).y[0]
    return {"time": t, "input": u, "output": x}


@pytest.fixture(scope="module")
def clean():
    return record(1500, 1)


@pytest.mark.slow
def test_the_numbers_of_a_clean_record_are_found_from_a_rough_guess(clean):
    found = sw.identify(GUESS, clean, (*FREE, "law.second.D"))
    assert found.converged
    assert not found.notes
    truth = (J, B, K, ALPHA, D)
    # what is left is the input between samples (its ends) and the steps of the integration, 1e-4 of the motion
    assert found.values == pytest.approx(truth, rel=5e-3)
    assert found.rms[0] < 3e-4 * found.size[0]
    assert found.value("law.first.K") == found.system.law.first.K
    assert found.system.excitation == GUESS.excitation


@pytest.mark.slow
def test_offsets_and_a_delay_are_found():
    log = record(1500, 2, offset=0.07, delay=0.0021, d=0.0)
    log["output"] = log["output"] + 0.013
    guess = GUESS._replace(law=sw.Cubic(0.9, 0.3))
    free = ("J", "B", "law.K", "law.alpha", "excitation.offset", "excitation.delay", "x.offset")
    found = sw.identify(guess, log, free)
    assert found.value("excitation.delay") == pytest.approx(0.0021, abs=2e-5)
    assert found.value("x.offset") == pytest.approx(0.013, abs=4e-4)
    assert found.value("excitation.offset") == pytest.approx(0.07, abs=4e-4)


@pytest.mark.slow
def test_a_late_measurement_is_told_from_its_own_delay():
    log = record(1500, 3, d=0.0)
    x = CubicSpline(log["time"], log["output"])
    log["output"] = x(log["time"] - 0.004)  # measured(t) = x(t - delay), which starts before the record
    log["output"][:1] = np.nan
    guess = GUESS._replace(law=sw.Cubic(0.9, 0.3))
    found = sw.identify(guess, {n: v[5:] for n, v in log.items()}, ("J", "B", "law.K", "law.alpha", "x.delay"))
    assert found.value("x.delay") == pytest.approx(0.004, abs=4e-5)


@pytest.mark.slow
def test_a_free_run_over_another_record_is_that_of_another_integrator(clean):
    found = sw.identify(GUESS, clean, (*FREE, "law.second.D"))
    other = record(900, 7)
    computed = found.simulate(other, {"output": other["output"][:50]})["output"]
    size = np.std(other["output"])
    assert np.sqrt(np.mean((computed - other["output"])[50:] ** 2)) < 2e-3 * size
    again = found.simulate({"input": other["input"]}, (0.3, 0.0))["output"]
    assert np.sqrt(np.mean((again - other["output"]) ** 2)) < 2e-3 * size


@pytest.mark.slow
def test_derivatives_are_those_of_the_variational_equations(clean):
    """d x(t)/d K and d x(t)/d x(0) by DOP853 of the equations and their derivatives, over a window of 60 samples."""
    system = sw.Oscillator(J, B, sw.Cubic(K, ALPHA), sw.Harmonic(0.0), 1.0)
    of = experiment(system, {"excitation": "input"}, {"x": "output"}, ("law.K", "B"), "linear")
    u = clean["input"][:60]
    one = Record(u[None], clean["output"][None, :60], 1.0 / RATE)
    problem = LeastSquares(of, [Window(one, 0, 60)], np.ones(1), 16)
    start = np.array([0.1, 2.0])
    point = problem.point_at(of.first(), [start])
    t = np.arange(60) / RATE

    def rhs(s, y):
        x, v, xk, vk, xb, vb, x0, v0 = y
        k = K * (1.0 + 3.0 * ALPHA * x * x)
        return (
            v, (np.interp(s, t, u) - B * v - K * (x + ALPHA * x**3)) / J,
            vk, (-B * vk - k * xk - (x + ALPHA * x**3)) / J,
            vb, (-B * vb - k * xb - v) / J,
            v0, (-B * v0 - k * x0) / J,
        )  # fmt: skip

    y0 = [*start, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0]
    y = solve_ivp(rhs, (0.0, t[-1]), y0, "DOP853", t, rtol=1e-11, atol=1e-13, max_step=1.0 / RATE).y
    for got, want in (
        (point.by_value[0][:, 0], y[2]),
        (point.by_value[0][:, 1], y[4]),
        (point.by_start[0][:, 0], y[6]),
    ):
        assert got == pytest.approx(want, abs=2e-5 * np.max(np.abs(want)))


@pytest.mark.slow
def test_what_follows_from_the_numbers_has_an_interval(clean):
    """omega_0 = sqrt(K/J): its relative variance is (v_K + v_J)/4 less half of their covariance, relative ones."""
    log = clean | {"output": clean["output"] + 0.01 * np.random.default_rng(5).standard_normal(len(clean["time"]))}
    found = sw.identify(GUESS._replace(law=sw.Cubic(0.9, 0.3)), log, ("J", "B", "law.K", "law.alpha"))
    low, high = found.interval_of(lambda system: math.sqrt(system.law.K / system.J))
    jacobian = np.array([-0.5 / found.value("J"), 0.0, 0.5 / found.value("law.K"), 0.0])
    relative = math.sqrt(jacobian @ found.covariance @ jacobian)
    middle = math.sqrt(found.value("law.K") / found.value("J"))
    assert 0.5 * (low + high) == pytest.approx(middle, rel=1e-12)
    assert 0.5 * (high - low) == pytest.approx(1.96 * relative * middle, rel=0.02)


class Late(NamedTuple):
    """Not of the package: T = K x with an internal state that follows x by a first-order lag."""

    K: float
    c: float
    tau: float

    def states(self) -> int:
        return 1

    def torque(self, x: Any, v: Any, z: Any) -> Any:
        return self.K * x + self.c * (x - z[0])

    def z_rate(self, x: Any, v: Any, z: Any) -> Any:
        return ((x - z[0]) / self.tau,)

    def stiffness(self, x: Any) -> Any:
        return self.K + self.c + 0.0 * x


@pytest.mark.slow
def test_a_law_of_the_users_own_with_a_hidden_state():
    u, force = band_limited(1500, 5)
    t = np.arange(1500) / RATE

    def rhs(s, y):
        return y[1], (force(s) - B * y[1] - 0.7 * y[0] - 0.3 * (y[0] - y[2])) / J, (y[0] - y[2]) / 0.05

    x = solve_ivp(rhs, (0.0, t[-1]), (0.1, 0.0, 0.0), "DOP853", t, rtol=1e-10, atol=1e-12, max_step=1.0 / RATE).y[0]
    guess = sw.Oscillator(1.7e-4, 6e-3, Late(0.9, 0.1, 0.03), sw.Harmonic(0.0), 1.0)
    found = sw.identify(guess, {"time": t, "input": u, "output": x}, ("J", "B", "law.K", "law.c", "law.tau"))
    assert found.values == pytest.approx((J, B, 0.7, 0.3, 0.05), rel=0.02)


@pytest.mark.slow
def test_a_gear_between_a_measured_motor_and_a_measured_load():
    """Held motor: its measured angle is the reference; the load's inertia is known, the gear is what is sought."""
    drive = sw.Drive(1e-4, 0.5, 50.0, 6.0, sw.Cubic(8e3, 2e4))
    rate, n = 500.0, 2000
    t = np.arange(n) / rate
    speed, up = 20.0, 30.0
    angle = speed * t + 0.5 * up * t * t
    lines = sw.KinematicError((sw.Line(2, 1.2e-4, 0.5),))

    def rhs(s, y):
        theta, rate_of = speed * s + 0.5 * up * s * s, speed + up * s
        e, slope = 1.2e-4 * math.cos(2 * theta + 0.5), -2.4e-4 * math.sin(2 * theta + 0.5)
        u, du = y[0] - e, y[1] - slope * rate_of
        torque = 8e3 * (u + 2e4 * u**3) + 6.0 * du
        return y[1], up / 50.0 - torque / 0.5

    x = solve_ivp(rhs, (0.0, t[-1]), (0.0, 0.0), "DOP853", t, rtol=1e-10, atol=1e-14, max_step=1.0 / rate).y[0]
    guess = drive._replace(law=sw.Cubic(6e3, 0.0), B=10.0).train(
        control=sw.train.Held(), kinematic_error=sw.KinematicError((sw.Line(2, 1e-4, 0.3),)), omega=1.0
    )
    free = ("law.K", "law.alpha", "B", "error.lines.0.amplitude", "error.lines.0.phase")
    log = {"time": t, "motor_angle": angle, "x": x}
    found = sw.identify(guess, log, free, inputs={"reference": "motor_angle"}, outputs={"x": "x"})
    assert found.value("law.K") == pytest.approx(8e3, rel=2e-3)
    assert found.value("B") == pytest.approx(6.0, rel=2e-2)
    assert found.value("error.lines.0.amplitude") == pytest.approx(lines.lines[0].amplitude, rel=5e-3)
    assert found.value("error.lines.0.phase") == pytest.approx(0.5, abs=1e-2)


def test_band_limited_pieces_follow_a_sum_of_cosines():
    rng = np.random.default_rng(3)
    f, phase = rng.uniform(0.0, 0.38, 30), rng.uniform(0.0, 6.0, 30)

    def signal(s):
        return np.sum(np.cos(2.0 * np.pi * f[:, None] * np.ravel(s) + phase[:, None]), axis=0).reshape(np.shape(s))

    for delay in (0.0, 0.3, -1.7, 5.25):
        found = pieces(signal(np.arange(600.0)) + 0.7 * np.arange(600.0), 4, "band-limited", delay)
        s = np.linspace(0.0, 1.0, 5)
        times = np.arange(len(found))[:, None] / 4.0 + s / 4.0 - delay
        got = np.polynomial.polynomial.polyval(s, found.T)
        inner = slice(400, -400)
        assert got[inner] == pytest.approx((signal(times) + 0.7 * times)[inner], abs=2e-4)


def test_held_and_linear_pieces_are_what_they_say():
    u = np.array([1.0, 3.0, 2.0])
    assert pieces(u, 2, "held")[:, 0] == pytest.approx([1.0, 1.0, 3.0, 3.0])
    assert pieces(u, 2, "linear")[:, :2] == pytest.approx(np.array([[1.0, 1.0], [2.0, 1.0], [3.0, -0.5], [2.5, -0.5]]))


def test_a_signal_has_the_derivatives_of_its_value():
    signal = Signal(2.0, 0.1, 0.0, 0.5, 20.0, 0.3, 1.0, 0.5, -0.3, 0.2, 0.1, -0.05)
    angle, h = 0.62, 1e-4
    by_difference = (signal.value(angle + h) - signal.value(angle - h)) / (2.0 * h)
    assert signal.slope(angle) == pytest.approx(by_difference, rel=1e-6)
    bend = (signal.slope(angle + h) - signal.slope(angle - h)) / (2.0 * h)
    assert signal.curvature(angle) == pytest.approx(bend, rel=1e-6)
    late = signal._replace(delay=1e-6)
    assert late.value(angle) - signal.value(angle) == pytest.approx(-1e-6 * by_difference * 2.0, rel=1e-4)


def test_lanes_run_as_one_by_one():
    system = GUESS._replace(excitation=Signal(1.0, 0.2, 0.0, 1.0, 4.0 * RATE))
    others = [
        system,
        system._replace(B=1e-2),
        system._replace(law=sw.Parallel(sw.Cubic(1.1, 0.2), sw.laws.QuadraticDamping(1e-5))),
    ]
    p = pieces(np.sin(np.arange(20.0)), 4, "band-limited")[None]
    starts = np.array([[0.1, 0.2, 0.3], [1.0, 0.0, -1.0]])
    together = lanes_of(others).run(starts, p, np.array([0, 1]), 20, 4, 1.0 / RATE)
    for i, one in enumerate(others):
        alone = lanes_of([one]).run(starts[:, i : i + 1], p, np.array([0, 1]), 20, 4, 1.0 / RATE)
        assert together[:, :, i] == pytest.approx(alone[:, :, 0], rel=1e-12)


@pytest.mark.slow
def test_only_the_ratios_are_told_where_the_force_has_no_scale(clean):
    with pytest.raises(ValueError, match="common factor"):
        sw.identify(GUESS._replace(law=sw.Cubic(0.8, 0.1)), clean, ("J", "B", "law.K", "law.alpha", "excitation.gain"))


@pytest.mark.slow
def test_a_missing_term_is_flagged_and_laws_are_told_apart_by_what_they_predict():
    log = record(3000, 11, d=4e-4)
    rng = np.random.default_rng(0)
    log["output"] = log["output"] + 1e-3 * rng.standard_normal(len(log["output"]))
    cubic = GUESS._replace(law=sw.Cubic(0.8, 0.1))
    found = sw.identify(cubic, log, ("J", "B", "law.K", "law.alpha"))
    assert "|v| v" in found.discrepancy.flagged
    table = sw.fit.compare_laws(
        {
            "cubic": (cubic, ("J", "B", "law.K", "law.alpha")),
            "two dampings": (
                cubic._replace(law=sw.laws.Parallel(cubic.law, sw.laws.Viscous(1e-4))),
                ("B", "law.second.B"),
            ),
            "churning": (GUESS, (*FREE, "law.second.D")),
        },
        log,
    )
    assert table.names == ("churning", "cubic")
    assert "do not separate B and law.second.B" in table.left_out["two dampings"]
    assert "two dampings was omitted: the data do not separate" in str(table)
    with pytest.raises(ValueError, match=r"^worse: 'law\.X' is no number"):
        sw.fit.compare_laws({"worse": (cubic, ("law.X",))}, log)
    assert table.best.value("law.second.D") == pytest.approx(4e-4, rel=0.05)
    assert table.best.discrepancy.flagged == ()


BAD = [
    ({"free": ()}, "free is"),
    ({"free": ("law.X",)}, "law.X"),
    ({"free": ("J", "J")}, "twice"),
    ({"free": ("excitation.c0",)}, "is no number that can be free"),
    ({"free": ("omega",)}, "omega is free"),
    ({"inputs": {"excitation.mean": "input"}}, "name the torque"),
    ({"inputs": {"force": "input"}}, "with a part 'force'"),
    ({"outputs": {"y": "output"}}, "is no state"),
    ({"outputs": {}}, "no output"),
    ({"outputs": {"x": "torsion"}}, "no channel 'torsion'"),
    ({"between": "cubic"}, "between is"),
    ({"between": "held", "free": ("excitation.delay",)}, "held input"),
    ({"steps": 0}, "steps"),
]


@pytest.mark.parametrize(("changes", "sentence"), BAD)
def test_what_cannot_be_asked_is_one_sentence(changes, sentence):
    t = np.arange(100) / RATE
    log = {"time": t, "input": np.sin(9.0 * t), "output": np.sin(9.0 * t)}
    asked = {"free": ("J",), "inputs": {"excitation": "input"}, "outputs": {"x": "output"}} | changes
    with pytest.raises(ValueError, match=sentence) as error:
        sw.identify(GUESS, log, **asked)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (lambda log: log | {"output": 0.0 * log["output"]}, "use a record with motion"),
        (lambda log: log | {"output": 1e200 * log["time"]}, r"values beyond 1e\+30; give it in SI"),
        (lambda log: log | {"input": np.where(log["time"] == log["time"][7], np.nan, log["input"])}, "sample 7"),
        (lambda log: log | {"time": log["time"][::-1]}, "times must ascend"),
        (lambda log: log | {"time": log["time"] ** 1.5}, "equal steps"),
        (lambda log: log | {"input": log["input"][:-1]}, "equally many"),
        (lambda log: {n: v[:5] for n, v in log.items()}, "16 at least"),
        (lambda log: {"time": log["time"], "output": log["output"]}, "no channel 'input'"),
    ],
)
def test_a_log_that_tells_nothing_is_one_sentence(change, sentence):
    t = np.arange(100) / RATE
    log = change({"time": t, "input": np.sin(9.0 * t), "output": np.sin(9.0 * t)})
    with pytest.raises(ValueError, match=sentence):
        sw.identify(GUESS, log, ("J",), inputs={"excitation": "input"})


@pytest.mark.slow
def test_noise_is_said_to_be_unexplained(clean):
    noise = np.random.default_rng(0).standard_normal(1500)
    found = sw.identify(GUESS, clean | {"output": noise}, ("J", "B"))
    assert any("explains almost nothing of x" in note for note in found.notes)
