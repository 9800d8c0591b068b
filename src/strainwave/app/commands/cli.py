"""The command `strainwave`: what each subcommand takes and prints. Results go to stdout, everything else to stderr.

Exit codes: 0 ok, 1 the run failed, 2 wrong usage, 3 invalid project file, 130 interrupted. Heavy libraries are
imported inside the commands, so that `--help` answers at once.
"""

import os
import sys
from pathlib import Path
from typing import Any

import click

from ... import __version__
from .analysis.commands import analyze
from .compensation.commands import compensate, compensate_move, compensate_run_up
from .identification.commands import identify, loop_scan, order_scan
from .identification.log import log
from .identification.texts import orders
from .project_files.commands import completion, gear_names, new, schema

FAILED, INVALID_PROJECT, INTERRUPTED = 1, 3, 130
EXPECTED = (
    "SolveError", "ValueError", "TypeError", "RuntimeError", "ModuleNotFoundError", "FileNotFoundError", "Unrecordable",
)  # fmt: skip

json_option = click.option("--json", "as_json", is_flag=True, help="Print the result as JSON.")
retune_option = click.option(
    "--retune", is_flag=True,
    help="Compute gains of a bandwidth and damping of a ratio anew for every drive. Default: once, for the file's.",
)  # fmt: skip
folder_type = click.Path(file_okay=False, path_type=Path)


class Sentences(click.Group):
    """A group whose commands end with one sentence and an exit code, never with a traceback (but for --debug)."""

    def invoke(self, ctx: click.Context) -> Any:
        """Run the subcommand and turn what it raises into a sentence and an exit code."""
        try:
            return super().invoke(ctx)
        except (click.exceptions.Exit, click.ClickException, click.Abort, BrokenPipeError):
            raise
        except KeyboardInterrupt as stop:
            click.echo(f"strainwave: {str(stop) or 'interrupted; nothing was written: run it again'}", err=True)
            ctx.exit(INTERRUPTED)
        except Exception as error:  # whatever it is, a user gets one sentence; --debug shows the rest
            if ctx.params.get("debug") or os.environ.get("STRAINWAVE_DEBUG") == "1":
                raise
            files = sys.modules.get("strainwave.files.yaml_text")
            if files is not None and isinstance(error, files.FileError):
                click.echo(str(error), err=True)
                ctx.exit(INVALID_PROJECT)
            click.echo(f"strainwave: {_sentence(error)}", err=True)
            ctx.exit(FAILED)


def _sentence(error: Exception) -> str:
    """One line that says what went wrong."""
    if isinstance(error, OSError) and error.strerror:
        from ..output import sentence

        return sentence(error)
    text = " ".join(str(error).split()) or type(error).__name__
    name = type(error).__name__
    return text if name in EXPECTED else f"{name}: {text} (this is unexpected; --debug shows where)"


def _known_suffix(_context: click.Context, _option: click.Parameter, output: Path | None) -> Path | None:
    """Refuse a file name whose ending says nothing."""
    if output is not None and output.suffix not in (".csv", ".svg", ".png"):
        raise click.BadParameter(f"{output.name!r} must end in .csv, .svg or .png")
    return output


@click.group(cls=Sentences, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110})
@click.version_option(__version__, prog_name="strainwave")
@click.option("--debug", is_flag=True, help="Show the traceback of an error (also: STRAINWAVE_DEBUG=1).")
def cli(debug: bool) -> None:
    """Nonlinear dynamic error of strain wave gears (harmonic drives).

    Start with `strainwave demo`, then write a project file and run `strainwave analyze PROJECT.yaml -o report`.
    """


@cli.command()
@click.option(
    "-o", "--output", type=folder_type, default=Path("strainwave-demo"), show_default=True, help="Folder for reports."
)
@json_option
def demo(output: Path, as_json: bool) -> None:
    """Analyse the article's drive and a real catalogue drive."""
    from .demo import run

    click.echo(run(output, as_json))


@cli.command()
@click.argument("project", type=click.Path(path_type=Path))
@click.option(
    "-o", "--output", type=click.Path(dir_okay=False, path_type=Path), callback=_known_suffix,
    help="File for the curve: .csv, or .svg or .png for a figure of error and torque.",
)  # fmt: skip
@json_option
def response(project: Path, output: Path | None, as_json: bool) -> None:
    """Follow the pointing error of the whole drive through the project's speeds: stability, folds, jumps."""
    from .response import show

    show(project, output, as_json)


@cli.command()
@click.argument("project", type=click.Path(path_type=Path))
@click.option(
    "--grid", multiple=True, required=True, metavar="PATH=VALUES",
    help='Values of a parameter: LOW:HIGH:COUNT[:log] or V1,V2,..., in SI units or their own ("9 rad/s"); repeatable. '
    "PATH is a parameter of the error equation (omega, J, B, law.K, error.lines.0.amplitude), which is integrated, or "
    "a name of the file (loop.K_p, load.inertia, gear=CSG-40-50,SHG-40-50): then the response of the whole drive.",
)  # fmt: skip
@click.option(
    "--measure", "measures", multiple=True, default=("peak",), show_default=True,
    help="What to keep of every trajectory: peak, rms, mean, extremes, amplitude:K. Repeat it for several.",
)  # fmt: skip
@click.option("--settle", type=click.IntRange(0), default=200, show_default=True, help="Periods before measuring.")
@click.option("--periods", type=click.IntRange(1), default=20, show_default=True, help="Periods of the measures.")
@click.option("-o", "--output", type=folder_type, required=True, help="Store of the results; run again to resume.")
@click.option("--workers", type=click.IntRange(1), help="Threads. Default: one for every processor.")
@click.option(
    "--chunk", type=click.IntRange(1),
    help="Points that are computed and written at a time: what a stopped run loses at most. Default: by their number.",
)  # fmt: skip
@click.option("--cluster", metavar="ADDRESS", help="Scheduler of a dask cluster, for example tcp://127.0.0.1:8786.")
@retune_option
@json_option
def sweep(**given: Any) -> None:
    """Integrate a drive over a grid of its parameters, or follow the response of the whole drive, and keep the results.

    An interrupted sweep keeps what it has finished; the same command again goes on from there.
    """
    from .sweep import show

    show(**given)


@cli.command()
@click.argument("project", type=click.Path(path_type=Path))
@click.option("--count", type=click.IntRange(32, 5000), default=200, show_default=True, help="Drives, each a curve.")
@click.option(
    "--seed", type=click.IntRange(0), default=0, show_default=True, help="The same seed gives the same drives."
)
@click.option("--limit", help='Largest oscillation, for example "60 arcsec". Default: limit.oscillation of the file.')
@retune_option
@json_option
def variability(project: Path, **given: Any) -> None:
    """Say how probable it is that a drive exceeds its limit in its speeds, from the scatter of its numbers."""
    from .variability import show

    show(project, **given)


@cli.command("speed-map")
@click.argument("project", type=click.Path(path_type=Path))
@click.option(
    "-o", "--output", type=folder_type, required=True,
    help="Folder for cells.csv, bands.csv, campbell.csv and speed-map.svg.",
)  # fmt: skip
@click.option("--loads", help='Mean torques on the load, "LOW:HIGH:COUNT" or "V1,V2": "-60 N*m:0 N*m:9".')
@click.option("--load-inertias", "inertias", help='Inertias of the load in place of torques: "1 kg*m^2:3 kg*m^2:9".')
@click.option("--speeds", help='Range of the motor speed, "LOW:HIGH": "500 rpm:4000 rpm". Default: that of the file.')
@click.option("--limit", help='Largest oscillation, for example "60 arcsec". Default: limit.oscillation of the file.')
@click.option("--amplification", type=float, help="Largest oscillation relative to that of quasi-static rotation.")
@click.option("--margin", type=float, help="Separation margin from every resonance, 0.1 for 10 %.")
@click.option("--units", type=click.IntRange(0, 5000), default=0, help="Drives drawn by the scatter of the file.")
@click.option("--seed", type=click.IntRange(0), default=0, show_default=True, help="Seed of these drives.")
@json_option
def speed_map(project: Path, output: Path, **given: Any) -> None:
    """Say which motor speeds are allowed under every load, from all stable motions of the drive."""
    from .speed_map import show

    show(project, output, **given)


@cli.command()
@click.argument("project", type=click.Path(path_type=Path))
@click.argument("profile", nargs=-1)
@click.option("-o", "--output", type=folder_type, required=True, help="Folder for move.csv, move.svg and move.json.")
@click.option("--start", help='Angle of the load at the begin, as "-45 deg".')
@click.option("--payload", help='What the load carries, as "mass: 5 kg, radius: 0.4 m, phase: 90 deg".')
@click.option("--window", help='Largest distance of a settled load from rest, as "30 arcsec".')
@click.option(
    "--band", "bands", nargs=2, multiple=True, metavar="LOW HIGH",
    help='Motor speeds to avoid, as "1200 rpm" "1500 rpm"; repeatable.',
)  # fmt: skip
@click.option("--avoid", is_flag=True, help="Take the speeds to avoid of the analysis too, which takes its time.")
@click.option("--delimiter", default=",", show_default=True, help="Column separator of a CSV profile.")
@click.option("--decimal", default=".", show_default=True, help="Decimal separator of a CSV profile.")
@json_option
def move(
    project: Path, profile: tuple[str, ...], output: Path, as_json: bool, delimiter: str, decimal: str, **options: Any
) -> None:
    """Move the load along PROFILE: pointing error, settling, torques against the ratings, life, energy.

    PROFILE is one part or several, one after the other: a CSV file with the columns time [s] and angle [deg], or fields
    as in the group `move` of a project file: "trapezoid, angle: 90 deg, time: 0.6 s", "s_curve, angle: -90 deg, time:
    0.6 s", "dwell, time: 0.4 s". Without it the profile of the project file is taken.
    """
    from .move import show

    show(project, profile, output, options, {"delimiter": delimiter, "decimal": decimal}, as_json)


@cli.command()
@click.option(
    "--port", type=click.IntRange(0, 65535), default=8765, show_default=True, help="Port; if taken, the next."
)
@click.option("--browser/--no-browser", default=True, help="Whether to open the page in a browser.")
def app(port: int, browser: bool) -> None:
    """Serve the web app on this machine alone: a page with sliders and pictures of a drive."""
    from ..web.command import run

    run(port, browser)


for command in (analyze, completion, new, schema, compensate, compensate_move, compensate_run_up):
    cli.add_command(command)


@cli.command()
@click.argument("specification", type=click.Path(path_type=Path))
@click.option(
    "-o", "--output", type=folder_type, required=True,
    help="Folder for designs.csv, rejected.csv, designs.svg, design.json and the best designs as project files.",
)  # fmt: skip
@json_option
def design(specification: Path, output: Path, as_json: bool) -> None:
    """Search the catalogue for the gears and motors that do what SPECIFICATION asks of an axis."""
    from .design.design import show

    show(specification, output, as_json)


@cli.command()
@click.argument("projects", type=click.Path(path_type=Path), nargs=-1, required=True)
@click.option("-o", "--output", type=folder_type, required=True, help="Folder for comparison.html, .csv and .svg.")
@json_option
def compare(projects: tuple[Path, ...], output: Path, as_json: bool) -> None:
    """Put the response of several project files side by side: one table, one figure."""
    from .design.compare import show

    show(projects, output, as_json)


@cli.command()
@click.argument("project", type=click.Path(path_type=Path))
@click.option(
    "--to", type=click.Choice(("c", "fmu2", "fmu3", "mjcf", "urdf", "mat")), required=True,
    help="C99; FMU of FMI 2.0 or 3.0; a joint for MuJoCo or in URDF; the computed response for MATLAB.",
)  # fmt: skip
@click.option(
    "-o", "--output", type=click.Path(dir_okay=False, path_type=Path), required=True,
    help="File: .c (and .h beside it), .fmu, .xml, .urdf or .mat.",
)  # fmt: skip
@click.option("--step", help='Length of a step of C and FMU, as "250 us". Default: 16 in the shortest time scale.')
@json_option
def export(project: Path, to: str, output: Path, step: str | None, as_json: bool) -> None:
    """Take the motor, the gear and the load of a project to another program."""
    from .exchange.export import show

    show(project, to, output, step, as_json)


@cli.command()
@json_option
def reproduce(as_json: bool) -> None:
    """Compute the article's Tables 3 and 4 again and compare every number."""
    from .reproduction import show

    show(as_json)


@cli.command()
@click.argument("name", required=False, shell_complete=gear_names)
@click.option("--series", help="Only this series, for example CSG.")
@click.option("--size", type=int, help="Only this size.")
@click.option("--ratio", type=int, help="Only this ratio.")
@click.option("--torque", help='Smallest rated torque, for example "100 N*m".')
@click.option("--stiffness", help='Smallest stiffness K1, for example "1e5 N*m/rad".')
@click.option("--speed", help='Smallest limit of the input speed, for example "3000 rpm".')
@click.option(
    "--file", type=click.Path(path_type=Path), help="Gears of your own in YAML or CSV, in place of the catalogue."
)
@json_option
def catalogue(torque: str | None, stiffness: str | None, speed: str | None, **given: Any) -> None:
    """List the gears of the catalogue or of a file, or show one."""
    from .gears import show

    show(least={"torque": torque, "stiffness": stiffness, "speed": speed}, **given)


SHAFTS = click.Choice(("motor", "output"))


@cli.command("error-scan")
@click.argument("file", type=click.Path(path_type=Path))
@click.option("--back", type=click.Path(path_type=Path), help="CSV of the run in the backward direction.")
@click.option("--shaft", type=SHAFTS, default="motor", show_default=True, help="Shaft of the file's angle.")
@click.option("--turn", type=SHAFTS, help="Shaft whose turn the orders count on; the same by default.")
@click.option("--ratio", type=int, help="Ratio of the gear, where --shaft and --turn differ.")
@click.option("--orders", callback=orders, help="Fit these orders, as 1,2,4, in place of a search.")
@click.option("--highest", type=int, help="Highest order sought.")
@click.option("--false-alarm", type=float, default=0.01, show_default=True, help="Probability that noise gives a line.")
@click.option("--angle", default="angle", show_default=True, help='Column of the angle, as "Winkel [deg]".')
@click.option("--error", help='Column of the error, as "Fehler [arcsec]"; "error" or "ate" by default.')
@click.option("--backward", help='Column of the error on the way back; "backward" by default.')
@click.option("--ate", is_flag=True, help="The error is the vendors', output minus motor/ratio.")
@click.option("--delimiter", default=",", show_default=True, help="Column separator.")
@click.option("--decimal", default=".", show_default=True, help="Decimal separator.")
@json_option
def error_scan(
    file: Path, back: Path | None, shaft: Any, turn: Any, ratio: int | None, orders: list[int] | None,
    highest: int | None, false_alarm: float, as_json: bool, **columns: Any,
) -> None:  # fmt: skip
    """Find the lines of a measured kinematic error, with their uncertainty."""
    from .error_scan import show

    search = {"orders": orders, "highest": highest, "false_alarm": false_alarm}
    show(file, back, columns, (shaft, turn, ratio), search, as_json)


cli.add_command(loop_scan)


@cli.command("order-table")
@click.argument("source", metavar="IN", type=click.Path(path_type=Path))
@click.argument("target", metavar="OUT", type=click.Path(dir_okay=False, path_type=Path))
@click.option(
    "--format", "form", required=True,
    help="Format of OUT: json, csv, points, c, st, beckhoff, moteus, linuxcnc, hal, twincat, sinumerik, onstepx.",
)  # fmt: skip
@click.option("--from", "origin", help="Format of IN. Default: recognised by its content.")
@click.option(
    "--option", "options", multiple=True, metavar="KEY=VALUE", help="Option of OUT, as points=360; repeatable."
)
@click.option("--from-option", "known", multiple=True, metavar="KEY=VALUE", help="Option of IN; repeatable.")
@click.option("--ratio", type=float, help="Ratio of the gear, in place of the table's.")
@click.option("--speed", help='Speed of the table\'s shaft at which its delay becomes phase, as "300 rpm".')
@click.option(
    "--one-way", type=click.Choice(("forward", "backward", "mean")),
    help="One set of lines for both directions of motion.",
)  # fmt: skip
@click.option("--drop", is_flag=True, help="Leave out orders that OUT cannot hold, the weakest first.")
@json_option
def order_table(
    source: Path, target: Path, form: str, origin: str | None, options: tuple[str, ...], known: tuple[str, ...],
    as_json: bool, **changes: Any,
) -> None:  # fmt: skip
    """Write the order table IN as OUT in a format of drives and controls, and say what is lost."""
    from .order_tables.convert import show

    show(source, target, (origin, form), (known, options), changes, as_json)


@cli.command()
@json_option
def doctor(as_json: bool) -> None:
    """Report versions, cache, cores, vector units and optional parts."""
    from .doctor import show

    show(as_json)


@cli.command()
@click.option("--latex", is_flag=True, help="Print the equations as LaTeX.")
@json_option
def derive(latex: bool, as_json: bool) -> None:
    """Derive the error equation from Lagrange's equations and print each step."""
    from .derive import show

    show(latex, as_json)


cli.add_command(log)
cli.add_command(order_scan)
cli.add_command(identify)


def main() -> None:
    """Run the command line."""
    cli(prog_name="strainwave")
