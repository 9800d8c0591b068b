"""Several laws for one log, compared by what they predict of its part that they were not fitted to."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np

from ...base.arguments import typed
from ...base.quantities import number, numbers, shown
from ...base.records import Labelled, Result
from ...base.results import Floats, SolveError
from ...base.sentences import on_screen
from .identified import MOST_OF_START, Identified, channels_of
from .identify import identify


@dataclass(frozen=True, eq=False)
class LawComparison(Result):
    """Candidates in the order of what they leave of the part that was held out, those that cannot be last.

    Attributes
    ----------
    names : tuple of str
        Candidates, the best first.
    numbers : (candidates,) array
        Free numbers of each.
    fitted, held_out : (candidates,) arrays
        Root mean square of the residual of the first output, in the part that each was fitted to, and run freely over
        the part that was held out.
    found : tuple of Identified
        What each was found to be from the first part alone; one with `notes` cannot be, or has not converged.
    left_out : dict of str to str
        Candidates that could not be identified or simulated, such as one whose numbers the log does not tell apart,
        and why.
    """

    rows: ClassVar[str] = "candidate"

    names: tuple[str, ...]
    numbers: Floats
    fitted: Floats
    held_out: Floats
    found: tuple[Identified, ...]
    left_out: dict[str, str] = field(default_factory=dict)

    @property
    def best(self) -> Identified:
        """The candidate that leaves least of what was held out, of those that can be."""
        return self.found[0]

    def coordinates(self) -> Labelled:
        """Names."""
        return {"candidate": ("candidate", np.array(self.names), "")}

    def variables(self) -> Labelled:
        """Numbers of parameters and residuals."""
        return self._along("candidate", numbers="", fitted="", held_out="")

    def __str__(self) -> str:
        width = max(len("candidate"), *map(len, self.names))
        lines = [f"  {'candidate':<{width}}  numbers  fitted     held out"]
        table = zip(self.names, self.numbers, self.fitted, self.held_out, self.found, strict=True)
        for name, many, fitted, held, found in table:
            notes = "; ".join(found.notes)
            lines.append(f"  {name:<{width}}  {many:7.0f}  {fitted:<9.4g}  {held:<9.4g}  {notes}".rstrip())
        lines += [f"  {name} was left out: {why}" for name, why in self.left_out.items()]
        return on_screen("\n".join(["Comparison of laws by what was held out", *lines]))


@typed
def compare_laws(
    candidates: Mapping[str, tuple[Any, Sequence[str]]],
    log: Any,
    *,
    held_out: float = 0.25,
    progress: Callable[[str, float], None] = lambda _what, _share: None,
    **options: Any,
) -> LawComparison:
    """Identify several systems from the first part of a log, and let each run over the rest.

    Parameters
    ----------
    candidates : dict of str to (system, free)
        For each name the system and the paths of its free numbers, as `identify` takes them.
    log : Log or dict of str to array
        One record.
    held_out : float
        Share of the log at its end that no candidate sees.
    progress : callable
        Told what is done, and which share of all.
    options
        As for `identify`: inputs, outputs, between, steps.

    Returns
    -------
    LawComparison
        `names`, the best first, with the root mean square of the residual `fitted` and `held_out`, in the unit
        of the first output; `left_out` names the candidates that `identify` refuses.

    Raises
    ------
    ValueError
        If no candidate is given, or the share leaves too little of either part; and as `identify` where it refuses all.
    """
    if not candidates:
        raise ValueError("candidates is empty; give a name with a system and its free numbers")
    for name, value in candidates.items():
        if not isinstance(value, tuple | list) or len(value) != 2:
            raise TypeError(f"candidate {name!r} is {shown(value)}; give a system and its free numbers, as a pair")
    held_out = number("held_out", held_out)
    if not 0.0 < held_out < 1.0:
        raise ValueError(f"held_out is {held_out:g}; it is the share of the log that is not fitted to, such as 0.25")
    channels = channels_of(log)
    if "time" not in channels:
        raise ValueError(f"log has no channel 'time'; it has {', '.join(channels)}")
    channels = {name: np.asarray(values) for name, values in channels.items()}
    channels["time"] = numbers("log: time", channels["time"])
    cut = round((1.0 - held_out) * len(channels["time"]))
    if min(cut, len(channels["time"]) - cut) < 2 * MOST_OF_START:
        raise ValueError(
            f"held_out is {shown(held_out)} of {len(channels['time'])} samples; leave {2 * MOST_OF_START} at least in "
            "both parts"
        )
    first = {name: values[:cut] for name, values in channels.items()}
    later = {name: values[cut:] for name, values in channels.items()}
    identified, left, left_out = dict[str, Identified](), dict[str, float](), dict[str, str]()
    for i, (name, (system, free)) in enumerate(candidates.items()):
        progress(name, i / len(candidates))
        try:
            fit = identify(system, first, free, **options)
            (channel, computed), *_ = fit.simulate(later, later).items()
        except (ValueError, SolveError) as refusal:
            left_out[name] = str(refusal)
            continue
        error = (np.asarray(later[channel]) - computed)[MOST_OF_START:]
        left[name], identified[name] = float(np.sqrt(np.nanmean(error * error))), fit
    if not identified:
        raise ValueError("; ".join(f"{name}: {why}" for name, why in left_out.items()))
    names = sorted(left, key=lambda name: (bool(identified[name].notes), not np.isfinite(left[name]), left[name]))
    return LawComparison(
        tuple(names),
        np.array([float(len(identified[name].names)) for name in names]),
        np.array([float(identified[name].rms[0]) for name in names]),
        np.array([left[name] for name in names]),
        tuple(identified[name] for name in names),
        left_out,
    )
