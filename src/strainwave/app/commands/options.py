"""Arguments and options that several commands take."""

from collections.abc import Callable
from functools import reduce
from pathlib import Path
from typing import Any

import click

file_type = click.Path(path_type=Path)
folder_type = click.Path(file_okay=False, path_type=Path)
written_type = click.Path(dir_okay=False, path_type=Path)

project_argument = click.argument("project", type=file_type)
json_option = click.option("--json", "as_json", is_flag=True, help="Print the result as JSON.")
retune_option = click.option(
    "--retune", is_flag=True,
    help="Recompute the gains from the bandwidth, and the damping from its ratio, for every drive. Default: once.",
)  # fmt: skip
limit_option = click.option(
    "--limit", help='Largest oscillation, for example "60 arcsec". Default: limit.oscillation in the project file.'
)


def output_option(help: str, *endings: str, **attributes: Any) -> Callable[[Any], Any]:
    """Option -o of a command: a folder, unless `attributes` give another type, or a file with one of some endings.

    A place that cannot be written is refused before anything is computed.
    """
    kind = attributes.pop("type", written_type if endings else folder_type)

    def writable(_context: click.Context, _option: click.Parameter, output: Path | None) -> Path | None:
        if output is not None:
            if endings and output.suffix not in endings:
                raise click.BadParameter(f"{output.name!r} must end in {', '.join(endings[:-1])} or {endings[-1]}")
            from ..console.output_files import check_writable

            check_writable(*([output] if kind is folder_type else [output.parent, output.name]))
        return output

    return click.option("-o", "--output", help=help, type=kind, callback=writable, **attributes)


def together(*options: Callable[[Any], Any]) -> Callable[[Any], Any]:
    """Several options as one decorator."""
    return lambda command: reduce(lambda done, option: option(done), reversed(options), command)


def pairs(_context: click.Context, option: click.Parameter, texts: tuple[str, ...]) -> dict[str, str]:
    """Read CHANNEL=VALUE, repeated."""
    values = {}
    for text in texts:
        name, equal, value = text.partition("=")
        if not (name.strip() and equal and value.strip()):
            raise click.BadParameter(f"{text!r} is not {option.metavar}; write for example load_angle=deg")
        values[name.strip()] = value.strip()
    return values


def pairs_option(name: str, variable: str, metavar: str, help: str) -> Callable[[Any], Any]:
    """An option that may be repeated, each time with a pair."""
    return click.option(name, variable, multiple=True, callback=pairs, metavar=metavar, help=help)


def names_as_typed(_ctx: click.Context, _option: click.Parameter, typed: str) -> list[str]:
    """Names of the catalogue that begin as typed, for the completion of a shell."""
    from ...model.gears.catalogue import names

    return [name for name in names() if name.startswith(typed.upper())]


def _listed(context: click.Context, _option: click.Parameter, text: str | None) -> None:
    """Keep a name for each column for `_columns`."""
    context.meta["columns"] = text and [None if name.strip() in ("-", "") else name.strip() for name in text.split(",")]


def _columns(context: click.Context, option: click.Parameter, texts: tuple[str, ...]) -> Any:
    """All columns in their order, or some by their names or places; None where no option says."""
    some = pairs(context, option, texts)
    if some and context.meta["columns"]:
        raise click.UsageError("--columns names all columns and --column some of them; use only one of the two")
    return context.meta["columns"] or some or None


dialect_options = together(
    click.option("--delimiter", help='Column separator; " " for any number of blanks. Default: detected.'),
    click.option("--decimal", help="Decimal separator. Default: detected."),
)
reading_options = together(  # of logs
    click.option(
        "--columns", "names", callback=_listed, is_eager=True, expose_value=False,
        help='Names of all columns in order, for example "time,load_angle,-,torque"; - omits a column.',
    ),
    click.option(
        "--column", "columns", multiple=True, callback=_columns, metavar="CHANNEL=COLUMN",
        help="Name or index (from 0) of the column of a channel: load_angle=pos, torque=3; repeatable.",
    ),
    click.option("--joint", help="Text in the column names of one joint of several: elbow, axis0, 1."),
    pairs_option(
        "--unit", "units", "CHANNEL=UNIT",
        'Unit of a channel, as load_angle=deg, or the size of one count: "load_angle=0.088 deg"; repeatable.',
    ),
    click.option("--rate", type=float, help="Samples per second of a file without a time column."),
    click.option("--ratio", type=float, help="Ratio of the gear; a log with another ratio is refused."),
    click.option("--trim", type=float, help="Seconds removed at the start; 0 keeps all. Default: the transient."),
    dialect_options,
)  # fmt: skip


def quantity(option: str, text: str, unit: str, sign: str = "any") -> float:
    """Read a quantity that an option of the command line gives, in a unit of SI, or refuse it (click.BadParameter).

    `sign` is "any", "positive" or "not negative".
    """
    from ...files.fields.kinds import number as number_in

    try:
        return number_in(text, unit, sign)
    except ValueError as error:
        raise click.BadParameter(f"{option}: {error}") from None


def span(
    option: str, ends: list[str] | tuple[str, ...], unit: str, example: str, sign: str = "not negative"
) -> tuple[float, float]:  # fmt: skip
    """Read a range that an option gives by its two ends, or refuse it (click.BadParameter)."""
    values = [quantity(option, end, unit, sign) for end in ends]
    if len(values) != 2 or not values[0] < values[1]:
        text = " to ".join(repr(end) for end in ends)
        raise click.BadParameter(f"{option}: {text} is not a range; write a smaller and a larger value, {example}")
    return values[0], values[1]
