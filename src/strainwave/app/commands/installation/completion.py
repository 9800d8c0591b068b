"""`strainwave completion`: the script by which a shell completes commands, options, gears and files."""

import click
from click.shell_completion import get_completion_class

SHELLS = ("bash", "zsh", "fish")


@click.command()
@click.argument("shell", type=click.Choice(SHELLS))
def completion(shell: str) -> None:
    """Print the completion of SHELL.

    It completes commands, options, gears and files.

    bash: eval "$(strainwave completion bash)" in ~/.bashrc; zsh: the same in ~/.zshrc; fish: strainwave completion fish
    > ~/.config/fish/completions/strainwave.fish.
    """
    kind = get_completion_class(shell)
    root = click.get_current_context().find_root().command
    assert kind is not None
    click.echo(kind(root, {}, "strainwave", "_STRAINWAVE_COMPLETE").source())
