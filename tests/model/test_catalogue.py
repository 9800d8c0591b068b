"""The catalogue gives back its tables, applies their doubts, and agrees with printed twists and frequencies."""

import csv
import dataclasses
import math
import pickle

import pytest

import strainwave as sw
from strainwave.model.catalogue import DATA

ARCMIN = math.pi / 10800.0


def rows(file: str) -> list[dict[str, str]]:
    with (DATA / file).open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


RATINGS = rows("catalogue_ratings.csv")
STIFFNESS = rows("catalogue_stiffness.csv")


def gear_of(row: dict[str, str]) -> sw.catalogue.Gear:
    return sw.catalogue.gear(f"{row['series']}-{row['size']}-{row['ratio']}")


def test_the_tables_hold_as_many_rows_as_were_published():
    assert (len(RATINGS), len(STIFFNESS)) == (115, 57)
    assert len(sw.catalogue.names()) == len(set(sw.catalogue.names())) == 115


@pytest.mark.parametrize("row", RATINGS, ids=lambda r: f"{r['series']}-{r['size']}-{r['ratio']}")
def test_every_rating_comes_back(row):
    gear = gear_of(row)
    assert (gear.series, str(gear.size), str(gear.ratio)) == (row["series"], row["size"], row["ratio"])
    assert gear.rated_torque == float(row["T_rated_2000rpm_Nm"])
    assert gear.average_torque == float(row["T_average_Nm"])
    assert gear.repeated_peak_torque == float(row["T_repeated_peak_Nm"])
    assert gear.momentary_torque == float(row["T_momentary_Nm"])
    assert gear.max_rpm == float(row["n_in_max_rpm"])
    assert gear.average_rpm == float(row["n_in_avg_rpm"])
    assert gear.max_speed == pytest.approx(gear.max_rpm * 2.0 * math.pi / 60.0, rel=1e-15)
    assert gear.average_speed == pytest.approx(gear.average_rpm * 2.0 * math.pi / 60.0, rel=1e-15)
    assert gear.input_inertia == pytest.approx(float(row["J_in_1e-4_kgm2"]) * 1e-4, rel=1e-15)
    assert row["source"] in gear.source


@pytest.mark.parametrize("row", STIFFNESS, ids=lambda r: f"{r['family']}-{r['size']}-{r['ratio']}")
def test_every_stiffness_comes_back_for_every_gear_it_holds_for(row):
    lowest = int(row["ratio"].removeprefix(">="))
    covered = [
        gear
        for gear in map(sw.catalogue.gear, sw.catalogue.names())
        if gear.series in row["family"].split("/")
        and str(gear.size) == row["size"]
        and (gear.ratio >= lowest if row["ratio"].startswith(">=") else gear.ratio == lowest)
    ]
    for gear in covered:
        assert (float(row["T1_Nm"]), float(row["T2_Nm"])) == (gear.T1, gear.T2)
        assert tuple(float(row[f"K{i}_Nm_per_rad"]) for i in (1, 2, 3)) == (gear.K1, gear.K2, gear.K3)
        assert gear.law == sw.PiecewiseLinear(gear.K1, gear.K2, gear.K3, gear.T1, gear.T2)
        if row["note"]:
            assert any(row["note"] in note for note in gear.notes)
    assert bool(covered) == (row["family"] != "CSF")


# Twist formula and limit torques: Harmonic Drive LLC, CSF/CSG catalogue, p. 50; size 40.
@pytest.mark.parametrize(
    ("name", "torque", "arcmin"),
    [
        ("CSG-40-50", 54.0, 1.8564),
        ("CSG-40-50", 196.0, 5.3432),
        ("CSG-40-50", 300.0, 7.3295),
        ("CSG-40-80", 54.0, 1.4280),
        ("CSG-40-80", 196.0, 3.8688),
        ("CSG-40-160", 300.0, 5.4232),
    ],
)
def test_size_40_twists_as_the_vendors_formula_says(name, torque, arcmin):
    gear = sw.catalogue.gear(name)
    assert gear.twist(torque) / ARCMIN == pytest.approx(arcmin, abs=0.5e-4)
    assert gear.twist(-torque) == -gear.twist(torque)
    assert gear.law.torque(gear.twist(torque)) == pytest.approx(torque, rel=1e-14)


def test_natural_frequency_of_size_40_with_the_motor_held_is_the_vendors():
    drive = sw.catalogue.gear("CSG-40-100").drive(load_inertia=10.0, B=0.0)
    assert drive.omega_0_held / (2.0 * math.pi) == pytest.approx(18.1465, abs=0.5e-4)


def test_the_drive_takes_the_wave_generator_as_motor_inertia_unless_told():
    gear = sw.catalogue.gear("CSG-40-50")
    assert gear.drive(load_inertia=1.3, B=2.0) == sw.Drive(4.5e-4, 1.3, 50.0, 2.0, gear.law)
    assert gear.drive(load_inertia=1.3, motor_inertia=1e-3, B=2.0).J_m == 1e-3


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"load_inertia": 0.0}, "load_inertia is 0.0"),
        ({"load_inertia": math.nan}, "load_inertia is nan"),
        ({"motor_inertia": -1.0}, "motor_inertia is -1.0"),
        ({"B": -1.0}, "B is -1.0"),
        ({"B": math.inf}, "B is inf"),
    ],
)
def test_the_drive_refuses_impossible_inertias_and_damping(changes, sentence):
    with pytest.raises(ValueError, match=sentence):
        sw.catalogue.gear("CSG-40-50").drive(**({"load_inertia": 1.3, "B": 0.0} | changes))


def test_an_ambiguous_mass_is_empty_and_says_why():
    gear = sw.catalogue.gear("CSG-40-50")
    assert gear.mass is None
    assert any("(5, 3.5)" in note for note in gear.notes)
    assert sw.catalogue.gear("SHG-40-50").mass == 7.7


def test_average_speeds_that_look_mistyped_are_flagged_and_no_others():
    flagged = {n for n in sw.catalogue.names() if any("mistyped" in note for note in sw.catalogue.gear(n).notes)}
    slow = {f"{r['series']}-{r['size']}-{r['ratio']}" for r in RATINGS if r["n_in_avg_rpm"] in {"1100", "950", "900"}}
    assert slow <= flagged
    assert {"SHG-58-120", "SHG-65-100"} <= flagged
    assert not any(name.startswith(("CSG", "HFUC")) for name in flagged)
    assert not {"SHG-40-50", "SHG-65-80", "SHG-20-50"} & flagged


def test_a_name_may_be_written_carelessly():
    assert sw.catalogue.gear(" csg 40_50 ").name == "CSG-40-50"


@pytest.mark.parametrize(
    ("name", "sentence"),
    [
        ("CSG-40-51", "the catalogue has no gear 'CSG-40-51'; the nearest are CSG-40-50"),
        ("XYZ", "its names look like CSG-40-50"),
        ("", "its names look like CSG-40-50"),
        (
            "CSF-40-50",
            "torques, input speeds, input inertia and mass are not tabulated; CSG-40-50 has the same stiffness",
        ),
        ("CSF-8-30", "torques, input speeds, input inertia and mass are not tabulated; give ratio and law explicitly"),
    ],
)
def test_a_gear_that_is_not_there_is_refused_with_help(name, sentence):
    with pytest.raises(ValueError, match=sentence):
        sw.catalogue.gear(name)


def test_a_gear_without_tabulated_stiffness_says_what_is_missing(monkeypatch):
    monkeypatch.setattr(sw.catalogue, "_gears", dict)
    with pytest.raises(ValueError, match=r"torsional stiffness \(K1, K2, K3, T1, T2\) is not tabulated"):
        sw.catalogue.gear("CSG-40-50")


def test_a_record_is_frozen_and_travels():
    gear = sw.catalogue.gear("CSG-40-50")
    with pytest.raises(dataclasses.FrozenInstanceError):
        gear.K1 = 0.0
    assert pickle.loads(pickle.dumps(gear)) == gear
