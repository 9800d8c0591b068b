"""`strainwave new` and `schema`: a commented project file by questions, and the schema of such files."""

import json
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from shlex import quote
from typing import Any, NamedTuple

import click

from ...base.archive import atomic
from ...base.units import ARCSEC
from ...files.fields.groups import ACCURACY, ASSUMED, UNPRINTED
from ...files.fields.kinds import BANDWIDTH, Entry
from ...files.fields.kinds import number as number_in
from ...files.fields.schema import TITLE
from ...files.reading import from_text
from ...files.reference import NAME, project_schema, reference, template
from ...model.gears.catalogue import gear, names
from ...model.gears.gear import SPECIAL
from ..console import to_json
from ..console.terminal import echo
from .options import names_as_typed, output_option, together, written_type

MOST_SHOWN = 12  # gears in a complaint
NEW_RPM = 3000.0  # rpm of a new file
STOPPED = "interrupted; nothing was written"
NONE = "none"


class Question(NamedTuple):
    """One number or word of a new project file.

    Attributes
    ----------
    name, prompt, unit : str
        Name of the option and the question, and the unit in which it is answered.
    default : str
        Answer of an empty input; "" where an answer is needed. Only a terminal asks for one with a default.
    sentence : str
        Meaning of the answer.
    """

    name: str
    prompt: str
    unit: str
    default: str
    sentence: str

    @property
    def option(self) -> str:
        """The option that gives the answer."""
        return "--" + self.name.replace("_", "-")

    @property
    def help(self) -> str:
        """The sentence with the unit and the default."""
        unit = f" [{self.unit}]" if self.unit else ""
        return self.sentence + unit + (f" Default: {self.default}." if self.default else "")


QUESTIONS = (
    Question("title", "Title", "", NONE, "Title of the report, one line; none uses the file name."),
    Question("gear", "Gear", "", "", "Name of a gear in the catalogue; part of a name lists the gears with it."),
    Question("load_inertia", "Inertia of the load", "kg*m^2", "", "Inertia on the output side, without the gear."),
    Question(
        "motor_inertia", "Inertia of the motor", "kg*cm^2", "catalogue",
        "Inertia of motor and wave generator, motor side; catalogue uses the wave generator alone.",
    ),
    Question(
        "loop", "Loop of the motor", "Hz", "30 Hz",
        "Bandwidth of the cascaded position loop; none assumes a motor with exactly constant speed.",
    ),
    Question("gravity", "Gravity", "N*m", NONE, "Gravity torque with the arm horizontal, on the output side."),
    Question(
        "accuracy", "Accuracy of the gear", "arcsec", "catalogue",
        "Accuracy class of the gear, peak-to-peak; special is that of a selected gear; "
        f"if the catalogue has none, {UNPRINTED} are assumed."),
    Question(
        "kinematic_error", "Kinematic error", "arcsec", "catalogue",
        "Amplitude at order 2 of the motor, 0-to-peak; catalogue divides the accuracy class among the usual orders.",
    ),
    Question("damping", "Damping ratio", "%", "3 %", "Fraction of critical damping; 1 to 5 % are usual."),
    Question(
        "budget", "Limit of the oscillation", "arcsec", "catalogue",
        "Limit of the pointing error about its mean, 0-to-peak; catalogue uses the accuracy class (peak-to-peak), "
        "1.54 times the error at very low speed; none sets no limit.",
    ),
    Question("speed_from", "Lowest speed", "rpm", "500 rpm", "Lowest speed of the motor."),
    Question("speed_to", "Highest speed", "rpm", "catalogue",
        "Highest speed of the motor; catalogue uses the gear's largest average speed, at most 3000 rpm."),
)  # fmt: skip


KINDS = {"loop": BANDWIDTH, "accuracy": ACCURACY}
SI_UNITS = dict.fromkeys(("load_inertia", "motor_inertia"), "kg*m**2") | {"gravity": "N*m", "damping": ""}
SI_UNITS |= dict.fromkeys(("speed_from", "speed_to"), "rad/s")  # rad of the others


def _option(question: Question) -> Callable[[Any], Any]:
    """The option that answers a question."""
    complete: dict[str, Any] = {"shell_complete": names_as_typed} if question.name == "gear" else {}
    return click.option(question.option, question.name, help=question.help, **complete)


@click.command()
@together(*map(_option, QUESTIONS))
@output_option("Project file to write.", type=written_type, default=Path("drive.yaml"))
@click.option("--force", is_flag=True, help="Overwrite an existing file.")
def new(output: Path, force: bool, **options: str | None) -> None:
    """Write a commented project file.

    On a terminal the command asks for each number without an option; Enter accepts the default.
    """
    if output.exists() and not force:
        raise click.UsageError(f"{output} exists; use --force to replace it, or choose another name with -o")
    if output.exists() and not output.is_file():
        raise click.UsageError(f"{output} is not an ordinary file and is not replaced; choose another name with -o")
    output = output.resolve() if output.is_symlink() else output
    if not output.parent.is_dir():
        raise click.UsageError(f"there is no folder {output.parent}; create it, or choose another name with -o")
    answers = _answers(options)
    fields = _fields(answers) | {"sources": _assumed(options, answers)}
    text = template(fields, NAME if (output.parent / NAME).is_file() else "")
    project = from_text(text, output)
    with atomic(output) as part:
        Path(part).write_text(text, encoding="utf-8", newline="\n")
    for note in project.notes:
        echo(f"note: {note}", err=True)
    echo(f"{output} is written; strainwave analyze {quote(str(output))} -o report computes it")


@click.command()
@click.option("--markdown", is_flag=True, help="Print the reference of all fields as Markdown instead.")
def schema(markdown: bool) -> None:
    """Print the JSON Schema of the project file, for editors."""
    click.echo(reference() if markdown else to_json(project_schema()), nl=not markdown)


def _answers(options: Mapping[str, str | None]) -> dict[str, str]:
    asking = sys.stdin.isatty()
    missing = [q.option for q in QUESTIONS if options.get(q.name) is None and not q.default]
    if missing and not asking:
        raise click.UsageError(f"{' and '.join(missing)} must be given when the command does not run on a terminal")
    answers: dict[str, str] = {}
    for question in QUESTIONS:
        value = options.get(question.name)
        instead = {"kinematic_error": answers.get("accuracy"), "accuracy": options.get("kinematic_error")}
        if value is None and asking and not instead.get(question.name):
            answers[question.name] = _ask(question, answers)
            continue
        try:
            answers[question.name] = _read(question, question.default if value is None else value, answers)
        except ValueError as error:
            option = question.option if value is not None else f"{question.option} must be given"
            raise click.UsageError(f"{option}: {error}") from None
    return answers


def _ask(question: Question, answers: dict[str, str]) -> str:
    """Ask until the answer can be used."""
    echo(f"\n{question.sentence}", err=True)
    unit = f" [{question.unit}]" if question.unit else ""
    default = f" ({question.default})" if question.default else ""
    while True:
        try:
            typed = click.prompt(f"{question.prompt}{unit}{default}", default="", show_default=False, err=True)
            return _read(question, typed.strip() or question.default, answers)
        except click.Abort:
            raise KeyboardInterrupt(STOPPED) from None
        except ValueError as error:
            echo(f"  {error}", err=True)


def _read(question: Question, text: str, answers: dict[str, str]) -> str:
    """The answer as the file holds it; "" for none (ValueError with one sentence)."""
    name = question.name
    if name == "gear":
        return _gear(text)
    if name == "title":
        return str(TITLE.read("" if text == NONE else text, Entry((), [])))
    if text == NONE and (question.default == NONE or name in ("loop", "budget")):
        return ""
    if text == "catalogue" and question.default == "catalogue":
        text = _of_catalogue(name, answers)
        if name != "speed_to":
            return text
    text = _with_unit(text, question.unit)
    _check(name, text, answers)
    return text


def _check(name: str, text: str, answers: dict[str, str]) -> None:
    """Check an answer by its kind, the gear and the answers before it (ValueError with one sentence)."""
    if name == "kinematic_error" and answers["accuracy"]:
        raise ValueError(f"{text!r} and --accuracy both set the size of the kinematic error; use one of them")
    if name in KINDS:
        KINDS[name].read(text, Entry((), []))
        if text == SPECIAL and gear(answers["gear"]).special_accuracy is None:
            raise ValueError(f"the catalogue has no special accuracy of {answers['gear']}; write it in arcsec")
        return
    value = number_in(text, SI_UNITS.get(name, "rad"), "not negative" if name == "speed_from" else "positive")
    least = gear(answers["gear"]).input_inertia if name == "motor_inertia" else None
    if least is not None and value < (1.0 - 1e-6) * least:
        of = f"the wave generator of {answers['gear']} alone, {1e4 * least:g} kg*cm^2"
        raise ValueError(f"{text!r} is less than the inertia of {of}; write the sum for motor and wave generator")
    if name == "speed_to" and value <= number_in(answers["speed_from"], "rad/s"):
        raise ValueError(f"{text!r} is not above the lowest speed, {answers['speed_from']}; write a larger speed")


def _with_unit(text: str, unit: str) -> str:
    """The text, with the unit of the question where it is a number alone."""
    try:
        float(text)
    except ValueError:
        return text
    return f"{text} {unit}"


def _gear(text: str) -> str:
    """Name of a gear of the catalogue (ValueError with those that a part of a name is of, or the nearest)."""
    if not text:
        raise ValueError("a gear is needed; write for example CSG-40-50, or a part of a name as CSG-40")
    try:
        return gear(text).name
    except ValueError as error:
        begin = "-".join(text.upper().replace("-", " ").split())
        matches = [name for name in names() if f"-{begin}-" in f"-{name}-" or name.startswith(begin)]
        if not matches:
            raise ValueError(str(error)) from None
        others = f" and {len(matches) - MOST_SHOWN} more" if len(matches) > MOST_SHOWN else ""
        some = f"{', '.join(matches[:MOST_SHOWN])}{others}"
        raise ValueError(f"{text!r} is a part of {some}; write the whole name") from None


def _assumed(options: Mapping[str, str | None], answers: dict[str, str]) -> str:
    """The sources of the groups that have a default."""
    groups = {"loop": "motor.loop", "damping": "damping", "budget": "limit"}
    groups |= {"speed_from": "speed.from", "speed_to": "speed.to"}
    asked = [q for q in QUESTIONS if q.name in groups and options.get(q.name) is None]
    usual = [q.name for q in asked if answers[q.name] and answers[q.name] == _read(q, q.default, answers)]
    unprinted = not answers["accuracy"] and _accuracy(answers) == UNPRINTED
    names_of = [*(groups[name] for name in usual), *["excitation.accuracy"] * unprinted]
    return f"{{{', '.join(f'{name}: {ASSUMED}' for name in names_of)}}}" if names_of else ""


def _accuracy(answers: dict[str, str]) -> str:
    """The accuracy that the file has: the answer, that of the catalogue, or the assumed one; "" beside an amplitude."""
    if answers["kinematic_error"] != "catalogue":
        return ""
    return answers["accuracy"] or ("catalogue" if gear(answers["gear"]).accuracy else UNPRINTED)


def _of_catalogue(name: str, answers: dict[str, str]) -> str:
    """Field of a project file that takes a number of the catalogue (ValueError if the catalogue lacks the number)."""
    gear_name = answers["gear"]
    record = gear(gear_name)
    if name == "motor_inertia" and record.input_inertia is None:
        raise ValueError(f"the catalogue has no inertia of the wave generator of {gear_name}; write it in kg*cm^2")
    if name in ("accuracy", "motor_inertia"):
        return ""  # an accuracy is of use where kinematic error or budget follow from it
    if name == "speed_to":
        return f"{min(NEW_RPM, record.average_rpm or NEW_RPM):g} rpm"
    if answers["accuracy"] == SPECIAL and name == "budget":
        return f"{(record.special_accuracy or 0.0) / ARCSEC:.3g} arcsec"
    if name == "kinematic_error":
        return "catalogue"
    return answers["accuracy"] or (UNPRINTED if record.accuracy is None else f"{record.accuracy / ARCSEC:.3g} arcsec")


def _fields(answers: dict[str, str]) -> dict[str, str]:
    """Fields of a project file by their paths; empty ones are left as examples."""
    error = answers["kinematic_error"]
    loop, gravity = answers["loop"], answers["gravity"]
    return {
        "title": json.dumps(answers["title"], ensure_ascii=False) if answers["title"] else "",
        "gear": answers["gear"],
        "motor.inertia": answers["motor_inertia"],
        "motor.mode": "" if loop else "held",
        "motor.loop": f"{{type: cascade, bandwidth: {loop}, damping: 0.7}}" if loop else "",
        "load.inertia": answers["load_inertia"],
        "load.drag": f"{{type: angle_torque, amplitude: {gravity}}}" if gravity else "",
        "damping.ratio": answers["damping"],
        "speed.from": answers["speed_from"],
        "speed.to": answers["speed_to"],
        "speed.shaft": "motor",
        "excitation.kinematic_error": "" if error == "catalogue" else f"[{{order: 2, amplitude: {error}}}]",
        "excitation.accuracy": _accuracy(answers),
        "limit.oscillation": answers["budget"],
    }
