"""`strainwave app`: the local web app."""

import threading
import webbrowser

import click


@click.command()
@click.option("--port", type=click.IntRange(0, 65535), default=8765, help="Port; if in use, the next free one.")
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
            click.echo(f"port {port} is in use; the app uses port {actual}", err=True)
        click.echo(f"strainwave app: {address} (Ctrl-C stops the app)")
        if browser:
            threading.Thread(target=_open, args=(address,), daemon=True).start()

    serve(port, opened)


def _open(address: str) -> None:
    if not webbrowser.open(address):
        click.echo(f"no browser was found; open {address}", err=True)
