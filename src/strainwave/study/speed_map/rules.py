"""Rules that forbid a speed: a limit on the oscillation, on its amplification, a margin from the resonances.

Intervals are arrays (n, 2) of speeds [rad/s], ascending and apart.

The vendors' resonance rule beside the map: one linear frequency, f_n = sqrt(K1/J_l)/(2 pi), at 30 f_n rpm. The torques
and speeds of a speed map against the limits of its gear and its motor.
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise, product
from math import inf, pi, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...base.facts import Fact
from ...base.quantities import number
from ...base.results import Floats
from ...base.sentences import number as written
from ...base.units import BASES, RPM
from ...base.units import Speeds as Axis
from ...drive.asked import BRAKE, PEAK, RMS, MotorLimits, Need
from ...drive.drive_response import MotorUse, Usage, limit_findings
from ...drive.project import Project
from ...model.gears.limits import Finding, check_limits, gravest
from .bands import AMPLIFIED, between, hulls_between, merged
from .bands import Motions as Sizes
from .motions import MEAN, MOTOR, OMEGA, OSCILLATION, TORQUE, UnderLoad
from .motions import RMS as OF_RMS

# f_n [Hz] that the vendor's selection procedure asks for, and where
REQUIRED = (
    (4.0, "slow turntables, slow welding base axes, gantry axes"),
    (8.0, "robot base axes, low-dynamic hand axes, tool revolvers, medical and measuring positioning"),
    (15.0, "general mechanical engineering, tilting axes, hand axes, Scara and gantry robots"),
    (20.0, "B and C axes of 5-axis grinding, laser-welding hand axes, milling heads for plastics"),
    (25.0, "C axes of turning machines, milling of light metal and chipboard"),
    (30.0, "milling of hardwood"),
)

MARGIN = 0.1  # separation margin of torsional trains: 10 % (API 617 after Wang, Feese & Pettinato 2012)

ROUNDING_FACTOR = 1.0 + 1e-9  # times a bound: beyond it, and not by rounding

FOLD_WIDTH = 1e-3  # relative width within which a motion at a fold may be found stable or not

Span = tuple[float, float]

NO_USAGE = Usage(0.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Rules:
    """Rules that forbid a speed; None is no rule.

    Attributes
    ----------
    limit : float or None
        Largest oscillation of the error [rad] that is allowed.
    amplification : float or None
        Largest oscillation that is allowed, relative to that of quasi-static rotation.
    margin : float or None
        Separation margin: no speed is nearer than this share to a resonance, from where its backbone begins to where
        its peak lies.
    speed, motor_torque : float or None
        Largest speed of the motor [rad/s], of its gear or its own, where the map goes beyond it, and largest torque of
        the motor [N*m].
    sheet : MotorLimits or None
        Limits of the motor's peak and rms torque, which may depend on its speed.
    gear_torque, mean_torque : float or None
        Largest torque in the gear [N*m], and its largest cubic mean over a turn.
    """

    limit: float | None = None
    amplification: float | None = None
    margin: float | None = None
    speed: float | None = None
    motor_torque: float | None = None
    sheet: MotorLimits | None = None
    gear_torque: float | None = None
    mean_torque: float | None = None

    def level(self, quasi_static: float) -> float:
        """Oscillation [rad] from which on a speed is forbidden."""
        amplified = np.inf if self.amplification is None else self.amplification * quasi_static
        return min(np.inf if self.limit is None else self.limit, amplified)


def rules_of(
    limit: float | None, amplification: float | None, margin: float | None, limit_of_project: float | None
) -> Rules:
    """Rules from the arguments of the verb, or the project's own limit; by themselves twice the quasi-static error."""
    limit = None if limit is None else number("limit [rad]", limit, positive=True)
    amplification = None if amplification is None else number("amplification", amplification, positive=True)
    margin = None if margin is None else number("margin", margin, positive=True)
    if margin is not None and not margin < 1.0:
        raise ValueError(f"margin is {margin:g}; it is a share of the speed and must be less than 1, as 0.1 for 10 %")
    if limit is None and amplification is None and margin is None:
        return Rules(limit=limit_of_project) if limit_of_project is not None else Rules(amplification=AMPLIFIED)
    return Rules(limit, amplification, margin)


class Bands(NamedTuple):
    """Forbidden and allowed speeds under one load."""

    forbidden: Floats
    allowed: Floats


def none(span: Span) -> Bands:
    """Bands that allow no speed, as where the motor's loop is unstable."""
    return Bands(as_intervals([span]), as_intervals([]))


def bands_of(loaded: UnderLoad, rules: Rules, span: Span, resonances: Iterable[Span], apart: float) -> Bands:
    """Apply the rules to all stable motions under a load.

    Parameters
    ----------
    loaded : UnderLoad
        The motions.
    rules : Rules
        What is forbidden.
    span : (float, float)
        Range of speeds [rad/s].
    resonances : list of (float, float)
        Speeds [rad/s] over which each resonance bends, for the margin.
    apart : float
        Distance of the speeds that were searched, relative to each: how far a motion that no curve has may reach.
    """
    level = rules.level(loaded.quasi_static)
    bands: list[Span] = [band for run, _ in loaded.runs for band in above(run, level)]
    for bound, column in ((rules.gear_torque, TORQUE), (rules.mean_torque, MEAN)):
        if bound is not None:
            bands += [band for run, _ in loaded.runs for band in above(run, bound * ROUNDING_FACTOR, column)]
    bands += loaded.jumping
    for flip in loaded.flips:  # what follows repeats after more turns: its own motions decide where they are known
        bands += gaps([(run[0, OMEGA], run[-1, OMEGA]) for run, slower in loaded.runs if slower], flip)
    bands += gaps([(run[0, OMEGA], run[-1, OMEGA]) for run, _ in loaded.runs], span)
    bands += [(w / (1.0 + apart), w * (1.0 + apart)) for w, size, torque, _ in loaded.loose
              if size > level or torque > (inf if rules.gear_torque is None else rules.gear_torque)]  # fmt: skip
    bands += beyond_sheet(needs_of(loaded), rules.sheet)
    if rules.speed is not None:
        bands.append((rules.speed, span[1]))
    if rules.margin is not None:
        bands += [((1.0 - rules.margin) * low, (1.0 + rules.margin) * high) for low, high in resonances]
    forbidden = clipped(bands, span)
    if loaded.loose:  # between two forbidden speeds no nearer one was searched: a motion that no curve has may go on
        narrow = [(low, high) for low, high in complement(forbidden, span) if high < low * (1.0 + apart)]
        inside = [(low, high) for low, high in narrow if low > span[0] and high < span[1]]
        forbidden = clipped([*map(tuple, forbidden), *inside], span)
    return Bands(forbidden, complement(forbidden, span))


def above(run: Floats, level: float, column: int = OSCILLATION) -> list[Span]:
    """Bands of a run in which the oscillation, or another column, is above a level; ends by linear interpolation."""
    return Sizes(run[:, OMEGA], run[:, column], np.ones(len(run), bool)).above(level)


def needs_of(loaded: UnderLoad) -> list[Need]:
    """Demands of the runs under a load on the motor."""
    return [Need(run[:, OMEGA], run[:, MOTOR], run[:, OF_RMS], np.ones(len(run) - 1, bool)) for run, _ in loaded.runs]


def beyond_sheet(needs: Iterable[Need], sheet: MotorLimits | None) -> Iterator[Span]:
    """Bands in which motions ask for more than the motor's peak or rms torque."""
    for need, limit in product(needs, (PEAK, RMS) if sheet else ()):
        omega, torque, available, joined = need.against(sheet or MotorLimits(), limit)
        yield from Sizes(omega, torque - available, joined).above(0.0)


def swept(first: Floats, second: Floats) -> list[Span]:
    """Bands of two loads, and what those that belong together pass between the loads."""
    left, right = [tuple((float(low), float(high)) for low, high in bands) for bands in (first, second)]
    return [*left, *right, *hulls_between(left, right)]


def gaps(spans: list[Span], within: Span) -> list[Span]:
    """Parts of a range that no span covers; gaps narrower than a fold is sharp are left out."""
    return list(between(clipped(spans, within), within, FOLD_WIDTH))


def clipped(spans: list[Span], within: Span) -> Floats:
    """Intervals inside a range, merged."""
    inside = [(max(low, within[0]), min(high, within[1])) for low, high in spans]
    return as_intervals(merged([span for span in inside if span[0] < span[1]]))


def complement(intervals: Floats, within: Span) -> Floats:
    """Intervals of a range that are not among these."""
    return as_intervals(between(intervals, within, 0.0))


def common(first: Floats, second: Floats) -> Floats:
    """Intersection of two sets of intervals."""
    pairs = [(max(a, c), min(b, d)) for a, b in first for c, d in second]
    return as_intervals(merged([pair for pair in pairs if pair[0] < pair[1]]))


def as_intervals(spans: object) -> Floats:
    """Array (n, 2) of spans."""
    return np.array(spans, float).reshape(-1, 2)


def holds(intervals: Floats, omega: Floats) -> NDArray[np.bool_]:
    """True if speeds (n,) lie in the intervals, (n,) bool."""
    inside = (omega[:, None] >= intervals[:, 0]) & (omega[:, None] <= intervals[:, 1])
    return np.asarray(np.any(inside, axis=1))


@dataclass(frozen=True, eq=False)
class VendorRule:
    """Vendors' rule under one load, against the map.

    Attributes
    ----------
    load : float
        Torque [N*m] or inertia [kg*m^2].
    frequency : float
        f_n [Hz].
    speed : float
        Resonance speed of the motor [rad/s], 30 f_n rpm.
    band : (low, high)
        What it is taken to forbid [rad/s].
    safe, needless, misleading : (n, 2) arrays
        Speeds [rad/s] that it and the map allow; that it alone forbids; that it allows and the map forbids.
    """

    load: float
    frequency: float
    speed: float
    band: Span
    safe: Floats
    needless: Floats
    misleading: Floats

    def facts(self) -> tuple[Fact, ...]:
        """Its numbers."""
        return (
            Fact("f_n_Hz", self.frequency), Fact("speed_rpm", self.speed), Fact("safe_rpm", self.safe),
            Fact("needless_rpm", self.needless), Fact("misleading_rpm", self.misleading),
            Fact("sentence", self.sentence), Fact("meets", self.meets),
        )  # fmt: skip

    @property
    def meets(self) -> tuple[str, ...]:
        """Applications whose required f_n the drive has."""
        return tuple(name for least, name in REQUIRED if self.frequency >= least)

    @property
    def sentence(self) -> str:
        """Sentence on the rule under this load."""
        speed = f"f_n = {self.frequency:.4g} Hz, {self.speed / RPM:.5g} rpm"
        parts = [f"forbids {listed(self.needless)} needlessly"] * bool(len(self.needless))
        parts += [f"allows {listed(self.misleading)} although the map forbids it"] * bool(len(self.misleading))
        return f"The vendors' rule ({speed}) " + (" and ".join(parts) if parts else "agrees with the map") + "."


def vendor_sentence(rules: Sequence[VendorRule]) -> str:
    """Sentence on the rule over all loads; empty without a rule."""
    if len(rules) < 2:
        return rules[0].sentence if rules else ""
    ends = [min(rules, key=lambda rule: rule.speed), max(rules, key=lambda rule: rule.speed)]
    f_n = " to ".join(dict.fromkeys(f"{rule.frequency:.4g}" for rule in ends))
    speed = " to ".join(dict.fromkeys(f"{rule.speed / RPM:.5g}" for rule in ends))
    parts = []
    for name, text in (
        ("needless", "forbids {1}{0} needlessly under {2} of {3} loads"),
        ("misleading", "allows {0}, {1}which the map forbids under {2} of {3} loads"),
    ):
        some = [getattr(rule, name) for rule in rules if len(getattr(rule, name))]
        if some:
            spans = merged((float(low), float(high)) for low, high in np.concatenate(some))
            same = all(np.array_equal(bands, spans) for bands in some)
            parts.append(text.format(listed(np.array(spans)), "" if same else "parts of ", len(some), len(rules)))
    return f"The vendors' rule (f_n = {f_n} Hz, {speed} rpm) " + (
        ", and ".join(parts) + "." if parts else "agrees with the map under every load."
    )


def vendor_rules(
    projects: Sequence[Project], loads: Floats, bands: Sequence[Bands], span: Span
) -> Iterator[VendorRule]:
    """Compare the rule for the stiffness of the gear and the inertia of the load with the bands of every load.

    It is about order 2 of a motor, so that the speeds of a forcing have none.
    """
    for project, load, ruled in zip(projects, loads.tolist(), bands, strict=True):
        drive, gear = project.drive, project.gear
        K1 = drive.J_l * drive.omega_0_held**2 if gear is None else float(gear.law.stiffness(0.0))
        if K1 > 0.0 and project.speeds.by_motor:
            frequency = sqrt(K1 / drive.J_l) / (2.0 * pi)
            speed = 30.0 * frequency * RPM
            band = (1.0 - MARGIN) * speed, (1.0 + MARGIN) * speed
            inside = clipped([band], span)
            outside = complement(inside, span)
            parts = (outside, ruled.allowed), (inside, ruled.allowed), (outside, ruled.forbidden)
            yield VendorRule(load, frequency, speed, band, *(common(*both) for both in parts))


def windows(forbidden: Sequence[Floats], span: Span, joined: Sequence[bool]) -> Floats:
    """Speeds allowed under all loads; bands of two neighbours that are `joined`, (n - 1,) flags, enclose none."""
    pairs = [pair for pair, both in zip(pairwise(forbidden), joined, strict=True) if both]
    bands = [band for first, second in (*((one, one) for one in forbidden), *pairs) for band in swept(first, second)]
    return as_intervals(between(clipped(bands, span), span))


def listed(intervals: Floats, axis: Axis = BASES["motor"]) -> str:
    """Intervals of a speed, in rpm of the motor or rad/s of a forcing."""
    return ", ".join(f"{written(low * axis.scale, 5)} to {axis.said(high, 5)}" for low, high in np.asarray(intervals))


def with_ratings(rules: Rules, project: Project, span: Span) -> Rules:
    """The rules with the speeds and the motor torque by which a drive of this gear and motor fails."""
    bounds = [f.bound * RPM for f in _findings(project, span[1], NO_USAGE) if f.fails]
    largest = math.inf if project.motor_limits is None else project.motor_limits.torque
    torque = largest if math.isfinite(largest) else None
    findings = () if project.gear is None else check_limits(project.gear, peak_torque=0.0, average_torque=0.0)
    ends = {f.limit: f.bound for f in findings}
    mean = ends.pop("average_torque", None)
    return replace(
        rules, speed=min(bounds, default=None), motor_torque=torque, sheet=project.motor_limits,
        gear_torque=min(ends.values(), default=None), mean_torque=mean,
    )  # fmt: skip


def beyond_ratings(
    project: Project, fastest: float, by_load: list[UnderLoad], texts: dict[float, str], resting: float
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Sentences about limits that the motions pass: those by which the drive fails, and others.

    The largest speed [rad/s], the motions under each load, its name by the load, and the torque [N*m, motor side] of
    the loads at rest.
    """
    worst = dict[str, tuple[Finding, str]]()
    for loaded in by_load:
        used, use = asked_under(loaded)
        places = {"average_torque": used.at_average, PEAK: use.at}
        for finding in _findings(project, fastest, used, use, needs_of(loaded), resting):
            omega = places.get(finding.limit, used.at_peak) if finding.omega is None else finding.omega
            where = f" (at {project.speeds.said(omega, 5)} under {texts[loaded.load]})"
            placed = finding.unit != "rpm" and finding.limit != BRAKE
            row = finding, finding.sentence + where * placed
            worst[finding.limit] = max(worst.get(finding.limit, row), row, key=lambda r: r[0].value - r[0].bound)
    passed = gravest(tuple(finding for finding, _ in worst.values()))
    sentences = [(f.fails, worst[f.limit][1]) for f in passed]
    return tuple(text for fails, text in sentences if fails), tuple(text for fails, text in sentences if not fails)


def asked_under(loaded: UnderLoad) -> tuple[Usage, MotorUse]:
    """Largest torques that the motions under a load ask of the gear and of the motor, with their speeds."""
    table = np.concatenate([np.zeros((1, MEAN + 1)), *(run for run, _ in loaded.runs)])
    torque, mean, motor = (table[np.argmax(table[:, column])] for column in (TORQUE, MEAN, MOTOR))
    loose = [(one.torque, one.omega) for one in loaded.loose if math.isfinite(one.torque)]
    used = Usage(*max([(float(torque[TORQUE]), float(torque[OMEGA])), *loose]), float(mean[MEAN]), mean[OMEGA])
    return used, MotorUse(float(motor[MOTOR]), motor[OMEGA], 0.0)


def findings_under(project: Project, loaded: UnderLoad) -> tuple[Finding, ...]:
    """Limits of gear and motor that the motions under one load of a project pass, the gravest first."""
    resting = max(map(abs, project.load_torques)) / project.drive.N
    findings = _findings(project, project.speeds.given[-1], *asked_under(loaded), needs_of(loaded), resting)
    passed = gravest(tuple(one for one in findings if one.exceeded))
    return tuple(sorted(passed, key=lambda one: one.limit == "average_torque"))


def _findings(
    project: Project, fastest: float, used: Usage, motor: MotorUse | None = None, needs: Iterable[Need] = (),
    resting: float | None = None,
) -> tuple[Finding, ...]:  # fmt: skip
    speed = fastest if project.speeds.by_motor else None
    return limit_findings(project.gear, used, speed, project.motor_limits, motor, needs, resting)
