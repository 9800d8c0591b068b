"""`how_sure`: what assumed numbers of damping, hysteresis, error and loop leave open in the response of a drive."""

from collections.abc import Collection, Iterable, Iterator
from contextlib import suppress
from dataclasses import replace
from itertools import pairwise, product
from math import isfinite, nan
from typing import Any, NamedTuple

import numpy as np

from ...base.facts import Fact
from ...base.number_text import number, unit_text
from ...base.results import Floats, SolveError
from ...base.sentences import listed
from ...base.units import ARCSEC
from ...drive.drive_response import DriveResponse
from ...drive.postures import LOADS, WITH_MEMORY, spread
from ...drive.project import Project
from ...drive.steady import is_beating
from ...drive.train_curve import has_curve, largest_crest
from ...model.laws.dry import is_dry
from ..fields.groups import ASSUMED
from ..project_text import project_text
from ..reading import from_text
from .names import quantity
from .replaced import replaced

CURVE_POINTS, BAND_SPEEDS = 40, 200  # about so many points of each curve; speeds of the band
# 2 to 5 % of damping for 3 %, as in the report; an accuracy class is what an error has at most.
# A hysteresis loss of a catalogue is an upper bound; that of another gear may be too small.
RANGES = {  # by how names begin: what they are, and the ends of the range over the value
    "damping.": ("damping", 2.0 / 3.0, 5.0 / 3.0), "hysteresis.": ("hysteresis", 0.5, 1.5),
    "hysteresis": ("yield twist of the hysteresis", 0.5, 1.5), "excitation.": ("kinematic error", 0.5, 1.0),
    "motor.loop.bandwidth": ("bandwidth", 2.0 / 3.0, 1.5),
}  # fmt: skip
SCALED_NAMES = ("damping.ratio", "damping.B", "damping.quality", "motor.loop.bandwidth", "excitation.accuracy")
SCALED_ENDINGS = {  # of a hysteresis: its torque is proportional to all of the first together
    "hysteresis.": (
        ".K", ".K1", ".K2", ".K3", ".T1", ".T2", ".T_c", ".T_s", ".B", ".D", ".sigma_0", ".sigma_1", ".sigma_2",
    ),
    "hysteresis": (".yield_twist",),
}  # fmt: skip


INNER_SHARES = tuple(k / 8 for k in range(1, 8))  # shares of a range at which an inner largest is looked for
BESIDE, HALVINGS, FLAT = 1 / 16, 5, 0.01  # and beside one of another case; halvings at most, until so flat a top

HEADS = "assumed", "value", "low", "high", "oscillation [arcsec] from", "to"
Case = tuple[float | None, ...]  # of each group of numbers: at which share of its range it is, or as it is


class Doubt(NamedTuple):
    """Numbers that are assumed together, with the ends of their range, and the ends of the oscillation [rad]."""

    what: str
    names: tuple[str, ...]
    value: str
    ends: tuple[str, str]
    sizes: tuple[float, float]

    def row(self) -> tuple[Fact, ...]:
        """Its row in a table."""
        texts = self.what, self.value, *self.ends, *(number(size / ARCSEC, 3) for size in self.sizes)
        return tuple(Fact("", unit_text(text), head) for text, head in zip(texts, HEADS, strict=True))

    @property
    def sentence(self) -> str:
        """Its assumption, its range, and what that gives."""
        sizes = " to ".join(number(size / ARCSEC, 3) for size in self.sizes)
        what = f"{self.what[:1].upper()}{self.what[1:]} {self.value}"
        return f"{what} is assumed; {unit_text(' to '.join(self.ends))} gives an oscillation of {sizes} arcsec"


class Sureness(NamedTuple):
    """Range of the answer that assumed numbers leave open.

    Attributes
    ----------
    doubts : tuple of Doubt
        Each assumed number changed alone; none where nothing is assumed.
    omega, low, high : (n,) arrays
        Speeds of the base angle [rad/s], and the least and the largest oscillation [rad] of the stable motions of all
        drives that were computed: every number at the ends of its range, alone and with the others. NaN where none has
        a stable motion.
    largest : (float, float)
        Least and largest of the largest oscillations [rad] of these drives.
    drives : int
        Number of these drives.
    lost : tuple of str
        Reasons why others have no answer, an unstable loop for one.
    load : str
        Loads that all of this is for, where the file has a range of torques: its ends, its mean and that of the drive's
        largest oscillation; of a law with memory the last alone, by its torque.
    """

    doubts: tuple[Doubt, ...]
    omega: Floats
    low: Floats
    high: Floats
    largest: tuple[float, float]
    drives: int
    lost: tuple[str, ...] = ()
    load: str = ""

    def sentences(self, limit: float | None) -> tuple[str, ...]:
        """A row for every assumed number, and the `conclusions`."""
        return *(doubt.sentence for doubt in self.doubts), *self.conclusions(limit)

    def conclusions(self, limit: float | None) -> tuple[str, ...]:
        """All assumed numbers together, where there are any, and why other drives have no answer."""
        return (self.together(limit), *self.lost) if self.doubts else self.lost

    def together(self, limit: float | None) -> str:
        """All assumed numbers, of which there is one at least, together against the limit [rad]."""
        ends = " to ".join(number(size / ARCSEC, 3) for size in self.largest)
        whats = f"oscillation with assumed {listed(doubt.what for doubt in self.doubts)} varied"
        sentence = f"{whats}{' together' if len(self.doubts) > 1 else ''}{self.load}: {ends} arcsec"
        if limit is not None:
            inside, least = self.largest[1] <= limit, self.largest[0] > limit
            where = "within" if inside else "above" if least else "below and above"
            sentence += f", {where} the limit of {number(limit / ARCSEC)} arcsec"
        return sentence

    def facts(self, limit: float | None = None) -> tuple[Fact, ...]:
        """The rows, and the ends of the largest oscillation."""
        keys = ("what", "value", "from", "to", "least_arcsec", "most_arcsec")
        rows = tuple(tuple(map(Fact, keys, (d.what, d.value, *d.ends, *d.sizes))) for d in self.doubts)
        return (
            Fact("how_sure.rows", rows),
            *(Fact(f"how_sure.{key}", size) for key, size in zip(keys[4:], self.largest, strict=True) if self.doubts),
            Fact("", tuple(doubt.row() for doubt in self.doubts), "{}"),
            Fact("", self.conclusions(limit), "how sure: {}"),
        )


def solved(project: Project) -> DriveResponse:
    """The response of a drive with its assumed numbers at other values, of a whole train without its torques."""
    response = project.train_response(coexisting=False, points=CURVE_POINTS, torques=False)
    return project.response(coexisting=False, points=CURVE_POINTS) if response is None else response


def largest(project: Project) -> float:
    """Largest oscillation [rad] of that response: of a train without dry friction its crest, where that is stable."""
    train = project.train
    if train is not None and has_curve(train) and not (is_dry(train) or is_beating(train.error)):
        crest = largest_crest(train, project.speeds.limits, None, False, CURVE_POINTS)
        if crest is not None and crest.stable:
            return crest.size
    response = solved(project)
    return float(response.oscillation[response.top])


def how_sure(project: Project, band: bool = True) -> Sureness:
    """Follow the response of a drive with its assumed numbers at the ends of what is usual.

    A damping that the file calls assumed goes from two thirds to five thirds of its value, 2 to 5 % for 3 %; an error
    from half of its value to all of it, as a class is an upper bound; a bandwidth from two thirds to one and a half;
    the torque of a hysteresis, and the torsion at which it yields, from half of it to one and a half. Damping and gains
    are computed anew for each drive. Of a range of loads each is followed under the torques of `load`, and the largest
    oscillation counts. A project that is changed in Python is written as a file first; where no file holds it, nothing
    is computed. Without the `band` the stability of their curves is looked at where it matters to the largest alone, in
    half the time, and `low` and `high` are NaN.
    """
    omega = np.linspace(*project.speeds.limits, BAND_SPEEDS)
    if any(_assumed(project)):
        try:
            project = _as_a_file(project)
        except ValueError as error:
            why = f"The range for assumed values is not computed: {error}"
            return Sureness((), omega, omega * nan, omega * nan, (nan, nan), 0, (why,))
    groups = tuple(_assumed(project))
    drives = _Drives(project, groups, _torques(project) if groups else (), omega, band)
    plain = (None,) * len(groups)
    corners = [*product((0.0, 1.0), repeat=len(groups))] if groups else []
    for case in (*(_with_share(plain, i, end) for i in range(len(groups)) for end in (0.0, 1.0)), *corners):
        drives.size(case)
    inner = [drives.worst_share(i, plain, INNER_SHARES if group.shifts else (0.5,)) for i, group in enumerate(groups)]
    for i, share in enumerate(inner):
        if groups[i].shifts and len(groups) > 1:
            others = [_with_share(corner, i, share) for corner in corners if corner[i]]
            best = max(others, key=lambda case: drives.size(case) or 0.0)
            drives.worst_share(i, best, tuple(x for x in (share - BESIDE, share, share + BESIDE) if 0.0 <= x <= 1.0))
    sizes = drives.sizes.items()
    sides = [_extremes([s for case, s in sizes if _with_share(case, i, None) == plain]) for i in range(len(groups))]
    doubts = tuple(
        Doubt(what, tuple(group.names), _texts(group, 1.0), (_texts(group, low), _texts(group, high)), side)
        for group, side in zip(groups, sides, strict=True)
        for what, low, high in [RANGES[group.key]]
        if isfinite(side[0])
    )
    number_of = sum(size is not None for size in drives.computed.values())
    torques, ends = drives.torques, _extremes(drives.sizes.values())
    load = f" under the worst of {len(torques)} load torques" if len(torques) > 1 else ""
    load = unit_text(f" under a load torque of {number(torques[0])} N·m") if len(torques) == 1 else load
    return Sureness(doubts, omega, drives.low, drives.high, ends, number_of, tuple(drives.lost), load)


class _Drives:
    """The drives of a project with other numbers in place of those assumed, each computed once.

    Attributes
    ----------
    sizes : dict
        Largest oscillation [rad] of every case that has one.
    low, high : (n,) arrays
        Least and largest oscillation [rad] of all at speeds `omega` [rad/s].
    computed : dict
        The same by the texts that are changed: a number may be an end of its range.
    """

    def __init__(
        self, project: Project, groups: "tuple[Group, ...]", torques: tuple[float, ...], omega: Floats, band: bool
    ) -> None:
        self.project, self.groups, self.torques, self.omega, self.band = project, groups, torques, omega, band
        self.low, self.high = omega * nan, omega * nan
        self.sizes, self.lost = dict[Case, float](), dict[str, None]()
        self.computed = dict[frozenset[tuple[str, str]], float | None]()
        if groups:
            self.size((None,) * len(groups))

    def size(self, case: Case) -> float | None:
        """Largest oscillation [rad] of a case; None where it has none."""
        changes: dict[str, str] = {}
        for group, share in zip(self.groups, case, strict=True):
            texts = {} if share is None else {name: _scaled(t, group.factor(share)) for name, t in group.names.items()}
            changes |= {name: text for name, text in texts.items() if text != _scaled(group.names[name], 1.0)}
        key = frozenset(changes.items())
        if key not in self.computed:
            try:
                variant = replaced(self.project, changes, retune=True) if changes else self.project
                loads = [variant.under(torque) for torque in self.torques] or [variant]
                self.computed[key] = max(map(self.one_size, loads))
            except (ValueError, SolveError) as error:
                self.computed[key], self.lost[f"One variant cannot be computed: {error}"] = None, None
        if (size := self.computed[key]) is not None:
            self.sizes[case] = size
        return size

    def one_size(self, project: Project) -> float:
        """Largest oscillation [rad] of one drive, whose curve widens the band."""
        if not self.band:
            return largest(project)
        response = solved(project)
        for indices, values in _stretches(response, self.omega):
            self.low[indices] = np.fmin(self.low[indices], values)
            self.high[indices] = np.fmax(self.high[indices], values)
        return float(response.oscillation[response.top])

    def worst_share(self, i: int, case: Case, shares: tuple[float, ...]) -> float:
        """Share of the range of group i with the largest oscillation, the others as in a case.

        A resonance that passes the speeds with the number has its largest within the range: around the largest that is
        known, the range is halved until its neighbours are nearly as large. Where the ends are the largest of few, they
        are taken.
        """
        sizes, top, added = dict[float, float](), 0.0, [0.0, 1.0, *shares]
        for _ in range(1 + HALVINGS):
            sizes |= {x: self.size(_with_share(case, i, x)) or 0.0 for x in added}
            top, xs = max(sizes, key=lambda x: sizes[x]), sorted(sizes)
            if top in (0.0, 1.0) and not self.groups[i].shifts:
                break
            around = xs[max(xs.index(top) - 1, 0) : xs.index(top) + 2]
            added = [0.5 * (top + x) for x in around if sizes[x] < (1.0 - FLAT) * sizes[top]]
        return top


def _with_share(case: Case, i: int, share: float | None) -> Case:
    """A case with another share of group i."""
    return (*case[:i], share, *case[i + 1 :])


def _torques(project: Project) -> tuple[float, ...]:
    """Torques [N*m] on the load that a range of them is tried at."""
    if not project.other_loads[0] < project.other_loads[1]:
        return ()
    sizes = dict[float, float]()
    others = spread(project, WITH_MEMORY if project.has_memory else LOADS)
    for torque in dict.fromkeys((project.mean_load_torque, *others)):
        with suppress(ValueError, SolveError):
            sizes[torque] = largest(project.under(torque))
    worst = max(sizes, key=lambda torque: sizes[torque], default=project.mean_load_torque)
    return (worst,) if project.has_memory else tuple(sorted({*project.other_loads, project.mean_load_torque, worst}))


def _as_a_file(project: Project) -> Project:
    """The project, or where it is not what its text and changes of its gear's law say, one that a file says."""
    same = replaced(project, {})
    if replace(same, text=project.text, notes=project.notes, gear=project.gear) == project:
        return project
    return from_text(project_text(project), project.path)


def _extremes(sizes: Collection[float]) -> tuple[float, float]:
    """Least and largest of some sizes; NaN of none."""
    return min(sizes, default=nan), max(sizes, default=nan)


class Group(NamedTuple):
    """Numbers that are assumed together: their key in `RANGES`, and the text of each by its name."""

    key: str
    names: dict[str, str]

    @property
    def shifts(self) -> bool:
        """True for numbers that shift resonances: the largest oscillation may lie anywhere in their range."""
        return self.key not in ("damping.", "excitation.")

    def factor(self, share: float) -> float:
        """Factor at a share of the range."""
        _, low, high = RANGES[self.key]
        return float(low * (high / low) ** share)


def _assumed(project: Project) -> Iterator[Group]:
    """Numbers that are assumed, by those that are changed together."""
    texts = {one.name: one.value for one in project.sources if one.word == ASSUMED}
    for key in RANGES:
        names = [name for name in texts if name.startswith(key) and _is_scaled(key, name) and quantity(texts[name])[0]]
        if names:
            yield Group(key, {name: texts[name] for name in names})


def _texts(group: Group, factor: float) -> str:
    """The numbers of a group times a factor, each that differs once."""
    return listed(dict.fromkeys(unit_text(_scaled(t, factor).replace("^", "**")) for t in group.names.values()))


def _is_scaled(group: str, name: str) -> bool:
    """True for a number that is scaled with its group, not for a phase or a type beside it."""
    endings = SCALED_ENDINGS.get(group, ".amplitude" if ".kinematic_error." in name else ())
    return name in SCALED_NAMES or name.endswith(endings)


def _scaled(text: str, factor: float) -> str:
    """Text of a number with its unit, times a factor."""
    value, unit = quantity(text)
    product = (value or 0.0) if factor == 1.0 else float(f"{factor * (value or 0.0):.4g}")  # computed as it is printed
    return f"{product:.6g} {unit}".rstrip()


def _stretches(response: DriveResponse, omega: Floats) -> Iterable[tuple[Any, Any]]:
    """Numbers of speeds [rad/s] that each step between two stable motions passes, with the oscillation [rad] there."""
    visited = response.visited()
    for i, j in pairwise(visited):
        if j == i + 1:
            first, last = (i, j) if response.omega[i] < response.omega[j] else (j, i)
            inside = np.flatnonzero((omega >= response.omega[first]) & (omega <= response.omega[last]))
            yield inside, np.interp(omega[inside], response.omega[[first, last]], response.oscillation[[first, last]])
