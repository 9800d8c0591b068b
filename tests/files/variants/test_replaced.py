"""Projects with other values in their files: what is read is what a file with that value says."""

import math
from dataclasses import fields

import pytest
from twelve_projects import PROJECTS

import strainwave as sw
from strainwave.files.reading import from_text, read_project
from strainwave.files.variants.replaced import replaced, tuning
from strainwave.study.analysis.design_variables import Subject
from strainwave.study.analysis.remedies import with_gear

MOVE = {"move.profile.0.type": "s_curve", "move.profile.0.angle": "90 deg", "move.profile.0.time": "0.6 s"}


@pytest.fixture
def read(tmp_path):
    return lambda text: from_text(text, tmp_path / "drive.yaml")


def apart(one, other):
    names = [field.name for field in fields(one) if field.compare and field.name != "text"]
    return [name for name in names if getattr(one, name) != getattr(other, name)]


@pytest.mark.parametrize(
    ("project", "values", "old", "new"),
    [
        ("antenna", {"load.inertia": "2 kg*m^2"}, "inertia: 1.3 kg*m^2", "inertia: 2 kg*m^2"),
        ("antenna", {"gear": "SHG-40-50"}, "CSG-40-50", "SHG-40-50"),
        ("loop by bandwidth, payload", {"loop.bandwidth": "20 Hz"}, "30 Hz", "20 Hz"),
        ("loop by bandwidth, payload", {"motor.loop.damping": "1"}, "damping: 0.7", "damping: 1"),
        ("loop by bandwidth, payload", {"load_torque.mean.from": "-50 N*m"}, "-60 N*m", "-50 N*m"),
        ("position loop, coupling", {"coupling.law.K": "3e5 N*m/rad"}, "K: 4e5 N*m/rad", "K: 3e5 N*m/rad"),
        ("position loop, coupling", {"gear.alpha": "1e4 1/rad^2"}, "6.9e4 1/rad^2", "1e4 1/rad^2"),
        ("position loop, coupling", {"gear.ratio": "80"}, "ratio: 50", "ratio: 80"),
        ("two couplings, gravity", {"couplings.1.inertia": "0.3 kg*m^2"}, "{inertia: 0.1", "{inertia: 0.3"),
        ("two couplings, gravity", {"kinematic_error.1.amplitude": "5 arcsec"}, ": 3 arcsec", ": 5 arcsec"),
        ("accuracy class of the catalogue", {"damping.quality": "10"}, "quality: 20", "quality: 10"),
        ("backlash", {"speed": "900 rpm"}, "from: 1000 rpm, to: 2500 rpm", "at: [900 rpm]"),
        ("backlash", {"limit.oscillation": "9 arcsec"}, "gear:", "limit: {oscillation: 9 arcsec}\ngear:"),
        ("backlash", MOVE, "gear:", "move: {profile: [{type: s_curve, angle: 90 deg, time: 0.6 s}]}\ngear:"),
    ],
)
def test_another_value_is_read_as_if_the_file_had_it(read, project, values, old, new):
    text = PROJECTS[project]
    assert text.count(old) >= 1
    found = sw.replaced(read(text), values, retune=True)
    assert apart(found, read(text.replace(old, new, 1))) == []
    assert apart(found, read(text)) != []
    assert apart(sw.replaced(found, {}), found) == []


BUILT = """
gear: SHG-32-100
motor: {inertia: 4.5 kg*cm^2, loop: {type: speed, bandwidth: 40 Hz, damping: 1, lag: 0.5 ms}}
load: {inertia: 5 kg*m^2}
damping: {ratio: 2.5 %}
speed: {from: 100 rpm, to: 3000 rpm, shaft: motor}
excitation: {kinematic_error: [{order: 2, amplitude: 25 arcsec}]}
limit: {oscillation: 115 arcsec}
scatter: {load.inertia: 25 %}
"""


def built(bandwidth, J_l, ratio, K1):
    """Gains and B of BUILT by hand: K_p = J w and K_i = J (w/2)^2 of damping 1, J the motor and the load over N^2."""
    J, w = 4.5e-4 + J_l / 100.0**2, 2.0 * math.pi * bandwidth
    return J * w, J * w * w / 4.0, 2.0 * ratio * math.sqrt(K1 * J_l)


@pytest.mark.parametrize(
    ("values", "gains_of", "B_of"),
    [
        ({"load.inertia": "2 kg*m^2"}, (40.0, 5.0), (5.0, 0.025)),
        ({"motor.inertia": "9 kg*cm^2", "gear.K1": "4e4 N*m/rad"}, (40.0, 5.0), (5.0, 0.025)),
        ({"loop.bandwidth": "30 Hz"}, (30.0, 5.0), (5.0, 0.025)),
        ({"load.inertia": "2 kg*m^2", "loop.bandwidth": "30 Hz"}, (30.0, 5.0), (5.0, 0.025)),
        ({"damping.ratio": "5 %", "load.inertia": "2 kg*m^2"}, (40.0, 5.0), (5.0, 0.05)),
        ({"gear": "SHG-40-120", "load.inertia": "2 kg*m^2"}, (40.0, 5.0), (5.0, 0.025)),
    ],
)
def test_a_drive_is_built_once(read, values, gains_of, B_of):
    project = read(BUILT)
    found = sw.replaced(project, values)
    K1 = (sw.catalogue.gear(values["gear"]) if "gear" in values else project.gear).K1
    K_p, K_i, B = built(*gains_of, B_of[1], K1)
    loop = found.whole.motor.control.loop
    assert (loop.K_p, loop.K_i) == pytest.approx((K_p, K_i), rel=1e-12)
    assert pytest.approx((B, B), rel=1e-12) == (found.drive.B, found.whole.B)
    assert apart(read(sw.project_text(found)), found) in ([], ["notes"], ["gear", "notes"])


def test_a_drive_is_built_anew_where_that_is_asked_for(read):
    found = sw.replaced(read(BUILT), {"load.inertia": "2 kg*m^2"}, retune=True)
    K_p, _, B = built(40.0, 2.0, 0.025, found.gear.K1)
    assert (found.whole.motor.control.loop.K_p, found.drive.B) == pytest.approx((K_p, B), rel=1e-12)
    assert "bandwidth" in found.text


def test_what_is_kept_is_said(read):
    project = read(BUILT)
    both = "Kept from the drive before the change: the gains of the motor's loop and the damping B."
    assert sw.replaced(project, {"load.inertia": "2 kg*m^2"}).notes[-1] == both
    assert both not in sw.replaced(project, {"speed": "900 rpm"}).notes
    assert tuning(project, ["load.inertia"], False).startswith("Kept as in the drive of the file: the gains")
    assert tuning(project, ["load.inertia"], True).startswith("Computed anew for every drive: the gains")
    assert tuning(project, ["loop.bandwidth", "damping.ratio"], False).count("gains") == 1
    assert tuning(project, ["loop.bandwidth"], False).startswith("Kept as in the drive of the file: the damping B;")
    assert tuning(read(PROJECTS["position loop, coupling"]), ["load.inertia"], False) == ""


def test_a_remedy_and_another_value_give_the_same_drive(read):
    project, other = read(BUILT), sw.catalogue.gear("SHG-32-120")
    subject = Subject(project.system(reduced=True), project.train, project.speeds.limits, project)
    found = with_gear(subject, project, other).train
    assert found._replace(reference=0.0) == sw.replaced(project, {"gear": "SHG-32-120"}).train._replace(reference=0.0)


def test_numbers_of_a_catalogue_gear_replace_those_of_its_law(read):
    project = read(PROJECTS["hysteresis"])
    found = sw.replaced(project, {"gear.K1": "9e4 N*m/rad", "load.inertia": "2 kg*m^2"})
    assert found.drive.law == sw.Parallel(project.gear.law._replace(K1=9e4), project.drive.law.second)
    again = sw.replaced(found, {"gear.K2": "9.5e4 N*m/rad", "load.inertia": "3 kg*m^2"})
    assert again.drive.law.first == project.gear.law._replace(K1=9e4, K2=9.5e4)
    assert found.whole.law == found.drive.law
    assert (found.drive.J_l, found.gear) == (2.0, project.gear)


@pytest.mark.parametrize(
    ("project", "values", "said"),
    [
        ("antenna", {"load.inertia": "2"}, r"^load\.inertia: '2' has no unit; write for example 1\.3 kg\*m\^2"),
        ("antenna", {"lod.x": "2 kg*m^2"}, "the project file has no 'lod.x'; its numbers are motor.inertia, load"),
        ("antenna", {"x" * 5000: "2 kg*m^2"}, "^the project file has no 'x+... .{1,40}; its numbers are motor.inertia"),
        ("antenna", {"inertia": "2 kg*m^2"}, "'inertia' is in several groups of the file; write motor.inertia or load"),
        ("antenna", {"load.inertia.x": "2 kg*m^2"}, r"load\.inertia is not a group with 'x'"),
        ("antenna", {"gear": "CSG-40-51"}, "CSG-40-51"),
        ("article", {"gear.K1": "9 N*m/rad"}, "gear.law.K1: unknown field"),
        ("loop by bandwidth, payload", {"loop.K_p": "3 N*m/rad"}, "K_p: is a gain, and bandwidth and damping give"),
    ],
)
def test_what_the_file_may_not_have_is_refused_in_its_own_sentence(read, project, values, said):
    with pytest.raises(ValueError, match=said) as error:
        sw.replaced(read(PROJECTS[project]), values)
    assert "\n" not in str(error.value)
    assert "drive.yaml" not in str(error.value)


@pytest.mark.parametrize(("shaft", "factor"), [("motor", 1.0), ("load", 100.0 / 50.0)])
def test_another_ratio_keeps_the_speeds_of_the_shaft_that_has_them(tmp_path, shaft, factor):
    path = tmp_path / "drive.yaml"
    path.write_text(PROJECTS["catalogue gear, motor not named"], encoding="utf-8")
    project = replaced(read_project(path), {"speed.shaft": shaft})
    assert project.drive.N == 50.0
    other = replaced(project, {"gear": "CSG-40-100"})
    assert other.speeds.limits == pytest.approx([factor * omega for omega in project.speeds.limits], rel=1e-14)


def test_the_scatter_of_a_notation_is_that_of_the_number_that_is_kept(read):
    scatter = "scatter: {damping.ratio: 10 %, loop.bandwidth: 5 %, load.inertia: 3 %}"
    text = f"{BUILT.partition('scatter')[0]}{scatter}\nscatter_correlation: [[1, 0, 0.5], [0, 1, 0], [0.5, 0, 1]]\n"
    found = sw.replaced(read(text), {"load.inertia": "2 kg*m^2"})
    assert found.scatter == (("damping.B", 0.1), ("load.inertia", 0.03))
    assert found.correlation == ((1.0, 0.5), (0.5, 1.0))
    assert "Gains take the place of loop.bandwidth, whose scatter is left out." in found.notes[-1]
    assert sw.replaced(read(text), {"load.inertia": "2 kg*m^2"}, retune=True).scatter[1] == ("loop.bandwidth", 0.05)


def test_another_gear_keeps_the_member_that_is_fixed(read):
    text = BUILT.replace("gear: SHG-32-100", "gear: {name: CSG-40-50, fixed: flexspline}").replace("3000", "1000")
    project = read(text)
    subject = Subject(project.system(reduced=True), project.train, project.speeds.limits, project)
    for name, ratio in (("CSG-45-50", 51.0), ("CSG-40-80", 81.0)):
        found = with_gear(subject, project, sw.catalogue.gear(name))
        assert pytest.approx(ratio, rel=1e-15) == found.train.N
        assert found.speeds == pytest.approx([ratio / 51.0 * speed for speed in subject.speeds])
