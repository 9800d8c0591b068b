"""Other programs and other methods on the same equations, and measured or made records."""

import math

import numpy as np
from scipy.integrate import solve_ivp

import strainwave as sw

from .forms import T18, duffing, folds
from .published import article_cells
from .row import Row

AUTO = "AUTO-07p 0.9.2, equations of `benchmarks/auto`"
PIECES = "exact flow of the pieces; DOP853 with located switches (they agree to {})"
CURVES = "published/test_response_curves.py::"


def folds_of(B, alpha, A, span, harmonics=None):
    return lambda: folds(sw.frequency_response(duffing(B, alpha, A), span, harmonics=harmonics))


def by_scipy(system, orbit, periods=1, samples=512):
    """Amplitude at omega of the motion that DOP853 finds from the state of the orbit, largest |x|, and what is left."""
    time = 2.0 * math.pi * periods / system.omega

    def rate(t, y):
        law = system.law
        force = system.excitation.amplitude * math.cos(system.omega * t)
        return y[1], force - system.B * y[1] - law.K * (y[0] + law.alpha * y[0] ** 3)

    t = np.linspace(0.0, time, samples + 1)
    run = solve_ivp(rate, (0.0, time), orbit.state(0.0), "DOP853", t, rtol=1e-12, atol=1e-14)
    return 2.0 * abs(np.fft.rfft(run.y[0, :-1])[periods]) / samples, np.max(np.abs(run.y[:, -1] - run.y[:, 0]))


def repeats():
    """What DOP853 finds of the top of example 01 of NLvib: its amplitude over ours, less one; what does not repeat."""
    system = duffing(0.05, 0.1, 0.18)
    curve = sw.frequency_response(system, (0.5, 1.6))
    top = int(np.argmax(curve.amplitude(1)))
    system = system._replace(omega=float(curve.omega[top]))
    orbit = sw.find_orbit(system, guess=curve.coefficients[top])
    amplitude, left = by_scipy(system, orbit)
    return amplitude / orbit.amplitude(1) - 1.0, left


def backlash():
    orbit = sw.find_orbit(sw.Oscillator(1.0, 0.1, sw.Backlash(1.0, 0.5), sw.Harmonic(0.6), 0.8))
    return orbit.peak, orbit.amplitude(1), orbit.amplitude(3), abs(orbit.multipliers[0])


GEAR = sw.Oscillator(
    0.6030927835,
    9.82317898446,
    sw.PiecewiseLinear(1e5, 1.4e5, 1.8e5, 54.0, 196.0),
    sw.Harmonic(0.0),
    235.0,
    sw.KinematicError((sw.Line(2, 1.1e-4),)),
)


def gear_folds():
    return folds(sw.frequency_response(GEAR, (150.0, 300.0), harmonics=63))


def two_inertias():
    drive = sw.HDC_40_050._replace(B=5.0, law=sw.Cubic(7160.0, 1e4))
    orbits = [
        sw.find_orbit(drive.error_equation(motor_torque=sw.Harmonic(1.0), omega=omega))
        for omega in (200.0, 380.0, 420.0)
    ]
    return [orbit.amplitude(1) for orbit in orbits]


def drifting_phase():
    quantities = ("normalised RMS difference, formula as printed", "normalised RMS difference")
    return [article_cells()["Table 4", "printed", "non-resonant", quantity] for quantity in quantities]


def isola():
    """Both subharmonic amplitudes at omega 3.15 on the closed branch, and their largest multipliers."""
    loop = sw.isolas(duffing(0.01, 0.2, 2.0, 3.15), (3.0, 10.0))[0]
    here = np.flatnonzero(loop.omega == 3.15)
    here = here[np.argsort(-loop.amplitude(1)[here])]
    _, first = np.unique(np.round(loop.amplitude(1)[here], 9), return_index=True)
    low, high = here[first]
    largest = np.abs(loop.multipliers[:, 0])
    return loop.amplitude(1)[high], loop.amplitude(1)[low], largest[high], largest[low]


ROWS = (
    Row(
        "Duffing: B 0.1, α 0.05, A 1",
        AUTO,
        "speeds of both folds",
        ("1.2704388304", "1.5863944033"),
        lambda: (lambda f: (min(f, key=lambda w: abs(w - 1.27)), f[-1]))(folds_of(0.1, 0.05, 1.0, (0.25, 3.0), 15)()),
        "benchmarks/response.py",
        note="5e-10, AUTO's tolerance is 1e-7",
    ),
    Row(
        "Example 01 of NLvib: B 0.05, α 0.1, A 0.18",
        AUTO + ", EPSL 1e-9",
        "speeds of both folds",
        ("1.115700", "1.269602"),
        folds_of(0.05, 0.1, 0.18, (0.5, 1.6)),
        CURVES + "test_nlvib_example_01_converged",
    ),
    Row(
        "Tutorial of HarmonicBalance.jl: B 0.01, α 1, A 0.01",
        AUTO + ", EPSL 1e-9",
        "speeds of both folds",
        ("1.038604", "1.226449"),
        folds_of(0.01, 1.0, 0.01, (0.9, 1.3), 7),
        CURVES + "test_harmonicbalance_jl_tutorial",
    ),
    Row(
        "Example of OSCILATE: B 0.01, α 0.2, A 0.01",
        AUTO + ", EPSL 1e-9",
        "speeds of both folds",
        ("1.022189", "1.064511"),
        folds_of(0.01, 0.2, 0.01, (0.9, 1.3)),
        CURVES + "test_oscilate_duffing_direct",
    ),
    Row(
        "Top of example 01 of NLvib",
        "SciPy DOP853 from the state of our orbit",
        "relative difference of the amplitude; what does not repeat after a period",
        ("0.0000000", "0.0000000"),
        repeats,
        "test_validation_page.py::test_scipy_repeats_the_orbit_of_example_01",
    ),
    Row(
        "Subharmonic: B 0.002, α 0.05, A 8, ω 3.4",
        "shooting with SciPy DOP853, periodic to 1e-12",
        "amplitudes at ω/3 of the stable and the unstable orbit",
        ("2.9418", "2.1434"),
        lambda: [np.interp(3.4, b.omega, b.amplitude(1)) for b in sw.isolas(T18, (3.2, 3.6))],
        "published/test_errata.py::test_e6_orbits_with_omega_over_three_are_those_of_shooting",
    ),
    Row(
        "Article's case 1, printed μ and ω₀, from rest",
        "SciPy DOP853",
        "RMS difference of x(t) as printed, and with its phase drift [%]",
        ("54.6", "4.2"),
        drifting_phase,
        "published/test_errata.py::test_e10_the_phase_of_the_free_vibration_drifts_without_resonance",
    ),
    Row(
        "Backlash 0.5, B 0.1, A 0.6, ω 0.8",
        PIECES.format("7e-10"),
        "peak, amplitudes at ω and 3ω, Floquet modulus",
        ("3.297722874", "3.260846925", "0.042768294", "0.675231907"),
        backlash,
        CURVES + "test_backlash_by_balance_and_shooting",
    ),
    Row(
        "CSF-40-50, three slopes, kinematic error of order 2",
        PIECES.format("2e-10"),
        "motor speeds of both folds [rad/s]",
        ("226.448419", "249.057291"),
        gear_folds,
        CURVES + "test_gear_with_three_slopes",
    ),
    Row(
        "HDC-40-050 as two inertias, α 1e4, motor torque of 1 N m",
        "Taylor integration of the four states",
        "amplitude of the error at 200, 380, 420 rad/s",
        ("3.43352996e-4", "9.55480228e-4", "7.40370108e-4"),
        two_inertias,
        "model/train/test_drive_train.py"
        "::test_error_equation_and_train_in_relative_coordinates_give_the_reference_amplitudes",
    ),
    Row(
        "Subharmonic isola: B 0.01, α 0.2, A 2, ω 3.15",
        "tight shooting",
        "amplitudes, stable and unstable; Floquet moduli over three periods",
        ("0.87516", "0.66510", "0.9705", "1.2843"),
        isola,
        "published/test_nayfeh_mook.py::test_the_isola_is_closed_and_holds_both_printed_subharmonics",
    ),
    Row(
        "Laws from tables of points, four tables",
        "SciPy `PchipInterpolator`",
        "largest difference of torque, slope, energy",
        (),
        None,
        "model/test_measured.py::test_a_table_is_scipys_monotone_cubic_between_its_points",
        told=("< 1e-11",),
        note="rounding",
    ),
    Row(
        "Linear train with and without loop",
        "python-control; transfer functions by hand",
        "frequency responses and poles",
        (),
        None,
        "drive/test_to_control.py",
        told=("< 1e-9",),
        note="rounding",
    ),
    Row(
        "Exported C, plant and controllers",
        "the same steps in Python, compiled by `cc`",
        "outputs over the largest value",
        (),
        None,
        "files/export/test_plant_code.py",
        told=("< 1e-12",),
        note="rounding",
    ),
    Row(
        "FMU 2.0 and 3.0",
        "FMPy runs the unit; SciPy runs the equations",
        "outputs of a run-up",
        (),
        None,
        "files/export/test_fmu.py",
        told=("< 1e-8",),
        note="tolerances",
    ),
    Row(
        "Whole drives with a position loop",
        "two inertias by hand, integrated by SciPy",
        "pointing error of two examples",
        (),
        None,
        "test_examples.py",
        told=("< 0.1 %",),
        note="tolerance",
    ),
    Row(
        "Certificates of multiple scales, 500 random drives",
        "harmonic balance",
        "true over estimated error, first order; second order",
        (),
        None,
        "python benchmarks/certificate.py",
        told=("0.04 to 1.02", "0.58 to 2.38"),
        note="within 1.5 in 99.8 % and 97.8 %; where valid, at most 1.02 and 2.38",
    ),
    Row(
        "Twelve project files",
        "command line, sweep, report and Python",
        "oscillation, torque, speed of the peak",
        (),
        None,
        "test_one_drive.py::test_command_line_sweep_report_and_python_agree",
        told=("< 1e-9",),
        note="rounding",
    ),
)
