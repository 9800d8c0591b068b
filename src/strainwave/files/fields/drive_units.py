"""Sizes of a drive's own parameters, so that gains can be written as the drive has them."""

from typing import Any

from ...drive.sources import DriveUnit
from .kinds import Quantity
from .rows import Group, field, no_frequency

UNITS = {"K_v": "1/s", "K_p": "N*m*s/rad", "K_i": "N*m/rad", "T_n": "s", "T_p": "s"}


def _one(gain: str, size: str, what: str) -> Any:
    """Row of a gain: its size for 1 of the drive's parameter."""
    unit, check = UNITS[gain], no_frequency if gain == "K_v" else None
    meaning = f"{what} equal to 1 unit of the drive's parameter."
    return field(Quantity(unit, "positive", check=check), f"{size} {unit}", meaning)


class DriveUnitsSpec(Group):
    """Size of 1 of each of the drive's own parameters; `tune` writes its gains in them."""

    K_v: float | None = _one("K_v", "0.1", "Gain of the position loop")
    K_p: float | None = _one("K_p", "3e-4", "Gain of the speed loop")
    K_i: float | None = _one("K_i", "0.01", "Integral gain of the speed loop")
    T_n: float | None = _one("T_n", "1e-5", "Integral time of the speed loop")
    T_p: float | None = _one("T_p", "1e-3", "Integral time of the position loop")

    @property
    def sizes(self) -> tuple[DriveUnit, ...]:
        """Sizes of those that are given, in SI."""
        return tuple(DriveUnit(gain, getattr(self, gain), unit) for gain, unit in UNITS.items() if gain in self.given)

    @staticmethod
    def of(units: tuple[DriveUnit, ...]) -> "DriveUnitsSpec | None":
        """The group of sizes; None of none."""
        return DriveUnitsSpec(**{one.gain: one.size for one in units}) if units else None
