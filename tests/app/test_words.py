"""Limits that a run passes are the first warnings of the report, each with the speed where it happens."""

import math
from types import SimpleNamespace

import strainwave as sw
from strainwave.app import words
from strainwave.app.words import warnings
from strainwave.study.usage import Usage, limit_findings

RPM = math.pi / 30.0


def test_what_the_run_asks_beyond_the_datasheet_is_said_first():
    gear = sw.catalogue.gear("CSG-40-50")
    used = Usage(peak_torque=600.0, at_peak=2400 * RPM, average_torque=300.0, at_average=2350 * RPM)
    limits = limit_findings(gear, used, 4500 * RPM)
    drive = gear.drive(load_inertia=1.3, B=20.0)
    project = SimpleNamespace(gear=gear, drive=drive, notes=("a doubt",), shaft="motor")
    analysis = SimpleNamespace(usage=used, limits=limits, warnings=("a warning",), exact=SimpleNamespace(sweep=None))
    said = warnings(project, analysis)
    assert [sentence.split(",")[0] for sentence in said[:3]] == [
        "At 2400 rpm at the motor: The torque in the gear reaches 600 N·m",
        "The input speed reaches 4500 rpm",
        "At 2350 rpm at the motor: The cubic mean of the torque in the gear is 300 N·m",
    ]
    assert said[3:] == ["a warning", "a doubt"]


def test_jumps_are_told_with_the_resonance_next_to_them_alone():
    exact = {"jump_up": {"omega_rad_per_s": 154.0, "motor_speed_rpm": 1470.8}, "jump_down": None}
    row = {"name": "primary", "order": 2, "omega_rad_per_s": 138.7, "motor_speed_rpm": 1324.2, "peak": None}
    results = {"exact_response": exact}
    assert words._resonance_lines(results, row, True)[1] == "    jumps up at 1470.8 rpm at the motor"
    assert len(words._resonance_lines(results, row, False)) == 1
