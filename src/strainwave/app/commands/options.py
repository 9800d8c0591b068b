"""Arguments and options that several commands take."""

import re
from ast import literal_eval
from collections.abc import Callable
from functools import reduce
from pathlib import Path
from shlex import quote
from typing import Any

import click

file_type = click.Path(path_type=Path)
folder_type = click.Path(file_okay=False, path_type=Path)
written_type = click.Path(dir_okay=False, path_type=Path)

project_argument = click.argument("project", type=file_type)
json_option = click.option("--json", "as_json", is_flag=True, help="Print the result as JSON.")
retune_option = click.option(
    "--retune", is_flag=True,
    help="Compute gains of a bandwidth and damping of a ratio anew for every drive. Default: once, for the file's.",
)  # fmt: skip
limit_option = click.option(
    "--limit", help='Largest oscillation, for example "60 arcsec". Default: limit.oscillation of the file.'
)


# Calls that sentences of the library name, and the options of the commands in their place.
CALLS = (
    (re.compile(r"\bone_way\('(\w+)'\)"), r"--one-way \1"),
    (re.compile(r"\bat_speed\(\.\.\.\)"), "--speed"),
    (re.compile(r"\bkeep\(\.\.\.\) or drop\b"), "--drop"),
    (re.compile(r"\bout with keep\(\.\.\.\)"), "out of the file"),
    (
        re.compile(r"\bstrongest\((\d+)\), or let the weakest be left out with drop\b"),
        "--drop, which leaves out the weakest",
    ),
    (re.compile(r"\bcolumns=\['time', 'load_angle', \.\.\.\]"), "--columns time,load_angle,..."),
    (re.compile(r"\bcolumns=\{'time': \.\.\.\}, or rate\b"), "--column time=..., or --rate"),
    (re.compile(r"\bunits= says"), "--unit says"),
    (re.compile(r"(?<![\w./-])trim=0(?![\w.])"), "--trim 0"),
)
GIVEN = re.compile(r"(?<![\w./-])(unit|column)s=(\{[^{}]*\})")


def in_options(sentence: str, command: click.Command | None = None) -> str:
    """A sentence of the library with options in place of its calls, where the command has these."""
    typed = sentence
    for call, option in CALLS:
        typed = call.sub(option, typed)
    typed = GIVEN.sub(_pairs_as_typed, typed)
    known = None if command is None else {option for one in command.params for option in one.opts}
    named = set(re.findall(r"(?<!\S)--[a-z-]+", typed)) - set(re.findall(r"(?<!\S)--[a-z-]+", sentence))
    return typed if known is None or named <= known else sentence


def _pairs_as_typed(given: re.Match[str]) -> str:
    try:
        typed = [f"--{given[1]} {quote(f'{channel}={value}')}" for channel, value in literal_eval(given[2]).items()]
    except (ValueError, SyntaxError, AttributeError):  # no dictionary: it is no call
        return given[0]
    return " ".join(typed)


def output_option(help: str, **attributes: Any) -> Callable[[Any], Any]:
    """Option -o of a command: a folder, unless `attributes` give another type."""
    return click.option("-o", "--output", help=help, **{"type": folder_type} | attributes)


def together(*options: Callable[[Any], Any]) -> Callable[[Any], Any]:
    """Several options as one decorator."""
    return lambda command: reduce(lambda done, option: option(done), reversed(options), command)


def pairs(_context: click.Context, option: click.Parameter, texts: tuple[str, ...]) -> dict[str, str]:
    """Read CHANNEL=VALUE, repeated."""
    values = {}
    for text in texts:
        name, equal, value = text.partition("=")
        if not (name.strip() and equal and value.strip()):
            example = "points=360" if option.metavar == "KEY=VALUE" else "load_angle=deg"
            raise click.BadParameter(f"{text!r} is not {option.metavar}; write for example {example}")
        values[name.strip()] = value.strip()
    return values


def pairs_option(name: str, variable: str, metavar: str, help: str) -> Callable[[Any], Any]:
    """An option that may be repeated, each time with a pair."""
    return click.option(name, variable, multiple=True, callback=pairs, metavar=metavar, help=help)


dialect_options = together(
    click.option("--delimiter", help='Column separator; " " for any number of blanks. Default: found.'),
    click.option("--decimal", help="Decimal separator. Default: found."),
)
reading_options = together(  # of logs
    pairs_option(
        "--column", "columns", "CHANNEL=COLUMN",
        "Name or place (0 is the first) of the column of a channel: load_angle=pos, torque=3; repeatable.",
    ),
    pairs_option(
        "--unit", "units", "CHANNEL=UNIT",
        'Unit of a channel, as load_angle=deg, or the size of 1: "load_angle=0.088 deg"; repeatable.',
    ),
    click.option("--rate", type=float, help="Samples per second of a file without a time."),
    click.option("--ratio", type=float, help="Ratio of the gear: the log of another one is refused."),
    click.option("--trim", type=float, help="Seconds left out at the begin; 0 keeps all. Default: a transient."),
    dialect_options,
)  # fmt: skip
