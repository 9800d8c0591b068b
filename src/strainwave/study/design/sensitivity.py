"""How the largest oscillation answers to the numbers of a drive, by averaging."""

from collections.abc import Callable

from .averaged import Drives, largest
from .result import Sensitivity

STEP = 0.01


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
