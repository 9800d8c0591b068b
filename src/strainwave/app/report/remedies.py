"""What would make the error smaller, as data, in a sentence and as a bar chart."""

from typing import Any

from ...base.sentences import Sentence, Speed
from ...study.analysis.avoid import Avoid
from ...study.analysis.load_cases import worst_of
from ...study.analysis.remedies import Remedy
from ..console import number
from ..figures.bars import Bar, bars
from ..view import View, sizes

NOTHING = 0.005  # relative change that is called none
FEW = 6  # remedies of the sentence; the table has all


def remedies_data(view: View, avoid: Avoid) -> dict[str, Any]:
    """Keys of `advice` about what would help: a row each, the sentence, and what was not tried."""
    found = view.analysis.remedies
    largest, at = largest_of(view, avoid)
    return {
        "remedies": [_row(view, remedy, largest) for remedy in found],
        "remedy_sentence": _sentence(view, found, at),
        "not_tried": list(view.analysis.not_tried),
    }


def largest_of(view: View, avoid: Avoid) -> tuple[float, float]:
    """Oscillation [rad] to which the remedies are related, and its speed [rad/s]."""
    worst = worst_of(view.analysis.load_cases)
    own = avoid if worst is None or worst.avoid is None else worst.avoid
    return own.largest, own.at


def remedies_figure(view: View) -> str:
    """Change of the oscillation by every remedy, the most helpful first."""
    rows = [Bar(more(remedy), remedy.ratio - 1.0, _percent(remedy.ratio - 1.0)) for remedy in view.analysis.remedies]
    title = "change of the largest oscillation (filled: less, hatched: more)"
    return bars(rows, title, "change of the largest oscillation by each remedy")


def _row(view: View, remedy: Remedy, largest: float) -> dict[str, Any]:
    return {
        "what": remedy.what,
        "change": _change(remedy),
        "from": remedy.before,
        "to": remedy.gear or remedy.after,
        "unit": remedy.unit,
        "relative_oscillation": remedy.ratio,
        **sizes(remedy.ratio * largest, "oscillation"),
        "relative_change_per_unit": remedy.per_unit,
        "at_rad_per_s": remedy.at,
        "at_rpm": view.speeds.rpm(remedy.at),
        "above_limit": remedy.exceeds,
    }


def _sentence(view: View, found: tuple[Remedy, ...], at: float) -> str:
    """What helps at a peak at some speed [rad/s], the most helpful first, and what does not."""
    if not found:
        return ""
    best, worst = found[0], worst_of(view.analysis.load_cases)
    helps = f"Most helpful: {more(best)}." if best.ratio < 1.0 - NOTHING else "None of them makes it smaller."
    under = "" if worst is None else f" under a load torque of {number(worst.torque)} N·m"
    matters = [remedy for remedy in found if abs(remedy.ratio - 1.0) > NOTHING]
    without = ", ".join(more(remedy) for remedy in found if remedy not in matters)
    none = f" These change nothing: {without}." if without else ""
    if not matters:
        return helps + none
    effects = Sentence("; ").join(_effect(remedy, at) for remedy in matters[:FEW])
    others = f"; the table of the report has {len(matters) - FEW} more" if len(matters) > FEW else ""
    return f"{helps} Computed again{under} with one thing changed at a time: " + effects + others + "." + none


def _change(remedy: Remedy) -> str:
    if remedy.gear:
        return f"{remedy.gear} instead"
    if remedy.by:
        return f"{number(remedy.by, 3)} N·m more"
    if remedy.share == -1.0:
        return "cancelled by feed-forward"
    return f"{number(100.0 * abs(remedy.share))} % {'more' if remedy.share > 0.0 else 'less'}"


def more(remedy: Remedy) -> str:
    """The change in words, "10 % more damping of the gear"."""
    if remedy.gear:
        return f"{remedy.what}, {remedy.gear}"
    if remedy.share == -1.0:
        return f"{remedy.what} cancelled by feed-forward"
    return f"{_change(remedy)} {'mean torque' if remedy.by else remedy.what}"


def _percent(change: float) -> str:
    if abs(change) <= NOTHING:
        return "±0 %"
    return f"{'−' if change < 0.0 else '+'}{number(abs(100.0 * change), 2)} %"


def _effect(remedy: Remedy, at: float) -> str:
    change = 100.0 * (remedy.ratio - 1.0)
    size = f"{number(abs(change), 2)} % {'less' if change < 0.0 else 'more'}"
    moved = abs(remedy.at / at - 1.0) > NOTHING and remedy.ratio > NOTHING
    where = ", at " + _speed(remedy.at) + " instead of " + _speed(at) if moved else ""
    held = ", within the limit" if remedy.exceeds is False else ""
    return f"{more(remedy)}: {size} oscillation{held}" + where


def _speed(omega: float) -> Speed:
    return Speed(omega, digits=4, bare=True)
