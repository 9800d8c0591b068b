"""`strainwave app`, `completion` and `skill`: the local web app, scripts of shells, and the text for assistants."""

import threading
import webbrowser
from pathlib import Path

import click
from click.shell_completion import get_completion_class

SHELLS = ("bash", "zsh", "fish")
TEXT = Path(__file__).parents[1] / "skill.md"  # which AGENTS.md and llms.txt hold too


@click.command()
@click.option("--port", type=click.IntRange(0, 65535), default=8765, help="Port; if taken, the next.")
@click.option("--browser/--no-browser", default=True, help="Whether to open the page in a browser.")
def app(port: int, browser: bool) -> None:
    """Serve the page with sliders, on this machine alone."""
    try:
        from ..web.server import serve
    except ModuleNotFoundError as error:
        if error.name not in ("starlette", "uvicorn", "anyio"):
            raise
        raise RuntimeError(f"the app needs {error.name}; pip install 'strainwave[web]'") from None

    def opened(address: str, actual: int) -> None:
        if actual != port and port:
            click.echo(f"port {port} is taken; the app is at {actual}", err=True)
        click.echo(f"strainwave app: {address} (Ctrl-C ends it)")
        if browser:
            threading.Thread(target=_open, args=(address,), daemon=True).start()

    serve(port, opened)


def _open(address: str) -> None:
    if not webbrowser.open(address):
        click.echo(f"no browser was found; open {address}", err=True)


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


@click.command()
def skill() -> None:
    """Print which command answers which question."""
    click.echo(TEXT.read_text(encoding="utf-8"), nl=False)
