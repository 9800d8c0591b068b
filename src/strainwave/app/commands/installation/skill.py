"""`strainwave skill`: the text for assistants, which command answers which question."""

from pathlib import Path

import click

TEXT = Path(__file__).parents[2] / "skill.md"  # which AGENTS.md and llms.txt hold too


@click.command()
def skill() -> None:
    """Print which command answers which question."""
    click.echo(TEXT.read_text(encoding="utf-8"), nl=False)
