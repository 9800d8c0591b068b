"""Speeds to avoid by their rule, on curves of the closed form of the linear oscillator."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

import strainwave as sw
from strainwave.base.series import oscillation
from strainwave.drive.drive_response import DriveResponse
from strainwave.drive.hysteresis_bands import HysteresisBand, Jump
from strainwave.drive.jumps import Sweep, jumps_of
from strainwave.study.analysis.regimes import Regime, with_tops
from strainwave.study.speed_map.avoid import speeds_to_avoid
from strainwave.study.speed_map.error_equation import operating_point, quasi_static
from strainwave.study.speed_map.ramp import Ramp, in_run
from strainwave.theory.resonance import Resonance

K, J, ZETA, A = 1e5, 1.0, 0.03, 1e-4
OMEGA_0 = math.sqrt(K / J)
SYSTEM = sw.Oscillator(
    J, 2.0 * ZETA * J * OMEGA_0, sw.Linear(K), sw.Harmonic(0.0), 100.0, sw.KinematicError((sw.Line(2, A),))
)


def transmissibility(omega, zeta=ZETA, omega_0=OMEGA_0):
    """Error at the load over the kinematic error of order 2 (den Hartog 1956, Mechanical Vibrations, sec. 2.12)."""
    r = 2.0 * omega / omega_0
    return np.sqrt((1.0 + (2 * zeta * r) ** 2) / ((1.0 - r * r) ** 2 + (2 * zeta * r) ** 2))


def followed(omega, peak, mean=0.0, jump_up=math.nan, jump_down=math.nan):
    """Response curve of one motion at every speed."""
    table = np.column_stack([np.full(len(omega), mean), np.zeros((len(omega), 2)), peak, np.zeros(len(omega))])
    curve = SimpleNamespace(
        omega=omega, values=omega, span=(omega[0], omega[-1]), stable=np.ones(len(omega), bool), closed=False,
        folds=[], doublings=[], branch_points=[], peak=peak + abs(mean), coefficients=table,
        oscillation=oscillation(table), inside=np.ones(len(omega), bool), status=sw.Status.OK, envelope=None, period=1,
        multipliers=np.zeros((len(omega), 2)),
    )  # fmt: skip
    path = np.arange(len(omega))
    rise, drop = Jump(jump_up, 0.0, 1.0, "fold", 1), Jump(jump_down, 1.0, 0.0, "fold", 1)
    up, down = ((drop,), (rise,)) if jump_up < jump_down else ((rise,), (drop,))
    both = jump_up, jump_down
    bands = (HysteresisBand(min(both), max(both), up, down),) if math.isfinite(jump_up) else ()
    run_up, run_down = Sweep(path, up if bands else (), True, []), Sweep(path[::-1], down if bands else (), True, [])
    sweep = jumps_of("omega", run_up, run_down, "", bands)
    return DriveResponse(curve, sweep, torque=0.0 * peak, mean_torque=0.0 * peak)


OMEGA = np.linspace(100.0, 220.0, 2001)
POINT = operating_point(SYSTEM)


@pytest.mark.parametrize("mean", [0.0, 3e-3])
def test_the_band_of_a_resonance_ends_at_twice_the_error_of_slow_turning_whatever_the_mean(mean):
    found = speeds_to_avoid(SYSTEM, followed(OMEGA, A * transmissibility(OMEGA), mean), POINT)
    ((low, high),) = found.bands
    assert transmissibility(np.array([low, high])) == pytest.approx(2.0, rel=1e-4)
    assert found.slow == pytest.approx(A, rel=1e-5)


def test_a_range_without_resonance_has_no_speed_to_avoid_however_its_largest_is():
    omega = np.linspace(20.0, 60.0, 101)
    assert speeds_to_avoid(SYSTEM, followed(omega, A * transmissibility(omega)), POINT).bands == ()


def test_the_band_between_the_jumps_is_avoided_even_of_a_small_oscillation():
    omega = np.linspace(20.0, 60.0, 101)
    response = followed(omega, A * transmissibility(omega), jump_up=30.0, jump_down=40.0)
    assert speeds_to_avoid(SYSTEM, response, POINT).bands == ((30.0, 40.0),)


def test_a_band_that_the_range_cuts_off_ends_with_the_range():
    omega = np.linspace(100.0, 0.5 * OMEGA_0, 801)
    ((_, high),) = speeds_to_avoid(SYSTEM, followed(omega, A * transmissibility(omega)), POINT).bands
    assert high == omega[-1]


def test_where_no_motion_is_stable_nothing_is_advised():
    curve = SimpleNamespace(omega=OMEGA, peak=OMEGA, oscillation=np.zeros(len(OMEGA)))
    assert speeds_to_avoid(SYSTEM, DriveResponse(curve, None), POINT) is None


@pytest.mark.parametrize(("height", "bands"), [(1.9, 0), (2.1, 1)])
def test_a_peak_counts_from_twice_the_error_of_slow_turning(height, bands):
    hill = A * (1.0 + (height - 1.0) * np.exp(-(((OMEGA - 160.0) / 5.0) ** 2)))
    assert len(speeds_to_avoid(SYSTEM, followed(OMEGA, hill), POINT).bands) == bands


def hills(*several):
    """Oscillation of quasi-static rotation with hills of a height [times that] at a speed, five rad/s wide."""
    return A * (1.0 + sum((h - 1.0) * np.exp(-(((OMEGA - w) / 5.0) ** 2)) for w, h in several))


def test_every_peak_is_told_and_has_a_band():
    found = speeds_to_avoid(SYSTEM, followed(OMEGA, hills((130.0, 4.0), (170.0, 20.0))), POINT)
    assert [peak[0] for peak in found.peaks] == pytest.approx([130.0, 170.0], abs=0.1)
    for (low, high), (at, size) in zip(found.bands, found.peaks, strict=True):
        assert low < at < high
        ends = np.interp([low, high], OMEGA, hills((130.0, 4.0), (170.0, 20.0)))
        assert ends == pytest.approx([2.0 * A] * 2, rel=1e-4)
        assert size > 2.0 * A


def test_a_bump_on_the_flank_of_a_peak_is_none_of_its_own():
    curve = hills((170.0, 20.0)) + 2.5 * A * np.exp(-(((OMEGA - 164.0) / 0.5) ** 2))
    assert np.sum((curve[1:-1] > curve[:-2]) & (curve[1:-1] > curve[2:])) == 2
    found = speeds_to_avoid(SYSTEM, followed(OMEGA, curve), POINT)
    assert len(found.peaks) == len(found.bands) == 1


@pytest.mark.parametrize(("height", "placed"), [(0.3, None), (1.1, 118.0)])
def test_a_maximum_of_the_third_harmonic_on_the_flank_of_order_2_is_no_superharmonic(height, placed):
    omega = np.linspace(70.0, 200.0, 2601)
    heights = (2, 1.0, 126.0, 20.0), (3, height, 118.0, 10.0)
    sizes = {p: h * A * np.exp(-(((omega - at) / width) ** 2)) for p, h, at, width in heights}
    seen = SimpleNamespace(
        omega=omega, counted=np.arange(len(omega)), curve=SimpleNamespace(peak=sum(sizes.values())),
        torsion_amplitude=lambda _, p: sizes[p],
    )  # fmt: skip
    met = tuple(
        Regime(name, order, Resonance(p, 1), 300.0 / p, True)
        for name, order, p in (("superharmonic 3:1", 1, 3), ("primary", 2, 2))
    )
    third, second = (regime.top for regime in with_tops(met, SYSTEM, seen, {}))
    assert second == (pytest.approx(126.0), pytest.approx(A))
    assert third == (None if placed is None else (pytest.approx(placed), pytest.approx(height * A)))


def test_a_limit_takes_the_place_of_the_peaks():
    curve = followed(OMEGA, hills((130.0, 4.0), (170.0, 20.0)))
    ((low, high),) = speeds_to_avoid(SYSTEM, curve, POINT, limit=5.0 * A).bands
    # 1 + 19 exp(-d^2/25) = 5
    assert [low, high] == pytest.approx([170.0 - (d := 5.0 * math.sqrt(math.log(19.0 / 4.0))), 170.0 + d], abs=1e-3)
    assert speeds_to_avoid(SYSTEM, curve, POINT, limit=21.0 * A).bands == ()


def ramp(swing):
    """Run-up from 100 to 220 rad/s in 60 s: at every speed the steady error, on a swing once in 50 turns."""
    t = np.linspace(0.0, 60.0, 600_001)
    speed = 100.0 + 2.0 * t
    angle = 100.0 * t + t * t
    error = A * transmissibility(speed) * np.cos(2.0 * angle) + swing * np.sin(angle / 50.0)
    return SimpleNamespace(trajectory=SimpleNamespace(t=t), motor_speed=speed, pointing=error)


@pytest.mark.parametrize("swing", [0.0, 1e-3])
def test_the_oscillation_of_a_run_up_is_that_about_its_slow_swing(swing):
    found = in_run(ramp(swing), 5.0)
    assert found.omega[0] == pytest.approx(110.0, rel=0.01)
    exact = A * transmissibility(found.omega)
    assert np.max(np.abs(found.sizes - exact)) < 0.01 * np.max(exact)


@pytest.mark.parametrize("shift", [0.0, 0.3, 0.5])
def test_the_oscillation_of_a_run_up_is_that_between_its_samples(shift):
    """Twenty samples of each cycle, as many as a run-up has at its highest speed: they miss up to 1.2 % of a crest."""
    step = 2.0 * math.pi / 8 / 20
    angle = step * (np.arange(20 * 8 * 12) + shift)
    run = SimpleNamespace(
        trajectory=SimpleNamespace(t=angle / 100.0),
        motor_speed=np.full(len(angle), 100.0),
        pointing=A * np.cos(8 * angle),
    )
    assert np.min(in_run(run, 0.0).sizes) == pytest.approx(A, rel=3e-4)  # the mean of a turn is right to a sample
    assert Ramp(run, 0.0).largest(run.pointing)[0] == pytest.approx(A, rel=3e-4)


def test_slow_rotation_is_as_large_as_between_the_places_where_it_is_looked_at():
    # the crests of an order 300 lie between 2048 places, those of an order 8 beside a line of the output between 64
    for lines in ([(300, A, 0.1)], [(8, A, math.pi / 8.0), (0.02, 0.1 * A, 0.4)]):
        error = sw.KinematicError(tuple(sw.Line(*line) for line in lines))
        top = sum(line.amplitude * math.sin(math.pi * min(line.order, 0.5)) for line in error.lines)  # in a turn
        assert quasi_static(SYSTEM._replace(error=error), POINT) == pytest.approx(top, rel=1e-4)


def test_what_a_run_up_adds_to_the_speeds_of_the_steady_curve_stands_by_itself():
    # the curve has its resonance elsewhere: the same drive with a load torque on a stiffer piece
    stiffer = followed(OMEGA, A * transmissibility(OMEGA, omega_0=1.2 * OMEGA_0))
    limit = 6.0 * A
    alone = speeds_to_avoid(SYSTEM, stiffer, POINT, limit)
    both = speeds_to_avoid(SYSTEM, stiffer, POINT, limit, passed=in_run(ramp(1e-3), 0.0))
    top = 0.5 * OMEGA_0  # where the order 2 meets omega_0
    assert len(alone.bands) == 1
    assert not any(low < top < high for low, high in alone.bands)
    assert alone.bands == both.bands
    ((low, high),) = both.passed
    assert low < top < high
    assert transmissibility(np.array([low, high])) == pytest.approx(6.0, rel=0.05)
    assert both.largest_passed == pytest.approx((top, np.max(A * transmissibility(OMEGA))), rel=0.02)


def test_the_bands_of_a_run_up_are_those_above_the_limit_where_there_is_one():
    limit = 3.0 * A
    found = speeds_to_avoid(SYSTEM, followed(OMEGA, 0.0 * OMEGA + A), POINT, limit, in_run(ramp(0.0), 0.0))
    assert found.bands == ()
    ((low, high),) = found.passed
    assert transmissibility(np.array([low, high])) == pytest.approx(3.0, rel=0.02)


def test_a_run_of_a_turn_or_two_has_no_oscillation_of_its_own():
    assert in_run(ramp(0.0), 59.98) is None


PUMPED = """
gear: {ratio: 50, law: {type: linear, K: 1e5 N*m/rad}}
motor: {inertia: 4.5 kg*cm^2, mode: held}
stiffness: {ripples: [{order: 2, depth: 10 %}]}
damping: {ratio: 1 %}
load: {inertia: 1.3 kg*m^2}
speed: {from: 2500 rpm, to: 2800 rpm, shaft: motor}
limit: {oscillation: 60 arcsec}
excitation: {kinematic_error: [{order: 2, amplitude: 23 arcsec}]}
"""


def test_speeds_without_a_stable_motion_are_avoided(tmp_path):
    (tmp_path / "pumped.yaml").write_text(PUMPED, encoding="utf-8")
    project = sw.read_project(tmp_path / "pumped.yaml")
    response = project.response(coexisting=False)
    system = project.system(reduced=True)
    found = speeds_to_avoid(system, response, operating_point(system), project.limit)
    (band,) = found.unstable
    assert found.bands == found.unstable
    assert found.largest < project.limit
    # Mathieu's first tongue: delta omega / omega_0 = depth/2 about 2 omega_0 over the order, less what the damping
    # takes (Nayfeh & Mook 1979, Nonlinear Oscillations, sec. 5.3): |omega - omega_0| < omega_0 sqrt((d/4)^2 - zeta^2)
    omega_0, depth, zeta = math.sqrt(1e5 / 1.3), 0.1, 0.01
    half = omega_0 * math.sqrt((depth / 4.0) ** 2 - zeta**2)
    assert band == pytest.approx((omega_0 - half, omega_0 + half), rel=1e-3)
    for omega, grows in ((omega_0, True), (band[0] - 1.5, False)):
        run = sw.simulate(project.system(omega), (1e-6, 0.0), np.linspace(0.0, 200.0 / omega * 2.0 * math.pi, 5_000))
        assert (run.peak(after=0.9 * run.t[-1]) > 10.0 * project.limit) == grows
