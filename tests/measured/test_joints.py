"""Measured joints of robots have the lines that docs/logs.md says."""

import gzip
import re
from pathlib import Path

import numpy as np
import pytest
from printed import same, says

import strainwave as sw

MEASURED = Path(__file__).parent
PAGE = (Path(__file__).resolve().parents[2] / "docs" / "logs.md").read_text(encoding="utf-8")
ARCSEC = np.pi / 648_000


def steady(joint):
    log = sw.read_log(MEASURED / "kinova_gen3" / f"joint_{joint}.csv")
    return log, next(part for part in log.segments() if part.kind == "constant speed")


@pytest.mark.slow
def test_torques_of_three_joints_have_three_orders_in_common():
    ends = {}
    for joint in (5, 6, 7):
        log, part = steady(joint)
        for line in sw.order_scan([log.run("torque_from_current", part=part)]).lines:
            low, high = line.interval("order")
            for order in (200, 400, 700):
                if low <= order <= high:
                    ends.setdefault(order, []).extend(1e3 * end for end in line.interval())
    assert {order: len(found) for order, found in ends.items()} == {200: 6, 400: 6, 700: 6}
    first, second, third = (f"{min(ends[order]):.0f} to {max(ends[order]):.0f}" for order in (200, 400, 700))
    assert says(" ".join(PAGE.split()), f"{first}, {second} and {third}")


@pytest.mark.slow
def test_lines_of_a_velocity_stay_with_the_time():
    runs = [log.run("load_speed", part=part) for log, part in map(steady, (3, 4, 5, 6, 7))]
    kept = [f"{line.frequency:.2f}" for line in sw.order_scan(runs, highest=400).lines if line.kind == "frequency"]
    assert len(kept) == 3
    assert says(" ".join(PAGE.split()), f"{kept[0]}, {kept[1]} and {kept[2]} Hz")


@pytest.mark.slow
@pytest.mark.parametrize(("joint", "motion"), [(1, "linear_move"), (2, "jog"), (6, "linear_move")])
def test_ratios_and_transmission_errors_of_a_cobot_are_those_of_the_table(joint, motion):
    with gzip.open(MEASURED / "lara8" / f"joint{joint}_{motion}_with_mass.csv.gz", "rt") as file:
        table = np.genfromtxt(file, delimiter=",", names=True)
    time, (motor, load) = table["Timestamp"], (table[f"encoder_{end}inc_{joint}"] for end in ("motor", "load"))
    gear = sw.fit.arrangement(motor, load, per_turn=2**24)
    assert str(gear.arrangement) == "flexspline fixed, circular spline at the output"
    angle, output = 2 * np.pi / 2**24 * motor, 2 * np.pi / 2**24 * load
    speed = np.abs(np.convolve(np.gradient(angle, time), np.ones(25) / 25, "same"))
    even = np.abs(speed / np.quantile(speed, 0.8) - 1) < 0.08
    edges = np.flatnonzero(np.diff(np.concatenate([[False], even, [False]])))
    part = slice(*max(edges.reshape(-1, 2), key=np.ptp))
    run = sw.Run(time[part], angle[part], (output - angle / gear.ratio)[part], unit="rad")
    scan = sw.order_scan([run], ratio=gear.ratio, highest=8)
    assert {line.pair for line in scan.lines} == {None}
    row = [f"{joint}", f"{gear.measured:.2f} ± {gear.error:.2f}", f"{gear.ratio}", f"{run.turns:.1f}"]
    for order in (2, 4, 6):
        found = [line.interval() for line in scan.lines if line.order == order]
        row.append(" to ".join(f"{end / ARCSEC:.1f}" for end in found[0]) if found else "")
    line = re.search(rf"^\| {joint} \|.*$", PAGE, re.MULTILINE).group()
    assert same(f"| {' | '.join(row)} |", line.replace("| |", "|  |"))
