"""`strainwave catalogue`: a list of gears of the catalogue or of a file that meet conditions, or one gear's record."""

from dataclasses import asdict
from pathlib import Path

import click

from ....base.units import ARCSEC
from ....files.own_gears import read_gears
from ....model.gears.catalogue import gear, names, select
from ....model.gears.gear import NUMBERS, Gear
from ...console import number, print_table, to_json
from ...view import quantity
from ..options import file_type, json_option


def names_as_typed(_ctx: click.Context, _option: click.Parameter, typed: str) -> list[str]:
    """Names of the catalogue that begin as typed."""
    return [name for name in names() if name.startswith(typed.upper())]


@click.command()
@click.argument("name", required=False, shell_complete=names_as_typed)
@click.option("--series", help="Only this series, for example CSG.")
@click.option("--size", type=int, help="Only this size.")
@click.option("--ratio", type=int, help="Only this ratio.")
@click.option("--torque", help='Smallest rated torque, for example "100 N*m".')
@click.option("--stiffness", help='Smallest stiffness K1, for example "1e5 N*m/rad".')
@click.option("--speed", help='Smallest limit of the input speed, for example "3000 rpm".')
@click.option("--file", type=file_type, help="Gears of your own in YAML or CSV, in place of the catalogue.")
@json_option
def catalogue(
    name: str | None, series: str | None, size: int | None, ratio: int | None, file: Path | None, as_json: bool,
    **least: str | None,
) -> None:  # fmt: skip
    """List gears of the catalogue or of a file, or show one."""
    listed_gears = None if file is None else read_gears(file)
    if name is not None:
        _one(gear(name) if listed_gears is None else _own(listed_gears, name, file), as_json)
        return
    units = {"torque": "N*m", "stiffness": "N*m/rad", "speed": "rad/s"}
    bounds = {key: quantity(f"--{key}", text, units[key]) for key, text in least.items() if text is not None}
    gears = list(listed_gears.values()) if listed_gears is not None else select()
    chosen = select(gears, series=series, size=size, ratio=ratio, **bounds)
    if not chosen:
        known = ", ".join(sorted({g.series for g in gears} - {""})) or "none"
        where = "the catalogue" if file is None else str(file)
        raise ValueError(f"no gear of {where} meets all conditions; it has {len(gears)} gears of the series {known}")
    if as_json:
        click.echo(to_json({"units": NUMBERS, "gears": [asdict(g) for g in chosen]}))
        return
    columns = ("gear", "K1", "K2", "K3", "T1", "T2", "rated", "rpm")  # 80 letters wide with the longest name
    fields = ("K1", "K2", "K3", "T1", "T2", "rated_torque", "max_rpm")
    rows = [(_marked(g), *(getattr(g, field) for field in fields)) for g in chosen]
    caption = (
        "K in N·m/rad, T and rated torque in N·m; largest speed with grease; – is not tabulated; * a doubtful number; "
    )
    caption += "`strainwave catalogue NAME` shows the rest"
    print_table("1 gear" if len(chosen) == 1 else f"{len(chosen)} gears", columns, rows, caption)


def _marked(gear: Gear) -> str:
    """Name of a gear, with its ratio where that is not its end, and a star where a number of its record is doubtful."""
    star = " *" if any(getattr(gear, name) is not None for name, _ in gear.doubts) else ""
    return gear.name + ("" if gear.name.endswith(f"-{gear.ratio}") else f", ratio {gear.ratio}") + star


def _own(gears: dict[str, Gear], name: str, file: Path | None) -> Gear:
    if name not in gears:
        raise ValueError(f"{file} has no gear {name!r}; it has {', '.join(gears)[:200]}")
    return gears[name]


def _one(gear: Gear, as_json: bool) -> None:
    if as_json:
        click.echo(to_json({"units": NUMBERS, "gear": asdict(gear), "cubic_fit": _fit(gear)}))
        return
    for key, value in asdict(gear).items():
        if key not in ("notes", "doubts", "source") and value is not None:
            unit = NUMBERS.get(key, "")
            angle = f"  ({value / ARCSEC:.4g} arcsec)" if unit == "rad" else ""
            click.echo(f"{key:<22}{number(value, 6)} {unit}".rstrip() + angle)
    fit = _fit(gear)
    if fit is not None:
        click.echo(f"{'cubic fit':<22}K {number(fit['K'], 4)} N*m/rad, alpha {number(fit['alpha'], 4)} 1/rad**2, "
                   f"rms error {100.0 * fit['relative_rms']:.2g} % up to {number(fit['reach'], 4)} rad")  # fmt: skip
    unknown = [key for key in NUMBERS if getattr(gear, key) is None]
    click.echo(f"not tabulated: {', '.join(unknown) or 'nothing'}")
    click.echo(f"source: {gear.source}")
    for note in gear.notes:
        click.echo(f"note: {note}")


def _fit(gear: Gear) -> dict[str, float] | None:
    if None in (gear.K1, gear.K2, gear.K3, gear.T1, gear.T2):
        return None
    fit = gear.fit(3)
    return {"K": gear.cubic.K, "alpha": gear.cubic.alpha, "relative_rms": fit.relative, "reach": fit.reach}
