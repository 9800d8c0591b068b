"""`strainwave new`: a commented project file from the answers to a few questions."""

import json
import sys
from collections.abc import Mapping
from pathlib import Path
from shlex import quote

import click

from ....archive import atomic
from ....files.entries import number
from ....files.loop_fields import bandwidth
from ....files.reading import from_text
from ....files.reference.json_schema import NAME
from ....files.reference.template import template
from ....files.schema import read_title
from ....model.gears import catalogue
from .questions import NONE, QUESTIONS, Question

MOST_SHOWN = 12  # gears
STOPPED = "interrupted; nothing was written"


def show(output: Path, force: bool, given: Mapping[str, str | None]) -> None:
    """Write a project file from what the options give and, on a terminal, from answers.

    Raises
    ------
    click.UsageError
        If the file exists, an option has a bad value, or one is missing and nobody can be asked.
    ProjectError
        If the answers contradict each other.
    KeyboardInterrupt
        If the user stops; nothing is written.
    """
    if output.exists() and not force:
        raise click.UsageError(f"{output} exists; take --force to replace it, or another name with -o")
    if output.exists() and not output.is_file():
        raise click.UsageError(f"{output} is no ordinary file and is not replaced; take another name with -o")
    output = output.resolve() if output.is_symlink() else output
    if not output.parent.is_dir():
        raise click.UsageError(f"there is no folder {output.parent}; make it, or take another name with -o")
    answers = _answers(given)
    text = template(_fields(answers), NAME if (output.parent / NAME).is_file() else "")
    project = from_text(text, output)
    with atomic(output) as part:
        Path(part).write_text(text, encoding="utf-8", newline="\n")
    for note in project.notes:
        click.echo(f"note: {note}", err=True)
    click.echo(f"{output} is written; strainwave analyze {quote(str(output))} -o report computes it")


def _answers(given: Mapping[str, str | None]) -> dict[str, str]:
    asking = sys.stdin.isatty()
    missing = [q.option for q in QUESTIONS if given.get(q.name) is None and not q.default]
    if missing and not asking:
        raise click.UsageError(f"{' and '.join(missing)} must be given, where no terminal can be asked")
    answers: dict[str, str] = {}
    for question in QUESTIONS:
        value = given.get(question.name)
        if value is None and asking:
            answers[question.name] = _ask(question, answers)
            continue
        try:
            answers[question.name] = _read(question, question.default if value is None else value, answers)
        except ValueError as error:
            if value is not None:
                raise click.UsageError(f"{question.option}: {error}") from None
            raise click.UsageError(f"{question.option} must be given: {error}") from None
    return answers


def _ask(question: Question, answers: dict[str, str]) -> str:
    """Ask until the answer can be used."""
    click.echo(f"\n{question.sentence}", err=True)
    unit = f" [{question.unit}]" if question.unit else ""
    default = f" ({question.default})" if question.default else ""
    while True:
        try:
            typed = click.prompt(f"{question.prompt}{unit}{default}", default="", show_default=False, err=True)
            return _read(question, typed.strip() or question.default, answers)
        except click.Abort:
            raise KeyboardInterrupt(STOPPED) from None
        except ValueError as error:
            click.echo(f"  {error}", err=True)


def _read(question: Question, text: str, answers: dict[str, str]) -> str:
    """The answer as the file holds it; "" for none (ValueError with one sentence)."""
    name = question.name
    if name == "gear":
        return _gear(text)
    if name == "title":
        title: str = read_title("" if text == NONE else text)
        return title
    if text == NONE and question.default == NONE:
        return ""
    if text == "catalogue" and question.default == "catalogue":
        return _of_catalogue(name, answers["gear"])
    text = _with_unit(text, question.unit)
    if name == "loop":
        bandwidth(text)
    else:
        unit = {"load_inertia": "kg*m**2", "motor_inertia": "kg*m**2", "gravity": "N*m", "damping": ""}.get(name, "rad")
        unit = "rad/s" if name.startswith("speed") else unit
        value = number(text, unit, "not negative" if name == "speed_from" else "positive")
        if name == "speed_to" and value <= number(answers["speed_from"], "rad/s"):
            raise ValueError(f"{text!r} is not above the lowest speed, {answers['speed_from']}; write a larger speed")
    return text


def _with_unit(text: str, unit: str) -> str:
    """The text, with the unit of the question where it is a number alone."""
    try:
        float(text)
    except ValueError:
        return text
    return f"{text} {unit}"


def _gear(text: str) -> str:
    """Name of the one gear that a text means (ValueError with those that hold it)."""
    if not text:
        raise ValueError("a gear is needed; write for example CSG-40-50, or a part of a name as CSG-40")
    try:
        return catalogue.gear(text).name
    except ValueError as error:
        parts = text.upper().replace("-", " ").split()
        found = [name for name in catalogue.names() if all(part in name for part in parts)]
        if not found:
            raise ValueError(str(error)) from None
        if len(found) == 1:
            return found[0]
        more = f" and {len(found) - MOST_SHOWN} more" if len(found) > MOST_SHOWN else ""
        raise ValueError(f"{text!r} is a part of {', '.join(found[:MOST_SHOWN])}{more}; write one of them") from None


def _of_catalogue(name: str, gear: str) -> str:
    """What the record of a gear gives: "" for its inertia, the word for its accuracy (ValueError if it has none)."""
    record = catalogue.gear(gear)
    if name == "motor_inertia":
        if record.input_inertia is None:
            raise ValueError(f"the catalogue has no inertia of the wave generator of {gear}; write it in kg*cm^2")
        return ""
    if record.accuracy is None:
        raise ValueError(f"the catalogue has no accuracy of {gear}; write the amplitude of order 2 in arcsec")
    return "catalogue"


def _fields(answers: dict[str, str]) -> dict[str, str]:
    """Fields of a project file by their paths; empty ones are left as examples."""
    error = answers["kinematic_error"]
    loop, gravity = answers["loop"], answers["gravity"]
    return {
        "title": json.dumps(answers["title"], ensure_ascii=False) if answers["title"] else "",
        "gear": answers["gear"],
        "motor.inertia": answers["motor_inertia"],
        "motor.mode": "" if loop else "held",
        "motor.loop": f"{{type: position, bandwidth: {loop}, damping: 0.7}}" if loop else "",
        "load.inertia": answers["load_inertia"],
        "load.drag": f"{{type: angle_torque, amplitude: {gravity}}}" if gravity else "",
        "damping.ratio": answers["damping"],
        "speed.from": answers["speed_from"],
        "speed.to": answers["speed_to"],
        "speed.shaft": "motor",
        "excitation.kinematic_error": "" if error == "catalogue" else f"[{{order: 2, amplitude: {error}}}]",
        "excitation.accuracy": error if error == "catalogue" else "",
        "limit.oscillation": answers["budget"],
    }
