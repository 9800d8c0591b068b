"""Compensation: the bench of a CSG-40-50, laws of residuals, wrong models, wrong signs, units, and what is refused."""

import math

import numpy as np
import pytest
from one_bench import DRIVE, ERROR, LINEAR, OMEGA_A, PD, PERIOD, SAMPLING, loop

import strainwave as sw
from strainwave.base.units import ARCSEC
from strainwave.model.train.filters import LoadEncoder
from strainwave.study.compensation.bench import bench_of, steady_bench_of

SPEEDS = [share * OMEGA_A / 2.0 for share in (0.3, 0.9, 1.0, 1.1, 3.0)]
IDEAL = sw.controllers.Sampling(PERIOD, PERIOD)
SOFT = LINEAR._replace(law=LINEAR.law._replace(K1=0.8e5, K2=0.8e5, K3=0.8e5))


def run(controller, speed=50.0, **changes):
    """Residual of a controller on the drive, in steady state."""
    found = sw.numerics.loop_ensemble(loop(controller, speed, **changes), {}, 6.0, settle=4.0, orders=[2])
    return found.amplitude[0, 0] * np.exp(1j * found.phase[0, 0])


@pytest.mark.slow
def test_with_a_load_encoder_twenty_decibels_at_every_speed():
    """Below, on and above the resonance; without one the linear inverse does it by the model."""
    bench = sw.study.compensation_bench(
        DRIVE, ("inverse", "adaptive", "adaptive-inverse"), speeds=SPEEDS, sampling=SAMPLING
    )
    best = [one.reduction for one in bench.best()]
    assert min(best) > 20.0
    assert np.all(bench.reduction > 30.0)  # the linear inverse without a load's encoder
    assert not any(one.excluded for row in bench.results for one in row)
    assert all(one.torque.peak < 3.0 for row in bench.results for one in row)


FRICTION = sw.laws.Coulomb(1.0)


def lifted(mean):
    """The drive with a weight of 40 N*m on its load, and friction beside it."""
    drag = sw.Parallel(sw.train.AngleTorque(40.0, phase=0.3), FRICTION)
    return LINEAR._replace(load=sw.train.Load(DRIVE.load.J, sw.Harmonic(0.0, mean=mean), drag))


@pytest.mark.parametrize(("mean", "held"), [(0.0, 0.0), (-5.0, -5.0)])
def test_gravity_is_held_where_the_load_begins(mean, held):
    """In every steady run; moves and run-ups keep it as it is. Friction stays."""
    bench = steady_bench_of(lifted(mean), SAMPLING)
    for train in (bench.model, bench.plant):
        assert train.load.excitation.mean == pytest.approx(held - 40.0 * math.sin(0.3))
        assert train.load.drag.second == FRICTION
        assert not isinstance(train.load.drag.first, sw.train.AngleTorque)
    assert any("Gravity varies 50 times more slowly" in text for text in bench.remarks)
    assert steady_bench_of(LINEAR, SAMPLING) == bench_of(LINEAR, SAMPLING)
    assert bench_of(lifted(mean), SAMPLING).plant.load.drag == lifted(mean).load.drag


@pytest.mark.slow
def test_the_slow_twist_of_gravity_is_no_residual():
    """On a linear gear a weight changes neither the plain loop's error nor what is left by a controller that adapts.

    Its twist would drift by 80 arcsec either way.
    """
    weight = LINEAR._replace(load=sw.train.Load(DRIVE.load.J, drag=sw.train.AngleTorque(40.0, phase=1.2)))
    plain, lifting = (
        sw.compensate(train, "adaptive", speed=60.0, sampling=SAMPLING, robust=False) for train in (LINEAR, weight)
    )
    assert lifting.before.rms == pytest.approx(plain.before.rms, rel=1e-2)
    assert lifting.after.rms == pytest.approx(plain.after.rms, rel=0.05, abs=0.05 * ARCSEC)


@pytest.mark.slow
@pytest.mark.parametrize(("g", "phi"), [(0.8, 0.0), (1.0, 0.3), (1.2, -0.5), (0.5, 1.5)])
@pytest.mark.parametrize("speed", [15.0, 55.0])
def test_a_feedforward_off_by_gain_and_phase_leaves_what_it_must(g, phi, speed):
    """Of the exact inverse, times g and turned by phi, |1 - g e^(i phi)| of the error is left."""
    line = ERROR.lines[0]
    wrong = sw.KinematicError((sw.Line(2, g * line.amplitude, phi),))
    controller = sw.controllers.AngleFeedforward(PD, wrong, DRIVE.N, IDEAL.lead, DRIVE.motor.J)
    changes = {"sampling": IDEAL, "law": LINEAR.law}
    left = abs(run(controller, speed, **changes)) / abs(run(PD, speed, **changes))
    assert left == pytest.approx(abs(1.0 - g * np.exp(1j * phi)), rel=0.02)


@pytest.mark.slow
def test_a_torque_table_leaves_what_the_wrong_stiffness_makes_of_it():
    """Residual of a measured error against an inverse plant G: |1 - G'/G|, G' of the drive that is 20 % softer."""
    for speed in (15.0, 42.0, 55.0):
        found = sw.compensate(LINEAR, "measured-table", speed=speed, sampling=IDEAL, plant=SOFT, robust=False)
        G, real = (bench_of(train, IDEAL).response(speed).error_of_torque[0] for train in (LINEAR, SOFT))
        expected = abs(1.0 - real / G)
        left = found.amplitude_after[0] / found.amplitude_before[0]
        assert left == pytest.approx(expected, rel=0.02, abs=0.01)


@pytest.mark.slow
def test_a_table_by_a_wrong_model_is_flagged_and_adaptation_recovers():
    table = sw.compensate(LINEAR, "measured-table", speed=42.0, sampling=SAMPLING, plant=SOFT, robust=False)
    assert table.after.rms > 1.2 * table.before.rms
    assert any("do not use the controller there" in text for text in table.warnings)
    nominal = sw.compensate(LINEAR, "measured-table", speed=42.0, sampling=SAMPLING)
    assert any("20 % softer than the model the error grows" in text for text in nominal.warnings)
    adaptive = sw.compensate(LINEAR, "adaptive-inverse", speed=42.0, sampling=SAMPLING, plant=SOFT, robust=False)
    assert adaptive.reduction > 20.0


@pytest.mark.slow
def test_adaptation_converges_with_its_rate():
    """The amplitude's distance from its end decays with g |G|/2."""
    bench, speed = bench_of(LINEAR, IDEAL), 30.0
    G = bench.response(speed).error_of_torque[0]
    rate = 0.6
    adaptive = sw.controllers.AdaptiveCancellation(
        PD, DRIVE.N, 2.0 * rate / abs(G), float(np.angle(G)), 10.0, PERIOD, order=2
    )  # fmt: skip
    own = loop(adaptive, speed, sampling=IDEAL, law=LINEAR.law)
    found = sw.numerics.run_loop(own, 6.0)
    turn = round(2.0 * math.pi / speed / PERIOD)

    def size(t):
        k = round(t / PERIOD)
        part = slice(k, k + turn)
        return abs(2.0 * np.mean(found.error[part] * np.exp(-2j * speed * found.time[part])))

    assert np.log(size(2.0) / size(4.0)) / 2.0 == pytest.approx(rate, rel=0.05)


@pytest.mark.slow
def test_a_wrong_sign_trips_the_guard_and_the_plain_loop_is_left():
    bench = bench_of(LINEAR, IDEAL)
    right = sw.study.COMPENSATORS["adaptive"].build(bench, 50.0)
    wrong = right._replace(phase=right.phase + math.pi, most=0.5)
    own = sw.numerics.run_loop(loop(wrong, sampling=IDEAL, law=LINEAR.law), 12.0)
    plain = sw.numerics.run_loop(loop(PD, sampling=IDEAL, law=LINEAR.law), 12.0)
    assert own.memory.state[3] == 1.0
    assert own.rms(10.0) == pytest.approx(plain.rms(10.0), rel=0.05)


@pytest.mark.slow
def test_repetitive_control_learns_every_order():
    error = sw.KinematicError((sw.Line(2, 23.0 * ARCSEC), sw.Line(4, 5.0 * ARCSEC, 0.7)))
    motor = DRIVE.motor._replace(drag=sw.laws.Coulomb(0.05))  # the machine code of the mirrored drive
    drive = LINEAR._replace(error=error, motor=motor)
    found = sw.compensate(drive, "repetitive", speed=15.0, sampling=SAMPLING, robust=False)
    assert np.all(found.amplitude_after < 0.2 * found.amplitude_before)


@pytest.mark.slow
def test_adaptation_compensates_all_units():
    for speed in (45.0, 50.0):
        units = sw.compensate(DRIVE, "adaptive", speed=speed, sampling=SAMPLING, robust=False, units=60).units
        assert not units.unstable
        assert units.quantiles((0.95,))[0] < 0.1 * np.median(units.before.rms)


@pytest.mark.slow
def test_units_that_are_not_compensated_are_named_with_their_cause():
    right = sw.study.COMPENSATORS["adaptive"].build(bench_of(DRIVE, SAMPLING), 50.0)
    wrong = right._replace(phase=right.phase + math.pi)
    units = sw.compensate(DRIVE, wrong, speed=50.0, sampling=SAMPLING, robust=False, units=20).units
    assert len(units.unstable) > 10
    assert all("degrees off the model's, beyond 90" in cause for _, cause in units.unstable)
    weak = SAMPLING._replace(limit=0.3)
    units = sw.compensate(DRIVE, "inverse", speed=45.0, sampling=weak, robust=False, units=20).units
    assert units.unstable
    assert all("the torque is at its limit of 0.3 N*m" in cause for _, cause in units.unstable)


@pytest.mark.slow
def test_units_are_drawn_as_they_are_said_to_be():
    units = sw.compensate(DRIVE, "inverse", speed=20.0, sampling=SAMPLING, robust=False, units=40).units
    assert np.all(np.abs(units.stiffness - 1.0) <= 0.15)
    assert np.all(np.abs(units.amplitude - 1.0) <= 0.5)
    assert np.ptp(units.before.phase) > 4.0
    few, again = (
        sw.compensate(DRIVE, "inverse", speed=20.0, sampling=SAMPLING, robust=False, units=5).units for _ in range(2)
    )
    np.testing.assert_array_equal(few.after.rms, again.after.rms)


@pytest.mark.slow
def test_a_motor_that_is_too_weak_excludes_the_speed():
    weak = SAMPLING._replace(limit=0.4)
    found = sw.compensate(DRIVE, "inverse", speed=50.0, sampling=weak, robust=False)
    assert "at its limit of 0.4 N*m" in found.excluded
    assert 0.0 < found.torque.limited < 1.0


UNEVEN = ("adaptive-inverse", "predicted-table", "repetitive")  # of each, more machine code


def turning(sign, uneven):
    """A drive without odd symmetry, or its mirror image, which does backward what the drive does forward."""
    lines = (sw.Line(2, 23.0 * ARCSEC, 0.3), sw.Line(3, 6.0 * ARCSEC, 1.0))[: 1 + uneven]
    if sign < 0:  # the error of the mirror image is -e(-theta)
        lines = tuple(line._replace(phase=math.pi - line.phase) for line in lines)
    motor = DRIVE.motor._replace(drag=sw.laws.Coulomb(0.05)) if uneven else DRIVE.motor
    return DRIVE._replace(
        error=sw.KinematicError(lines), motor=motor, load=sw.train.Load(10.0, sw.Harmonic(0.0, mean=sign * 9.0))
    )


@pytest.mark.slow
@pytest.mark.parametrize("name", sw.study.COMPENSATORS)
def test_backward_motion_is_that_of_the_mirrored_drive(name):
    """With friction and a second line too where it is `UNEVEN`; the others run the machine code of `DRIVE`."""
    forward, backward = (
        sw.compensate(turning(sign, name in UNEVEN), name, speed=sign * 40.0, sampling=IDEAL, robust=False)
        for sign in (1, -1)
    )
    assert backward.after.rms == pytest.approx(forward.after.rms, rel=1e-4, abs=1e-4 * forward.before.rms)
    assert backward.before.rms == pytest.approx(forward.before.rms, rel=1e-6)
    assert backward.amplitude_before == pytest.approx(forward.amplitude_before, rel=1e-6)
    assert backward.after.mean == pytest.approx(-forward.after.mean, rel=1e-4, abs=1e-4 * forward.before.rms)
    assert backward.gains == forward.gains


@pytest.mark.slow
def test_the_guard_of_the_motors_adaptation_needs_no_limit_of_the_torque():
    """It is a few times the torque with which the motor keeps its reference: that of the gear over N."""
    design = sw.study.COMPENSATORS["adaptive-motor"]
    found = [design.build(bench_of(LINEAR, IDEAL._replace(limit=limit)), 45.0).most for limit in (1e9, 3.0)]
    assert found[0] == found[1]
    K, B, J, e, w = 1e5, DRIVE.B, 10.0, 23.0 * ARCSEC, 2.0 * 45.0
    u = -e * J * w * w / (J * w * w - K - 1j * B * w)  # twist of the gear on a held motor
    assert found[0] == pytest.approx(5.0 * abs((K + 1j * B * w) * u) / 50.0, rel=0.03)
    good = design.build(bench_of(LINEAR, IDEAL), 45.0)
    wrong = good._replace(phase=good.phase + math.pi)
    given = sw.compensate(LINEAR, wrong, speed=45.0, sampling=IDEAL, robust=False)
    assert any("the guard switched the correction torque off" in text for text in given.warnings)


@pytest.mark.slow
def test_the_worst_of_several_attitudes_is_reported():
    """A gear that stiffens with its torque meets another resonance where gravity twists it."""
    weight = DRIVE._replace(load=sw.train.Load(DRIVE.load.J, drag=sw.train.AngleTorque(60.0)))
    angles = (0.0, 0.5 * math.pi, 1.0)
    alone = {
        a: sw.compensate(weight, "angle", speed=45.0, sampling=SAMPLING, robust=False, load_angles=(a,)) for a in angles
    }
    worst = max(angles, key=lambda a: alone[a].after.rms)
    found = sw.compensate(weight, "angle", speed=45.0, sampling=SAMPLING, robust=False, load_angles=angles)
    assert found.load_angle == worst
    assert found.after == alone[worst].after
    assert any(f"Of 3 load angles that of {math.degrees(worst):.4g} deg is the worst" in text for text in found.remarks)
    row = sw.study.compensation_bench(weight, ["angle"], speeds=[45.0], sampling=SAMPLING, load_angles=angles).results[
        0
    ]
    assert row[0].after == found.after
    assert found.after.rms > 1.1 * min(one.after.rms for one in alone.values())


@pytest.mark.slow
def test_a_table_that_takes_nothing_away_is_said_to_make_no_gain():
    """The inverse of a model whose resonance lies elsewhere leaves as much as there was."""
    shares = {}
    for speed in np.linspace(38.0, 44.0, 13).tolist():
        one = sw.compensate(LINEAR, "measured-table", speed=speed, sampling=SAMPLING, plant=SOFT, robust=False)
        share = shares[speed] = one.after.rms / one.before.rms
        said = " ".join(one.warnings)
        assert ("no benefit" in said) == (0.98 <= share <= 1.02)
        assert ("do not use the controller there" in said) == (share > 1.02)
        assert one.gains == (share < 0.98)
    assert min(shares.values()) < 0.98
    assert max(shares.values()) > 1.02
    assert not sw.compensate(LINEAR, "loop", speed=40.0, sampling=SAMPLING, robust=False).warnings


@pytest.mark.slow
def test_a_drive_with_gravity_hysteresis_and_friction():
    """Not the ideal case: the linear inverse still takes most of it away, and the nonlinear one is refused."""
    law = sw.Parallel(sw.BoucWen(4e4, 0.0, 8e-5), sw.Linear(8e4))
    load = sw.train.Load(10.0, drag=sw.train.AngleTorque(40.0))
    motor = DRIVE.motor._replace(drag=sw.laws.Coulomb(0.05))
    drive = DRIVE._replace(law=law, load=load, motor=motor)
    found = sw.compensate(drive, "inverse", speed=20.0, sampling=SAMPLING, robust=False)
    assert found.amplitude_after[0] < 0.1 * found.amplitude_before[0]
    with pytest.raises(ValueError, match="laws with memory, which have no inverse"):
        sw.compensate(drive, "nonlinear-inverse", speed=20.0, sampling=SAMPLING)


@pytest.mark.slow
@pytest.mark.parametrize(("speed", "beyond"), [(80.0, False), (150.0, True)])
def test_a_correction_beyond_the_bandwidth_of_the_loop_is_said(speed, beyond):
    found = sw.compensate(DRIVE, "angle", speed=speed, sampling=SAMPLING, robust=False)
    assert any("beyond the loop's bandwidth of 30 Hz" in text for text in found.warnings) == beyond


def test_what_was_assumed_is_said():
    text = " ".join(bench_of(DRIVE._replace(motor=DRIVE.motor._replace(control=sw.train.Held()))).remarks)
    assert "every 250 us" in text
    assert "position loop of 30 Hz" in text
    lagged = DRIVE._replace(motor=DRIVE.motor._replace(control=sw.train.Lagged(DRIVE.motor.control, 2e-4)))
    bench = bench_of(lagged, SAMPLING)
    assert bench.sampling == SAMPLING
    assert bench.lead == pytest.approx(SAMPLING.lead + 2e-4)
    cascade = sw.train.Lagged(sw.train.CascadeLoop(20.0, 0.05, 0.05), 2e-4)
    sees_the_load = DRIVE._replace(motor=DRIVE.motor._replace(control=LoadEncoder(cascade)))
    assert bench_of(sees_the_load, SAMPLING, bench.loop).lag == 2e-4


@pytest.mark.parametrize(
    ("call", "error", "sentence"),
    [
        (lambda: sw.compensate(DRIVE, "magic", speed=50.0), ValueError, "no controller 'magic'; there are loop, angle"),
        (lambda: sw.compensate(DRIVE._replace(error=sw.NoError())), ValueError, "nothing to cancel"),
        (lambda: sw.compensate(DRIVE, speed=-5000.0), ValueError, "0.25 ms are too slow for order 2 at"),
        (lambda: sw.compensate(DRIVE, speed=5000.0), ValueError, "0.25 ms are too slow for order 2 at"),
        (lambda: sw.compensate(DRIVE, speed=50.0, units=-1), ValueError, "units is -1"),
        (
            lambda: sw.compensate(DRIVE, speed=5.0, sampling=sw.controllers.Sampling(1e-2, 1e-2)),
            ValueError,
            "plain loop is unstable with samples every 10 ms",
        ),
        (lambda: sw.study.compensation_bench(DRIVE, (), speeds=[1.0]), ValueError, "nothing to simulate"),
    ],
)
def test_what_cannot_be_compensated_gets_a_sentence(call, error, sentence):
    with pytest.raises(error, match=sentence):
        call()


@pytest.mark.slow
def test_the_default_speed_is_that_of_the_resonance_under_the_mean_torque_of_the_load():
    law = DRIVE.law
    loaded = DRIVE._replace(load=DRIVE.load._replace(excitation=sw.Harmonic(0.0, 1, 0.0, -1.2 * law.T2)))
    free, held = (sw.compensate(train, "adaptive", sampling=SAMPLING, robust=False) for train in (DRIVE, loaded))
    assert free.speed == pytest.approx(math.sqrt(law.K1 / 10.0) / 2.0, rel=1e-12)
    assert held.speed == pytest.approx(math.sqrt(law.K3 / 10.0) / 2.0, rel=1e-12)


@pytest.mark.slow
def test_a_controller_that_settles_more_slowly_than_the_loop_is_measured_once_it_has():
    """Measured after the loop's own ten time constants, the observer had 3.8 arcsec in place of 0.5."""
    drive = sw.Drive(2.3077e-4, 2.81189, 100.0, 19.2798, sw.Cubic(125060.0, 3.0224e6))
    control = sw.train.PositionLoop(51.19254, 0.240274)
    error = sw.KinematicError((sw.Line(5, 2.51668e-6, -0.408),))
    train = drive.train(kinematic_error=error, control=control, load_torque=sw.Harmonic(0.0, mean=-27.18))
    sampling = sw.controllers.Sampling(1.25e-4, 6.25e-5, 1e3, 2.0 * np.pi / 2**16, load_quantum=2.0 * np.pi / 2**24)
    found = sw.compensate(train, "observer", speed=62.888, sampling=sampling, robust=False)
    bench = bench_of(train, sampling=sampling)
    late = bench.run(found.controller, 62.888, 25.0)
    error = late.error[late.time > 20.0]
    assert found.after.rms == pytest.approx(np.std(error), rel=0.2)
    assert found.after.rms < 0.6 * ARCSEC


@pytest.mark.slow
@pytest.mark.parametrize("speed", [20.0, 43.0, 80.0])
def test_a_fast_adaptation_has_left_a_tenth_after_ln_10_time_constants(speed):
    """Few turns pass meanwhile: at 43 rad/s the run has no 50 of them."""
    found = sw.compensate(DRIVE, "adaptive", speed=speed, sampling=SAMPLING, robust=False)
    assert found.converged == pytest.approx(math.log(10.0) / found.rate, rel=0.05)
