"""What assumed numbers leave open, against drives whose files have the other numbers."""

import json
import math
import re
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from assumed_axis import AXIS, axis
from click.testing import CliRunner
from scipy.integrate import solve_ivp

import strainwave as sw
from strainwave.app.commands.cli import cli
from strainwave.base.results import SolveError
from strainwave.base.units import ARCSEC
from strainwave.files.reading import from_text
from strainwave.files.variants import sureness
from strainwave.files.variants.sureness import CURVE_POINTS, how_sure
from strainwave.plot.drive import SURE, Drawn, drive_panels


def largest(project):
    found = project.response(coexisting=False)
    return float(found.oscillation[found.top])


@pytest.mark.slow
def test_the_ends_are_those_of_drives_whose_files_have_the_other_numbers():
    sure, nominal = axis().sureness, largest(axis())
    damping, band = sure.doubts
    assert (damping.ends, band.ends) == (("2 %", "5 %"), ("20 Hz", "45 Hz"))
    ratios = [nominal, *(largest(axis(ratio, more="")) for ratio in damping.ends)]
    bands = [nominal, *(largest(axis(band=one, more="")) for one in band.ends)]
    both = [largest(axis(ratio, one, more="")) for ratio in damping.ends for one in band.ends]
    every = [*bands, *ratios, *both]
    told = (damping.sizes, ratios), (band.sizes, bands), (sure.largest, every)
    for (least, most), sizes in told:  # drives within the ranges may lie beyond those at their ends
        assert least <= min(sizes) * (1.0 + 1e-6)
        assert most >= max(sizes) * (1.0 - 1e-6)
    assert damping.sizes == pytest.approx((min(ratios), max(ratios)), rel=1e-6)
    curve = axis().response(coexisting=False, points=CURVE_POINTS)
    size = np.interp(sure.omega, curve.omega, curve.oscillation)
    assert np.all(sure.low <= size * (1 + 1e-9))
    assert np.all(size <= sure.high * (1 + 1e-9))
    assert np.max(sure.high) == pytest.approx(sure.largest[1], rel=0.01)


def test_nothing_is_open_where_nothing_is_assumed():
    project = from_text(AXIS.replace("RATIO", "3 %").replace("BAND", "30 Hz, damping: 0.7"), Path("axis.yaml"))
    assert (project.assumed, project.digits(), project.digits(5)) == ((), 4, 5)
    assert project.sureness.sentences(project.limit) == ()
    assert project.sureness.drives == 0
    for word, names in (("assumed", ["excitation.accuracy"]), ("measured", [])):
        text = AXIS.replace("RATIO", "3 %").replace("BAND", "30 Hz, damping: 0.7")
        text = text.replace("kinematic_error: [{order: 2, amplitude: 23 arcsec}]", "accuracy: 60 arcsec")
        found = from_text(f"{text}sources: {{excitation.accuracy: {word}}}\n", Path("axis.yaml"))
        assert [one.name for one in found.assumed] == names


@pytest.mark.slow
def test_a_drive_that_no_file_may_have_is_left_out_and_said():
    fast = axis(band="60 Hz, lag: 1 ms").sureness
    assert fast.lost
    assert "bandwidth" in fast.lost[0]
    assert np.isfinite(fast.largest).all()


@pytest.mark.slow
def test_the_response_prints_three_digits_and_rows_and_json_has_all_digits(tmp_path):
    path = tmp_path / "axis.yaml"
    path.write_text(axis().text, encoding="utf-8")
    printed = CliRunner().invoke(cli, ["response", str(path)]).stdout
    size = largest(axis()) / ARCSEC
    assert f"largest oscillation: {size:.3g} arcsec at" in printed
    assert re.search(r"assumed +value +low +high +oscillation \[arcsec\] from +to\n +damping +3 % +2 % +5 %", printed)
    assert "below and above the limit of 60 arcsec" in printed
    assert "assumed: motor.loop.damping 0.7, motor.loop.bandwidth 30 Hz, damping.ratio 3 %; measured: load" in printed
    data = json.loads(CliRunner().invoke(cli, ["response", str(path), "--json"]).stdout)
    assert data["oscillation"]["oscillation_arcsec"] == pytest.approx(size, rel=1e-9)
    assert [row["what"] for row in data["how_sure"]["rows"]] == ["damping", "bandwidth"]
    assert {row["source"] for row in data["sources"]} == {"catalogue", "assumed", "yours", "measured"}


ZERO = "{order: 2, amplitude: 23 arcsec}, {order: 3, amplitude: 0 arcsec}"
HELD = AXIS.replace("{loop: {type: cascade, bandwidth: BAND}}", "{mode: held}").replace("RATIO", "3 %")
HELD = HELD.replace("{order: 2, amplitude: 23 arcsec}", ZERO) + "sources: {excitation: assumed, damping: assumed}\n"


@pytest.fixture(scope="module")
def held():
    return from_text(HELD, Path("axis.yaml"))


def test_speeds_without_a_stable_motion_are_left_out_of_the_band(held, monkeypatch):
    whole, tried = held.response(coexisting=False, points=CURVE_POINTS), []
    visited = np.flatnonzero(np.abs(whole.omega / np.median(whole.omega) - 1.0) > 0.2)
    top = visited[np.argmax(whole.oscillation[visited])]
    two_parts = SimpleNamespace(omega=whole.omega, oscillation=whole.oscillation, top=top, visited=lambda: visited)

    def few(project):
        tried.append(project)
        return two_parts

    monkeypatch.setattr(sureness, "solved", few)
    sure = how_sure(held)
    gap = np.isnan(sure.low)
    assert 0 < np.sum(gap) < len(gap)
    assert np.array_equal(gap, np.isnan(sure.high))
    bands = [curve for curve in drive_panels(whole, held, None, Drawn(sure=sure))[0].curves if curve.colour == SURE]
    assert len(bands) == 2
    assert all(np.isfinite(curve.y).all() and np.isfinite(curve.upper).all() for curve in bands)
    assert len(tried) == 8  # an error at its upper end is the error of the file
    assert sure.doubts[1].names == ("excitation.kinematic_error.0.amplitude",)  # a line of zero has no range


def test_the_sizes_without_a_band_are_those_of_the_curves_of_the_band(held):
    alone, banded = how_sure(held, band=False), how_sure(held)
    assert np.isnan(alone.low).all()
    assert np.isnan(alone.high).all()
    assert np.isfinite(banded.high).all()
    assert (alone.drives, alone.lost, len(alone.doubts)) == (banded.drives, (), 2)
    assert alone.largest == pytest.approx(banded.largest, rel=1e-12)
    for one, other in zip(alone.doubts, banded.doubts, strict=True):
        assert one.sizes == pytest.approx(other.sizes, rel=1e-12)


def test_each_panel_alone_names_the_curve_of_the_drive(held):
    whole = held.response(coexisting=False, points=CURVE_POINTS)
    error, torque = ({curve.label for curve in panel.curves} for panel in drive_panels(whole, held))
    assert {name for name in error if "stable" in name} == {name for name in torque if "stable" in name} != set()


def test_a_drive_that_cannot_be_computed_leaves_no_doubt(held, monkeypatch):
    def none(_):
        raise SolveError("no motion")

    monkeypatch.setattr(sureness, "solved", none)
    sure = how_sure(held)
    assert (sure.doubts, sure.drives) == ((), 0)
    assert sure.sentences(held.limit) == ("One variant cannot be computed: no motion",)


@pytest.mark.slow
def test_an_assumed_hysteresis_is_varied_and_leaves_three_digits():
    element = "hysteresis: {type: bouc_wen, K: 1.4e4 N*m/rad, ratio: 0, yield_twist: 10 arcsec}\n"
    text = HELD.replace("damping:", f"{element}damping:", 1).replace("{excitation: assumed, damping", "{hysteresis")
    project = from_text(text, Path("axis.yaml"))
    assert project.digits() == 3
    torque, twist = project.sureness.doubts
    assert (torque.names, twist.names) == (("hysteresis.K",), ("hysteresis.yield_twist",))
    assert twist.sentence.startswith("Yield twist of the hysteresis 10 arcsec is assumed; 5 arcsec to 15 arcsec")
    rows = (torque, "1.4e4", ("7e3", "1.4e4", "2.1e4")), (twist, "10 arcsec", ("5 arcsec", "10 arcsec", "15 arcsec"))
    for doubt, own, texts in rows:
        ends = [largest(from_text(text.replace(own, value), Path("axis.yaml"))) for value in texts]
        assert doubt.sizes == pytest.approx((min(ends), max(ends)), rel=1e-3)
        assert max(ends) > 1.02 * min(ends)


def test_a_project_that_is_changed_in_python_has_the_doubts_of_its_own_drive(held, monkeypatch):
    seen = []

    def stop(project):
        seen.append((project.drive.J_l, project.drive.law.K1))
        raise SolveError("no motion")

    changed = sw.replaced(held, {"gear.K1": "3e4 N*m/rad"}).with_load_inertia(2.0)
    monkeypatch.setattr(sureness, "solved", stop)
    how_sure(changed)
    assert {*seen} == {(2.0, 3e4)}


def test_the_load_that_the_range_is_for_is_named_where_the_file_has_a_range_of_loads():
    ranged = "excitation: {load_torque: {mean: {from: -20 N*m, to: 60 N*m}}, "
    assert "excitation: {" in HELD
    for text, load in ((HELD, ""), (HELD.replace("excitation: {", ranged, 1), " under the worst of 3 load torques")):
        together = from_text(text, Path("axis.yaml")).sureness.sentences(None)[2]
        assert together.startswith(f"oscillation with assumed damping and kinematic error varied together{load}: ")


@pytest.mark.slow
def test_the_range_is_for_the_load_of_the_verdict():
    mean = "mean: {from: 10 N*m, to: 30 N*m}"
    text = HELD.replace("inertia: ", "drag: {type: angle_torque, amplitude: 40 N*m}, inertia: ", 1)
    project = from_text(text.replace("excitation: {", f"excitation: {{load_torque: {{{mean}}}, ", 1), Path("axis.yaml"))
    worst = max(project.analyze(advice=False).load_cases, key=lambda case: case.avoid.largest)
    assert worst.torque == pytest.approx(70.0)
    sure = project.sureness
    assert sure.load == " under the worst of 3 load torques"
    error = sure.doubts[1]
    assert error.ends[1] == "23 arcsec"  # that of the file
    assert error.sizes[1] == pytest.approx(worst.avoid.largest, rel=1e-6)


LOADED = AXIS.replace("excitation: {", "excitation: {load_torque: {mean: {from: 0 N*m, to: 150 N*m}}, ")
STIFFER = LOADED.replace("BAND", "30 Hz, damping: 0.7").replace("RATIO", "3 %")
STIFFER += "sources: {motor.loop: assumed, damping: assumed}\n"


@pytest.mark.slow
def test_a_change_that_is_worst_under_another_load_than_the_drive_itself_counts():
    project = from_text(STIFFER, Path("axis.yaml"))
    stiff = sw.replaced(project, {"motor.loop.bandwidth": "45 Hz", "damping.ratio": "2 %"}, retune=True)
    sizes = [
        float(np.max(one.under(torque).response(coexisting=False, points=40).oscillation))
        for one, torque in ((project, 0.0), (project, 150.0), (stiff, 0.0), (stiff, 150.0))
    ]
    assert sizes[0] < sizes[1] < project.limit < sizes[2]
    sure = project.sureness
    assert sure.largest[1] == pytest.approx(max(sizes), rel=1e-3)
    assert "below and above the limit" in sure.sentences(project.limit)[-1]


NARROW = """
gear:
  ratio: 100
  law: {type: piecewise_linear, T1: 14 N*m, T2: 48 N*m, K1: 3.1e4 N*m/rad, K2: 5.0e4 N*m/rad, K3: 5.7e4 N*m/rad}
motor: {inertia: 3 kg*cm^2, loop: {type: cascade, bandwidth: 30 Hz, damping: 0.7}}
load: {inertia: 4 kg*m^2}
damping: {ratio: 1 %}
speed: {from: 434 rpm, to: 452 rpm, shaft: motor}
sources: {motor.loop: assumed}
excitation: {kinematic_error: [{order: 2, amplitude: 20 arcsec}]}
"""


def integrated(project, rpms):
    """Largest oscillation [arcsec] of the pointing error from one speed to the next, by equations of its own.

    They are of a cascade, three slopes and a load.
    """
    y, sizes = np.zeros(5), []
    for rpm in rpms:
        error = turned(project, rpm, y)
        y = error[:, -1]
        sizes.append(float(np.max(np.abs(error[2] - np.mean(error[2, :-1])))) / ARCSEC)
    return max(sizes)


def turned(project, rpm, start):
    K_v, K_p, T_n = project.train.motor.control
    N, J_m, J_l, B, omega, size = 100.0, 3e-4, 4.0, project.drive.B, rpm * math.pi / 30.0, 20.0 * ARCSEC
    knots = np.array([0.0, 14.0, 48.0]), np.array([0.0, 14.0 / 3.1e4, 14.0 / 3.1e4 + 34.0 / 5e4])

    def rates(t, y):
        d, d_rate, q, q_rate, z = y
        theta = omega * t + d
        u = d / N - q - size * math.cos(2.0 * theta)
        slope = -2.0 * size * math.sin(2.0 * theta)
        beyond = 5.7e4 * max(abs(u) - knots[1][-1], 0.0)
        torque = math.copysign(np.interp(abs(u), *knots[::-1]) + beyond, u)
        torque += B * (d_rate / N - q_rate - slope * (omega + d_rate))
        w = d_rate + K_v * d
        motor = -K_p * (w + z / T_n) - (1.0 / N - slope) * torque
        return d_rate, motor / J_m, q_rate, torque / J_l, w

    turn = 2.0 * math.pi / omega
    times = np.linspace(98 * turn, 100 * turn, 801)
    return solve_ivp(rates, (0.0, times[-1]), start, "DOP853", times, rtol=1e-8, atol=1e-12).y


@pytest.mark.slow
def test_the_largest_inside_a_range_of_assumed_numbers_counts():
    project = from_text(NARROW, Path("axis.yaml"))
    (bandwidth,) = project.sureness.doubts
    drives = {band: sw.replaced(project, {"motor.loop.bandwidth": f"{band} Hz"}, retune=True) for band in (35, 45)}
    found = drives[35].response(coexisting=False)
    top = found.omega[found.top] * 30.0 / math.pi
    own = {
        band: integrated(drive, np.linspace(434.0, 452.0 if band == 45 else top, 5)) for band, drive in drives.items()
    }
    assert own[45] < 0.86 * own[35]
    assert bandwidth.sizes[1] / ARCSEC == pytest.approx(own[35], rel=0.01)
    rng = np.random.default_rng(5)
    drawn = [largest(sw.replaced(project, {"motor.loop.bandwidth": f"{band} Hz"}, retune=True))
             for band in rng.uniform(20.0, 45.0, 40)]  # fmt: skip
    assert max(drawn) <= 1.01 * bandwidth.sizes[1]


def test_every_number_that_is_varied_is_named():
    text = HELD.replace(ZERO, "{order: 2, amplitude: 23 arcsec}, {order: 4, amplitude: 8 arcsec}")
    sure = how_sure(from_text(text, Path("axis.yaml")))
    error = sure.doubts[1]
    assert error.sentence.startswith(
        "Kinematic error 23 arcsec and 8 arcsec is assumed; 11.5 arcsec and 4 arcsec to 23 arcsec and 8 arcsec give"
    )
