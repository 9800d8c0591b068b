"""Projects with other values in their files: what is read is what a file with that value says."""

from dataclasses import fields

import pytest
from twelve_projects import PROJECTS

import strainwave as sw
from strainwave.files.reading import from_text, read_project
from strainwave.files.variants.replaced import replaced


@pytest.fixture
def read(tmp_path):
    return lambda text: from_text(text, tmp_path / "drive.yaml")


def apart(one, other):
    names = [field.name for field in fields(one) if field.name != "text"]
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
    ],
)
def test_another_value_is_read_as_if_the_file_had_it(read, project, values, old, new):
    text = PROJECTS[project]
    assert text.count(old) >= 1
    found = sw.replaced(read(text), values)
    assert apart(found, read(text.replace(old, new, 1))) == []
    assert apart(found, read(text)) != []
    assert apart(sw.replaced(found, {}), found) == []


def test_numbers_of_a_catalogue_gear_replace_those_of_its_law(read):
    project = read(PROJECTS["hysteresis"])
    found = sw.replaced(project, {"gear.K1": "9e4 N*m/rad", "load.inertia": "2 kg*m^2"})
    assert found.drive.law == sw.Parallel(project.gear.law._replace(K1=9e4), project.drive.law.second)
    assert found.whole.law == found.drive.law
    assert (found.drive.J_l, found.gear) == (2.0, project.gear)


@pytest.mark.parametrize(
    ("project", "values", "said"),
    [
        ("antenna", {"load.inertia": "2"}, r"^load\.inertia: '2' has no unit; write for example 1\.3 kg\*m\^2"),
        ("antenna", {"load.inertia": "-2 kg*m^2"}, r"^load\.inertia: '-2 kg\*m\^2' is not positive"),
        ("antenna", {"load.inertias": "2 kg*m^2"}, r"load\.inertias: unknown field; did you mean"),
        ("antenna", {"lod.x": "2 kg*m^2"}, "the project file has no 'lod.x'; its numbers are motor.inertia, load"),
        ("antenna", {"inertia": "2 kg*m^2"}, "'inertia' is in several groups of the file; write motor.inertia or load"),
        ("antenna", {"load.inertia.x": "2 kg*m^2"}, r"load\.inertia is not a group with 'x'"),
        ("antenna", {"gear": "CSG-40-51"}, "CSG-40-51"),
        ("antenna", {"gear.K1": "9 N*m"}, r"gear\.K1: '9 N\*m' is not per radian"),
        ("article", {"gear.K1": "9 N*m/rad"}, "gear.law.K1: unknown field"),
        ("two couplings, gravity", {"couplings.2.inertia": "1 kg*m^2"}, "is not a group with '2'"),
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
