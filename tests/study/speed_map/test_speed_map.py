"""Speed maps against closed forms, SciPy's integrator and the verbs that they are built of."""

import json
import re
from pathlib import Path
from types import SimpleNamespace

import article_equation
import numpy as np
import pytest
from click.testing import CliRunner
from loop_machines import SLOPES as SHG_25_100
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq, minimize_scalar
from three_slopes import three_slopes

import strainwave as sw
from strainwave.app.commands import cli as command
from strainwave.study.speed_map import decide
from strainwave.study.speed_map.intervals import common, complement
from strainwave.study.speed_map.motions import OMEGA, OSCILLATION, LooseMotion
from strainwave.study.speed_map.rules import Rules, bands_of
from strainwave.study.speed_map.search import MotionStart
from strainwave.study.speed_map.under_load import case_of, seeds_for, under_load

pytestmark = pytest.mark.slow

ARCSEC, RPM = np.pi / 648_000.0, np.pi / 30.0
EDGE = 5e-4  # accuracy of the ends of bands between points of a curve
J, K, RATIO = 1.3, 1e5, 0.03
OMEGA_0 = np.sqrt(K / J)
B = 2.0 * RATIO * J * OMEGA_0
A = 23.0 * ARCSEC

TEXT = """
title: axis
gear: {{ratio: 50, law: {law}}}
motor: {{inertia: 4.5 kg*cm^2, mode: held}}
load: {{inertia: 1.3 kg*m^2}}
damping: {{ratio: 3 %}}
speed: {{from: 40 rad/s, to: 300 rad/s, shaft: motor}}
{more}
excitation:
  kinematic_error: [{{order: 2, amplitude: 23 arcsec}}]
  load_torque: {torque}
"""
LINEAR = "{type: linear, K: 1e5 N*m/rad}"
CUBIC = "{type: cubic, K: 1e5 N*m/rad, alpha: 2e5 1/rad^2}"


def project(tmp_path, law=LINEAR, more="", torque="{mean: -50 N*m}"):
    path = tmp_path / "axis.yaml"
    path.write_text(TEXT.format(law=law, more=more, torque=torque), encoding="utf-8")
    return sw.read_project(path)


def linear_oscillation(omega, stiffness=K, inertia=J, damping=B):
    """|x| of J x'' + B (x' - e') + K (x - e) = 0, e = A cos(2 omega t)."""
    w = 2.0 * omega
    through = stiffness + 1j * w * damping
    return A * abs(through / (through - inertia * w * w))


def test_the_largest_oscillation_is_that_of_the_crest_between_the_speeds(tmp_path):
    found = sw.speed_map(project(tmp_path), limit=60.0 * ARCSEC)
    top = minimize_scalar(
        lambda w: -linear_oscillation(w), bounds=(100.0, 180.0), method="bounded", options={"xatol": 1e-9}
    )
    speed, size = found.crests[0]
    assert speed == pytest.approx(top.x, rel=1e-4)  # the crest is flat
    assert size == pytest.approx(-top.fun, rel=1e-7)
    assert np.max(found.oscillation) < size


def test_a_linear_drive_has_the_closed_form_everywhere(tmp_path):
    limit = 3.0 * A
    found = sw.speed_map(project(tmp_path), limit=limit, loads=[-50.0, 0.0], search=False)
    exact = np.array([linear_oscillation(w) for w in found.speeds])
    np.testing.assert_allclose(found.oscillation, np.stack([exact, exact]), rtol=3e-3)
    torque = J * (2.0 * found.speeds) ** 2 * exact  # the gear carries the load's inertia and its mean torque
    np.testing.assert_allclose(found.torque[1], torque, rtol=3e-3)
    np.testing.assert_allclose(found.torque[0], torque + 50.0, rtol=3e-3)
    assert np.all(found.motions == 1)
    assert not found.subharmonic.any()
    half = 0.5 * OMEGA_0
    edges = [brentq(lambda w: linear_oscillation(w) - limit, *ends) for ends in ((40.0, half), (half, 300.0))]
    for bands in found.forbidden:
        np.testing.assert_allclose(bands, [edges], rtol=EDGE)
    np.testing.assert_allclose(found.windows, [[40.0, edges[0]], [edges[1], 300.0]], rtol=EDGE)


def test_amplification_and_margin_are_the_same_bands_by_other_names(tmp_path):
    drive = project(tmp_path)
    by_limit = sw.speed_map(drive, limit=3.0 * A, search=False)
    by_amplification = sw.speed_map(drive, amplification=3.0, search=False)
    np.testing.assert_allclose(by_amplification.forbidden[0], by_limit.forbidden[0], rtol=1e-9)
    assert by_limit.quasi_static == pytest.approx(A, rel=1e-6)
    (band,) = sw.speed_map(drive, margin=0.1, search=False).forbidden[0]
    peak = max(np.linspace(130.0, 145.0, 3001), key=linear_oscillation)
    np.testing.assert_allclose(band, [0.9 * min(peak, 0.5 * OMEGA_0), 1.1 * max(peak, 0.5 * OMEGA_0)], rtol=1e-3)


def test_inertias_move_the_band_as_their_square_root(tmp_path):
    inertias = np.array([0.9, 1.3, 2.0])
    found = sw.speed_map(project(tmp_path), load_inertias=inertias, limit=3.0 * A, search=False)
    assert found.load_name == "load inertia"
    for inertia, row, rule in zip(inertias, found.oscillation, found.vendor, strict=True):
        exact = [linear_oscillation(w, inertia=inertia) for w in found.speeds]
        np.testing.assert_allclose(row, exact, rtol=3e-3)
        assert rule.speed == pytest.approx(0.5 * np.sqrt(K / inertia), rel=1e-12)  # 30 f_n rpm


def settled(omega, alpha, y0, turns=120):
    """Oscillation [rad] on which the equation written out here settles, by DOP853."""

    def rhs(t, y):
        phase = 2.0 * omega * t
        u, du = y[0] - A * np.cos(phase), y[1] + 2.0 * omega * A * np.sin(phase)
        return [y[1], -(B * du + K * (u + alpha * u**3)) / J]

    period = np.pi / omega
    t = np.linspace(0.0, 2.0 * period, 257) + turns * period
    y = solve_ivp(rhs, (0.0, t[-1]), y0, method="DOP853", t_eval=t, rtol=1e-9, atol=1e-13).y[0]
    return np.max(np.abs(y - np.mean(y[:-1])))


@pytest.mark.slow
def test_both_motions_of_a_hysteresis_are_in_the_map_and_the_limit_forbids_by_the_larger(tmp_path):
    drive = project(tmp_path, CUBIC, torque="{mean: 0 N*m}")
    found = sw.speed_map(drive, limit=1e-3, speeds=np.linspace(100.0, 250.0, 601))
    curve = sw.frequency_response(drive.system(), (100.0, 250.0))
    told = sw.jumps(curve)
    assert {j.up: j.speed for j in found.jumps} == pytest.approx(
        {True: told.on_run_up[0].value, False: told.on_run_down[0].value}, rel=1e-4
    )
    assert {j.rises: j.speed for j in found.jumps} == pytest.approx(
        {True: told.jump_up, False: told.jump_down}, rel=1e-4
    )
    up, down = (f"{speed / RPM:.5g} rpm" for speed in (told.jump_up, told.jump_down))
    assert f"jumps up at {up} and drops at {down}" in str(found)  # as `response`
    inside = (found.speeds > told.jump_up) & (found.speeds < told.jump_down)
    assert np.all(found.motions[0, inside] == 2)
    middle = 0.5 * (told.jump_up + told.jump_down)
    at = int(np.argmin(np.abs(found.speeds - middle)))
    omega, starts = found.speeds[at], [(0.0, 0.0), (3.5e-3, 0.0), (-3.5e-3, 0.0), (0.0, 1.0), (2e-3, -0.8)]
    reached = [settled(omega, 2e5, y0) for y0 in starts]
    assert max(reached) > 2.0 * min(reached)
    assert found.oscillation[0, at] == pytest.approx(max(reached), rel=2e-3)
    assert not found.is_allowed(omega, 0.0)
    ((low, high),) = found.forbidden[0]
    assert high == pytest.approx(told.jump_down, rel=EDGE) if told.jump_down > told.jump_up else True
    assert settled(1.005 * high, 2e5, (3.5e-3, 0.0)) < 1e-3
    assert settled(0.995 * low, 2e5, (0.0, 0.0)) < 1e-3 < settled(1.005 * low, 2e5, (0.0, 0.0))


HYSTERETIC = """
gear: {ratio: 50, law: {type: cubic, K: 22042.6 N*m/rad, alpha: 9.44048e+06 1/rad^2}}
motor: {inertia: 25.287 kg*cm^2, mode: held}
load: {inertia: 1.7538 kg*m^2}
damping: {B: 5.788 N*m*s/rad}
hysteresis: {type: bouc_wen, K: 6395.3 N*m/rad, ratio: 0, yield_twist: 0.0001588 rad}
speed: {from: 22.7 rad/s, to: 194.5 rad/s, shaft: motor}
excitation: {kinematic_error: [{order: 2, amplitude: 1.207 arcsec}, {order: 6, amplitude: 4.191 arcsec}]}
limit: {oscillation: 59.4 arcsec}
"""


BEGUN_LATE = """
gear: {ratio: 80, law: {type: cubic, K: 50176.2 N*m/rad, alpha: 2.25066e+07 1/rad^2}}
motor: {inertia: 9.1861 kg*cm^2, mode: held}
load: {inertia: 1.1519 kg*m^2}
damping: {B: 27.8878 N*m*s/rad}
hysteresis: {type: bouc_wen, K: 14846 N*m/rad, ratio: 0, yield_twist: 3.417e-05 rad}
speed: {from: 60.7343 rad/s, to: 240.337 rad/s, shaft: motor}
excitation: {kinematic_error: [{order: 6, amplitude: 5.534 arcsec, phase: 75.9 deg}]}
limit: {oscillation: 20.655 arcsec}
"""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("text", "load", "speeds", "omega", "start", "numbers", "lines", "least"),
    [
        # of a law with memory the main curve alone was known: 17 arcsec, all speeds were allowed
        pytest.param(
            HYSTERETIC, -1.76, (68.9, 69.1), None, (9.08e-4, 0.433, -1.588e-4),
            (1.7538, 5.788, 22042.6, 9.44048e6, 6395.3, 1.588e-4), [(2, 1.207, 0.0), (6, 4.191, 0.0)], 250.0,
            id="isolated",
        ),
        # the range begins below the end of the large motion, to which few phases of a start lead
        pytest.param(
            BEGUN_LATE, 0.0, None, 60.9772, (3.53546e-4, 2.17234e-2, 3.417e-5),
            (1.1519, 27.8878, 50176.2, 2.25066e7, 14846.0, 3.417e-5), [(6, 5.534, np.radians(75.9))], 70.0,
            id="at-the-end-of-the-range",
        ),
    ],
)  # fmt: skip
def test_a_motion_of_a_gear_with_hysteresis_apart_from_the_curve_is_found(
    text, load, speeds, omega, start, numbers, lines, least, tmp_path
):
    path = tmp_path / "hysteretic.yaml"
    path.write_text(text)
    found = sw.speed_map(sw.read_project(path), loads=[load], speeds=speeds, threads=1)
    omega = omega or float(found.speeds[np.argmax(found.oscillation[0])])
    J, B, K, alpha, share_of_memory, yielding = numbers

    def by_hand(t, y):
        e = sum(a * ARCSEC * np.cos(k * omega * t + phase) for k, a, phase in lines)
        slope = -sum(a * ARCSEC * k * omega * np.sin(k * omega * t + phase) for k, a, phase in lines)
        u, strain, share = y[0] - e, y[1] - slope, abs(y[2]) / yielding
        gear = B * strain + K * (u + alpha * u**3) + share_of_memory * y[2]
        slip = strain - share * (0.5 * abs(strain) * np.sign(y[2]) + 0.5 * strain)
        return [y[1], -(gear + load) / J, slip]

    turn = 2.0 * np.pi / omega
    t = np.linspace(78.0, 80.0, 4097) * turn
    y = solve_ivp(by_hand, (0.0, t[-1]), start, t_eval=t, rtol=1e-7, atol=1e-10).y[0]
    assert 0.5 * np.ptp(y) > least * ARCSEC  # it stays for 80 turns
    assert not any(low <= omega <= high for low, high in found.allowed[0])
    if not speeds:
        assert found.allowed[0][0][0] < 63.5  # beyond the end of the large motion all is allowed
        assert found.allowed[0][-1][1] == found.speeds[-1]
    else:
        assert np.max(found.oscillation) == pytest.approx(np.max(np.abs(y - np.mean(y[:-1]))), rel=2e-4)
        assert len(found.allowed[0]) == 0


@pytest.mark.slow
def test_an_isolated_subharmonic_is_found_and_flagged(tmp_path):
    """Order 2 drives a vibration of order 1 near twice the resonance, apart from the main curve."""
    path = tmp_path / "axis.yaml"
    path.write_text(
        "gear: SHG-25-100\nload: {inertia: 1.2774 kg*m^2}\ndamping: {B: 7.798 N*m*s/rad}\n"
        "speed: {from: 120 rad/s, to: 200 rad/s, shaft: motor}\n"
        "excitation: {kinematic_error: [{order: 2, amplitude: 16.39 arcsec}], load_torque: {mean: -10.31 N*m}}\n",
        encoding="utf-8",
    )
    drive = sw.read_project(path)
    found = sw.speed_map(drive, limit=2e-4)
    alone = sw.speed_map(drive, limit=2e-4, search=False)
    at = int(np.argmin(np.abs(found.speeds - 165.0)))
    assert (alone.motions[0, at], found.motions[0, at]) == (1, 2)
    assert found.subharmonic[0, at]
    assert not found.subharmonic[0, 0]
    assert alone.is_allowed(165.0, -10.31)
    assert not found.is_allowed(165.0, -10.31)
    law, omega, amplitude = sw.catalogue.gear("SHG-25-100").law, found.speeds[at], 16.39 * ARCSEC

    def rhs(t, y):
        phase = 2.0 * omega * t
        u, du = y[0] - amplitude * np.cos(phase), y[1] + 2.0 * omega * amplitude * np.sin(phase)
        return [y[1], (10.31 - 7.798 * du - law.torque(u)) / 1.2774]

    best = 0.0
    for angle in np.arange(0.0, 2.0 * np.pi, np.pi / 4.0):
        y0 = [10.31 / law.K1 + 4e-4 * np.cos(angle), 4e-4 * omega * np.sin(angle)]
        period = 2.0 * np.pi / omega
        t = (80.0 + np.linspace(0.0, 1.0, 257)) * period
        y = solve_ivp(rhs, (0.0, t[-1]), y0, method="DOP853", t_eval=t, rtol=1e-8, atol=1e-12).y[0]
        best = max(best, np.max(np.abs(y - np.mean(y[:-1]))))
    assert found.oscillation[0, at] == pytest.approx(best, rel=5e-3)


def test_a_campbell_line_is_the_exact_period_of_the_duffing_spring(tmp_path):
    found = sw.speed_map(project(tmp_path, CUBIC, torque="{mean: 0 N*m}"), search=False, orders=(3,))
    two, three = found.lines
    assert (two.order, two.excited, three.order, three.excited) == (2, True, 3, False)
    assert two.speed[0] == pytest.approx(0.5 * OMEGA_0, rel=1e-9)
    np.testing.assert_allclose(3.0 * three.speed, 2.0 * two.speed, rtol=1e-12)
    alpha, i = 2e5, len(two.amplitude) // 2
    quiet = sw.Oscillator(J, 0.0, sw.Cubic(K, alpha), sw.Harmonic(0.0), 1.0)
    peak = float(sw.numerics.backbone(quiet, [two.amplitude[i]]).peak[0])

    def slowness(s):  # 1/speed over the angle x = peak sin s, from the energy
        return 1.0 / np.sqrt(K / J * (1.0 + 0.5 * alpha * peak**2 * (1.0 + np.sin(s) ** 2)))

    period = 4.0 * quad(slowness, 0.0, 0.5 * np.pi, epsabs=0.0, epsrel=1e-12)[0]
    assert two.speed[i] == pytest.approx(0.5 * 2.0 * np.pi / period, rel=1e-6)


def test_lines_of_a_train_with_a_loop_are_its_modes(tmp_path):
    text = TEXT.replace("mode: held", "loop: {{type: position_loop, K_p: 60 N*m/rad, K_d: 0.05 N*m*s/rad}}")
    path = tmp_path / "axis.yaml"
    path.write_text(text.format(law=LINEAR, more="", torque="{mean: 0 N*m}"), encoding="utf-8")
    found = sw.speed_map(sw.read_project(path), search=False)
    J_m, N, K_p, K_d = 4.5e-4, 50.0, 60.0, 0.05
    M = np.diag([J_m, J])
    C = np.array([[K_d + B / N**2, -B / N], [-B / N, B]])
    S = np.array([[K_p + K / N**2, -K / N], [-K / N, K]])
    A_ = np.block([[np.zeros((2, 2)), np.eye(2)], [-np.linalg.solve(M, S), -np.linalg.solve(M, C)]])
    poles = np.linalg.eigvals(A_)
    modes = np.sort([abs(p) for p in poles if p.imag > 0.0 and -p.real < 0.5 * abs(p)])
    assert [line.mode for line in found.lines] == list(range(1, len(modes) + 1))
    np.testing.assert_allclose([2.0 * line.speed[0] for line in found.lines], modes, rtol=1e-6)


def test_cogging_of_a_motor_with_a_loop_is_an_order_of_the_map(tmp_path):
    drag = "loop: {{bandwidth: 30 Hz}}, drag: {{type: angle_torque, amplitude: 0.05 N*m, order: 3}}"
    path = tmp_path / "axis.yaml"
    path.write_text(
        TEXT.replace("mode: held", drag).format(law=LINEAR, more="", torque="{mean: 0 N*m}"), encoding="utf-8"
    )
    found = sw.speed_map(sw.read_project(path), search=False)
    assert {line.order for line in found.lines if line.excited} == {2, 3}


def test_the_lists_of_the_vendor_rule_and_its_band_part_the_range(tmp_path):
    found = sw.speed_map(project(tmp_path, CUBIC), limit=3.0 * A, search=False)
    (rule,), span = found.vendor, (40.0, 300.0)
    assert rule.frequency == pytest.approx(OMEGA_0 / (2.0 * np.pi), rel=1e-12)
    right = common(found.forbidden[0], np.array([rule.band]))
    lists = [rule.safe, rule.needless, rule.misleading, right]
    assert sum(float(np.sum(np.diff(some))) for some in lists) == pytest.approx(260.0, rel=1e-9)
    for omega in np.linspace(41.0, 299.0, 173):
        by_rule, by_map = not rule.band[0] <= omega <= rule.band[1], found.is_allowed(omega, -50.0)
        name = {(True, True): 0, (False, True): 1, (True, False): 2, (False, False): 3}[by_rule, by_map]
        assert [bool(np.any((some[:, 0] <= omega) & (omega <= some[:, 1]))) for some in lists].index(True) == name
    np.testing.assert_allclose(found.allowed[0], complement(found.forbidden[0], span))
    assert len(rule.misleading)  # the mean torque stiffens the spring: the resonance lies above the rule's


def test_the_sentence_about_the_vendor_rule_is_about_every_load(tmp_path):
    found = sw.speed_map(project(tmp_path, CUBIC), limit=3.0 * A, loads=[-400.0, -50.0, 0.0], search=False)
    sets = [(len(rule.needless), len(rule.misleading)) for rule in found.vendor]
    needless, misleading = (sum(bool(one[i]) for one in sets) for i in (0, 1))
    under = "under {} of 3 loads the rule {} [0-9., a-z]+ rpm, but the map {}"
    for count, verb, other in ((needless, "forbids", "allows"), (misleading, "allows", "forbids")):
        assert re.search(under.format(count, verb, other), found.vendor_sentence)
    assert found.vendor_sentence in " ".join(str(found).split())
    one = sw.speed_map(project(tmp_path, CUBIC), limit=3.0 * A, search=False)
    assert one.vendor_sentence == one.vendor[0].sentence
    inertias = sw.speed_map(project(tmp_path), limit=3.0 * A, load_inertias=[1.0, 4.0], search=False)
    f_n = np.sqrt(K / np.array([4.0, 1.0])) / (2.0 * np.pi)
    assert f"f_n = {f_n[0]:.3g} to {f_n[1]:.3g} Hz" in inertias.vendor_sentence


def test_a_torque_beyond_the_ratings_of_the_gear_is_a_failure(tmp_path):
    path = tmp_path / "small.yaml"
    text = TEXT.format(law=LINEAR, more="", torque="{mean: -50 N*m}").replace("1.3 kg", "0.2 kg")
    path.write_text(text.replace("{ratio: 50, law: " + LINEAR + "}", "CSG-20-50"), encoding="utf-8")
    drive, gear = sw.read_project(path), sw.catalogue.gear("CSG-20-50")
    beyond = sw.speed_map(drive, loads=[-1.1 * gear.repeated_peak_torque], search=False)
    assert any("above the momentary torque of CSG-20-50, 127 N*m" in failure for failure in beyond.failures)
    within = sw.speed_map(drive, loads=[-10.0], search=False)
    assert within.torque.max() < gear.repeated_peak_torque
    assert within.failures == ()


def test_scatter_gives_the_quantiles_of_the_units(tmp_path):
    drive = project(tmp_path, more="scatter: {load.inertia: 10 %}\n")
    units = list(sw.sample.scattered(drive, 9, seed=1))
    found = sw.speed_map(drive, units=units, speeds=np.linspace(60.0, 280.0, 12), limit=3.0 * A, search=False)
    own = [(one.drive.J_l, one.drive.B) for one in units]  # the ratio of the file gives each its own B
    each = np.array([[linear_oscillation(w, K, inertia, damping) for w in found.speeds] for inertia, damping in own])
    np.testing.assert_allclose(found.scatter.worst[0], each.max(axis=0), rtol=3e-3)
    np.testing.assert_allclose(found.scatter.oscillation[1, 0], np.median(each, axis=0), rtol=3e-3)
    np.testing.assert_allclose(found.scatter.forbidden[0], np.mean(each > 3.0 * A, axis=0), atol=1e-12)
    assert found.to_xarray()["quantile"].dims == ("share", "load", "speed")
    free = [not np.any(each[:, i] > 3.0 * A) for i in range(12)]
    windows = found.unit_windows
    assert [bool(np.any((windows[:, 0] <= w) & (w <= windows[:, 1]))) for w in found.speeds] == free
    assert f"{each.max() / ARCSEC:.3g}"[:3] in found.units_sentence.split("largest oscillation ")[1]


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"speeds": (100.0, 100.0)}, "low < high"),
        ({"speeds": (300.0, 100.0)}, "low < high"),
        ({"limit": -1.0}, "limit"),
        ({"margin": 1.0}, "less than 1"),
        ({"loads": [-5.0], "load_inertias": [1.0]}, "give one of them"),
        ({"load_inertias": [0.0]}, "must be positive"),
    ],
)
def test_bad_input_gets_one_sentence(tmp_path, options, said):
    with pytest.raises(ValueError, match=said) as told:
        sw.speed_map(project(tmp_path), search=False, **options)
    assert "\n" not in str(told.value)


@pytest.mark.slow
def test_a_range_in_which_only_the_smaller_motion_meets_the_limit_is_forbidden_by_the_larger(tmp_path):
    drive = project(tmp_path, CUBIC, torque="{mean: 0 N*m}")
    jumps = {j.up: j.speed for j in sw.speed_map(drive, limit=1e-3, search=False).jumps}
    both = np.linspace(jumps[False] + 2.0, jumps[True] - 2.0, 9)
    small, large = settled(both[-1], 2e5, (0.0, 0.0)), settled(both[0], 2e5, (1.9e-3, 0.0))
    found = sw.speed_map(drive, speeds=both, limit=0.9 * large)
    assert small < 0.5 * found.rules.limit  # one motion meets it
    assert len(found.windows) == 0
    assert np.min(found.oscillation) == pytest.approx(large, rel=3e-3)
    (said,) = found.failures
    least = re.search(r"at least ([\d.]+) arcsec, its minimum at ([\d.]+) rpm with 0 N·m", said)
    assert [float(text) for text in least.groups()] == pytest.approx([large / ARCSEC, both[0] / RPM], rel=3e-3)


def test_a_limit_that_no_speed_meets_forbids_all_and_names_both_numbers(tmp_path):
    found = sw.speed_map(project(tmp_path), limit=1e-3 * ARCSEC, search=False)
    assert len(found.windows) == 0
    (said,) = found.failures
    assert said.startswith("The limit of 0.001 arcsec cannot be met at any speed: the largest oscillation at ")
    assert "FAIL: The limit" in str(found)


def test_remarks_tell_of_orders_that_meet_nothing_and_of_a_limit_below_the_static_error(tmp_path):
    found = sw.speed_map(project(tmp_path), limit=0.5 * A, orders=(40,), search=False)
    assert any("orders without a resonance in this speed range: 40" in remark for remark in found.remarks)
    assert any("below the gear error at very low speed" in remark for remark in found.remarks)
    (band,) = found.forbidden[0]
    assert band[0] == 40.0


def test_a_map_has_its_arrays_in_xarray(tmp_path):
    found = sw.speed_map(project(tmp_path), loads=[-50.0, 0.0], search=False)
    data = found.to_xarray()
    assert dict(data.sizes)["load"] == 2
    assert data["oscillation"].attrs["units"] == "rad"
    table = found.to_dataframe()
    np.testing.assert_array_equal(table.index, found.speeds)
    np.testing.assert_array_equal(table[["oscillation -50.0", "oscillation 0.0"]], found.oscillation.T)
    np.testing.assert_array_equal(data["forbidden_low"].values, np.concatenate(found.forbidden)[:, 0])


@pytest.mark.slow
def test_the_command_writes_tables_and_the_figure(tmp_path):
    drive = project(tmp_path, more="limit: {oscillation: 69 arcsec}\n")
    result = CliRunner().invoke(
        command.cli, ["speed-map", str(drive.path), "-o", str(tmp_path / "out"), "--loads", "-50 N*m:0 N*m:2", "--json"]
    )
    assert result.exit_code == 0, result.stderr
    told = json.loads(result.stdout)
    half = 0.5 * OMEGA_0
    low, high = (brentq(lambda w: linear_oscillation(w) - 3.0 * A, *ends) for ends in ((40.0, half), (half, 300.0)))
    np.testing.assert_allclose(told["loads"][0]["forbidden_rpm"], [[low / RPM, high / RPM]], rtol=1e-3)
    assert sorted(p.name for p in (tmp_path / "out").iterdir()) == [
        "bands.csv", "campbell.csv", "cells.csv", "speed-map.svg"
    ]  # fmt: skip
    cells = np.genfromtxt(tmp_path / "out" / "cells.csv", delimiter=",", names=True)
    text = (tmp_path / "out" / "speed-map.svg").read_text(encoding="utf-8")
    assert 'viewBox="0 0 430 ' in text  # read on a telephone
    exact = [linear_oscillation(w * RPM) for w in cells["motor_speed_rpm"]]
    np.testing.assert_allclose(cells["oscillation_rad"], exact, rtol=3e-3)


@pytest.mark.slow
def test_the_command_writes_the_units_that_scatter(tmp_path):
    drive = project(tmp_path, more="limit: {oscillation: 69 arcsec}\nscatter: {load.inertia: 10 %}\n")
    result = CliRunner().invoke(
        command.cli, ["speed-map", str(drive.path), "-o", str(tmp_path / "out"), "--units", "3"]
    )  # fmt: skip
    assert result.exit_code == 0, result.stderr
    assert "allowed for all 3 units under every load" in result.stdout
    cells = np.genfromtxt(tmp_path / "out" / "cells.csv", delimiter=",", names=True)
    worst, share = cells["oscillation_worst_unit_rad"], cells["share_of_units_forbidden"]
    np.testing.assert_array_equal(worst > 69 * ARCSEC, share > 0.0)
    np.testing.assert_array_equal(cells["oscillation_95_percent_of_units_rad"], worst)


@pytest.mark.parametrize(
    ("options", "code", "said"),
    [
        (["--limit", "3 kg"], 2, "--limit"),
        (["--loads", "-60 N*m:0 N*m"], 2, "does not end in a number of values"),
        (["--speeds", "300 rpm:300 rpm"], 2, "--speeds: '300 rpm' to '300 rpm' is not a range"),
        (["--speeds", "300 rpm:400 rpm:500 rpm"], 2, "is not a range; write a smaller and a larger value"),
        (["--speeds", "300 rpm"], 2, "is not a range"),
        (["--loads", "-60 N*m:0 N*m:\u00b2"], 2, "does not end in a number of values from 1 to 1000"),
        (["--loads", "-60 N*m:0 N*m:1000000000"], 2, "does not end in a number of values from 1 to 1000"),
        (["--units", "8"], 1, "has no scatter"),
    ],
)
def test_the_command_refuses_in_one_sentence_and_writes_nothing(tmp_path, options, code, said):
    drive = project(tmp_path)
    out = tmp_path / "out"
    result = CliRunner().invoke(command.cli, ["speed-map", str(drive.path), "-o", str(out), *options])
    assert result.exit_code == code, result.output
    assert said in result.stderr
    assert "Traceback" not in result.stderr
    assert not out.exists()


def test_a_speed_that_a_band_passes_between_two_inertias_is_not_allowed_between_them(tmp_path):
    limit = 3.0 * A
    found = sw.speed_map(project(tmp_path), load_inertias=[0.9, 2.0], limit=limit, search=False)
    (light,), (heavy,) = found.forbidden
    assert heavy[1] < light[0]
    inertias = np.linspace(0.9, 2.0, 45)
    for omega in np.linspace(45.0, 295.0, 101):
        exact = [linear_oscillation(omega, inertia=inertia) <= limit for inertia in inertias]
        mapped = [found.is_allowed(omega, inertia) for inertia in inertias]
        assert all(safe or not allowed for safe, allowed in zip(exact, mapped, strict=True))
    assert not found.is_allowed(0.5 * (heavy[1] + light[0]), 1.4)
    assert found.is_allowed(0.5 * (heavy[1] + light[0]), 0.9)
    assert found.is_allowed(50.0, 1.4)
    for beyond in ((50.0, 0.89), (50.0, 2.01), (39.9, 1.4), (300.1, 1.4)):
        assert not found.is_allowed(*beyond)


def test_no_motion_is_searched_where_a_light_load_only_follows_the_error(tmp_path):
    found = sw.speed_map(project(tmp_path), load_inertias=[1e-9], limit=3.0 * A)
    np.testing.assert_allclose(found.oscillation, A, rtol=1e-6)
    assert np.all(found.motions == 1)
    assert not found.forbidden[0].size


@pytest.mark.parametrize(("motor", "size"), [("mode: held", 20), ("loop: {type: speed, bandwidth: 48 Hz}", 1)])
def test_a_load_without_a_known_motion_is_forbidden_and_the_others_keep_their_bands(tmp_path, motor, size):
    """A free vibration within the gap has no stiffness: the Campbell diagram has no lines then."""
    path = tmp_path / "loose.yaml"
    path.write_text(
        f"""
gear: {{ratio: 100, law: {{type: backlash, K: 3e4 N*m/rad, half_gap: 1e-4 rad}}}}
motor: {{inertia: 3e-4 kg*m^2, {motor}}}
load: {{inertia: 0.5 kg*m^2}}
damping: {{B: 10 N*m*s/rad}}
speed: {{from: 50 rad/s, to: 400 rad/s, shaft: motor}}
excitation: {{kinematic_error: [{{order: 2, amplitude: {size} arcsec}}]}}
""",
        encoding="utf-8",
    )
    drive = sw.read_project(path)
    found = sw.speed_map(drive, loads=[-10.0, 0.0, 10.0], limit=3e-4, search=False)
    np.testing.assert_allclose(found.forbidden[1], [[50.0, 400.0]])
    np.testing.assert_allclose(found.forbidden[0], found.forbidden[2], rtol=1e-6)  # the law is odd
    assert found.allowed[0].size
    assert not found.windows.size
    assert "with a load torque of 0" in " ".join(found.remarks)
    with pytest.raises(sw.SolveError, match="no stable steady motion"):
        sw.speed_map(drive, loads=[0.0], limit=3e-4, search=False)


def test_a_mode_that_is_a_resonance_at_some_amplitudes_alone_does_not_stop_the_map(tmp_path):
    path = tmp_path / "loop.yaml"
    path.write_text(
        """
gear: CSG-40-50
motor: {inertia: 4.5 kg*cm^2, loop: {bandwidth: 30 Hz}}
load: {inertia: 1.3 kg*m^2}
damping: {ratio: 3 %}
speed: {from: 1000 rpm, to: 3000 rpm, shaft: motor}
excitation: {kinematic_error: [{order: 2, amplitude: 23 arcsec}]}
""",
        encoding="utf-8",
    )
    found = sw.speed_map(sw.read_project(path), loads=np.linspace(-60.0, 0.0, 9), search=False)
    assert {line.load for line in found.lines} == set(found.loads)
    for line in found.lines:
        assert np.all(np.isfinite(line.speed))
        assert line.speed.shape == line.amplitude.shape


ACROSS = """
title: corner
gear: {ratio: 100, law: {type: piecewise_linear, K1: 31e3 N*m/rad, K2: 50e3 N*m/rad, K3: 57e3 N*m/rad,
                         T1: 14 N*m, T2: 48 N*m}}
motor: {inertia: 3e-4 kg*m^2, mode: held}
load: {inertia: 0.437 kg*m^2}
damping: {B: 8.76 N*m*s/rad}
speed: {from: 400 rad/s, to: 690 rad/s, shaft: motor}
excitation:
  load_torque: {mean: 11.5 N*m}
  kinematic_error:
    - {order: 1, amplitude: 22.9 arcsec, phase: 2.8 rad}
    - {order: 2, amplitude: 4.2 arcsec, phase: 4.56 rad}
"""


def repeats_after_a_turn(omega):
    """Whether the drive `ACROSS`, written out here, settles on a motion as short as its excitation, by DOP853."""
    lines = ((1, 22.9 * ARCSEC, 2.8), (2, 4.2 * ARCSEC, 4.56))

    def rhs(t, y):
        e = sum(a * np.cos(k * omega * t + p) for k, a, p in lines)
        de = -sum(k * omega * a * np.sin(k * omega * t + p) for k, a, p in lines)
        return [y[1], (-11.5 - 8.76 * (y[1] - de) - three_slopes(y[0] - e, SHG_25_100)) / 0.437]

    turn = 2.0 * np.pi / omega
    t = 200.0 * turn + np.linspace(0.0, 2.0 * turn, 129)
    y0 = [-11.5 / 31e3 + 1e-6, 0.0]
    y = solve_ivp(rhs, (0.0, t[-1]), y0, method="DOP853", t_eval=t, rtol=1e-8, atol=1e-12, max_step=turn / 16).y[0]
    return bool(np.max(np.abs(y[:65] - y[64:])) < 0.02 * np.ptp(y))


@pytest.mark.slow
def test_a_stable_motion_ends_where_its_stability_does_not_at_the_last_point_of_a_curve(tmp_path):
    path = tmp_path / "corner.yaml"
    path.write_text(ACROSS, encoding="utf-8")
    speeds = 2.0 * np.array([200.0, 269.0, 280.0, 295.0, 315.0, 345.0])
    found = sw.speed_map(sw.read_project(path), speeds=speeds, limit=1e-3, search=False)
    assert (found.motions[0] > 0).tolist() == [repeats_after_a_turn(w) for w in speeds]


DOUBLING = """\
gear: {ratio: 160, law: {type: cubic, K: 31933.8 N*m/rad, alpha: -42356.1 1/rad^2}}
motor: {inertia: 0.0092099 kg*cm^2, mode: held}
load: {inertia: 0.095846 kg*m^2}
damping: {ratio: 2.401 %}
speed: {from: 700 rad/s, to: 900 rad/s, shaft: motor}
excitation:
  kinematic_error:
    - {order: 1, amplitude: 32.67 arcsec, phase: -21.6 deg}
    - {order: 4, amplitude: 18.12 arcsec, phase: -23.1 deg}
    - {order: 6, amplitude: 17.26 arcsec, phase: -23.0 deg}
  load_torque: {mean: -35.94 N*m}
limit: {oscillation: 38.192 arcsec}
"""


def test_a_motion_beside_every_curve_is_not_tried_again_where_a_neighbouring_load_has_one():
    def at_load(*motions, curves=(0,)):
        return SimpleNamespace(loose=[LooseMotion(omega, size, 0.0, 1) for omega, size in motions], curves=curves)

    def left(*there, curves=(0,)):
        return [seed.omega for seed in seeds_for(seeds, here, at_load(*there, curves=curves))]

    here = at_load((100.0, 5.0), (100.0, 2.0), (120.0, 5.0))
    seeds, omegas = [MotionStart(w, (0.0, 0.0), 1) for w in (100.0, 110.0, 120.0)], [100.0, 110.0, 120.0]
    # 110 was followed there; 124 is more than 2.5 % from 120
    assert left((101.0, 4.99), (110.0, 9.0), (124.0, 5.0)) == [110.0, 120.0]
    assert left((101.0, 4.0)) == omegas
    assert left(curves=()) == []


STEEP = """
gear: {ratio: 30, law: {type: cubic, K: 130275 N*m/rad, alpha: 3.24e7 1/rad^2}}
motor: {inertia: 3 kg*cm^2, mode: held}
load: {inertia: 0.30475 kg*m^2}
damping: {ratio: 2 %}
hysteresis: {type: bouc_wen, K: 15021 N*m/rad, ratio: 0, yield_twist: 0.031 mrad}
speed: {from: 400 rad/s, to: 420 rad/s, shaft: motor}
excitation: {kinematic_error: [{order: 4, amplitude: 6.247 arcsec}]}
limit: {oscillation: 19 arcsec}
"""


def test_motions_of_a_law_with_memory_do_not_add_up_from_load_to_load(tmp_path, monkeypatch):
    """A steep law has its resonance at every speed of the range, and no curve has it."""
    (tmp_path / "axis.yaml").write_text(STEEP, encoding="utf-8")
    project, tried, before = sw.read_project(tmp_path / "axis.yaml"), [], decide.one_load.with_search_result

    def counted(loaded, case, span, speeds, seeds):
        tried.append(len(seeds))
        return before(loaded, case, span, speeds, seeds)

    monkeypatch.setattr(decide.one_load, "with_search_result", counted)
    found = sw.speed_map(project, loads=[-4.0, 0.0, 4.0])
    assert all(len(some) == 0 for some in found.allowed)
    assert sum(tried) <= 4


def test_a_motion_beside_every_curve_is_as_large_as_an_integration_of_it(tmp_path):
    """Orders 4 and 8, whose crests lie between 64 samples of a turn; the motion is not symmetric about its mean."""
    lines = "{order: 4, amplitude: 6.247 arcsec}, {order: 8, amplitude: 3 arcsec}"
    text = STEEP.replace("{order: 4, amplitude: 6.247 arcsec}", lines)
    (tmp_path / "axis.yaml").write_text(text, encoding="utf-8")
    of, span = sw.read_project(tmp_path / "axis.yaml"), (400.0, 401.0)
    loaded, (seed, *_) = under_load(case_of(of, 0.0, span), span)
    (motion,) = (one for one in loaded.loose if one.omega == seed.omega)
    system, (spring, loop) = of.system(seed.omega), of.system(seed.omega).law

    def rates(phase, y):
        u, du = y[0] - system.error.value(phase), y[1] - seed.omega * system.error.slope(phase)
        torque = spring.K * (u + spring.alpha * u**3) + loop.K * y[2] + system.B * du
        z_rate = du - abs(y[2] / loop.yield_twist) * (0.5 * abs(du) * np.sign(y[2]) + 0.5 * du)
        return np.array([y[1], -torque / system.J, z_rate]) / seed.omega

    last = 2.0 * np.pi * np.linspace(100.0, 102.0, 2 * 2048, endpoint=False)
    x = solve_ivp(rates, (0.0, last[-1]), seed.state, "RK45", last, rtol=1e-7, atol=1e-10, max_step=0.05).y[0]
    size = np.max(np.abs(x - np.mean(x)))
    assert motion.oscillation == pytest.approx(size, rel=1e-3)
    assert size > 1.01 * 0.5 * np.ptp(x)


def test_what_goes_on_where_a_motion_doubles_its_period_is_not_allowed(tmp_path):
    (tmp_path / "p.yaml").write_text(DOUBLING, encoding="utf-8")
    of = sw.read_project(tmp_path / "p.yaml")
    system, omega = of.system(794.0), 794.0

    def rates(phase, y):
        u, du = y[0] - system.error.value(phase), y[1] - omega * system.error.slope(phase)
        force = 35.94 - system.B * du - system.law.K * (u + system.law.alpha * u**3)
        return [y[1] / omega, force / (system.J * omega)]

    last = 2.0 * np.pi * np.linspace(92.0, 100.0, 2001)
    run = solve_ivp(rates, (0.0, last[-1]), [-0.00044836, 0.30957581], "LSODA", last, rtol=1e-8, atol=1e-10)
    # it repeats after four turns and stays, with more than ten times the limit
    assert run.y[:, 0] == pytest.approx(run.y[:, 1000], rel=0.01)
    assert np.abs(run.y[:, 0] - run.y[:, 500]).max() > 1e-3 * np.abs(run.y[:, 0]).max()
    assert 0.5 * np.ptp(run.y[0]) > 10.0 * of.limit
    found = sw.speed_map(of)
    assert not any(low < omega < high for low, high in found.allowed[0])
    assert any(low < omega < high for low, high in found.forbidden[0])


def test_no_sliver_between_forbidden_speeds_is_allowed_that_no_search_has_seen():
    run = np.zeros((2, 9))
    run[:, OMEGA], run[:, OSCILLATION] = (100.0, 200.0), 1.0
    loose = tuple(LooseMotion(w, 5.0, 0.0, 0) for w in (120.0, 124.0, 150.0))
    loaded = SimpleNamespace(quasi_static=1.0, runs=[(run, None)], loose=loose, jumping=(), flips=())
    found = bands_of(loaded, Rules(limit=2.0), (100.0, 200.0), [], 0.012)
    np.testing.assert_allclose(
        found.forbidden, [[120.0 / 1.012, 124.0 * 1.012], [150.0 / 1.012, 150.0 * 1.012]], rtol=1e-12
    )


@pytest.mark.slow
def test_the_map_of_a_forcing_speaks_of_the_forcing_and_judges_no_rule_of_a_motor(tmp_path):
    """At the ends of the band of the article's drive its error is twice the static one, by shooting."""
    project = Path(__file__).parents[3] / "examples/projects/article.yaml"
    asked = ["speed-map", str(project), "-o", str(tmp_path)]
    text = CliRunner().invoke(command.cli, asked).stdout
    assert "speeds of the forcing are forbidden if: oscillation above 2 times" in text
    assert re.search(r"forbidden speeds +jumps of the error\n +0 N·m +272\.62 to 472\.23 rad/s", text)
    assert "rpm" not in text
    assert "vendors" not in text
    told = json.loads(CliRunner().invoke(command.cli, [*asked, "--json"]).stdout)
    (band,) = told["loads"][0]["forbidden_rad_per_s"]
    static = brentq(lambda x: 7160.0 * (x + 0.1 * x**3) - article_equation.TORQUE, 0.0, 1.0)
    for omega in band:
        assert article_equation.shot(omega) == pytest.approx(2.0 * static, rel=2e-3)
    assert told["shaft"] == "forcing"
    assert told["vendor"] == []
    np.testing.assert_allclose(told["loads"][0]["forbidden_rpm"], [np.divide(band, RPM)], rtol=1e-12)
    assert np.genfromtxt(tmp_path / "cells.csv", delimiter=",", names=True)["forcing_rad_per_s"][0] == 10.47
    assert np.genfromtxt(tmp_path / "bands.csv", delimiter=",", names=True)["from_rad_per_s"][0] == pytest.approx(
        band[0]
    )
    drawn = (tmp_path / "speed-map.svg").read_text(encoding="utf-8")
    assert "forcing frequency" in drawn
    assert "rpm" not in drawn


@pytest.mark.slow
def test_a_drive_too_stiff_to_search_says_so_and_has_its_curve(tmp_path):
    """A loop of 30 Hz for 13000/50^2 kg m^2 stops a rotor of 4.5e-4 kg m^2 alone in 1/2.2e6 s."""
    (tmp_path / "heavy.yaml").write_text(
        "gear: CSG-40-50\nmotor: {inertia: 4.5 kg*cm^2, loop: {type: cascade, bandwidth: 30 Hz, damping: 0.7}}\n"
        "load: {inertia: 13000 kg*m^2}\ndamping: {ratio: 3 %}\nspeed: {from: 1000 rpm, to: 3000 rpm, shaft: motor}\n"
        "limit: {oscillation: 100 arcsec}\nexcitation: {kinematic_error: [{order: 2, amplitude: 23 arcsec}]}\n"
    )
    found = sw.speed_map(sw.read_project(tmp_path / "heavy.yaml"))
    assert any("simulations do not settle in the allowed steps" in text for text in found.remarks)
    assert found.forbidden[0].size == 0
