"""`variability`: what the scatter of a drive's parameters does to its peak error, its jumps and its resonances.

Independent random drives (no grid, no stratification), so that every standard error printed is that of plain sampling.
"""

from collections.abc import Mapping
from contextlib import suppress
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..base.law import is_spring, repeating
from ..base.protocols import System, lacking, state_count, with_parts
from ..base.quantities import SMALLEST, interval, number, numbers, parameters, positive_count, replace, shown, whole
from ..base.results import Branch, Floats, SolveError
from ..drive.jumps import jumps
from ..numerics.attractors.settle import SEEN, settled
from ..numerics.balance.harmonics import whole_orders
from ..numerics.curves.response import response_family
from ..numerics.ensemble.request import LaneError, check_lanes
from ..numerics.operating_point import operating_points
from ..theory.slow_flow.setting import active_orders
from .points import described
from .result import Band, JumpSpread, SpeedSpread, Variability, ranking, running_quantile
from .sampling import MOST_DRIVES, TOGETHER, Distribution, by_path, check_names, named

ANGLES = 2.0 * np.pi * np.arange(64)[:, None] / 64
AT_A_TIME = 256  # drives of which natural frequencies are computed at a time
LEAST = 32  # drives, for quantiles and rankings to mean anything


def variability(
    system: Any,
    distributions: Mapping[str, Any],
    *,
    speeds: ArrayLike | None = None,
    count: int = 2000,
    seed: int = 0,
    quantiles: ArrayLike = (0.05, 0.5, 0.95),
    settle: int = 200,
    longest: int = 3000,
    jump_span: tuple[float, float] | None = None,
    jump_count: int = 64,
    speed_band: tuple[float, float] | None = None,
    amplitude: float = 0.0,
    threads: int | None = None,
) -> Variability:
    """Draw drives at random and tell how their peak error, jump speeds and resonances scatter, and why.

    The peak error is that of the motion that starts from rest, after it has settled. Where several motions coexist
    that is one of them, and drives may end on different ones; `basins` tells about the others.

    Parameters
    ----------
    system : Oscillator
        The drive; what has no distribution stays as it is.
    distributions : dict of str to Uniform, LogUniform, Normal, or a frozen distribution of scipy.stats
        Path of a parameter to its distribution (SI units), as in ``{"law.K": sw.Normal(1e5, 5e3)}``. They are
        independent of each other. A tuple of paths has the distribution of a factor that scales them together:
        ``{("law.K1", "law.K2", "law.K3"): sw.Normal(1.0, 0.05)}``; results name it "law.K1 & law.K2 & law.K3".
    speeds : (speeds,) array_like, optional
        Base speeds [rad/s] at which the peak error is computed. Default: the system's omega.
    count : int
        Number of drives, at least 32.
    seed : int
        The same seed gives the same drives and numbers.
    quantiles : (quantiles,) array_like
        Shares of the drives, between 0 and 1.
    settle, longest : int
        Turns before the first look at a motion, and in all.
    jump_span : (float, float), optional
        Range of omega [rad/s] in which to follow response curves; without it no jumps are looked for.
    jump_count : int
        How many of the drives are followed.
    speed_band : (float, float), optional
        Range of omega [rad/s]: how probable is it that a line of the excitation meets the natural frequency there?
    amplitude : float
        Amplitude [rad] of vibration at which the natural frequency is taken (describing function); 0: small.
    threads : int, optional
        Default: as many as there are processors.

    Returns
    -------
    Variability
        Quantiles of the peak error [rad] at `speeds`, of the speeds of `jumps` [rad/s] and of resonances
        (`band`), over the `drives` drawn.

    Raises
    ------
    ValueError, TypeError
        If there is no such parameter, a distribution gives an impossible drive, or a count or share is out of range.

    References
    ----------
    Saltelli et al. 2008, Global Sensitivity Analysis: The Primer, secs. 1.2.5 (regression), 1.2.6-1.2.8 (first-order
    index).
    """
    system = repeating(
        "variability", with_parts("variability", system, "J", "B", "law", "excitation", "omega", "error")
    )
    whole_orders(system)
    if positive_count("count", count, MOST_DRIVES) < LEAST:
        raise ValueError(f"count is {count}; it must be at least {LEAST} drives")
    shares = np.sort(numbers("quantiles", quantiles))
    if not (shares[0] > 0.0 and shares[-1] < 1.0):
        raise ValueError(f"quantiles are {shown(quantiles)}; they must be shares between 0 and 1")
    grid = numbers("speeds", system.omega if speeds is None else speeds)
    if not np.all(grid >= SMALLEST):
        raise ValueError(f"speeds are {shown(speeds)}; they must be positive, {SMALLEST:g} rad/s up")
    follow = positive_count("jump_count", jump_count)
    settle, longest = positive_count("settle", settle), positive_count("longest", longest)
    if longest < settle + SEEN:
        raise ValueError(f"longest is {longest} turns; it must be at least settle + {SEEN} = {settle + SEEN}")
    span = None if jump_span is None else interval("jump_span", jump_span, positive=True)
    bounds = None if speed_band is None else interval("speed_band", speed_band, positive=True)
    number("amplitude", amplitude)
    if amplitude < 0.0:
        raise ValueError(f"amplitude is {amplitude:g} rad; it must not be negative")
    drives = drawn(system, distributions, count, seed)
    apart = by_path(system, drives)
    if "omega" in apart and speeds is not None:
        raise ValueError("omega has a distribution and speeds are given; leave one of them out")
    how = {"settle": settle, "longest": longest, "threads": threads}
    spreads = tuple(_at_speed(system, drives, apart, omega, shares, seed, how) for omega in grid.tolist())
    jumping = None if span is None else _jumps(system, apart, span, follow, shares)
    band = None if bounds is None else _band(system, apart, *bounds, float(amplitude))
    return Variability(drives, spreads, jumping, band, seed)


def drawn(system: System, distributions: Any, count: int, seed: Any) -> dict[str, Floats]:
    """Values (count,) of every parameter, drawn independently; the first drives of a larger count are the same."""
    if not isinstance(distributions, Mapping) or not distributions:
        raise ValueError(f"distributions are {shown(distributions)}; give a dict of path to distribution")
    seed = whole("seed", seed)
    known = {p.path: p.value for p in parameters(system)}
    names = [named(key) for key in distributions]
    for path in (path for name in names for path in name.split(TOGETHER)):
        if not isinstance(known.get(path), float):
            able = ", ".join(p for p, v in known.items() if isinstance(v, float))
            raise ValueError(f"{type(system).__name__} has no parameter {shown(path)} that can vary; it has {able}")
    check_names(system, names)
    values = {}
    streams = np.random.SeedSequence(seed).spawn(len(distributions))
    for name, law, stream in zip(names, distributions.values(), streams, strict=True):
        values[name] = _values(name, law, np.random.default_rng(stream).random(count))
    try:
        check_lanes(system, by_path(system, values))
    except LaneError as error:
        place = int(np.argmax(error.lanes))
        raise ValueError(f"drive {place}, with {described(values, place)}, is impossible: {error.reason}") from error
    return values


def _values(path: str, law: Any, shares: Floats) -> Floats:
    inside = np.maximum(shares, 0.5**53)
    if isinstance(law, Distribution):
        law.check()
        return np.asarray(law.quantile(inside), float)
    if lacking(law, "ppf"):
        raise TypeError(
            f"the distribution of {path!r} is {shown(law)}; give Uniform, LogUniform, Normal, or a frozen distribution "
            "of scipy.stats"
        )
    values = np.asarray(law.ppf(inside), float)
    if values.shape != shares.shape or not np.all(np.isfinite(values)):
        raise ValueError(f"the distribution of {path!r} gives values that are not finite; cut it off")
    return values


def _at_speed(
    system: Any, drives: dict[str, Floats], apart: dict[str, Floats], omega: float, shares: Floats, seed: int, how: Any
) -> SpeedSpread:
    base = system if "omega" in apart else system._replace(omega=omega)
    count = len(next(iter(drives.values())))
    ends = settled(base, apart, np.zeros((state_count(system), count)), **how)
    peak = np.maximum(np.abs(ends.lowest), np.abs(ends.highest))
    good = ~ends.diverged
    if np.count_nonzero(good) < LEAST:
        raise SolveError(f"at omega = {omega:g} rad/s only {np.count_nonzero(good)} of {count} drives stay bounded")
    rng = np.random.default_rng([seed, 1])
    running = running_quantile(peak[good], shares, rng)
    table = ranking({path: v[good] for path, v in drives.items()}, peak[good], rng)
    unsettled = int(np.count_nonzero(good & (ends.period == 0)))
    return SpeedSpread(omega, shares, peak, running, table, int(np.count_nonzero(~good)), unsettled)


def _jumps(system: System, drives: dict[str, Floats], span: Any, follow: int, shares: Floats) -> JumpSpread:
    few: dict[str, Any] = {path: v[:follow] for path, v in drives.items() if path != "omega"}
    pairs = [_jump_speeds(branch) for branch in (response_family(system, span, few) if few else [])]
    up, down = np.array([pair or (np.nan, np.nan) for pair in pairs], float).reshape(-1, 2).T
    return JumpSpread(span, shares, up, down, pairs.count(None))


def _jump_speeds(branch: Branch) -> tuple[float, float] | None:
    """Speeds [rad/s] of the jumps up and down, nan without one; None of a curve that ends or has no stable orbit."""
    with suppress(ValueError):
        if branch.status.found:
            sweep = jumps(branch)
            return sweep.jump_up, sweep.jump_down
    return None


def _band(system: System, drives: dict[str, Floats], low: float, high: float, amplitude: float) -> Band:
    natural = natural_frequencies(system, drives, amplitude)
    inside = {k: (natural >= k * low) & (natural <= k * high) for k in active_orders(system)}
    return Band(low, high, amplitude, natural, inside)


def natural_frequencies(system: Any, drives: dict[str, Floats], amplitude: float = 0.0) -> Floats:
    """Free vibration [rad/s] of every drive (drives,), small or of an amplitude [rad].

    nan where nothing restores, or where the law does not carry the mean torque.

    With an amplitude a, one harmonic: J a omega^2 = (1/pi) integral of T(u0 + a cos p) cos p dp, where u0 is the mean
    that carries the mean torque at this amplitude (describing function; Nayfeh & Mook 1979, sec. 2.3.4). For a cubic
    law whose frequency has risen by 10 % its error is below 0.1 %; `backbone` is exact.

    Raises
    ------
    TypeError
        If the law has friction or memory.
    """
    if not is_spring(system):
        raise TypeError(f"{type(system.law).__name__} has friction or memory; natural frequencies need a law torque(x)")
    count = len(next(iter(drives.values())))
    parts = (slice(first, first + AT_A_TIME) for first in range(0, count, AT_A_TIME))  # a bound on the memory
    return np.concatenate(
        [_of_some(system, {path: v[some] for path, v in drives.items()}, amplitude) for some in parts]
    )


def _of_some(system: System, drives: dict[str, Floats], amplitude: float) -> Floats:
    members = replace(system, drives)
    count = len(next(iter(drives.values())))
    mean = np.mean(np.broadcast_to(members.excitation.torque(ANGLES), (64, count)), axis=0)
    law = members.law
    if amplitude > 0.0:
        wave = amplitude * np.cos(ANGLES)
        u0 = operating_points(law, mean, wave)
        pull = 2.0 * np.mean(law.torque(u0 + wave) * np.cos(ANGLES), axis=0) / amplitude
    else:
        u0 = operating_points(law, mean)
        pull = law.stiffness(u0) + 0.0 * u0
    with np.errstate(invalid="ignore"):
        return np.asarray(np.sqrt(np.where(pull > 0.0, pull, np.nan) / members.J))
