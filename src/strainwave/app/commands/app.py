"""`strainwave app`: the local web app."""

import threading
import webbrowser

import click


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
