"""Speeds of a drive: a range or single ones, of the base angle, with the shaft that they are given for."""

from dataclasses import dataclass
from math import inf
from typing import Literal

from ..base.number_text import number
from ..base.units import RPM

BEYOND = 0.2  # share of single speeds by which a curve goes beyond them


@dataclass(frozen=True)
class Speeds:
    """A range of speeds, or single ones, and their shaft.

    Attributes
    ----------
    limits : (float, float)
        Range of the speed of the base angle [rad/s]; of single speeds a fifth beyond them.
    single : tuple of float
        Single speeds of the base angle [rad/s], ascending; empty where a range is given.
    shaft : {"motor", "load", "forcing"}
        The shaft that the speeds were given for; with "forcing" the base angle is the forcing phase itself, else the
        motor's (wave-generator) angle.
    ratio : float
        Turns of the base angle in one turn of that shaft.
    """

    limits: tuple[float, float]
    single: tuple[float, ...] = ()
    shaft: Literal["motor", "load", "forcing"] = "motor"
    ratio: float = 1.0

    @classmethod
    def at(cls, single: tuple[float, ...], shaft: Literal["motor", "load", "forcing"], ratio: float) -> "Speeds":
        """Single speeds [rad/s], ascending."""
        return cls(((1.0 - BEYOND) * single[0], (1.0 + BEYOND) * single[-1]), single, shaft, ratio)

    @property
    def given(self) -> tuple[float, ...]:
        """Speeds [rad/s] as given: the ends of the range, or the single ones."""
        return self.single or self.limits

    @property
    def middle(self) -> float:
        """Middle of the given speeds [rad/s]."""
        return 0.5 * (self.given[0] + self.given[-1])

    @property
    def by_motor(self) -> bool:
        """True if the base angle is that of the motor."""
        return self.shaft != "forcing"

    @property
    def base_angle(self) -> str:
        """Base angle in words."""
        return "motor (wave-generator) angle" if self.by_motor else "forcing phase"

    @property
    def name(self) -> str:
        """Name of the speed of the base angle."""
        return "motor speed" if self.by_motor else "forcing frequency ω"

    @property
    def unit(self) -> str:
        """Unit in which speeds of the base angle are shown: rpm of the motor, or rad/s."""
        return "rpm" if self.by_motor else "rad/s"

    @property
    def base(self) -> str:
        """The shaft of the base angle, one of `BASES`."""
        return "motor" if self.by_motor else "forcing"

    @property
    def scale(self) -> float:
        """Factor from rad/s to that unit."""
        return 1.0 / RPM if self.by_motor else 1.0

    def said(self, omega: float, digits: int = 4) -> str:
        """A speed of the base angle [rad/s] with its unit: rpm, or rad/s of a forcing."""
        return f"{number(omega * self.scale, digits)} {self.unit}"

    def rpm(self, omega: float) -> float | None:
        """Speed of the motor [rpm] at a base-angle speed [rad/s]; None where the base angle is a forcing phase."""
        return omega / RPM if self.by_motor else None

    def own(self, omega: float) -> float:
        """Speed of the given shaft at a base-angle speed [rad/s]: in rpm, or in rad/s of the forcing phase."""
        return omega / self.ratio / RPM if self.by_motor else omega

    @property
    def own_unit(self) -> str:
        """Unit of `own`, with the shaft."""
        return f"rpm at the {self.shaft}" if self.by_motor else "rad/s of the forcing phase"


BASES = {"motor": Speeds((0.0, inf)), "forcing": Speeds((0.0, inf), (), "forcing")}  # by the shaft of the base angle
