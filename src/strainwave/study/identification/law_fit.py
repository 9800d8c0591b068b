"""Laws identified from measurements: candidates compared, lack of fit, and the numbers of the one that is taken.

Lack of fit: whether a law misses a measurement by more than its repetitions, or its noise, differ by. Fisher 1922,
J. R. Stat. Soc. 85, 597-612; Draper & Smith 1998, Applied Regression Analysis, 3rd ed., sec. 2.1.

`compare_laws`: several laws for one log, compared by what they predict of its part that they were not fitted to.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar, NamedTuple

import numpy as np

from ...base.facts import Fact
from ...base.quantities import joined, number, numbers, shown
from ...base.records import Along, Labelled, Result
from ...base.results import Floats, SolveError
from ...base.terminal import on_screen, silent
from ...base.units import ARCSEC
from .channels import channels_of, row_of
from .fitted import Fit
from .identified import START_SAMPLES, Identified
from .identify import identify

TIE_ERRORS = 2.0  # standard errors of the difference from the best candidate
CHANCE = 0.01  # probability below which chance is not believed
MISFIT_WORDS = {
    "runs": ("it misses the runs by {} N*m rms, and they differ by", "{} times wider for it", "runs differ by"),
    "loop": (
        "it misses the torque along the loop by {} N*m rms, beside noise of",
        "at least {} times those of the noise alone",
        "the residual along the loop is noise of",
    ),
}  # fmt: skip


class LackOfFit(NamedTuple):
    """Misfit of a law, beside the differences of repetitions.

    Attributes
    ----------
    pure : float
        Root mean square [N*m] by which a run differs from others at its speed and load; of a loop its noise.
    missed : float
        The same of what the law misses: of runs as it would be with pure error alone, of a loop that along the torsion.
    ratio : float
        Mean square of what the law misses over that which pure error gives it (F).
    probability : float
        Of a ratio as large by chance.
    of : str
        What the law was fitted to: "runs", "loop".
    """

    pure: float
    missed: float
    ratio: float
    probability: float
    of: str = "runs"

    @property
    def found(self) -> bool:
        """True if the law does not fit."""
        return self.probability < CHANCE

    def __str__(self) -> str:
        misses, wider, pure = MISFIT_WORDS[self.of]
        chance = f"(probability {self.probability:.2g})"
        if not self.found:
            return f"no lack of fit: {pure} {self.pure:.3g} N*m rms {chance}"
        return (
            f"the law does not fit: {misses.format(f'{self.missed:.3g}')} {self.pure:.3g} N*m {chance}; the intervals "
            f"are {wider.format(f'{self.ratio**0.5:.3g}')}, without the error of the law"
        )


class LoopCandidate(NamedTuple):
    """A candidate law: what it has, its unknowns, and its error on samples or runs that were left out.

    `error` is the root mean square [N*m] under the fit to the others, `worse` the mean difference of its square from
    the best candidate's in standard errors of that difference.
    """

    name: str
    unknowns: int
    error: float
    worse: float
    chosen: bool

    def facts(self) -> tuple[Fact, ...]:
        """Row of a table."""
        words = ("law", "unknowns", "error", "", "taken")
        return tuple(map(Fact, self._fields, self, words))


def compare_candidates(
    fits: Sequence[tuple[str, int]], errors: Floats, unit: float, where: str
) -> tuple[int, tuple[LoopCandidate, ...], str]:
    """The simplest candidate within two standard errors of the best, the table, and the reason.

    Parameters
    ----------
    fits : sequence of (str, int)
        Name and number of unknowns of every candidate.
    errors : (candidates, m) array
        Squared errors of parts that were left out.
    unit : float
        Of their roots [N*m].
    where : str
        What was left out, in words.
    """
    means = errors.mean(axis=1)
    best = int(np.argmin(means))
    difference = errors - errors[best]
    spreads = np.std(difference, axis=1, ddof=1) / np.sqrt(errors.shape[1])
    worse = np.divide(difference.mean(axis=1), spreads, out=np.zeros(len(fits)), where=spreads > 0.0)
    tied = np.flatnonzero(worse <= TIE_ERRORS)
    choice = min(tied.tolist(), key=lambda i: (fits[i][1], means[i]))
    rows = tuple(
        LoopCandidate(fits[i][0], fits[i][1], unit * float(means[i]) ** 0.5, float(worse[i]), i == choice)
        for i in np.argsort(means, kind="stable").tolist()
    )
    text = f"{fits[choice][0]}: error {unit * means[choice] ** 0.5:.3g} N*m {where}"
    if choice == best:
        return choice, rows, f"{text}, the smallest of {len(fits)} candidates"
    return choice, rows, (
        f"{text}, within two standard errors of the smallest, {unit * means[best] ** 0.5:.3g} N*m, of {fits[best][0]}, "
        f"which has {fits[best][1] - fits[choice][1]} more unknowns"
    )  # fmt: skip


@dataclass(frozen=True, eq=False)
class LawFit(Fit):
    """A law identified from measured torques, the best of several candidates.

    Attributes
    ----------
    law : NamedTuple
        As found.
    values : dict of str to float
        Numbers by their path.
    covariance : (m, m) array
        Of these numbers, in their order.
    freedom : (m,) array
        Degrees of freedom of their intervals.
    unidentified : dict of str to str
        What the measurement does not tell, by its path, each with a sentence.
    comparison : tuple of LoopCandidate
        The candidates by their error in what was left out, smallest first.
    reason : str
        Why this candidate was chosen.
    residual_rms : float
        Root mean square [N*m] of measured minus fitted torque.
    torque, fitted : (n,) arrays
        Measured and fitted torque [N*m].
    remarks : tuple of str
        What limits the result.
    lack_of_fit : LackOfFit or None
        What the law misses beside noise or repetitions; None where that is not known.
    """

    units: ClassVar[dict[str, str]]
    words: ClassVar[dict[str, str]] = {}
    unknown: ClassVar[str]  # sentence where it is not known whether the law fits

    law: Any
    values: dict[str, float]
    covariance: Floats
    freedom: Floats
    unidentified: dict[str, str]
    comparison: tuple[LoopCandidate, ...]
    reason: str
    residual_rms: float
    torque: Floats
    fitted: Floats
    remarks: tuple[str, ...]
    lack_of_fit: LackOfFit | None = field(kw_only=True)

    def variables(self) -> Labelled:
        """Measured and fitted torque and their difference."""
        columns = {"torque": self.torque, "fitted": self.fitted, "residual": self.torque - self.fitted}
        return {name: (self.rows, values, "N*m") for name, values in columns.items()}

    def table(self) -> list[tuple[str, float, float, float, str]]:
        """Rows (name, value, low, high, unit) of the numbers, angles in arcmin."""
        rows = []
        for name, value in self.values.items():
            low, high = self.interval(name)
            scale, unit = (60.0 * ARCSEC, "arcmin") if self.units[name] == "rad" else (1.0, self.units[name])
            rows.append((self.words.get(name, name), value / scale, low / scale, high / scale, unit))
        return rows

    @property
    def misses(self) -> str:
        """Sentence on what the law misses; empty where nothing shows that it does."""
        return str(self.lack_of_fit) if self.lack_of_fit is not None and self.lack_of_fit.found else ""

    def sentences(self) -> tuple[str, ...]:
        """Limits of the measurement, the reason for this law, the limit of the result, and the fit of the law."""
        fits = "" if self.misses else str(self.lack_of_fit or self.unknown)
        texts = (*dict.fromkeys(self.unidentified.values()), self.reason, *self.remarks, fits)
        return tuple(sentence for sentence in texts if sentence)

    def headline(self) -> str:
        """Fitted law, in one line."""
        return f"{type(self).__name__}: residual {self.residual_rms:.3g} N*m rms"

    def __str__(self) -> str:
        lines = [self.headline(), *([f"  {self.misses}"] if self.misses else [])]
        for name, value, low, high, unit in self.table():
            lines.append(f"  {name:<26}{value:>12.5g}  ({low:.5g} .. {high:.5g}) {unit}".rstrip())
        return on_screen("\n".join([*lines, *(f"  {sentence}" for sentence in self.sentences())]))


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
    arrays: ClassVar[Along] = {"candidate": {"numbers": "", "fitted": "", "held_out": ""}}

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

    def __str__(self) -> str:
        width = max(len("candidate"), *map(len, self.names))
        lines = [f"  {'candidate':<{width}}  numbers  fitted     held out"]
        table = zip(self.names, self.numbers, self.fitted, self.held_out, self.found, strict=True)
        for name, count, fitted, held, one in table:
            notes = "; ".join(one.notes)
            lines.append(f"  {name:<{width}}  {count:7.0f}  {fitted:<9.4g}  {held:<9.4g}  {notes}".rstrip())
        lines += [f"  {name} was omitted: {why}" for name, why in self.left_out.items()]
        return on_screen("\n".join(["Comparison of laws by what was held out", *lines]))


def compare_laws(
    candidates: Mapping[str, tuple[Any, Sequence[str]]],
    log: Any,
    *,
    held_out: float = 0.25,
    progress: Callable[[str, float], None] = silent,
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
    held_out = number("held_out", held_out)
    if not 0.0 < held_out < 1.0:
        raise ValueError(f"held_out is {held_out:g}; it is the share of the log that is not fitted to, such as 0.25")
    channels = channels_of(log)
    if "time" not in channels:
        raise ValueError(f"log has no channel 'time'; it has {joined(channels)}")
    channels = {name: row_of("log", name, values) for name, values in channels.items()}
    channels["time"] = numbers("log: time", channels["time"])
    cut = round((1.0 - held_out) * len(channels["time"]))
    if min(cut, len(channels["time"]) - cut) < 2 * START_SAMPLES:
        raise ValueError(
            f"held_out is {shown(held_out)} of {len(channels['time'])} samples; leave {2 * START_SAMPLES} at least in "
            "both parts"
        )
    first, later = [{n: v[s] for n, v in channels.items()} for s in (slice(cut), slice(cut, None))]
    identified, left, left_out = dict[str, Identified](), dict[str, float](), dict[str, str]()
    for i, (name, (system, free)) in enumerate(candidates.items()):
        progress(name, i / len(candidates))
        try:
            fit = identify(system, first, free, **options)
            (channel, computed), *_ = fit.simulate(later, later).items()
        except (ValueError, SolveError) as refusal:
            left_out[name] = str(refusal)
            continue
        error = (np.asarray(later[channel]) - computed)[START_SAMPLES:]
        left[name], identified[name] = float(np.sqrt(np.nanmean(error * error))), fit
    if not identified:
        raise ValueError("; ".join(f"{name}: {why}" for name, why in left_out.items()))
    names = sorted(left, key=lambda name: (bool(identified[name].notes), not np.isfinite(left[name]), left[name]))
    fits = tuple(identified[name] for name in names)
    sizes, rms = np.array([(len(fit.names), fit.rms[0]) for fit in fits], float).T
    return LawComparison(tuple(names), sizes, rms, np.array([left[name] for name in names]), fits, left_out)
