# ruff: noqa: E501
"""A valid call of every public function and class that takes arguments, small enough for the interpreter.

CALLS has by name a function without arguments that gives the callable and its arguments by name. A class of models is
called by `used`, which puts its instance where it belongs and moves a drive with it: only a verb checks a model.
"""

from functools import cache
from pathlib import Path

import numpy as np
from all_results import CLOSED, CURVE, DUFFING, LOOPED, NUMBERS, RESULTS, axis, branch, design
from canonical import DISSIPATIVE, ERRORS, EXCITATIONS, LAWS, PROFILES, REFERENCES, TRAINS, VARIATIONS

import strainwave as sw
from strainwave.base.protocols import state_count
from strainwave.base.quantities import checked
from strainwave.files.reading import from_text

TIMES = 0.01 * np.arange(200)
TURN = np.linspace(0.0, 4.0 * np.pi, 240, endpoint=False)
SWEEP = np.tile(np.cos(0.05 * np.arange(50) ** 2), 4)
KNOTS = sw.laws.Knot(-1.0, -2.0, 2.0), sw.laws.Knot(0.0, 0.0, 2.0)
GEAR = sw.catalogue.gear("CSG-40-50")
LOOP = sw.train.PositionLoop(50.0, 0.5)
CASCADE = sw.train.CascadeLoop(20.0, 0.2, 0.05)
FILTERS = {
    "LowPassFilter": sw.train.LowPassFilter(200.0, 0.7),
    "NotchFilter": sw.train.NotchFilter(200.0, 50.0, 0.1),
    "BiquadFilter": sw.train.BiquadFilter(200.0, 0.7, 300.0, 0.1),
}
LINK = {"mass": 8.0, "length": 0.4, "centre": 0.2, "inertia": 0.1}
POSTURES = "inertia [kg*m^2],torque [N*m],coupling [N*m/rad]\n1,-5,2e5\n2,-9,1e5\n"
QUICK = sw.Rk4(8)
COARSE = sw.Rk4(steps_per_period=8)
LIGHT = DUFFING._replace(excitation=sw.Harmonic(0.0))
STRONG = sw.Oscillator(1.0, 0.05, sw.Cubic(1.0, 0.1), sw.Harmonic(0.5), 1.2)
SAMPLING = sw.controllers.Sampling(limit=3.0)
SPEEDS = np.array([-20.0, -10.0, -5.0, -2.0, 2.0, 5.0, 10.0, 20.0])
SCATTER = {"B": sw.Normal(0.05, 0.002), "law.K": sw.Uniform(0.9, 1.1)}
AXIS = """
gear: {name: CSG-40-50}
motor: {inertia: 4.5 kg*cm^2, loop: {bandwidth: 30 Hz, damping: 0.7}, max_torque: 3 N*m}
load: {inertia: 1.3 kg*m^2}
damping: {ratio: 3 %}
speed: {from: 100 rad/s, to: 180 rad/s, shaft: motor}
limit: {oscillation: 100 arcsec}
excitation: {kinematic_error: [{order: 2, amplitude: 23 arcsec}]}
scatter: {load.inertia: 3 %}
"""
WANTED = """
load: {inertia: 1.3 kg*m^2}
speed: {from: 2 rpm, to: 40 rpm}
limit: {oscillation: 90 arcsec}
motor: {rotor_inertias: [0.5 kg*cm^2]}
damping: {ratio: 3 %}
"""
GEARS = """name,ratio,K1 [N*m/rad],K2 [N*m/rad],K3 [N*m/rad],T1 [N*m],T2 [N*m]
MY-40-50,50,1e5,1.4e5,1.8e5,54,196
"""
TWO_TURNS = """
gear: {ratio: 50, fixed: flexspline, law: {type: linear, K: 1e5 N*m/rad}}
motor: {inertia: 4.5 kg*cm^2, loop: {type: cascade, bandwidth: 30 Hz}}
load: {inertia: 1.3 kg*m^2}
damping: {ratio: 3 %}
speed: {from: 120 rad/s, to: 130 rad/s, shaft: motor}
limit: {oscillation: 100 arcsec}
excitation:
  kinematic_error: [{order: 2, amplitude: 9 arcsec}, {order: {wave_generator: 2, output: -2}, amplitude: 9 arcsec}]
"""


@cache
def project():
    """A project of a gear of the catalogue, with a loop, a limit and a scatter."""
    Path("axis.yaml").write_text(AXIS.replace("{name: CSG-40-50}", "CSG-40-50"), encoding="utf-8")
    return sw.read_project("axis.yaml")


def beating():
    """A project whose motions beat, with a cascade and the flexspline fixed."""
    return from_text(TWO_TURNS, Path("beating.yaml"))


@cache
def train():
    """A drive train with a loop."""
    return sw.HDC_40_050.train(control=LOOP, kinematic_error=sw.KinematicError((sw.Line(2, 1e-4),)), omega=150.0)


@cache
def decay():
    """Time and value of a free vibration."""
    t = 0.1 * np.arange(300)
    return t, np.exp(-0.01 * t) * np.cos(t)


@cache
def curve():
    """A hardening response with two folds."""
    return sw.frequency_response(STRONG, (0.9, 1.8), harmonics=3)


@cache
def log(count=80):
    """Time, input and output of x'' + .1 x' + 1.2 x = u."""
    t = 0.1 * np.arange(count)
    u = np.cos(0.8 * t)
    return {"time": t, "input": u, "output": (0.56 * u + 0.08 * np.sin(0.8 * t)) / 0.32 + 1e-3 * np.cos(7.0 * t)}


def written(name, text):
    """Path of a file with a text."""
    Path(name).write_text(text, encoding="utf-8")
    return name


def table(*columns, names):
    """Text of a CSV file."""
    rows = [",".join(names), *(",".join(f"{value:.12g}" for value in row) for row in zip(*columns, strict=True))]
    return "\n".join(rows) + "\n"


def moved(system):
    """A short motion of any system."""
    return sw.simulate(system, np.zeros(state_count(checked(system))), 0.02, method=COARSE)


def looped(loop):
    """A design of a joint with a loop of its motor."""
    return sw.design(sw.Specification(**SPECIFICATION | {"loop": loop}), gears=[GEAR])


def shortly(profile, **options):
    """A short move of a drive."""
    return sw.move(train(), profile, tail=1e-4, method=sw.Dopri5(1e-3, 1e-5), **options)


def used(kind, model):
    """A short motion of a drive that a model is part of."""
    whole = TRAINS["free"]
    put = {
        "law": lambda: STRONG._replace(law=model),
        "excitation": lambda: STRONG._replace(excitation=model),
        "error": lambda: STRONG._replace(error=model),
        "variation": lambda: sw.gears.VaryingOscillator(
            1.0, sw.gears.GearDamping(0.1), sw.Cubic(1.0, 0.1), sw.Harmonic(0.3), 1.2, variation=model
        ),
        "damping": lambda: sw.gears.VaryingOscillator(1.0, model, sw.Cubic(1.0, 0.1), sw.Harmonic(0.3), 1.2),
        "reference": lambda: whole._replace(motor=sw.train.Motor(0.2, control=LOOP), reference=model),
        "control": lambda: whole._replace(motor=sw.train.Motor(0.2, control=model)),
        "filter": lambda: whole._replace(motor=sw.train.Motor(0.2, control=sw.train.Filtered(CASCADE, model))),
        "motor": lambda: whole._replace(motor=model),
        "load": lambda: whole._replace(load=model),
        "friction": lambda: whole._replace(friction=model),
        "torque": lambda: whole._replace(motor=sw.train.Motor(0.2, model)),
        "system": lambda: model,
    }
    return moved(put[kind]())


def model_calls():
    """Calls of the classes of models: their fields are the arguments."""
    whole = TRAINS["everything"]
    kinds = {
        "law": {**LAWS, **DISSIPATIVE},
        "excitation": EXCITATIONS,
        "error": {"KinematicError": ERRORS["KinematicError"]},
        "variation": {"Variation": VARIATIONS["Variation"]},
        "damping": {"GearDamping": sw.gears.GearDamping(0.1, VARIATIONS["Variation"], 5.0, fast=0.4, v_fast=0.3)},
        "reference": {name: REFERENCES[name] for name in ("SpeedProfile", "Segment")},
        "torque": PROFILES,
        "control": {
            "PositionLoop": LOOP,
            "SpeedLoop": sw.train.SpeedLoop(0.3, 0.2, 0.05),
            "CascadeLoop": CASCADE,
            "PositionIntegral": sw.train.PositionIntegral(CASCADE, 1.0),
            "LoadEncoder": sw.train.LoadEncoder(CASCADE),
            "MixedEncoders": sw.train.MixedEncoders(CASCADE, 60.0),
            "Filtered": sw.train.Filtered(CASCADE, FILTERS["NotchFilter"]),
            "Lagged": sw.train.Lagged(sw.train.SpeedLoop(0.3, 0.2, 0.05), 0.1),
        },
        "motor": {"Motor": sw.train.Motor(0.2, sw.Harmonic(0.1), sw.laws.Viscous(0.01), LOOP)},
        "load": {"Elastic": whole.load, "Load": sw.train.Load(1.5, sw.Harmonic(0.1), sw.laws.Viscous(0.01))},
        "filter": FILTERS,
        "friction": {"LoadFriction": sw.laws.LoadFriction(0.1, 0.2)},
        "system": {
            "Oscillator": STRONG,
            "VaryingOscillator": sw.gears.VaryingOscillator(
                1.0, sw.gears.GearDamping(0.1), sw.Cubic(1.0, 0.1), sw.Harmonic(0.3), 1.2
            ),
            "DriveTrain": TRAINS["position loop"],
            "SteadyTrain": sw.train.SteadyTrain(TRAINS["free"]._replace(error=ERRORS["KinematicError"]), 1.3),
        },
    }
    user = ("Saturating", "Stop")  # defined in the tests
    return {
        name: lambda kind=kind, model=model: (lambda **k: used(kind, type(model)(**k)), model._asdict())
        for kind, models in kinds.items()
        for name, model in models.items()
        if name not in user
    }


def controller_calls():
    """Calls of the sampled controllers, run for a few samples."""
    N, PD = CLOSED.train.N, CLOSED.controller
    C = sw.controllers
    line = sw.KinematicError((sw.Line(2, 1e-4),))
    made = [
        PD,
        C.AdaptiveCancellation(PD, N, 1.0, 0.1, 1.0, 1e-3),
        C.Cascade(20.0, 0.1, 0.1, 1e-3),
        C.DisturbanceObserver(PD, 1e-4, 50.0, 1e-3),
        C.AngleFeedforward(PD, line, N),
        C.InverseDynamics(PD, CLOSED.train),
        C.notch(PD, 100.0, 1e-3),
        C.Repetitive(PD, N, 500.0, 0.3, 1e-3, 2.0, 1e-3),
        C.SpeedTable(PD, (20.0, 45.0), (0.1, -0.2), (0.0, 0.1), order=2, lead=3e-4),
        C.TorqueTable(PD, sw.Harmonics((sw.Harmonic(0.2, 2, 0.4), sw.Harmonic(0.1, 4))), 3e-4),
    ]
    blocks = [
        C.Average(20.0, 1e-3),
        C.Demodulator(C.Average(20.0, 1e-3), 20.0, 1e-3),
        C.Tracker(50.0, 160.0, 5.0, 1e-3),
    ]
    calls = {
        type(c).__name__: lambda c=c: (
            lambda **k: sw.numerics.run_loop(CLOSED._replace(controller=type(c)(**k)), 5e-3),
            c._asdict(),
        )
        for c in made
    }
    calls |= {type(b).__name__: call(lambda b=b, **k: checked(type(b)(**k)), **b._asdict()) for b in blocks}
    return calls | {
        "Sampling": lambda: (
            lambda **k: sw.numerics.run_loop(CLOSED._replace(sampling=C.Sampling(**k)), 5e-3),
            CLOSED.sampling._asdict(),
        ),
        "ClosedLoop": lambda: (lambda **k: sw.numerics.run_loop(C.ClosedLoop(**k), 5e-3), CLOSED._asdict()),
        "notch": lambda: (C.notch, {"loop": PD, "frequency": 100.0, "period": 1e-3, "width": 0.5, "depth": 0.1}),
    }


def call(function, *names, **arguments):
    """A row of the table."""
    return lambda: (function, {name: value() if name in names else value for name, value in arguments.items()})


SPECIFICATION = {
    "load_inertias": (1.3,), "speeds": (1.0, 3.0), "limit": 1e-3, "rotor_inertias": (1e-4, 1e-3),
    "damping_ratio": 0.03, "duty": (), "mean_torque": 20.0, "peak_torque": 60.0,
    "average_speed": 3.0, "momentary_torque": 100.0, "preload": 0.0, "life": 1e3, "largest_size": 50,
    "largest_mass": 10.0, "ratios": (50, 100), "series": ("CSG",), "accuracy": None,
    "kinematic_error": sw.KinematicError((sw.Line(2, 1e-4),)), "loop": None, "title": "elbow",
}  # fmt: skip
BY_DUTY = SPECIFICATION | {"mean_torque": None, "peak_torque": None, "average_speed": None}
CALLS = {
    **model_calls(),
    **controller_calls(),
    "Line": call(lambda **k: used("error", sw.KinematicError((sw.Line(**k),))), order=2, amplitude=0.1, phase=0.3),
    "Knot": call(
        lambda **k: used("law", sw.laws.Tabulated((*KNOTS, sw.laws.Knot(**k)))), x=1.0, T=2.0, K=2.0
    ),
    "Ripple": call(
        lambda **k: used("variation", sw.gears.Variation((sw.gears.Ripple(**k),))), order=1, depth=0.1, phase=0.3
    ),
    "LoadedError": call(
        lambda **k: sw.gears.LoadedError(**k).under(1.0), at_rest=ERRORS["KinematicError"], backward=None,
        per_torque=(1e-6,) * len(ERRORS["KinematicError"].lines),
    ),
    "Tuning": call(lambda **k: looped(sw.train.Tuning(**k)), **sw.train.Tuning(100.0)._asdict()),
    "MovingAverageFilter": call(
        lambda **k: looped(sw.train.Tuning(100.0, filters=(sw.train.MovingAverageFilter(**k),))), time=2e-3
    ),
    "read_specification": lambda: (sw.read_specification, {"path": written("wanted.yaml", WANTED)}),
    "read_gears": lambda: (sw.read_gears, {"path": written("gears.csv", GEARS)}),
    "largest": call(sw.sample.largest, "project", project=axis),
    "tabulated": call(sw.tabulated, points=[(-1.0, -2.0), (0.0, 0.0), (1.0, 2.0), (2.0, 5.0)], odd=False),
    "Drive": call(lambda **k: moved(sw.Drive(**k).error_equation(omega=100.0)), **sw.HDC_40_050._asdict()),
    "Drive.train": call(
        sw.HDC_40_050.train, motor_torque=sw.Harmonic(0.1), load_torque=sw.Harmonic(0.2),
        kinematic_error=ERRORS["KinematicError"], omega=100.0, control=LOOP, motor_drag=sw.laws.Viscous(0.1),
        load_drag=sw.laws.Viscous(0.1), reference=sw.train.Steady(),
    ),
    "Drive.error_equation": call(
        sw.HDC_40_050.error_equation, motor_torque=sw.Harmonic(0.1), load_torque=sw.Harmonic(0.2),
        kinematic_error=ERRORS["KinematicError"], omega=100.0, motor="free",
    ),
    "read_project": lambda: (sw.read_project, {"path": written("one.yaml", AXIS.replace("{name: CSG-40-50}", "CSG-40-50"))}),
    "project_text": lambda: (sw.project_text, {"source": train(), "omega": (100.0, 180.0), "title": "axis"}),
    "project_entry": call(sw.project_entry, model=sw.Cubic(1.0, 0.1)),
    "replaced": call(sw.replaced, "project", project=project, values={"load.inertia": "2 kg*m^2"}, retune=False),
    "replaced, of a model": call(sw.replaced, project=STRONG, values={"law.alpha": 0.2, "B": 0.1}),
    "load": lambda: (sw.load, {"path": moved(STRONG).save("motion.nc")}),
    "simulate": call(sw.simulate, system=STRONG, y0=(0.1, 0.0), t=0.5, method=QUICK),
    "simulate, times": call(sw.simulate, system=STRONG, y0=(0.1, 0.0), t=[0.0, 0.1, 0.3], method=sw.Dopri5(1e-6)),
    "Dopri5": call(
        lambda **k: sw.simulate(STRONG, (0.1, 0.0), 0.2, method=sw.Dopri5(**k)),
        rtol=1e-6, atol=1e-9, max_steps=1000, largest_step=0.1,
    ),
    "Rk4": call(lambda **k: sw.simulate(STRONG, (0.1, 0.0), 0.2, method=sw.Rk4(**k)), steps=8, steps_per_period=None),
    "Dop8": call(lambda **k: sw.simulate(STRONG, (0.1, 0.0), 0.2, method=sw.Dop8(**k)), steps=8, steps_per_period=None),
    "drive_run": call(
        sw.drive_run, "train", train=train, y0=(0.0, 0.0, 0.0, 0.0), t=0.001, gear=GEAR, method=sw.Dopri5(1e-4, 1e-7)
    ),
    "drive_motion": call(sw.drive_motion, "project", project=axis, omega=120.0, load=5.0),
    "run_up": call(sw.run_up, system=STRONG._replace(B=0.5), rates=[0.1], speeds=(0.9, 1.1)),
    "ensemble": call(
        sw.ensemble, system=STRONG, parameters={"B": [0.1, 0.2]}, y0=(0.0, 0.0), periods=1, settle=1,
        measures=(sw.Peak(), sw.Rms(), sw.Amplitude(1)), method=QUICK, threads=1,
    ),
    "Amplitude": call(
        lambda k: sw.ensemble(STRONG, {"B": [0.1]}, (0.0, 0.0), periods=1, measures=(sw.Amplitude(k),), method=QUICK), k=1
    ),
    "find_orbit": call(sw.find_orbit, system=DUFFING, harmonics=3, guess=None, period=1, throw=False),
    "frequency_response": call(
        sw.frequency_response, system=DUFFING, span=(1.0, 1.1), harmonics=3, period=1, points=10, throw=False
    ),
    "isolas": call(
        sw.isolas, system=DUFFING, span=(3.0, 3.1), resonance=sw.Resonance(1, 3), harmonics=3, points=2
    ),
    "basins": call(
        sw.basins, system=DUFFING, x_span=(-1.0, 1.0), v_span=(-1.0, 1.0), samples=1, seed=0, settle=1, longest=9,
        method=sw.Rk4(4), threads=1,
    ),
    "jumps": call(sw.jumps, "branch", branch=branch),
    "slow_flow": call(sw.slow_flow, system=DUFFING, resonance=sw.PRIMARY, order=1),
    "Resonance": call(lambda **k: sw.slow_flow(DUFFING, sw.Resonance(**k)), p=1, q=1),
    "lyapunov": call(sw.lyapunov, system=LIGHT, span=1.0, near=0.0),
    "small_signal": call(sw.small_signal, law=sw.Cubic(1.0, 0.1), mean_torque=0.1, amplitude=0.1),
    "bode": call(sw.bode, "train", train=train, omega=[1.0, 10.0], source="motor", amplitude=None, at=None, speed=0.0),
    "margins": call(sw.margins, "train", train=train, at=None, speed=0.0),
    "state_space": call(sw.state_space, train=LOOPED, at=None, speed=0.0),
    "speed_map": call(
        sw.speed_map, "project", project=axis, speeds=(100.0, 120.0), loads=[0.0], load_inertias=None, limit=3e-4,
        amplification=None, margin=None, orders=(), units=(), search=False, threads=1,
    ),
    "move": call(
        sw.move, "project", project=train, profile=sw.Trapezoid(0.01, 0.002), start=0.0, payload=None, gear=GEAR,
        limits=sw.MotorLimits(5.0, 500.0), window=1e-4, bands=[(1.0, 9.0)], tail=1e-3, method=sw.Dopri5(1e-3, 1e-5),
    ),
    "Trapezoid": call(
        lambda **k: shortly(sw.Trapezoid(**k)), angle=0.01, time=0.002, ramp=0.3, speed=0.0, acceleration=0.0
    ),
    "SCurve": call(
        lambda **k: shortly(sw.SCurve(**k)), angle=0.01, time=0.002, ramp=0.3, rounding=0.5, speed=0.0,
        acceleration=0.0, jerk=0.0,
    ),
    "AngleProfile": call(
        lambda **k: shortly(sw.AngleProfile(**k)), times=(0.0, 0.001, 0.002, 0.003), angles=(0.0, 0.001, 0.002, 0.002)
    ),
    "Dwell": call(lambda **k: shortly((sw.study.Dwell(**k), sw.Trapezoid(0.01, 0.002))), time=0.002),
    "Payload": call(
        lambda **k: sw.Payload(**k).on(TRAINS["free"]), mass=1.0, radius=0.1, inertia=0.0, phase=0.0, gravity=9.8
    ),
    "Feedforward": call(
        lambda **k: shortly(sw.Trapezoid(0.01, 0.002), feedforward=sw.Feedforward(**k)),
        acceleration=1.0, gravity=1.0, friction=1.0, speed=1.0,
    ),
    "MotorLimits": call(
        lambda **k: shortly(sw.Trapezoid(0.01, 0.002), limits=sw.MotorLimits(**k)),
        torque=5.0, speed=500.0,
    ),
    "read_frd": lambda: (
        sw.read_frd,
        {"path": written("b.csv", table(TIMES[1:], TIMES[1:], names=("frequency [Hz]", "size [dB]"))), "columns": None,
         "units": {"size": "dB"}, "quantity": "plant", "amplitude": 1.0, "estimator": "H1", "delimiter": ",", "decimal": "."},
    ),
    "read_profile": lambda: (
        sw.read_profile,
        {"path": written("p.csv", table(TIMES, TIMES, names=("time [s]", "angle [rad]"))), "delimiter": ",", "decimal": "."},
    ),
    "Specification": call(lambda **k: sw.design(sw.Specification(**k), gears=[GEAR]), **SPECIFICATION),
    "DutySegment": call(
        lambda **k: sw.design(sw.Specification(**BY_DUTY | {"duty": (sw.DutySegment(**k),)}), gears=[GEAR]),
        torque=20.0, speed=3.0, duration=1.0,
    ),
    "design": lambda: (sw.design, {"specification": sw.Specification(**SPECIFICATION), "gears": [GEAR]}),
    "design_text": lambda: (
        sw.design_text, {"specification": design().specification, "candidate": design().feasible[0]}
    ),
    "monitor": call(
        sw.monitor, time=TIMES, signal=np.cos(20.0 * TIMES), angle=10.0 * TIMES, orders=(2,), bandwidth=20.0,
        frequencies=None,
    ),
    "compensate": call(
        sw.compensate, "project", project=train, controller="inverse", speed=60.0, sampling=SAMPLING, loop=None,
        plant=None, robust=False, units=0, seed=1, load_angles=(0.0,),
    ),
    "prediction_table": call(
        sw.prediction_table, "project", project=project, orders=(2,), speeds=(100.0, 110.0), closed=False
    ),
    "compensation_bench": call(
        sw.study.compensation_bench, "project", project=train, controllers=("inverse",), speeds=(60.0,),
        sampling=SAMPLING, loop=None, plant=None, robust=False, load_angles=(0.0,),
    ),
    "speed_table": call(
        sw.study.speed_table, "project", project=project, speeds=[100.0, 150.0], table=None, direction=1
    ),
    "OrderTable": call(
        sw.OrderTable, lines=(sw.Line(2, 1e-4),), unit="rad", turn="motor", ratio=50.0, zero=0.0, sign="correction",
        direction="both", backward=None, mean=0.0, mean_backward=0.0, delay=0.0, speeds=None, load=None, source="x",
    ),
    "OrderTable.of": call(
        sw.OrderTable.of, error=sw.KinematicError((sw.Line(2, 1e-4),)), sign="error", ratio=50.0, zero=0.0, delay=0.0
    ),
    "export": call(
        sw.export, source=LOOPED, path="axis.c", to="c", step=1e-4, method=None, start=(0.0,) * 4
    ),
    "Run": call(lambda **k: sw.order_scan([sw.Run(**k)], orders=[2.0]), time=TIMES, angle=10.0 * TIMES,
                value=np.cos(20.0 * TIMES) + 0.1 * np.cos(7.7 * TIMES**2), unit="N*m"),
    "Log": call(
        lambda **k: sw.Log(**k).segments(), time=TIMES, channels={"motor_angle": 10.0 * TIMES}, units={}, notes=(), doubts=(),
    ),
    "read_log": lambda: (
        sw.read_log,
        {
            "path": written("log.csv", table(TIMES, 10.0 * TIMES, names=("time [s]", "motor_angle [rad]"))),
            "columns": {"motor_angle": 1}, "units": {"motor_angle": "rad"}, "rate": None, "ratio": 50.0, "trim": None,
            "unwrap": True, "delimiter": ",", "decimal": ".",
        },
    ),
    "read_scan": lambda: (
        sw.read_scan,
        {
            "path": written("scan.csv", table(TURN, 1e-4 * np.cos(2.0 * TURN), names=("angle [rad]", "error [rad]"))),
            "angle": "angle", "error": "error", "backward": None, "ate": False, "delimiter": ",", "decimal": ".",
            "reverse": False,
        },
    ),
    "order_scan": lambda: (
        sw.order_scan,
        {"runs": [sw.Run(TIMES, 10.0 * TIMES, np.cos(20.0 * TIMES) + 0.1 * np.cos(7.7 * TIMES**2), "rad")],
         "orders": [2.0], "ratio": 50.0, "highest": 10.0, "false_alarm": 0.01},
    ),
    "arrangement": call(
        sw.fit.arrangement, motor_counts=np.linspace(0.0, 9e6, 50), load_counts=np.linspace(0.0, 9e4, 50), per_turn=1000
    ),
    "amplitude_at": call(RESULTS["OrderScan"]().amplitude_at, order=4.0, speed=5.0, level=0.95),
    "error_scan": call(
        sw.error_scan, angle=TURN, error=1e-4 * np.cos(2.0 * TURN) + 1e-6 * np.cos(TURN**2), orders=[1, 2],
        backward=None, highest=None, false_alarm=0.01, drift=True, noise="auto", ate=False,
    ),
    "fit_loop": lambda: (
        sw.fit_loop,
        {"torsion": 2e-3 * np.sin(np.linspace(0.0, 4.0 * np.pi, 120)),
         "torque": sw.PiecewiseLinear(3e4, 5e4, 6e4, 14.0, 48.0).torque(2e-3 * np.sin(np.linspace(0, 4 * np.pi, 120))),
         "rated_torque": 90.0, "ratio": 50.0, "check_units": True},
    ),
    "fit_decay": lambda: (
        sw.fit_decay,
        {"time": decay()[0], "value": decay()[1], "system": LIGHT._replace(law=sw.Linear(1.1)), "free": ("B", "law.K")},
    ),
    "identify": lambda: (
        sw.identify,
        {"system": sw.Oscillator(1.0, 0.12, sw.Linear(1.1), sw.Harmonic(0.0), 1.0), "log": log(), "free": ("law.K",),
         "inputs": None, "outputs": None, "between": "linear", "steps": 1},
    ),
    "compare_laws": lambda: (
        sw.fit.compare_laws,
        {"candidates": {"linear": (sw.Oscillator(1.0, 0.12, sw.Linear(1.1), sw.Harmonic(0.0), 1.0), ("law.K",))},
         "log": log(400), "held_out": 0.25},
    ),
    "identify_drive": call(
        sw.identify_drive, "project", project=project, log={"time": TIMES, "motor_angle": 10.0 * TIMES, "load_angle": 0.2 * TIMES},
        free=("gear.K1",), between="linear",
    ),
    "hysteresis_loop": call(sw.hysteresis_loop, law=CURVE, torque=20.0, speed=1e-9, rtol=1e-4),
    "lost_motion": call(sw.study.lost_motion, law=CURVE, rated_torque=87.0, share=0.04, speed=1e-9),
    "fit_hysteresis": call(
        sw.fit.fit_hysteresis, spring=GEAR.law, hysteresis_loss=1e-4, lost_motion=None, rated_torque=100.0, load=None,
        replace_spring=False, n=1, tolerance=0.05,
    ),
    "sweep": call(
        sw.sweep, measure=lambda q: {"x": q.B}, system=STRONG, grid={"B": [0.1, 0.2]}, store=None, client=None, workers=1,
        processes=False, chunk=None, seed=0, units=None,
    ),
    "EnsembleMeasure": call(
        lambda **k: sw.sweep(sw.EnsembleMeasure(**k), STRONG, {"B": [0.1, 0.2]}, workers=1), y0=(0.0, 0.0), periods=1,
        measures=(sw.Peak(),), settle=1, method=QUICK,
    ),
    "LatinHypercube": call(
        lambda **k: sw.sweep(lambda q: {"x": q.B}, STRONG, sw.sample.LatinHypercube(**k), workers=1), count=3, distributions=SCATTER, seed=0
    ),
    "Sobol": call(
        lambda **k: sw.sweep(lambda q: {"x": q.B}, STRONG, sw.sample.Sobol(**k), workers=1), count=4, distributions=SCATTER, seed=0
    ),
    "Normal": call(lambda **k: drawn(sw.Normal(**k)), mean=0.1, deviation=0.01, low=0.05, high=0.2),
    "Uniform": call(lambda **k: drawn(sw.Uniform(**k)), low=0.1, high=0.2),
    "LogUniform": call(lambda **k: drawn(sw.sample.LogUniform(**k)), low=0.1, high=0.2),
    "compare": lambda: (sw.compare, {"projects": [axis(), axis()]}),
    "exceedance": call(sw.exceedance, "project", project=project, count=32, seed=0, limit=3e-4, retune=False),
    "scattered": call(
        lambda **k: list(sw.sample.scattered(**k)), "project", project=project, count=2, seed=0, retune=False
    ),
    "draw": call(sw.draw, "result", result=branch, axes=None),
    "from_bandwidth": call(
        sw.train.from_bandwidth, bandwidth=100.0, inertia=1e-3, damping=0.7, kind="position", lag=0.0
    ),
    "accuracy_spectrum": call(sw.gears.accuracy_spectrum, accuracy=1e-3, shares={1: 0.25, 2: 1.0}, phases=None),
    "peak_to_peak": call(sw.gears.peak_to_peak, error=ERRORS["KinematicError"]),
    "fit_odd": call(sw.gears.fit_odd, law=GEAR.law, reach=1e-3, degree=3),
    "check_limits": call(
        sw.gears.check_limits, gear=GEAR, peak_torque=100.0, average_torque=20.0, max_speed=100.0, average_speed=50.0
    ),
    "cubic_mean": call(sw.gears.cubic_mean, torque=[1.0, 2.0], weights=[1.0, 1.0]),
    "load_friction": call(sw.gears.load_friction, efficiency=0.7, torque=100.0, ratio=50.0, running_torque=0.1),
    "no_load_drag": call(sw.gears.no_load_drag, running_torque=0.1, starting_torque=0.05, speed=200.0),
    "bearing_life": call(sw.gears.bearing_life, gear=GEAR, average_torque=20.0, average_speed=100.0),
    "on_output_turn": call(sw.gears.on_output_turn, excitation=ERRORS["KinematicError"], N=50.0),
    "order_map": call(sw.gears.order_map, N=50.0, arrangement=sw.gears.Arrangement("flexspline", "circular spline"), cogging=12),
    "Arrangement": call(
        lambda **k: sw.gears.Arrangement(**k).ratio(50.0), fixed="flexspline", output="circular spline"
    ),
    "Arrangement.ratio": call(sw.gears.Arrangement().ratio, N=50.0),
    "Arrangement.teeth": call(sw.gears.Arrangement().teeth, ratio=50.0),
    "Arrangement.torques": call(sw.gears.Arrangement().torques, N=50.0),
    "Arrangement.turn": call(sw.gears.Arrangement().turn, member="flexspline"),
    "Arrangement.lobes": call(sw.gears.Arrangement().lobes, spline="flexspline", times=2),
    "derive_arrangement": call(sw.theory.derive_arrangement, arrangement=sw.gears.Arrangement()),
    "Posture": call(lambda **k: sw.Posture(**k).on(axis()).system(120.0), inertia=2.0, torque=-5.0, coupling=None, name="out"),
    "Link": call(
        lambda **k: sw.study.two_link(sw.study.Link(**k), sw.study.Link(**LINK), [(0.0, 1.0)])[0].on(axis()), **LINK
    ),
    "Link.rod": call(sw.study.Link.rod, mass=8.0, length=0.4),
    "two_link": call(
        sw.study.two_link, first=sw.study.Link(**LINK), second=sw.study.Link(**LINK), angles=[(0.0, 1.0), (1.0, 0.5)],
        joint=1, payload=3.0, gravity=9.8,
    ),
    "read_postures": lambda: (sw.read_postures, {"path": written("postures.csv", POSTURES)}),
    "move_postures": call(
        sw.move_postures, "project", project=project, profile=sw.Trapezoid(0.01, 0.002), postures=(sw.Posture(2.0, -5.0),),
        tail=1e-3, method=sw.Dopri5(1e-3, 1e-5),
    ),
    "tune": call(
        sw.tune, "project", project=project, goals=("compliance",), gains=("K_p",), peak_sensitivity=2.0, gain_margin=1.5,
        phase_margin=0.5, loads=(0.0,), units=(), share=1.0, delay=1e-3, notch=False,
    ),
    "read_project, two turns": lambda: (sw.read_project, {"path": written("two.yaml", TWO_TURNS)}),
    "Project.response, two turns": lambda: (
        beating().response, {"harmonics": None, "points": 10, "coexisting": False}
    ),
    "speed_map, two turns": call(
        sw.speed_map, "project", project=beating, speeds=(120.0, 125.0), loads=[0.0], load_inertias=None, limit=3e-4,
        amplification=None, margin=None, orders=(), units=(), search=False, threads=1,
    ),
    "static_sources": call(sw.gears.static_sources, N=50.0),
    "catalogue.gear": call(sw.catalogue.gear, name="CSG-40-50"),
    "Gear.drive": call(GEAR.drive, load_inertia=1.3, motor_inertia=4.5e-4, B=20.0),
    "discrepancy": call(
        sw.fit.discrepancy, residual=np.cos(NUMBERS**7), jacobian=np.vander(NUMBERS, 2), candidates=None, records=None,
        interval=1.0,
    ),
    "unidentifiable": call(
        sw.fit.unidentifiable, jacobian=np.vander(NUMBERS, 2), names=("a", "b"), values=[1.0, 2.0], tolerance=1e-6
    ),
    "bootstrap": call(
        sw.fit.bootstrap, jacobian=np.vander(NUMBERS, 2), residual=np.cos(NUMBERS**7), records=None, block=4, draws=10,
        seed=0,
    ),
    "sandwich": call(
        sw.fit.sandwich, jacobian=np.vander(NUMBERS, 2), residual=np.cos(NUMBERS**7), records=None
    ),
    "spread": call(sw.fit.spread, jacobian=np.vander(NUMBERS, 2), residual=np.cos(NUMBERS**7), records=None),
    "standstill": call(sw.study.standstill, project=LOOPED),
    "fit_bode": call(
        sw.fit.fit_bode, measured=RESULTS["MeasuredBode"](), project=LOOPED, free=("J_m",), speed=0.0
    ),
    "measured_bode": call(
        sw.fit.measured_bode, omega=TIMES[1:], value=1.0 / TIMES[1:], quantity="plant", phased=True, deviation=None,
        amplitude=1.0, estimator="H1", notes=(),
    ),
    "bode_of_records": call(
        sw.fit.bode_of_records, time=TIMES, reference=SWEEP, torque=np.roll(SWEEP, 2), speed=np.roll(SWEEP, 3),
        held=True, amplitude=1.0, notes=(),
    ),
    "backbone": call(sw.numerics.backbone, system=DUFFING, amplitudes=[0.1, 1.0], harmonics=3),
    "parameter_response": call(
        sw.numerics.parameter_response, system=DUFFING, path="B", span=(0.05, 0.06), harmonics=3, period=1, start=None,
        points=10, throw=False,
    ),
    "response_family": call(
        sw.numerics.response_family, system=DUFFING, span=(0.6, 0.7), parameters={"B": [0.1]}, harmonics=3, points=10,
        threads=1,
    ),
    "switch_branch": lambda: (
        sw.numerics.switch_branch,
        {"system": STRONG, "orbit": curve().folds[0], "span": (1.0, 1.4), "parameter": "omega", "harmonics": 3,
         "points": 10},
    ),
    "loop_response": call(sw.numerics.loop_response, loop=CLOSED, omega=[10.0], at=None, steps=1, output=None),
    "loop_ensemble": call(
        sw.numerics.loop_ensemble, loop=CLOSED, varied={"controller.K_p": [10.0]}, duration=4e-3, settle=2e-3, orders=(2.0,),
        y0=None, steps=1, threads=1,
    ),
    "run_loop": call(sw.numerics.run_loop, loop=CLOSED, duration=4e-3, y0=None, every=1, steps=1, unit=0),
    "shoot": call(sw.numerics.shoot, system=STRONG, y0=(0.0, 0.0), period=1, rtol=1e-4, throw=False),
    "operating_state": call(sw.study.operating_state, "train", train=train, speed=100.0, near=(), angle=0.0),
    "hardening": call(sw.study.hardening, system=DUFFING, alpha=[0.1], span=(0.2, 1.3), speeds=[0.65], harmonics=3),
    "compare_with_integration": call(
        sw.study.compare_with_integration, system=DUFFING, resonance=sw.PRIMARY, y0=(0.0, 0.0), t_end=40.0, multiples=(1,)
    ),
    "efficiency": call(sw.study.efficiency, "train", train=train, torque=[10.0], speed=[100.0]),
    "energy_balance": call(sw.study.energy_balance, system=STRONG, start=(0.0, 0.0), duration=1.0, rtol=1e-6),
    "parametric_resonances": call(
        sw.study.parametric_resonances,
        system=sw.gears.VaryingOscillator(
            1.0, sw.gears.GearDamping(0.05), sw.Cubic(1.0, 0.1), sw.Harmonic(0.1), 1.2, variation=VARIATIONS["Variation"]
        ),
        span=(0.9, 1.0),
    ),
    "error_parts": call(sw.study.error_parts, "system", system=lambda: DUFFING._replace(error=ERRORS["KinematicError"]), orbit=None),
    "two_turn_motion": call(sw.study.two_turn_motion, "system", system=lambda: DUFFING._replace(error=ERRORS["KinematicError"]), omega=1.3, ratio=50.0, start=None),
    "two_turn_response": call(sw.study.two_turn_response, "system", system=lambda: DUFFING._replace(error=ERRORS["KinematicError"]), speeds=(1.3, 1.4), ratio=50.0),
    "Project.response": lambda: (project().response, {"points": 10, "harmonics": 3, "coexisting": False}),
    "Project.under": lambda: (axis().under, {"torque": 5.0}),
    "Project.system": lambda: (axis().system, {"omega": 120.0}),
    "Project.with_load_inertia": lambda: (axis().with_load_inertia, {"J_l": 2.0}),
}  # fmt: skip


def drawn(distribution):
    """A few drives with a number that is drawn."""
    return sw.sweep(lambda q: {"x": q.B}, STRONG, sw.sample.LatinHypercube(3, {"B": distribution}), workers=1)


def method_calls():
    """Calls of the methods of results."""
    rows = {
        "Orbit": {"amplitude": {"k": 1}, "state": {"phase": 0.1}},
        "Branch": {"amplitude": {"k": 1}},
        "Trajectory": {"peak": {"component": 0, "after": 0.0}, "save": {"path": "a.nc"}, "plot": {"axes": None}},
        "DecayFit": {"interval": {"path": "B", "level": 0.9}, "value": {"path": "B"}, "deviation": {"path": "B"}},
        "OrderScan": {"delay_interval": {"level": 0.9}, "line": {"order": 4.0},
                      "predict": {"time": TIMES, "angle": 10.0 * TIMES}},
        "Hardening": {"best": {"weights": (1.0,)}},
        "Bode": {"decibels": {"shaft": "motor"}, "degrees": {"shaft": "motor"}},
        "StateSpace": {"response": {"omega": [1.0, 2.0]}},
        "DriveRun": {"efficiency": {"after": 0.0}, "lost": {"after": 0.0}, "speed_ripple": {"after": 0.0}},
        "LoopRun": {"rms": {"settle": 0.0}},
        "Units": {"quantiles": {"shares": (0.5,)}},
        "CompensationBench": {"best": {"load_encoder": True}, "residuals": {"width": 80}},
        "PredictionTable": {"at": {"speed": 1.0, "direction": 1, "closed": False}},
        "SpeedMap": {"is_allowed": {"speed": 120.0, "load": 0.0}},
        "Exceedance": {"ends": {"level": 0.95}},
        "Log": {"channel": {"name": "hall"}, "cut": {"start": 0.0, "stop": 0.2}, "segments": {"tolerance": 0.1},
                "run": {"channel": "load_angle", "angle": "hall", "part": None}},
        "Identified": {"simulate": {"inputs": {"time": [0.0, 0.1], "input": [0.0, 0.0]}, "start": (0.0, 0.0)}},
    }  # fmt: skip
    flow = sw.slow_flow(DUFFING, sw.PRIMARY)
    proof = sw.lyapunov(LIGHT)
    others = {
        "SlowFlow.response": (flow.response, {"band": (0.9, 1.4)}),
        "SlowFlow.states_at": (flow.states_at, {"omega": 1.1}),
        "SlowFlow.backbone": (flow.backbone, {"amplitudes": [0.1, 0.2]}),
        "SlowFlow.evolve": (flow.evolve, {"y0": (0.1, 0.0), "t": [0.0, 1.0]}),
        "SlowFlow.x": (flow.x, {"t": [0.0, 1.0], "y0": (0.1, 0.0)}),
        "StabilityProof.V": (proof.V, {"x": 0.1, "v": 0.1, "phase": 0.0}),
        "StabilityProof.contains": (proof.contains, {"x": 0.1, "v": 0.1, "phase": 0.0}),
    }
    return {
        f"{name}.{method}": lambda name=name, method=method, arguments=arguments: (
            getattr(RESULTS[name](), method), arguments
        )
        for name, methods in rows.items()
        for method, arguments in methods.items()
    } | {name: lambda row=row: row for name, row in others.items()}  # fmt: skip


CALLS |= method_calls()
