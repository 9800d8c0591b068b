"""`exceedance`: how probable it is that a drive whose numbers scatter exceeds its limit somewhere in its speeds."""

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, ClassVar

import numpy as np
from scipy.special import betaincinv, ndtr, ndtri

from ...base.facts import Fact
from ...base.number_text import number
from ...base.quantities import number as checked_number
from ...base.quantities import parse, positive_count, probabilities, whole
from ...base.records import Labelled, Result
from ...base.results import Floats, Interrupted
from ...base.terminal import silent
from ...drive.postures import WITH_MEMORY, spread
from ...drive.project import Project
from ...drive.speeds import Speeds
from ...drive.train_curve import refuse_free
from ...study.identification.intervals import Interval
from ...study.speed_map.avoid import band_above
from ..fields.groups import Radians
from ..notes import hysteresis_note
from ..yaml_text import read
from .names import nominal_of
from .ranking import Ranking, ranking
from .replaced import replaced, tuning

LEVELS, MOST_ERRORS = (0.05, 0.5, 0.95), 3  # levels of quantiles, and errors, that the text has
LEAST_DRIVES, MOST_DRIVES = 32, 1_000_000  # drives: fewer mean nothing, more are not drawn at once
CONFIDENCE = 0.95
UNITS = {"oscillation": "rad", "at": "rad/s", "low": "rad/s", "high": "rad/s"}
PLACE = r"^points? \d+ \([^)]*\): (SolveError: )?"  # of a drive without a curve, in what a sweep says of it
NOT_COMPUTED = 255  # status of a point that a sweep had no time for
CUT = 3.0  # standard deviations: no drive is farther from its nominal value


@dataclass(frozen=True, eq=False)
class Exceedance(Result):
    """The largest oscillation of the error of drives drawn at random, over their whole range of speeds.

    Attributes
    ----------
    limit : float
        Largest oscillation [rad] that is allowed.
    factors : dict of str to (drives,) array
        Numbers of the file relative to themselves, by their names; of a phase what is added to it [rad].
    oscillation, at : (drives,) arrays
        Largest |error - mean| [rad] over the stable motions of the curve under any of the `loads`,
        and the speed [rad/s] of the base angle there; nan of a drive without a response curve.
    low, high : (drives,) arrays
        Ends [rad/s] of the speeds to avoid around that one: above the limit, or between jumps; nan of a drive that
        does not exceed the limit.
    seed : int
        Seed of the drives.
    ranking : Ranking or None
        The numbers by what they contribute to the variance of the oscillation; None where a drive has no curve.
    errors : tuple of str
        Sentences about drives without a curve, each once.
    tuning : str
        Sentence on gains given as a bandwidth and damping given as a ratio in every drive; empty of others.
    loads : tuple of float
        Torques of the load [N*m] under each of which every drive is followed.
    speeds : Speeds or None
        Those of the project, in whose unit the speeds to avoid are written.
    remarks : tuple of str
        Effects that the numbers leave out.
    """

    rows: ClassVar[str] = "drive"

    limit: float
    factors: dict[str, Floats]
    oscillation: Floats
    at: Floats
    low: Floats
    high: Floats
    seed: int
    ranking: Ranking | None
    errors: tuple[str, ...]
    tuning: str = ""
    loads: tuple[float, ...] = ()
    speeds: Speeds | None = None
    remarks: tuple[str, ...] = ()

    @property
    def under(self) -> str:
        """Sentence on the torques of the load; empty where the load has one."""
        if len(self.loads) < 2:
            return ""
        return f"Each under {len(self.loads)} torques of its load, {self.loads[0]:.6g} to {self.loads[-1]:.6g} N*m."

    @property
    def count(self) -> int:
        """Drives."""
        return len(self.oscillation)

    @property
    def failed(self) -> int:
        """Drives without a response curve."""
        return int(np.sum(np.isnan(self.oscillation)))

    @property
    def exceeding(self) -> int:
        """Drives whose oscillation is above the limit."""
        return int(np.sum(self.oscillation > self.limit))

    @property
    def probability(self) -> float:
        """Share of the drives with a curve that exceed the limit."""
        return self.exceeding / max(self.count - self.failed, 1)

    @property
    def interval(self) -> tuple[float, float]:
        """Clopper-Pearson interval of the probability: it holds that in at least 95 % of all samples.

        Drives without a curve count as below the limit at its lower end, as above the limit at its upper one.
        """
        ends = [clopper_pearson(n, self.count) for n in (self.exceeding, self.exceeding + self.failed)]
        return ends[0][0], ends[1][1]

    def ends(self, level: float = CONFIDENCE) -> tuple[Interval, Interval] | None:
        """Intervals [rad/s] with a share `level` of the lower and of the upper ends; None where no drive has them."""
        finite = ~np.isnan(self.low)
        if not np.any(finite):
            return None
        (level,) = probabilities("level", level)
        shares = 0.5 * (1.0 - level), 0.5 * (1.0 + level)
        low = Interval(*map(float, np.quantile(self.low[finite], shares)))
        return low, Interval(*map(float, np.quantile(self.high[finite], shares)))

    def variables(self) -> Labelled:
        """Oscillation, its speed, the ends of the band and the factors of every drive."""
        factors: dict[str, Any] = {name: ("drive", values, "1") for name, values in self.factors.items()}
        speeds = {name: ("drive", getattr(self, name), "rad/s") for name in ("at", "low", "high")}
        return {"oscillation": ("drive", self.oscillation, "rad"), **speeds, **factors}

    def facts(self) -> tuple[Fact, ...]:
        """Every fact of an exceedance, once."""
        share, low, high = [f"{number(100.0 * p, 3)} %" for p in (self.probability, *self.interval)]
        rows = () if self.ranking is None else self.ranking.rows
        sizes = np.nanquantile(self.oscillation, LEVELS) if self.failed < self.count else np.full(len(LEVELS), np.nan)
        exceeding = f"{self.exceeding} of {self.count} drives exceed {{}} somewhere in the range"
        failed = f"{self.failed} of the drives have no response curve: {'; '.join(self.errors[:MOST_ERRORS])}"
        return (
            Fact("limit_rad", self.limit, exceeding),
            Fact("drives", self.count), Fact("exceeding", self.exceeding), Fact("failed", self.failed),
            Fact("probability", self.probability), Fact("interval", self.interval), Fact("confidence", CONFIDENCE),
            Fact("method", "Clopper-Pearson", f"probability {share}, 95 % confidence ({{}}) {low} to {high}"),
            Fact("oscillation_quantiles_rad", tuple(sizes.tolist()), "oscillation of 5, 50, 95 % of the drives: {}"),
            Fact("oscillation_rad", self.oscillation), Fact("at_rad_per_s", self.at),
            Fact("avoid_low_rad_per_s", self.low), Fact("avoid_high_rad_per_s", self.high),
            Fact("", self._ends_text(), "{}"),
            Fact("factors", self.factors), Fact("first_order_index", {row.path: row.index for row in rows}),
            Fact("", tuple(row.sentence for row in rows), "{}"),
            Fact("errors", self.errors), Fact("", failed, "{}" if self.failed else ""),
            Fact("load_torques_N_m", self.loads), Fact("", self.under, "{}" if self.under else ""),
            Fact("tuning", self.tuning, "{}" if self.tuning else ""),
            Fact("seed", self.seed, f"seed {self.seed}"), Fact("remarks", self.remarks, "note: {}"),
        )  # fmt: skip

    def _ends_text(self) -> tuple[str, ...]:
        """Sentence on both ends of the speeds to avoid, in the unit of the project's speeds."""
        ends, speeds = self.ends(), self.speeds
        if ends is None:
            return ()
        in_unit, unit = (float, "rad/s") if speeds is None else (speeds.own, speeds.own_unit)
        begin, end = [f"{number(in_unit(side.low), 6)} to {number(in_unit(side.high), 6)}" for side in ends]
        return (f"speeds to avoid begin at {begin} and end at {end} {unit} (95 % of the drives that exceed it)",)


def exceedance(
    project: Project,
    *,
    count: int = 200,
    seed: int = 0,
    limit: float | None = None,
    retune: bool = False,
    progress: Callable[[int, int], None] = silent,
    **options: Any,
) -> Exceedance:
    """Draw drives by the scatter of a project file and follow the response of each through its speeds.

    Every number of `scatter` is normal about that of the file, with the standard deviation given there (relative, of a
    phase an angle), cut off at three of them, and correlated as `scatter_correlation` says or independent. The curve is
    that of the whole drive, as `Project.response` follows it; where the torque of the load has a range or follows the
    load's angle, as gravity does, there is one for each of five torques of the range.

    Parameters
    ----------
    project : Project
        With `scatter`.
    count : int
        Number of drives, at least 32.
    seed : int
        The same seed gives the same drives.
    limit : float, optional
        Largest oscillation [rad] that is allowed. Default: that of the project.
    retune : bool
        True to compute gains given as a bandwidth and damping given as a ratio anew for every drive (`replaced`).
        Default: they are built once, for the drive of the file, and do not know how the numbers scatter.
    progress : callable
        progress(done, count): called after each drive.
    **options
        `store`, `client`, `workers` and `processes` of `sweep`: drives are computed elsewhere, or go on where a run
        stopped. Default: one after the other, in memory.

    Returns
    -------
    Exceedance
        `probability` that a drive exceeds the limit and its `interval` of 95 % (from 0 to 1), and the largest
        `oscillation` [rad] of each drive drawn.

    Raises
    ------
    ValueError
        If the project has no scatter or no limit.
    Interrupted
        On Ctrl-C after at least 32 drives, with their result: as of a `count` of so many.

    References
    ----------
    Clopper & Pearson 1934, Biometrika 26, 404-413 (the interval).
    """
    if positive_count("count", count, MOST_DRIVES) < LEAST_DRIVES:
        raise ValueError(f"count is {count}; it must be at least {LEAST_DRIVES} drives")
    factors = _factors(project, count, seed)
    allowed = project.limit if limit is None else checked_number("limit [rad]", limit, positive=True)
    if allowed is None:
        raise ValueError(f"{project.path.name} has no limit; write for example 'limit: {{oscillation: 60 arcsec}}'")
    if project.train is not None:
        refuse_free(project.train)
    from .project_sweep import sampled  # xarray and zarr, seconds that a refusal need not take

    def result(data: Any) -> Exceedance:
        done = int(np.argmin(np.append(data["point_status"] != NOT_COMPUTED, False)))
        if done < LEAST_DRIVES:
            few = f"{done} of {count} drives were finished, and an answer needs {LEAST_DRIVES}"
            raise KeyboardInterrupt(f"interrupted; {few}: nothing is kept") from None
        kept = {name: values[:done] for name, values in factors.items()}
        none = np.full(done, np.nan)
        top, w, low, high = (data[name].values[:done] if name in data else none for name in UNITS)
        rank = None if np.any(np.isnan(top)) else ranking(kept, top)
        errors = tuple(dict.fromkeys(re.sub(PLACE, "", error) for error in data.attrs["errors"].splitlines()))
        more = tuple(spread(project, WITH_MEMORY)), project.speeds, tuple(hysteresis_note(project))
        return Exceedance(allowed, kept, top, w, low, high, seed, rank, errors, tuning(project, kept, retune), *more)

    texts = partial(_texts, *_nominal(project))
    shown = {"progress": lambda _, share: progress(round(share * count), count) if share else None}
    how: dict[str, Any] = {"retune": retune, "chunk": 1, "workers": 1, "units": UNITS, **shown, **options}
    try:
        return result(sampled(partial(worst, allowed), project, texts, [*factors.values()], together=True, **how))
    except Interrupted as stop:
        part = result(stop.found)
        some = f"the result is that of the {part.count} drives that were finished, of {count}"
        raise Interrupted(f"interrupted; {some}", part) from None


def clopper_pearson(hits: int, count: int) -> tuple[float, float]:
    """Interval of 95 % of a probability of which `count` trials gave `hits`."""
    tail = 0.5 * (1.0 - CONFIDENCE)
    low = 0.0 if hits == 0 else float(betaincinv(hits, count - hits + 1, tail))
    return low, (1.0 if hits == count else float(betaincinv(hits + 1, count - hits, 1.0 - tail)))


def worst(limit: float, drive: Project) -> dict[str, float]:
    """Largest oscillation of a drive, its speed, and the ends of the speeds to avoid; nan where there are none."""
    torques, rows = spread(drive, WITH_MEMORY), []
    for torque in torques:
        response = (drive.under(torque) if len(torques) > 1 else drive).response()
        ends = band_above(response, limit) or (np.nan, np.nan)
        rows.append((float(response.oscillation[response.top]), float(response.omega[response.top]), *ends))
    lows, highs = np.array(rows)[:, 2:].T
    row = *max(rows)[:2], float(np.fmin.reduce(lows)), float(np.fmax.reduce(highs))
    return dict(zip(UNITS, row, strict=True))


def scattered(project: Project, count: int = 64, seed: int = 0, *, retune: bool = False) -> Iterator[Project]:
    """Draw drives by the scatter of a project file, as `exceedance` does.

    Parameters
    ----------
    project : Project
        With `scatter`.
    count : int
        Number of drives; more begin with the same ones.
    seed : int
        The same seed gives the same drives.
    retune : bool
        As of `exceedance`.

    Returns
    -------
    iterator of Project
        The drives, one after the other.

    Raises
    ------
    ValueError
        If the project has no scatter.
    """
    factors, (nominal, added) = _factors(project, count, seed), _nominal(project)
    rows = zip(*factors.values(), strict=True)
    return (replaced(project, _texts(nominal, added, row), retune=retune) for row in rows)


def _factors(project: Project, count: int, seed: int) -> dict[str, Floats]:
    """Factors (count,) of the numbers that scatter."""
    count, seed = positive_count("count", count, MOST_DRIVES), whole("seed", seed)
    if not project.scatter:
        raise ValueError(f"{project.path.name} has no scatter; write for example 'scatter: {{load.inertia: 5 %}}'")
    return drawn(project.scatter, count, seed, project.correlation)


Nominal = tuple[tuple[str, tuple[float, str]], ...]  # numbers of the file by their names, with their units


def _nominal(project: Project) -> tuple[Nominal, tuple[str, ...]]:
    """Numbers of the file that scatter, and the names of those, phases, to which something is added."""
    content: Any = read(project.text).content
    names = [(name, nominal_of(content, project.gear, name)) for name, _ in project.scatter]
    return tuple(names), tuple(name for name, size in project.scatter if isinstance(size, Radians))


def _texts(nominal: Nominal, added: tuple[str, ...], factors: Sequence[float]) -> dict[str, str]:
    """Texts of the numbers times their factors, or phases with them added."""
    return {
        name: f"{parse(f'{value!r} {unit}', 'rad') + f!r} rad" if name in added else f"{value * f!r} {unit}".rstrip()
        for (name, (value, unit)), f in zip(nominal, map(float, factors), strict=True)
    }


def drawn(scatter: tuple[tuple[str, float], ...], count: int, seed: int, correlation: Any = None) -> dict[str, Floats]:
    """Factors (count,) about 1 by name, of phases about 0 [rad], normal and cut off at CUT deviations.

    More drives begin with the same ones.
    """
    uniform = np.random.default_rng(seed).random((count, len(scatter)))
    outside = float(ndtr(-CUT))
    z = ndtri(outside + (1.0 - 2.0 * outside) * uniform)
    if correlation is not None:
        sizes, directions = np.linalg.eigh(np.array(correlation))
        z = np.clip(z @ (np.sqrt(np.maximum(sizes, 0.0)) * directions).T, -CUT, CUT)
    return {name: (0 if isinstance(size, Radians) else 1) + size * z[:, i] for i, (name, size) in enumerate(scatter)}
