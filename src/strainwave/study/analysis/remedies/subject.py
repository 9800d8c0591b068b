"""The drive whose remedies are looked for: what is followed, and how another drive is made of it."""

from typing import Any, NamedTuple

from ....base.law import depends
from ....base.protocols import terms_of
from ....drive.project import Project
from ....drive.train_curve import largest_oscillation
from ....model.drive import Drive
from ....model.train.drive_train import DriveTrain


class Subject(NamedTuple):
    """A drive: its error equation, the whole train where that is followed, and the range of speeds [rad/s].

    `project` is None where the equation is all that is known, `load_torque` [N*m] the constant torque of the load where
    the drive has a range of them.
    """

    system: Any
    train: DriveTrain | None
    speeds: tuple[float, float]
    project: Project | None = None
    load_torque: float | None = None

    @property
    def whole(self) -> Any:
        """The model that is followed: the train, else the error equation."""
        return self.system if self.train is None else self.train

    def having(self, whole: Any) -> "Subject":
        """The same with another model in place of the one that is followed."""
        return self._replace(system=whole) if self.train is None else self._replace(train=whole)

    def of_drive(self, drive: Drive) -> "Subject":
        """The same with the error equation of another drive."""
        if self.project is None:
            return self
        return self._replace(system=self.project.equation_of(drive, self.load_torque))

    @property
    def has_memory(self) -> bool:
        """Whether the law of the gear or of a coupling has friction or memory."""
        couplings = () if self.train is None else self.train.load.couplings()
        return any(depends(law) > 1 for law in (self.whole.law, *couplings))

    @property
    def load_torques(self) -> tuple[Any, ...]:
        """Terms of the torque on the load, of an error equation of its excitation."""
        excitation = self.system.excitation if self.train is None else self.train.load.end().excitation
        return terms_of(excitation)

    def largest(self, harmonics: int, coexisting: bool) -> tuple[float, float] | None:
        """Speed [rad/s] and size [rad] of its largest |error - mean|, as `largest_oscillation`."""
        return largest_oscillation(self.whole, self.speeds, harmonics, coexisting)
