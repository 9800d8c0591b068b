"""Measured Bode plots from files: tables of frequencies as drives export them, or records of a closed loop."""

import os
import re
from collections.abc import Mapping
from math import pi
from pathlib import Path

import numpy as np

from ..base.quantities import joined, shown
from ..base.results import Complexes, Floats
from ..base.units import HERTZ
from ..study.identification.bode.measured_bode import Estimator, MeasuredBode, Quantity, bode_of_records, measured_bode
from .logs.names import ENDINGS, QUANTITIES, SHAFTS
from .logs.read import columns_of, read_log
from .logs.table import Column, index_of, refuse, unit_of
from .yaml_text import FileError

Columns = Mapping[str, str | int] | None

WORDS = {
    "frequency": {"frequency", "freq", "f", "frequenz", "omega", "w", "ω"},
    "size": {"magnitude", "mag", "gain", "amplitude", "amplitudengang", "betrag", "ampl", "abs", "size"},
    "phase": {"phase", "phi", "phasengang", "angle", "arg", "φ"},
    "real": {"real", "re", "realteil"},
    "imaginary": {"imaginary", "imag", "im", "imaginärteil", "imaginaerteil"},
}
UNITS = {
    "frequency": {"hz": HERTZ, "khz": 1e3 * HERTZ, "rad/s": 1.0},
    "size": {"db": 0.0, "1": 1.0, "-": 1.0, "gain": 1.0},  # a factor is of no use to decibels
    "phase": dict.fromkeys(("deg", "°", "degree", "degrees", "grad"), pi / 180.0) | {"rad": 1.0},
}
NUMBERS = {"1", "-"}  # units when they stand alone
SPELT = {ending: unit for ending, unit in ENDINGS.items() if unit == "rad/s"} | {"rad/sec": "rad/s"}
ASKED = {"frequency": ("Hz", "rad/s"), "size": ("dB", "gain"), "phase": ("deg", "rad")}
LOAD = set(SHAFTS["load"])
OF = ", motor speed over motor torque [rad/(N*m*s)]"
OMEGA = {"omega", "w", "ω"}
TURNS = 4.0 * pi  # a phase beyond it in radians is in degrees
RECORDS = {
    "reference": {"reference", "ref", "excitation", "setpoint", "sollwert", "command"},
    "motor_torque": set(QUANTITIES["torque"]),
    "motor_speed": set(QUANTITIES["speed"]),
}


def read_frd(
    path: str | os.PathLike[str], columns: Columns = None, units: Mapping[str, str] | None = None, *,
    quantity: Quantity | None = None, amplitude: float | None = None, estimator: Estimator = "unknown",
    delimiter: str | None = None, decimal: str | None = None,
) -> MeasuredBode:  # fmt: skip
    """Read a measured Bode plot.

    Parameters
    ----------
    path : str or Path
        A file as of `read_log` with a column of frequencies, and size and phase, size alone, or real and imaginary
        part; or with time, reference, torque and speed of the motor, from which `bode_of_records` estimates the plant.
    columns : mapping, optional
        Columns by "frequency", "size", "phase", "real", "imaginary", or by "time", "reference", "motor_torque",
        "motor_speed". Default: by the names in the file.
    units : mapping, optional
        Units: Hz, kHz, rad/s; dB, gain; deg, rad. Default: those of the file, or refused where they are not clear.
    quantity : {"plant", "open loop", "closed loop"}, optional
        Measured quantity. Default: that of the names in the file, else the plant, motor speed over torque.
    amplitude, estimator
        As of `measured_bode`.
    delimiter, decimal
        As of `read_log`.

    Returns
    -------
    MeasuredBode
        Frequencies `omega` [rad/s], ascending, and the response `value`, (n,) arrays, complex: motor speed over its
        torque [rad/(N*m*s)], or a loop gain [1], as `quantity` says.

    Raises
    ------
    FileError
        If the file has no such columns, several that may be meant, or a unit that is not clear; one sentence.
    """
    path, columns = Path(path), dict(columns or {})
    file, notes = columns_of(path, delimiter, decimal)
    records = "frequency" not in columns and not any(_words(column) & WORDS["frequency"] for column in file)
    try:
        _refuse_unread(records, columns, units or {}, quantity, estimator)
        if records:
            by_role = _record_columns(path, file, columns)
            log = read_log(path, by_role, units, trim=0.0, unwrap=False, delimiter=delimiter, decimal=decimal)
            rows = [log.channels[role] for role in RECORDS]
            return bode_of_records(log.time, *rows, amplitude=amplitude, notes=log.notes)
        picked = {role: _picked(path, file, role, columns) for role in WORDS}
        omega, z, phased = _response(picked, units or {}, notes)
        names = " ".join(re.findall(r"[a-z0-9]+", " ".join(c.name.lower() for c in picked.values() if c is not None)))
        if quantity is None:
            quantity = "open loop" if "open loop" in names else "closed loop" if "closed loop" in names else "plant"
            notes.append(f"it was taken as that of the {quantity}{OF if quantity == 'plant' else ''}")
        if estimator == "unknown" and "h1" in names.split():
            estimator = "H1"
        return measured_bode(
            omega, z, quantity=quantity, phased=phased, amplitude=amplitude, estimator=estimator, notes=tuple(notes)
        )  # fmt: skip
    except FileError:
        raise
    except ValueError as error:
        raise refuse(path, str(error), what="Bode plot") from None


def _refuse_unread(
    records: bool, columns: Mapping[str, object], units: Mapping[str, str], quantity: str | None, estimator: str
) -> None:
    """Refuse arguments that do not count for what the file holds (ValueError)."""
    roles, what = (("time", *RECORDS), "records") if records else (tuple(WORDS), "a table of frequencies")
    for name, given, accepted in (("columns", columns, roles), ("units", units, roles if records else tuple(UNITS))):
        if wrong := [key for key in given if key not in accepted]:
            raise ValueError(f"holds {what}, and {name} has {shown(wrong[0])}; accepted: {', '.join(accepted)}")
    if records and (quantity not in (None, "plant") or estimator != "unknown"):
        raise ValueError(
            "holds records of a closed loop, from which the plant is estimated with the reference as instrument; leave "
            "quantity and estimator out"
        )


def _words(column: Column) -> set[str]:
    """Words of a column's name, in small letters."""
    text = re.sub(r"(?<=[a-z])(?=[A-Z][a-z])", "_", column.name.replace("dB", "db").replace("Hz", "hz"))
    return set(re.findall(r"[^\W\d_]+", text.lower()))


def _unit(role: str, column: Column) -> str:
    """Unit that a file gives a column of a Bode plot, "" without one."""
    written = unit_of(column).lower()
    for text in (written, column.name.lower()):
        for spelling, unit in SPELT.items():
            text = text.replace(spelling, unit)
        words = re.findall(r"[^\s\[\](),;_]+", text)
        words += [word.rpartition("/")[2] for word in words]
        units = [word for word in words if word in UNITS[role] and word != "gain" and (written or word not in NUMBERS)]
        if units:
            return str(units[0])
        written = ""
    return ""


def _picked(path: Path, file: list[Column], role: str, columns: Mapping[str, str | int]) -> Column | None:
    """Column of a role: as given, or the only one whose name says so."""
    if role in columns:
        return file[index_of(path, file, role, columns[role])]
    named = [column for column in file if _words(column) & WORDS[role]]
    if len(named) > 1:
        names, first = ", ".join(column.name for column in named), named[0].name
        raise ValueError(f"has {len(named)} columns of the {role}, {names}; which one? columns={{{role!r}: {first!r}}}")
    return named[0] if named else None


def _in_unit(role: str, column: Column, units: Mapping[str, str], notes: list[str]) -> Floats:
    """Values of a column: rad/s, size or rad."""
    values, spelling = column.values, _unit(role, column)
    guesses = {
        "frequency": "rad/s" if _words(column) & OMEGA else "",
        "size": "db" if np.any(values < 0.0) else "",
        "phase": "deg" if np.nanmax(np.abs(values)) > TURNS else "",
    }
    unit = units.get(role, spelling).lower() or guesses[role]
    if unit not in UNITS[role]:
        first, second = ASKED[role]
        fact = f"is in {joined([unit])}" if unit else "has no unit"
        raise ValueError(f"{shown(column.name)} {fact}; is it {first} or {second}? units={{{role!r}: {first!r}}}")
    if role == "size" and unit != "db" and np.any(values < 0.0):
        raise ValueError(f"{shown(column.name)} has negative sizes; are they in dB? units={{'size': 'dB'}}")
    if not spelling and role not in units:
        notes.append(f"the {role} was read in {unit.replace('db', 'dB')}")
    return np.asarray(10.0 ** (values / 20.0) if unit == "db" else values * UNITS[role][unit])


def _response(
    picked: Mapping[str, Column | None], units: Mapping[str, str], notes: list[str]
) -> tuple[Floats, Complexes, bool]:  # fmt: skip
    """Frequencies [rad/s], complex values or sizes, and whether they have a phase."""
    given = {role: column for role, column in picked.items() if column is not None}
    part = {r: _in_unit(r, column, units, notes) if r in ASKED else column.values for r, column in given.items()}
    if len(set(map(len, part.values()))) > 1:
        raise ValueError(f"has {', '.join(f'{len(v)} values of the {k}' for k, v in part.items())}; give equally many")
    pair = {"real", "imaginary"} <= part.keys()
    if not pair and "size" not in part:
        raise ValueError(
            "has frequencies, but no size and no real and imaginary part; name the column: columns={'size': NAME}"
        )
    z = part["real"] + 1j * part["imaginary"] if pair else part["size"] * np.exp(1j * part.get("phase", 0.0))
    good = np.isfinite(z) & (part["frequency"] > 0.0) & (z != 0.0)
    if not np.all(good):
        notes.append(f"{np.sum(~good)} lines without frequency or value were omitted")
    return part["frequency"][good], z[good], pair or "phase" in part


def _record_columns(path: Path, file: list[Column], columns: Mapping[str, str | int]) -> dict[str, str | int]:
    """Columns of a log of reference, torque and speed."""
    by_role = dict(columns)
    for role, words in RECORDS.items():
        if role in by_role:
            continue
        taken = [index_of(path, file, channel, column) for channel, column in by_role.items()]
        named = [i for i, c in enumerate(file) if _words(c) & words and not _words(c) & LOAD and i not in taken]
        if len(named) != 1:
            names = ", ".join(file[i].name for i in named) or "none"
            raise ValueError(
                f"has no frequency, and records need a {role.replace('_', ' ')}, of which there is {names}: "
                f"columns={{'frequency': NAME}} or columns={{{role!r}: NAME}} names it"
            )
        by_role[role] = named[0]
    return by_role
