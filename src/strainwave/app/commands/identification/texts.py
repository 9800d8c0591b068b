"""Options that are texts with a meaning."""

import click


def orders(_context: click.Context, _option: click.Parameter, text: str | None) -> list[int] | None:
    """Read orders such as 1,2,4."""
    if text is None:
        return None
    parts = [part.strip() for part in text.split(",")]
    if not all(part.isascii() and part.isdigit() for part in parts):
        raise click.BadParameter(f"{text!r} is no list of orders; write for example 1,2,4")
    return [int(part) for part in parts]


def pairs(_context: click.Context, option: click.Parameter, texts: tuple[str, ...]) -> dict[str, str]:
    """Read CHANNEL=VALUE, repeated."""
    found = {}
    for text in texts:
        name, equal, value = text.partition("=")
        if not (name.strip() and equal and value.strip()):
            raise click.BadParameter(f"{text!r} is not {option.metavar}; write for example load_angle=deg")
        found[name.strip()] = value.strip()
    return found
