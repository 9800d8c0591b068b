"""One instance of every class of results that can be saved, small enough for the interpreter; import costs nothing."""

from functools import cache
from pathlib import Path

import numpy as np

import strainwave as sw
from strainwave.drive.drive_response import DriveResponse
from strainwave.drive.response import of_equation
from strainwave.files.reading import from_text

DUFFING = sw.Oscillator(J=1.0, B=0.05, law=sw.Cubic(1.0, 0.1), excitation=sw.Harmonic(0.18), omega=1.2)
CURVE = sw.Parallel(sw.Linear(7160.0), sw.BoucWen(900.0, 0.0, 8e-5))

LOOPED = sw.HDC_40_050.train(control=sw.train.SpeedLoop(0.5, 20.0))
NUMBERS = np.linspace(0.9, 1.1, 33)


@cache
def branch():
    return sw.frequency_response(DUFFING, (0.9, 1.4), harmonics=5)


@cache
def drive():
    return of_equation(DUFFING, branch())


@cache
def run():
    train = sw.HDC_40_050._replace(law=CURVE).train(
        control=sw.train.SpeedLoop(0.5, 20.0), kinematic_error=sw.KinematicError((sw.Line(2, 1e-4),)), omega=150.0
    )
    gear = sw.catalogue.gear("CSG-40-50")
    return sw.drive_run(train, t=np.linspace(0.0, 0.01, 21), method=sw.Dopri5(rtol=1e-6), gear=gear)


@cache
def move():
    train = sw.HDC_40_050.train(control=sw.train.Held(), kinematic_error=sw.KinematicError((sw.Line(2, 1e-4),)))
    part, gear = sw.Trapezoid(0.02, 0.01), sw.catalogue.gear("CSG-40-50")
    return sw.move(train, part, gear=gear, bands=[(1.0, 9.0)], tail=1e-3, method=sw.Dopri5(rtol=1e-4, atol=1e-6))


@cache
def identified():
    t = 0.1 * np.arange(120)
    u, wave = np.cos(0.8 * t), np.sin(0.8 * t)  # of x'' + .1 x' + 1.2 x = u
    x = (0.56 * u + 0.08 * wave) / (0.56**2 + 0.08**2)
    guess = sw.Oscillator(J=1.0, B=0.12, law=sw.Linear(1.1), excitation=sw.Harmonic(0.0), omega=1.0)
    log = {"time": t, "input": u, "output": x + 1e-3 * np.cos(7.0 * t)}
    return sw.identify(guess, log, ("B", "law.K"), between="linear", steps=1)


@cache
def order_scan():
    t = 0.01 * np.arange(400)
    runs = [sw.Run(t, w * t, np.cos(4.0 * w * t) + 0.1 * np.cos(7.7 * t), "N*m") for w in (3.0, 5.0)]
    return sw.order_scan(runs, orders=[4.0])


def axis():
    text = (
        "gear: {ratio: 50, law: {type: linear, K: 1e5 N*m/rad}}\nmotor: {inertia: 4.5 kg*cm^2}\n"
        "load: {inertia: 1.3 kg*m^2}\ndamping: {ratio: 3 %}\nspeed: {from: 100 rad/s, to: 180 rad/s, shaft: motor}\n"
        "excitation: {kinematic_error: [{order: 2, amplitude: 23 arcsec}]}\n"
    )
    return from_text(text, Path("axis.yaml"))


@cache
def measured_bode():
    omega = np.geomspace(10.0, 1000.0, 20)
    return sw.fit.measured_bode(omega, 1.0 / (1j * omega * 5e-4), deviation=0.1 / omega, amplitude=1.0)


@cache
def design():
    spec = sw.Specification(
        load_inertias=(1.3,), speeds=(1.0, 3.0), limit=1e-3, rotor_inertias=(1e-4, 1e-3), damping_ratio=0.1
    )
    return sw.design(spec, gears=[sw.catalogue.gear("CSG-40-50"), sw.catalogue.gear("CSG-20-100")])


CLOSED = sw.controllers.ClosedLoop(
    sw.HDC_40_050.train(
        control=sw.train.Commanded(), kinematic_error=sw.KinematicError((sw.Line(2, 1e-4),)), omega=150.0
    ),
    sw.controllers.SampledPD(10.0, 0.1, 1e-3),
    sw.controllers.Sampling(1e-3, 1e-3),
)


@cache
def loops():
    return sw.numerics.loop_ensemble(CLOSED, {"controller.K_p": [10.0, 20.0]}, 0.01, settle=4e-3, orders=[2.0])


@cache
def compensation():
    one = sw.results.Residual(1e-4, 2e-4, 3e-4, 1e-5)
    return sw.results.Compensation(
        name="adaptive",
        title="adaptive cancellation",
        speed=150.0,
        before=one,
        after=one._replace(rms=1e-6),
        torque=sw.results.TorqueUse(0.1, 0.3, 0.0),
        torque_before=sw.results.TorqueUse(0.1, 0.2, 0.0),
        gear_torque=20.0,
        orders=np.array([2.0, 4.0]),
        amplitude_before=np.array([1e-4, 1e-5]),
        amplitude_after=np.array([1e-6, 2e-6]),
        robustness=(sw.results.Robustness(-0.2, 1e-4, 2e-6),),
        stable=True,
        condition="It converges.",
        load_encoder=True,
        excluded="",
        units=units(),
        controller=CLOSED.controller,
        warnings=(),
        remarks=("Assumed.",),
    )


def units():
    return sw.results.Units(loops(), loops(), np.array([0.9, 1.1]), np.array([1.2, 0.8]), ((1, "its phase is off"),))


@cache
def loop_fit():
    way = 2e-3 * np.sin(np.linspace(0.0, 4.0 * np.pi, 200))
    return sw.fit_loop(way, sw.PiecewiseLinear(3e4, 5e4, 6e4, 14.0, 48.0).torque(way), rated_torque=90.0)


RESULTS = {
    name: cache(make)  # each is computed once
    for name, make in {
        "Trajectory": lambda: sw.simulate(DUFFING, (0.1, 0.0), np.linspace(0.0, 3.0, 11)),
        "Orbit": lambda: branch().folds[0],
        "Branch": branch,
        "Jumps": lambda: sw.jumps(branch()),
        "DriveResponse without torques": lambda: DriveResponse(branch(), sw.jumps(branch())),
        "DriveResponse": drive,
        "SlowResponse": lambda: sw.slow_flow(DUFFING, sw.PRIMARY).response((0.9, 1.4)),
        "StatesAtSpeeds": lambda: sw.slow_flow(DUFFING, sw.PRIMARY).states_at(NUMBERS),
        "SlowResponse without states": lambda: sw.slow_flow(DUFFING, sw.SUBHARMONIC).response((0.9, 1.4)),
        "StabilityProof": lambda: sw.lyapunov(DUFFING),
        "Hardening": lambda: sw.study.hardening(DUFFING, [0.0, 0.1], (0.2, 1.6), speeds=[1.1]),
        "RunUps": lambda: sw.results.RunUps(
            NUMBERS, np.array([NUMBERS, 0.5 * NUMBERS]) * 1e-4, np.array([NUMBERS, NUMBERS]), (0.5, 2.0), "error x"
        ),
        "LoopFit": loop_fit,
        "DriveRun": run,
        "Move": move,
        "Bode": lambda: sw.bode(
            sw.HDC_40_050.train(control=sw.train.PositionLoop(50.0, 0.5)), np.geomspace(1.0, 1e3, 7)
        ),
        "StateSpace": lambda: sw.state_space(LOOPED),
        "Margins": lambda: sw.margins(LOOPED),
        "SpeedMap": lambda: sw.speed_map(axis(), speeds=(100.0, 180.0), loads=[-20.0, 0.0], search=False),
        "Design": design,
        "DriveMotion": lambda: sw.drive_motion(axis(), 120.0),
        "ProjectComparison": lambda: sw.compare([axis(), axis()]),
        "Exceedance": lambda: sw.results.Exceedance(
            1e-4, {"load.inertia": NUMBERS}, 1e-4 * NUMBERS, *[90.0 * NUMBERS] * 3, 1, None, ()
        ),
        "Log": lambda: sw.Log(
            0.01 * np.arange(50),
            {"load_angle": np.sin(0.1 * np.arange(50)), "hall": np.arange(50.0)},
            {"hall": "V"},
            ("Read.",),
            ("Strange.",),
        ),
        "LoopRun": lambda: sw.numerics.run_loop(CLOSED, 0.01),
        "LoopEnsemble": loops,
        "LoopResponse": lambda: sw.numerics.loop_response(CLOSED, [10.0, 20.0, 40.0]),
        "Units": units,
        "Compensation": compensation,
        "Monitored": lambda: sw.monitor(
            0.01 * np.arange(50), np.cos(2.0 * 0.1 * np.arange(50)), angle=0.1 * np.arange(50), bandwidth=20.0
        ),
        "PredictionTable": lambda: sw.results.PredictionTable(
            NUMBERS,
            np.array([2, 4]),
            np.array([NUMBERS, 0.5j * NUMBERS]) * 1e-4,
            NUMBERS < 1.05,
            (1.0,),
            (0.9,),
            np.array([NUMBERS, 0.4j * NUMBERS]) * 1e-4,
            NUMBERS < 1.02,
            ("Assumed.",),
        ),
        "Identified": identified,
        "LawComparison": lambda: sw.results.LawComparison(
            ("linear",), np.array([2.0]), np.array([1e-3]), np.array([1.1e-3]), (identified(),)
        ),
        "OrderScan": order_scan,
        "MeasuredBode": measured_bode,
        "Standstill": lambda: sw.study.standstill(LOOPED),
        "BodeFit": lambda: sw.fit.fit_bode(measured_bode(), LOOPED, free=("J_m", "gain")),
        "CompensationBench": lambda: sw.results.CompensationBench(
            np.array([150.0]), ("adaptive",), ((compensation(),),)
        ),
    }.items()
}
WITHOUT_FIGURE = (
    "LawComparison",
    "DriveMotion",
    "Hardening",
    "StatesAtSpeeds",
    "StateSpace",
    "Standstill",
    "Margins",
    "Exceedance",
    "ProjectComparison",
)
