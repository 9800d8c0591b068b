"""The command `strainwave`. Results go to stdout, everything else to stderr.

Exit codes: 0 ok, 1 the run failed, 2 wrong usage, 3 invalid project file, 130 interrupted. A command is one file, which
COMMANDS names; it is imported where the command is called, so that `--help` answers at once.
"""

import os
import sys
from typing import Any

import click
from click.shell_completion import CompletionItem, add_completion_class

from ... import __version__
from ...base.above import thing
from .exchange.completion import PowerShellComplete

FAILED, INVALID_PROJECT, INTERRUPTED = 1, 3, 130
EXPECTED = (
    "SolveError", "ValueError", "TypeError", "RuntimeError", "ModuleNotFoundError", "FileNotFoundError", "Unrecordable",
)  # fmt: skip

# Module below this folder, and what `--help` says: the first sentence of the command's own help.
COMMANDS = {
    "analyze": ("analyze", "Analyse the drives of project files and write a report of each."),
    "app": ("app",
        "Serve the web app on this machine alone: a page with sliders and pictures of a drive."),
    "catalogue": ("exchange.catalogue",
        "List the gears of the catalogue or of a file, or show one."),
    "compare": ("compare",
        "Put the response of several project files side by side: one table, one figure."),
    "compensate": ("compensation.compensate",
        "Cancel the error with controllers designed on the project, each in closed loop against the plain loop."),
    "compensate-move": ("compensation.on_the_way",
        "Move the load along PROFILE in closed loop, under several controllers and with shaped references."),
    "compensate-run-up": ("compensation.on_the_way",
        "Run through a range of speeds and back in closed loop: largest errors, and whether the drive still jumps."),
    "completion": ("exchange.completion",
        "Print a script that completes commands, options, gears and files in SHELL."),
    "demo": ("analyze", "Analyse the article's drive and a real catalogue drive."),
    "derive": ("article",
        "Derive the error equation from Lagrange's equations and print each step."),
    "design": ("design",
        "Search the catalogue for the gears and motors that do what SPECIFICATION asks of an axis."),
    "doctor": ("doctor", "Report versions, cache, cores, vector units and optional parts."),
    "error-scan": ("identification.error_scan",
        "Find the lines of a measured kinematic error, with their uncertainty."),
    "export": ("exchange.export",
        "Take the motor, the gear and the load of a project to another program."),
    "identify": ("identification.identify",
        "Find numbers of a drive from logs of the angles of its motor and its load."),
    "log": ("identification.log",
        "Read a log of measured channels and say what is in it: units, rate, gaps, segments, doubts."),
    "loop-scan": ("identification.loop_scan",
        "Identify the torsion law of a gear from a measured loop of torque over torsion, with intervals of 95 %."),
    "move": ("move",
        "Move the load along PROFILE: pointing error, settling, torques against the ratings, life, energy."),
    "new": ("exchange.new", "Write a commented project file."),
    "order-scan": ("identification.order_scan",
        "Find the orders of a quantity that was logged while a shaft turned, and tell orders from frequencies."),
    "order-table": ("exchange.order_table",
        "Write the order table IN as OUT in a format of drives and controls, and say what is lost."),
    "reproduce": ("article",
        "Compute the article's Tables 3 and 4 again and compare every number."),
    "response": ("response",
        "Follow the pointing error of the whole drive through the project's speeds: stability, folds, jumps."),
    "schema": ("exchange.new", "Print the JSON Schema of the project file, for editors."),
    "speed-map": ("speed_map",
        "Say which motor speeds are allowed under every load, from all stable motions of the drive."),
    "sweep": ("sweep",
        "Integrate a drive over a grid of its parameters, or follow the response of the whole drive, and "
        "keep the results."),
    "variability": ("variability",
        "Say how probable it is that a drive exceeds its limit in its speeds, from the scatter of its numbers."),
}  # fmt: skip


class Sentences(click.Group):
    """The group of COMMANDS. They end with one sentence and an exit code, never with a traceback (but for --debug)."""

    def get_command(self, _ctx: click.Context, cmd_name: str) -> click.Command | None:
        """The command of a name, its module imported; None of a name that is none."""
        if cmd_name not in COMMANDS:
            return None
        module, _ = COMMANDS[cmd_name]
        command: click.Command = thing(f"{__package__}.{module}", cmd_name.replace("-", "_"))
        return command

    def format_commands(self, _ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write names and sentences of all commands, none of them imported."""
        with formatter.section("Commands"):
            formatter.write_dl([(name, sentence) for name, (_, sentence) in COMMANDS.items()])

    def shell_complete(self, ctx: click.Context, incomplete: str) -> list[CompletionItem]:
        """Names of commands and options that begin as typed, no command imported."""
        names = [name for name in COMMANDS if name.startswith(incomplete)]
        options = click.Command.shell_complete(self, ctx, incomplete)
        return [*(CompletionItem(name, help=COMMANDS[name][1]) for name in names), *options]

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


@click.group(
    cls=Sentences,
    commands=dict.fromkeys(COMMANDS, click.Command(None)),  # for `Did you mean`
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110, "show_default": True},
)
@click.version_option(__version__, prog_name="strainwave")
@click.option("--debug", is_flag=True, help="Show the traceback of an error (also: STRAINWAVE_DEBUG=1).")
def cli(debug: bool) -> None:
    """Nonlinear dynamic error of strain wave gears (harmonic drives).

    Start with `strainwave demo`, then write a project file and run `strainwave analyze PROJECT.yaml -o report`.
    """


add_completion_class(PowerShellComplete)  # click has the other shells


def main() -> None:
    """Run the command line."""
    cli(prog_name="strainwave")
