"""The drive whose remedies are looked for: what is followed, and how another drive is made of it.

The largest oscillation of a drive in a range of speeds, in a fraction of the time of its response curve.
"""

from typing import Any, NamedTuple

import numpy as np

from ....base.law import depends, is_spring
from ....base.protocols import terms_of
from ....base.results import Floats
from ....compile.tree import leaf_of
from ....drive.project import Project
from ....drive.train_curve import largest_on_turns, largest_oscillation
from ....model.drive import Drive
from ....model.train.drive_train import DriveTrain
from ....numerics.balance.choice import balance_of
from ....numerics.balance.truncation import MATTERS
from ....numerics.continuation.passage import Coexisting
from ....numerics.curves.response import traced
from ....numerics.stability.second_order import displacement_peaks

POINTS = 12  # of a curve by harmonic balance, and more where it bends

Top = tuple[float, float]


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


def largest(subject: Subject, harmonics: int, coexisting: bool) -> Top | None:
    """Speed [rad/s] and size [rad] of the largest |error - mean| in the speeds of a drive; None where none is found.

    Parameters
    ----------
    subject : Subject
        The drive.
    harmonics : int
        Of the base angle.
    coexisting : bool
        Whether motions that do not join the curve from the ends of the range are looked for.
    """
    if subject.train is not None:
        return largest_oscillation(subject.train, subject.speeds, harmonics, coexisting)
    if not is_spring(subject.system):
        return largest_on_turns(subject.system, subject.speeds, harmonics, coexisting)
    return _balanced(subject.system, subject.speeds, harmonics, coexisting)


def _balanced(system: Any, speeds: tuple[float, float], harmonics: int, coexisting: bool) -> Top | None:
    leaf = leaf_of(system, "omega")
    middle = system._replace(omega=(speeds[0] * speeds[1]) ** 0.5)
    problem, found, _, _ = traced(
        lambda h: balance_of(middle, leaf, leaf, h), *speeds, (harmonics, harmonics), MATTERS, POINTS,
        Coexisting() if coexisting else None,
    )  # fmt: skip
    if not len(found.points):
        return None
    series = problem.displacements(found.points)
    series[:, 0] = 0.0
    return crest(found.points[:, -1], displacement_peaks(series), speeds)


def crest(omega: Floats, sizes: Floats, speeds: tuple[float, float]) -> Top:
    """The highest place of a curve within a range, by the parabola through its highest point and those beside it."""
    inside = (omega >= speeds[0] * (1.0 - 1e-9)) & (omega <= speeds[1] * (1.0 + 1e-9))
    i = int(np.argmax(np.where(inside, sizes, -np.inf)))
    best = float(omega[i]), float(sizes[i])
    if not 0 < i < len(omega) - 1 or not inside[i - 1 : i + 2].all() or not best[1] > 0.0:
        return best
    w, a = omega[i - 1 : i + 2] / best[0], sizes[i - 1 : i + 2] / best[1]
    s = np.cumsum([0.0, *np.hypot(np.diff(w), np.diff(a))])
    if not np.all(np.diff(s) > 0.0):
        return best
    parabola, where = np.polyfit(s, a, 2), np.polyfit(s, w, 2)
    if not parabola[0] < 0.0:
        return best
    top = float(np.clip(-0.5 * parabola[1] / parabola[0], s[0], s[2]))
    return best[0] * float(np.polyval(where, top)), best[1] * float(np.polyval(parabola, top))
