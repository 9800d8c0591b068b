"""Closed forms: numbers that follow from a formula without this library."""

import math

import numpy as np
from scipy.integrate import quad
from scipy.special import mathieu_a, mathieu_b

import strainwave as sw

from .row import Row

TIGHT = sw.Dopri5(rtol=1e-13, atol=1e-15)
VENDOR = "Harmonic Drive LLC, CSF/CSG catalogue, p. 50"
KRACK = "one harmonic in closed form (Krack & Gross 2019, [doi](https://doi.org/10.1007/978-3-030-14023-6))"


def duffing(B, alpha, A, omega=1.0):
    return sw.Oscillator(1.0, B, sw.Cubic(1.0, alpha), sw.Harmonic(A), omega)


def crest(curve, k=1):
    i = int(np.argmax(curve.amplitude(k)))
    return curve.amplitude(k)[i], curve.omega[i]


def folds(curve):
    return sorted(fold.omega for fold in curve.folds)


def free_frequencies():
    """Integrated over ten periods; what is left of the velocity is turned into time."""
    found = []
    for alpha, X, omega in ((0.1, 1.0, 1.0367), (1.0, 1.0, 1.3178), (1.0, 2.0, 1.976), (10.0, 1.0, 2.8666)):
        for _ in range(2):
            end = 20.0 * math.pi / omega
            run = sw.simulate(duffing(0.0, alpha, 0.0), (X, 0.0), end, method=TIGHT)
            omega = 20.0 * math.pi / (end - run.y[1, -1] / run.rate[1, -1])
        found.append(omega)
    return found


def free_period():
    gear = sw.Drive(4.5e-4, 1.3, 50.0, 0.0, sw.catalogue.gear("CSF-40-50").law).error_equation(omega=1.0)
    period = 0.0127889
    for _ in range(2):
        run = sw.simulate(gear, (3e-3, 0.0), 10.0 * period, method=sw.Dopri5(rtol=1e-12, atol=1e-18))
        period -= run.y[1, -1] / run.rate[1, -1] / 10.0
    return [period]


def vendor_twists():
    arcmin = math.pi / 10800.0
    pairs = [("CSG-40-50", torque) for torque in (54.0, 196.0, 300.0)]
    pairs += [("CSG-40-80", 54.0), ("CSG-40-80", 196.0), ("CSG-40-80", 300.0)]
    return [sw.catalogue.gear(name).twist(torque) / arcmin for name, torque in pairs]


def vendor_resonance():
    drive = sw.catalogue.gear("CSG-40-100").drive(load_inertia=10.0, B=0.0)
    return [drive.omega_0_held / (2.0 * math.pi)]


def one_harmonic(B, alpha, A, span):
    return lambda: crest(sw.frequency_response(duffing(B, alpha, A), span, harmonics=1))


def subharmonics(system):
    def found():
        return [s.amplitude for s in sw.slow_flow(system, sw.SUBHARMONIC).steady_states() if s.amplitude > 0.0]

    return found


def first_order_errors():
    """Percent by which the peak of first-order multiple scales, A/B, is above the computed one."""
    errors = []
    for A in (0.002, 0.005, 0.01):
        true, _ = crest(sw.frequency_response(duffing(0.01, 0.2, A), (0.8, 1.5)))
        flow = sw.slow_flow(duffing(0.01, 0.2, A), sw.PRIMARY).response((0.8, 1.5))
        errors.append(100.0 * (flow.peak[1] / true - 1.0))
    return errors


def mathieu_edges():
    """a = 4/omega^2 of the six edges of three tongues, less Mathieu's characteristic value there."""
    ripples = sw.gears.Variation((sw.gears.Ripple(1, 0.4),))
    system = sw.gears.VaryingOscillator(
        1.0, sw.gears.GearDamping(0.0), sw.Linear(1.0), sw.Harmonic(0.0), 1.0, sw.NoError(), ripples
    )
    apart = []
    for r in sw.study.parametric_resonances(system, (0.6, 2.5)):
        for a in (4.0 / r.low**2, 4.0 / r.high**2):
            apart.append(min(abs(a - mathieu_a(r.m, 0.2 * a)), abs(a - mathieu_b(r.m, 0.2 * a))))
    return [max(apart)]


def bouc_wen_loss():
    """Energy of the loop n = 1, beta = gamma = 1/2 over the closed form, less one; straight while it unloads."""
    law, y = sw.BoucWen(1.0, 0.0, 0.4), 0.4
    loop = sw.hysteresis_loop(law, 0.3)
    n = len(loop.torque) // 3
    x, top = loop.torsion[n:], 0.3
    length = float(np.max(x) - np.min(x))
    branch, _ = quad(lambda s: top - s if s < top else -y * (1.0 - math.exp(-(s - top) / y)), 0.0, length, points=[top])
    area = -2.0 * branch
    return [loop.energy / area - 1.0]


def backlash_contact():
    """Speed beyond which the free motion A/(omega sqrt(omega^2 + B^2)) fits into the gap."""
    system = sw.Oscillator(1.0, 0.1, sw.Backlash(1.0, 0.5), sw.Harmonic(0.6), 1.0)
    low, high = 1.09, 1.1
    for _ in range(30):
        omega = 0.5 * (low + high)
        forced = 0.6 / (-omega * omega + 0.1j * omega)
        run = sw.simulate(system._replace(omega=omega), (forced.real, (1j * omega * forced).real), 20.0, method=TIGHT)
        low, high = (omega, high) if run.switches else (low, omega)
    return [low]


NAYFEH = duffing(0.01, 0.2, 2.0, 3.15)
T18 = duffing(0.002, 0.05, 8.0, 3.4)

ROWS = (
    Row(
        "Example 01 of NLvib: B 0.05, α 0.1, A 0.18",
        KRACK,
        "peak amplitude at ω, J = K = 1",
        ("2.8416246", "1.2666342"),
        one_harmonic(0.05, 0.1, 0.18, (0.5, 1.6)),
        "published/test_response_curves.py::test_one_harmonic_of_nlvib_example_01_is_the_closed_form",
    ),
    Row(
        "Tutorial of HarmonicBalance.jl: B 0.01, α 1, A 0.01",
        KRACK,
        "peak amplitude at ω",
        ("0.816502", "1.224727"),
        one_harmonic(0.01, 1.0, 0.01, (0.9, 1.3)),
        "published/test_response_curves.py::test_harmonicbalance_jl_tutorial",
    ),
    Row(
        "Free cubic spring; α and release 0.1, 1; 1, 1; 1, 2; 10, 1",
        "elliptic integral (Abramowitz & Stegun, ch. 17)",
        "frequency by integration [rad/s]",
        ("1.0367169071", "1.3177760650", "1.9760163641", "2.8666401366"),
        free_frequencies,
        "published/test_elliptic.py::test_integration_gives_the_printed_frequencies",
    ),
    Row(
        "Free CSF-40-50 with its three slopes, released at 3 mrad",
        "cosines piece by piece",
        "period [s]",
        ("0.0127889662624",),
        free_period,
        "published/test_piecewise.py::test_integration_gives_the_free_period",
    ),
    Row(
        "Torsion of size 40, ratio 50 and 80",
        VENDOR + ", formula",
        "at 54, 196, 300 N m [arcmin]",
        ("1.8564", "5.3432", "7.3295", "1.4280", "3.8688", "5.4232"),
        vendor_twists,
        "model/gears/test_catalogue.py::test_size_40_twists_as_the_vendors_formula_says",
    ),
    Row(
        "CSG-40-100 with 10 kg m², motor held",
        VENDOR + ", √(K₁/J)/2π",
        "resonance [Hz]",
        ("18.1465",),
        vendor_resonance,
        "model/gears/test_catalogue.py::test_natural_frequency_of_size_40_with_the_motor_held_is_the_vendors",
    ),
    Row(
        "Subharmonic: B 0.01, α 0.2, A 2, ω 3.15",
        "Nayfeh & Mook 1979, sec. 4.1.4, first order",
        "both amplitudes",
        ("0.86502", "0.65905"),
        subharmonics(NAYFEH),
        "published/test_nayfeh_mook.py::test_first_order_gives_the_printed_subharmonics",
    ),
    Row(
        "Subharmonic: B 0.002, α 0.05, A 8, ω 3.4",
        "[erratum E6](theory.md), corrected formula",
        "both amplitudes",
        ("2.850", "2.093"),
        subharmonics(T18),
        "published/test_errata.py::test_e6_subharmonic_amplitudes_are_the_corrected_ones",
    ),
    Row(
        "Example of OSCILATE: B 0.01, α 0.2, A 0.002, 0.005, 0.01",
        "first order A/B against the computed peak",
        "error of first order [%]",
        ("0.30", "1.80", "6.46"),
        first_order_errors,
        "published/test_response_curves.py::test_error_of_first_order_multiple_scales_at_the_peak",
    ),
    Row(
        "Backlash 0.5, B 0.1, A 0.6",
        "A/(ω √(ω² + B²)) = half gap",
        "speed at which contact ends [rad/s]",
        ("1.0931653",),
        backlash_contact,
        "published/test_backlash.py::test_above_1_0931653_orbits_float_inside_the_gap",
    ),
    Row(
        "Parametric resonances, depth 0.4",
        "values of Mathieu's equation ([DLMF 28.2](https://dlmf.nist.gov/28.2), SciPy)",
        "largest distance of six edges of tongues, as a",
        ("0.00000000",),
        mathieu_edges,
        "study/gear/test_parametric.py::test_edges_of_the_tongues_are_the_characteristic_values_of_mathieus_equation",
    ),
    Row(
        "Bouc-Wen loop, n = 1",
        "area in closed form",
        "relative error of the loss",
        ("0.0000",),
        bouc_wen_loss,
        "theory/slow_flow/test_memory.py::test_bouc_wen_loses_the_area_of_its_exact_loop",
    ),
)
