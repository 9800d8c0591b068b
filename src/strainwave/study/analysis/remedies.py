"""What would make the error smaller: its peak computed again with one thing changed by 10 % at a time."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...compile.jit import as_python
from ...law import depends, is_spring
from ...model.train.drive_train import DriveTrain
from ...numerics.curves.response import traced_points
from ...numerics.stability.second_order import displacement_peaks
from ...protocols import lacking, lines_of, terms_of
from ...quantities import parameters, replace
from ...results import Floats, SolveError
from ...tree import leaf_of
from ..response.gear_forces import settling_time
from ..response.resonances import operating_point
from ..response.response import PLAIN_RUNS, ExactResponse
from ..response.steady import settle
from .avoid import Avoid
from .drive_response import oscillations
from .runup import silent
from .train_curve import largest_oscillation

CHANGE, NEAR = 0.1, 0.15  # what is changed, and the band about a peak that is computed again, relative
POINTS, SIMULATED = 12, 7  # of that band, by harmonic balance and by integration
BENDS = 0.01  # relative change of the stiffness by the preload, from which on it counts


@dataclass(frozen=True)
class Remedy:
    """What a change of one thing by 10 % does to the largest oscillation.

    Attributes
    ----------
    what : str
        The thing that is changed; the preload by 10 % of the largest torque.
    share : float
        Relative change of the thing: 0.1 or -0.1; 0 of a preload.
    by : float
        Change of a preload [N*m]; 0 of the others.
    ratio : float
        Largest oscillation over that without the change.
    at : float
        Speed [rad/s] of it.
    """

    what: str
    share: float
    by: float
    ratio: float
    at: float


def remedies(
    system: Any,
    response: ExactResponse,
    avoid: Avoid,
    speeds: tuple[float, float],
    torque: float,
    train: DriveTrain | None = None,
    loads: tuple[tuple[float, Any], ...] = (),
    progress: Callable[[str], None] = silent,
) -> tuple[Remedy, ...]:
    """Compute the peak again with one thing changed by 10 % at a time; the most helpful first.

    Parameters
    ----------
    system : Oscillator or VaryingOscillator
        The error equation.
    response, avoid : ExactResponse, Avoid
        The curve and its largest oscillation.
    speeds : (float, float)
        Range of the base-angle speed [rad/s].
    torque : float
        Largest torque in the gear [N*m]; 10 % of it is the change of the preload.
    train : DriveTrain, optional
        The train that the curve belongs to, in place of the error equation.
    loads : tuple of (float, system)
        Relative changes of the load's inertia, each with the error equation that it leads to; of a train they follow.
    progress : callable
        Told every change before it is tried.
    """
    sweep = response.sweep
    around = [] if sweep is None else [band for band in sweep.bands if band.low <= avoid.at <= band.high]
    ends = [avoid.at, *(end for band in around for end in (band.low, band.high))]
    band = max(speeds[0], (1.0 - NEAR) * min(ends)), min(speeds[1], (1.0 + NEAR) * max(ends))
    harmonics = response.curve.coefficients.shape[1] // 2
    folded = bool(response.curve.folds or response.curve.elsewhere)
    before = avoid.largest
    if train is None and not is_spring(system):  # at as few speeds as the others
        coarse = _simulated(system, band)
        before = before if coarse is None else coarse[1]
    found = []
    at = response.visited()[np.argmax(oscillations(response.curve)[response.visited()])]
    for what, share, by, changed in _changes(system, train, CHANGE * torque, response.curve.coefficients[at], loads):
        progress(f"{what}, {share:+.0%}" if share else what)
        after = _peak(*changed, band, harmonics, folded)
        if after is not None:
            found.append(Remedy(what, share, by, after[1] / before, after[0]))
    return tuple(sorted(found, key=lambda remedy: remedy.ratio))


def _changes(
    system: Any, train: DriveTrain | None, preload: float, series: Floats, loads: tuple[tuple[float, Any], ...]
) -> Iterator[tuple[str, float, float, tuple[Any, Any]]]:
    """Name, share, size and result of every change: the error equation, and the train in its place."""
    whole = system if train is None else train
    here = (lambda changed: (changed, None)) if train is None else (lambda changed: (system, changed))
    more = 1.0 + CHANGE
    damping = {p.path: more * p.value for p in parameters(whole) if p.path in ("B", "damping.B") and p.value > 0.0}
    if damping:
        yield "damping of the gear", CHANGE, 0.0, here(replace(whole, damping))
    if (stiffer := _stiffer(whole.law)) is not None:
        yield "stiffness of the gear", CHANGE, 0.0, here(whole._replace(law=stiffer))
    if (line := line_that_matters(whole.error, series)) is not None:
        order, smaller = line
        yield f"kinematic error of order {order}", -CHANGE, 0.0, here(replace(whole, smaller))
    if train is not None:
        yield from ((name, share, 0.0, here(changed)) for name, share, changed in train_changes(train))
        return
    yield from (("inertia of the load", share, 0.0, here(changed)) for share, changed in loads)
    if is_spring(system):
        loaded = system._replace(excitation=_with_more(system.excitation, preload))
        if _bends(system, loaded):
            yield "preload", 0.0, preload, here(loaded)


def _bends(system: Any, loaded: Any) -> bool:
    """Whether a preload that the law carries changes the stiffness at the operating point."""
    try:
        return abs(operating_point(loaded).stiffness / operating_point(system).stiffness - 1.0) > BENDS
    except SolveError:
        return False


def line_that_matters(error: Any, series: Floats) -> tuple[int, dict[str, float]] | None:
    """Order of the line whose harmonic is the largest in the error at its peak, and the change that makes it less."""
    sizes = {}
    for i, line in enumerate(lines_of(error)):
        if line.amplitude:
            sizes[i] = float(np.linalg.norm(series[2 * line.order - 1 : 2 * line.order + 1]))
    if not sizes:
        return None
    i = max(sizes, key=sizes.__getitem__)
    line = error.lines[i]
    return line.order, {f"error.lines.{i}.amplitude": (1.0 - CHANGE) * line.amplitude}


def train_changes(train: DriveTrain) -> Iterator[tuple[str, float, DriveTrain]]:
    """Name, share and result of every change of what the error equation does not have."""
    more = 1.0 + CHANGE
    load = train.load
    for share in (CHANGE, -CHANGE):
        end = load.end()
        yield "inertia of the load", share, train._replace(load=load.with_end(end._replace(J=(1.0 + share) * end.J)))
    if load.couplings():
        if load.B > 0.0:
            yield "damping of the coupling", CHANGE, train._replace(load=load._replace(B=more * load.B))
        if (stiffer := _stiffer(load.law)) is not None:
            yield "stiffness of the coupling", CHANGE, train._replace(load=load._replace(law=stiffer))
    gain = getattr(train.motor.control, "K_p", 0.0)
    if gain > 0.0:
        for share in (CHANGE, -CHANGE):  # a stiff loop holds the motor, a soft one lets it give way: either may help
            control = train.motor.control._replace(K_p=(1.0 + share) * gain)
            yield "gain K_p of the loop", share, train._replace(motor=train.motor._replace(control=control))


def _with_more(torque: Any, by: float) -> Any:
    """The torque with a larger mean, in the direction that it has."""
    terms = terms_of(torque)
    mean = sum(term.mean for term in terms)
    first = terms[0]._replace(mean=terms[0].mean + (by if mean >= 0.0 else -by))
    return first if lacking(torque, "terms") else torque._replace(terms=(first, *terms[1:]))


def _stiffer(law: Any) -> Any:
    """The law with 10 % more torque at every torsion; None where its numbers do not say how."""
    more = 1.0 + CHANGE
    changes = {}
    for p in parameters(law):
        if "N*m" in p.unit:
            changes[p.path] = p.value / more if p.unit.startswith("1/") else more * p.value
    changed = replace(law, changes)
    if depends(law) > 1:
        return changed if changes else None
    x = np.geomspace(1e-5, 1e-1, 9)
    same = np.allclose(changed.torque(x), more * law.torque(x), rtol=1e-9, atol=0.0)
    return changed if same else None


def _peak(
    system: Any, train: Any, band: tuple[float, float], harmonics: int, folded: bool
) -> tuple[float, float] | None:
    """Speed [rad/s] and size [rad] of the largest oscillation in a band.

    Where the curve without the change has neither folds nor motions beside it none are looked for.
    """
    if train is not None:
        return largest_oscillation(train, band, harmonics, folded)
    if not is_spring(system):
        return _simulated(system, band)
    with as_python(PLAIN_RUNS):
        middle = system._replace(omega=(band[0] * band[1]) ** 0.5)
        problem, found, _, _ = traced_points(middle, leaf_of(system, "omega"), *band, harmonics, 1, POINTS)
    if not len(found.points):
        return None
    series = problem.displacements(found.points)
    series[:, 0] = 0.0
    sizes = displacement_peaks(series)
    return float(found.points[np.argmax(sizes), -1]), float(np.max(sizes))


def _simulated(system: Any, band: tuple[float, float]) -> tuple[float, float] | None:
    """The same by integration, upwards, with the parabola through the three largest."""
    start, found = operating_point(system).start, []
    for omega in np.linspace(*band, SIMULATED):
        motion = settle(system._replace(omega=float(omega)), start, time=settling_time(system._replace(omega=omega)))
        if not motion.closed:
            return None
        start = motion.end
        found.append((float(omega), float(np.max(np.abs(motion.x - np.mean(motion.x[:-1]))))))
    w, a = np.array(found).T
    i = int(np.argmax(a))
    if not 0 < i < len(w) - 1:
        return float(w[i]), float(a[i])
    bend = a[i - 1] - 2.0 * a[i] + a[i + 1]
    s = 0.5 * (a[i - 1] - a[i + 1]) / bend if bend < 0.0 else 0.0
    return float(w[i] + s * (w[1] - w[0])), float(a[i] - 0.125 * (a[i - 1] - a[i + 1]) ** 2 / min(bend, -1e-300))
