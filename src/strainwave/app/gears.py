"""`strainwave catalogue`: the gears of the catalogue, and the record of one."""

from dataclasses import asdict

import click

from ..model import catalogue
from .console import number, print_table, to_json

UNITS = {
    "K1": "N*m/rad",
    "K2": "N*m/rad",
    "K3": "N*m/rad",
    "T1": "N*m",
    "T2": "N*m",
    "rated_torque": "N*m",
    "average_torque": "N*m",
    "repeated_peak_torque": "N*m",
    "momentary_torque": "N*m",
    "max_rpm": "rpm",
    "average_rpm": "rpm",
    "input_inertia": "kg*m^2",
    "mass": "kg",
}


def show(name: str | None, series: str | None, size: int | None, ratio: int | None, as_json: bool) -> None:
    """Print one record, or the list that passes the filters.

    Raises
    ------
    ValueError
        If the gear is unknown, or nothing passes the filters.
    """
    if name is not None:
        _one(name, as_json)
        return
    gears = [catalogue.gear(known) for known in catalogue.names()]
    chosen = [
        g
        for g in gears
        if (series is None or g.series == series.upper()) and size in (None, g.size) and ratio in (None, g.ratio)
    ]
    if not chosen:
        known = ", ".join(sorted({g.series for g in gears}))
        raise ValueError(f"no gear of the catalogue has that series, size and ratio; it has the series {known}")
    if as_json:
        click.echo(to_json({"units": UNITS, "gears": [asdict(g) for g in chosen]}))
        return
    columns = ("gear", "ratio", "K1 N·m/rad", "K2", "K3", "T1 N·m", "T2", "rated N·m", "max rpm", "J_in kg·m²")
    rows = [(g.name, g.ratio, g.K1, g.K2, g.K3, g.T1, g.T2, g.rated_torque, g.max_rpm, g.input_inertia) for g in chosen]
    print_table(
        f"{len(chosen)} gears",
        columns,
        rows,
        "input speeds with grease; `strainwave catalogue NAME` shows source and doubts",
    )


def _one(name: str, as_json: bool) -> None:
    gear = catalogue.gear(name)
    record = asdict(gear)
    if as_json:
        click.echo(to_json({"units": UNITS, "gear": record}))
        return
    for key, value in record.items():
        if key not in ("notes", "source"):
            click.echo(f"{key:<22}{number(value, 6)} {UNITS.get(key, '')}".rstrip())
    click.echo(f"source: {gear.source}")
    for note in gear.notes:
        click.echo(f"note: {note}")
