"""Sampled loops at the edge of stability: is every answer right about whether they are stable?

    python benchmarks/sampled_loops.py [COUNT]

Axes of two or three inertias with a cascade, lag, torque filter, encoder on motor or load and delays that are no whole
periods have gains with which the largest |eigenvalue| of the map from sample to sample, computed by hand
(tests/sampled_axis.py), is within 1e-3 of 1: half below, half above. Then drives well within: every phase and gain
margin against Nyquist curves by the sum of the aliases.
"""

import json
import sys
import tempfile
from pathlib import Path

import numpy as np
from click.testing import CliRunner

import strainwave as sw
from strainwave.app.commands.cli import cli as command
from strainwave.app.web.views import response as page
from strainwave.drive.loops.linear_control import control_parts
from strainwave.drive.loops.margins import loop_of
from strainwave.drive.loops.worst_margins import loaded_trains
from strainwave.drive.operating_point import mean_state
from strainwave.study.compensation.bench import bench_of
from strainwave.study.tuning.open_loop import OpenLoop

sys.path[:0] = [str(Path(__file__).resolve().parents[1] / "tests")]

from sampled_axis import edges, margins_by_hand, within  # noqa: E402

MOVE = "move: {profile: [{type: trapezoid, angle: 20 deg, time: 0.4 s}]}\n"
FACES = ("margins", "project", "response", "analyze", "speed-map", "move", "page", "tune")


def told(*words):
    """JSON of a command."""
    result = CliRunner().invoke(command, [*words, "--json"], catch_exceptions=False)
    return json.loads(result.stdout)


def faces(path, folder):
    """Whether each face says that the loop is stable and, where it is not, allows no speed."""
    project = sw.read_project(path)
    train, sampling = project.train, project.sampling
    analyzed = told("analyze", str(path), "-o", str(folder / "report"))["verdict"]
    mapped = told("speed-map", str(path))
    moved = told("move", str(path), "-o", str(folder / "move"))
    unstable = "loop is unstable"
    said = {
        "margins": sw.margins(train, speed=train.omega, sampling=sampling).stable,
        "project": project.loop.stable and not project.loop_fault,
        "response": not any(unstable in text for text in told("response", str(path))["failures"]),
        "analyze": unstable not in analyzed["headline"],
        "speed-map": not any(unstable in text for text in mapped["failures"]),
        "move": not any(unstable in text for text in moved["failures"]),
        "page": not any(unstable in text for text in page(project)["failures"]),
        "tune": bool(np.isfinite(
            OpenLoop(train, 0.0, sampling).figures(control_parts(train.motor.control), train.motor.control)[0]
        )),
    }  # fmt: skip
    allowed = analyzed["allowed_speeds"], mapped["allowed_under_every_load_rpm"]
    return said, allowed


def main():
    """Print what disagrees."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 24
    wrong, largest, sampled = 0, 0.0, 0.0
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        for i, axis in enumerate(edges(count)):
            own = np.max(np.abs(axis.eigenvalues()))
            path = folder / "axis.yaml"
            path.write_text(axis.text(MOVE), encoding="utf-8")
            said, allowed = faces(path, folder)
            off = [name for name in FACES if said[name] != (own < 1.0)]
            if own > 1.0 and any(allowed):
                off.append("allowed speeds")
            project = sw.read_project(path)
            one = next(iter(loaded_trains(project)))
            loop = loop_of(one.train, mean_state(one.train), one.train.omega, project.sampling)
            largest = max(largest, abs(np.max(np.abs(loop.poles)) - own))
            if axis.encoder == "motor" and axis.filter is None:
                poles = bench_of(project).response(100.0).poles
                by_hand = np.max(np.abs(axis.eigenvalues(speed_by_difference=True)))
                sampled = max(sampled, abs(np.max(np.abs(poles)) - by_hand))
            wrong += len(off)
            print(f"{i + 1:2}: largest |eigenvalue| {own:.6f}, wrong: {', '.join(off) or 'none'}", flush=True)
        phase, gain, n = 0.0, 0.0, 0
        for axis in within(12):
            path = folder / "axis.yaml"
            path.write_text(axis.text(), encoding="utf-8")
            found = sw.read_project(path).loop.margins[0]
            phases, factors = margins_by_hand(axis)
            n += len(phases) + len(factors)
            phase = max(phase, float(np.max(np.abs(np.degrees(found.phase_margins) - phases))))
            gain = max(gain, float(np.max(np.abs(found.gain_margins / factors - 1.0), initial=0.0)))
    print(
        f"{count} loops at the edge, {len(FACES)} faces each: {wrong} wrong; largest |eigenvalue| off by {largest:.1e},"
    )
    print(f"that of compensate, whose speed is a difference of angles, by {sampled:.1e}")
    print(f"{n} margins of 12 drives: phase off by at most {phase:.1e} degrees, gain by {gain:.1e}")


if __name__ == "__main__":
    main()
