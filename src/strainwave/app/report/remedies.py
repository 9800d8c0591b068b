"""Remedies that make the error smaller: as data, in a sentence and as a bar chart."""

from collections.abc import Sequence
from html import escape
from textwrap import wrap
from typing import Any, NamedTuple

from ...base.sentences import Sentence, Speed
from ...plot.svg import FONT, INK, LETTER, WIDTH, text_at
from ...study.analysis.load_cases import worst_of
from ...study.analysis.remedies import CANCELLED, NOTHING, Remedy
from ...study.speed_map.avoid import Avoid
from ..console import number
from ..view import View, sizes

FEW = 6  # remedies of the sentence; the table has all
ROW, LINE, THICK, TOP = 12.0, 16.0, 13.0, 40.0  # space between rows, of a line of text, of a bar, above them [px]
NAME, GAP = 42, 7.0  # letters of a line of a name, and distance of texts [px]
FILL = "#0072B2"


def remedies_data(view: View, avoid: Avoid) -> dict[str, Any]:
    """Keys of `advice` about remedies: a row each, their sentence, what does not help, and what was not tried."""
    remedies = view.analysis.remedies
    largest, speed = largest_of(view, avoid)
    return {
        "remedies": [_row(view, remedy, largest) for remedy in remedies],
        "remedy_sentence": _sentence(view, remedies, speed),
        "no_help": _no_help(remedies),
        "not_tried": list(view.analysis.not_tried),
    }


def largest_of(view: View, avoid: Avoid) -> tuple[float, float]:
    """Oscillation [rad] to which the remedies are related, and its speed [rad/s]."""
    worst = worst_of(view.analysis.load_cases)
    deciding = avoid if worst is None or worst.avoid is None else worst.avoid
    return deciding.largest, deciding.at


def remedies_figure(view: View) -> str:
    """Change of the oscillation by every remedy that helps, the most helpful first; "" where none does."""
    known = [remedy for remedy in view.analysis.remedies if remedy.share != CANCELLED and remedy.helps]
    rows = [Bar(str(one), one.ratio - 1.0, f"−{number(100.0 * (1.0 - one.ratio), 2)} %") for one in known]
    title = "change of the largest oscillation"
    return bars(rows, title, f"{title} by each remedy") if rows else ""


def _row(view: View, remedy: Remedy, largest: float) -> dict[str, Any]:
    return {
        "what": remedy.what,
        "change": remedy.change,
        "from": remedy.before,
        "to": remedy.gear or remedy.after,
        "unit": remedy.unit,
        "relative_oscillation": remedy.ratio,
        **sizes(remedy.ratio * largest, "oscillation"),
        "at_rad_per_s": remedy.at,
        "at_rpm": view.speeds.rpm(remedy.at),
        "above_limit": remedy.exceeds,
        "helps": remedy.helps,
    }


def can_be_ordered(remedy: Remedy) -> bool:
    """Whether a change can be bought or set: another gear, the loop, a preload, damping."""
    return bool(remedy.gear or remedy.by or "loop" in remedy.what or remedy.what.startswith("damping"))


def after_change(view: View, remedy: Remedy) -> dict[str, Any]:
    """What a change leaves of the largest oscillation."""
    avoid = view.analysis.avoid
    return sizes(None if avoid is None else remedy.ratio * largest_of(view, avoid)[0], "oscillation")


def _no_help(remedies: tuple[Remedy, ...]) -> str:
    """Sentence on the changes that leave the oscillation as it is or make it larger; "" without one."""
    useless = ", ".join(str(remedy) for remedy in remedies if not remedy.helps)
    return f"These changes do not help: {useless}." if useless else ""


def _sentence(view: View, remedies: tuple[Remedy, ...], speed: float) -> str:
    """Sentence on the remedies of the peak at a speed [rad/s], the most helpful first, and those that do not help."""
    remedies = tuple(remedy for remedy in remedies if remedy.share != CANCELLED)
    helpful, useless = [remedy for remedy in remedies if remedy.helps], _no_help(remedies)
    if not helpful:
        return useless
    worst = worst_of(view.analysis.load_cases)
    load = "" if worst is None else f" under a load torque of {number(worst.torque)} N·m"
    effects = Sentence("; ").join(_effect(remedy, speed) for remedy in helpful[:FEW])
    others = f"; the table of the report has {len(helpful) - FEW} more" if len(helpful) > FEW else ""
    said = f"Most helpful: {helpful[0]}. Computed again{load} with one thing changed at a time: " + effects
    return said + others + "." + (f" {useless}" if useless else "")


def _effect(remedy: Remedy, speed: float) -> str:
    shifted = abs(remedy.at / speed - 1.0) > NOTHING and remedy.ratio > NOTHING
    place = ", at " + _speed(remedy.at) + " instead of " + _speed(speed) if shifted else ""
    within = ", within the limit" if remedy.exceeds is False else ""
    return f"{remedy}: {number(100.0 * (1.0 - remedy.ratio), 2)} % less oscillation{within}" + place


def _speed(omega: float) -> Speed:
    return Speed(omega, digits=4, bare=True)


class Bar(NamedTuple):
    """A relative change, which is negative, with the name of its cause and the text of its value."""

    name: str
    change: float
    value: str


def bars(rows: Sequence[Bar], title: str, label: str) -> str:
    """Draw the changes below each other, in their order.

    Parameters
    ----------
    rows : sequence of Bar
        From top to bottom.
    title : str
        Above the chart.
    label : str
        Text for screen readers.

    Returns
    -------
    str
        One SVG element, 760 px wide.
    """
    names = [wrap(row.name, NAME) or [""] for row in rows]
    left = GAP + LETTER * max((len(line) for lines in names for line in lines), default=0) + GAP
    room = 2.0 * GAP + LETTER * max((len(row.value) for row in rows), default=0)
    zero, y, parts = WIDTH - GAP, TOP, list[str]()
    scale = (zero - left - room) / max(-row.change for row in rows)
    for row, lines in zip(rows, names, strict=True):
        middle = y + 0.5 * LINE * len(lines)
        parts += [text_at(left - GAP, y + LINE * (i + 0.75), line, "end") for i, line in enumerate(lines)]
        start = zero + row.change * scale
        place = f'x="{start:.1f}" y="{middle - 0.5 * THICK:.1f}" width="{zero - start:.1f}"'
        parts.append(f'<rect {place} height="{THICK:g}" fill="{FILL}" stroke="{INK}"/>')
        parts.append(text_at(start - GAP, middle + 0.25 * LINE, row.value, "end"))
        y += LINE * len(lines) + ROW
    axis = f'<path d="M{zero:.1f} {TOP - 6.0:.1f}V{y - 0.5 * ROW:.1f}" stroke="{INK}"/>'
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" role="img" aria-label="{escape(label)}" '
        f'viewBox="0 0 {WIDTH:.0f} {y:.0f}" fill="{INK}" font-size="{FONT}" '
        f'font-family="Segoe UI, Helvetica Neue, Arial, DejaVu Sans, sans-serif">'
        f"{text_at(GAP, 18.0, title, 'start')}{''.join(parts)}{axis}</svg>"
    )
