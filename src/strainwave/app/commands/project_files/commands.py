"""What `new`, `schema` and `completion` take; their work is imported inside, so that `--help` answers at once."""

from pathlib import Path
from typing import Any

import click

from .powershell import SHELLS
from .questions import QUESTIONS


def gear_names(_context: click.Context, _parameter: click.Parameter, incomplete: str) -> list[str]:
    """Names of the catalogue that begin as typed."""
    from ....model.gears import catalogue

    return [name for name in catalogue.names() if name.startswith(incomplete.upper())]


def _asked(command: Any) -> Any:
    """An option for every question."""
    for question in reversed(QUESTIONS):
        complete: dict[str, Any] = {"shell_complete": gear_names} if question.name == "gear" else {}
        command = click.option(question.option, question.name, help=question.help, **complete)(command)
    return command


@click.command()
@_asked
@click.option(
    "-o", "--output", type=click.Path(dir_okay=False, path_type=Path), default=Path("drive.yaml"), show_default=True,
    help="Project file to write.",
)  # fmt: skip
@click.option("--force", is_flag=True, help="Replace a file that exists.")
def new(output: Path, force: bool, **given: str | None) -> None:
    """Write a commented project file.

    On a terminal every number that no option gives is a question; Enter takes its default.
    """
    from .new import show

    show(output, force, given)


@click.command()
@click.option("--markdown", is_flag=True, help="Print the reference of all fields as Markdown instead.")
def schema(markdown: bool) -> None:
    """Print the JSON Schema of the project file, for editors."""
    from ....files.reference.json_schema import project_schema
    from ....files.reference.markdown import reference
    from ...console import to_json

    click.echo(reference() if markdown else to_json(project_schema()), nl=not markdown)


@click.command()
@click.argument("shell", type=click.Choice(SHELLS))
def completion(shell: str) -> None:
    """Print a script that completes commands, options, gears and files in SHELL.

    bash: eval "$(strainwave completion bash)" in ~/.bashrc; zsh: the same in ~/.zshrc; fish: strainwave completion fish
    > ~/.config/fish/completions/strainwave.fish; powershell: strainwave completion powershell | Out-String |
    Invoke-Expression in $PROFILE.
    """
    from click.shell_completion import get_completion_class

    kind = get_completion_class(shell)
    root = click.get_current_context().find_root().command
    assert kind is not None
    click.echo(kind(root, {}, "strainwave", "_STRAINWAVE_COMPLETE").source())
