"""The catalogue gives back its tables, applies their doubts, and agrees with printed twists and frequencies."""

import csv
import math

import pytest

import strainwave as sw
from strainwave.model.gears.catalogue import DATA
from strainwave.model.gears.gear import NUMBERS

ARCMIN = math.pi / 10800.0


def rows(file: str) -> list[dict[str, str]]:
    with (DATA / file).open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


RATINGS = rows("catalogue_ratings.csv")
STIFFNESS = rows("catalogue_stiffness.csv")
RATCHETING = rows("catalogue_ratcheting.csv")
ACCURACY = rows("catalogue_accuracy.csv")
RT1 = rows("catalogue_rt1.csv")
GEARS = [sw.catalogue.gear(name) for name in sw.catalogue.names()]


def gear_of(row: dict[str, str]) -> sw.catalogue.Gear:
    return sw.catalogue.gear(f"{row['series']}-{row['size']}-{row['ratio']}")


def test_the_tables_hold_as_many_rows_as_were_published():
    assert (len(RATINGS), len(STIFFNESS)) == (115, 57)
    kinds = [gear.series == "CSF" or gear.series.startswith("RT1") for gear in GEARS]
    assert kinds.count(False) == 115
    assert len(GEARS) == len({gear.name for gear in GEARS}) == 183  # and 64 CSF, 4 RT1-H-CS


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
        for gear in GEARS
        if gear.series in row["family"].split("/")
        and str(gear.size) == row["size"]
        and (gear.ratio >= lowest if row["ratio"].startswith(">=") else gear.ratio == lowest)
    ]
    for gear in covered:
        assert (float(row["T1_Nm"]), float(row["T2_Nm"])) == (gear.T1, gear.T2)
        assert tuple(float(row[f"K{i}_Nm_per_rad"]) for i in (1, 2, 3)) == (gear.K1, gear.K2, gear.K3)
        assert gear.law == sw.PiecewiseLinear(gear.K1, gear.K2, gear.K3, gear.T1, gear.T2)
        if row["note"]:
            assert any(row["note"] in said for said in (gear.source, *gear.notes))
    assert covered


@pytest.mark.parametrize("row", RATCHETING, ids=lambda r: f"{r['series']}-{r['size']}")
def test_every_ratcheting_and_buckling_torque_comes_back(row):
    for ratio in (30, 50, 80, 100, 120, 160):
        printed = row[f"ratcheting_ratio_{ratio}_Nm"]
        gear = next((g for g in GEARS if g.name == f"{row['series']}-{row['size']}-{ratio}"), None)
        if gear is not None:
            assert gear.ratcheting_torque == (float(printed) if printed else None)
            assert gear.buckling_torque == float(row["buckling_Nm"])
            assert row["source"] in gear.source
        elif printed:  # no stiffness: CSF-8 and CSF-11 with other ratios than 30, CSF-100; no ratings: none of CSG
            assert (row["series"], row["size"]) in {("CSF", "8"), ("CSF", "11"), ("CSF", "100")}


@pytest.mark.parametrize("row", ACCURACY, ids=lambda r: f"{r['quantity']}-{r['sizes']}-{r['ratio']}")
def test_every_accuracy_comes_back(row):
    scale = {"1e-4 rad": 1e-4, "arcmin": ARCMIN}[row["unit"]]
    lowest = int(row["ratio"].removeprefix(">="))
    for gear in GEARS:
        ratio = gear.ratio >= lowest if ">=" in row["ratio"] else gear.ratio == lowest
        if gear.series in row["families"].split("/") and str(gear.size) in row["sizes"].split("/") and ratio:
            assert getattr(gear, row["quantity"]) == pytest.approx(float(row["value"]) * scale, rel=1e-15)
            assert row["source"] in gear.source
    # The printed arcmin are the printed rad, rounded to the half.
    assert float(row["value"]) * scale / ARCMIN == pytest.approx(float(row["printed"].strip("< arcmin")), abs=0.02)


# TPI 275 of Schaeffler: sizes 14, 17, 20, 25 with ratio 100.
@pytest.mark.parametrize(
    ("size", "K1", "K3", "rated"),
    [(14, 4.7e3, 7.1e3, 10), (17, 10e3, 16e3, 31), (20, 16e3, 29e3, 52), (25, 31e3, 57e3, 87)],
)
def test_schaefflers_gears_have_the_stiffness_of_harmonic_drives(size, K1, K3, rated):
    gear = sw.catalogue.gear(f"RT1-H-CS-{size}-100")
    assert (gear.K1, gear.K3, gear.rated_torque) == (K1, K3, rated)
    peer = sw.catalogue.gear(f"CSG-{size}-100")
    assert (peer.K1, peer.K3) == (gear.K1, gear.K3)
    with pytest.raises(ValueError, match=f"RT1-H-CS-{size}-100 has no torsion law: K2, T1, T2 are not tabulated"):
        _ = gear.law
    with pytest.raises(ValueError, match="has no input inertia in its sources; give motor_inertia"):
        gear.drive(load_inertia=1.0, B=0.0)


@pytest.mark.parametrize("row", RT1, ids=lambda r: r["size"])
def test_every_number_of_schaefflers_gears_comes_back(row):
    gear = sw.catalogue.gear(f"{row['series']}-{row['size']}-{row['ratio']}")
    assert gear.efficiency == pytest.approx(float(row["efficiency_percent"]) / 100.0, rel=1e-15)
    assert gear.running_torque == pytest.approx(float(row["running_torque_2000rpm_mNm"]) * 1e-3, rel=1e-15)
    assert gear.starting_torque == pytest.approx(float(row["starting_torque_mNm"]) * 1e-3, rel=1e-15)
    assert gear.back_driving_torque == float(row["back_driving_torque_Nm"])
    assert gear.pitch_radius == pytest.approx(float(row["pitch_radius_mm"]) * 1e-3, rel=1e-15)
    assert gear.pitch_radius * 2.0 == pytest.approx(
        gear.size * 2.54e-3, rel=1e-3
    )  # size: pitch diameter in inch times 10
    assert gear.source == row["source"]


@pytest.mark.parametrize("gear", GEARS, ids=lambda g: g.name)
def test_no_record_contradicts_itself(gear):
    assert list(gear.contradictions()) == []
    assert gear.source


# Torsion [1e-4 rad] at T1 and T2 that the maker prints beside the stiffness: CSF/CSG catalogue, p. 50.
@pytest.mark.parametrize(
    ("size", "at_T1", "at_T2"),
    [
        ("8", 8.5, 19),
        ("11", 9.5, 19),
        ("14", 10.5, 31),
        ("17", 11.5, 30),
        ("20", 12.3, 38),
        ("25", 14.0, 40),
        ("32", 12.1, 38),
    ],
)
def test_ratio_30_twists_as_the_maker_prints(size, at_T1, at_T2):
    gear = sw.catalogue.gear(f"CSF-{size}-30")
    assert 1e4 * gear.twist(gear.T1) == pytest.approx(at_T1, abs=0.051)
    assert 1e4 * gear.twist(gear.T2) == pytest.approx(at_T2, abs=0.51)


@pytest.mark.parametrize(
    ("name", "at_T1"),
    [
        ("HFUS-11-50", 3.6),
        ("CSF-14-50", 5.8),
        ("CSF-17-50", 4.9),
        ("CSF-20-50", 5.2),
        ("CSF-25-50", 5.5),
        ("CSF-32-50", 5.5),
        ("CSF-40-50", 5.2),
    ],
)
def test_ratio_50_twists_within_5_percent_of_what_the_maker_prints(name, at_T1):
    gear = sw.catalogue.gear(name)
    assert 1e4 * gear.twist(gear.T1) == pytest.approx(at_T1, rel=0.05)


def test_size_40_has_the_cubic_fit_of_its_slopes():
    gear = sw.catalogue.gear("CSG-40-50")
    assert gear.cubic == pytest.approx((1.089e5, 6.85e4), rel=1e-3)  # an independent least-squares program
    assert gear.reach == pytest.approx(gear.twist(1.5 * 196.0), rel=1e-15)
    assert gear.fit(3).law == gear.cubic
    assert gear.fit(5).rms < gear.fit(3).rms
    assert gear.rounded(1e-4) == sw.laws.RoundedPiecewiseLinear(1e5, 1.4e5, 1.8e5, 54.0, 196.0, 1e-4)
    with pytest.raises(ValueError, match="where the rounded corners meet"):
        gear.rounded(1.0)


def test_select_meets_every_condition():
    found = sw.catalogue.select(series="csg", ratio=100, torque=300.0, speed=3000.0 * math.pi / 30.0)
    assert [g.name for g in found] == ["CSG-40-100", "CSG-45-100", "CSG-50-100", "CSG-58-100"]
    assert sw.catalogue.select(found, stiffness=2.5e5) == found[2:]
    assert sw.catalogue.select(size=40, ratio=51) == []
    assert all(g.rated_torque is not None for g in sw.catalogue.select(torque=1.0))


def test_footnotes_of_the_momentary_torque_are_passed_on():
    assert any("395 (382)" in note for note in sw.catalogue.gear("CSG-25-120").notes)
    assert len([g for g in GEARS if any("momentary peak torque" in note for note in g.notes)]) == 9


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


def test_torques_that_a_record_shares_with_another_series_alone_are_flagged():
    torques = [key for key in RATINGS[0] if key.startswith("T_")]
    alike = {(r["size"], r["ratio"]): [r[key] for key in torques] for r in RATINGS if r["series"] == "CSG"}
    copied = {
        f"HFUS-{r['size']}-{r['ratio']}"
        for r in RATINGS
        if r["series"] == "HFUS" and alike.get((r["size"], r["ratio"])) == [r[key] for key in torques]
    }
    assert copied == {"HFUS-50-80", "HFUS-58-80"}
    for gear in map(sw.catalogue.gear, copied):
        for limit in ("rated_torque", "average_torque", "repeated_peak_torque", "momentary_torque"):
            assert any("digit for digit" in note for note in gear.doubts_about(limit))


@pytest.mark.parametrize("gear", GEARS, ids=lambda gear: gear.name)
def test_every_doubt_is_a_note_on_a_number_of_the_record(gear):
    assert {note for _, note in gear.doubts} <= set(gear.notes)
    assert {name for name, _ in gear.doubts} <= set(NUMBERS)
    assert all(note.startswith(f"{gear.name}: ") and note.endswith(".") and ".." not in note for note in gear.notes)


def test_a_name_may_be_written_carelessly():
    assert sw.catalogue.gear(" csg 40_50 ").name == "CSG-40-50"


@pytest.mark.parametrize(
    ("name", "sentence"),
    [
        ("CSG-40-51", "the catalogue has no gear 'CSG-40-51'; the nearest are CSG-40-50"),
        ("XYZ", "its names look like CSG-40-50"),
        ("", "its names look like CSG-40-50"),
    ],
)
def test_a_gear_that_is_not_there_is_refused_with_help(name, sentence):
    with pytest.raises(ValueError, match=sentence):
        sw.catalogue.gear(name)


def test_a_csf_gear_says_what_is_not_tabulated_and_has_the_inertia_of_its_sister():
    gear = sw.catalogue.gear("CSF-40-50")
    assert (gear.rated_torque, gear.max_rpm, gear.max_speed, gear.mass) == (None, None, None, None)
    assert any("input speeds and mass are not tabulated" in note for note in gear.notes)
    assert gear.input_inertia == sw.catalogue.gear("CSG-40-50").input_inertia
    assert gear.law == sw.catalogue.gear("CSG-40-50").law
    assert sw.catalogue.gear("CSF-8-30").input_inertia is None
