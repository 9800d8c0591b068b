"""`strainwave new`, `schema` and `catalogue`: a commented project file by questions, its schema, and gears."""

import json
import sys
from collections.abc import Callable, Mapping
from dataclasses import asdict
from pathlib import Path
from shlex import quote
from typing import Any, NamedTuple

import click

from ...base.archive import atomic
from ...base.units import ARCSEC
from ...files.fields.groups import ACCURACY, ASSUMED, UNPRINTED
from ...files.fields.json_schema import NAME, project_schema
from ...files.fields.kinds import BANDWIDTH, Entry
from ...files.fields.kinds import number as number_in
from ...files.fields.schema import TITLE
from ...files.fields.template import template
from ...files.own_gears import read_gears
from ...files.reading import from_text
from ...files.reference import reference
from ...model.gears.catalogue import gear, names, select
from ...model.gears.gear import NUMBERS, SPECIAL, Gear
from ...model.orders import TURNING_SPLINE, USUAL
from ..console import echo, number, print_table, to_json
from ..view import quantity
from .options import file_type, json_option, output_option, together, written_type

MOST_SHOWN = 12  # gears
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
    Question("title", "Title", "", NONE, "One line above the report; none takes the name of the file."),
    Question("gear", "Gear", "", "", "Name of a gear of the catalogue; a part of a name lists those that hold it."),
    Question("load_inertia", "Inertia of the load", "kg*m^2", "", "On the output side, without the gear."),
    Question(
        "motor_inertia", "Inertia of the motor", "kg*cm^2", "catalogue",
        "Motor and wave generator, on the motor side; catalogue takes that of the wave generator alone.",
    ),
    Question(
        "loop", "Loop of the motor", "Hz", "30 Hz",
        "Bandwidth of the cascade that holds the motor; none is a motor that keeps its speed ideally.",
    ),
    Question("gravity", "Gravity", "N*m", NONE, "Torque of the load's weight on a level arm, on the output side."),
    Question(
        "accuracy", "Accuracy of the gear", "arcsec", "catalogue",
        "Accuracy class of the gear, peak-to-peak; special: a selected gear; "
        f"without one in the catalogue {UNPRINTED} are assumed."),
    Question(
        "kinematic_error", "Kinematic error", "arcsec", "catalogue",
        "Amplitude of order 2 of the motor, 0-to-peak; catalogue shares the gear's accuracy by the usual orders.",
    ),
    Question("damping", "Damping ratio", "%", "3 %", "Share of the critical damping; 1 to 5 % are usual."),
    Question(
        "budget", "Budget of the oscillation", "arcsec", "catalogue",
        "Largest distance of the pointing error from its mean; catalogue takes the accuracy class, peak-to-peak, which "
        "is 1.54 times the error in slow rotation; none takes no limit.",
    ),
    Question("speed_from", "Lowest speed", "rpm", "500 rpm", "Of the motor."),
    Question("speed_to", "Highest speed", "rpm", "catalogue",
        "Of the motor; catalogue takes the gear's largest average, at most 3000 rpm."),
)  # fmt: skip


KINDS = {"loop": BANDWIDTH, "accuracy": ACCURACY}


def names_as_typed(_ctx: click.Context, _option: click.Parameter, typed: str) -> list[str]:
    """Names of the catalogue that begin as typed."""
    return [name for name in names() if name.startswith(typed.upper())]


def _option(question: Question) -> Callable[[Any], Any]:
    """The option that answers a question."""
    complete: dict[str, Any] = {"shell_complete": names_as_typed} if question.name == "gear" else {}
    return click.option(question.option, question.name, help=question.help, **complete)


@click.command()
@together(*map(_option, QUESTIONS))
@output_option("Project file to write.", type=written_type, default=Path("drive.yaml"))
@click.option("--force", is_flag=True, help="Replace a file that exists.")
def new(output: Path, force: bool, **options: str | None) -> None:
    """Write a commented project file.

    On a terminal every number that no option gives is a question; Enter takes its default.
    """
    if output.exists() and not force:
        raise click.UsageError(f"{output} exists; take --force to replace it, or another name with -o")
    if output.exists() and not output.is_file():
        raise click.UsageError(f"{output} is no ordinary file and is not replaced; take another name with -o")
    output = output.resolve() if output.is_symlink() else output
    if not output.parent.is_dir():
        raise click.UsageError(f"there is no folder {output.parent}; make it, or take another name with -o")
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
        raise click.UsageError(f"{' and '.join(missing)} must be given, where no terminal can be asked")
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
    if name == "kinematic_error" and answers["accuracy"]:
        raise ValueError(f"{text!r} and --accuracy both give the size of the error; give one of them")
    if name in KINDS:
        KINDS[name].read(text, Entry((), []))
        if text == SPECIAL and gear(answers["gear"]).special_accuracy is None:
            raise ValueError(f"the catalogue has no special accuracy of {answers['gear']}; write it in arcsec")
    else:
        unit = {"load_inertia": "kg*m**2", "motor_inertia": "kg*m**2", "gravity": "N*m", "damping": ""}.get(name, "rad")
        unit = "rad/s" if name.startswith("speed") else unit
        value = number_in(text, unit, "not negative" if name == "speed_from" else "positive")
        least = gear(answers["gear"]).input_inertia if name == "motor_inertia" else None
        if least is not None and value < (1.0 - 1e-6) * least:
            of = f"the wave generator of {answers['gear']} alone, {1e4 * least:g} kg*cm^2"
            raise ValueError(f"{text!r} is less than that of {of}; write that of motor and wave generator together")
        if name == "speed_to" and value <= number_in(answers["speed_from"], "rad/s"):
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
        raise ValueError(f"no gear of {where} meets all conditions; it has {len(gears)} gears of the series {listed}")
    if as_json:
        click.echo(to_json({"units": NUMBERS, "gears": [asdict(g) for g in chosen]}))
        return
    columns = ("gear", "K1", "K2", "K3", "T1", "T2", "rated", "rpm")  # 80 letters wide with the longest name
    fields = ("K1", "K2", "K3", "T1", "T2", "rated_torque", "max_rpm")
    rows = [(_marked(g), *(getattr(g, field) for field in fields)) for g in chosen]
    caption = (
        "K in N·m/rad, T and rated torque in N·m; largest speed with grease; – is not tabulated; * a doubtful number; "
        "`strainwave catalogue NAME` shows the rest"
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
        click.echo(f"{'arrangement':<22}{arrangement}: ratio {abs(ratio)}, {sense} the motor ({how})")
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
