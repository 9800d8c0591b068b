"""Each controller on measurements: what it must do by its closed form, with lost samples, compiled as in Python."""

import math

import numpy as np
import pytest
from one_bench import DRIVE, ERROR, J_L, J_M, PD, PERIOD, N
from scipy import signal

import strainwave as sw
from strainwave.base.quantities import checked
from strainwave.compile.jit import kernel, run
from strainwave.compile.tree import leaves
from strainwave.model.controllers.closed_loop import even, noise, rounded
from strainwave.model.controllers.feedforward import inverse

OPEN = DRIVE._replace(motor=DRIVE.motor._replace(control=sw.train.Commanded()))
CONTROLLERS = {
    "SampledPD": sw.controllers.SampledPD(3.0, 0.1, PERIOD, 1e-3, 2e-3),
    "Cascade": sw.controllers.Cascade(40.0, 0.5, 20.0, PERIOD, 1e-3, 2e-3, 4.0),
    "AngleFeedforward": sw.controllers.AngleFeedforward(PD, ERROR, N, 3e-4, J_M),
    "TorqueTable": sw.controllers.TorqueTable(PD, sw.Harmonics((sw.Harmonic(0.2, 2, 0.4), sw.Harmonic(0.1, 4))), 3e-4),
    "InverseDynamics": sw.controllers.InverseDynamics(PD, OPEN, 3e-4),
    "AdaptiveCancellation": sw.controllers.AdaptiveCancellation(PD, N, 500.0, 0.7, 2.0, PERIOD, order=2),
    "AdaptiveCancellation, motor": sw.controllers.AdaptiveCancellation(
        PD, N, 500.0, 0.7, 2.0, PERIOD, order=2, on_load=0
    ),
    "Repetitive": sw.controllers.Repetitive(PD, N, 500.0, 0.3, 1e-3, 2.0, PERIOD),
    "SpeedTable": sw.controllers.SpeedTable(
        PD, (20.0, 45.0, 90.0), (0.1, -0.2, 0.3), (0.0, 0.1, 0.2), order=2, lead=3e-4
    ),
    "DisturbanceObserver": sw.controllers.DisturbanceObserver(PD, J_M, 300.0, PERIOD),
    "Notch": sw.controllers.notch(PD, 194.0, PERIOD),
}
each = pytest.mark.parametrize("controller", CONTROLLERS.values(), ids=CONTROLLERS.keys())


def measurements(count=200, lost=()):
    """A slow run-up with noise on both encoders."""
    rng, rows = np.random.default_rng(5), []
    for k in range(count):
        t = k * PERIOD
        angle, speed = 40.0 * t + 10.0 * t * t, 40.0 + 20.0 * t
        motor, load = angle + 1e-3 * rng.standard_normal(), angle / N + 1e-4 * rng.standard_normal()
        rows.append(
            sw.controllers.Measurement(
                angle, speed, 20.0, motor, math.nan if k in lost else load, 0.3 * rng.standard_normal(), 0.0
            )
        )
    return rows


@kernel
def replay(controller, table, out):
    state = controller.start()
    for k in range(len(out)):
        m = sw.controllers.Measurement(
            table[k, 0], table[k, 1], table[k, 2], table[k, 3], table[k, 4], table[k, 5], 0.0
        )
        state, out[k] = controller.update(state, m)


@each
@pytest.mark.slow
def test_compiled_code_does_what_python_does(controller):
    table = np.array(measurements(lost=(7, 8)), float)
    compiled, python = np.zeros(len(table)), np.zeros(len(table))
    run(replay, controller, table, compiled)
    replay(controller, table, python)
    np.testing.assert_allclose(compiled, python, rtol=1e-12, atol=1e-12 * np.max(np.abs(python)))


@each
def test_a_lost_angle_of_the_load_leaves_the_torque_finite(controller):
    state = controller.start()
    for m in measurements(60, lost=range(20, 40)):
        state, torque = controller.update(state, m)
        assert math.isfinite(torque)
    assert np.all(np.isfinite(leaves(state)))


def test_the_pd_loop_is_its_formula():
    state = CONTROLLERS["SampledPD"].start()
    _, first = CONTROLLERS["SampledPD"].update(state, sw.controllers.Measurement(1.0, 2.0, 5.0, 1.01, 0.0, 0.0, 0.0))
    assert first == pytest.approx(2e-3 * 5.0 - 3.0 * 0.01)
    state, _ = CONTROLLERS["SampledPD"].update(state, sw.controllers.Measurement(1.0, 2.0, 5.0, 1.01, 0.0, 0.0, 0.0))
    _, second = CONTROLLERS["SampledPD"].update(state, sw.controllers.Measurement(1.2, 2.0, 5.0, 1.23, 0.0, 0.0, 0.0))
    rate = 0.02 / PERIOD * PERIOD / (PERIOD + 1e-3)
    assert second == pytest.approx(2e-3 * 5.0 - 3.0 * 0.03 - 0.1 * rate)


def test_an_integral_gives_back_what_the_limit_took():
    """A load that a limited torque cannot carry for a second, then lets go: the integral must not have wound up."""
    cascade = sw.controllers.Cascade(40.0, 0.5, 20.0, PERIOD)

    def overshoot(gives_back):
        state, angle, speed, applied, worst, asked = cascade.start(), 0.0, 0.0, 0.0, 0.0, 0.0
        for k in range(8000):
            cut = applied - asked if gives_back else 0.0
            state, asked = cascade.update(state, sw.controllers.Measurement(0.0, 0.0, 0.0, angle, 0.0, applied, cut))
            applied = min(max(asked, -1.0), 1.0)
            against = 2.0 if k < 4000 else 0.0
            speed = max(speed + PERIOD * (applied - against - 0.5 * speed) / 5e-3, -0.5)
            angle += PERIOD * speed
            worst = max(worst, angle)
        return worst

    assert overshoot(True) < 0.2 * overshoot(False)


@pytest.mark.parametrize("K_x", [0.0, 8.0])
def test_a_cascade_answers_a_torque_step_as_its_transfer_function(K_x):
    K_v, K_p, K_i, J, period = 40.0, 0.5, 20.0, 5e-3, 2e-5
    cascade = sw.controllers.Cascade(K_v, K_p, K_i, period, K_x=K_x)
    state, angle, speed, found = cascade.start(), 0.0, 0.0, []
    for _ in range(20000):
        found.append(angle)
        state, torque = cascade.update(state, sw.controllers.Measurement(0.0, 0.0, 0.0, angle, 0.0, 0.0, 0.0))
        angle += period * (speed + 0.5 * period * (torque - 1.0) / J)
        speed += period * (torque - 1.0) / J
    loop = np.polymul([1.0, K_v, K_v * K_x], [K_p, K_i])
    step = signal.TransferFunction([-1.0, 0.0, 0.0], np.polyadd([J, 0.0, 0.0, 0.0, 0.0], loop))
    _, wanted = signal.step(step, T=period * np.arange(20000))
    np.testing.assert_allclose(found, wanted, atol=2e-3 * np.max(np.abs(wanted)))


@pytest.mark.parametrize(("frequency", "gain"), [(200.0, 0.0), (20.0, 1.0), (2000.0, 1.0)])
def test_the_notch_has_its_gain_at_its_frequency_and_one_far_away(frequency, gain):
    plain = sw.controllers.SampledPD(1.0, 0.0, PERIOD)  # gives back the deviation, with a minus
    controller, torques = sw.controllers.notch(plain, 200.0, PERIOD, width=0.3), []
    state = controller.start()
    for k in range(40000):
        state, torque = controller.update(
            state, sw.controllers.Measurement(0.0, 0.0, 0.0, math.sin(frequency * k * PERIOD), 0, 0, 0)
        )
        torques.append(torque)
    assert np.max(np.abs(torques[30000:])) == pytest.approx(gain, abs=5e-3)


def test_the_observer_finds_a_constant_torque_with_its_bandwidth():
    """J theta'' = tau + d, tau what is applied: the estimate is d (1 - exp(-g t))."""
    still = sw.controllers.SampledPD(0.0, 0.0, PERIOD)
    controller, speed, angle, applied, found = (
        sw.controllers.DisturbanceObserver(still, 2e-3, 100.0, PERIOD),
        0.0,
        0.0,
        0.0,
        [],
    )
    state = controller.start()
    for _ in range(400):
        state, asked = controller.update(state, sw.controllers.Measurement(0.0, 0.0, 0.0, angle, 0.0, applied, 0.0))
        found.append(-asked)
        angle += PERIOD * (speed + 0.5 * PERIOD * (asked + 0.7) / 2e-3)
        speed += PERIOD * (asked + 0.7) / 2e-3
        applied = asked
    t = PERIOD * np.arange(400)
    np.testing.assert_allclose(found[20:], 0.7 * (1.0 - np.exp(-100.0 * t[20:])), atol=0.7 * 3 * 100.0 * PERIOD)
    assert found[-1] == pytest.approx(0.7, rel=1e-3)


def test_the_inverse_keeps_the_load_on_course():
    """With the motion and torque of the inverse, the train's own equations accelerate neither load nor deviation."""
    train = OPEN._replace(
        motor=OPEN.motor._replace(drag=sw.laws.Coulomb(0.02)), error=sw.KinematicError((sw.Line(2, 1e-4, 0.7),)),
        load=sw.train.Load(J_L, sw.Harmonic(0.0, mean=-70.0), sw.laws.Viscous(3.0)), omega=80.0,
    )  # fmt: skip
    angle, h = 2.3, 1e-5
    motor, fast, torque = inverse(train, angle, 80.0, 0.0)
    early, later = (inverse(train, angle + d, 80.0, 0.0)[0] for d in (-80.0 * h, 80.0 * h))
    assert (later - early) / (2.0 * h) == pytest.approx(fast, rel=1e-6)  # its speed is that of its angle
    x, v = motor / N - angle / N, fast / N - 80.0 / N
    rates = train.rhs(angle, (x, v, motor - angle, fast - 80.0, torque))
    load = rates[3] / N - rates[1]  # acceleration of the load, the motor's over N less x''
    assert abs(load) * J_L < 1e-9 * 70.0 + abs(train.B * (v - train.error.slope(motor) * fast)) + 1e-9
    before = inverse(train, angle - 80.0 * h, 80.0, 0.0)[1]
    after = inverse(train, angle + 80.0 * h, 80.0, 0.0)[1]
    assert rates[3] == pytest.approx((after - before) / (2.0 * h), rel=1e-4)


def test_an_angle_is_in_whole_steps_of_its_encoder():
    assert rounded(0.26, 0.1) == pytest.approx(0.3)
    assert rounded(-0.26, 0.1) == pytest.approx(-0.3)
    assert rounded(0.26, 0.0) == 0.26


def test_noise_is_white_and_the_same_in_every_run():
    values = np.array([noise(1, 3, k, 0) for k in range(20000)])
    assert np.mean(values) == pytest.approx(0.0, abs=0.03)
    assert np.std(values) == pytest.approx(1.0, rel=0.02)
    assert abs(np.mean(values[1:] * values[:-1])) < 0.03
    other = np.array([noise(1, 4, k, 0) for k in range(2000)])
    assert abs(np.mean(values[:2000] * other)) < 0.08
    assert noise(1, 3, 17, 0) == noise(1, 3, 17, 0)
    shares = np.array([even(2, 0, k, 2) for k in range(20000)])
    np.testing.assert_allclose(np.histogram(shares, 10, (0.0, 1.0))[0], 2000, atol=200)


@pytest.mark.slow
def test_compiled_noise_is_that_of_python():
    @kernel
    def fill(out):
        for k in range(len(out)):
            out[k] = noise(7, 12, k, 1) + even(7, 12, k, 2)

    compiled, python = np.zeros(500), np.zeros(500)
    run(fill, compiled)
    fill(python)
    np.testing.assert_allclose(compiled, python, rtol=1e-15)


def test_a_load_with_several_drags_has_an_inverse_and_one_with_memory_none():
    load = OPEN.load._replace(drag=sw.Parallel(sw.laws.Viscous(0.5), sw.laws.Coulomb(2.0)))
    checked(sw.controllers.InverseDynamics(PD, OPEN._replace(load=load)))
    load = OPEN.load._replace(drag=sw.BoucWen(1e5, 0.3, 1e-4))
    with pytest.raises(ValueError, match="couplings or laws with memory"):
        checked(sw.controllers.InverseDynamics(PD, OPEN._replace(load=load)))


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: sw.controllers.SampledPD(-1.0, 0.1, PERIOD), r"SampledPD.K_p is -1; give a positive value"),
        (lambda: sw.controllers.SampledPD(1.0, 0.1, 0.0), r"SampledPD.period is 0 s; the period must be positive"),
        (lambda: sw.controllers.Cascade(1.0, 0.0, 1.0, PERIOD), r"Cascade.K_p is 0"),
        (
            lambda: sw.controllers.DisturbanceObserver(PD, J_M, 5000.0, PERIOD),
            r"below 4000 rad/s \(one per",
        ),
        (
            lambda: sw.controllers.AdaptiveCancellation(PD, N, -1.0, 0.0, 1.0, PERIOD),
            r"AdaptiveCancellation.gain is -1",
        ),
        (
            lambda: sw.controllers.AdaptiveCancellation(PD, N, 1.0, 0.0, 1.0, PERIOD, order=0),
            r"order is 0; it must be above 0",
        ),
        (lambda: sw.controllers.Repetitive(PD, N, 1.0, 0.0, 1.5, 1.0, PERIOD), r"smooth is 1.5; it is a share"),
        (lambda: sw.controllers.Sampling(delay=2e-3), r"delay is 0.002 s; it must be at most 7 periods, 0.00175 s"),
        (lambda: sw.controllers.Sampling(period=0.0), r"Sampling.period is 0; it must be positive"),
        (lambda: sw.controllers.Sampling(loss=1.0), r"Sampling.loss is 1; it is a share"),
    ],
)
def test_numbers_out_of_range_get_a_sentence(make, sentence):
    with pytest.raises(ValueError, match=sentence):
        checked(make())


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: sw.controllers.notch(PD, 2e4, PERIOD), "carry none above 12566.4 rad/s"),
        (lambda: sw.controllers.notch(PD, 200.0, PERIOD, depth=2.0), "depth is 2; it must be from 0 to 1"),
    ],
)
def test_makers_refuse_what_they_cannot_make(make, sentence):
    with pytest.raises(ValueError, match=sentence):
        make()
