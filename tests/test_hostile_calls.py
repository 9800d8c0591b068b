# ruff: noqa: E501
"""Wrong values as arguments of public verbs, and options of commands that make no sense: each answer is a sentence."""

from pathlib import Path

import numpy as np
import pytest
from all_results import CLOSED, DUFFING, LOOPED, order_scan
from hostile_commands import OWN, PROJECT, TIMES, TURN, VALID, answer_of, fault, hostile_command, table, valid_command

import strainwave as sw
from strainwave.app.commands.cli import cli
from strainwave.base.quantities import array_of, numbers
from strainwave.files.reading import from_text
from strainwave.numerics.ensemble import ensemble

C = sw.controllers
SLOW = ("exceedance", "compare", "demo", "derive", "reproduce")
LONG, WAVES = "x" * 5000, np.cos(20.0 * TIMES)
GEAR, TRAIN, N, PD = sw.catalogue.gear("CSG-40-50"), CLOSED.train, CLOSED.train.N, CLOSED.controller
LIGHT = DUFFING._replace(excitation=sw.Harmonic(0.0))
STRONG = sw.Oscillator(1.0, 0.05, sw.Cubic(1.0, 0.1), sw.Harmonic(0.5), 1.2)
FORCED = sw.Oscillator(1.0, 0.12, sw.Linear(1.1), sw.Harmonic(0.0), 1.0)
LOUD = CLOSED._replace(train=TRAIN.with_motor(excitation=sw.Harmonic(0.0, mean=1e60)))
SPRING, TWISTS = sw.PiecewiseLinear(3e4, 5e4, 6e4, 14.0, 48.0), 2e-3 * np.sin(np.linspace(0.0, 4.0 * np.pi, 120))
LOOSE = CLOSED._replace(train=TRAIN.with_motor(J=1e-59))
STIFF = CLOSED._replace(train=TRAIN._replace(load=sw.train.Load(0.05, drag=sw.Linear(1e12))))
SHORT = sw.Trapezoid(0.01, 0.002)
STEEP = np.column_stack([np.linspace(0.9, 1.1, 33), 1e60 ** (np.arange(33) == 16)])
LOG = {"time": TIMES, "motor_angle": 10.0 * TIMES, "load_angle": 0.2 * TIMES}


@pytest.fixture(scope="module")
def project():
    return from_text(PROJECT, Path("axis.yaml"))


@pytest.fixture(scope="module")
def train():
    return sw.HDC_40_050.train(
        control=sw.train.PositionLoop(50.0, 0.5), kinematic_error=sw.KinematicError((sw.Line(2, 1e-4),)), omega=150.0
    )


def moved(train, profile, **options):
    """A short move of a drive."""
    return sw.move(train, profile, method=sw.Dopri5(1e-3, 1e-5), **{"tail": 1e-4, "limits": None} | options)


def looped(controller, loop=CLOSED):
    """A few samples of a loop with another controller."""
    return sw.numerics.run_loop(loop._replace(controller=controller), 5e-3)


def specified(**other):
    """A specification with other numbers."""
    given = {"load_inertias": (1.3,), "speeds": (1.0, 3.0), "limit": 1e-3, "rotor_inertias": (1e-4,)}
    return sw.design(sw.Specification(**given | {"damping_ratio": 0.03} | other), gears=[GEAR])


def written(name, *columns, names):
    """Name of a CSV file with these columns."""
    Path(name).write_text(table(*columns, names=names), encoding="utf-8")
    return name


@pytest.mark.parametrize(
    "values",
    ["5", ["1", "2"], np.array([1j]), np.array(["2026-01-01"], "M8[D]"), [[1.0], [1.0, 2.0]],
     np.ma.array([1.0, 2.0], mask=[True, False]), [None], [1e61], np.array([np.longdouble("1e4000")])],
)  # fmt: skip
def test_texts_dates_masked_and_huge_numbers_are_no_numbers(values):
    for read in (numbers, array_of):
        with pytest.raises(ValueError, match=r"^torque .* is .*; it must be .*numbers"):
            read("torque [N*m]", values)


@pytest.mark.parametrize(
    "call",
    [
        lambda _: sw.ensemble(STRONG, {"B": [0.1]}, (0.0, 0.0), periods=1, measures=(sw.Amplitude(10**400),)),
        lambda _: sw.fit.arrangement(np.linspace(0.0, 9e6, 50), 1e-297 * np.arange(50.0), 1000),
        lambda _: sw.fit.discrepancy(np.cos(TIMES), 1e-300 * np.vander(TIMES, 2)),
        lambda _: sw.identify(FORCED, LOG, np.zeros(0)),
        lambda _: sw.identify(FORCED, LOG, ("law.K",), inputs={"excitation": "motor_angle"}, steps=10**9,
                              outputs={"x": "load_angle"}),
        lambda _: sw.identify(FORCED._replace(omega=0.0), LOG, ("law.K",), outputs={"x": "load_angle"}),
        lambda _: sw.monitor(TIMES, WAVES, angle=10.0 * TIMES, bandwidth=2e-11),
        lambda _: sw.read_frd(written("b.csv", TIMES[1:], TIMES[1:], names=("frequency [Hz]", "size [dB]")),
                              units={"size": LONG}),
        lambda _: sw.read_frd(written("b.csv", TIMES[1:], TIMES[1:], names=("frequency [Hz]", "size [dB]")),
                              amplitude=np.nan),
        lambda _: sw.read_log(written("l.csv", TIMES, TIMES, names=("time [s]", "x")), trim=(1.0, 2.0, 3.0)),
        lambda _: sw.replaced(STRONG, {"B": np.array([1.0, np.nan])}),
        lambda _: sw.replaced(STRONG, {"law.alpha": np.nan}),
        lambda _: sw.fit.bode_of_records(TIMES, WAVES, WAVES, 0.0 * TIMES),
        lambda _: sw.fit.bode_of_records(TIMES, WAVES, 0.0 * TIMES, WAVES),
        lambda p: sw.compensate(p, "inverse", speed=150.0, robust=False, units=10**400),
        lambda _: sw.study.compare_with_integration(DUFFING, sw.PRIMARY, t_end=1e16),
        lambda _: sw.fit_loop(1e-300 * np.sin(TURN), np.sin(TURN)),
        lambda _: sw.fit_loop(TWISTS, SPRING.torque(TWISTS) + 1e16 * (np.arange(120) == 0)),
        lambda _: sw.fit_loop(TWISTS - 1.0, SPRING.torque(TWISTS)),
        lambda _: sw.Log(1e-302 * TIMES, {}),
        lambda _: sw.Log(TIMES, {"motor_angle": 1e299 * TIMES}).segments(),
        lambda _: sw.Log(TIMES, {"load_angle": TIMES}).run(LONG),
        lambda _: sw.Log(TIMES, {"load_angle": TIMES}).segments(5e-324),
        lambda _: sw.fit.sandwich(1e-300 * np.array([[0.9, 1.0], [0.91, 1.0], [0.92, 1.1]]), np.ones(3)),
        lambda _: sw.fit.bootstrap(STEEP, np.cos(np.linspace(0.9, 1.1, 33) ** 7), block=4, draws=10),
        lambda _: specified(duty=np.zeros((0, 3))),
        lambda _: sw.lyapunov(LIGHT).V(np.inf, 0.0),
        lambda _: sw.lyapunov(LIGHT).contains(0.0, 1e300),
        lambda _: sw.simulate(STRONG, (0.1, 0.0), 0.1).peak(10**400),
        lambda _: sw.simulate(STRONG, (0.1, 0.0), 0.1).peak(2),
        lambda p: sw.tune(p, goals=("compliance",), gains=("K_p",), loads=[[0.0]]),
        lambda _: sw.read_project(LONG),
        lambda _: sw.slow_flow(DUFFING, sw.Resonance(1, 10**400)),
        lambda _: sw.sweep(lambda q: {"x": q.B}, STRONG, {"B": [0.1]}, store="\ud800"),
        lambda _: sw.study.efficiency(LOOPED, [5e-324], [100.0]),
        lambda _: looped(C.DisturbanceObserver(PD, 1e-4, 50.0, -0.0)),
        lambda _: looped(C.AdaptiveCancellation(PD, N, 1.0, 0.1, 1.0, 1e-3, order=1e30)),
        lambda _: looped(C.AdaptiveCancellation(PD, N, 1.0, 0.1, 1.0, 1e-3, on_load=10**30)),
        lambda _: looped(C.AdaptiveCancellation(PD, 0.0, 1.0, 0.1, 1.0, 1e-3)),
        lambda _: looped(C.InverseDynamics(PD, TRAIN._replace(law=sw.Cubic(0.0, 0.1)))),
        lambda _: C.notch(C.SampledPD(10.0, np.nan, 1e-3), 100.0, 1e-3),
        lambda _: sw.small_signal(sw.Cubic(5e-324, 0.1), 0.1),
        lambda p: sw.identify_log({"time": TIMES, LONG: TIMES}, project=p),
        lambda _: order_scan().amplitude_at(4.0, 5e-324),
        lambda _: sw.simulate(STRONG, (0.1, 0.0), 0.2, method=sw.Dopri5(1e-6, 5e-324)),
        lambda _: sw.numerics.loop_ensemble(LOOSE, {"controller.K_p": [10.0]}, 4e-3, settle=2e-3),
        lambda _: sw.numerics.loop_response(LOUD, [10.0]),
        lambda _: sw.numerics.run_loop(STIFF, 4e-3),
        lambda _: sw.study.parametric_resonances(
            sw.gears.VaryingOscillator(1.0, sw.gears.GearDamping(0.05), *STRONG[2:], sw.NoError()), (0.9, 1.0)
        ),
        lambda _: moved(LOOPED, sw.AngleProfile((-1e60, 1e-3, 2e-3, 3e-3), (0.0, 0.001, 0.002, 0.002))),
        lambda _: moved(LOOPED, SHORT, start=1e16),
        lambda _: sw.fit.compare_laws({"linear": (FORCED, ("law.K",))}, {"time": TIMES, "input": np.nan * TIMES}),
        lambda _: sw.numerics.parameter_response(
            sw.Oscillator(1.0, 0.0, sw.Linear(1.44), sw.Harmonic(0.18), 1.2), "excitation.amplitude", (0.05, 0.06)
        ),
        lambda _: sw.study.two_turn_motion(
            STRONG._replace(excitation=sw.Harmonic(1e60), error=sw.KinematicError((sw.Line(2, 0.1),))), 1.3, ratio=50.0
        ),
    ],
)  # fmt: skip
def test_what_once_had_no_sentence_has_one_or_a_result(call, project, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    try:
        assert str(call(project))
    except (ValueError, sw.SolveError) as refusal:
        assert fault(refusal) == ""  # noqa: PT017


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda _p, t: moved(t, (sw.study.Dwell(2e9), SHORT)), "takes more than 1,000,000 steps and reached 0 of 2e.09 s; give a shorter"),
        (lambda _p, t: moved(t, SHORT, tail=1e9), "takes more than 1,000,000 steps and reached 0.002 of 1e.09 s; give a shorter"),
        (lambda p, _t: sw.drive_motion(p, 1.2e-10), "could not be integrated: stopped at t = 0 s .* step limit"),
        (lambda _p, _t: sw.simulate(STRONG, (0.1, 0.0), 1e9, method=sw.Rk4(8)), "1.53e.09 steps are too many to record; give the times at which to record, or fewer"),
        (lambda _p, _t: sw.ensemble(STRONG, {"B": [0.1]}, (0.0, 0.0), periods=10**9, settle=1, method=sw.Rk4(8)), "periods of [0-9]+ steps are more than 100,000,000 steps; give fewer"),
        (lambda _p, _t: sw.basins(DUFFING, (-1.0, 1.0), (-1e3, 1e3), samples=1, settle=1, longest=9, method=sw.Rk4(4)), "9 periods of 13316088 steps are more than 100,000,000 steps; give"),
        (lambda _p, _t: isolas((3.0, 3.1e12)), r"ends at 1.03e\+12 times its start; take at most 1e\+06 times"),
        (lambda _p, _t: isolas((3e-4, 3.1e-4)), r"38 turns from 1400 starts take 4.*e.09 steps, more than 4e.08; take a"),
        (lambda _p, _t: sw.slow_flow(DUFFING, sw.PRIMARY).evolve((0.1, 0.0), [0.0, 1e9]), "could not be followed to t = 1e.09 s, only to 0 s; start closer"),
        (lambda _p, _t: sw.slow_flow(DUFFING, sw.PRIMARY).x([0.0, 1.0], (1e9, 0.0)), "to t = 1 s, only to 0 s; start closer to equilibrium, take an earlier end"),
        (lambda _p, _t: looped(PD, CLOSED._replace(sampling=C.Sampling(1e-3, seed=10**30))), "Sampling.seed is 10+; it must not exceed 9.0072e"),
        (lambda p, _t: list(sw.sample.scattered(p, 10**9)), "count is 1000000000; it must be at most 1000000"),
        (lambda _p, _t: sw.sweep(lambda q: {"x": q.B}, STRONG, sw.sample.Sobol(2**30, {"B": sw.Normal(0.05, 0.002)})), "1,073,741,824 points are more than 100,000,000; give the sweep a store"),
    ],
)  # fmt: skip
def test_what_takes_too_many_steps_is_refused_before_it_begins(call, sentence, project, train, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises((ValueError, sw.SolveError), match=sentence):
        call(project, train)


def isolas(span):
    """Isolas of a drive with a cubic spring."""
    return sw.isolas(DUFFING, span, resonance=sw.Resonance(1, 3), harmonics=3, points=2)


@pytest.mark.parametrize(
    "call",
    [
        lambda: sw.order_scan([sw.Run(TIMES, 10.0 * TIMES, WAVES + 0.1 * np.cos(7.7 * TIMES**2), "rad")], orders=np.array(1.5)),
        lambda: sw.error_scan(TURN, 1e-4 * np.cos(2.0 * TURN) + 1e-6 * np.cos(TURN**2), orders=np.array([1, 2]), drift=np.True_),
        lambda: looped(C.Cascade(np.uint8(3), 0.1, 0.1, 1e-3)),
        lambda: sw.HDC_40_050._replace(N=np.uint8(200)).error_equation(omega=np.float32(100.0)),
        lambda: sw.sweep(lambda q: {"x": q.B}, STRONG, {"B": np.array([0.1, 0.2])}, chunk=np.uint8(3), workers=1),
        lambda: sw.monitor(TIMES, WAVES, angle=10.0 * TIMES, orders=np.array([2]), bandwidth=np.float64(20.0)),
        lambda: sw.frequency_response(DUFFING, np.array([1.0, 1.1]), harmonics=np.int64(3), points=np.int64(10)),
        lambda: sw.prediction_table(from_text(PROJECT, Path("axis.yaml")), np.array([2]), speeds=np.array([100.0, 110.0]), closed=False),
    ],
)  # fmt: skip
def test_numbers_and_arrays_of_numpy_are_arguments_like_others(call):
    assert str(call())


class Marched(Exception):
    """The lanes of an ensemble were about to be marched."""


def test_a_lane_that_takes_some_minutes_is_marched(monkeypatch):
    def march(*_):
        raise Marched

    monkeypatch.setattr(ensemble, "march_all", march)
    with pytest.raises(Marched):
        sw.ensemble(STRONG, {"B": [0.1]}, (0.0, 0.0), periods=100_000, method=sw.Dop8(steps_per_period=128))


@pytest.mark.parametrize(
    ("y0", "t", "method"),
    [
        ((1e11, 0.0), [0.0, 0.1, 0.3], sw.Dopri5(1e-6)),  # the spring has hardened
        ((0.0, 0.0), [0.0, 1e8, 2e9], sw.Dopri5(1e-6)),
        ((0.0, 0.0), [0.0, 1e8, 2e9], sw.Rk4()),
    ],
)
def test_a_run_without_a_hope_of_its_end_stops_at_its_start(y0, t, method):
    run = sw.simulate(STRONG, y0, t, method=method)
    assert run.status is sw.Status.TOO_MANY_STEPS
    assert (run.steps, len(run.t)) == (0, 1)
    assert "stopped at t = 0 s" in run.message


@pytest.mark.parametrize(
    "arguments",
    [
        [*valid_command("sweep"), "-o", "x" * 3000],
        [*valid_command("sweep"), "--cluster", "x" * 3000],
        [*valid_command("exceedance"), "--seed", "9" * 400],
        ["order-table", "table.csv", "\udcff", "--format", "csv"],
        ["order-table", "table.csv", "", "--format", "csv"],
    ],
)
def test_what_once_had_no_sentence_in_a_command_has_one(arguments, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert answer_of(arguments, 60.0)[1] == ""


def test_every_command_has_a_call_that_is_spoilt():
    assert {name.partition(",")[0] for name in VALID} == {*cli.commands} - {*OWN}


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in VALID if name not in SLOW])
def test_the_call_of_a_command_that_is_spoilt_is_a_valid_one(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert answer_of(valid_command(name), 60.0) == ("done", "")


@pytest.mark.parametrize("name", [name for name in VALID if name not in SLOW])
def test_every_command_answers_hostile_options_with_a_sentence(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for seed in range(3):
        arguments = hostile_command(name, f"test {seed}")
        assert answer_of(arguments, 0.5)[1] == "", arguments
