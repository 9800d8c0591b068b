"""Integration, periodic orbits, curves, attractors, ensembles, sampled loops."""

import numpy as np

import strainwave as sw

from .drives import (
    BIASED,
    CLOSED,
    DRIVE,
    DUFFING,
    ERROR,
    EXACT,
    GEAR,
    INTEGRATED,
    SYSTEMS,
    answer,
    projects,
    trains,
)

SPANS = {
    "cubic": (0.5, 1.6), "biased": (1.9, 2.6), "softening": (0.8, 1.8), "polynomial": (0.4, 1.6),
    "piecewise": (100.0, 200.0), "rounded": (100.0, 200.0), "backlash": (0.4, 1.2), "play": (0.6, 1.6),
    "Bouc-Wen": (200.0, 400.0), "Coulomb": (0.7, 1.6), "LuGre": (0.7, 1.6), "varying": (120.0, 180.0),
}  # fmt: skip
KINKED = (
    1e-5  # the rate of a law with memory has a corner, across which no step of the variational flow keeps its order
)
NEAR_FOLD = 1e-8  # the square root of 1e-16 limits what is found at a turning point


def start(system, size=1.0):
    """States at the begin: a torsion of the law's scale, at rest."""
    states = len(system.state_names())
    large = abs(system.law.stiffness(0.0) if not hasattr(system.law, "z_rate") else 0.0) < 100.0
    return np.eye(states)[0] * (0.3 * size if large else 1e-4 * size)


def orbit_numbers(orbit):
    """Numbers of an orbit that do not depend on how it was found: no phase of a tiny harmonic, no step."""
    found = {
        "omega": orbit.omega,
        "peak": orbit.peak,
        "mean and 1..4": np.array([orbit.amplitude(k) for k in range(5)]),
    }
    words = {"stable": orbit.stable, "status": orbit.status, "label": orbit.label, "period": orbit.period}
    return found | words


def moduli(orbit):
    """Sizes of the two largest Floquet multipliers, which the variational flow gives."""
    return np.sort(np.abs(orbit.multipliers))[::-1][:2]


def curve_numbers(branch):
    """Special points of a curve, its ends, and words; its points lie where the steps fell."""
    special = {name: getattr(branch, name) for name in ("folds", "doublings", "branch_points", "tori", "elsewhere")}
    found = {f"{name}/{i}": [o.value, o.peak, o.amplitude(1)] for name, os in special.items() for i, o in enumerate(os)}
    counts = {name: len(os) for name, os in special.items()} | {"closed": branch.closed, "status": branch.status}
    ends = np.argsort(branch.values)[[0, -1]]
    return found | counts | {"ends": branch.peak[ends] if not branch.closed else None}


def simulate():
    """Motions in time of every system and train, by every method."""
    for name, system in SYSTEMS.items():
        run = sw.simulate(system, start(system), np.linspace(0.0, 20.0 * np.pi / system.omega, 4))
        yield name, [run.y[:, 1:], run.peak(), run.status], INTEGRATED
    for name, method, error in (("dop8", sw.Dop8(200), CLOSED), ("rk4", sw.Rk4(400), CLOSED)):
        run = sw.simulate(DUFFING, (0.3, 0.0), 30.0, method=method)
        yield name, [run.y[:, -1], run.peak()], error
    for name, train in trains().items():
        size = np.zeros(len(train.state_names()))
        run = sw.simulate(train, size, np.linspace(0.0, 0.2, 3))
        yield f"train/{name}", [run.y[:, 1:], run.status], INTEGRATED


def find_orbit():
    """Periodic orbits of every system and train by harmonic balance."""
    for name, system in SYSTEMS.items():
        orbit, with_memory = sw.find_orbit(system), hasattr(system.law, "z_rate")
        yield name, orbit_numbers(orbit), INTEGRATED if with_memory else CLOSED
        yield f"{name}/multipliers", moduli(orbit), KINKED if with_memory else INTEGRATED
        yield f"{name}/rough", orbit_numbers(sw.find_orbit(system, harmonics=4)), CLOSED
    for name, train in trains().items():
        orbit = answer(lambda train=train: sw.find_orbit(train, harmonics=8))
        yield f"train/{name}", orbit if isinstance(orbit, str) else orbit_numbers(orbit), CLOSED
        if not isinstance(orbit, str):
            yield f"train/{name}/multipliers", moduli(orbit), KINKED if name == "hysteresis" else INTEGRATED


def shoot():
    """The same orbits by shooting."""
    for name in ("cubic", "softening", "piecewise", "backlash", "Bouc-Wen", "varying"):
        system = SYSTEMS[name]
        settled = sw.simulate(system, start(system), [0.0, 200.0 * np.pi / system.omega]).y[:, -1]
        orbit = sw.numerics.shoot(system, settled)
        yield name, [orbit_numbers(orbit), moduli(orbit)], INTEGRATED


def frequency_response():
    """Curves over the speed, and what a slow run-up and run-down do on them."""
    for name, system in SYSTEMS.items():
        branch = sw.frequency_response(system, SPANS[name])
        yield name, curve_numbers(branch), NEAR_FOLD
        found = sw.jumps(branch)
        yield f"{name}/jumps", [found.jump_up, found.jump_down, found.width, len(found.bands)], NEAR_FOLD
        yield f"{name}/ways", [found.finished_up, found.finished_down], EXACT
    family = sw.numerics.response_family(DUFFING, (0.8, 1.6), {"law.alpha": [0.05, 0.1], "B": [0.05, 0.08]})
    yield "family", [curve_numbers(branch) for branch in family], NEAR_FOLD


def parameter_response():
    """Curves over another parameter, isolas, switched branches, backbones."""
    branch = sw.numerics.parameter_response(DUFFING, "excitation.amplitude", (0.0, 0.5))
    yield "amplitude", curve_numbers(branch), NEAR_FOLD
    driven = sw.Oscillator(1.0, 0.01, sw.Cubic(1.0, 0.2), sw.Harmonic(2.0), 3.15)
    yield "isolas", [curve_numbers(loop) for loop in sw.isolas(driven, (3.0, 10.0))], NEAR_FOLD
    main = sw.frequency_response(BIASED, (1.9, 2.6))
    yield "switch_branch", curve_numbers(sw.numerics.switch_branch(BIASED, main.doublings[0])), 1e-6
    for name in ("cubic", "piecewise", "backlash"):
        sizes = [0.6, 1.0, 2.0] if name != "piecewise" else [3e-4, 1e-3, 2e-3]
        free = sw.numerics.backbone(SYSTEMS[name], sizes)
        yield f"backbone/{name}", [free.omega, free.peak], CLOSED
    one_line = sw.KinematicError(ERROR.lines[:1])
    gear = SYSTEMS["piecewise"]._replace(law=GEAR.cubic, error=one_line)
    found = sw.study.hardening(gear, [0.0, 6.85e4, 1.37e5], (30.0, 250.0), speeds=[126.0, 147.0])
    yield "hardening", [found.peak, found.peak_speed, found.at_speeds, found.best()], 1e-6  # the peak of a curve


def attractors():
    """Attractors and basins."""
    wells = sw.Oscillator(1.0, 0.15, sw.Cubic(-1.0, -1.0), sw.Harmonic(0.2), 1.0)
    found = sw.basins(wells, (-2.2, 2.2), (-2.2, 2.2), samples=500)
    yield "basins", [found.fractions, found.standard_errors], EXACT
    yield "basins/attractors", [(a.period, a.amplitude, a.peak) for a in found.attractors], 1e-6  # until it settles


MEASURES = (
    sw.Peak(),
    sw.Rms(),
    sw.numerics.Mean(),
    sw.numerics.Extremes(),
    sw.Final(),
    sw.Amplitude(1),
)


def ensemble():
    """Variants side by side, to the bit."""
    for name in ("cubic", "piecewise", "backlash", "Bouc-Wen", "Coulomb", "varying"):
        system = SYSTEMS[name]
        lanes = {"omega": system.omega * np.array([0.8, 1.0, 1.1])}
        found = sw.ensemble(system, lanes, start(system), periods=4, settle=50, measures=MEASURES)
        yield name, found, EXACT
    found = sw.ensemble(
        DUFFING, {"law.alpha": np.linspace(0.0, 0.2, 9), "B": np.linspace(0.04, 0.08, 9)}, (0.0, 0.0), periods=4,
        settle=100, method=sw.Dopri5(),
    )  # fmt: skip
    yield "adaptive", found, EXACT


def sampled():
    """Sampled loops: a run, an ensemble, their linear response; shaped references; monitors."""
    train = DRIVE.train(control=sw.train.Commanded(), kinematic_error=ERROR, omega=150.0)
    sampling = sw.controllers.Sampling(1e-3, 1e-3, limit=3.0, motor_quantum=1e-5, load_noise=1e-6)
    loops = {
        "pd": sw.controllers.SampledPD(10.0, 0.1, 1e-3),
        "cascade": sw.controllers.Cascade(20.0, 0.1, 1.0, 1e-3, 4.5e-4),
        "notch": sw.controllers.notch(sw.controllers.SampledPD(10.0, 0.1, 1e-3), 400.0, 1e-3),
    }
    for name, controller in loops.items():
        closed = sw.controllers.ClosedLoop(train, controller, sampling)
        run = sw.numerics.run_loop(closed, 0.2)
        yield f"run/{name}", {key: value for key, (_, value, _) in run.variables().items()}, 1e-6  # steps of encoders
    quiet = sw.controllers.ClosedLoop(train, loops["pd"], sw.controllers.Sampling(1e-3, 1e-3))
    lanes = sw.numerics.loop_ensemble(quiet, {"controller.K_p": [10.0, 20.0]}, 0.2, settle=0.1, orders=[2.0])
    yield "ensemble", {key: value for key, (_, value, _) in lanes.variables().items()}, EXACT
    response = sw.numerics.loop_response(quiet, [10.0, 50.0, 200.0])
    values = {key: value for key, (_, value, _) in response.variables().items()}
    yield "response", [values, response.stable, response.slowest], INTEGRATED
    t = 1e-3 * np.arange(4000)
    angle = (20.0 + 0.5 * t) * t
    signal = 23.0 * np.cos(2 * angle + 0.5) + 4.0 * np.cos(4 * angle) + np.cos(7.7 * t)
    for name, options in (
        ("known", {"angle": angle, "orders": (2, 4)}), ("tracked", {"frequencies": (30.0, 100.0), "bandwidth": 2.0}),
    ):  # fmt: skip
        found = sw.monitor(t, signal, **options)
        yield f"monitor/{name}", [found.amplitude[:, -1], found.frequency[-1], found.settled_from], CLOSED


def response():
    """Response of the whole drive of every project."""
    for name, project in projects().items():
        yield name, answer(lambda project=project: curve_numbers(project.response().curve)), NEAR_FOLD
