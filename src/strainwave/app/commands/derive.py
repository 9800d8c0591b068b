"""`strainwave derive`: the error equation from Lagrange's equations."""

import click

from ..console import Progress, to_json


def show(latex: bool, as_json: bool) -> None:
    """Print the derivation as text, LaTeX or JSON.

    Raises
    ------
    RuntimeError
        If SymPy is not installed.
    """
    with Progress("derive") as progress:
        progress.show("deriving the error equation", 0.0)
        from ...theory.derivation.error_equation import derivation

        try:
            steps = derivation()
        except ModuleNotFoundError as error:
            raise RuntimeError(str(error)) from error
    if as_json:
        click.echo(to_json({"latex": steps.latex(), "text": str(steps)}))
    else:
        click.echo(steps.latex() if latex else str(steps))
