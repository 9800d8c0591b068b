"""Numbers that are legal and absurd get one sentence each; sound drives get none."""

import math
import random
from pathlib import Path

import numpy as np
import pytest

import strainwave as sw
from strainwave.files.notes import unsaid
from strainwave.files.reading import from_text

EXPLICIT = """\
gear: {{ratio: 50, rated_torque: 137 N*m, law: {{type: linear, K: {K}}}}}
motor: {{inertia: {J_m}}}
load: {{inertia: {J_l}}}
damping: {{{damping}}}
speed: {{from: {low}, to: {high}, shaft: {shaft}}}
excitation:
  kinematic_error: [{{order: 2, amplitude: {error}}}]
  load_torque: {{mean: {mean}}}
"""
SOUND = {
    "K": "1e5 N*m/rad", "J_m": "6 kg*cm^2", "J_l": "1.3 kg*m^2", "damping": "ratio: 3 %", "low": "500 rpm",
    "high": "3000 rpm", "shaft": "motor", "error": "23 arcsec", "mean": "-50 N*m",
}  # fmt: skip


def notes(**fields):
    return from_text(EXPLICIT.format(**SOUND | fields), Path("project.yaml")).notes


ABSURD = {
    "K too small by 10^4": ({"K": "10 N*m/rad"}, "twists by 4.71e+04 arcmin under its rated torque of 137 N*m"),
    "K too large by 10^4": ({"K": "1e9 N*m/rad"}, "twists by 0.000471 arcmin under its rated torque of 137 N*m"),
    "load's inertia at the motor": ({"J_l": "5.2 kg*cm^2"}, "is 0.000347 times the motor inertia at the output, 50^2"),
    "motor's inertia at the output": ({"J_m": "1.5 kg*m^2"}, "motor.inertia may be too large by 50^2, or load.inertia"),
    "error of degrees": ({"error": "0.4 deg"}, "sum to 24 arcmin; gears have at most 1 arcmin"),
    "damping in percent": ({"damping": "ratio: 3"}, "The damping ratio is 3 (300 % of critical)"),
    "damping above 20 %": ({"damping": "ratio: 0.25"}, "The damping ratio is 0.25 (25 % of critical)"),
    "output speeds": ({"low": "10 rpm", "high": "60 rpm"}, "if these are output speeds, write 'shaft: load'"),
    "motor speeds": ({"shaft": "load"}, "The motor speed is 1.5e+05 rpm; gears allow at most 8500 rpm at the input"),
    "speeds far away": (
        {"low": "90 rpm", "high": "130 rpm"},
        "is far from all excitation frequencies in the speed range, 3 to 4.33 Hz",
    ),
    "torque that ratchets": ({"mean": "-3000 N*m"}, "reaches 3000 N*m, 21.9 times the rated torque; gears ratchet"),
}


@pytest.mark.parametrize(("fields", "said"), ABSURD.values(), ids=ABSURD.keys())
def test_what_is_legal_and_absurd_gets_its_sentence(fields, said):
    found = notes(**fields)
    assert sum(said in note for note in found) == 1
    # a wrong stiffness or inertia shows in the natural frequency too
    assert len([note for note in found if said not in note and "natural frequency" not in note.lower()]) == 0


@pytest.mark.parametrize(
    ("loop", "said"),
    [  # J = 6e-4 + 1.3/50^2 kg*m^2: K_p = 0.14 N*m*s/rad crosses over at 125 rad/s
        ("K_v: 30 1/s, K_p: 140 N*m*s/rad, T_n: 32 ms", "is at 1.99e+04 Hz; 1 to 1000 Hz is usual"),
        ("K_v: 30 1/s, K_p: 0.14 N*m*s/rad, T_n: 32 s", "motor.loop.T_n is 32000 ms, 1e+03 times slower"),
        ("K_v: 0.03 1/s, K_p: 0.14 N*m*s/rad, T_n: 32 ms", "motor.loop.K_v is 0.03 1/s, 1.04e+03 times slower"),
        ("bandwidth: 40 kHz", "1 to 1000 Hz is usual. Check the unit of motor.loop.bandwidth."),
    ],
)
def test_gains_in_the_unit_of_another_maker_are_said(loop, said):
    text = EXPLICIT.format(**SOUND).replace("motor: {", f"motor: {{loop: {{type: cascade, {loop}}}, ")
    (note,) = from_text(text, Path("project.yaml")).notes
    assert said in note
    assert "check the" in note.lower()


def test_a_damping_of_a_bandwidth_is_no_gain_in_another_unit():
    loop = "motor: {loop: {type: cascade, bandwidth: 40 Hz, damping: 0.1}, "
    assert from_text(EXPLICIT.format(**SOUND).replace("motor: {", loop), Path("project.yaml")).notes == ()


NOTCHED = "motor: {{loop: {{type: cascade, bandwidth: 30 Hz, filters: [{{type: notch, {}}}]}}, "


def test_a_notch_at_the_crossover_says_what_it_takes():
    filters = NOTCHED.format("frequency: 30 Hz, width: 30 Hz, depth: 0.4")
    (note,) = from_text(EXPLICIT.format(**SOUND).replace("motor: {", filters), Path("project.yaml")).notes
    frequency = np.linspace(1.0, 40.0, 390_001)
    s = 1j * frequency
    notch = (s * s + 0.4 * 30.0 * s + 900.0) / (s * s + 30.0 * s + 900.0)
    at = np.flatnonzero(np.abs(30.0 / s * notch) < 1.0)[0]  # of a loop that crosses over at 30 Hz on a rigid gear
    assert f"falls from 30 to {frequency[at]:.3g} Hz" in note
    assert f"phase loss of {-np.degrees(np.angle(notch[at])):.3g} degrees" in note


@pytest.mark.parametrize("notch", ["frequency: 150 Hz, width: 60 Hz", "frequency: 60 Hz, width: 50 Hz"])
def test_a_notch_beside_the_crossover_is_no_matter(notch):
    text = EXPLICIT.format(**SOUND).replace("motor: {", NOTCHED.format(notch))
    assert from_text(text, Path("project.yaml")).notes == ()


def test_a_torque_that_ratchets_is_found_at_the_end_of_a_range_and_in_gravity():
    (of_range,) = notes(mean="{from: -1000 N*m, to: 3000 N*m}")
    gravity = "1.3 kg*m^2, drag: {type: angle_torque, amplitude: 2950 N*m}"
    (of_gravity,) = notes(mean="-50 N*m", J_l=gravity)
    assert of_range == of_gravity
    assert "The load torque reaches 3000 N*m, 21.9 times the rated torque" in of_range


def test_a_free_motor_cannot_balance_a_range_of_torques():
    # N (N T_m + T_l) = (N^2 J_m + J_l) of the motor's acceleration, by Newton
    rate = 50.0 * (50.0 * 1.5 + 60.0) / (50.0**2 * 6e-4 + 1.3) * 30.0 / math.pi
    driven = "{from: -20 N*m, to: 60 N*m}}\n  motor_torque: {mean: 1.5 N*m"
    (said,) = notes(J_m="6 kg*cm^2, mode: free", mean=driven)
    assert f"do not balance under a load torque of 60 N*m: the motor accelerates by {rate:.4g} rpm/s" in said
    assert said.endswith("cannot run steadily; write 'mode: held'.")


def test_a_natural_frequency_that_no_drive_has_is_said():
    text = EXPLICIT.format(**SOUND | {"K": "3e7 N*m/rad", "J_l": "0.1 kg*m^2"}).replace("137 N*m", "3e4 N*m")
    (note,) = from_text(text, Path("project.yaml")).notes
    assert note.startswith("The natural frequency is 2.76e+03 Hz; 1 Hz to 2 kHz is usual. Check the units")


def test_a_stiffness_without_a_rated_torque_is_held_against_those_of_the_catalogue():
    text = EXPLICIT.format(**SOUND | {"K": "10 N*m/rad"}).replace("rated_torque: 137 N*m, ", "")
    found = from_text(text, Path("project.yaml")).notes
    assert found[0].startswith("The stiffness of the gear at zero torque is 10 N*m/rad; catalogue gears have 340 to")


def test_a_mean_torque_beyond_the_gears_ratcheting_torque_is_said():
    text = "gear: CSG-40-50\n" + EXPLICIT.format(**SOUND | {"mean": "-2400 N*m"}).split("\n", 1)[1]
    note, loss = from_text(text, Path("project.yaml")).notes
    assert "hysteresis loss of up to 60 arcsec. The results neglect the hysteresis" in loss
    assert "reaches 2400 N*m, above the ratcheting torque of 2300 N*m: the teeth skip, and no computed" in note


def sound(seed):
    """A gear of the catalogue, a load that fits its motor and gives a usual frequency, driven within its limits."""
    rng = random.Random(seed)
    gear = sw.catalogue.gear(rng.choice(GEARS))
    J_m = gear.input_inertia * rng.uniform(1.2, 5.0)
    frequency = math.exp(rng.uniform(math.log(6.0), math.log(45.0)))
    J_l = gear.K1 / (2.0 * math.pi * frequency) ** 2
    J_l = min(max(J_l, 0.1 * gear.ratio**2 * J_m), 10.0 * gear.ratio**2 * J_m)
    top = rng.uniform(0.3, 1.0) * (gear.max_rpm or 4000.0)
    rated = gear.rated_torque or 0.05 * gear.K1 * 1e-2
    mode = rng.choice(
        ["mode: held", "loop: {bandwidth: 20 Hz, damping: 0.7}", "drag: {type: viscous, B: 1e-5 N*m*s/rad}"]
    )
    amplitude = rng.uniform(5.0, 60.0)
    return (
        f"gear: {gear.name}\nmotor: {{inertia: {J_m} kg*m^2, {mode}}}\nload: {{inertia: {J_l} kg*m^2}}\n"
        f"damping: {{ratio: {rng.uniform(0.005, 0.08)}}}\n"
        f"speed: {{from: {rng.uniform(0.05, 0.5) * top} rpm, to: {top} rpm, shaft: motor}}\n"
        f"excitation:\n  kinematic_error: [{{order: 2, amplitude: {amplitude} arcsec}}, "
        f"{{order: 4, amplitude: {0.3 * amplitude} arcsec}}]\n"
        f"  load_torque: {{mean: {-rng.uniform(0.0, 1.0) * rated} N*m}}\n"
    )


GEARS = [name for name in sw.catalogue.names() if sw.catalogue.gear(name).input_inertia and sw.catalogue.gear(name).K1]


def test_200_random_sound_drives_get_no_sentence():
    assert len(GEARS) > 100
    projects = {seed: from_text(sound(seed), Path("project.yaml")) for seed in range(200)}
    found = {seed: set(project.notes) - set(project.gear.notes) for seed, project in projects.items()}
    found = {seed: [said for said in some if "a hysteresis loss of" not in said] for seed, some in found.items()}
    assert {seed: said for seed, said in found.items() if said} == {}


@pytest.mark.parametrize(
    ("gear", "said"),
    [("SHG-40-120", "looks mistyped"), ("HFUS-58-80", "digit for digit"), ("CSG-14-50", "T1 = 0.2"), ("CSG-40-50", "")],
)
def test_what_the_catalogue_doubts_of_a_gear_is_a_note_of_its_project_once(gear, said):
    text = (
        f"gear: {gear}\nload: {{inertia: 1.3 kg*m^2}}\ndamping: {{ratio: 3 %}}\nlimit: {{oscillation: 9 deg}}\n"
        "speed: {from: 100 rpm, to: 2000 rpm, shaft: motor}\nexcitation: {accuracy: 1 arcmin}\n"
    )
    project = from_text(text, Path("project.yaml"))
    doubts = [note for note in project.notes if note.startswith(f"{gear}: ")]
    assert all("mass" not in note for note in doubts)
    assert any(said in note for note in doubts) if said else not doubts
    beyond = [finding.sentence.replace("N*m", "N·m") for finding in project.judged(project.response()).findings]
    for note in doubts:
        assert sum(note in sentence.replace("N·m", "N*m") for sentence in [*beyond, *unsaid(doubts, beyond)]) >= 1
        assert unsaid([note], [f"First. {note.replace('N*m', 'N·m')}"]) == []


@pytest.mark.parametrize(("ratio", "teeth"), [(100.5, False), (100, True), (101, True), (1.02, True), (1.03, False)])
def test_a_ratio_that_no_teeth_give_is_said(ratio, teeth):
    text = EXPLICIT.format(**SOUND).replace("ratio: 50", f"ratio: {ratio}")
    said = [note for note in from_text(text, Path("project.yaml")).notes if note.startswith("gear.ratio: ")]
    assert len(said) == (not teeth)
    assert all(f"{ratio} is no ratio of a strain wave gear alone" in note for note in said)
