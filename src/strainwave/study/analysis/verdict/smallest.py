"""The smallest change of one thing that brings the largest oscillation of a drive under its limit.

Every step that is named was computed, under every load torque that has a curve. Steps are whole percents. Where none
suffices, what can only be exchanged is taken if it does: a line that is cancelled, another gear, a preload.
"""

from math import ceil, copysign, exp, log1p
from math import log as ln

from ....base.results import SolveError
from ....drive.drive_response import DriveResponse
from ..avoid import Avoid
from ..load_cases import LoadCase
from ..remedies.knobs import Knob, Subject
from ..remedies.remedies import Allowance, Remedy, Trial, at_worst, every_knob, under

MARGIN = 0.99  # of the limit, which a change has to reach: the short curve that judges it is within 1 %
HELPS = 0.99  # relative oscillation below which a thing is followed further
THINGS, STEPS = 3, 3  # things of which the step is searched, and steps of each
LEAST, MOST = -0.5, 1.0  # relative changes beyond which none is searched, but for what can be cancelled altogether


def smallest_change(
    subject: Subject, drive: DriveResponse, avoid: Avoid | None, cases: tuple[LoadCase, ...], torque: float,
    tried: tuple[Remedy, ...],
) -> Remedy | None:  # fmt: skip
    """Find the smallest step that suffices, beginning with what the remedies that were tried do.

    Parameters
    ----------
    subject : Subject
        The drive as it is.
    drive, avoid : DriveResponse, Avoid or None
        Its curve, and its speeds to avoid with the limit of its oscillation [rad].
    cases : tuple of LoadCase
        Its load torques, where it has a range of them.
    torque : float
        Largest torque in the gear [N*m].
    tried : tuple of Remedy
        What one step of each thing does.

    Returns
    -------
    Remedy or None
        None where the limit is not exceeded or not given, and where no change that suffices was found.
    """
    if avoid is None or avoid.limit is None or avoid.largest <= avoid.limit or not tried:
        return None
    allowance, limit = Allowance.of(subject), MARGIN * avoid.limit
    worst, curve, avoid = at_worst(subject, drive, avoid, cases)
    trial = Trial.of(worst, curve, avoid)
    if trial is None:
        return None
    ratio = limit / avoid.largest
    known = list(every_knob(worst, curve, torque))
    helpful = [remedy for remedy in tried if _stepwise(remedy) and remedy.ratio < HELPS]
    steps: list[Remedy] = []
    for remedy in sorted(helpful, key=lambda remedy: _size(_needed(remedy, ratio)))[:THINGS]:
        least = -1.0 if any(other.what == remedy.what and other.share == -1.0 for other in tried) else LEAST
        steps += _steps(trial, _knob_of(remedy, known), remedy, ratio, least, allowance)
    steps.sort(key=lambda remedy: _size(remedy.share))
    steps += [remedy for remedy in tried if not _stepwise(remedy) and remedy.ratio <= ratio]
    others = [under(subject, t) for c in cases if (t := c.torque) != worst.load_torque]
    other_knobs = [list(every_knob(other, curve, torque)) for other in others]
    for remedy in steps:
        if all(_within(limit, trial, _knob_of(remedy, knobs), remedy.share, allowance) for knobs in other_knobs):
            return remedy
    return None


def _steps(
    trial: Trial, knob: Knob, tried: Remedy, ratio: float, least: float, allowance: Allowance
) -> list[Remedy]:  # fmt: skip
    """Computed steps of one thing that reach a relative oscillation, as long as drives may be followed."""
    steps = [tried]
    for _ in range(STEPS):
        share = _needed(steps[-1], ratio)
        if not least <= share <= MOST or share == -1.0 or any(share == remedy.share for remedy in steps):
            break
        changed = knob.turned(share)
        if isinstance(changed, str) or not allowance.take():
            break
        after = trial.remedy(knob, share, changed)
        if after is None or after.ratio >= HELPS:
            break
        steps.append(after)
    return [remedy for remedy in steps if remedy.ratio <= ratio]


def _within(limit: float, trial: Trial, knob: Knob, share: float, allowance: Allowance) -> bool:
    """Whether a change keeps the oscillation [rad] under another load torque within a limit."""
    changed = knob.turned(share)
    if isinstance(changed, str) or not allowance.take():
        return False
    try:
        top = changed.largest(*trial.how)
    except SolveError:  # its law cannot carry the torque
        return False
    return top is not None and top[1] <= limit


def _needed(remedy: Remedy, ratio: float) -> float:
    """Share, in whole percents, with which an oscillation that goes with a power of the thing reaches a ratio."""
    share = exp(min(log1p(remedy.share) * ln(ratio) / ln(remedy.ratio), 10.0)) - 1.0
    return copysign(ceil(round(100.0 * abs(share), 6)) / 100.0, share)


def _stepwise(remedy: Remedy) -> bool:
    """Whether the thing can be changed by any share."""
    return not remedy.by and remedy.share not in (0.0, -1.0)


def _size(share: float) -> float:
    """Size of a relative change; twice as much and half as much are equal."""
    return abs(log1p(share)) if share > -1.0 else float("inf")


def _knob_of(remedy: Remedy, known: list[Knob]) -> Knob:
    """What a remedy has turned."""
    cancelled = remedy.share == -1.0
    return next(k for k in known if k.what == remedy.what and (k.changes == (1.0,)) == cancelled)
