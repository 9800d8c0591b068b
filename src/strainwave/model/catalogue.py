"""Datasheet records of strain wave gears, each with its source and the doubts about it.

Stiffness follows the vendors' definition: three straight lines of slope K1, K2, K3 that meet at the torques T1 and T2
(Harmonic Drive LLC, CSF/CSG catalogue, p. 50). The numbers and their public sources are in the folder `data`.
"""

import ast
import csv
import difflib
import math
import re
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from .drive import Drive
from .laws import PiecewiseLinear

DATA = Path(__file__).parent / "data"
RPM = 2.0 * math.pi / 60.0
STIFFNESS_SOURCE = {
    "CSG/HFUC": "Harmonic Drive LLC CSF/CSG catalogue p. 50, CHA manual p. 50",
    "SHG/HFUS": "AimanHaidar/harmonic-drive-selector (Apache-2.0), the same as the CSF/CSG catalogue p. 50",
}


@dataclass(frozen=True)
class Gear:
    """Datasheet record of one gear.

    Attributes
    ----------
    name, series, size, ratio
        "CSG-40-50" is series "CSG", size 40 (pitch diameter in inch times 10), reduction ratio 50.
    K1, K2, K3 : float
        Torsional stiffness up to T1, from T1 to T2, and beyond T2 [N*m/rad, output side].
    T1, T2 : float
        Torques at which the slope changes [N*m, output side].
    rated_torque, average_torque, repeated_peak_torque, momentary_torque : float
        Limits of the output torque [N*m]; the rated one at 2000 rpm input speed.
    max_rpm, average_rpm : float
        Limits of the input speed with grease as printed [rpm]; `max_speed` and `average_speed` give them in rad/s.
    input_inertia : float
        Inertia of the wave generator [kg m^2, motor side].
    mass : float or None
        Mass [kg], None where the source is ambiguous.
    source : str
        Where the numbers come from.
    notes : tuple of str
        Doubts about single numbers, full sentences.
    """

    name: str
    series: str
    size: int
    ratio: int
    K1: float
    K2: float
    K3: float
    T1: float
    T2: float
    rated_torque: float
    average_torque: float
    repeated_peak_torque: float
    momentary_torque: float
    max_rpm: float
    average_rpm: float
    input_inertia: float
    mass: float | None
    source: str
    notes: tuple[str, ...] = ()

    @property
    def law(self) -> PiecewiseLinear:
        """The vendors' three-slope torsion law."""
        return PiecewiseLinear(self.K1, self.K2, self.K3, self.T1, self.T2)

    @property
    def max_speed(self) -> float:
        """Largest input speed with grease [rad/s]."""
        return self.max_rpm * RPM

    @property
    def average_speed(self) -> float:
        """Largest average input speed with grease [rad/s]."""
        return self.average_rpm * RPM

    def twist(self, torque: float) -> float:
        """Torsion [rad] under a static output torque [N*m] with the input locked (CSF/CSG catalogue, p. 50).

        T/K1 up to T1, T1/K1 + (T - T1)/K2 up to T2, T1/K1 + (T2 - T1)/K2 + (T - T2)/K3 beyond; odd in T.
        """
        size = abs(torque)
        first, second = min(size, self.T1), min(max(size - self.T1, 0.0), self.T2 - self.T1)
        third = max(size - self.T2, 0.0)
        return math.copysign(first / self.K1 + second / self.K2 + third / self.K3, torque)

    def drive(self, *, load_inertia: float, motor_inertia: float | None = None, B: float) -> Drive:
        """Build the drive of this gear.

        Parameters
        ----------
        load_inertia : float
            Inertia of the load [kg m^2, output side].
        motor_inertia : float, optional
            Everything that turns with the motor shaft, the wave generator included [kg m^2, motor side].
            Default: the wave generator alone.
        B : float
            Damping across the spring [N*m*s/rad, output side].

        Raises
        ------
        ValueError
            If an inertia is not positive or B is negative.
        """
        J_m = self.input_inertia if motor_inertia is None else motor_inertia
        for name, value in (("load_inertia", load_inertia), ("motor_inertia", J_m)):
            if not 0.0 < value < math.inf:
                raise ValueError(f"{name} is {value} kg*m^2; an inertia must be positive and finite")
        if not 0.0 <= B < math.inf:
            raise ValueError(f"B is {B} N*m*s/rad; the damping must be finite and not negative")
        return Drive(float(J_m), float(load_inertia), float(self.ratio), float(B), self.law)


def names() -> list[str]:
    """Names of all gears in the catalogue, in the order series, size, ratio."""
    return list(_gears())


def gear(name: str) -> Gear:
    """Return the record of a gear, for example ``gear("CSG-40-50")`` (series, size, ratio).

    Raises
    ------
    ValueError
        If the gear is unknown (the sentence lists the nearest names) or tabulated in part (it says what is missing).
    """
    key = re.sub(r"[\s_-]+", "-", str(name).strip().upper())
    found = _gears().get(key)
    if found is not None:
        return found
    missing = _missing(key)
    if missing:
        raise ValueError(f"the catalogue has no complete record of {name!r}: {missing}")
    near = difflib.get_close_matches(key, names(), n=3, cutoff=0.6)
    remedy = f"the nearest are {', '.join(near)}" if near else "its names look like CSG-40-50 (series, size, ratio)"
    raise ValueError(f"the catalogue has no gear {name!r}; {remedy}")


def _rows(file: str) -> list[dict[str, str]]:
    with (DATA / file).open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


def _stiffness(series: str, size: str, ratio: int) -> dict[str, str] | None:
    for row in _rows_of_stiffness():
        tabulated = row["ratio"]
        fits = ratio >= int(tabulated[2:]) if tabulated.startswith(">=") else ratio == int(tabulated)
        if series in row["family"].split("/") and row["size"] == size and fits:
            return row
    return None


@cache
def _rows_of_stiffness() -> list[dict[str, str]]:
    return _rows("catalogue_stiffness.csv")


@cache
def _gears() -> dict[str, Gear]:
    ratings = _rows("catalogue_ratings.csv")
    usual_rpm: dict[tuple[str, str], float] = {}
    for row in ratings:
        kin = _kin(row), row["size"]
        usual_rpm[kin] = max(usual_rpm.get(kin, 0.0), float(row["n_in_avg_rpm"]))
    gears = []
    for row in ratings:
        stiffness = _stiffness(row["series"], row["size"], int(row["ratio"]))
        if stiffness is not None:
            gears.append(_gear(row, stiffness, usual_rpm[_kin(row), row["size"]]))
    gears.sort(key=lambda g: (g.series, g.size, g.ratio))
    return {g.name: g for g in gears}


def _kin(row: dict[str, str]) -> str:
    """Series that share one average speed per size."""
    return "SHG/HFUS" if row["series"] in ("SHG", "HFUS") else "CSG/HFUC"


def _gear(row: dict[str, str], stiffness: dict[str, str], usual_rpm: float) -> Gear:
    name = f"{row['series']}-{row['size']}-{row['ratio']}"
    notes = [f"{name}: {stiffness['note']}."] if stiffness["note"] else []
    mass, doubt = _mass(row["mass_kg"])
    if doubt:
        notes.append(f"{name}: {doubt}")
    if float(row["n_in_avg_rpm"]) < usual_rpm:
        notes.append(
            f"{name}: the average input speed of {row['n_in_avg_rpm']} rpm looks mistyped in the source, other ratios "
            f"of this size say {usual_rpm:.0f} rpm; check the maker's datasheet."
        )
    return Gear(
        name=name,
        series=row["series"],
        size=int(row["size"]),
        ratio=int(row["ratio"]),
        K1=float(stiffness["K1_Nm_per_rad"]),
        K2=float(stiffness["K2_Nm_per_rad"]),
        K3=float(stiffness["K3_Nm_per_rad"]),
        T1=float(stiffness["T1_Nm"]),
        T2=float(stiffness["T2_Nm"]),
        rated_torque=float(row["T_rated_2000rpm_Nm"]),
        average_torque=float(row["T_average_Nm"]),
        repeated_peak_torque=float(row["T_repeated_peak_Nm"]),
        momentary_torque=float(row["T_momentary_Nm"]),
        max_rpm=float(row["n_in_max_rpm"]),
        average_rpm=float(row["n_in_avg_rpm"]),
        input_inertia=float(row["J_in_1e-4_kgm2"] + "e-4"),
        mass=mass,
        source=f"stiffness: {STIFFNESS_SOURCE[_kin(row)]}; ratings: {row['source']}",
        notes=tuple(notes),
    )


def _mass(text: str) -> tuple[float | None, str]:
    """Return the mass [kg], or None and why: the source does not name the two variants that a pair belongs to."""
    if not text.startswith("("):
        return float(text), ""
    printed = " and ".join(f"{m:g} kg" for m in ast.literal_eval(text) if m is not None)
    return (
        None,
        f"the mass is left empty, the source prints {text} ({printed}) without saying which variant weighs what.",
    )


def _missing(key: str) -> str:
    """Say what the tables lack about a gear that is in one of them, or return an empty text."""
    match = re.fullmatch(r"([A-Z]+)-([0-9]{1,3})-([0-9]{1,3})", key)
    if match is None:
        return ""
    series, size, ratio = match.group(1), match.group(2), int(match.group(3))
    rated = any((r["series"], r["size"], r["ratio"]) == match.groups() for r in _rows("catalogue_ratings.csv"))
    if rated:
        return "its torsional stiffness (K1, K2, K3, T1, T2) is not tabulated; give ratio and law explicitly"
    row = _stiffness(series, size, ratio)
    if row is None:
        return ""
    kin = [
        g.name
        for g in _gears().values()
        if g.series in row["family"].split("/") and g.size == int(size) and g.ratio == ratio
    ]
    advice = f"{kin[0]} has the same stiffness and inertia" if kin else "give ratio and law explicitly"
    return f"torques, input speeds, input inertia and mass are not tabulated; {advice}"
