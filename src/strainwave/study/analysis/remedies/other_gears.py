"""Other gears of the catalogue in a drive: the next size of the same series, and the next ratios of the same size.

The drive keeps its load, the damping ratio of its gear, the lines of its kinematic error (those of an accuracy class
follow the record), the gains of its loop, and its speeds at the load: the motor turns as much faster as
the ratio is larger.
"""

from collections.abc import Iterator
from functools import partial
from math import sqrt
from typing import Any

from ....model.drive import Drive
from ....model.gears import catalogue
from ....model.gears.error_spectrum import accuracy_spectrum
from ....model.gears.gear import Gear
from ....model.train.drive_train import DriveTrain
from ....protocols import lines_of
from ....tree import made
from .knobs import Knob
from .subject import Source, Subject


def other_gears(subject: Subject) -> Iterator[Knob]:
    """The neighbours of a drive's gear in the catalogue, each as one change."""
    source = subject.source
    if source is None or source.gear is None:
        return
    for what, gear in neighbours(source.gear):
        yield Knob(what, 0.0, gear.name, partial(_in_place, subject, source, gear), (1.0,), (0.0,))


def _in_place(subject: Subject, source: Source, gear: Gear, _: float) -> Subject | str:
    return with_gear(subject, source, gear)


def neighbours(gear: Gear) -> list[tuple[str, Gear]]:
    """Next size of the same ratio, next larger and next smaller ratio of the same size, where there are any."""
    known = [g for g in catalogue.select(series=gear.series) if None not in (g.size, g.K1, g.K2, g.K3, g.T1, g.T2)]
    if gear not in known:
        return []
    here = _place(gear)
    bigger = [g for g in known if g.ratio == gear.ratio and _place(g) > here]
    same = [g for g in known if g.size == gear.size]
    more, less = [g for g in same if g.ratio > gear.ratio], [g for g in same if g.ratio < gear.ratio]
    found = [
        ("next size of the gear", min(bigger, key=_place, default=None)),
        ("next larger ratio of the gear", min(more, key=_place, default=None)),
        ("next smaller ratio of the gear", max(less, key=_place, default=None)),
    ]
    return [(what, other) for what, other in found if other is not None]


def _place(gear: Gear) -> tuple[int, int]:
    """Size and ratio: the place of a gear in its series."""
    return gear.size or 0, gear.ratio


def with_gear(subject: Subject, source: Source, gear: Gear) -> Subject | str:
    """The drive with another gear of the catalogue, or why it cannot have it."""
    drive, old = source.drive, source.gear
    assert old is not None
    faster = gear.ratio / drive.N if source.by_motor else 1.0
    low, high = (faster * speed for speed in subject.speeds)
    if not _holds(drive.law, old.law):
        return "the drive has another law than the catalogue's"
    if source.by_motor and gear.max_speed is not None and high > gear.max_speed:
        return f"its input may turn at {gear.max_rpm:g} rpm at most"
    J_m = drive.J_m
    if gear.input_inertia is not None and old.input_inertia is not None:
        J_m += gear.input_inertia - old.input_inertia
    if not J_m > 0.0:
        return "the motor's inertia is less than that of its gear's wave generator"
    other = drive._replace(J_m=J_m, N=float(gear.ratio), law=swapped(drive.law, old.law, gear.law))
    inertia, before = (other.J, drive.J) if source.free else (other.J_l, drive.J_l)
    other = other._replace(B=drive.B * sqrt(gear.law.K1 / old.law.K1 * inertia / before))
    changed = subject.of_drive(other)._replace(speeds=(low, high))
    if subject.train is not None:
        changed = changed._replace(train=_train_with(subject.train, other))
    error = _error_of(subject.whole.error, old, gear)
    return changed.having(changed.whole._replace(error=error))


def _train_with(train: DriveTrain, drive: Drive) -> DriveTrain:
    """The train with the gear of another drive, its loop with the gains that it has."""
    return train._replace(motor=train.motor._replace(J=drive.J_m), N=drive.N, B=drive.B, law=drive.law)


def _holds(law: Any, part: Any) -> bool:
    """Whether a law is another one, or made of it."""
    if type(law) is type(part) and law == part:
        return True
    return isinstance(law, tuple) and any(_holds(item, part) for item in law)


def swapped(law: Any, old: Any, new: Any) -> Any:
    """A law with another one in the place of one of its parts."""
    if type(law) is type(old) and law == old:
        return new
    return made(law, [swapped(part, old, new) for part in law]) if isinstance(law, tuple) else law


def _error_of(error: Any, old: Gear, gear: Gear) -> Any:
    """The same kinematic error, or that of the new gear's accuracy class where it was that of the old one's."""
    if old.accuracy is None or gear.accuracy is None:
        return error
    of_class = lines_of(error) == accuracy_spectrum(old.accuracy).lines
    return accuracy_spectrum(gear.accuracy) if of_class else error
