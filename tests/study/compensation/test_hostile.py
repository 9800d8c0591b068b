"""Benches that are easily got wrong: blind controllers, slow learners, stiff plants, loops that drift, wrong kinds."""

import math
import re
from typing import NamedTuple

import numpy as np
import pytest
from one_bench import DRIVE, GEAR, J_M, LINEAR, LOOP, PD, PERIOD, SAMPLING, loop

import strainwave as sw
from strainwave.base.units import ARCSEC
from strainwave.model.controllers.loops import moved
from strainwave.study.compensation.bench import bench_of

BLIND = SAMPLING._replace(load_encoder=0)
LOADED = DRIVE._replace(load=sw.train.Load(10.0, sw.Harmonic(0.0, 1, 0.0, -30.0)))


def compensated(train=DRIVE, controller="adaptive", speed=45.0, **given):
    return sw.compensate(train, controller, **{"speed": speed, "sampling": SAMPLING, "robust": False} | given)


@pytest.mark.parametrize("name", ["adaptive", "adaptive-inverse", "repetitive", "measured-table"])
def test_what_measures_the_load_needs_its_encoder(name):
    """Without one these controllers did nothing, and the bench said 0 dB."""
    with pytest.raises(ValueError, match=f"{name} needs an encoder on the load, but Sampling.load_encoder is 0"):
        compensated(controller=name, sampling=BLIND)
    given = sw.controllers.AdaptiveCancellation(PD, 50.0, 1.0, 0.0, 1.0, PERIOD)
    with pytest.raises(ValueError, match="AdaptiveCancellation needs an encoder on the load"):
        compensated(controller=given, sampling=BLIND)


@pytest.mark.slow
def test_controllers_without_the_load_run_without_its_encoder():
    assert compensated(controller=PD, sampling=BLIND).load_encoder is False
    assert compensated(controller="inverse", sampling=BLIND).reduction > 30.0


@pytest.mark.slow
def test_a_given_controller_is_judged_by_its_own_slow_gain():
    """A tenth of the designed gain takes ten times as long, and leaves as little."""
    quick = sw.study.COMPENSATORS["adaptive"].build(bench_of(LINEAR, sw.controllers.Sampling(PERIOD, PERIOD)), 45.0)
    slow = quick._replace(gain=0.1 * quick.gain)
    for controller in (quick, slow):
        found = compensated(LINEAR, controller, sampling=sw.controllers.Sampling(PERIOD, PERIOD))
        assert found.amplitude_after[0] < 1e-3 * found.amplitude_before[0]


@pytest.mark.slow
def test_repetitive_control_is_judged_when_its_slowest_order_has_converged():
    """At the resonance one lead serves all orders badly, and order 2 converges with a quarter of the rate."""
    assert compensated(controller="repetitive", speed=0.5 * math.sqrt(GEAR.K1 / 10.0)).reduction > 20.0


@pytest.mark.slow
def test_repetitive_control_carries_the_mean_torque_of_the_load():
    """Its guard knows of the mean: under a load at the corner of the law it once dropped its torque without a word."""
    corner = DRIVE._replace(load=sw.train.Load(10.0, sw.Harmonic(0.0, 1, 0.0, -GEAR.law.T1)))
    found = compensated(corner, "repetitive")
    assert found.reduction > 20.0


@pytest.mark.slow
def test_a_guard_that_has_dropped_its_torque_is_said():
    right = sw.study.COMPENSATORS["adaptive"].build(bench_of(LINEAR, SAMPLING), 50.0)
    wrong = right._replace(phase=right.phase + math.pi)
    for controller in (wrong, sw.controllers.TorqueTable(wrong, sw.Harmonic(0.0, 2))):
        found = compensated(LINEAR, controller, speed=50.0)
        assert any("the guard switched the correction torque off at 477.5 rpm" in text for text in found.warnings)
    assert not compensated(LINEAR, right, speed=50.0).warnings


@pytest.mark.slow
def test_a_limit_that_is_met_while_a_loop_settles_does_not_exclude_the_speed():
    found = compensated(LOADED, "nonlinear-inverse")
    assert found.torque.limited > 0.0
    assert found.torque.peak < SAMPLING.limit
    assert found.excluded == ""


@pytest.mark.slow
def test_a_stiff_plant_is_not_taken_for_an_unstable_loop():
    """Of a gear with much damping four steps a sample were unstable themselves."""
    drive = LINEAR._replace(B=4e5)
    found = bench_of(drive, SAMPLING).response(45.0)
    assert found.stable
    motor = drive.motor._replace(control=sw.train.Commanded())
    own = loop(sampling=sw.controllers.Sampling(PERIOD, PERIOD))._replace(train=drive._replace(motor=motor, omega=45.0))
    fine = sw.numerics.loop_response(own, found.omega, steps=1000)
    np.testing.assert_allclose(found.error_of_torque, fine.error_of_torque, rtol=1e-4)
    with pytest.raises(ValueError, match="too slow for the plant, which needs"):
        bench_of(LINEAR._replace(B=1e8), SAMPLING).response(45.0)


def test_an_encoder_of_the_load_is_no_loop_to_sample():
    control = sw.train.LoadEncoder(sw.train.CascadeLoop(4.0, 0.1, 0.05))
    with pytest.raises(ValueError, match=r"write 'encoder: motor' in motor.loop, or give a sampled controller"):
        bench_of(LINEAR._replace(motor=LINEAR.motor._replace(control=control)), SAMPLING)


def test_a_loop_without_stiffness_is_named():
    loose = LINEAR._replace(motor=LINEAR.motor._replace(control=sw.train.SpeedLoop(0.4)))
    for drive in (loose, LINEAR._replace(law=sw.Backlash(1e5, 2e-4))):
        with pytest.raises(ValueError, match="use a loop with a position gain, or a mean load outside the backlash"):
            compensated(drive)


def test_a_hysteresis_that_cannot_carry_the_load_is_named():
    """It yields without end; one that carries the load is run, though its internal state stays where it is left."""
    weight = sw.train.Load(10.0, drag=sw.train.AngleTorque(40.0, phase=0.5 * math.pi))
    with pytest.raises(ValueError, match=r"as .*BoucWen.* 3[.]2 N[*]m"):
        compensated(DRIVE._replace(law=sw.BoucWen(4e4, 0.0, 8e-5), load=weight))
    carries = bench_of(DRIVE._replace(law=sw.Parallel(sw.BoucWen(4e4, 0.0, 8e-5), sw.Linear(8e4)), load=weight))
    assert carries.memory == 1
    assert carries.response(45.0).stable
    assert carries.response(45.0).slowest < 1.0


def test_repetitive_control_is_refused_around_an_integral():
    """The table's mean and the integral of the loop would grow for ever, one against the other."""
    cascade = sw.controllers.Cascade(40.0, 0.4, 8.0, PERIOD, J=J_M)
    with pytest.raises(ValueError, match="often caused by an integral in the plain loop"):
        compensated(controller="repetitive", loop=cascade)


@pytest.mark.parametrize(
    ("given", "error", "sentence"),
    [
        ({"speed": 0.0}, ValueError, "a drive at rest has no orders"),
        ({"load_angles": (0.5,)}, ValueError, "no torque on this load depends on its angle"),
        ({"load_angles": ()}, ValueError, "load_angles"),
        ({"speed": 1e-12}, ValueError, "4 turns at 9.549×10⁻¹² rpm take more than 1e[+]08 samples"),
        (
            {"loop": sw.controllers.SampledPD(LOOP.K_p, LOOP.K_d, 1e-3)},
            ValueError,
            "is 0.001 s and Sampling[.]period is 0.00025 s",
        ),
        ({"sampling": SAMPLING._replace(load_encoder=2)}, ValueError, "load_encoder is 2; it must be 1"),
        ({"seed": -1}, ValueError, "seed is -1; it must be a whole number"),
    ],
)
def test_numbers_get_a_sentence(given, error, sentence):
    with pytest.raises(error, match=sentence):
        compensated(controller="inverse", **given)


def test_a_run_of_too_many_samples_is_refused():
    with pytest.raises(ValueError, match=r"a loop is run for at most 1e\+08: run it for at most 25000 s"):
        sw.numerics.run_loop(loop(), 1e6)
    with pytest.raises(ValueError, match=r"duration is 1e\+12 s"):
        sw.numerics.loop_ensemble(loop(), {}, 1e12, settle=0.0)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["adaptive", "adaptive-inverse", "repetitive"])
def test_what_learns_forward_learns_backward_too(name):
    """Near the resonance the plant's phase is beyond 45 degrees: with its sign of forward motion it diverged."""
    ideal = sw.controllers.Sampling(PERIOD, PERIOD)
    bench, speed = bench_of(LINEAR, ideal), 44.5
    assert math.pi / 4.0 < abs(float(np.angle(bench.response(speed).error_of_torque[0]))) < 3.0 * math.pi / 4.0
    controller = sw.study.COMPENSATORS[name].build(bench, speed)
    for way in (1.0, -1.0):
        left, before = (
            sw.numerics.run_loop(bench.closed(one, way * speed), 14.0).rms(12.0) for one in (controller, PD)
        )
        assert left < 0.05 * before


@pytest.mark.slow
def test_an_integral_takes_away_a_torque_that_is_added_around_it():
    """Its anti-windup counts what the limit took, not what a controller around it adds: that once leaked it away."""
    cascade, ideal = sw.controllers.Cascade(40.0, 0.4, 8.0, PERIOD, J=J_M), sw.controllers.Sampling(PERIOD, PERIOD)
    around = sw.controllers.TorqueTable(cascade, sw.Harmonic(0.0, 1, 0.0, 0.5))
    late = [
        sw.numerics.run_loop(loop(one, sampling=ideal, law=LINEAR.law), 6.0).error[20000:] for one in (cascade, around)
    ]
    assert np.mean(late[1]) == pytest.approx(np.mean(late[0]), abs=1e-6 * 0.5 / (40.0 * 0.4))


class Own(NamedTuple):
    """A slow integral on the load's error that no design knows."""

    inner: sw.controllers.SampledPD
    gain: float

    def start(self):
        return self.inner.start(), 0.0

    def update(self, state, m):
        shift = state[1] + self.gain * PERIOD * (m.reference / 50.0 - m.load)
        memory, torque = self.inner.update(state[0], moved(m, 50.0 * shift, 0.0, 0.0))
        return (memory, shift), torque


@pytest.mark.slow
def test_a_controller_of_ones_own_is_judged_when_its_slowest_motion_has_decayed():
    """Its mean decays with its gain, by a factor e in 8 s; it was measured after the ten time constants of the loop."""
    found = compensated(LOADED, Own(PD, 0.125), sampling=SAMPLING._replace(load_noise=0.0))
    assert abs(found.before.mean) > 60.0 * ARCSEC
    assert abs(found.after.mean) < 1e-3 * abs(found.before.mean)
    assert 1.0 / found.rate == pytest.approx(8.0, rel=0.05)
    (constant,) = re.findall(r"slowest time constant of the adaptation ([\d.]+) s", str(found))
    assert float(constant) == pytest.approx(8.0, rel=0.05)
