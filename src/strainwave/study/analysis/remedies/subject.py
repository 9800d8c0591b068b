"""The drive whose remedies are looked for: what is followed, and how another drive is made of it."""

from collections.abc import Callable
from typing import Any, NamedTuple

from ....law import depends
from ....model.drive import Drive
from ....model.gears.gear import Gear
from ....model.train.drive_train import DriveTrain
from ....protocols import terms_of


class Source(NamedTuple):
    """What an error equation is made of.

    Attributes
    ----------
    drive : Drive
        Inertias, ratio, damping and law.
    free : bool
        Whether its motor follows a torque alone.
    by_motor : bool
        Whether the base angle is the motor's, so that its speeds follow the ratio.
    equation : callable
        Error equation of another drive under a constant torque [N*m] of the load, None for its own.
    gear : Gear or None
        Record of its gear.
    """

    drive: Drive
    free: bool
    by_motor: bool
    equation: Callable[[Drive, float | None], Any]
    gear: Gear | None = None


class Subject(NamedTuple):
    """A drive: its error equation, the whole train where that is followed, and the range of speeds [rad/s].

    `source` is None where the equation is all that is known, `load_torque` [N*m] the constant torque of the load where
    the drive has a range of them.
    """

    system: Any
    train: DriveTrain | None
    speeds: tuple[float, float]
    source: Source | None = None
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
        if self.source is None:
            return self
        return self._replace(system=self.source.equation(drive, self.load_torque))

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
