"""Columns of logs of several joints: stamps in two parts, names of ROS, the columns of one joint."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np

from ...base.quantities import shown
from .names import canonical, named, suffixed
from .table import Column, refuse

SECONDS = re.compile(r"(.*?)_?(?:in)?_?(?:s|secs?|seconds?)", re.IGNORECASE)
NANOSECONDS = re.compile(r"(.*?)_?(?:in)?_?(?:ns|nsecs?|nano_?secs?|nano_?seconds?)", re.IGNORECASE)
KINDS = ("position", "velocity", "effort")  # arrays of a JointState of ROS, in its order


def joined_stamps(file: list[Column], notes: list[str]) -> list[Column]:
    """Columns with stamps in seconds and nanoseconds as one time, since the first second."""
    for i, seconds in enumerate(file):
        for j, part in enumerate(file):
            first, second = SECONDS.fullmatch(seconds.name), NANOSECONDS.fullmatch(part.name)
            inside = (part.values >= 0.0) & (part.values < 1e9)
            if i != j and first and second and first[1].lower() == second[1].lower() and np.all(inside):
                time = seconds.values - seconds.values[0] + 1e-9 * part.values
                notes.append(f"{seconds.name} and {part.name} are one time, since second {seconds.values[0]:.0f}")
                one, other = replace(seconds, values=time, unit="s"), replace(part, name="")
                if canonical(seconds.name) != "time":
                    one = replace(one, name="time")
                return [one if k == i else other if k == j else column for k, column in enumerate(file)]
    return file


def joints_named(file: list[Column]) -> list[Column]:
    """Columns of a JointState that ROS echoed as a table, named by joint and kind: "elbow/position"."""
    if not any(column.name for column in file):  # ros2 topic echo --csv: sec, nanosec, frame, names, arrays
        many = next((i for i, column in enumerate(file[3:]) if not column.text), 0)
        if not many or not len(file) > 3 + many or (len(file) - 3) % many or len(file) > 3 + 4 * many:
            return file
        heads, joints = ["sec", "nanosec", "frame"], [column.text for column in file[3 : 3 + many]]
        names = [*heads, *(f"name {j}" for j in joints), *(f"{joint}/{kind}" for kind in KINDS for joint in joints)]
        return [replace(column, name=name) for column, name in zip(file, names, strict=False)]
    joint = {column.name[10:]: column.text for column in file if column.name.startswith("field.name") and column.text}
    pattern = re.compile(rf"field\.({'|'.join(KINDS)})(\d+)")  # rostopic echo -p
    matches = [pattern.fullmatch(column.name) for column in file]
    return [
        replace(column, name=f"{joint[one[2]]}/{one[1]}") if one and one[2] in joint else column
        for column, one in zip(file, matches, strict=True)
    ]


def only_joint(file: list[Column]) -> str | None:
    """Number at the end of the names of both angles where one alone stands there, as in encoder_motorinc_1."""
    ends = [re.fullmatch(r"(.+)_(\d+)", column.name) for column in file]
    angles = [(suffixed(one[1]), one[2]) for one in ends if one and suffixed(one[1]) in ("motor_angle", "load_angle")]
    numbers = {number for _, number in angles}
    return numbers.pop() if len(numbers) == 1 and len({name for name, _ in angles}) == 2 else None


def of_joint(path: Path, file: list[Column], joint: str) -> list[Column]:
    """Columns with the name of one joint taken out of their names, and without those of others."""
    word = re.compile(rf"[/._\[\s]*(?<![A-Za-z0-9]){re.escape(joint)}(?![A-Za-z0-9])\]?")
    hits = [bool(word.search(column.name)) for column in file]
    if not joint or not any(hits):
        available = ", ".join(column.name for column in file if column.name)
        raise refuse(path, f"has no column of the joint {shown(joint)}; it has {available}: name a part of these")
    names = [word.sub("", c.name).strip("/._ ") if hit else c.name for hit, c in zip(hits, file, strict=True)]
    channels = [suffixed(named(name).name) or "time" for name in names]
    other = [not hit and channel != "time" for hit, channel in zip(hits, channels, strict=True)]
    return [replace(c, name="" if out else name) for c, name, out in zip(file, names, other, strict=True)]
