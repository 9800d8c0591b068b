"""The same drive with other motors, where nothing says which it has: ideally held, free, and in a position loop."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from ...law import depends
from ...model.train.drive_train import DriveTrain
from .avoid import Speeds
from .drive_response import DriveResponse
from .train_curve import train_curve


@dataclass(frozen=True, eq=False)
class MotorCase:
    """The steady motions of a drive with one motor.

    Attributes
    ----------
    name : str
        What drives it, in words.
    drive : DriveResponse or None
        Its motions; None where no curve of them is found.
    """

    name: str
    drive: DriveResponse | None

    @property
    def oscillation(self) -> float:
        """Largest |error - mean| [rad] that a slow run-up or run-down meets; nan without a curve."""
        return float("nan") if self.drive is None else float(self.drive.oscillation[self._at(self.drive)])

    @property
    def omega(self) -> float:
        """Speed [rad/s] of it; nan without a curve."""
        return float("nan") if self.drive is None else float(self.drive.omega[self._at(self.drive)])

    @property
    def jumps(self) -> int:
        """Number of speeds at which a slow run-up or run-down jumps."""
        sweep = None if self.drive is None else self.drive.response.sweep
        return 0 if sweep is None else len({jump.value for jump in (*sweep.on_run_up, *sweep.on_run_down)})

    @staticmethod
    def _at(drive: DriveResponse) -> int:
        visited = drive.visited()
        return int(visited[np.argmax(drive.oscillation[visited])])


def motor_cases(
    trains: Mapping[str, DriveTrain], speeds: Speeds, progress: Callable[[str], None]
) -> tuple[MotorCase, ...]:  # fmt: skip
    """Follow the motions of a train with every motor through a range of motor speeds [rad/s], told before each."""
    found = []
    for name, train in trains.items():
        progress(name)
        found.append(MotorCase(name, train_curve(train, speeds, coexisting=depends(train.law) == 1)))
    return tuple(found)


def spread(cases: tuple[MotorCase, ...]) -> float:
    """Largest oscillation over the smallest; nan where fewer than two motors have a curve."""
    sizes = [case.oscillation for case in cases if case.drive is not None]
    return max(sizes) / min(sizes) if len(sizes) > 1 and min(sizes) > 0.0 else float("nan")
