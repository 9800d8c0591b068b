"""A row of the page on validation: what is compared, the number of the source, ours, and where it comes from."""

from collections.abc import Callable, Sequence
from typing import NamedTuple


class Row(NamedTuple):
    """A compared case: `known` holds printed numbers as they are printed, `found` computes ours in the same order.

    `recipe` is a test below tests/ or a command. Where there is no `found`, `told` are our numbers as the recipe gave
    them: it takes too long for a test, needs a record or another program, or holds a bound. `note` replaces the
    difference.
    """

    case: str
    source: str
    compared: str
    known: tuple[str, ...]
    found: Callable[[], Sequence[float]] | None
    recipe: str
    told: tuple[str, ...] = ()
    note: str = ""


def decimals(printed: str) -> tuple[int, str]:
    """Decimals of a printed number, and its exponent as it is printed."""
    mantissa, _, exponent = printed.partition("e")
    return len(mantissa.partition(".")[2]), exponent


def as_printed(value: float, printed: str) -> str:
    """Our number with as many decimals and the exponent of the printed one; two digits where that leaves nothing."""
    places, exponent = decimals(printed)
    if float(printed) and abs(value) < 20.0 * half_digit(printed):
        return f"{value:.2g}"
    if not exponent:
        return f"{value:.{places}f}".removeprefix("-") if round(value, places) == 0 else f"{value:.{places}f}"
    return f"{value / 10.0 ** int(exponent):.{places}f}e{exponent}"


def half_digit(printed: str) -> float:
    """Half a unit of the last printed digit."""
    places, exponent = decimals(printed)
    return 0.5 * 10.0 ** (int(exponent or 0) - places)


def difference(ours: Sequence[float], known: Sequence[str]) -> str:
    """None to the printed digits, or the largest relative difference in percent."""
    wrong = [
        value / float(printed) - 1.0 if float(printed) else value
        for value, printed in zip(ours, known, strict=True)
        if abs(value - float(printed)) > 1.02 * half_digit(printed)
    ]
    if not wrong:
        return "none in these digits"
    worst = max(wrong, key=abs)
    return f"{100.0 * worst:+.2g} %" if abs(worst) < 1.0 else f"factor {1.0 + worst:.3g}"


def markdown(row: Row) -> str:
    """The row as it stands on the page."""
    ours = [float(value) for value in row.found()] if row.found else []
    shown = [as_printed(value, printed) for value, printed in zip(ours, row.known, strict=True)] if ours else row.told
    apart = row.note or difference(ours, row.known)
    first = f"**{row.case}**<br>{row.source}<br>`{row.recipe}`"
    return f"| {first} | {row.compared} | {', '.join(row.known) or '–'} | {', '.join(shown)} | {apart} |"
