"""Motions in two turns: equal to an integration of the drive's own equations, and to the balance of one turn.

The response of a project, and its map of speeds, with lines of the output's turn; a line too small to matter changes
neither from those of one turn.
"""

import math
from typing import NamedTuple

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.ndimage import maximum_filter1d, minimum_filter1d
from turns import sizes_of_turns

import strainwave as sw
from strainwave.app.commands.response import facts
from strainwave.app.commands.speed_map import write
from strainwave.drive.steady import is_beating
from strainwave.drive.train_curve import with_rounded_corners
from strainwave.drive.two_turns import beat_said, largest_beat, two_turn_motion, two_turn_response
from strainwave.files.reading import from_text
from strainwave.files.variants.project_sweep import sweep_project
from strainwave.numerics.curves import torus_follow as follow
from strainwave.numerics.curves import torus_growth as growth

N, K, J, ALPHA = 8.0, 2e4, 1.3, 2e5
B = 0.08 * np.sqrt(K * J)
ERROR = sw.KinematicError((sw.Line(2, 1e-4), sw.Line(2 - 2 / N, 8e-5, 0.3)))
GRAVITY = sw.train.AngleTorque(12.0, 1, 0.2)
SETTLING = 4.5  # s
LOOP = (60.0, 0.8)  # of the motor [N*m/rad, N*m*s/rad]
COUPLING = (0.6, 8.0, 6e4, 1e4)  # inertia before it, damping, stiffness, its growth

HELD = sw.DriveTrain(
    sw.train.Motor(1.0, control=sw.train.Held()), N, B, sw.Cubic(K, ALPHA), sw.train.Load(J, drag=GRAVITY), 45.0, ERROR
)
LOOPED = HELD._replace(motor=sw.train.Motor(4e-3, control=sw.train.PositionLoop(*LOOP)))
ALONE = HELD._replace(load=sw.train.Load(J), error=sw.NoError())


def with_coupling(train, law):
    return train._replace(load=sw.train.Elastic(*COUPLING[:2], law, train.load._replace(J=J - COUPLING[0])))


TRAINS = {
    "held, gravity": HELD,
    "loop, gravity": LOOPED,
    "loop, gravity, coupling": with_coupling(LOOPED, sw.Cubic(*COUPLING[2:])),
    "held, linear coupling": with_coupling(HELD._replace(load=sw.train.Load(J)), sw.Linear(COUPLING[2])),
}


def rates_of(train):
    """Equations of motor, gear, coupling and load written out: states x, its rate, motor's deviation, twist."""
    looped, coupled = not train.motor.held, len(train.load.couplings()) > 0
    omega, pull = train.omega, train.load.end().drag
    growth = getattr(train.load.couplings()[0], "alpha", 0.0) if coupled else 0.0
    orders = np.array([line.order for line in train.error.lines])
    sizes = np.array([line.amplitude for line in train.error.lines])
    phases = np.array([line.phase for line in train.error.lines])

    def rates(t, y):
        x, v, *rest = y
        d, w = rest[:2] if looped else (0.0, 0.0)
        angle = orders * (omega * t + d) + phases
        e, slope = sizes @ np.cos(angle), -(sizes * orders) @ np.sin(angle)
        torque = K * (x - e) * (1.0 + ALPHA * (x - e) ** 2) + train.B * (v - slope * (omega + w))
        fast = (-(1.0 / N - slope) * torque - LOOP[0] * d - LOOP[1] * w) / train.motor.J if looped else 0.0
        twist, speed = rest[-2:] if coupled else (0.0, 0.0)
        against = pull.amplitude * np.sin((omega * t + d) / N - x - twist + pull.phase) if pull == GRAVITY else 0.0
        if not coupled:
            return [v, fast / N - (torque - against) / J, *([w, fast] if looped else [])]
        passed = COUPLING[2] * twist * (1.0 + growth * twist**2) + COUPLING[1] * speed
        here, there = (torque - passed) / COUPLING[0], (passed - against) / (J - COUPLING[0])
        return [v, fast / N - here, *([w, fast] if looped else []), speed, here - there]

    return rates


@pytest.mark.parametrize("train", TRAINS.values(), ids=TRAINS.keys())
def test_a_motion_of_two_turns_is_the_settled_one_of_the_drives_equations(train):
    motion = two_turn_motion(train, train.omega)
    places, turns = 2048, int(N)
    t = 2.0 * np.pi / train.omega * np.arange(places * (turns + 1) + 1) / places
    count = len(train.state_names())
    start = np.zeros(count)
    run = solve_ivp(rates_of(train), (-SETTLING, t[-1]), start, "DOP853", t_eval=t, rtol=1e-8, atol=1e-12).y
    error = run[0] + (run[-2] if train.load.couplings() else 0.0) - (0.0 if train.motor.held else run[2] / N)
    size = np.max(np.abs(error))
    there = motion.states(0, train.omega * t)[0]
    np.testing.assert_allclose(there / size, error / size, rtol=0, atol=1e-6)
    sizes = sizes_of_turns(error, places)
    assert motion.largest[0] == pytest.approx(np.max(sizes), rel=2e-5)
    assert motion.smallest[0] == pytest.approx(np.min(sizes), rel=2e-3)  # by samples: a crest leaves a turn steeply
    assert motion.stable[0]


def test_envelopes_are_those_of_turns_from_any_angle():
    motion, places = two_turn_motion(LOOPED, LOOPED.omega), 4_000
    theta = 2.0 * np.pi / places * np.arange(places * (int(N) + 1) + 1)
    sizes = sizes_of_turns(motion.states(0, theta)[0], places)[:-1].reshape(int(N), places)
    np.testing.assert_allclose(motion.oscillations[0, :, 0], np.max(sizes, axis=1), rtol=1e-3)
    assert motion.largest[0] == pytest.approx(np.max(sizes), rel=1e-5)
    np.testing.assert_allclose(motion.oscillations[0, :, 1], np.min(sizes, axis=1), rtol=2e-3)
    assert np.max(sizes[:, 0]) < 0.95 * motion.largest[0]  # turns from angle 0 alone miss the largest


@pytest.mark.parametrize("name", ["held, gravity", "held, linear coupling", "loop, gravity"])
def test_the_largest_turns_of_a_curve_are_those_of_dense_samples(name):
    curve, places = two_turn_response(TRAINS[name], (40.0, 90.0)), 8192
    order = np.rint(curve.pairs @ np.array([N, 1.0])).astype(int)  # waves in a turn of the output
    for waves, largest in zip(curve.waves, curve.largest, strict=True):
        spectra = np.zeros((2, int(N) * places), complex)
        np.add.at(spectra, (slice(None), order), [waves, waves * np.sinc(order / N)])
        error, means = np.fft.ifft(spectra, norm="forward").real  # and that of the turn around each sample
        low, high = (size(means, places + 1, mode="wrap") for size in (minimum_filter1d, maximum_filter1d))
        assert largest == pytest.approx(max(np.max(error - low), np.max(high - error)), rel=1e-6)
    np.testing.assert_allclose(curve.smallest, curve.oscillations[..., 1].min(axis=1), rtol=1e-12)


def test_envelopes_of_a_ratio_that_no_few_turns_hold_are_those_of_many_turns():
    ratio = 7.123  # motor and output stand as before after 7123 turns
    error = sw.KinematicError((sw.Line(2, 1e-4), sw.Line(2 - 2 / ratio, 8e-5, 0.3)))
    motion = two_turn_motion(HELD._replace(N=ratio, error=error), HELD.omega)
    assert motion.oscillations.shape[1] <= 1000
    sizes = sizes_of_turns(motion.states(0, 2.0 * np.pi / 600 * np.arange(300 * 600 + 1))[0], 600)
    np.testing.assert_allclose([motion.largest[0], motion.smallest[0]], [sizes.max(), sizes.min()], rtol=5e-3)


def test_a_crest_tells_the_oscillation_of_a_drive_with_another_loop_at_its_speed():
    crest, stiffer = largest_beat(LOOPED, (40.0, 90.0)), sw.train.PositionLoop(1.2 * LOOP[0], LOOP[1])
    assert crest.size_of(LOOPED) == pytest.approx(crest.size, rel=1e-9)
    other = LOOPED._replace(motor=LOOPED.motor._replace(control=stiffer))
    exact = two_turn_motion(other, crest.speed).largest[0]
    assert crest.size_of(other) == pytest.approx(exact, rel=1e-3)
    assert abs(exact / crest.size - 1.0) > 0.01


def test_the_part_that_repeats_with_every_turn_is_that_of_the_spectrum():
    motion = two_turn_motion(HELD, HELD.omega)
    assert motion.amplitude(2, 8)[0] > 1e-4 * motion.largest[0]
    turns, places = int(N), 128
    error = motion.states(0, 2.0 * np.pi * np.arange(turns * places) / places)[0]
    whole = (np.fft.rfft(error) / len(error))[::turns]
    found = motion.branch((40.0, 50.0)).coefficients[0]
    highest, size = len(found) // 2, np.max(np.abs(error))
    expected = np.column_stack([2.0 * whole.real, -2.0 * whole.imag])[1 : highest + 1].ravel()
    np.testing.assert_allclose(found, [whole[0].real, *expected], rtol=0, atol=1e-9 * size)


def test_disturbances_grow_as_by_the_drives_equations():
    short = HELD._replace(B=0.1 * B)  # its disturbances last
    motion = two_turn_motion(short, short.omega)
    assert motion.growth[0] == pytest.approx(marched_growth(short, motion, 0), rel=1e-4)


def test_disturbances_beside_folds_grow_as_by_the_drives_equations():
    error = sw.KinematicError((sw.Line(2, 1e-4), sw.Line(2 - 2 / N, 1e-5, 0.3)))
    weak = HELD._replace(B=0.25 * B, load=sw.train.Load(J), error=error)
    curve = two_turn_response(weak, (60.0, 90.0))
    upper, lower = (int(np.flatnonzero(curve.omega == fold)[0]) for fold in curve.folds[:2])
    for i in (upper + 2, lower - 2):
        grown = marched_growth(weak._replace(omega=float(curve.omega[i])), curve, i)
        assert curve.growth[i] == pytest.approx(grown, rel=1e-3)
        assert not curve.stable[i]


def marched_growth(train, curve, number):
    """Rate [1/s] of the disturbances that last longest, over a turn of the output from a motion of a curve."""
    period, start = 2.0 * np.pi * N / train.omega, curve.states(number, np.zeros(1))[:, 0]
    columns = []
    for step in np.diag((1e-8, 1e-8 * train.omega)):
        ends = [
            solve_ivp(rates_of(train), (0.0, period), y, "DOP853", rtol=1e-11, atol=1e-16).y[:, -1]
            for y in (start + step, start - step)
        ]
        columns.append((ends[0] - ends[1]) / (2.0 * np.sum(step)))
    return np.log(np.max(np.abs(np.linalg.eigvals(np.array(columns).T)))) / period


def test_growth_over_many_turns_is_found_in_parts_of_few(monkeypatch):
    uneven = N + 0.03  # 803 turns until motor and output stand as before
    error = sw.KinematicError((ERROR.lines[0], ERROR.lines[1]._replace(order=2 - 2 / uneven)))
    motion = two_turn_motion(HELD._replace(N=uneven, error=error), HELD.omega)
    whole = motion.growth
    monkeypatch.setattr(growth, "ENTRIES", 400)  # of 100 turns at a time
    parts = growth.growth(motion.problem, motion.flow, motion.points)
    np.testing.assert_allclose(parts, whole, rtol=1e-9)


def test_a_curve_of_as_many_waves_as_it_may_have_takes_no_more_than_its_motions_need(monkeypatch):
    ratio = 20.0
    error = sw.KinematicError((ERROR.lines[0], ERROR.lines[1]._replace(order=2 - 2 / ratio)))
    train = HELD._replace(N=ratio, error=error)
    free = two_turn_response(train, (60.0, 90.0))
    monkeypatch.setattr(follow, "ALONG", 132)  # fewer than the waves that estimates ask for
    curve = two_turn_response(train, (60.0, 90.0))
    assert len(free.pairs) > len(curve.pairs)
    assert curve.message == "reached both ends"
    assert curve.largest.max() == pytest.approx(free.largest.max(), rel=1e-3)


def test_a_linear_drive_answers_every_wave_by_itself():
    train = HELD._replace(law=sw.Linear(K), load=sw.train.Load(J))
    motion = two_turn_motion(train, 50.0)
    for line, pair in zip(ERROR.lines, ((2, 0), (2, -2)), strict=True):
        w = line.order * 50.0
        gear = K + 1j * w * B
        assert motion.amplitude(*pair)[0] == pytest.approx(line.amplitude * abs(gear / (gear - J * w * w)), rel=1e-9)
    assert motion.beat[0] == pytest.approx(2.0 * np.pi * N / (2.0 * 50.0), rel=1e-14)


def test_one_turn_alone_has_the_folds_and_the_stability_of_its_response():
    system = sw.Oscillator(J, 0.25 * B, sw.Cubic(K, 2e4), sw.Harmonic(0.0), 1.0, sw.KinematicError((ERROR.lines[0],)))
    span = (55.0, 85.0)
    exact, found = sw.frequency_response(system, span), two_turn_response(system, span, ratio=N)
    assert len(exact.folds) == 2
    assert found.status
    np.testing.assert_allclose(sorted(found.folds), sorted(fold.omega for fold in exact.folds), rtol=1e-5)
    ends = [int(np.argmin(np.abs(found.omega - fold))) for fold in found.folds]
    inside = np.zeros(len(found.omega), bool)
    inside[min(ends) + 1 : max(ends)] = True
    clear = np.abs(np.arange(len(inside))[:, None] - ends).min(axis=1) > 1
    assert np.array_equal(found.stable[clear], ~inside[clear])
    np.testing.assert_allclose(found.largest, found.smallest, rtol=1e-9)


@pytest.mark.parametrize(
    ("system", "options", "sentence"),
    [
        (HELD._replace(law=sw.Backlash(K, 1e-4)), {}, "this torsion law has corners: integrate the drive with"),
        (
            HELD._replace(law=sw.Parallel(sw.Linear(K), sw.laws.Coulomb(1.0, 0.1))),
            {},
            "friction, hysteresis or a nonlinear",
        ),
        (HELD._replace(N=7.3), {}, r"line 1 of the kinematic error: the order 1\.75 is no whole number"),
        (
            HELD._replace(N=1.01, error=sw.KinematicError((sw.Line(2, 1e-4), sw.Line(2 - 2 / 1.01, 8e-5)))),
            {},
            "line 1 of the kinematic error: the ratio is 1.01: motor and output turn nearly alike, so that the order "
            "0.019802 beats with neither turn",
        ),
        (
            sw.Oscillator(J, B, sw.Linear(K), sw.Harmonic(1.0), 1.0),
            {},
            "is neither a DriveTrain nor an Oscillator with a",
        ),
        (ALONE, {}, "no periodic excitation; give an error order"),
        (ALONE, {"omega": 0.0}, r"omega \[rad/s\] is 0\.0; it must be a positive"),
        (ALONE, {"omega": -45.0}, r"omega \[rad/s\] is -45\.0; it must be a positive"),
        (ALONE, {"omega": np.nan}, r"omega \[rad/s\] is nan; it must be a positive"),
        (ALONE, {"omega": (90.0, 40.0)}, r"speeds \[rad/s\] is \(90\.0, 40\.0\); it must be two finite numbers"),
        *(
            (
                sw.Oscillator(J, B, sw.Linear(K), sw.Harmonic(1.0), 1.0),
                {"ratio": ratio},
                f"ratio is {ratio}; it must be a",
            )
            for ratio in (0.0, -8.0, np.nan)
        ),
    ],
)
def test_what_is_not_balanced_in_two_turns_is_refused_in_one_sentence(system, options, sentence):
    verb = two_turn_response if isinstance(options.get("omega"), tuple) else two_turn_motion
    rest = {"ratio": options["ratio"]} if "ratio" in options else {}
    with pytest.raises((ValueError, TypeError), match=sentence) as refusal:
        verb(system, options.get("omega", 70.0), **rest)
    assert "\n" not in str(refusal.value)


PROJECT = """\
title: joint
gear: {ratio: 50, law: {type: cubic, K: 2e4 N*m/rad, alpha: 4e5 1/rad^2}}
motor: {inertia: 1 kg*cm^2, MOTOR}
load: {inertia: 1 kg*m^2}
damping: {B: 15 N*m*s/rad}
speed: {from: 300 rpm, to: 1200 rpm, shaft: motor}
excitation:
  kinematic_error:
    - {order: 2, amplitude: 20 arcsec}
    - {order: ORDER, amplitude: SIZE, phase: 40 deg}
  load_torque: {mean: -4 N*m}
limit: {oscillation: 120 arcsec}
"""


def joint(path, order="{wave_generator: 2, output: 2}", size="6 arcsec", motor="mode: held", ratio="50", more=""):
    text = PROJECT.replace("ORDER", order).replace("SIZE", size).replace("MOTOR", motor)
    text = text.replace("ratio: 50", f"ratio: {ratio}").replace("limit:", f"{more}limit:")
    return from_text(text, path / "joint.yaml")


@pytest.mark.parametrize("motor", ["mode: held", "loop: {bandwidth: 30 Hz, damping: 0.7}"])
def test_a_line_too_small_to_matter_changes_no_response(motor, tmp_path):
    alone = joint(tmp_path, "4", "0 arcsec", motor).response(coexisting=False)
    found = joint(tmp_path, size="1e-7 arcsec", motor=motor).response()
    assert alone.curve.envelope is None
    np.testing.assert_allclose(
        sorted(fold.omega for fold in found.folds), sorted(fold.omega for fold in alone.folds), rtol=1e-6
    )
    sizes = {"torque": 1e-5, "across": 1e-5, "motor_torque": 1e-5}
    for name in ("oscillation", "peak", *sizes, "mean_torque", "motor_mean", "motor_rms"):
        one, two = getattr(alone, name), getattr(found, name)
        np.testing.assert_allclose(two[[-1, 0]], one[[0, -1]], rtol=sizes.get(name, 1e-6), err_msg=name)
        assert np.max(two) == pytest.approx(np.max(one), rel=5e-3), name  # their points on a crest are others
    np.testing.assert_allclose(*found.curve.envelope.T, rtol=1e-6)


def test_a_pair_of_one_turn_alone_is_its_whole_order(tmp_path):
    one, pair = (joint(tmp_path, order) for order in ("4", "{wave_generator: 4, output: 0}"))
    assert not is_beating(pair.subject.error)
    assert np.array_equal(one.response(coexisting=False).oscillation, pair.response(coexisting=False).oscillation)


def test_the_response_and_the_map_of_a_beat_are_judged_by_its_largest_turn(tmp_path):
    project = joint(tmp_path)
    found = project.response()
    answers = facts(project, found)
    told = {fact.key: fact.value for fact in answers}
    assert told["left_out_relative"] == 1e-4
    assert found.message == "reached both ends; other periodic motions are not searched"
    assert told["beat.turns"] == found.curve.beat == 25.0
    assert not told["passes"]
    most = float(found.omega[found.top])
    slow = two_turn_motion(project.whole, found.omega[-1])
    np.testing.assert_allclose(found.curve.envelope[-1], [slow.largest[0], slow.smallest[0]], rtol=1e-4)
    mapped = sw.speed_map(project, search=False)
    assert mapped.smallest[0, 0] == pytest.approx(slow.smallest[0], rel=1e-4)
    assert np.all(mapped.smallest < mapped.oscillation)
    write(mapped, tmp_path / "map")
    cells = np.genfromtxt(tmp_path / "map" / "cells.csv", delimiter=",", names=True)
    np.testing.assert_allclose(cells["smallest_oscillation_rad"], mapped.smallest[0], rtol=1e-6)
    assert {line.order for line in mapped.lines if line.excited} == {2, 2 + 2 / 50}
    # 25 turns of 300 rpm, and of 1200 rpm
    assert any("beats every 25 turns of the motor, 5 s at 300 rpm and 1.25 s at 1200 rpm" in r for r in mapped.remarks)
    with pytest.raises(ValueError, match="points is -3; it must be a whole number of at least 1"):
        project.response(points=-3)
    ((low, high),) = mapped.forbidden[0]
    edge = two_turn_motion(project.whole, low)
    assert edge.largest[0] == pytest.approx(project.limit, rel=1e-4)
    assert low < most < high


def test_slow_rotation_oscillates_as_the_largest_turn_of_a_slow_motion(tmp_path):
    more = "    - {order: {output: 1}, amplitude: 40 arcsec}\n  load_torque: {mean: -4 N*m}\n"
    text = PROJECT.replace("  load_torque: {mean: -4 N*m}\n", more).replace("MOTOR", "mode: held").replace("120", "60")
    text = text.replace("ORDER", "{wave_generator: 2, output: 2}").replace("SIZE", "6 arcsec").replace("1200", "330")
    project = from_text(text, tmp_path / "joint.yaml")
    mapped = sw.speed_map(project, search=False)
    assert mapped.quasi_static[0] == pytest.approx(two_turn_motion(project.whole, 1.0).largest[0], rel=1e-3)
    assert any(remark.endswith("a resonance in this speed range: 1/50, 2, 2 + 2/50") for remark in mapped.remarks)
    assert not any("quasi-static" in remark for remark in mapped.remarks)  # 66 arcsec, but not in any turn


def test_a_sweep_has_the_smallest_turn_beside_the_largest(tmp_path):
    size = "excitation.kinematic_error.1.amplitude"
    swept, project = sweep_project(joint(tmp_path), {size: ["0 arcsec", "6 arcsec"]}), joint(tmp_path)
    found = project.response()
    assert float(swept["oscillation"][1]) == found.oscillation[found.top]
    assert float(swept["smallest"][1]) == found.curve.envelope[found.top, 1]
    assert float(swept["smallest"][0]) == pytest.approx(float(swept["oscillation"][0]), rel=1e-5)
    assert "smallest" not in sweep_project(joint(tmp_path, "4"), {size: ["6 arcsec"]})


def test_means_are_those_of_all_turns_after_which_motions_repeat(tmp_path):
    project = joint(tmp_path, size="15 arcsec", ratio="51, fixed: flexspline")
    found = project.response()
    assert found.curve.beat == 25.5
    motion, law = two_turn_motion(project.whole, found.omega[0]), project.drive.law
    theta = 2.0 * np.pi * np.arange(51 * 200) / 200
    x, v = motion.states(0, theta)[:2]
    error = project.kinematic_error
    torque = law.torque(x - error.value(theta)) + project.drive.B * (v - motion.omega[0] * error.slope(theta))
    assert found.mean_torque[0] == pytest.approx(np.mean(np.abs(torque) ** 3) ** (1 / 3), rel=1e-4)
    assert found.motor_mean[0] == pytest.approx(np.mean((1 / 51 - error.slope(theta)) * torque), rel=1e-6)


def test_harmonics_are_refused_where_motions_beat(tmp_path):
    project = joint(tmp_path)
    for count in (-3, 9):
        with pytest.raises(ValueError, match=f"harmonics is {count}, but waves of beating motions are chosen"):
            project.response(count)


def test_a_map_of_a_free_motor_has_the_motions_of_its_train(tmp_path):
    project = joint(tmp_path, motor="mode: free", more="  motor_torque: {mean: 0.08 N*m}\n")
    mapped = sw.speed_map(project, speeds=(162.0, 164.0), load_inertias=[1.0, 4.0], search=False)
    motion = two_turn_motion(project.whole, mapped.speeds[-1])
    assert motion.stable[0]
    assert mapped.oscillation[0, -1] == pytest.approx(motion.largest[0], rel=1e-3)
    # above its resonance a torque that grows slows a free motor down (Sommerfeld's effect)
    assert "no stable steady motion is known with a load inertia of 4" in mapped.remarks
    heavy = project.with_load_inertia(4.0)
    with pytest.raises(
        sw.SolveError, match="no steady motion of this drive is stable in this range; drive_run computes"
    ):
        sw.speed_map(heavy, speeds=(162.0, 164.0), search=False)


PULLED = "load: {inertia: 1 kg*m^2, drag: {type: angle_torque, amplitude: PULL N*m, order: 1}}"


def under_gravity(path, pull, motor="mode: held", to="1200 rpm"):
    text = PROJECT.replace("ORDER", "{wave_generator: 2, output: 2}").replace("SIZE", "6 arcsec")
    text = text.replace("load: {inertia: 1 kg*m^2}", PULLED.replace("PULL", f"{pull}"))
    return from_text(text.replace("MOTOR", motor).replace("1200 rpm", to), path / "joint.yaml")


@pytest.mark.slow
@pytest.mark.parametrize(("inertia", "omega", "pull", "stable"), [
    (1.0, 32.5, 0.0, True), (1.0, 163.0, 0.0, True), (4.0, 163.0, 0.0, False), (1.0, 200.0, 0.3, False),
    (1.0, 300.0, 0.0, False), (4.0, 300.0, 0.0, False), (1.0, 400.0, 0.0, True),
])  # fmt: skip
def test_the_speed_of_a_free_motor_is_as_stable_as_by_its_equations(inertia, omega, pull, stable, tmp_path):
    project = under_gravity(tmp_path, pull, "mode: free") if pull else joint(tmp_path, motor="mode: free")
    train = project.with_load_inertia(inertia).whole
    motion = two_turn_motion(train, omega)
    orders, sizes, phases = np.array([(line.order, line.amplitude, line.phase) for line in train.error.lines]).T
    spring, damping = train.law, train.B

    def in_gear(x, v, angle, speed):
        a = np.multiply.outer(angle, orders) + phases
        slope = -np.sin(a) @ (sizes * orders)
        u = x - np.cos(a) @ sizes
        return slope, spring.K * (u + spring.alpha * u**3) + damping * (v - slope * speed)

    theta = 2.0 * np.pi / 256 * np.arange(256 * 50)
    x, v, d, w = motion.states(0, theta)
    slope, torque = in_gear(x, v, theta + d, omega + w)
    drive = np.mean((1.0 / 50.0 - slope) * torque)  # torque of the motor that keeps the mean speed

    def rates(angle, y):  # by the motor's own angle: that a motion may begin at any time is no disturbance
        x, v, speed = y.reshape(3, 6)
        slope, torque = in_gear(x, v, angle, speed)
        fast = (drive - (1.0 / 50.0 - slope) * torque) / train.motor.J
        against = 4.0 + pull * np.sin(angle / 50.0 - x)
        return np.ravel(np.array([v, fast / 50.0 - (torque - against) / inertia, fast]) / speed)

    turns = 50.0 if pull else 25.0
    first, steps = d[0], np.array([1e-7, 1e-5, 1e-4])
    starts = np.array([[x[0]], [v[0]], [omega + w[0]]]) + np.hstack([np.diag(steps), -np.diag(steps)])
    span = (first, first + 2.0 * np.pi * turns)
    ends = solve_ivp(rates, span, starts.ravel(), "DOP853", rtol=1e-12, atol=1e-14).y[:, -1].reshape(3, 6)
    largest = np.max(np.abs(np.linalg.eigvals((ends[:, :3] - ends[:, 3:]) / (2.0 * steps))))
    grown = np.log(largest) * omega / (2.0 * np.pi * turns)
    assert motion.growth[0] == pytest.approx(grown, rel=1e-4, abs=1e-7)
    assert motion.stable[0] == (grown < 0.0) == stable


@pytest.mark.parametrize("order", ["{wave_generator: 2, output: 2}", "4"])
def test_the_whole_torque_of_a_free_motor_keeps_its_speed_by_its_equations(order, tmp_path):
    drags = "drag: {type: viscous, B: 3 mN*m*s/rad}, mode: free", "drag: {type: viscous, B: 2 N*m*s/rad}"
    text = PROJECT.replace("ORDER", order).replace("SIZE", "15 arcsec").replace("MOTOR", drags[0])
    text = text.replace("load: {inertia: 1 kg*m^2}", f"load: {{inertia: 1 kg*m^2, {drags[1]}}}")
    project = from_text(text, tmp_path / "joint.yaml")
    found, train = project.response(), project.whole
    at = int(np.argmin(np.abs(found.omega - 60.0)))
    omega, given = float(found.omega[at]), float(found.motor_mean[at])
    orders, sizes, phases = np.array([(line.order, line.amplitude, line.phase) for line in train.error.lines]).T

    def rates(_, y):
        x, v, angle, speed = y
        a = angle * orders + phases
        slope, u = -np.sin(a) @ (sizes * orders), x - np.cos(a) @ sizes
        torque = train.law.K * (u + train.law.alpha * u**3) + train.B * (v - slope * speed)
        fast = (given - 3e-3 * speed - (1.0 / 50.0 - slope) * torque) / train.motor.J
        slow = (torque - 4.0 - 2.0 * (speed / 50.0 - v)) / 1.0
        return [v, fast / 50.0 - slow, speed, fast]

    turn = 2.0 * np.pi / omega
    t = turn * np.array([25.0, 50.0])  # it settles within 0.14 s
    angle = solve_ivp(rates, (0.0, t[-1]), [4.0 / train.law.K, 0.0, 0.0, omega], "DOP853", t, rtol=1e-10, atol=1e-13).y[
        2
    ]
    assert np.diff(angle)[0] / np.diff(t)[0] == pytest.approx(omega, rel=1e-4)
    assert found.motor_torque[at] == pytest.approx(given, rel=1e-9)  # constant
    assert found.motor.holding >= given > 0.26


@pytest.mark.slow
@pytest.mark.parametrize(("motor", "damping", "said"), [
    ("held", "0", "this drive has no damping, and its beating motions never settle"),
    ("free", "0", "this drive has no damping, and its beating motions never settle"),
    ("free", "1e-9", "the curve of motions of two turns winds at .* rad/s; give the drive more damping"),
])  # fmt: skip
def test_a_drive_that_nothing_damps_ends_in_a_sentence(motor, damping, said, tmp_path):
    text = PROJECT.replace("ORDER", "{wave_generator: 2, output: 2}").replace("SIZE", "6 arcsec")
    text = text.replace("MOTOR", f"mode: {motor}").replace("B: 15", f"B: {damping}")
    text = text.replace("type: cubic, K: 2e4 N*m/rad, alpha: 4e5 1/rad^2", "type: linear, K: 2e4 N*m/rad")
    text = text.replace("from: 300 rpm, to: 1200 rpm", "from: 740 rpm, to: 775 rpm")
    project = from_text(text, tmp_path / "joint.yaml")
    with pytest.raises(sw.SolveError, match=said):
        project.response()


def test_gravity_beats_with_the_lines_of_a_response_and_of_a_map(tmp_path):
    project = under_gravity(tmp_path, 30, to="500 rpm")
    found = project.response()
    assert found.curve.beat == 50.0
    assert not found.without_angle
    assert project.other_loads == (-4.0, -4.0) != project.load_torques
    # the torque of gravity is in the gear's, beside that of the load
    assert found.torque[-1] > 30.0
    for asked in ({}, {"load_inertias": [1.0]}, {"loads": [-4.0]}):
        mapped = sw.speed_map(project, speeds=(44.0, 45.0), search=False, **asked)
        motion = two_turn_motion(project.whole, mapped.speeds[-1])
        assert mapped.oscillation.shape[0] == 1
        assert mapped.oscillation[0, -1] == pytest.approx(motion.largest[0], rel=2e-3)  # waves that a curve leaves out


def test_a_free_motor_that_does_not_lift_its_load_is_told_so(tmp_path):
    project = under_gravity(tmp_path, 6, "mode: free")
    said = r"in every output turn: lifting the load requires 12 J, and the kinetic energy is 3\.95 J at 125\.66"
    for ask in (project.response, project.analyze, lambda: two_turn_motion(project.whole, 40.0 * np.pi)):
        with pytest.raises(sw.SolveError, match=said):
            ask()


def test_what_follows_no_beat_says_so(tmp_path):
    ripples = "stiffness: {ripples: [{order: 2, depth: 5 %}]}"
    text = PROJECT.replace("ORDER", "{wave_generator: 2, output: 2}").replace("SIZE", "6 arcsec")
    varying = from_text(f"{text.replace('MOTOR', 'mode: held')}{ripples}\n", tmp_path / "joint.yaml")
    for ask in (varying.response, varying.analyze, lambda: sw.speed_map(varying)):
        with pytest.raises(
            ValueError, match="an error order of the output turn together with varying damping or stiff"
        ):
            ask()


class Own(NamedTuple):
    """A law with a corner that knows its rounded form."""

    K: float

    def torque(self, x):
        return self.K * (x + abs(x))

    def rounded(self):
        return sw.Linear(self.K)


class Steeper(sw.PiecewiseLinear):
    """Another law than the one whose methods it inherits."""

    def torque(self, x):
        return 2.0 * self.K1 * x


def test_a_law_rounds_its_corners_itself():
    assert with_rounded_corners(HELD._replace(law=Own(3.0))).law == sw.Linear(3.0)
    for law in (Steeper(1.0, 2.0, 3.0, 1.0, 2.0), sw.Linear(K), sw.laws.RoundedPiecewiseLinear(1, 2, 3, 1, 2, 0.1)):
        train = HELD._replace(law=law)
        assert with_rounded_corners(train) is train


def test_the_corners_of_a_catalogue_gear_are_rounded_and_said(tmp_path):
    text = PROJECT.replace("{ratio: 50, law: {type: cubic, K: 2e4 N*m/rad, alpha: 4e5 1/rad^2}}", "CSG-40-50")
    text = text.replace("B: 15 N*m*s/rad", "ratio: 2 %").replace("MOTOR", "mode: held").replace("1200", "2400")
    text = (
        text.replace("1 kg*cm^2", "5 kg*cm^2")
        .replace("-4 N*m", "-50 N*m")
        .replace("inertia: 1 kg*m^2", "inertia: 1.3 kg*m^2")
    )
    alone = from_text(text.replace("ORDER", "4").replace("SIZE", "0 arcsec"), tmp_path / "joint.yaml")
    beat = from_text(
        text.replace("ORDER", "{wave_generator: 2, output: 2}").replace("SIZE", "1e-7 arcsec"), tmp_path / "joint.yaml"
    )
    one, two = alone.response(coexisting=False), beat.response()
    assert two.rounding.startswith("the corners of the torsion law are rounded over ")
    assert two.message.endswith(f"not searched; {two.rounding}")
    assert two.rounding in sw.speed_map(beat, speeds=(40.0, 45.0), search=False).remarks
    folds = [[fold.omega for fold in found.folds] for found in (one, two)]
    np.testing.assert_allclose([min(folds[1]), max(folds[1])], [min(folds[0]), max(folds[0])], rtol=1e-3)
    assert np.max(two.oscillation) == pytest.approx(np.max(one.oscillation), rel=2e-3)


def test_a_catalogue_gear_under_gravity_swings_as_by_its_true_corners(tmp_path):
    """Motor held, load that hangs: an integration by SciPy with straight lines between the corners."""
    text = PROJECT.replace("{ratio: 50, law: {type: cubic, K: 2e4 N*m/rad, alpha: 4e5 1/rad^2}}", "SHG-25-80")
    text = text.replace("load: {inertia: 1 kg*m^2}", PULLED.replace("PULL", "25")).replace("B: 15", "B: 14")
    text = text.replace("-4 N*m", "0 N*m").replace("300 rpm", "LOW rpm").replace("1200 rpm", "HIGH rpm")
    text = text.replace("20 arcsec", "14 arcsec").replace("ORDER", "{wave_generator: 2, output: 2}")
    text = text.replace("LOW", "880").replace("HIGH", "900").replace("SIZE", "8 arcsec").replace("MOTOR", "mode: held")
    project = from_text(text, tmp_path / "joint.yaml")
    found, train = project.response(), project.whole
    law, omega, ratio, places = train.law, float(found.omega[-1]), 80, 256
    orders, sizes, phases = np.array([(line.order, line.amplitude, line.phase) for line in train.error.lines]).T

    def rates(t, y):
        a = orders * omega * t + phases
        x, v = y
        u, rate = x - sizes @ np.cos(a), v + omega * (sizes * orders) @ np.sin(a)
        over = [max(abs(u) - corner, 0.0) for corner in (law.T1 / law.K1, law.T1 / law.K1 + (law.T2 - law.T1) / law.K2)]
        torque = law.K1 * abs(u) + (law.K2 - law.K1) * over[0] + (law.K3 - law.K2) * over[1]
        return [v, 25.0 * np.sin(omega * t / ratio - x) - math.copysign(torque, u) - 14.0 * rate]

    turn = 2.0 * np.pi / omega
    t = turn * np.arange(places * (ratio + 1) + 1) / places
    run = solve_ivp(rates, (-10.0 * turn, t[-1]), [0.0, 0.0], "LSODA", t, rtol=1e-7, atol=1e-11).y[0]
    exact = np.max(sizes_of_turns(run, places))
    assert found.oscillation[-1] == pytest.approx(exact, rel=5e-3)


def test_the_words_of_a_project_name_its_loop_once(tmp_path):
    said = str(under_gravity(tmp_path, 6, "loop: {bandwidth: 30 Hz, damping: 0.7}"))
    assert "motor: position loop of 30 Hz, damping 0.7, with the gravity of the load" in " ".join(said.split())
    assert "held" not in said
    assert "motor: held\n" in str(joint(tmp_path))


def test_a_line_without_amplitude_beats_with_nothing():
    silent = HELD._replace(error=sw.KinematicError((*ERROR.lines, sw.Line(2.37, 0.0))))
    assert beat_said(silent) == beat_said(HELD)
    assert two_turn_motion(silent, 45.0).largest == two_turn_motion(HELD, 45.0).largest
