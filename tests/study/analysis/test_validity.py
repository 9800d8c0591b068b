"""Maps of where multiple scales hold, against single certificates, response curves and published errors."""

import numpy as np
import pytest
from peak_errors import errors_at_peak

import strainwave as sw

CUBIC = sw.Oscillator(1.0, 0.05, sw.Cubic(1.0, 0.2), sw.Harmonic(0.05), 1.05)
BIASED = CUBIC._replace(excitation=sw.Harmonic(0.05, mean=0.3))
SOFT = CUBIC._replace(law=sw.Cubic(1.0, -0.05))
GEAR = sw.Oscillator(
    0.6030927835, 14.7, sw.PiecewiseLinear(1e5, 1.4e5, 1.8e5, 54.0, 196.0), sw.Harmonic(0.0), 235.0,
    sw.KinematicError((sw.Line(2, 1.1e-4),)),
)  # fmt: skip
SUB = sw.Oscillator(1.0, 0.01, sw.Cubic(1.0, 0.2), sw.Harmonic(2.0), 3.15)
CASES = {
    "cubic": (CUBIC, sw.PRIMARY, (0.75, 1.5), 1),
    "softening": (SOFT, sw.PRIMARY, (0.75, 1.2), 1),
    "biased": (BIASED, sw.PRIMARY, (0.85, 1.5), 1),
    "gear": (GEAR, sw.Resonance(2, 1), (170.0, 260.0), 2),
}


def strengthened(system, factor):
    """The system with all lines of its excitation times a factor."""
    torque = system.excitation._replace(amplitude=factor * system.excitation.amplitude)
    if not isinstance(system.error, sw.KinematicError):
        return system._replace(excitation=torque)
    lines = tuple(line._replace(amplitude=factor * line.amplitude) for line in system.error.lines)
    return system._replace(excitation=torque, error=sw.KinematicError(lines))


def largest_by_curve(system, band, order, omega):
    """Amplitude of the torsion's harmonic on the stable branch of the largest motion, by continuation."""
    curve = sw.frequency_response(system, band, harmonics=7 * order, points=400)
    c = curve.coefficients[:, 2 * order - 1] - 1j * curve.coefficients[:, 2 * order]
    error = getattr(system.error, "lines", ())
    u = np.abs(c - sum(line.amplitude * np.exp(1j * line.phase) for line in error))
    best = np.zeros(len(omega))
    for i in range(len(curve) - 1):
        if curve.stable[i] and curve.stable[i + 1]:
            low, high = sorted((curve.omega[i], curve.omega[i + 1]))
            inside = (omega >= low) & (omega <= high)
            share = (omega[inside] - curve.omega[i]) / (curve.omega[i + 1] - curve.omega[i])
            best[inside] = np.maximum(best[inside], u[i] + share * (u[i + 1] - u[i]))
    return best, np.array([f.omega for f in curve.folds])


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_true_amplitudes_are_those_of_response_curves(name):
    system, resonance, band, order = CASES[name]
    omega, factor = np.linspace(*band, 14)[1:-1], np.array([0.2, 0.8, 1.7, 2.6])
    found = sw.study.validity_map(system, resonance, omega, factor)
    for j, f in enumerate(factor):
        amplitude, folds = largest_by_curve(strengthened(system, float(f)), band, order, omega)
        away = np.min(np.abs(omega[:, None] - folds), axis=1, initial=1e9) > 3e-3 * omega
        away &= amplitude > 0.0
        assert np.sum(away) >= 10
        # linear interpolation between the points of a curve
        assert found.motion[away, j] == pytest.approx(amplitude[away], rel=4e-3)


@pytest.mark.parametrize("name", CASES)
def test_errors_of_cells_are_those_of_single_certificates(name):
    system, resonance, band, _ = CASES[name]
    omega, factor = np.linspace(*band, 6)[1:-1], np.array([0.3, 1.2, 2.4])
    found = sw.study.validity_map(system, resonance, omega, factor)
    compared = 0
    for i, j in np.ndindex(len(omega), len(factor)):
        one = strengthened(system, float(factor[j]))._replace(omega=float(omega[i]))
        for k in (0, 1):
            flow = sw.slow_flow(one, resonance, order=k + 1)
            error = flow.certificate().amplitude_at_speed
            # the certificate takes the largest state, stable or not, and asks for a motion next to it alone
            state = flow.steady_states()[0]
            if found.motion[i, j] > 1.5 * state.amplitude:  # a larger motion than the one next to the state
                assert found.error[k, i, j] > 0.3
            elif state.stable and error is not None and error < 0.2:
                assert found.error[k, i, j] == pytest.approx(error, rel=1e-6, abs=1e-10)
                compared += 1
    assert compared >= 18


@pytest.mark.compiled
def test_map_of_a_superharmonic_of_three_slopes_is_that_of_single_certificates():
    # three slopes have exact means of first order, which with hard lines belong to one speed
    system = GEAR._replace(excitation=sw.Harmonic(60.0, mean=20.0), error=sw.NoError())
    omega, factor = np.array([128.0, 136.0]), np.array([0.5, 1.0])
    found = sw.study.validity_map(system, sw.SUPERHARMONIC, omega, factor)
    compared = 0
    for i, j in np.ndindex(2, 2):
        one = strengthened(system, float(factor[j]))._replace(omega=float(omega[i]))
        for k in (0, 1):
            flow = sw.slow_flow(one, sw.SUPERHARMONIC, order=k + 1)
            error = flow.certificate().amplitude_at_speed
            if flow.steady_states()[0].stable and error is not None and error < 0.9:
                assert found.error[k, i, j] == pytest.approx(error, rel=1e-6, abs=1e-10)
                compared += 1
    assert compared >= 4


@pytest.mark.parametrize("cell", [(0, 0), (3, 1), (5, 2), (7, 0)])
def test_cells_agree_with_periodic_orbits(cell):
    omega, factor = np.linspace(0.8, 1.25, 8), np.array([0.4, 1.0, 1.8])
    found = sw.study.validity_map(BIASED, sw.PRIMARY, omega, factor)
    i, j = cell
    one = strengthened(BIASED, float(factor[j]))._replace(omega=float(omega[i]))
    state = sw.slow_flow(one, sw.PRIMARY, order=2).steady_states()[0]
    guess = np.zeros((3, 1))
    guess[:, 0] = (
        sw.slow_flow(one, sw.PRIMARY).mean_torsion,
        *(state.amplitude * np.array([np.cos(state.phase), np.sin(state.phase)])),
    )
    orbit = sw.find_orbit(one, guess=guess, harmonics=15)
    assert orbit.stable
    assert found.motion[i, j] == pytest.approx(orbit.amplitude(1), rel=1e-7)
    assert found.error[1, i, j] == pytest.approx(abs(state.amplitude / orbit.amplitude(1) - 1.0), abs=1e-7)


def test_an_order_does_not_hold_beyond_the_true_jump():
    """First order's upper branch goes on beyond the true jump: error 1 there, although it has a state."""
    system = CUBIC._replace(B=0.01, excitation=sw.Harmonic(0.01))
    true_end = max(fold.omega for fold in sw.frequency_response(system, (0.9, 1.2), harmonics=7).folds)
    omega = np.array([true_end - 1e-4, true_end + 1e-4, 1.07])
    found = sw.study.validity_map(system, sw.PRIMARY, omega, [1.0])
    first = sw.slow_flow(system._replace(omega=1.07), sw.PRIMARY).steady_states()[0]
    assert first.amplitude > 0.9
    assert found.error[0, 0, 0] < 0.1
    assert found.error[0, 1:, 0].tolist() == [1.0, 1.0]
    assert found.error[1, 0, 0] < 0.01
    assert found.motion[0, 0] > 0.9
    assert found.motion[1, 0] < 0.2


def test_subharmonic_motion_and_its_absence_are_both_judged():
    found = sw.study.validity_map(SUB, sw.SUBHARMONIC, [2.9, 3.15], [1.0])
    assert found.motion[0, 0] == pytest.approx(0.0, abs=1e-12)
    assert found.motion[1, 0] == pytest.approx(0.87516, abs=5e-6)  # case of Nayfeh & Mook 1979, sec. 4.1.4
    assert found.error[0, 1, 0] == pytest.approx(1.0 - 0.86502 / 0.87516, abs=2e-5)
    assert found.error[0, 0, 0] < 0.05


@pytest.mark.slow
@pytest.mark.parametrize(("A", "error"), [(0.002, 0.0030), (0.005, 0.0180), (0.01, 0.0646), (0.02, 0.196)])
def test_general_map_gives_the_errors_of_the_peak_against_converged_balance(A, error):
    """OSCILATE's Duffing oscillator, zeta = 0.005, alpha = 0.2: errors of first order's peak; at its true amplitude."""
    curve = sw.frequency_response(
        CUBIC._replace(B=0.01, excitation=sw.Harmonic(A)), (0.9, 1.9), harmonics=9, points=2000
    )
    amplitude, speed = errors_at_peak([0.2 * float(np.max(curve.amplitude(1))) ** 2], 0.005)
    assert amplitude[0, 0] == pytest.approx(error, rel=0.01)
    assert speed[1, 0] < 1e-3


def test_general_map_is_the_peak_of_each_drive():
    """Both orders' own peaks, by their response curves, under the torque of the true peak."""
    zeta, bend = 0.02, 0.4
    amplitude, speed = errors_at_peak([bend], zeta)
    # the torque of a lag of 90 degrees at this amplitude, by integration of what damping takes: A = 2 zeta omega a, and
    # harmonics that take below 1 % of it
    omega = 1.0 + 0.375 * bend - 15.0 / 256.0 * bend**2
    A = 2.0 * zeta * omega * np.sqrt(bend)
    drive = sw.Oscillator(1.0, 2.0 * zeta, sw.Cubic(1.0, 1.0), sw.Harmonic(A), 1.0)
    true = sw.frequency_response(drive, (0.8, 1.5), harmonics=9, points=2000)
    top = int(np.argmax(true.amplitude(1)))
    assert true.amplitude(1)[top] == pytest.approx(np.sqrt(bend), rel=5e-3)
    for k in (0, 1):
        peak = sw.slow_flow(drive, sw.PRIMARY, order=k + 1).response((0.8, 1.5)).peak
        assert amplitude[k, 0] == pytest.approx(abs(peak[1] / true.amplitude(1)[top] - 1.0), abs=2e-3)
        assert speed[k, 0] == pytest.approx(abs(peak[0] / true.omega[top] - 1.0), abs=2e-3)


def test_holds_counts_what_is_within_so_many_percent():
    found = sw.study.validity_map(CUBIC, sw.PRIMARY, np.linspace(0.8, 1.4, 7), [0.5, 1.0])
    assert found.holds(5.0).shape == (2, 7, 2)
    assert np.array_equal(found.holds(5.0), found.error <= 0.05)
    assert np.all(found.holds(1.0) <= found.holds(20.0))
    data = found.to_xarray()
    assert data["error"].dims == ("order", "omega", "amplitude")
    assert data["motion"].attrs["units"] == "rad"
    assert "order 2 holds to 1 %, 5 %, 20 %" in str(found)
    with pytest.raises(ValueError, match="must be below 100"):
        found.holds(100.0)


@pytest.mark.parametrize(
    ("speeds", "amplitudes", "said"),
    [
        ([1.0, 0.9], [1.0], r"speeds \[rad/s\] are \[1\.0, 0\.9\]; they must be positive and in rising order"),
        ([1.0], [0.0, 1.0], "amplitudes are .* positive and in rising order"),
        ([1.0], [np.nan], "amplitudes is .* finite numbers"),
    ],
)
def test_bad_axes_are_refused_in_one_sentence(speeds, amplitudes, said):
    with pytest.raises(ValueError, match=said):
        sw.study.validity_map(CUBIC, sw.PRIMARY, speeds, amplitudes)


def test_first_order_has_no_peak_under_a_large_kinematic_error():
    """a = (A/2 zeta) (1 + 3/8 alpha a^2)^2 has a solution up to sqrt(alpha) A/(2 zeta) = 0.530, the largest of
    sqrt(x)/(1 + 3 x/8)^2.
    """
    limit = np.max(np.sqrt(x := np.linspace(0.0, 3.0, 30001)) / (1.0 + 0.375 * x) ** 2)
    assert limit == pytest.approx(0.530, abs=1e-3)
    for share, inside in ((0.8, True), (1.1, False)):
        error = sw.KinematicError((sw.Line(1, share * limit * 0.06),))
        drive = sw.Oscillator(1.0, 0.06, sw.Cubic(1.0, 1.0), sw.Harmonic(0.0), 1.0, error)
        peak = sw.slow_flow(drive, sw.PRIMARY).response((0.9, 1.5)).peak[0]
        assert (peak < 1.4) == inside


@pytest.mark.parametrize("zeta", [0.005, 0.03, 0.1])
def test_bounds_of_the_orders_are_those_of_the_documentation(zeta):
    """docs/limits.md: from which alpha a^2 on first order is off by 1, 5 and 20 %, and the most of second order."""
    bends = np.geomspace(1e-3, 10.0, 401)
    first, second = np.max(errors_at_peak(bends, zeta), axis=0)
    assert [f"{bends[first > limit][0]:.3f}" for limit in (0.01, 0.05, 0.2)] == ["0.027", "0.138", "0.575"]
    assert np.max(second) <= 0.00505


@pytest.mark.parametrize(
    ("name", "zeta", "bend", "first", "second"),
    [
        ("CSF-20-30", 0.02, 0.168, 6.18, 0.002), ("CSF-20-30", 0.05, 0.027, 1.01, 0.0),
        ("CSG-40-50", 0.02, 0.905, 30.41, 0.069), ("CSG-40-50", 0.05, 0.145, 5.33, 0.001),
        ("CSG-40-50", 0.10, 0.036, 1.35, 0.0), ("CSG-25-100", 0.02, 1.965, 81.39, 0.189),
        ("CSG-25-100", 0.05, 0.314, 11.32, 0.009), ("CSG-25-100", 0.10, 0.079, 2.92, 0.0),
        ("CSF-20-30", 0.10, 0.007, 0.25, 0.0),
    ],
)  # fmt: skip
def test_errors_of_gears_are_those_of_the_documentation(name, zeta, bend, first, second):
    """docs/limits.md: errors at the peak that a kinematic error of 1 arcmin peak-to-peak makes."""
    size = sw.catalogue.gear(name).cubic.alpha * (0.5 * np.pi / 180 / 60 / (2 * zeta)) ** 2
    errors = 100.0 * np.max(errors_at_peak([size], zeta), axis=0)[:, 0]
    assert size == pytest.approx(bend, abs=5e-4)
    assert errors == pytest.approx([first, second], abs=5.01e-3)
