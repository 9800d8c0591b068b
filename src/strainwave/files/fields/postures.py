"""Group `postures` of a project file: rows, a CSV file with them, or the links and angles of an arm."""

from collections.abc import Iterator
from dataclasses import dataclass
from math import degrees
from pathlib import Path
from typing import Any

from ...drive.postures import Link, Posture, two_link
from .csv_files import read_postures
from .kinds import FILE_NAME, Entry, Items, Kind, NotOfKind, Quantity, Row, Schema, Text, Whole, Wrong
from .rows import Fields, Group, Points, field, needed

MOST_POSTURES = 1000
MASS, LENGTH = Quantity("kg", "positive"), Quantity("m", "positive")
EXAMPLE_POSTURES = "[{inertia: 2 kg*m^2, torque: -40 N*m}, {inertia: 5 kg*m^2, torque: -110 N*m}]"
EXAMPLE_LINKS = "[{mass: 12 kg, length: 0.5 m}, {mass: 6 kg, length: 0.4 m}]"


class PostureSpec(Group):
    """Load of the drive in a posture."""

    name: str = field(Text(), "stretched", "Name of the posture.", "")
    inertia: float = needed(Quantity("kg*m**2", "positive"), "2 kg*m^2",
        "Inertia of the load behind all couplings, on the output side.")  # fmt: skip
    torque: float | None = field(Quantity("N*m"), "-40 N*m",
        "Gravity torque on the load; a resisting torque is negative. Default: that of the excitation.")  # fmt: skip
    coupling: float | None = field(Quantity("N*m/rad", "positive"), "2e5 N*m/rad",
        "Stiffness K of the coupling next to the gear. Default: that of the load.")  # fmt: skip

    def posture(self) -> Posture:
        """The posture as an object of the drive."""
        return Posture(self.inertia, self.torque, self.coupling, self.name)


class LinkSpec(Group):
    """A link of an arm."""

    mass: float = needed(MASS, "12 kg", "Mass.")
    length: float = needed(LENGTH, "0.5 m", "Distance from joint to joint, or to the payload.")
    centre: float | None = field(LENGTH, "0.2 m", "Distance of the centre of mass from the joint. Default: half.")
    inertia: float | None = field(Quantity("kg*m**2", "not negative"), "0.3 kg*m^2",
        "Inertia about the centre of mass. Default: that of a uniform rod.")  # fmt: skip

    def link(self) -> Link:
        """The link as an object of the drive."""
        given = {name: getattr(self, name) for name in ("centre", "inertia") if getattr(self, name) is not None}
        return Link.rod(self.mass, self.length)._replace(**given)


class TwoLinkSpec(Group):
    """Arm of two links in a vertical plane, of which the drive turns one joint and the other is held."""

    links: tuple[LinkSpec, ...] = needed(Items(Fields(LinkSpec), 2, 2), EXAMPLE_LINKS, "Links, starting at the base.")
    joint: int = field(Whole(1, 2, "write 1 or 2", "is not a joint of two links; write 1 or 2"), "1",
        "Number of the joint that the drive turns.", 1)  # fmt: skip
    payload: float = field(Quantity("kg", "not negative"), "3 kg", "Point mass at the end of the second link.", 0.0)
    angles: Any = needed(Points(("rad", "rad"), "angles; write [0 deg, 90 deg]"), "[[0 deg, 0 deg], [0 deg, 90 deg]]",
        "Angles of the first link above the horizontal, and of the second relative to it, by posture.")  # fmt: skip

    def check(self) -> Iterator[Wrong]:
        """Refuse an arm without postures."""
        if not self.angles:
            yield Wrong(("angles",), "is empty; write for example 'angles: [[0 deg, 0 deg], [0 deg, 90 deg]]'")

    def postures(self) -> tuple[Posture, ...]:
        """Rows of the arm, named by their angles."""
        first, second = [link.link() for link in self.links]
        rows = two_link(first, second, self.angles, joint=self.joint, payload=self.payload)
        names = [f"{degrees(a):.6g} and {degrees(b):.6g} deg" for a, b in self.angles]
        return tuple(row._replace(name=name) for row, name in zip(rows, names, strict=True))


@dataclass(frozen=True)
class PosturesKind(Kind):
    """Rows, the name of a file with them, or an arm."""

    rows = Items(Fields(PostureSpec), 1, MOST_POSTURES)
    arm = Fields(TwoLinkSpec)

    def read(self, value: object, entry: Entry) -> Any:
        if not isinstance(value, str | list | dict):
            raise NotOfKind("a list, a group of fields or the name of a file")
        return self._form(value).read(value, entry)

    def _form(self, value: object) -> Any:
        return FILE_NAME if isinstance(value, str) else self.rows if isinstance(value, list) else self.arm

    def schema(self) -> Schema:
        return {"anyOf": [form.schema() for form in (self.rows, FILE_NAME, self.arm)]}

    def text(self, value: Any) -> str:
        return self.rows.text(value)

    def part(self, value: object, key: str) -> Row | None:
        return None if isinstance(value, str) else self._form(value).part(value, key)


def postures_of(value: Any, folder: Path) -> tuple[Posture, ...]:
    """Postures of what the field holds, a file read from a folder (FileError)."""
    if isinstance(value, str):
        return read_postures(folder / value)
    if isinstance(value, TwoLinkSpec):
        return value.postures()
    return tuple(row.posture() for row in value or ())
