"""Write what common units are worth, as Pint computes it: python tools/units.py.

`strainwave.base.units` reads the table in place of Pint, whose import takes longer than most answers.
"""

from pathlib import Path

from strainwave.base import units

TARGET = Path(units.__file__).with_name("common_units.txt")
SPELLINGS = {
    "": ["", "percent"],
    "rad": ["rad", "mrad", "urad", "deg", "arcmin", "arcsec", "rev", "turn"],
    "arcsec": ["rad", "arcsec", "deg"],
    "rad/s": ["rad/s", "rpm", "deg/s", "rev/s"],
    "N*m": ["N*m", "Nm", "mN*m", "mNm", "N*cm", "Ncm", "kN*m", "kNm"],
    "N*m/rad": ["N*m/rad", "Nm/rad", "N*m/arcmin", "Nm/arcmin", "N*m/mrad", "N*m/arcsec", "N*m/deg", "kN*m/rad"],
    "kg*m**2": ["kg*m^2", "kg*cm^2", "g*cm^2", "kg*mm^2", "g*mm^2", "g*m^2"],
    "N*m*s/rad": ["N*m*s/rad", "Nm*s/rad"],
    "1/rad**2": ["1/rad^2"],
    "1/rad": ["1/rad"],
    "K": ["K"],
    "Hz": ["Hz", "kHz", "1/s"],
    "s": ["s", "ms", "us", "min", "h"],
    "A": ["A", "mA"],
    "N*m/A": ["N*m/A", "mN*m/A", "Nm/A"],
    "V": ["V", "mV"],
    "kg": ["kg", "g"],
    "m": ["m", "mm", "cm"],
    "m/s**2": ["m/s^2"],
}


def rows() -> list[str]:
    """Lines of the table: what is given, what is wanted, and p and q of a factor p/q, with tabs between."""
    units.common.cache_clear()
    return [
        "\t".join([given, wanted, *map(repr, units.computed_factors(given, wanted))])
        for wanted, spellings in SPELLINGS.items()
        for given in spellings
    ]


if __name__ == "__main__":
    TARGET.write_text("\n".join(rows()) + "\n", encoding="utf-8")
