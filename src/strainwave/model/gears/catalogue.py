"""The catalogue: datasheet records of strain wave gears, each number with its source and the doubts about it.

The tables and their public sources are in the folder `data`. What no source gives is None in the record.
"""

import ast
import csv
import difflib
import math
import re
from collections.abc import Iterable
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

from ...base.quantities import number, positive_count, shown
from .gear import Gear

__all__ = ["Gear", "gear", "names", "select"]

DATA = Path(__file__).parent / "data"
LONGEST_NAME = 60  # characters of a name
ARCMIN = math.pi / 10800.0
STIFFNESS_SOURCE = {
    "CSG/CSF/HFUC": "Harmonic Drive LLC CSF/CSG catalogue p. 50, CHA manual p. 50",
    "SHG/HFUS": "AimanHaidar/harmonic-drive-selector (Apache-2.0), the same as the CSF/CSG catalogue p. 50",
}
CSF_NOTE = (
    "rated to momentary torque, input speeds and mass are not tabulated; CSG carries about 30 % more torque and is "
    "rated for 10 000 h instead of 7 000 h"
)

Row = dict[str, str]


def names() -> list[str]:
    """Names of all gears in the catalogue, in the order series, size, ratio."""
    return list(_gears())


def gear(name: str) -> Gear:
    """Return the record of a gear, for example ``gear("CSG-40-50")`` (series, size, ratio).

    Raises
    ------
    ValueError
        If the gear is unknown; the sentence lists the nearest names.
    """
    if len(name) > LONGEST_NAME:
        raise ValueError(
            f"the catalogue has no gear {shown(name)}; its names look like 'CSG-40-50' (series, size, ratio)"
        )
    key = re.sub(r"[\s_-]+", "-", name.strip().upper())
    record = _gears().get(key)
    if record is not None:
        return record
    names = _nearest(key)
    remedy = f"the nearest are {', '.join(names)}" if names else "its names look like CSG-40-50 (series, size, ratio)"
    raise ValueError(f"the catalogue has no gear {name!r}; {remedy}")


def _nearest(key: str) -> list[str]:
    """Three names next to an unknown one: of its series by size and then ratio, else those that are spelt alike."""
    wanted = re.fullmatch(r"(.+)-([0-9]{1,4})-([0-9]{1,4})", key)
    if wanted:
        size, ratio = int(wanted[2]), int(wanted[3])
        same = [g for g in _gears().values() if g.series == wanted[1]]
        if same:
            return [g.name for g in sorted(same, key=lambda g: (abs((g.size or 0) - size), abs(g.ratio - ratio)))[:3]]
    return difflib.get_close_matches(key, names(), n=3, cutoff=0.6)


def select(
    gears: Iterable[Gear] | None = None,
    *,
    series: str | None = None,
    size: int | None = None,
    ratio: int | None = None,
    torque: float | None = None,
    stiffness: float | None = None,
    speed: float | None = None,
) -> list[Gear]:
    """Return the gears that meet all conditions; one whose record lacks a number meets no condition on it.

    Parameters
    ----------
    gears : iterable of Gear, optional
        Default: the whole catalogue.
    series : str, optional
        Capitals or not.
    size, ratio : int, optional
        Exactly these.
    torque : float, optional
        Smallest rated torque [N*m].
    stiffness : float, optional
        Smallest K1 [N*m/rad].
    speed : float, optional
        Smallest limit of the input speed [rad/s].

    Raises
    ------
    ValueError
        If a condition is no number that these can be.
    """
    for name, count in (("size", size), ("ratio", ratio)):
        if count is not None:
            positive_count(name, count)
    for name, low in (("torque", torque), ("stiffness", stiffness), ("speed", speed)):
        if low is not None:
            number(name, low)
    least = (("rated_torque", torque), ("K1", stiffness), ("max_speed", speed))

    def fits(g: Gear) -> bool:
        enough = all(low is None or (getattr(g, field) or 0.0) >= low * (1.0 - 1e-12) for field, low in least)
        alike = series is None or g.series.upper() == series.upper()
        return enough and alike and size in (None, g.size) and ratio in (None, g.ratio)

    return [g for g in (_gears().values() if gears is None else gears) if fits(g)]


@cache
def _rows(file: str) -> list[Row]:
    with (DATA / file).open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


@cache
def _gears() -> dict[str, Gear]:
    rated = [_rated(row) for row in _rows("catalogue_ratings.csv")]
    gears = [
        *rated,
        *_csf({(g.series, g.size): g.input_inertia for g in rated}),
        *map(_rt1, _rows("catalogue_rt1.csv")),
    ]
    gears = sorted(map(_completed, gears), key=lambda g: (g.series, g.size or 0, g.ratio))
    return {g.name: g for g in gears}


def _holds(tabulated: str, ratio: int) -> bool:
    """True if a row holds for a ratio: it names that ratio, or a least one after ">="."""
    return ratio >= int(tabulated[2:]) if tabulated.startswith(">=") else ratio == int(tabulated)


def _completed(g: Gear) -> Gear:
    """Return the gear with its stiffness, ratcheting and buckling torque, accuracy and doubts, where tabulated."""
    g = _with_accuracies(_with_torques(_with_stiffness(g)))
    for row in _rows("catalogue_notes.csv"):
        if (g.series, str(g.size), str(g.ratio)) == (row["series"], row["size"], row["ratio"]):
            g = _with(g, {}, "", row["note"], *row["numbers"].split("/"))
    return g


def _with_stiffness(g: Gear) -> Gear:
    """The gear with its stiffness in three pieces."""
    for row in _rows("catalogue_stiffness.csv"):
        if g.series in row["family"].split("/") and str(g.size) == row["size"] and _holds(row["ratio"], g.ratio):
            numbers = {k: float(row[f"{k}_Nm_per_rad"]) for k in ("K1", "K2", "K3")}
            numbers |= {k: float(row[f"{k}_Nm"]) for k in ("T1", "T2")}
            source = STIFFNESS_SOURCE.get(row["family"], row["note"])
            doubt = row["note"] if row["family"] in STIFFNESS_SOURCE else ""
            g = _with(g, numbers, f"stiffness: {source}", doubt, "T1")
    return g


def _with_torques(g: Gear) -> Gear:
    """The gear with its ratcheting and buckling torque."""
    for row in _rows("catalogue_ratcheting.csv"):
        if (g.series, str(g.size)) == (row["series"], row["size"]):
            torques = {
                "buckling_torque": row["buckling_Nm"],
                "ratcheting_torque": row.get(f"ratcheting_ratio_{g.ratio}_Nm"),
            }
            numbers = {name: float(torque) for name, torque in torques.items() if torque}
            g = _with(g, numbers, f"ratcheting and buckling: {row['source']}")
    return g


def _with_accuracies(g: Gear) -> Gear:
    """The gear with the angles of its accuracy, and one sentence for each source of them."""
    sources: dict[str, list[str]] = {}
    for row in _rows("catalogue_accuracy.csv"):
        fits = g.series in row["families"].split("/") and str(g.size) in row["sizes"].split("/")
        if fits and _holds(row["ratio"], g.ratio):
            value = float(row["value"])
            angle = value * ARCMIN if row["unit"] == "arcmin" else value / 1e4  # the other unit is 1e-4 rad
            g = _with(g, {row["quantity"]: angle}, "")
            sources.setdefault(row["source"], []).append(row["quantity"].replace("_", " "))
    for source, quantities in sources.items():
        g = _with(g, {}, f"{', '.join(quantities)}: {source}")
    return g


def _with(g: Gear, numbers: dict[str, Any], source: str, doubt: str = "", *about: str) -> Gear:
    """The gear with further numbers, and a doubt about some of all its numbers."""
    note = f"{g.name}: {doubt}."
    notes, doubts = (*g.notes, note), (*g.doubts, *((name, note) for name in about))
    g = replace(g, **numbers, source="; ".join(filter(None, (g.source, source))))
    return replace(g, notes=notes, doubts=doubts) if doubt else g


@cache
def _usual_rpm(kin: str, size: str) -> float:
    """Largest average input speed [rpm] of the gears of a size: the other series have one speed per size."""
    return max(float(r["n_in_avg_rpm"]) for r in _rows("catalogue_ratings.csv") if (_kin(r), r["size"]) == (kin, size))


def _kin(row: Row) -> str:
    """Family of a row, whose series have the same input speeds."""
    return "SHG/HFUS" if row["series"] in ("SHG", "HFUS") else "CSG/HFUC"


RATED = {  # numbers of a record, and their columns among the ratings
    "rated_torque": "T_rated_2000rpm_Nm", "average_torque": "T_average_Nm",
    "repeated_peak_torque": "T_repeated_peak_Nm", "momentary_torque": "T_momentary_Nm",
    "max_rpm": "n_in_max_rpm", "average_rpm": "n_in_avg_rpm",
}  # fmt: skip
OF_RT1 = {  # the same of the series RT1, each with the size of 1 in SI over that of the column
    "K1": ("K1_Nm_per_rad", 1.0), "K3": ("K3_Nm_per_rad", 1.0), "rated_torque": ("T_rated_Nm", 1.0),
    "efficiency": ("efficiency_percent", 100.0), "running_torque": ("running_torque_2000rpm_mNm", 1000.0),
    "starting_torque": ("starting_torque_mNm", 1000.0), "back_driving_torque": ("back_driving_torque_Nm", 1.0),
    "pitch_radius": ("pitch_radius_mm", 1000.0),
}  # fmt: skip


def _labels(row: Row) -> dict[str, Any]:
    """Name, series, size and ratio of a row."""
    series, size, ratio = row["series"], row["size"], row["ratio"]
    return {"name": f"{series}-{size}-{ratio}", "series": series, "size": int(size), "ratio": int(ratio)}


def _rated(row: Row) -> Gear:
    """Record of a row of the ratings."""
    mass, doubt = _mass(row["mass_kg"])
    usual_rpm, doubted = _usual_rpm(_kin(row), row["size"]), ""
    if float(row["n_in_avg_rpm"]) < usual_rpm:
        doubted = (
            f"the average input speed of {row['n_in_avg_rpm']} rpm looks mistyped in the source, other ratios "
            f"of this size say {usual_rpm:.0f} rpm; check the maker's datasheet"
        )
    numbers: dict[str, Any] = {name: float(row[column]) for name, column in RATED.items()}
    inertia, source = float(row["J_in_1e-4_kgm2"] + "e-4"), f"ratings: {row['source']}"
    gear = Gear(**_labels(row), **numbers, input_inertia=inertia, mass=mass, source=source)
    return _with(_with(gear, {}, "", doubt, "mass"), {}, "", doubted, "average_rpm")


def _mass(text: str) -> tuple[float | None, str]:
    """Return the mass [kg], or None and why: the source does not name the two variants that a pair belongs to."""
    if not text.startswith("("):
        return float(text), ""
    printed = " and ".join(f"{m:g} kg" for m in ast.literal_eval(text) if m is not None)
    return (
        None,
        f"the mass is left empty, the source prints {text} ({printed}) without saying which variant weighs what",
    )


def _csf(inertias: dict[tuple[str, int | None], float | None]) -> list[Gear]:
    """Records of the CSF gears whose stiffness is tabulated; their ratios come from the table of ratcheting torques."""
    stiff = [row for row in _rows("catalogue_stiffness.csv") if "CSF" in row["family"].split("/")]
    gears = []
    for row in _rows("catalogue_ratcheting.csv"):
        ratios = [int(key.split("_")[2]) for key, value in row.items() if key.startswith("ratcheting") and value]
        for ratio in ratios if row["series"] == "CSF" else ():
            if not any(r["size"] == row["size"] and _holds(r["ratio"], ratio) for r in stiff):
                continue
            name, size = f"CSF-{row['size']}-{ratio}", int(row["size"])
            J, notes = inertias.get(("CSG", size)), (f"{name}: {CSF_NOTE}.",)
            source = "" if J is None else f"inertia: that of CSG-{size}, which the maker says is the same"
            gears.append(
                Gear(name=name, series="CSF", size=size, ratio=ratio, input_inertia=J, source=source, notes=notes)
            )
    return gears


def _rt1(row: Row) -> Gear:
    """Record of a Schaeffler RT1-H-CS."""
    labels = _labels(row)
    numbers: dict[str, Any] = {name: float(row[column]) / size for name, (column, size) in OF_RT1.items()}
    note = (
        f"{labels['name']}: K2, T1 and T2, input speeds, inertia and further torque limits are not tabulated; K1 and "
        f"K3 are those of CSG-{row['size']}-{row['ratio']}; the efficiency is given within 3 percentage points."
    )
    return Gear(**labels, **numbers, source=row["source"], notes=(note,))
