"""Where multiple scales hold: their error against harmonic balance, over speed and strength of the excitation.

At every speed and strength the stable steady states of largest amplitude of both orders are moved to true motions at
that speed by Newton's method (7 harmonics of the fastest component; Krack & Gross 2019, Harmonic Balance for Nonlinear
Vibration Problems, ch. 2). True motions also start from those of the neighbouring cells, so that a motion which both
orders miss is met as well. The largest stable one of them is what the orders are compared with.

Multiple scales against integration: one run of each from the same start, compared over one window.
"""

import math
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...base.arguments import typed
from ...base.law import springs_only
from ...base.protocols import orders_of, with_parts
from ...base.quantities import number, numbers, shown
from ...base.records import Along, Labelled, Result
from ...base.results import Floats, SolveError, Status, Trajectory
from ...base.sentences import on_screen
from ...numerics.integration.methods import Dopri5
from ...numerics.integration.simulate import simulate
from ...theory.slow_flow.certificate import Balance, balance_of, corrected
from ...theory.slow_flow.flow import slow_flow
from ...theory.slow_flow.results import Evolution
from ...theory.slow_flow.setting import Complexes, Resonance
from ...theory.slow_flow.states import states

TOGETHER = 500  # cells in one step of Newton's method: a user can interrupt between
LARGER = 1.05  # times the own motion: a neighbour's motion is then tried in a cell
MOST_SPREADS = 400  # rounds of such trials
REST = 1e-6  # of the whole motion: a component near omega_0 below it is absent

ORDERS = (1, 2)
LEVELS = (1.0, 5.0, 20.0)  # percent


@dataclass(frozen=True, eq=False)
class ValidityMap(Result):
    """Where each order of multiple scales holds, over speed and strength of the excitation of a drive.

    Attributes
    ----------
    regime : str
        The resonance treated.
    speeds : (n,) array
        Speeds of the base angle [rad/s].
    amplitudes : (m,) array
        Factors of every line of the excitation.
    error : (2, n, m) array
        Relative error of first and second order in the amplitude of the component near omega_0, of the stable state of
        largest amplitude against the stable true motion of largest amplitude at that speed; where the component is
        absent, of the whole motion. At most 1, which is also where either of the two is absent.
    motion : (n, m) array
        Amplitude [rad, 0-to-peak] of that component of the true motion; 0 where it is absent.
    """

    regime: str
    speeds: Floats
    amplitudes: Floats
    error: Floats
    motion: Floats

    arrays: ClassVar[Along] = {
        ("order", "omega", "amplitude"): {"error": ""},
        ("omega", "amplitude"): {"motion": "rad"},
    }

    def holds(self, percent: float) -> NDArray[np.bool_]:
        """Whether each order holds to so many percent: the shape of `error`.

        Parameters
        ----------
        percent : float
            Between 0 and 100.
        """
        limit = number("percent", percent, positive=True)
        if not limit < 100.0:
            raise ValueError(f"percent is {limit:g}; it must be below 100, where no order holds")
        return self.error <= 0.01 * limit

    def coordinates(self) -> Labelled:
        """Orders, speeds, and factors of the excitation."""
        return {
            "order": ("order", np.array(ORDERS), ""),
            "omega": ("omega", self.speeds, "rad/s"),
            "amplitude": ("amplitude", self.amplitudes, ""),
        }

    def __str__(self) -> str:
        head = (
            f"Validity of multiple scales ({self.regime}): {len(self.speeds)} speeds, {self.speeds[0]:.6g} .. "
            f"{self.speeds[-1]:.6g} rad/s, {len(self.amplitudes)} strengths of the excitation, "
            f"{self.amplitudes[0]:.6g} .. {self.amplitudes[-1]:.6g} times the system's"
        )
        return on_screen("\n".join([head, *self._shares()]))

    def _shares(self) -> list[str]:
        shares = [[f"{np.mean(part):.0%}" for part in self.holds(level)] for level in LEVELS]
        return [
            f"  order {order} holds to {', '.join(f'{level:g} %' for level in LEVELS)} in "
            f"{', '.join(share[i] for share in shares)} of the cells"
            for i, order in enumerate(ORDERS)
        ]


@typed
def validity_map(system: Any, resonance: Resonance, speeds: ArrayLike, amplitudes: ArrayLike) -> ValidityMap:
    """Where each order of multiple scales holds, over speed and strength of the excitation of a drive.

    Parameters
    ----------
    system : Oscillator
        The drive; its own omega is ignored.
    resonance : Resonance
        p omega ~ q omega_0 on the base angle.
    speeds : (n,) array_like
        Speeds of the base angle [rad/s], positive, in rising order.
    amplitudes : (m,) array_like
        Factors of every line of the system's torque and kinematic error, positive, in rising order; 1 is the system as
        it is. The mean torque stays.

    Returns
    -------
    ValidityMap
        `error` (2, n, m): relative error of the first and the second order in the amplitude of the component near
        omega_0, over speeds and amplitudes. `motion` (n, m): that amplitude of the true motion [rad, 0-to-peak].

    Raises
    ------
    ValueError
        If the axes are not positive and rising, or the slow flow refuses the system at a speed.
    """
    speeds, amplitudes = axis("speeds [rad/s]", speeds), axis("amplitudes", amplitudes)
    system = with_parts("validity_map", system, "law", "J", "omega")
    near = system._replace(omega=float(speeds[len(speeds) // 2]))
    flows = [slow_flow(near, resonance, order=order)._flow for order in ORDERS]
    for w in speeds.tolist():
        flows[0].setting.refuse_on_resonance(w)
    shape = len(speeds), len(amplitudes)
    omega, factor = np.repeat(speeds, shape[1]), np.tile(amplitudes, shape[0])
    everywhere = flows[0].setting.scaled(factor).at(omega)
    cells = _Cells(replace(balance_of(flows[0].setting), setting=everywhere), omega)
    motions = []
    for flow in flows:
        z = states(flow, omega, factor).largest_stable()
        motion = cells.balance.motion(replace(flow, setting=everywhere), z)
        motions.append(np.where(np.isfinite(z)[:, None], motion, np.nan))
        cells.improve(np.flatnonzero(np.isfinite(z)), motions[-1])
    cells.spread(shape)
    error = np.stack([cells.error(motion).reshape(shape) for motion in motions])
    return ValidityMap(str(resonance.checked()), speeds, amplitudes, error, cells.size().reshape(shape))


def axis(name: str, values: ArrayLike) -> Floats:
    """Positive numbers in rising order, or a sentence (ValueError)."""
    found = numbers(name, values)
    if not (np.all(found > 0.0) and np.all(np.diff(found) > 0.0)):
        raise ValueError(f"{name} are {shown(values)}; they must be positive and in rising order")
    return found


class _Cells:
    """The true motions of all cells: the largest stable one that was met so far."""

    def __init__(self, balance: Balance, omega: Floats) -> None:
        self.balance, self.omega = balance, omega
        self.c = np.full((len(omega), balance.harmonics + 1), np.nan + 0j)

    def size(self) -> Floats:
        """Amplitude [rad] of the component near omega_0; 0 where there is none, or no true motion was met."""
        return np.asarray(np.nan_to_num(np.abs(self.c[:, self.balance.fast])))

    def improve(self, cells: Any, motion: Complexes) -> Any:
        """Start from motions (all cells) in some cells; return in which a larger stable motion was met."""
        better = [self._improve(part, motion[part]) for part in np.array_split(cells, len(cells) // TOGETHER + 1)]
        return np.concatenate(better)

    def _improve(self, cells: Any, start: Complexes) -> Any:
        if not len(cells):
            return cells
        balance, omega = self.balance.of(cells), self.omega[cells]
        solution = corrected(balance, start, omega, None)
        good = np.flatnonzero(solution.converged)
        good = good[balance.of(good).settles(solution.c[good], omega[good])] if len(good) else good
        where, c = cells[good], solution.c[good]
        fast = self.balance.fast
        missing = ~np.isfinite(self.c[where, fast])
        larger = missing | (np.abs(c[:, fast]) > (1.0 + REST) * np.nan_to_num(np.abs(self.c[where, fast])))
        self.c[where[larger]] = c[larger]
        return where[larger]

    def spread(self, shape: tuple[int, int]) -> None:
        """Try the motions of neighbouring cells where these are larger, until nothing changes."""
        new = np.arange(len(self.omega))
        cell = np.arange(len(self.omega)).reshape(shape)
        for _ in range(MOST_SPREADS):
            changed = np.zeros(len(self.omega), bool)
            changed[new] = True
            size, new = self.size(), np.zeros(0, int)
            pairs = (cell[1:], cell[:-1]), (cell[:, 1:], cell[:, :-1])
            for cells, neighbours in (way for pair in pairs for way in (pair, pair[::-1])):
                mine, its = cells.ravel(), neighbours.ravel()
                try_it = changed[its] & (size[its] > LARGER * size[mine])
                start = np.full_like(self.c, np.nan)
                start[mine[try_it]] = self.c[its[try_it]]
                new = np.union1d(new, self.improve(mine[try_it], start))
            if not len(new):
                break

    def error(self, motion: Complexes) -> Floats:
        """Relative error of motions: of the component near omega_0, or where it is absent of the whole; at most 1."""
        fast = self.balance.fast
        mine, its = np.abs(motion[:, fast]), np.abs(self.c[:, fast])
        whole = np.linalg.norm(self.c[:, 1:], axis=1)
        off = np.linalg.norm(motion - self.c, axis=1)
        with np.errstate(all="ignore"):
            rest = (mine <= REST * whole) & (its <= REST * whole)
            error = np.where(rest, off / whole, np.abs(mine - its) / its)
        return np.where(np.isfinite(error), np.minimum(error, 1.0), 1.0)


SAMPLES = 32  # per period of the fastest component
LONGEST = 10_000_000  # samples in all, 0.1 GB a row
FEWEST_PERIODS, MOST_PERIODS = 12, 60
BLACKMAN_HARRIS = (0.35875, -0.48829, 0.14128, -0.01168)  # Harris 1978, Proc. IEEE 66, 51-83, table I (-92 dB)


@dataclass(frozen=True, eq=False)
class Comparison:
    """Multiple scales and integration side by side.

    Attributes
    ----------
    system, resonance
        What was compared.
    window : (float, float)
        Start and end [s].
    rms_difference : float
        Root mean square of the difference over that of the integrated solution.
    peak_theory, peak_integrated : float
        Largest |x| [rad] in the window.
    harmonics : dict
        Multiple of omega (Fraction) to (multiple scales, integration): amplitudes [rad, 0-to-peak] at the end of the
        window.
    theory : Evolution
        The transient of multiple scales.
    integrated : Trajectory
        The integrated solution at the same times.
    """

    system: Any
    resonance: Resonance
    window: tuple[float, float]
    rms_difference: float
    peak_theory: float
    peak_integrated: float
    harmonics: dict[Fraction, tuple[float, float]]
    theory: Evolution
    integrated: Trajectory

    def __str__(self) -> str:
        first, last = self.window
        parts = ", ".join(f"{k} omega: {a:.4g} and {b:.4g}" for k, (a, b) in self.harmonics.items())
        return (
            f"Comparison of multiple scales and integration, {self.resonance}, {first:g} .. {last:.6g} s\n"
            f"  rms of the difference {self.rms_difference:.3g} of the integrated solution\n"
            f"  largest |x| {self.peak_theory:.6g} rad and {self.peak_integrated:.6g} rad\n"
            f"  amplitudes [rad] {parts or 'none'}"
        )

    __repr__ = __str__

    @property
    def t(self) -> Floats:
        """Times [s] of both solutions."""
        return self.integrated.t


@typed
def compare_with_integration(
    system: Any,
    resonance: Resonance,
    y0: tuple[float, float] = (0.0, 0.0),
    t_end: float | None = None,
    *,
    multiples: tuple[Fraction | int, ...] = (1, 3, Fraction(1, 3)),
) -> Comparison:
    """Compare first-order multiple scales with integration from the same start over the window 0..t_end.

    Parameters
    ----------
    system : Oscillator
        The system at its omega [rad/s].
    resonance : Resonance
        Regime in which multiple scales treat it.
    y0 : (float, float)
        Start: x [rad], x' [rad/s].
    t_end : float, optional
        End of the window [s]; default 5/mu.
    multiples : tuple of Fraction or int
        Multiples of omega whose amplitudes are read at the end of the window, under a Blackman-Harris window over as
        many whole periods as fit into its last fifth (at most 60): a free vibration left there, at some other multiple,
        leaks less than 1e-4 of itself.

    Returns
    -------
    Comparison
        `harmonics` is empty where fewer than 12 periods fit.

    Raises
    ------
    ValueError
        If mu = 0 and no t_end is given, t_end is not positive, or multiple scales refuse the system.
    SolveError
        If the integration does not reach the end.
    """
    springs_only("compare", system)
    flow = slow_flow(system, resonance)
    if t_end is None:
        if flow.mu <= 0.0:
            raise ValueError(
                f"mu = {flow.mu:.6g} 1/s gives no window 5/mu; name the end of the window, t_end, in seconds"
            )
        t_end = 5.0 / flow.mu
    if not 0.0 < t_end < math.inf:
        raise ValueError(f"t_end = {t_end!r} s must be positive and finite")
    fastest = max(flow.omega_0, system.omega * max([1, *orders_of(system)]))
    samples = 2 + math.ceil(SAMPLES * t_end * fastest / (2.0 * np.pi))
    if samples > LONGEST:
        raise ValueError(f"t_end = {t_end:g} s takes {samples:.3g} samples, above {LONGEST:,}; give an earlier end")
    t = np.linspace(0.0, t_end, samples)
    integrated = simulate(system, y0, t, method=Dopri5(rtol=1e-11, atol=1e-15))
    if not integrated.status:
        raise SolveError(f"the integration beside multiple scales {integrated.message}")
    theory = flow.evolve(y0, t)
    size = math.sqrt(float(np.mean(integrated.y[0] ** 2)))
    difference = math.sqrt(float(np.mean((theory.x - integrated.y[0]) ** 2)))
    return Comparison(
        system=system,
        resonance=resonance,
        window=(0.0, float(t_end)),
        rms_difference=difference / size if size > 0.0 else 0.0,
        peak_theory=Trajectory(t, theory.x[None], theory.rate[None], Status.OK, "", 0, 0, 0).peak(),
        peak_integrated=integrated.peak(),
        harmonics=_harmonics(system.omega, t, theory.x, integrated.y[0], multiples),
        theory=theory,
        integrated=integrated,
    )


def _harmonics(
    omega: float, t: Floats, theory: Floats, integrated: Floats, multiples: tuple[Fraction | int, ...]
) -> dict[Fraction, tuple[float, float]]:
    """Amplitudes at multiples of omega over the last whole periods."""
    period = 2.0 * np.pi / omega
    periods = min(MOST_PERIODS, math.floor(0.2 * float(t[-1]) / period))
    if periods < FEWEST_PERIODS:
        return {}
    start = float(t[-1]) - periods * period
    use = t >= start
    share = (t[use] - start) / (periods * period)
    weight = np.array(BLACKMAN_HARRIS) @ np.cos(2.0 * np.pi * np.outer(np.arange(4), share))
    weight = weight / np.sum(weight)
    found = {}
    for multiple in multiples:
        wave = 2.0 * weight * np.exp(-1j * float(multiple) * omega * t[use])
        found[Fraction(multiple)] = (float(abs(wave @ theory[use])), float(abs(wave @ integrated[use])))
    return found
