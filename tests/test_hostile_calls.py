# ruff: noqa: ARG001
"""Arguments of other kinds: what a signature says is said to who calls, and no public verb answers with a traceback."""

from collections.abc import Callable, Mapping, Sequence
from decimal import Decimal
from fractions import Fraction
from inspect import signature
from operator import attrgetter
from typing import Any, Literal

import numpy as np
import pytest
from canonical import DISSIPATIVE, LAWS, TRAINS
from hostile_calls import answer, hostile_call
from hostile_commands import OWN, VALID, answer_of, hostile_command, valid_command
from public_names import PUBLIC
from valid_calls import CALLS, CLOSED, GEAR, LIGHT, STRONG, TIMES, TURN

import strainwave as sw
from strainwave.app.commands.cli import cli
from strainwave.base.arguments import typed
from strainwave.base.quantities import array_of, numbers
from strainwave.numerics.ensemble import ensemble

SLOW = (
    "shoot",
    "frequency_response",
    "exceedance",
    "compare",
    "demo",
    "derive",
    "reproduce",
    "isolas",
)

RETURNED = (
    "Branch Compensator Finding GearOrder LawFit MeasuredError Measurement Orbit OrderMap "
    "Project SlowFlow Source StabilityProof SteadyState Trajectory"
)  # of the package's own making: `test_wrong_kinds` calls their methods
LOUD = CLOSED.train.motor._replace(excitation=sw.Harmonic(0.0, mean=1e60))
SPRING, TWISTS = sw.PiecewiseLinear(3e4, 5e4, 6e4, 14.0, 48.0), 2e-3 * np.sin(np.linspace(0.0, 4.0 * np.pi, 120))
LOOSE = CLOSED._replace(train=CLOSED.train._replace(motor=CLOSED.train.motor._replace(J=1e-59)))


@typed
def verb(
    drive: sw.Drive | None,
    share: float = 0.5,
    count: int = 1,
    way: Literal["up", "down"] = "up",
    names: Sequence[str] = (),
    lines: Sequence[sw.Line] = (),
    values: Mapping[str, float] | None = None,
    told: Callable[[str], None] = print,
    closed: bool = True,
    other: Any = None,
) -> str:
    return f"{count} {way}"


@pytest.mark.parametrize(
    ("given", "kind", "sentence"),
    [
        ({"drive": 3}, TypeError, "drive is 3; give a Drive"),
        ({"drive": sw.Drive}, TypeError, "drive is <class .*Drive'>; give a Drive"),
        ({"share": "0.5"}, ValueError, "share is '0.5'; it must be a finite number"),
        ({"share": True}, ValueError, "share is True; it must be a finite number"),
        ({"count": 1.5}, ValueError, "count is 1.5; it must be a whole number"),
        ({"way": ["up"]}, ValueError, r"way is \['up'\]; it must be 'up' or 'down'"),
        ({"names": 5}, ValueError, "names is 5; it must be a list or tuple, each item a text"),
        ({"names": ("a", 5)}, ValueError, r"names is \('a', 5\); it must be a list or tuple, each item a text"),
        ({"lines": "x"}, TypeError, "lines is 'x'; give a list or tuple, each item a Line"),
        ({"lines": (sw.Line(2, 1e-4), 3)}, TypeError, "give a list or tuple, each item a Line"),
        (
            {"values": [1.0]},
            TypeError,
            r"values is \[1.0\]; give a dictionary: of each name \(a text\) a finite number",
        ),
        ({"values": {1: 2.0}}, TypeError, r"values is \{1: 2.0\}; give a dictionary"),
        ({"told": 5}, TypeError, "told is 5; give a function of 1 argument"),
        ({"told": lambda: None}, TypeError, "; give a function of 1 argument"),
        ({"closed": np.ones(2)}, ValueError, "it must be True or False"),
        ({"often": 3}, TypeError, "verb: got an unexpected keyword argument 'often'; its arguments are drive, share"),
    ],
)
def test_an_argument_of_another_kind_than_its_annotation_is_refused_in_one_sentence(given, kind, sentence):
    with pytest.raises(kind, match=sentence):
        verb(**{"drive": None, **given})


def test_what_the_annotations_say_passes_as_it_is():
    given = {"names": np.array(["a"]), "lines": [sw.Line(2, 1e-4)], "values": {"a": 1}, "closed": np.bool_(False)}
    assert verb(sw.HDC_40_050, np.float32(0.5), np.int64(2), "down", **given, other=object()) == "2 down"


@pytest.mark.parametrize(
    "values",
    ["5", b"5", ["1", "2"], [b"1"], np.array([1j]), np.array(["2026-01-01"], "M8[D]"), [10**400], [[1.0], [1.0, 2.0]],
     np.ma.array([1.0, 2.0], mask=[True, False]), [None], {1.0}, [1e61], np.array([np.longdouble("1e4000")])],
)  # fmt: skip
def test_texts_dates_masked_and_huge_numbers_are_no_numbers(values):
    for read in (numbers, array_of):
        with pytest.raises(ValueError, match=r"^torque .* is .*; it must be .*numbers"):
            read("torque [N*m]", values)


@pytest.mark.interpreted
@pytest.mark.parametrize(
    ("name", "spoilt"),
    [
        ("Amplitude", {"k": 10**400}),
        ("arrangement", {"load_counts": 1e-297 * np.arange(50.0)}),
        ("BoucWen", {"n": np.longdouble("1e4000")}),
        ("compensation_bench", {"loop": sw.Peak()}),
        ("discrepancy", {"jacobian": 1e-300 * np.vander(np.linspace(0.0, 1.0, 32), 2), "candidates": None}),
        ("find_orbit", {"system": TRAINS["commanded"]}),
        ("find_orbit", {"guess": np.longdouble("1e4000")}),
        ("identify", {"free": np.zeros(0)}),
        ("identify_drive", {"free": np.arange(3, dtype=np.uint8)}),
        ("loop_ensemble", {"orders": STRONG}),
        ("MotorLimits", {"torque": Fraction(1, 3)}),
        ("MotorLimits", {"peak_torque": sw.Dopri5(1e-3)}),
        ("monitor", {"bandwidth": 2e-11}),
        ("order_scan", {"orders": np.array(1.5)}),
        ("read_frd", {"amplitude": np.nan}),
        ("read_log", {"trim": {1: 2}}),
        ("read_log", {"trim": (1.0, 2.0, 3.0)}),
        ("read_scan", {"backward": GEAR}),
        ("replaced, of a model", {"values": {"B": [np.nan]}}),
        ("StabilityProof.V", {"v": Decimal("NaN")}),
        ("tabulated", {"points": np.ma.masked}),
        ("bode_of_records", {"speed": 0.0 * TIMES}),
        ("compensate", {"units": 10**400}),
        ("compare_with_integration", {"t_end": 1e16}),
        ("ensemble", {"y0": np.ma.masked}),
        ("fit_loop", {"torsion": 1e-300 * np.sin(TURN)}),
        ("fit_odd", {"law": sw.Peak()}),
        ("frequency_response", {"throw": np.ones(2)}),
        ("fit_decay", {"value": 1e-300 * np.cos(TIMES)}),
        ("identify", {"log": {"time": TIMES, "x": [[1.0, 2.0], [3.0]]}}),
        ("identify_drive", {"log": []}),
        ("identify_drive", {"log": {"time": TIMES, "motor_angle": {}, "load_angle": TIMES}}),
        ("identify_drive", {"log": {"time": TIMES, "motor_angle": 1j * TIMES, "load_angle": TIMES}}),
        ("Log", {"time": 1e-302 * TIMES}),
        ("Log", {"channels": {"motor_angle": 1e299 * TIMES}}),
        ("Log.run", {"channel": "x" * 5000}),
        ("Log.segments", {"tolerance": 5e-324}),
        ("OrderTable.of", {"error": (sw.Line("a", 1e-4),)}),
        ("parameter_response", {"throw": np.ones(2)}),
        ("read_log", {"columns": -np.inf}),
        ("read_log", {"units": np.array(["1", "2"])}),
        ("read_log", {"units": {"motor_angle": []}}),
        ("read_project", {"path": GEAR}),
        ("read_profile", {"decimal": np.ma.array([1.0, 2.0], mask=[True, False])}),
        ("Run", {"unit": [1.0]}),
        ("sandwich", {"jacobian": 1e-300 * np.array([[0.9, 1.0], [0.91, 1.0], [0.92, 1.1]]), "residual": np.ones(3)}),
        ("replaced, of a model", {"values": {"B": np.array([1.0, np.nan])}}),
        ("replaced, of a model", {"values": {"law.alpha": np.nan}}),
        ("replaced", {"retune": np.array(["1", "2"])}),
        ("speed_map, two turns", {"units": range(3)}),
        ("Specification", {"duty": -1.0}),
        ("Specification", {"duty": (3.0,)}),
        ("StabilityProof.V", {"x": np.inf}),
        ("StabilityProof.contains", {"v": 1e300}),
        ("Trajectory.peak", {"component": 10**400}),
        ("tune", {"loads": [[0.0]]}),
        ("tune", {"units": np.ones(2)}),
        ("tune", {"gains": np.ones((2, 1, 2))}),
        ("Trajectory.peak", {"component": 2}),
        ("read_project", {"path": "x" * 5000}),
        ("Resonance", {"q": 10**400}),
        ("basins", {"system": STRONG._replace(excitation=DISSIPATIVE["BoucWen"])}),
        ("DriveTrain", {"friction": LAWS["Cubic"]}),
        ("GearDamping", {"variation": sw.Status.OK}),
        ("VaryingOscillator", {"damping": sw.NoError()}),
        ("sweep", {"store": "\ud800"}),
        ("from_bandwidth", {"kind": np.arange(3)}),
        ("Specification", {"duty": np.zeros((0, 3))}),
        ("error_scan", {"drift": np.True_}),
        ("amplitude_at", {"order": Fraction(1, 3)}),
        ("efficiency", {"torque": 5e-324}),
        ("DisturbanceObserver", {"period": -0.0}),
        ("small_signal", {"law": sw.Cubic(5e-324, 0.1)}),
        ("KinematicError", {"lines": (sw.Line(np.longdouble("1e4000"), 0.1),)}),
        ("notch", {"loop": sw.controllers.SampledPD(10.0, np.nan, 1e-3)}),
        ("replaced, of a model", {"values": {"B": complex("nan")}}),
        ("identify_drive", {"log": {"time": TIMES, "x" * 5000: TIMES}}),
        ("hardening", {"speeds": [1, [2, 3]]}),
        ("margins", {"at": Fraction(10**400, 3)}),
        ("Cascade", {"K_v": np.uint8(3)}),
        ("compare_laws", {"log": {"time": [1, [2, 3]], "input": TIMES, "output": TIMES}}),
        ("ensemble", {"measures": ({}, sw.Rms())}),
        ("export", {"source": sw.Peak()}),
        ("Log", {"channels": {"motor_angle": [1, [2, 3]]}}),
        ("loop_response", {"output": sw.Cubic}),
        ("move", {"limits": sw.MotorLimits(5.0, 500.0, peak_torque=[[]])}),
        ("move", {"project": sw}),
        ("Project.response", {"coexisting": np.array([])}),
        ("Specification", {"kinematic_error": sw.Trapezoid(0.1, 0.1)}),
        ("Specification", {"series": np.array([])}),
        ("sweep", {"processes": np.array([])}),
        ("tabulated", {"points": [(-1.0, -2.0), (0.0, 10**400), (1.0, 2.0)]}),
        ("tune", {"goals": np.array([])}),
        ("AdaptiveCancellation", {"order": 1e30}),
        ("AdaptiveCancellation", {"on_load": 10**30}),
        ("Sampling", {"seed": 1e30}),
        ("read_scan", {"reverse": np.ma.array([1.0, 2.0], mask=[True, False])}),
        ("read_scan", {"ate": np.array([])}),
        ("read_log", {"unwrap": np.array([])}),
        ("read_log", {"columns": dict}),
        ("order_scan", {"orders": LAWS["Cubic"]}),
        ("bode_of_records", {"torque": 0.0 * TIMES}),
        ("amplitude_at", {"speed": 5e-324}),
        ("Dopri5", {"atol": 5e-324}),
        ("AdaptiveCancellation", {"N": 0.0}),
        ("Log", {"time": TIMES.astype(object)}),
        ("InverseDynamics", {"train": CLOSED.train._replace(law=sw.Cubic(0.0, 0.1))}),
        ("loop_ensemble", {"loop": LOOSE}),
        ("replaced, of a model", {"project": STRONG._replace(J=complex("nan"))}),
        ("identify", {"steps": 10**9}),
        ("replaced, of a model", {"project": STRONG._replace(J=[float("nan")] * 3)}),
        ("read_frd", {"units": {"size": "x" * 5000}}),
        ("SteadyTrain", {"train": TRAINS["free"]._replace(friction=TRAINS["free"])}),
        ("identify", {"system": sw.Oscillator(1.0, 0.12, sw.Linear(1.1), sw.Harmonic(0.0), 0.0)}),
        ("loop_response", {"output": lambda: 1.0}),
        ("loop_response", {"output": lambda *_: None}),
        ("move_postures", {"progress": lambda: 1.0}),
        (
            "parametric_resonances",
            {"system": sw.gears.VaryingOscillator(1.0, sw.gears.GearDamping(0.05), *STRONG[2:], sw.NoError())},
        ),
        ("sweep", {"progress": lambda: 1.0}),
        ("AngleProfile", {"times": (-1e60, 1e-3, 2e-3, 3e-3)}),
        ("bootstrap", {"jacobian": np.column_stack([np.linspace(0.9, 1.1, 33), 1e60 ** (np.arange(33) == 16)])}),
        ("compare_laws", {"log": {"time": 0.1 * np.arange(400), "input": np.nan, "output": np.arange(400.0)}}),
        ("Filtered", {"loop": sw.train.SteadyTrain(TRAINS["free"], 1.3)}),
        ("fit_decay", {"system": LIGHT._replace(B=-1e60, law=sw.Linear(1.1))}),
        ("fit_loop", {"torque": SPRING.torque(TWISTS) + 1e16 * (np.arange(120) == 0)}),
        ("fit_loop", {"torsion": TWISTS - 1.0}),
        ("loop_response", {"loop": CLOSED._replace(train=CLOSED.train._replace(motor=LOUD))}),
        ("move", {"start": 1e16}),
        (
            "parameter_response",
            {
                "system": sw.Oscillator(1.0, 0.0, sw.Linear(1.44), sw.Harmonic(0.18), 1.2),
                "path": "excitation.amplitude",
            },
        ),
        ("Specification", {"duty": ((Fraction(10, 3), Fraction(1, 3), 1),), "mean_torque": None, "peak_torque": None}),
        ("Specification", {"largest_size": Fraction(61, 3)}),
        ("Specification", {"life": Fraction(10**5, 3)}),
        ("Specification", {"load_inertias": (Fraction(4, 3),), "speeds": (Fraction(4, 3), 3.0)}),
        ("Specification", {"peak_torque": Fraction(1, 3)}),
        ("AdaptiveCancellation", {"gain": Fraction(-(10**9), 3)}),
        ("Cascade", {"K_v": Fraction(-(10**9), 3)}),
        ("Drive", {"N": np.uint8(200)}),
        ("shoot", {"rtol": Fraction(0, 1)}),
        ("Identified.simulate", {"inputs": {"time": [0.0, 0.1], "input": np.full(2, np.longdouble("1e4000"))}}),
        ("sweep", {"chunk": np.uint8(3)}),
        (
            "run_loop",
            {"loop": CLOSED._replace(train=CLOSED.train._replace(load=sw.train.Load(0.05, drag=sw.Linear(1e12))))},
        ),
        (
            "two_turn_motion",
            {"system": STRONG._replace(excitation=sw.Harmonic(1e60), error=sw.KinematicError((sw.Line(2, 0.1),)))},
        ),
    ],
)
def test_what_once_had_no_sentence_has_one(name, spoilt, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    function, arguments = CALLS[name]()
    assert answer(function, arguments | spoilt, 60.0)[1] == ""


@pytest.mark.interpreted
@pytest.mark.parametrize(
    ("name", "spoilt", "sentence"),
    [
        (
            "Dwell",
            {"time": 2e9},
            "takes more than 1,000,000 steps and has come to 0 of 2e.09 s; give a shorter",
        ),
        ("Trapezoid", {"time": 2e9}, "takes more than 1,000,000 steps and has come to 0 of 2e.09 s; give a shorter"),
        ("SCurve", {"time": 2e9}, "takes more than 1,000,000 steps and has come to 0 of 2e.09 s; give a shorter"),
        ("move", {"tail": 1e9}, "takes more than 1,000,000 steps and has come to 0.002 of 1e.09 s; give a shorter"),
        (
            "drive_motion",
            {"omega": 1.2e-10},
            "could not be integrated: stopped at t = 0 s .* step limit",
        ),
        ("simulate", {"t": 1e9}, "1.53e.09 steps are too many to record; give the times at which to record, or fewer"),
        ("ensemble", {"periods": 10**9}, "periods of [0-9]+ steps are more than 100,000,000 steps; give fewer"),
        ("basins", {"v_span": (-1e3, 1e3)}, "9 periods of 13316088 steps are more than 100,000,000 steps; give"),
        ("ensemble", {"settle": 10**9}, "periods of [0-9]+ steps are more than 100,000,000 steps; give fewer periods"),
        ("isolas", {"span": (3.0, 3.1e12)}, r"ends at 1.03e\+12 times its start; take at most 1e\+06 times"),
        ("isolas", {"span": (3e-4, 3.1e-4)}, r"38 turns from 1400 starts take 4.*e.09 steps, more than 4e.08; take a"),
        ("isolas", {"span": (0.003, 0.0031)}, r"38 turns from 1400 starts take 4.*e.08 steps, more than 4e.08; take a"),
        ("SlowFlow.evolve", {"t": [0.0, 1e9]}, "could not be followed to t = 1e.09 s, only to 0 s; start closer"),
        ("SlowFlow.evolve", {"y0": (1e3, 0.0), "t": [0.0, 1e3]}, "to t = 1000 s, only to 0 s; start closer"),
        ("SlowFlow.x", {"y0": (1e9, 0.0)}, "to t = 1 s, only to 0 s; start closer to equilibrium, take an earlier end"),
        (
            "AdaptiveCancellation",
            {"order": 1e30},
            "order is 10+19884624838656; it must not exceed 9.0072e",
        ),
        ("Sampling", {"seed": 10**30}, "Sampling.seed is 10+; it must not exceed 9.0072e"),
        ("scattered", {"count": 10**9}, "count is 1000000000; it must be at most 1000000"),
        ("exceedance", {"count": 10**9}, "count is 1000000000; it must be at most 1000000"),
        ("LatinHypercube", {"count": 10**9}, "1,000,000,000 points are more than 100,000,000; give the sweep a store"),
    ],
)
def test_what_takes_too_many_steps_is_refused_before_it_begins(name, spoilt, sentence, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    function, arguments = CALLS[name]()
    with pytest.raises((ValueError, sw.SolveError), match=sentence):
        function(**arguments | spoilt)


class Marched(Exception):
    """The lanes of an ensemble were about to be marched."""


def test_a_lane_that_takes_some_minutes_is_marched(monkeypatch):
    def march(*_):
        raise Marched

    monkeypatch.setattr(ensemble, "_march_all", march)
    with pytest.raises(Marched):
        sw.ensemble(STRONG, {"B": [0.1]}, (0.0, 0.0), periods=100_000, method=sw.Dop8(steps_per_period=128))


@pytest.mark.interpreted
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


@pytest.mark.interpreted
@pytest.mark.parametrize("name", [name for name in CALLS if name not in SLOW])
def test_every_verb_answers_hostile_arguments_with_a_result_or_a_sentence(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for seed in range(3):
        function, arguments, spoilt = hostile_call(name, f"test {seed}")
        assert answer(function, arguments, 0.5)[1] == "", spoilt


def test_every_public_name_that_takes_arguments_has_a_call_that_is_spoilt():
    called = {name.partition(",")[0] for name in CALLS}
    things = {path: attrgetter(path)(sw) for path in PUBLIC if not path.startswith("results.")}
    taking = {
        path.rpartition(".")[2]
        for path, thing in things.items()
        if callable(thing) and thing not in (sw.SolveError, sw.Status) and signature(thing).parameters
    }
    assert taking - called == {*RETURNED.split()}


def test_every_command_has_a_call_that_is_spoilt():
    assert {name.partition(",")[0] for name in VALID} == {*cli.commands} - {*OWN}


@pytest.mark.compiled
@pytest.mark.parametrize("name", [name for name in VALID if name not in SLOW])
def test_the_call_of_a_command_that_is_spoilt_is_a_valid_one(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert answer_of(valid_command(name), 60.0) == ("done", "")


@pytest.mark.interpreted
@pytest.mark.parametrize("name", [name for name in VALID if name not in SLOW])
def test_every_command_answers_hostile_options_with_a_sentence(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for seed in range(3):
        arguments = hostile_command(name, f"test {seed}")
        assert answer_of(arguments, 0.5)[1] == "", arguments
