"""`strainwave catalogue`: gears of the catalogue or of a file that meet conditions, or all numbers of one."""

from dataclasses import asdict
from pathlib import Path

import click

from ...base.units import ARCSEC
from ...files.own_gears import read_gears
from ...model.gears.catalogue import gear, select
from ...model.gears.gear import NUMBERS, Gear
from ...model.orders import TURNING_SPLINE, USUAL
from ..console import number, to_json
from ..console.terminal import echo, print_table
from .options import file_type, json_option, names_as_typed, quantity


@click.command()
@click.argument("name", required=False, shell_complete=names_as_typed)
@click.option("--series", help="Only this series, for example CSG.")
@click.option("--size", type=int, help="Only this size.")
@click.option("--ratio", type=int, help="Only this ratio.")
@click.option("--torque", help='Smallest rated torque, for example "100 N*m".')
@click.option("--stiffness", help='Smallest stiffness K1, for example "1e5 N*m/rad".')
@click.option("--speed", help='Smallest limit of the input speed, for example "3000 rpm".')
@click.option("--file", type=file_type, help="YAML or CSV file with your own gears, instead of the catalogue.")
@json_option
def catalogue(
    name: str | None, series: str | None, size: int | None, ratio: int | None, file: Path | None, as_json: bool,
    **least: str | None,
) -> None:  # fmt: skip
    """List gears of the catalogue or of a file, or show one."""
    library = None if file is None else read_gears(file)
    if name is not None:
        if library is not None and name not in library:
            raise ValueError(f"{file} has no gear {name!r}; it has {', '.join(library)[:200]}")
        _one(gear(name) if library is None else library[name], as_json)
        return
    units = {"torque": "N*m", "stiffness": "N*m/rad", "speed": "rad/s"}
    bounds = {key: quantity(f"--{key}", text, units[key]) for key, text in least.items() if text is not None}
    gears = select() if library is None else list(library.values())
    chosen = select(gears, series=series, size=size, ratio=ratio, **bounds)
    if not chosen:
        listed = ", ".join(sorted({g.series for g in gears} - {""})) or "none"
        where = "the catalogue" if file is None else str(file)
        raise ValueError(f"no gear of {where} meets all conditions; searched: {len(gears)} gears, series {listed}")
    if as_json:
        click.echo(to_json({"units": NUMBERS, "gears": [asdict(g) for g in chosen]}))
        return
    columns = ("gear", "K1", "K2", "K3", "T1", "T2", "rated", "rpm")  # 80 letters wide with the longest name
    fields = ("K1", "K2", "K3", "T1", "T2", "rated_torque", "max_rpm")
    rows = [(_marked(g), *(getattr(g, field) for field in fields)) for g in chosen]
    caption = (
        "stiffness K in N·m/rad; torque T and rated torque in N·m; largest speed with grease; –: not tabulated; "
        "*: doubtful number; `strainwave catalogue NAME` shows all numbers of a gear"
    )
    print_table("1 gear" if len(chosen) == 1 else f"{len(chosen)} gears", columns, rows, caption)


def _marked(gear: Gear) -> str:
    """Name of a gear, with its ratio where that is not its end, and a star where a number of its record is doubtful."""
    star = " *" if any(getattr(gear, name) is not None for name, _ in gear.doubts) else ""
    return gear.name + ("" if gear.name.endswith(f"-{gear.ratio}") else f", ratio {gear.ratio}") + star


def _one(gear: Gear, as_json: bool) -> None:
    if as_json:
        click.echo(to_json({"units": NUMBERS, "gear": asdict(gear), "cubic_fit": _fit(gear)}))
        return
    for key, value in asdict(gear).items():
        if key not in ("notes", "doubts", "source") and value is not None:
            unit = NUMBERS.get(key, "")
            angle = f"  ({value / ARCSEC:.4g} arcsec)" if unit == "rad" else ""
            click.echo(f"{key:<22}{number(value, 6)} {unit}".rstrip() + angle)
    arrangements = ((USUAL, "as printed"), (TURNING_SPLINE, "fixed: flexspline")) if gear.ratio > 1 else ()
    for arrangement, how in arrangements:
        ratio = int(arrangement.ratio(gear.ratio))
        sense = "with" if ratio > 0 else "against"
        click.echo(f"{'arrangement':<22}{arrangement}: ratio {abs(ratio)}, output turns {sense} the motor ({how})")
    if (fit := _fit(gear)) is not None:
        click.echo(f"{'cubic fit':<22}K {number(fit['K'], 4)} N*m/rad, alpha {number(fit['alpha'], 4)} 1/rad**2, "
                   f"rms error {100.0 * fit['relative_rms']:.2g} % up to {number(fit['reach'], 4)} rad")  # fmt: skip
    unknown = [key for key in NUMBERS if getattr(gear, key) is None]
    texts = [f"not tabulated: {', '.join(unknown) or 'nothing'}", f"source: {gear.source}"]
    echo("\n".join([*texts, *(f"note: {note}" for note in gear.notes)]))


def _fit(gear: Gear) -> dict[str, float] | None:
    if not gear.has_law:
        return None
    fit = gear.fit(3)
    return {"K": gear.cubic.K, "alpha": gear.cubic.alpha, "relative_rms": fit.relative, "reach": fit.reach}
