"""Names of columns: the unit in a name, and the canonical channel that it stands for."""

import re
from contextlib import suppress
from math import pi
from typing import NamedTuple

import numpy as np

from ...base.results import Floats
from ...base.units import NUMBER, convert, parse
from ...study.identification.run import CANONICAL

TURN = 2.0 * pi  # rad
KINDS = ("rad", "rad/s", "rad/s**2", "N*m", "s", "A", "V", "Hz", "K", "m", "N")  # SI units of channels
QUANTITIES = {
    "angle": ("angle", "position", "pos", "theta", "q", "winkel"),
    "speed": ("speed", "velocity", "vel", "velo", "omega", "dq", "qd", "drehzahl"),
    "torque": ("torque", "tau", "moment", "drehmoment", "effort"),
}
SHAFTS = {"motor": ("motor", "m"), "load": ("load", "l", "output", "joint", "link", "")}
FILLERS = re.compile(r"(?i)(?<![a-z])(act|actual|meas|measured|msr|estimate|encoder)(?![a-z])_?|_(?=estimate)")
UNMEASURED = re.compile(r"(?i)(pos|vel)_estimate|servo_stats|moteus|odrive|(motor|load)inc|counts?|ticks?")  # no angles
_OWN = {
    "time": ("time", "t", "timestamp", "zeit", "zeit_in_sec", "sec", "secs", "datetime", "date_time", "date", "datum"),
    "current": ("current", "motor_current", "strom"),
    "torsion": ("torsion", "twist"),
    "input": ("input",),
    "output": ("output",),
}
# In a name without brackets these endings are units; a single m is the motor.
ENDINGS = {
    "s": "s", "ms": "ms", "us": "us", "ns": "ns", "rad": "rad", "mrad": "mrad", "deg": "deg", "arcmin": "arcmin",
    "arcsec": "arcsec", "rev": "rev", "turns": "rev", "rad_per_s": "rad/s", "rad_s": "rad/s", "rads": "rad/s",
    "deg_per_s": "deg/s", "deg_s": "deg/s", "rpm": "rpm", "rev_per_s": "rev/s", "nm": "N*m", "n_m": "N*m",
    "mnm": "mN*m", "ncm": "N*cm", "a": "A", "ma": "mA", "v": "V", "mv": "mV", "hz": "Hz",
}  # fmt: skip
SINCE_1970_S = 978_307_200.0, 4_102_444_800.0  # to 2001 and to 2100
_SPELT = dict.fromkeys(("1/min", "min-1", "min^-1", "u/min"), "rpm")
_SPELT |= {"grad": "deg", "°/s": "deg/s", "rps": "rev/s"}


class Named(NamedTuple):
    """A column's name without its unit, and the unit, "" without one."""

    name: str
    unit: str


def unit_row(cells: list[str]) -> bool:
    """True for a line below the names that holds units: some, and nothing else."""
    bare = [cell.strip("[]() ") for cell in cells]
    return any(bare) and all(not cell or cell in ("-", "dB") or si_unit(cell) is not None for cell in bare)


def named(cell: str) -> Named:
    """Name and unit of "speed [rpm]", "pos (deg)", "Zeit / s", "velocity_rad_per_s"."""
    text = cell.strip().strip('"')
    for pattern in (r"(.+?)\s*\[([^\[\]]*)\]", r"(.+?)\s*\(([^()]*)\)", r"(.+?)\s+/\s+(\S+)", r"(.+?)\s+in\s+(\S+)"):
        match = re.fullmatch(pattern, text)
        if match and match.group(2).isdigit():
            continue  # an index
        if match and (pattern.endswith("]") or si_unit(match.group(2)) is not None):
            return Named(match.group(1).strip(), match.group(2).strip())
    parts = text.split("_")
    for count in (3, 2, 1):
        ending = "_".join(parts[-count:]).lower()
        if len(parts) > count and ending in ENDINGS:
            return Named("_".join(parts[:-count]), ENDINGS[ending])
    return Named(text, "")


def canonical(name: str) -> str | None:
    """Canonical channel, or "time", that a column's name stands for."""
    words = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name.strip())
    plain = re.sub(r"[^a-z0-9]+", "_", words.lower()).strip("_")
    for channel, names in _OWN.items():
        if plain in names:
            return channel
    parts = plain.split("_")
    for quantity, names in QUANTITIES.items():
        if sum(part in names for part in parts) == 1 and len(parts) <= 2:
            prefix = "".join(part for part in parts if part not in names)
            shaft = next((shaft for shaft, called in SHAFTS.items() if prefix in called), None)
            if shaft is None:
                continue
            return "torque" if quantity == "torque" and not prefix else f"{shaft}_{quantity}"
    return None


def suffixed(name: str) -> str | None:
    """Canonical channel that the end of a longer name stands for: "/arm/position", "encoder.pos_estimate", "ActPos"."""
    last = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", re.split(r"[/.]", name.strip("/."))[-1])
    return canonical(re.sub(r"(?i)(motor|load)inc$", r"\1_pos", FILLERS.sub("", last)))


def si_unit(unit: str) -> str | None:
    """SI unit of what a unit measures, or None if it is not known."""
    for kind in KINDS:
        with suppress(ValueError):
            convert(1.0, _spelt(unit), kind)
            return kind
    return None


def converted(values: Floats, unit: str | float, kind: str) -> Floats:
    """Values in SI.

    Parameters
    ----------
    values : (n,) array
        As they stand in the file.
    unit : str or float
        Their unit; or the size of 1, "0.088 deg" or a number in SI.
    kind : str
        The SI unit.

    Raises
    ------
    ValueError
        If the unit is not known or measures something else.
    """
    if isinstance(unit, str):
        text = unit.strip()
        sized = NUMBER.match(text) is not None and _spelt(text) == text and not text.startswith("1/")
        return values * parse(text, kind) if sized else convert(values, _spelt(text), kind)
    return values * float(unit)


def expected(channel: str) -> str:
    """SI unit of a canonical channel or the time, "" of others."""
    return "s" if channel == "time" else CANONICAL.get(channel, "")


def epoch_unit(time: Floats) -> str:
    """Unit in which times without one count from 1970: "ms", "us" or "ns"; "" where they do not.

    Of 2001 to 2100, in steps of less than a minute: times since a computer was started, in ns, may have the size of
    those since 1970 in ms.
    """
    finite = time[np.isfinite(time)]
    for unit, size in (("ms", 1e3), ("us", 1e6), ("ns", 1e9)):
        if len(finite) > 1 and SINCE_1970_S[0] <= np.min(finite) / size and np.max(finite) / size <= SINCE_1970_S[1]:
            return unit if np.median(np.abs(np.diff(finite))) / size < 60.0 else ""
    return ""


def _spelt(unit: str) -> str:
    return _SPELT.get(unit.strip().lower(), unit.strip())
