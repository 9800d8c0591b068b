"""`strainwave order-table`: an order table from one format to another, and what is lost on the way."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import click

from ....files.order_tables.order_table import OrderTable
from ....files.order_tables.registry import named
from ....files.order_tables.residual import TableResidual
from ....quantities import number, parse, shown
from ....units import ARCSEC
from ...console import number as written
from ...console import to_json


def show(
    source: Path, target: Path, forms: tuple[str | None, str], options: tuple[Sequence[str], Sequence[str]],
    changes: dict[str, Any], as_json: bool,
) -> None:  # fmt: skip
    """Read an order table, change it as requested, write it and print what the file leaves.

    Parameters
    ----------
    source, target : Path
        The file as it is and as it is wanted.
    forms : (str or None, str)
        Names of the two formats; None where the first is to be recognised.
    options : (sequence of str, sequence of str)
        KEY=VALUE of the two formats.
    changes : dict
        `ratio`, `speed` (text), `one_way`, None where not given; `drop`, whether orders may be left out.
    as_json : bool
        Whether to print JSON.

    Raises
    ------
    FileError
        If the file is no order table.
    ValueError
        If the target cannot hold it, or an option is wrong.
    """
    form = named(forms[1])
    table = OrderTable.read(source, forms[0], **_pairs(options[0]))
    if changes["ratio"] is not None:
        table = replace(table, ratio=number("--ratio", changes["ratio"], positive=True))
    if changes["speed"] is not None:
        table = table.at_speed(parse(changes["speed"], "rad/s"))
    if changes["one_way"] is not None:
        table = table.one_way(changes["one_way"])
    left = table.write(target, form.name, drop=changes["drop"], **_pairs(options[1]))
    if as_json:
        data = {"file": source.name, "written": str(target), "format": form.name, "orders": list(table.orders)}
        click.echo(to_json(data | {"residual": left._asdict()}))
        return
    click.echo(f"{source.name}: {len(table.orders)} orders per turn of the {table.turn}, {table.sign} in {table.unit}")
    click.echo("\n".join(f"  {line}" for line in _said(left)))
    click.echo(f"  written: {target} ({form.title})")


def _pairs(given: Sequence[str]) -> dict[str, str]:
    found = {}
    for text in given:
        name, mark, value = text.partition("=")
        if not (mark and name and value):
            raise ValueError(f"the option {shown(text)} is no KEY=VALUE; write for example points=360")
        found[name.strip()] = value.strip()
    return found


def _said(left: TableResidual) -> list[str]:
    rows = left.sentences()
    if left.unit == "rad":
        size, peak = (f"{written(value / ARCSEC, 3)} arcsec" for value in (left.rms, left.peak))
        rows.insert(1, f"that is {size} rms, {peak} peak")
    return rows
