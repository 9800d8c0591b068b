"""The project file: what a right one resolves to, and one line with place and remedy for everything that is wrong."""

import math
import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import strainwave as sw
from strainwave.drive.project import Project
from strainwave.drive.steady import is_beating
from strainwave.files.reading import ProjectError, from_text, read_project
from strainwave.files.yaml_text import FILE_BYTES

EXAMPLES = Path(__file__).resolve().parents[2] / "examples" / "projects"
ARCSEC = math.pi / 648000.0

# Line and column of every field matter: the tables below count in this text.
GOOD = """\
gear: CSG-40-50
motor: {inertia: 5 kg*cm^2, mode: held}
load: {inertia: 1.3 kg*m^2}
damping: {ratio: 0.02}
speed: {from: 100 rpm, to: 3000 rpm, shaft: motor}
excitation:
  kinematic_error: [{order: 2, amplitude: 23 arcsec}]
  load_torque: {mean: -50 N*m}
"""


@pytest.fixture
def written(tmp_path, monkeypatch):
    """Write a project file and return its name, as a person in that folder would give it."""
    monkeypatch.chdir(tmp_path)

    def write(content):
        data = content if isinstance(content, bytes) else content.encode()
        Path("project.yaml").write_bytes(data)
        return "project.yaml"

    return write


def complaint(path) -> list[str]:
    with pytest.raises(ProjectError) as refusal:
        read_project(path)
    return str(refusal.value).splitlines()


def law(text: str) -> tuple[str, str]:
    return "CSG-40-50", "{ratio: 50, law: {" + text + "}}"


def test_a_right_file_resolves_to_si(written):
    project = read_project(written(GOOD))
    assert project.title == "project"
    assert project.gear == sw.catalogue.gear("CSG-40-50")
    assert project.drive._replace(B=0.0) == project.gear.drive(load_inertia=1.3, motor_inertia=5e-4, B=0.0)
    assert project.damping_ratio == pytest.approx(0.02, rel=1e-14)
    assert (project.motor, project.speeds.shaft, project.speeds.single) == ("held", "motor", ())
    assert project.speeds.limits == pytest.approx((100.0 * math.pi / 30.0, 3000.0 * math.pi / 30.0), rel=1e-14)
    assert project.kinematic_error.lines == (sw.Line(2, pytest.approx(23.0 * ARCSEC, rel=1e-14), 0.0),)
    assert project.load_torque == sw.Harmonics((sw.Harmonic(0.0, 1, 0.0, -50.0),))
    assert project.motor_torque is None
    assert project.text == GOOD


def test_a_line_of_two_turns_has_the_sum_of_its_orders(written):
    lines = "[{order: {wave_generator: 2, output: 2}, amplitude: 5 arcsec}, {order: {output: 3}, amplitude: 1 arcsec}]"
    project = read_project(written(GOOD.replace("[{order: 2, amplitude: 23 arcsec}]", lines)))
    oval = sw.gears.order_map(50).order("flexspline tooth engagement").per_motor_turn  # pair (2, -2) at the ratio -50
    assert project.kinematic_error.orders() == pytest.approx((float(oval), 3.0 / 50.0), rel=1e-15)
    assert is_beating(project.subject.error)


@pytest.mark.parametrize(
    ("gear", "ratio", "said"),
    [
        ("{name: CSG-40-50, fixed: circular_spline}", 50.0,
         "flexspline turns against the motor, once in 50 turns; an oval "
         "circular spline gives error order 2, an oval flexspline gives error order {wave_generator: 2, output: 2}."),
        ("{name: CSG-40-50, fixed: flexspline}", 51.0,
         "circular spline turns with the motor, once in 51 turns; an oval "
         "flexspline gives error order 2, an oval circular spline gives error order {wave_generator: 2, output: -2}."),
        ("{ratio: 51, fixed: flexspline, law: {type: linear, K: 1e5 N*m/rad}}", 51.0, "with the motor, once in 51"),
        ("{ratio: 1.02, fixed: wave_generator, law: {type: linear, K: 1e5 N*m/rad}}", 1.02, "once in 1.02 turns; an "
         "oval circular spline gives error order {wave_generator: 0, output: 2}."),
    ],
)  # fmt: skip
def test_ratio_sense_and_orders_follow_from_the_member_that_is_fixed(gear, ratio, said, written):
    plain, fixed = read_project(written(GOOD)), read_project(written(GOOD.replace("gear: CSG-40-50", f"gear: {gear}")))
    assert pytest.approx(ratio, rel=1e-15) == fixed.drive.N
    assert plain.arrangement is None
    assert any(note.startswith("gear.fixed: ") and said in note for note in fixed.notes)
    assert not any("gear.fixed" in note for note in plain.notes)
    again = from_text(sw.project_text(fixed), fixed.path)
    assert again.arrangement == fixed.arrangement
    assert again.drive.N == fixed.drive.N


def test_the_line_of_an_oval_spline_has_the_order_of_the_map(written):
    lines = "[{order: {wave_generator: 2, output: -2}, amplitude: 5 arcsec}]"
    text = GOOD.replace("[{order: 2, amplitude: 23 arcsec}]", lines)
    project = read_project(written(text.replace("gear: CSG-40-50", "gear: {name: CSG-40-50, fixed: flexspline}")))
    oval = sw.gears.order_map(50, project.arrangement).order("circular spline tooth engagement").per_motor_turn
    assert project.kinematic_error.orders() == pytest.approx((float(oval),), rel=1e-15)


def test_a_limit_of_the_oscillation_is_read_in_any_unit_of_angle(written):
    assert read_project(written(GOOD)).limit is None
    assert read_project(written(GOOD + "limit: {oscillation: 1 arcmin}\n")).limit == pytest.approx(
        60.0 * ARCSEC, rel=1e-14
    )


def test_the_system_is_the_drives_error_equation(written):
    project = read_project(written(GOOD))
    system = project.system(200.0)
    assert (system.J, system.omega, system.B) == (1.3, 200.0, project.drive.B)
    assert system.excitation.torque(0.3) == 50.0
    assert system.error == project.kinematic_error


def test_the_article_example_is_the_articles_drive():
    project = read_project(EXAMPLES / "article.yaml")
    assert project.drive == sw.HDC_40_050
    assert (project.motor, project.speeds.shaft, project.gear) == ("free", "forcing", None)
    assert project.speeds.limits == (10.47, 1200.0)
    # ERRATA N2 and N3: omega_0 = 385.545 rad/s and A = 380.228 rad/s^2 from the article's Table 3
    assert project.omega_0 == pytest.approx(385.545, abs=5e-4)
    system = project.system(10.47)
    assert system.excitation.torque(0.0) / system.J == pytest.approx(380.228, abs=5e-4)


@pytest.mark.parametrize(
    ("shaft", "factor"), [("motor", 1.0), ("load", 50.0), ("forcing", 1.0)], ids=["motor", "load", "forcing"]
)
def test_speeds_belong_to_the_shaft_they_are_given_for(written, shaft, factor):
    project = read_project(
        written(GOOD.replace("from: 100 rpm, to: 3000 rpm, shaft: motor", f"at: [9 rpm, 3 rpm], shaft: {shaft}"))
    )
    assert project.speeds.single == pytest.approx((factor * 0.1 * math.pi, factor * 0.3 * math.pi), rel=1e-14)
    shown = 0.1 * math.pi if shaft == "forcing" else 3.0
    assert project.speeds.own(factor * 0.1 * math.pi) == pytest.approx(shown, rel=1e-14)
    assert project.speeds.limits == pytest.approx((factor * 0.08 * math.pi, factor * 0.36 * math.pi), rel=1e-14)


@pytest.mark.parametrize("mode", ["free", "held"])
@pytest.mark.parametrize("damping", ["{ratio: 0.02}", "{ratio: 2 %}", "{quality: 25}"])
def test_ratio_and_quality_refer_to_the_chosen_motor_mode(written, mode, damping):
    project = read_project(written(GOOD.replace("held", mode).replace("{ratio: 0.02}", damping)))
    J = {"free": project.drive.J, "held": 1.3}[mode]
    assert pytest.approx(2.0 * 0.02 * math.sqrt(1e5 * J), rel=1e-14) == project.drive.B


@pytest.mark.parametrize(("text", "B"), [("B: 10 N*m*s/rad", 10.0), ("B: 0 N*m*s/rad", 0.0), ("ratio: 0", 0.0)])
def test_damping_may_be_given_as_B_or_be_none(written, text, B):
    assert read_project(written(GOOD.replace("ratio: 0.02", text))).drive.B == B


def test_a_catalogue_gear_brings_its_own_motor_inertia(written):
    project = read_project(written(GOOD.replace("motor: {inertia: 5 kg*cm^2, mode: held}\n", "")))
    assert (project.drive.J_m, project.motor) == (4.5e-4, "held")


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("type: linear, K: 1e3 N*m/rad", sw.Linear(1e3)),
        ("type: cubic, K: 1 kN*m/rad, alpha: -2 rad^-2", sw.Cubic(1e3, -2.0)),
        ("type: polynomial, coefficients: [0 N*m, 5 N*m/rad, 6 N*m/rad^2]", sw.Polynomial((0.0, 5.0, 6.0))),
        (
            "type: piecewise_linear, K1: 1 N*m/rad, K2: 2 N*m/rad, K3: 3 N*m/rad, T1: 4 N*m, T2: 5 N*m",
            sw.PiecewiseLinear(1.0, 2.0, 3.0, 4.0, 5.0),
        ),
        ("type: backlash, K: 5 N*m/rad, half_gap: 1 mrad", sw.Backlash(5.0, 1e-3)),
        ("type: play, half_gap: 1 mrad, law: {type: linear, K: 5 N*m/rad}", sw.Play(1e-3, sw.Linear(5.0))),
        (
            "type: rounded_piecewise_linear, width: 1 mrad, "
            "K1: 1 N*m/rad, K2: 2 N*m/rad, K3: 3 N*m/rad, T1: 4 N*m, T2: 5 N*m",
            sw.laws.RoundedPiecewiseLinear(1.0, 2.0, 3.0, 4.0, 5.0, 1e-3),
        ),
        (
            "type: tabulated, points: [[-1 rad, -2 N*m], [0 rad, 0 N*m], [2 rad, 30 N*cm]]",
            sw.tabulated([(-1.0, -2.0), (0.0, 0.0), (2.0, 0.3)]),
        ),
    ],
)
def test_every_law_can_be_written(written, text, expected):
    project = read_project(written(GOOD.replace(*law(text)).replace("ratio: 0.02", "B: 1 N*m*s/rad")))
    assert (project.drive.law, project.drive.N, project.gear) == (expected, 50.0, None)


@pytest.mark.parametrize("number", ["1.3", "1.3e0", "13e-1", "+1.3", "'1.3", "0.13E+1"])
def test_numbers_are_read_as_text_and_not_by_yaml(written, number):
    quote = "'" if number.startswith("'") else ""
    assert read_project(written(GOOD.replace("1.3 kg*m^2", f"{number} kg*m^2{quote}"))).drive.J_l == 1.3


def test_the_mean_of_a_torque_goes_with_its_lines(written):
    project = read_project(
        written(GOOD.replace("{mean: -50 N*m}", "{mean: 5 N*m, lines: [{order: 1, amplitude: 2 N*m, phase: 90°}]}"))
    )
    assert project.load_torque.torque(0.0) == pytest.approx(5.0)
    assert project.load_torque.torque(math.pi / 2.0) == pytest.approx(3.0)


LINES = "kinematic_error: [{order: 2, amplitude: 23 arcsec}]"


@pytest.mark.parametrize(
    ("text", "accuracy"), [("catalogue", 2.9e-4), ("1.5 arcmin", 90.0 * ARCSEC), ("60 arcmin", 3600.0 * ARCSEC)]
)
def test_an_accuracy_class_stands_for_lines_of_that_peak_to_peak_and_says_so(written, text, accuracy):
    # CSG-40-50: 2.9e-4 rad, Harmonic Drive LLC, CSF/CSG catalogue p. 49
    project = read_project(written(GOOD.replace(LINES, f"accuracy: {text}")))
    assert project.kinematic_error.orders() == (1, 2, 4)
    assert sw.gears.peak_to_peak(project.kinematic_error) == pytest.approx(accuracy, rel=1e-12)
    (note,) = (note for note in project.notes if "accuracy class" in note)
    t, sizes = np.linspace(0.0, 2.0 * np.pi, 1001), []  # own series of the orders 1, 2, 4
    for phases in ((0.0, 0.0, 0.0), *np.random.default_rng(1).uniform(0.0, 2.0 * np.pi, (2000, 3))):
        series = sum(a * np.cos(k * t + p) for k, a, p in zip((1, 2, 4), (0.25, 1.0, 0.25), phases, strict=True))
        sizes.append(np.max(np.abs(series)) / np.ptp(series))
    slow, low, high = sizes[0], min(sizes[1:]), max(sizes[1:])
    assert f"{100 * slow:.0f} % of the peak-to-peak class ({100 * low:.0f} to {100 * high:.0f} % for" in note
    (size,) = re.findall(r"is then ±([\d.]+) arcsec", note)
    assert float(size) == pytest.approx(slow * accuracy / ARCSEC, rel=0.01)
    assert not any("accuracy class" in note for note in read_project(written(GOOD)).notes)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"5 kg*cm^2": "5 kg*m^2", "CSG-40-50": "HFUC-90-100"}, "has no catalogue value for HFUC-90-100; write an"),
        ({"shaft: motor": "shaft: forcing", "rpm": "rad/s"}, "refers to the motor turn"),
    ],
)
def test_an_accuracy_needs_a_source_and_the_motors_turn(written, changes, said):
    text = GOOD.replace(LINES, "accuracy: catalogue")
    for old, new in changes.items():
        text = text.replace(old, new)
    (line,) = complaint(written(text))
    assert line.startswith(f"project.yaml:7:13: excitation.accuracy: {said}")


def test_notes_tell_what_is_doubtful(written):
    notes = " ".join(read_project(written(GOOD.replace("5 kg*cm^2", "1 kg*cm^2").replace("held", "free"))).notes)
    for part in ("motor.inertia is 1 kg*cm^2, less than the 4.5 kg*cm^2 of the wave generator", "do not balance"):
        assert part in notes
    (loss,) = read_project(written(GOOD)).notes
    assert loss.startswith("The catalogue gives CSG-40-50 a hysteresis loss of up to 60 arcsec. The results neglect")


def test_the_hysteresis_of_the_record_is_that_of_its_loss(written):
    project = read_project(written(f"hysteresis: catalogue\n{GOOD}"))
    gear = sw.catalogue.gear("CSG-40-50")
    # the loop of the law is as wide at no torque as the datasheet says, 1 arcmin, after the rated torque
    assert sw.hysteresis_loop(project.drive.law, gear.rated_torque).loss == pytest.approx(math.pi / 10800.0, rel=1e-3)
    assert project.drive.law.first == gear.law
    assert not [note for note in project.notes if "hysteresis loss" in note]
    lacking = written(f"hysteresis: catalogue\n{GOOD}".replace("CSG-40-50", "CSF-40-50"))
    assert (
        "hysteresis: is catalogue, but no catalogue gives the hysteresis loss and rated torque" in complaint(lacking)[0]
    )


def test_a_special_accuracy_is_that_of_the_selected_grade(written):
    project = read_project(written(GOOD.replace(LINES, "accuracy: special")))
    gear = sw.catalogue.gear("CSG-40-50")
    assert sw.gears.peak_to_peak(project.kinematic_error) == pytest.approx(gear.special_accuracy, rel=1e-9)
    assert gear.special_accuracy < 0.6 * gear.accuracy


# (text to replace, its replacement, line:column: field: the sentence or its beginning)
WRONG = [
    ("1.3 kg*m^2", "1.3", "3:17: load.inertia: '1.3' has no unit; write for example 1.3 kg*m^2 or 0.25 kg*cm^2"),
    ("1.3 kg*m^2", "1,3 kg*m^2", "3:17: load.inertia: '1,3 kg*m^2' has a comma; write 1.3, not 1,3"),
    ("1.3 kg*m^2", "-1.3 kg*m^2", "3:17: load.inertia: '-1.3 kg*m^2' is not positive; write a value above zero"),
    ("1.3 kg*m^2", ".nan", "3:17: load.inertia: '.nan' does not begin with a finite number"),
    ("1.3 kg*m^2", "1e99 kg*m^2", "3:17: load.inertia: '1e99 kg*m^2' is outside any realistic range; check the number"),
    ("1.3 kg*m^2", "[1.3 kg*m^2]", "3:17: load.inertia: is a list, not a number with its unit"),
    ("1.3 kg*m^2", "{value: 1.3}", "3:17: load.inertia: is a group of fields, not a number with its unit"),
    ("100 rpm", "{}", "5:15: speed.from: is a group of fields, not a number with its unit; write for example 60"),
    ("1.3 kg*m^2", "!!float 1.3 kg*m^2", "3:17: load.inertia: has the tag 'float'; remove the tag"),
    ("1.3 kg*m^2", "*other", "3:17: load.inertia: '*other' is an alias; write the value out"),
    ("{inertia: 1.3 kg*m^2}", "1.3 kg*m^2", "3:7: load: '1.3 kg*m^2' is not a group of fields"),
    ("{inertia: 1.3 kg*m^2}", "", "3:1: load: is empty; write a value or remove the field"),
    ("{inertia: 1.3 kg*m^2}", "{}", "3:7: load.inertia: is missing; write for example 'inertia: 1.3 kg*m^2'"),
    ("load: {inertia: 1.3 kg*m^2}\n", "", "1:1: load: is missing; write for example 'load: {inertia: 1.3 kg*m^2}'"),
    ("m^2}", "m^2, dampling: {ratio: 0.02}}", "3:29: load.dampling: unknown field; did you mean 'damping'?"),
    (
        "m^2}",
        "m^2, gravity: 40 N*m}",
        "3:29: load.gravity: unknown field; see 'drag' (Friction, gravity or imbalance torque on "
        "the load), as drag: {type: ",
    ),
    ("m^2}", "m^2, inertia: 5 kg*m^2}", "3:29: load.inertia: appears twice, first in line 3; remove one"),
    ("damping:", "limit: {oscillation: 0 arcsec}\ndamping:", "4:22: limit.oscillation: '0 arcsec' is not positive"),
    ("damping:", "colour: red\ndamping:", "4:1: colour: unknown field; known here: title, revision, gear, hysteresis"),
    ("gear: CSG-40-50", "gear: CSG-40-5", "1:7: gear: the catalogue has no gear 'CSG-40-5'; the nearest are CSG-40-50"),
    ("gear: CSG-40-50", "gear: ~", "1:7: gear: is empty; write a value or remove the field"),
    (
        "CSG-40-50",
        "{ratio: 0.5, law: {type: linear, K: 5 N*m/rad}}",
        "1:15: gear.ratio: '0.5' is less than 1; write motor",
    ),
    ("CSG-40-50", "{ratio: -50, law: {type: linear, K: 5 N*m/rad}}", "1:15: gear.ratio: '-50' is not positive"),
    ("CSG-40-50", "{ratio: 50}", "1:7: gear.law: is missing; write for example 'law: {type: cubic"),
    (*law("K: 5 N*m/rad"), "1:24: gear.law.type: is missing; write one of linear, cubic, polynomial"),
    (*law("type: cubik, K: 5 N*m/rad"), "1:31: gear.law.type: 'cubik' is not known; did you mean 'cubic'?"),
    (*law("type: quux"), "1:31: gear.law.type: 'quux' is not known; write one of linear, cubic"),
    (
        *law("type: bouc_wen, K: 1e5 N*m/rad, ratio: 0.2, yield_twist: 1 mrad, gamma: 0.6"),
        "1:24: gear.law: BoucWen has gamma = 0.6 and beta = 0.5; with |gamma| > beta it creates energy",
    ),
    (*law("type: BoucWen, K: 1e5 N*m/rad, ratio: 1.2, yield_twist: 1 mrad"), "1:63: gear.law.ratio: is 1.2; it is"),
    (*law("type: coulomb, T_c: 5 N*m, width: 1 rad/s"), "1:24: gear.law: the stiffness at rest is 0 N*m/rad; it"),
    (*law("type: linear"), "1:24: gear.law.K: is missing; write it, for example 7160 N*m/rad or 3 Nm/arcmin"),
    (*law("type: linear, K: -5 N*m/rad"), "1:42: gear.law.K: '-5 N*m/rad' is not positive"),
    (*law("type: linear, k: 5 N*m/rad, K: 5 N*m/rad"), "1:39: gear.law.k: unknown field; did you mean 'K'?"),
    (
        *law("type: polynomial, coefficients: 5 N*m"),
        "1:57: gear.law.coefficients: is a text; write 2 to 16 coefficients",
    ),
    (
        *law("type: polynomial, coefficients: [0 N*m, -5 N*m/rad]"),
        "1:24: gear.law: the stiffness at rest is -5 N*m/rad",
    ),
    (
        *law("type: piecewise_linear, K1: 1 N*m/rad, K2: 1 N*m/rad, K3: 1 N*m/rad, T1: 5 N*m, T2: 3 N*m"),
        "1:24: gear.law: PiecewiseLinear has T1 = 5 and T2 = 3 N*m; it needs 0 < T1 < T2",
    ),
    ("mode: held", "mode: stiff", "2:35: motor.mode: 'stiff' is not known; write one of free, held"),
    (
        "ratio: 0.02",
        "ratio: 0.02, quality: 25",
        "4:10: damping: gives quality and ratio; write exactly one of B, ratio",
    ),
    ("{ratio: 0.02}", "{}", "4:10: damping: gives nothing; write exactly one of B, ratio, quality"),
    ("ratio: 0.02", "ratio: -0.02", "4:18: damping.ratio: '-0.02' is negative; write zero or more"),
    ("ratio: 0.02", "quality: 0", "4:20: damping.quality: '0' is not positive"),
    ("3000 rpm", "0 rpm", "5:28: speed.to: '0 rpm' is not positive"),
    ("100 rpm", "-100 rpm", "5:15: speed.from: '-100 rpm' is negative; write zero or more"),
    ("100 rpm", "4000 rpm", "5:29: speed.to: the range does not ascend; write the smaller speed after 'from'"),
    ("100 rpm", "3000 rpm", "5:29: speed.to: the range does not ascend"),
    ("from: 100 rpm, ", "", "5:8: speed: has one end of the range only; write both 'from' and 'to'"),
    ("from: 100 rpm, to: 3000 rpm, ", "", "5:8: speed: needs either a range 'from' and 'to' or a list 'at'"),
    ("from: 100 rpm, to: 3000 rpm", "at: [5 rpm, 6]", "5:21: speed.at[1]: '6' has no unit"),
    ("from: 100 rpm, to: 3000 rpm", "at: []", "5:13: speed.at: has 0 items; write at least 1"),
    (", shaft: motor", "", "5:8: speed.shaft: is missing; write for example 'shaft: motor'"),
    ("shaft: motor", "shaft: moter", "5:45: speed.shaft: 'moter' is not known; did you mean 'motor'?"),
    ("order: 2", "order: 0", "7:29: excitation.kinematic_error[0].order: '0' is not between 1 and 1000"),
    (
        "order: 2",
        "order: 2.5",
        "7:29: excitation.kinematic_error[0].order: '2.5' is not a whole number; write how often",
    ),
    (
        "gear: CSG-40-50",
        "gear: {ratio: 40.5, fixed: flexspline, law: {type: linear, K: 1e5 N*m/rad}}",
        "1:28: gear.fixed: contradicts the ratio: 40.5 is no ratio with the flexspline fixed and z1 = 2 N and z2 = 2 N "
        "+ 2 teeth; it is N + 1 of a whole N from 2 on",
    ),
    (
        "gear: CSG-40-50",
        "gear: {name: CSG-40-50, fixed: wave_generator}",
        "1:32: gear.fixed: is wave_generator, but CSG-40-50 has it on the motor; write ratio and law in full",
    ),
    ("order: 2", "order: {wave_generator: 2}", "7:29: excitation.kinematic_error[0].order.output: is missing"),
    ("order: 2", "order: {output: -1}", "7:29: excitation.kinematic_error[0].order: has a negative frequency"),
    (
        "order: 2",
        "order: {wave_generator: 1, output: -50}",
        "7:29: excitation.kinematic_error[0].order: has zero frequency at the ratio 50; remove this order",
    ),
    (
        "gear: CSG-40-50",
        "gear: {ratio: 1.0000001, law: {type: linear, K: 7160 N*m/rad}}",
        "1:15: gear.ratio: '1.0000001' is too close to 1; write 1, or the ratio of the teeth, for "
        "example 1.01 with a fixed wave generator",
    ),
    (
        "[{order: 2,",
        "[{order: 2, amplitude: 1 arcsec}, {order: {wave_generator: 1, output: 50},",
        "7:62: excitation.kinematic_error[1].order: has 100 periods per output turn, as line 0; add the two lines",
    ),
    ("order: 2", "order: [2]", "7:29: excitation.kinematic_error[0].order: a list is not a whole number"),
    ("order: 2, ", "", "7:21: excitation.kinematic_error[0].order: is missing; write for example 'order: 2'"),
    ("23 arcsec", "-23 arcsec", "7:43: excitation.kinematic_error[0].amplitude: '-23 arcsec' is negative"),
    ("23 arcsec", "23 arcsec, phase: -3.7e5 deg", "7:61: excitation.kinematic_error[0].phase: '-3.7e5 deg' is more"),
    (LINES, "accuracy: -1 arcmin", "7:13: excitation.accuracy: '-1 arcmin' is not positive"),
    (LINES, "accuracy: 60.1 arcmin", "7:13: excitation.accuracy: '60.1 arcmin' is above 1 deg"),
    (LINES, LINES + "\n  accuracy: 1 arcmin", "8:13: excitation.accuracy: contradicts kinematic_error"),
    ("23 arcsec", "0 arcsec", "7:3: excitation: has no periodic component; write for example"),
    (
        "load_torque: {mean: -50 N*m}",
        "motor_torque: {lines: [{order: 1, amplitude: 1 N*m}]}",
        "8:17: excitation.motor_torque: has no effect on a held motor; remove motor_torque "
        "or write 'mode: free' under motor",
    ),
    ("damping", "\tdamping", "4:1: file: the line is indented with a tab; indent with spaces"),
    ("gear: CSG", "gear: x: CSG", "1:8: file: a second ': ' in one line; put text with a colon in quotes"),
    ("damping:", "---\ndamping:", "4:1: file: a second document begins; a project file has one, remove the line '---'"),
    ("0.02}", "0.02", "5:6: file: not YAML"),
    ("damping:", "? [damping]\n:", "4:3: file: has a key that is not a word; write 'name: value'"),
    ("damping: {ratio: 0.02}", "damping: " + "[" * 30 + "]" * 30, "4:20: file: is nested more than 10 levels deep"),
]


def test_a_motor_torque_beside_a_loop_is_told_where_cogging_goes(written):
    text = GOOD.replace("load_torque: {mean: -50 N*m}", "motor_torque: {lines: [{order: 12, amplitude: 0.1 N*m}]}")
    motor = next(line for line in GOOD.splitlines() if line.startswith("motor:"))
    (line,) = complaint(written(text.replace(motor, "motor: {inertia: 4.5 kg*cm^2, loop: {bandwidth: 30 Hz}}")))
    assert "excitation.motor_torque: contradicts motor.loop" in line
    drag = "drag: {type: angle_torque, amplitude: 0.02 N*m, order: 12}"
    assert drag in line
    train = sw.read_project(written(GOOD.replace(motor, f"motor: {{loop: {{bandwidth: 30 Hz}}, {drag}}}"))).train
    assert (train.motor.drag.order, train.motor.drag.amplitude) == (12, 0.02)


@pytest.mark.parametrize(("old", "new", "said"), WRONG, ids=lambda v: str(v)[:30])
def test_what_a_person_gets_wrong_is_one_line_with_place_and_remedy(written, old, new, said):
    assert old in GOOD
    lines = complaint(written(GOOD.replace(old, new)))
    assert len(lines) == 1
    assert lines[0].startswith(f"project.yaml:{said}")


TABLE = "type: tabulated, points: [[-1 mrad, -90 N*m], [0 mrad, 0 N*m], [1 mrad, 100 N*m]]"
PLAY = f"type: play, half_gap: 1 mrad, law: {{{TABLE}}}"


@pytest.mark.parametrize(
    ("text", "old", "new", "said"),
    [
        (TABLE, "[0 mrad, 0 N*m], ", "", "gear.law: a table of 2 points is given; it needs 3 to 64"),
        (TABLE, "0 mrad", "-2 mrad", "gear.law: the torsion -0.002 rad stands after -0.001 rad; sort the points"),
        (TABLE, "0 mrad", "-1 mrad", "gear.law: the torsion -0.001 rad appears twice"),
        (TABLE, "-90 N*m", "90 N*m", "gear.law: the torque falls from 90 to 0 N*m between"),
        (TABLE, "0 mrad, ", "", "gear.law.points[1]: is no pair of a torsion and a torque; write [0.54 mrad, 54 N*m]"),
        (TABLE, "0 mrad", "0 mm", "gear.law.points[1][0]: '0 mm' is not an angle"),
        (TABLE, "points: [", "points: 7, x: [", "gear.law.points: is a text; write points such as"),
        (PLAY, "1 mrad, law", "-1 mrad, law", "gear.law.half_gap: '-1 mrad' is negative"),
        (PLAY, "points", "pionts", "gear.law.law.pionts: unknown field; did you mean"),
        (PLAY, "tabulated", "coulomb", "gear.law.law.T_c: is missing; write it, for example 0.5 N*m"),
        (
            "type: play, half_gap: 1 mrad",
            "1 mrad",
            "1 mrad",
            "gear.law.law: is missing; write it, for example {type: linear",
        ),
    ],
)
def test_what_is_wrong_with_a_law_is_said(written, text, old, new, said):
    assert old in text
    lines = complaint(written(GOOD.replace(*law(text.replace(old, new, 1))).replace("ratio: 0.02", "B: 1 N*m*s/rad")))
    assert any(said in line for line in lines), lines


def test_a_backlash_law_has_no_damping_ratio_and_an_explicit_gear_no_motor_inertia(written):
    text = GOOD.replace(*law("type: backlash, K: 5 N*m/rad, half_gap: 1 mrad"))
    assert complaint(written(text.replace("inertia: 5 kg*cm^2, ", ""))) == [
        "project.yaml:2:8: motor.inertia: is missing for an explicit gear; write for example 'inertia: 4.5 kg*cm^2'",
        "project.yaml:4:18: damping.ratio: has no meaning for a torsion law without stiffness at rest (backlash); "
        "write B: 10 N*m*s/rad",
    ]


SHG_25 = "{type: piecewise_linear, K1: 4.5e4 N*m/rad, K2: 6e4 N*m/rad, K3: 9e4 N*m/rad, T1: 14 N*m, T2: 48 N*m}"
BESIDE = {
    "nothing": "",
    "hysteresis": "hysteresis: {type: bouc_wen, K: 6e4 N*m/rad, ratio: 0, yield_twist: 0.08 mrad}\n",
    "bristles": "hysteresis: {type: lugre, sigma_0: 3e6 N*m/rad, sigma_1: 10 N*m*s/rad, sigma_2: 0 N*m*s/rad, "
    "T_c: 4 N*m, T_s: 5 N*m, v_s: 0.01 rad/s}\n",
    "dry friction": "hysteresis: {type: coulomb, T_c: 4.8 N*m, width: 1e-3 rad/s}\n",
}


@pytest.mark.parametrize("name", BESIDE)
@pytest.mark.parametrize("mode", ["held", "free"])
def test_a_damping_ratio_belongs_to_the_spring_whatever_hysteresis_lies_beside_it(written, mode, name):
    """B = 2 zeta sqrt(K1 J), J the load's inertia for a held motor and reduced by the motor's for a free one."""
    text = GOOD.replace("CSG-40-50", f"{{ratio: 50, law: {SHG_25}}}").replace("held", mode)
    J = 1.3 if mode == "held" else 1.0 / (1.0 / 1.3 + 1.0 / (50.0**2 * 5e-4))
    project = read_project(written(text + BESIDE[name]))
    given = project.drive.B
    assert given == pytest.approx(2.0 * 0.02 * math.sqrt(4.5e4 * J), rel=1e-12)
    assert project.damping_ratio == pytest.approx(0.02, rel=1e-12)
    assert project.omega_0 == pytest.approx(math.sqrt(4.5e4 / J), rel=1e-12)


@pytest.mark.parametrize(
    ("law", "K"),
    [
        ("{type: bouc_wen, K: 8e4 N*m/rad, ratio: 0.25, yield_twist: 0.1 mrad}", 2e4),
        (
            "{type: parallel, first: %s, second: {type: bouc_wen, K: 8e4 N*m/rad, ratio: 0.25, yield_twist: 0.1 mrad}}",
            6.5e4,
        ),
        ("{type: tabulated, points: [[-2 mrad, -100 N*m], [0 mrad, 0 N*m], [2 mrad, 100 N*m]]}", 5e4),
    ],
)
def test_a_damping_ratio_of_an_explicit_law_belongs_to_its_spring(written, law, K):
    text = GOOD.replace("CSG-40-50", f"{{ratio: 50, law: {law.replace('%s', SHG_25)}}}")
    given = read_project(written(text)).drive.B
    assert given == pytest.approx(2.0 * 0.02 * math.sqrt(K * 1.3), rel=1e-12)


@pytest.mark.parametrize("more", ["backlash: {half_gap: 10 arcsec}\n", ""])
def test_a_damping_ratio_of_what_only_hysteresis_holds_is_refused(written, more):
    text = GOOD + more + f"hysteresis: {YIELDING}\n"
    if not more:
        text = GOOD.replace("CSG-40-50", f"{{ratio: 50, law: {YIELDING}}}")
    (line,) = complaint(written(text))
    assert "damping.ratio: has no meaning for a torsion law with friction or hysteresis but no spring; write B" in line


def test_contradictions_are_told_with_what_is_wrong_elsewhere(written):
    text = GOOD.replace("1.3 kg*m^2", "1.3").replace("100 rpm", "20 Hz")
    text += "  motor_torque: {mean: 1 N*m}\n"
    fields = [line.split(": ")[1] for line in complaint(written(text))]
    assert fields == ["load.inertia", "speed.from", "excitation.motor_torque"]


LOOP = "loop: {type: speed_loop, K_p: 0.5 N*m*s/rad, K_i: 20 N*m/rad}"


def test_loop_drag_and_coupling_make_the_whole_train(written):
    text = GOOD.replace("mode: held", LOOP + ", drag: {type: viscous, B: 2e-4 N*m*s/rad}").replace(
        "inertia: 1.3 kg*m^2",
        "inertia: 1.2 kg*m^2, drag: {type: angle_torque, amplitude: 40 N*m}, "
        "coupling: {inertia: 0.1 kg*m^2, B: 5 N*m*s/rad, law: {type: linear, K: 4e5 N*m/rad}}",
    )
    project = read_project(written(text))
    train = project.train
    assert train.motor == sw.train.Motor(5e-4, drag=sw.laws.Viscous(2e-4), control=sw.train.SpeedLoop(0.5, 20.0))
    assert train.load[:3] == (0.1, 5.0, sw.Linear(4e5))
    assert (train.load.load.J, train.load.load.drag) == (1.2, sw.train.AngleTorque(40.0))
    assert project.drive.J_l == pytest.approx(1.3)
    assert read_project(written(GOOD)).train is None


def test_ripples_make_a_varying_oscillator(written):
    text = GOOD.replace("{ratio: 0.02}", "{ratio: 0.02, ripples: [{order: 3, depth: 10 %}], warming: 20 K}")
    system = read_project(written(text + "stiffness: {ripples: [{order: 2, depth: 0.1, phase: 90 deg}]}\n")).system(
        200.0
    )
    assert isinstance(system, sw.gears.VaryingOscillator)
    assert system.variation == sw.gears.Variation((sw.gears.Ripple(2, 0.1, math.pi / 2.0),))
    assert system.damping.variation == sw.gears.Variation((sw.gears.Ripple(3, 0.1),))
    assert system.damping.warming == 20.0


YIELDING = "{type: bouc_wen, K: 6e4 N*m/rad, ratio: 0, yield_twist: 0.08 mrad}"


@pytest.mark.parametrize("gear", ["CSG-40-50", "{ratio: 50, law: {type: linear, K: 1e5 N*m/rad}}"])
def test_hysteresis_and_backlash_stand_beside_a_gear_of_any_kind(written, gear):
    text = GOOD.replace("CSG-40-50", gear)
    spring = read_project(written(text)).drive.law
    hysteresis, gap = sw.BoucWen(6e4, 0.0, 8e-5), pytest.approx(10.0 * ARCSEC, rel=1e-14)
    one = read_project(written(text + f"hysteresis: {YIELDING}\n"))
    assert one.drive.law == sw.Parallel(spring, hysteresis)
    assert one.omega_0 == pytest.approx(math.sqrt(1e5 / 1.3), rel=1e-14)  # K1
    alone = text.replace("ratio: 0.02", "B: 1 N*m*s/rad") + "backlash: {half_gap: 10 arcsec}\n"
    both = alone + f"hysteresis: {YIELDING}\n"
    assert read_project(written(both)).drive.law == sw.Parallel(sw.Play(gap, spring), hysteresis)
    assert read_project(written(alone)).drive.law == sw.Play(gap, spring)
    assert read_project(written(both)).gear == read_project(written(text)).gear


WITH_FRICTION = "{ratio: 50, law: {type: parallel, first: {type: linear, K: 5 N*m/rad}, second: %s}}"


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("damping", "hysteresis: {type: linear, K: 5 N*m/rad}\ndamping", "4:13: hysteresis: Linear is a spring, which"),
        ("damping", "backlash: {half_gap: 0 rad}\ndamping", "4:22: backlash.half_gap: '0 rad' is not positive"),
        (
            "gear: CSG-40-50",
            "backlash: {half_gap: 1 mrad}\ngear: " + WITH_FRICTION % YIELDING,
            "1:11: backlash: requires a spring, but gear.law has friction or hysteresis; write that as 'hysteresis'",
        ),
        (
            "gear: CSG-40-50",
            "backlash: {half_gap: 1 mrad}\ngear: "
            "{ratio: 50, law: {type: polynomial, coefficients: [1 N*m, 5 N*m/rad]}}",
            "1:11: backlash: contradicts gear.law: Play.law is a Polynomial with the torque 1 N*m at zero torsion",
        ),
        ("CSG-40-50", "{name: CSG-40-50}", "1:7: gear: gives name alone; write 'gear: CSG-40-50' for a gear of"),
        ("CSG-40-50", "{name: A, law: {type: linear, K: 1e4 N*m/rad}}", "1:7: gear: the catalogue has no gear 'A'"),
        ("CSG-40-50", "{file: a.yaml, name: A, ratio: 5}", "1:7: gear: gives file and name and ratio; write 'gear: "),
        (
            "CSG-40-50",
            WITH_FRICTION % "{type: angle_torque, amplitude: 5 N*m}",
            "1:86: gear.law.second: AngleTorque follows the angle of a shaft; write it as drag",
        ),
        (
            "mode: held",
            f"drag: {{type: parallel, first: {YIELDING}, second: {{type: linear, K: 5 N*m/rad}}}}",
            "2:135: motor.drag.second: Linear is a spring, which ties a shaft to the ground; "
            "write friction, or angle_torque",
        ),
        (
            "mode: held",
            "drag: " + YIELDING.replace("ratio: 0", "ratio: 0.2"),
            "2:75: motor.drag.ratio: 0.2 of this torque is a spring, which ties a shaft to the ground; "
            "write 'ratio: 0'",
        ),
        ("0.02", "0.02, warming: -1e6 K", "4:33: damping.warming: is -1e+06 K, for 0.035 1/K the factor exp(3.5e+04)"),
    ],
)
def test_what_a_gear_or_a_shaft_cannot_hold_is_told_at_its_place(written, old, new, said):
    (line,) = complaint(written(GOOD.replace(old, new, 1)))
    assert line.startswith(f"project.yaml:{said}")


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("mode: held", "mode: free, " + LOOP, "motor.loop: contradicts 'mode: free', a motor without a loop"),
        ("mode: held", LOOP.replace("0.5", "-0.5"), "motor.loop.K_p: is -0.5; with a negative gain"),
        ("CSG-40-50", "{ratio: 50, law: {type: angle_torque, amplitude: 1 N*m}}", "gear.law: AngleTorque follows the"),
        ("ratio: 0.02", "ratio: 0.02, ripples: [{order: 2, depth: 120 %}]", "damping.ripples: the depths of a Vari"),
        ("ratio: 0.02", "ratio: 0.02, warming: 20 deg", "damping.warming: '20 deg' is not a difference of temperature"),
    ],
)
def test_what_does_not_fit_a_loop_or_a_ripple_is_said(written, old, new, said):
    (line,) = complaint(written(GOOD.replace(old, new)))
    assert said in line


def test_ripples_stand_beside_no_memory_and_no_loop(written):
    ripples = "stiffness: {ripples: [{order: 2, depth: 0.1}]}\n"
    law = YIELDING.replace("ratio: 0", "ratio: 0.5")
    (line,) = complaint(written(GOOD.replace("CSG-40-50", f"{{ratio: 50, law: {law}}}") + ripples))
    assert "stiffness: varies, but the torsion law is no spring" in line
    (line,) = complaint(written(GOOD.replace("mode: held", LOOP) + ripples))
    assert "motor.loop: cannot be combined with varying stiffness or damping" in line


@pytest.mark.parametrize(("shaft", "begin"), [("motor", "30 rpm at the motor"), ("load", "30 rpm at the load")])
def test_a_range_from_rest_begins_at_one_percent_of_its_end_and_says_so(written, shaft, begin):
    project = read_project(written(GOOD.replace("100 rpm", "0 rpm").replace("shaft: motor", f"shaft: {shaft}")))
    low, high = project.speeds.limits
    assert high == pytest.approx(3000.0 * math.pi / 30.0 * (50.0 if shaft == "load" else 1.0), rel=1e-14)
    assert low == pytest.approx(0.01 * high, rel=1e-14)
    said = f"The speed range starts at 0; computed is the range from 1 % of its upper end, {begin}."
    assert said in project.notes


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
def test_a_file_is_read_as_editors_save_it(written, encoding):
    text = "title: Müllers Achse\r\n" + GOOD.replace("23 arcsec", "23″").replace("\n", "\r\n")
    project = read_project(written(text.encode(encoding)))
    assert project.title == "Müllers Achse"
    assert project.kinematic_error.lines[0].amplitude == pytest.approx(23.0 * ARCSEC, rel=1e-14)


def test_utf_16_that_breaks_off_is_said(written):
    (line,) = complaint(written(GOOD.encode("utf-16")[:-1]))
    assert line == "project.yaml:1:1: file: starts as UTF-16 text but is not UTF-16; save it as UTF-8 text"


def test_very_many_problems_are_cut_short(written):
    lines = complaint(written(GOOD + "".join(f"wrong_{i}: 1\n" for i in range(500))))
    assert len(lines) == 21
    assert lines[-1] == "project.yaml: 480 further problems; correct these first"


@pytest.mark.parametrize(
    ("content", "line"),
    [
        ("", "project.yaml:1:1: file: is empty; begin with a line such as 'gear: CSG-40-50'"),
        ("# only a comment\n", "project.yaml:1:1: file: is empty; begin with a line such as 'gear: CSG-40-50'"),
        ("- gear\n", "project.yaml:1:1: file: holds a list, not fields; begin with a line such as 'gear: CSG-40-50'"),
        ("gear\n", "project.yaml:1:1: file: holds 'gear', not fields; begin with a line such as 'gear: CSG-40-50'"),
        (b"\x7fELF\0\0", "project.yaml:1:1: file: is binary, not text; give a project file in YAML"),
        (b"title: M\xfcller", "project.yaml:1:9: file: has the byte 0xfc, not UTF-8; save it as UTF-8 text"),
        (b"title: a\ngear: \x07", "project.yaml:2:7: file: has the control character U+0007; remove it"),
        ("a: &x [1]\nb: *x\n", None),
        ("gear: {" + "a: " * 3, None),
    ],
)
def test_a_file_that_is_no_project_is_told_in_one_line(written, content, line):
    lines = complaint(written(content))
    if line is None:
        assert lines
    else:
        assert lines == [line]


def test_a_bomb_of_aliases_is_not_expanded(written):
    bomb = "a: &a [x, x]\n" + "".join(
        f"{c}: &{c} [*{p}, *{p}]\n" for p, c in zip("abcdefghij", "bcdefghijk", strict=True)
    )
    assert any("is an alias; write the value out" in line for line in complaint(written(bomb)))


def test_a_large_file_is_refused_unread(written, monkeypatch):
    path = written("x" * (FILE_BYTES + 1))
    monkeypatch.setattr(Path, "read_bytes", lambda self: pytest.fail(f"{self} was read"))
    assert complaint(path) == [
        f"project.yaml:1:1: file: has {FILE_BYTES + 1} bytes; a project file has at most "
        f"{FILE_BYTES}, is it another file?"
    ]


def test_a_directory_a_missing_file_and_a_pipe_are_refused(tmp_path):
    assert complaint(tmp_path) == [f"{tmp_path}:1:1: file: is a directory; give the project file inside it"]
    assert complaint(tmp_path / "no") == [f"{tmp_path / 'no'}:1:1: file: does not exist; check the name and the folder"]
    assert complaint("a\0b") == [
        "a?b:1:1: file: cannot be read (null character in the name); check the name and the disk"
    ]
    assert "cannot be read" in complaint("x" * 5000)[0]


def test_a_file_without_permission_is_refused(written, monkeypatch):
    def refuse(self):
        raise PermissionError(13, "Permission denied", str(self))

    path = written(GOOD)
    monkeypatch.setattr(Path, "read_bytes", refuse)
    assert complaint(path) == ["project.yaml:1:1: file: no permission to read it; change its rights"]


def is_project_or_complaint(path) -> bool:
    """Whether loading gives a Project with finite numbers, or complaints of one line each; anything else raises."""
    try:
        project = read_project(path)
    except ProjectError as refusal:
        return all(line.startswith(str(path)) for line in str(refusal).splitlines())
    return isinstance(project, Project) and math.isfinite(project.omega_0 + project.drive.B)


fuzz = settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=150)


@fuzz
@given(st.binary(max_size=300) | st.text(max_size=300).map(lambda s: s.encode("utf-8", "surrogatepass")))
def test_any_bytes_give_a_project_or_a_complaint(written, content):
    assert is_project_or_complaint(written(content))


@fuzz
@given(st.text(alphabet="abg: -\n{}[],'\"&*!|>?%@`#1.e+~<\t", max_size=80))
def test_any_yaml_like_text_gives_a_project_or_a_complaint(written, content):
    assert is_project_or_complaint(written(content))
