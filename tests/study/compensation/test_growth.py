"""Stability of a sampled loop: its multipliers against closed forms and a loop of its own, and what is offered."""

import math

import numpy as np
import pytest
from one_bench import DRIVE, PD, PERIOD, SAMPLING
from scipy.linalg import expm

import strainwave as sw
from strainwave.model.controllers.loops import Measurement
from strainwave.study.compensation.bench import steady_bench_of
from strainwave.study.compensation.designs import COMPENSATORS, Compensator, scaled_gains
from strainwave.study.compensation.gains import learning_rate, rate_of

N, J_M, J_L, B, K, ALPHA, MEAN = 80.0, 8.1346e-4, 5.38563, 22.5923, 25895.9, 2.13606e6, -18.182
SPEED, STEP = 23.63939, 5e-4
LEARNING = sw.Drive(J_M, J_L, N, B, sw.Cubic(K, ALPHA)).train(
    kinematic_error=sw.KinematicError((sw.Line(2, 1.063e-5, -2.0628),)), control=sw.train.PositionLoop(62.616, 0.35973),
    omega=50.0, load_torque=sw.Harmonic(0.0, mean=MEAN),
)  # fmt: skip
SLOW = sw.controllers.Sampling(STEP, 0.0)


@pytest.mark.slow
def test_what_adapts_decays_with_the_rate_of_its_gain():
    """a' = -g y cos(k theta + phi) decays with g |G| cos(0)/2: the rate that the gain was made of."""
    bench = steady_bench_of(DRIVE, SAMPLING)
    controller = COMPENSATORS["adaptive"].build(bench, 50.0)
    slow = scaled_gains(controller, 0.1)
    assert learning_rate(bench, 50.0, slow) == pytest.approx(0.1 * rate_of(bench, 50.0), rel=1e-9)
    assert bench.growth(slow, 50.0) == pytest.approx(-0.1 * rate_of(bench, 50.0), rel=0.02)


def test_a_loop_without_memory_of_the_turn_grows_by_the_poles_of_its_samples():
    """Delay alone makes a stiff loop unstable; the motor alone is 1/(J z) of two integrations in closed form."""
    bench = steady_bench_of(DRIVE, SAMPLING)
    assert bench.growth(PD, 50.0) == pytest.approx(-1.0 / bench.response(50.0).slowest, rel=1e-6)
    stiff = sw.controllers.SampledPD(400.0 * PD.K_p, 0.2 * PD.K_d, PERIOD)
    assert bench.growth(stiff, 50.0) > 0.0


def own_growth(controller, turns=(60, 120)):
    """Rate [1/s] of the error of a linear loop of its own about the mean torque, exact from sample to sample."""
    twist = np.roots([K * ALPHA, 0.0, K, MEAN])
    twist = float(twist[np.abs(twist.imag) < 1e-12].real[0])
    stiffness = K * (1.0 + 3.0 * ALPHA * twist * twist)
    A = np.zeros((5, 5))  # motor, its speed, load, its speed, torque held
    A[0, 1] = A[2, 3] = 1.0
    gear = np.array([stiffness / N, B / N, -stiffness, -B, 0.0])
    A[1], A[3] = -gear / N / J_M, gear / J_L
    A[1, 4] = 1.0 / J_M
    step, y, memory, found = expm(A * STEP), np.array([1e-5, 0.0, 0.0, 0.0, 0.0]), controller.start(), []
    turn = round(2.0 * math.pi / SPEED / STEP)
    for i in range(turns[1] * turn):
        wanted = SPEED * i * STEP
        m = Measurement(wanted, SPEED, 0.0, wanted + y[0], (wanted / N) + y[2], 0.0, 0.0)
        memory, y[4] = controller.update(memory, m)
        y = step @ y
        found.append(y[2])
    early, late = (np.std(found[(t - 20) * turn : t * turn]) for t in turns)
    return math.log(late / early) / ((turns[1] - turns[0]) * turn * STEP)


@pytest.mark.slow
def test_what_learns_over_the_turn_grows_as_a_loop_of_its_own_does():
    bench = steady_bench_of(LEARNING, SLOW)
    controller = COMPENSATORS["repetitive"].build(bench, SPEED)._replace(most=1e9)
    growth = bench.growth(controller, SPEED)
    assert 0.03 < growth < 0.07  # by e in 20 s: 90 turns of the motor, in 20 of which nothing is to be seen
    assert growth == pytest.approx(own_growth(controller), rel=0.03)
    said = r"repetitive is unstable on its own model at 225\.7 rpm: small motions .* by a factor e every \d+(\.\d)? s"
    with pytest.raises(ValueError, match=said):
        sw.compensate(LEARNING, "repetitive", speed=SPEED, sampling=SLOW, robust=False)
    given = sw.compensate(LEARNING, controller, speed=SPEED, sampling=SLOW, robust=False)
    assert not given.stable
    assert not given.gains
    assert given.warnings[0].startswith("controller Repetitive: small motions of the sampled loop grow at 225.7 rpm")


BEATING = """\
gear: {ratio: 100, law: {type: linear, K: 3.1e4 N*m/rad}}
hysteresis: {type: bouc_wen, K: 1e4 N*m/rad, ratio: 0, yield_twist: 0.08 mrad}
motor: {inertia: 3 kg*cm^2, loop: {type: cascade, bandwidth: 30 Hz, damping: 0.7}}
load: {inertia: 1.2 kg*m^2}
damping: {ratio: 3 %}
speed: {from: 300 rpm, to: 2000 rpm, shaft: motor}
excitation:
  kinematic_error:
    - {order: 2, amplitude: 10 arcsec}
    - {order: {wave_generator: 2, output: 1}, amplitude: 3 arcsec}
"""


@pytest.mark.slow
def test_gains_are_lowered_where_a_motion_grows_beyond_all_floats(tmp_path):
    """Lines of the output's turn repeat after 100 turns of the motor, over which the first gains overflow."""
    (tmp_path / "axis.yaml").write_text(BEATING)
    project, speed = sw.read_project(tmp_path / "axis.yaml"), 2000.0 * math.pi / 30.0
    bench = steady_bench_of(project)
    built = COMPENSATORS["adaptive"].build(bench, speed)
    assert 1.0 < bench.growth(built, speed) < math.inf
    lowered = sw.compensate(project, "adaptive", speed=speed)
    assert lowered.stable
    assert lowered.after.rms < 0.1 * lowered.before.rms


@pytest.mark.slow
def test_gains_are_lowered_until_the_own_model_is_stable_with_a_factor_of_two():
    bench = steady_bench_of(DRIVE, SAMPLING)
    whole = scaled_gains(COMPENSATORS["adaptive"].build(bench, 50.0), 8.0)
    design = Compensator("quick", "", lambda *_: whole, True, "")
    found = design.controller_on(bench, 50.0)
    assert found == scaled_gains(whole, 0.25)
    assert bench.growth(scaled_gains(whole, 0.5), 50.0) < 0.0 < bench.growth(whole, 50.0)
    fast = scaled_gains(whole, 8.0)
    with pytest.raises(ValueError, match=r"quick is unstable .* even with 0\.25 of the gains"):
        Compensator("quick", "", lambda *_: fast, True, "").controller_on(bench, 50.0)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["angle", "inverse"])
def test_what_wanders_within_a_step_of_an_encoder_does_not_grow(name):
    """A motor's encoder of 12 bits; its step is 6.3 arcsec of the load, the error that is left less than 1."""
    law = sw.PiecewiseLinear(19241.023398965077, 27158.16160956702, 32589.793931480424, 3.36681730, 13.22087390)
    drive = sw.Drive(1.4773594456262145e-4, 1.0974780097892989, 50.0, 7.331141214677441, law).train(
        kinematic_error=sw.KinematicError((sw.Line(2, 1.9108886849167966e-05, 0.9040345775979004),)),
        control=sw.train.PositionLoop(19.836954499182603, 0.1510370957933448), omega=50.0,
    )  # fmt: skip
    turn = 2.0 * math.pi
    coarse = sw.controllers.Sampling(limit=1e3, motor_quantum=turn / 2**12, load_quantum=turn / 2**24)
    found = sw.compensate(drive, name, speed=25.988958534690408, sampling=coarse, robust=False)
    assert found.after.rms < 0.2 * found.before.rms
    assert found.stable
    assert found.gains
    assert not found.warnings
