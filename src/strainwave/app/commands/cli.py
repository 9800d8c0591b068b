"""The command `strainwave`. Results go to stdout, everything else to stderr.

Exit codes: 0 ok, 1 the run failed, 2 wrong usage, 3 invalid project file, 130 interrupted. A command stands in a file
of this folder, which is imported where the command is called: `--help` reads what it says, and answers at once.
"""

import errno
import os
import re
import signal
import sys
from collections.abc import Callable
from functools import wraps
from io import TextIOWrapper
from pathlib import Path
from typing import Any

import click
from click.shell_completion import CompletionItem

from ... import __version__
from ...base.above import thing
from ..console.written import written

FAILED, INVALID_PROJECT, INTERRUPTED = 1, 3, 130
EXPECTED = (
    "SolveError", "ValueError", "TypeError", "RuntimeError", "ModuleNotFoundError", "FileNotFoundError", "Unrecordable",
    "NoReader",
)  # fmt: skip

# Name if it is given, function, and the first sentence of its help, in the text of a command's file.
DECLARED = re.compile(
    r'^@click\.command\((?:"([^"]+)")?\)$.*?^def (\w+)\(.*?"""(.+?\.)(?:"""|\s)', re.DOTALL | re.MULTILINE
)


def commands_in(folder: Path) -> dict[str, tuple[str, str]]:
    """Commands of the files in a folder by their names, in order: module below it, and the sentence of `--help`."""
    declared = {
        name or function.replace("_", "-"): (".".join(path.relative_to(folder).with_suffix("").parts), sentence)
        for path in folder.rglob("*.py")
        for name, function, sentence in DECLARED.findall(path.read_text(encoding="utf-8"))
    }
    return {name: (module, " ".join(text.split())) for name, (module, text) in sorted(declared.items())}


COMMANDS = commands_in(Path(__file__).parent)
GROUPS = {  # of `--help`; a command that is in none stands in the last one
    "Start": "demo new analyze watch app skill doctor completion",
    "Ask about a drive": "response speed-map exceedance sweep compare",
    "Choose, move and control": "catalogue design move tune compensate",
    "Measure": "read-log order-scan fit-loop fit-bode identify",
    "Files and theory": "schema export order-table derive reproduce",
}


class Sentences(click.Group):
    """The group of COMMANDS. They end with one sentence and an exit code, never with a traceback (but for --debug)."""

    def get_command(self, _ctx: click.Context, cmd_name: str) -> click.Command | None:
        """The command of a name, its module imported; None of a name that is none."""
        if cmd_name not in COMMANDS:
            return None
        module, _ = COMMANDS[cmd_name]
        command: click.Command = thing(f"{__package__}.{module}", cmd_name.replace("-", "_"))
        if command.callback is not None and not hasattr(command.callback, "__wrapped__"):
            command.callback = _apart(command, command.callback)
        return command

    def format_commands(self, _ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write names and sentences of all commands in groups, none of them imported."""
        groups, width = {group: names.split() for group, names in GROUPS.items()}, max(map(len, COMMANDS))
        grouped = {name for names in groups.values() for name in names}
        groups[next(reversed(groups))] += [name for name in COMMANDS if name not in grouped]
        for group, names in groups.items():
            with formatter.section(group):
                formatter.write_dl([(name.ljust(width), COMMANDS[name][1]) for name in names])

    def shell_complete(self, ctx: click.Context, incomplete: str) -> list[CompletionItem]:
        """Names of commands and options that begin as typed, no command imported."""
        names = [name for name in COMMANDS if name.startswith(incomplete)]
        options = click.Command.shell_complete(self, ctx, incomplete)
        return [*(CompletionItem(name, help=COMMANDS[name][1]) for name in names), *options]

    def invoke(self, ctx: click.Context) -> Any:
        """Run the subcommand and turn its exceptions into a sentence and an exit code."""
        if isinstance(sys.stdout, TextIOWrapper) and sys.stdout.errors == "strict":  # for names that are no UTF-8
            sys.stdout.reconfigure(errors="backslashreplace")
        try:
            return super().invoke(ctx)
        except (click.exceptions.Exit, click.ClickException, click.Abort, BrokenPipeError):
            raise
        except KeyboardInterrupt as stop:
            kept = ", ".join(map(str, written(ctx)))
            default = f"interrupted; written: {kept}" if kept else "interrupted; nothing was written; run it again"
            click.echo(f"strainwave: {str(stop) or default}", err=True)
            ctx.exit(INTERRUPTED)
        except Exception as error:  # whatever it is, a user gets one sentence; --debug shows the rest
            if ctx.params.get("debug") or os.environ.get("STRAINWAVE_DEBUG") == "1":
                raise
            from ..console.library_words import in_options
            from ..console.terminal import echo

            command = self.get_command(ctx, ctx.invoked_subcommand) if ctx.invoked_subcommand else None
            files = sys.modules.get("strainwave.files.yaml_text")
            if files is not None and isinstance(error, files.FileError):
                echo(in_options(str(error), command), err=True)
                ctx.exit(INVALID_PROJECT)
            echo(f"strainwave: {in_options(_sentence(error), command)}", err=True)
            ctx.exit(FAILED)


def _apart(command: click.Command, run: Callable[..., Any]) -> Callable[..., Any]:
    """Function of a command with a check before it: none of its outputs is one of its inputs."""
    from .options import folder_type, written_type

    options = [param for param in command.params if param.type in (folder_type, written_type)]
    outputs = {param.name: set(re.findall(r"[\w.-]+\.\w+", getattr(param, "help", "") or "")) for param in options}

    @wraps(run)
    def checked(**given: Any) -> Any:
        from ...base.archive import INPUTS, refuse_inputs

        read = [value if isinstance(value, tuple) else (value,) for name, value in given.items() if name not in outputs]
        INPUTS[:] = [Path(one) for value in read for one in value if isinstance(one, str | Path)]
        for name, files in outputs.items():  # a folder, with the files that its help names, or a file
            if given[name] is not None:
                refuse_inputs(given[name], *(given[name] / file for file in files))
        return run(**given)

    return checked


def _sentence(error: Exception) -> str:
    """One line about an error."""
    if isinstance(error, OSError) and error.strerror:
        from ..console.output_files import sentence

        if error.filename is None and error.errno in (errno.ENOSPC, errno.EIO) and _stdout_fails():
            return f"standard output: {error.strerror.lower()}; files already written are complete"
        return sentence(error)
    text = " ".join(str(error).split()) or type(error).__name__
    name = type(error).__name__
    return text if name in EXPECTED else f"{name}: {text} (unexpected error; --debug shows the traceback)"


def _stdout_fails() -> bool:
    try:
        return bool(print(flush=True))
    except OSError:
        return True


@click.group(
    cls=Sentences,
    commands=dict.fromkeys(COMMANDS, click.Command(None)),  # for `Did you mean`
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110, "show_default": True},
)
@click.version_option(__version__, prog_name="strainwave")
@click.option("--debug", is_flag=True, help="Show the traceback of an error (also: STRAINWAVE_DEBUG=1).")
def cli(debug: bool) -> None:
    """Nonlinear dynamic error of strain wave gears (harmonic drives).

    Start with `strainwave new`, which asks for a drive, and `strainwave analyze drive.yaml`, which judges it.
    """


def main() -> None:
    """Run the command line; streams that the shell has closed are empty."""
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, mode, encoding="utf-8"))  # noqa: SIM115 (open as long as the process)
    try:
        cli(prog_name="strainwave")
    except OSError as error:  # of what `--help` and `--version` say
        click.echo(f"strainwave: {_sentence(error)}", err=True)
        sys.exit(FAILED)
    except SystemExit as end:
        if not end.code:  # all is done: what is asked of the process on its way out interrupts nothing
            signal.signal(signal.SIGINT, signal.SIG_IGN)
            signal.signal(signal.SIGTERM, signal.SIG_IGN)
        raise
