"""What a closed form is worth, by the certificate of its slow flow, and the same design by harmonic balance.

How the largest oscillation answers to the numbers of a drive, by averaging.
"""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

from ...base.results import SolveError
from ...drive.train_curve import POINTS, crest_in
from ...model.excitation import Harmonic
from ...model.oscillator import Oscillator
from ...model.train.drive_train import DriveTrain
from ...model.train.train_forms import AtLoad
from ...numerics.curves.over_a_turn import traced_turn
from ...theory.slow_flow.flow import slow_flow
from ...theory.slow_flow.setting import Resonance
from .averaged import Drives, Largest, largest
from .result import Sensitivity

STEP = 0.01

UNKNOWN = math.inf


class Worth(NamedTuple):
    """Relative error of a closed form."""

    size: float


def worth(drives: Drives, found: Largest, at: int) -> Worth:
    """Relative error of averaging by the certificate of the first-order slow flow, at one drive's largest oscillation.

    Near k omega the drive is one oscillator with its own mass and damping. The certificate is about the component at
    k omega and counts with its share of the oscillation, at most all. Of a motor in a loop the closed form also leaves
    out what the changing ratio does to the motor: N e' of its speed, which is added.
    """
    mass, order = float(found.mass[at]), int(found.order[at])
    slope = sum(line.order * line.amplitude for line in drives.error.lines)
    ripple = 0.0 if drives.loop is None else drives.N * slope
    if not mass > 0.0:
        return Worth(UNKNOWN)
    near = Oscillator(
        mass, float(found.damping[at]), drives.law, Harmonic(0.0, mean=drives.torque), float(found.omega[at]),
        drives.error,
    )  # fmt: skip
    try:
        seen = slow_flow(near, Resonance(order, 1)).certificate()
    except (SolveError, ValueError):
        return Worth(UNKNOWN)
    share = min(1.0, float(found.amplitude[at] / found.oscillation[at]))
    size = max(seen.amplitude, seen.waveform) * share
    return Worth(size + ripple if math.isfinite(size) else UNKNOWN)


class Balanced(NamedTuple):
    """Largest oscillation [rad] by harmonic balance, the motor's speed [rad/s] there, and its relative error."""

    oscillation: float
    omega: float
    error: float


def balanced(train: DriveTrain, speeds: tuple[float, float]) -> Balanced | None:
    """Largest oscillation of a whole drive train over a range of motor speeds [rad/s]; None where none is found."""
    system: Any = AtLoad(train, train.omega)
    problem, found, tail, _ = traced_turn(system, speeds, POINTS)
    if not len(found.points) or tail is None:
        return None
    at, size = crest_in(problem, found, speeds)
    return Balanced(size, at, float(tail.share))


def _stiffer(drives: Drives, by: float) -> Drives:
    law = drives.law
    return drives._replace(law=law._replace(**{k: by * getattr(law, k) for k in ("K1", "K2", "K3", "T1", "T2")}))


def _of_error(drives: Drives, by: float) -> Drives:
    lines = tuple(line._replace(amplitude=by * line.amplitude) for line in drives.error.lines)
    return drives._replace(error=drives.error._replace(lines=lines))


CHANGES: dict[str, Callable[[Drives, float], Drives]] = {
    "stiffness of the gear": _stiffer,
    "damping of the gear": lambda d, by: d._replace(B=by * d.B),
    "inertia of the load": lambda d, by: d._replace(J_l=by * d.J_l),
    "inertia of the motor": lambda d, by: d._replace(J_m=by * d.J_m),
    "kinematic error": _of_error,
    "mean torque": lambda d, by: d._replace(torque=by * d.torque),
}


def sensitivities(designs: list[tuple[str, float, Drives]]) -> tuple[Sensitivity, ...]:
    """Slopes of designs: name of the gear, inertia of the motor, and the drive; damping and loop stay as they are."""
    found = []
    for gear, motor, drives in designs:
        here = float(largest(drives).oscillation[0])
        for name, changed in CHANGES.items():
            up, down = (float(largest(changed(drives, 1.0 + s)).oscillation[0]) for s in (STEP, -STEP))
            found.append(Sensitivity(gear, motor, name, (up - down) / (2.0 * STEP * here)))
    return tuple(found)
