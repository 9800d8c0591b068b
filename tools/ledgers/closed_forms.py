"""Closed forms, proofs, laws and the catalogue."""

import numpy as np

import strainwave as sw

from .drives import BIASED, CLOSED, DRIVE, DUFFING, EXACT, GEAR, INTEGRATED, SYSTEMS, answer

WEAK = sw.Oscillator(1.0, 0.02, sw.Cubic(1.0, 0.1), sw.Harmonic(0.03), 1.0)
RESONANCES = {"primary": sw.PRIMARY, "super": sw.SUPERHARMONIC, "sub": sw.SUBHARMONIC, "none": sw.NONRESONANT}
OF_GEAR = sw.Resonance(2, 1)


def law():
    """Torque, stiffness and energy of every law."""
    x = np.array([-2e-3, -4e-4, 0.0, 5e-5, 1e-3, 2.5e-3])
    for name, system in SYSTEMS.items():
        at = x if abs(system.law.stiffness(1e-3)) > 100.0 else 1e3 * x
        if not hasattr(system.law, "z_rate"):
            yield name, {m: np.array([getattr(system.law, m)(v) for v in at]) for m in ("torque", "stiffness")}, CLOSED
            yield f"{name}/energy", np.array([system.law.energy(v) for v in at]), CLOSED
    points = [(-2.0e-3, -270.0), (-0.6e-3, -60.0), (0.0, 0.0), (0.5e-3, 52.0), (1.5e-3, 195.0), (2.1e-3, 300.0)]
    for dry in (
        sw.laws.Coulomb(0.02, 0.05),
        sw.laws.Stribeck(0.02, 0.03, 0.3, 0.05),
        sw.laws.QuadraticDamping(0.3),
        sw.laws.Viscous(0.05),
    ):
        yield type(dry).__name__, np.array([dry.torque(0.0, v) for v in (-1.0, -0.02, 0.0, 0.3)]), CLOSED
    yield "tabulated", sw.tabulated(points).torque(x), CLOSED


def catalogue():
    """Gears, their fits, limits, life, drags."""
    yield "names", sw.catalogue.names()[::20], EXACT
    for name in ("CSG-40-50", "SHG-25-100", "CSF-20-30", "RT1-H-CS-25-100"):
        yield name, sw.catalogue.gear(name), CLOSED
    yield "select", [g.name for g in sw.catalogue.select(series="CSG", ratio=100, torque=600.0)], EXACT
    yield "fit", {f"{degree}": vars(GEAR.fit(degree)) for degree in (3, 7)}, CLOSED
    yield "rounded", GEAR.rounded(1e-4), CLOSED
    yield "check_limits", sw.gears.check_limits(GEAR, peak_torque=600.0, average_torque=180.0, max_speed=350.0), CLOSED
    yield "bearing_life", sw.gears.bearing_life(GEAR, 120.0, 200.0), CLOSED
    yield "cubic_mean", sw.gears.cubic_mean(np.array([10.0, -40.0, 25.0]), np.array([1.0, 2.0, 3.0])), CLOSED
    yield "accuracy_spectrum", sw.gears.accuracy_spectrum(GEAR.accuracy), CLOSED
    yield "peak_to_peak", sw.gears.peak_to_peak(sw.gears.accuracy_spectrum(GEAR.accuracy)), CLOSED
    yield "no_load_drag", sw.gears.no_load_drag(0.05, 0.02), CLOSED
    yield "load_friction", sw.gears.load_friction(0.7, 67.0, 100.0, 0.05), CLOSED
    yield "fit_odd", vars(sw.gears.fit_odd(GEAR.law, 2e-3, 5)), CLOSED
    yield "small_signal", sw.small_signal(GEAR.cubic, 178.0), CLOSED
    yield "from_bandwidth", [sw.train.from_bandwidth(190.0, 1e-3, kind=k) for k in ("position", "speed")], CLOSED
    yield "drive", {n: getattr(DRIVE, n) for n in ("J", "J_m", "J_l", "mu", "omega_0", "omega_0_held")}, CLOSED


def orders():
    """Orders of a gear, sources of the static error, on which turn they count."""
    yield "map", sw.gears.order_map(50), CLOSED
    yield "sources", sw.gears.static_sources(50), CLOSED
    yield "on_output_turn", sw.gears.on_output_turn(sw.Harmonic(1.0, 3, 0.2), 50.0), CLOSED


def slow_flow():
    """Multiple scales of both orders: steady states, certificate, response, evolution, backbone."""
    for order in (1, 2):
        for name, resonance in RESONANCES.items():
            omega = {"super": 0.34, "sub": 3.1, "none": 0.6}.get(name, 1.05)
            flow = sw.slow_flow(DUFFING._replace(omega=omega), resonance, order=order)
            yield f"{name}/{order}/states", flow.steady_states(), CLOSED
            yield f"{name}/{order}/certificate", flow.certificate(), 1e-6  # differences of close numbers
            yield f"{name}/{order}/exists", [flow.exists(), flow.existence], EXACT
            yield f"{name}/{order}/rates", flow.rates(0.4 + 0.3j), CLOSED
            yield f"{name}/{order}/evolve", flow.evolve((0.3, 0.1), np.linspace(0.0, 60.0, 5)).x, 1e-7
        for name, system, resonance, band in (
            ("cubic", DUFFING, sw.PRIMARY, (0.9, 1.4)),
            ("gear", SYSTEMS["piecewise"]._replace(law=GEAR.cubic), OF_GEAR, (100.0, 200.0)),
            ("Bouc-Wen", SYSTEMS["Bouc-Wen"], sw.PRIMARY, (200.0, 400.0)),
        ):
            found = sw.slow_flow(system, resonance, order=order).response(band)
            yield f"response/{name}/{order}", [found.folds, found.fold_amplitudes, found.peak], 1e-8
    yield "backbone", sw.slow_flow(DUFFING, sw.PRIMARY, order=2).backbone([0.5, 1.0, 2.0]), CLOSED
    at = sw.slow_flow(DUFFING, sw.PRIMARY).states_at(np.linspace(0.9, 1.4, 11))
    yield "states_at", [at.omega, at.amplitude, at.stable], CLOSED
    predictor = sw.slow_flow(WEAK, sw.PRIMARY, order=2).predictor(0.05, speeds=(0.85, 1.15))
    state = predictor.start(omega=1.0)
    for _ in range(400):
        found = predictor.update(1.0, 1.0, state)
        state = found.state
    yield "predictor", [found.amplitude, found.x, found.rate], CLOSED


def lyapunov():
    """Proofs of stability of every system."""
    for name, system in SYSTEMS.items():
        proof = answer(lambda system=system: sw.lyapunov(system))
        yield name, [getattr(proof, word, proof) for word in ("claim", "reason", "conditions", "obstacle")], EXACT
    span = sw.lyapunov(SYSTEMS["softening"], span=2.0)
    yield "span", [span.claim, span.V(0.3, 0.2), span.dissipation(0.3, 0.2), span.contains(0.3, 0.2)], CLOSED


def parametric():
    """Parametric resonances."""
    yield "resonances", sw.study.parametric_resonances(SYSTEMS["varying"], (250.0, 700.0)), 1e-8


def validity():
    """Closed forms against integration."""
    for name, resonance in (("primary", sw.PRIMARY), ("none", sw.NONRESONANT)):
        one = sw.study.compare_with_integration(WEAK._replace(omega=1.0 if name == "primary" else 0.5), resonance)
        yield f"compare/{name}", [one.rms_difference, one.peak_theory, one.peak_integrated], 1e-6


def derivation():
    """Lagrange's equations, as LaTeX."""
    yield "latex", sw.theory.derive().latex(), EXACT


def biased_flow():
    """A mean torque: the spring about it, and its slow flow."""
    found = sw.slow_flow(BIASED._replace(omega=1.6, B=0.05), sw.PRIMARY, order=2).steady_states()
    yield "states", found, INTEGRATED
