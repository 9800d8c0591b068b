"""The slow flow while the speed changes: theta'' = rate.

With Omega = (p/q) omega(t) the component z E of the motion leaves on E

    z'' + (2 i Omega + mu) z' = R(z; omega) - i Omega' z - i (p/q) rate e_k = R_1

where R is the balance of constant speed and e_k the line of the kinematic error on E: its torque is
-e'' = (k^2 omega^2 - i k rate) e_k. With g = R_1/(2 i Omega + mu), z'' is that of the flow itself,
z'' = g_z z' + g_omega rate, so that z' = (g - g_omega rate/c)/(1 + g_z/c), c = 2 i Omega + mu. The term of g_omega is
of the same size as -i Omega' z and cancels it for a free vibration, whose amplitude does not depend on the frame it is
seen from. First order has neither of them.

What a passage answers with: one run-up or run-down, or one at each of several rates.
"""

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from ....base.records import Along, Labelled, Result
from ....base.results import Floats
from ....base.sentences import on_screen
from ..averaging import AveragedFlow, Exact
from ..closed_forms import CubicFlow
from ..fixed_points import Flow, newton_step
from ..second_order import STEP, Samples, SecondOrderFlow, Small
from ..setting import Complexes, Setting, real_matrix

if TYPE_CHECKING:
    from scipy.interpolate import RectBivariateSpline

ALONE, AMONG_OTHERS = (400, 17, 1), (120, 9, 16)  # amplitudes, speeds and phases of a table
SMALLEST = 1e-4  # of the largest function: a smaller one is left out
CHUNK = 400  # states sampled at a time


@dataclass(frozen=True)
class DelayedJump:
    """A jump on the way.

    Attributes
    ----------
    omega : float
        Speed of the base angle [rad/s] at which the amplitude is half way between those of the two motions.
    fold : float
        Speed [rad/s] of the fold, at which the drive would jump if the speed changed infinitely slowly.
    delay : float
        How far the drive goes beyond the fold [rad/s], positive in the direction of the passage.
    estimate : float
        The same to leading order, 2.33811 times a constant of the fold times rate^(2/3) [rad/s].
    """

    omega: float
    fold: float
    delay: float
    estimate: float


@dataclass(frozen=True, eq=False)
class Passage(Result):
    """A run-up or run-down through a resonance at a constant rate; the speed is then held at its last value.

    Attributes
    ----------
    first, last, rate : float
        Speeds of the base angle [rad/s] and its rate [rad/s^2], positive.
    order : int
        Order of the slow flow.
    closed_form : bool
        Whether the exact formula of a linear drive serves.
    largest, at : float
        Largest amplitude [rad, 0-to-peak] of the component near omega_0, and the speed [rad/s] at which it is.
    peak : float
        Largest |x| [rad] that is possible with these amplitudes, whatever the base angle is at the start.
    jumps : tuple of DelayedJump
        Jumps in the order of the way; empty where the drive passes without one.
    settling : float or None
        Time [s] from the last jump, or without one from the largest amplitude, to where the motion stays within 2 % of
        the steady state at its speed; None where it does not within the time of the history.
    t, omega, amplitude, envelope : (n,) arrays
        History: times [s], speeds [rad/s], amplitude [rad] as `largest`, and the largest |x| [rad] of a forcing period.
    error : float
        Estimated relative error of `largest` and of `peak`.
    valid : bool
        Whether `error` is at most 3 %, and rates 10 % higher and lower change `largest` by less than 15 %.
    message : str
        One sentence.
    """

    first: float
    last: float
    rate: float
    order: int
    closed_form: bool
    largest: float
    at: float
    peak: float
    jumps: tuple[DelayedJump, ...]
    settling: float | None
    t: Floats
    omega: Floats
    amplitude: Floats
    envelope: Floats
    error: float
    valid: bool
    message: str = field(repr=False)

    rows: ClassVar[str] = "t"
    places: ClassVar[Along] = {"t": {"t": "s"}}
    arrays: ClassVar[Along] = {"t": {"omega": "rad/s", "amplitude": "rad", "envelope": "rad"}}

    @property
    def jumped(self) -> bool:
        """Whether the drive jumped on the way."""
        return len(self.jumps) > 0

    @property
    def jump(self) -> float | None:
        """Speed [rad/s] of the first jump; None without one."""
        return self.jumps[0].omega if self.jumps else None

    def variables(self) -> Labelled:
        """Speed, amplitude and largest |x| over time; speeds of the jumps, their folds and estimates."""
        jumps = np.array([(j.omega, j.fold, j.estimate) for j in self.jumps]).reshape(-1, 3)
        return {
            **super().variables(),
            "jump": ("jump", jumps[:, 0], "rad/s"),
            "fold": ("jump", jumps[:, 1], "rad/s"),
            "estimate": ("jump", jumps[:, 2], "rad/s"),
        }

    def __str__(self) -> str:
        return on_screen(self.message)


@dataclass(frozen=True, eq=False)
class Passages(Result):
    """The same passage at several rates.

    Attributes
    ----------
    passages : tuple of Passage
        One for each rate, in the order in which they were given.
    rate_without_jump : float or None
        Rate [rad/s^2] above which the drive passes without jumping, to 1 %; None where it always jumps or never does.
    """

    passages: tuple[Passage, ...]
    rate_without_jump: float | None

    rows: ClassVar[str] = "rate"
    places: ClassVar[Along] = {"rate": {"rate": "rad/s^2"}}
    arrays: ClassVar[Along] = {
        "rate": {
            "largest": "rad", "at": "rad/s", "peak": "rad", "jumped": "", "jump": "rad/s", "settling": "s", "valid": "",
        }
    }  # fmt: skip

    @property
    def rate(self) -> Floats:
        """Rates (n,) [rad/s^2]."""
        return np.array([p.rate for p in self.passages])

    @property
    def largest(self) -> Floats:
        """Largest amplitudes (n,) [rad]."""
        return np.array([p.largest for p in self.passages])

    @property
    def at(self) -> Floats:
        """Speeds (n,) [rad/s] of the largest amplitudes."""
        return np.array([p.at for p in self.passages])

    @property
    def peak(self) -> Floats:
        """Largest |x| (n,) [rad]."""
        return np.array([p.peak for p in self.passages])

    @property
    def jumped(self) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
        """Whether the drive jumped (n,)."""
        return np.array([p.jumped for p in self.passages], bool)

    @property
    def jump(self) -> Floats:
        """Speeds (n,) [rad/s] of the first jumps; nan where there is none."""
        return np.array([np.nan if p.jump is None else p.jump for p in self.passages])

    @property
    def settling(self) -> Floats:
        """Settling times (n,) [s]; nan where the motion did not settle."""
        return np.array([np.nan if p.settling is None else p.settling for p in self.passages])

    @property
    def valid(self) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
        """Where the answer can be relied on (n,)."""
        return np.array([p.valid for p in self.passages], bool)

    def __len__(self) -> int:
        return len(self.passages)

    def __str__(self) -> str:
        limit = "none" if self.rate_without_jump is None else f"{self.rate_without_jump:.6g} rad/s^2"
        return on_screen(
            f"Passages at {len(self)} rates, {np.min(self.rate):.6g} .. {np.max(self.rate):.6g} rad/s^2\n"
            f"  largest amplitude {np.min(self.largest):.6g} .. {np.max(self.largest):.6g} rad, "
            f"{int(np.sum(self.jumped))} with a jump, {int(np.sum(self.valid))} valid\n"
            f"  rate above which it passes without a jump: {limit}"
        )


def moving_rates(flow: Flow, omega: Any, rate: Floats, z: Complexes) -> Complexes:
    """Rates z' [rad/s] (lanes,) at speeds omega [rad/s] that change by rate [rad/s^2], all (lanes,)."""
    if isinstance(flow, SecondOrderFlow):
        return _second(flow, omega, rate, z)
    if isinstance(flow, AveragedFlow):
        if isinstance(flow.means, Exact):
            if np.any(flow.setting.hard):
                return np.array([complex(flow.at(w).rates(x)) for w, x in zip(omega, z, strict=True)])
            return np.asarray(replace(flow, setting=flow.setting.at(omega)).rates(z))
        return np.asarray(flow.at(omega).rates(z))
    return np.asarray(CubicFlow(flow.setting.at(omega), flow.kind).rates(z))


def _second(flow: SecondOrderFlow, omega: Floats, rate: Floats, z: Complexes) -> Complexes:
    s = flow.setting
    n, ratio = len(z), s.fast / s.omega
    step, d = STEP * (np.abs(z) + 1e-3 * abs(z).max(initial=1e-30)), STEP * omega
    places = np.concatenate([z, z + step, z - step, z + 1j * step, z - 1j * step, z, z])
    speeds = np.concatenate([omega] * 5 + [omega + d, omega - d])
    along = np.tile(rate, 7)
    here = flow.at(speeds)
    c: Any = 2j * here.setting.fast + s.mu
    line = np.sum(s.error_lines[s.on_fast]) if s.on_fast.any() else 0.0
    g = here.unforced(places) - here.push - 1j * ratio * along * (places + line) / c
    g = np.asarray(g).reshape(7, n)
    by_re, by_im = (g[1] - g[2]) / (2.0 * step), (g[3] - g[4]) / (2.0 * step)
    c = c[:n]
    right = g[0] - rate * (g[5] - g[6]) / (2.0 * d) / c
    return np.asarray(-newton_step(np.eye(2) + real_matrix(by_re / c, by_im / c), right))


@dataclass(frozen=True, eq=False)
class Tabulated:
    """The torque's harmonic on E from a table: z times a function of |z| and omega for each multiple of z's phase.

    Without hard lines the phase plays no role, and there is one function.

    Attributes
    ----------
    multiples : tuple of int
        Multiples of the phase.
    parts : tuple of (spline, spline)
        Real and imaginary part of the function of each.
    largest : float
        Amplitude [rad] up to which they reach; beyond it the drive is taken for linear.
    """

    multiples: tuple[int, ...]
    parts: tuple[tuple["RectBivariateSpline", "RectBivariateSpline"], ...]
    largest: float

    def values(self, s: Setting, z: Any) -> tuple[Small, Any]:
        """No small harmonics, and 2 <n conj(E)> [rad/s^2]."""
        a, omega = np.abs(z), np.broadcast_to(s.omega, np.shape(z))
        turn = np.where(a > 0.0, z, 1.0) / np.where(a > 0.0, a, 1.0)
        found: Any = 0.0
        for m, (re, im) in zip(self.multiples, self.parts, strict=True):
            found = found + (re.ev(a, omega) + 1j * im.ev(a, omega)) * turn**m
        return [], found * np.maximum(a / self.largest, 1.0)


def tabulated(flow: Flow, band: tuple[float, float], largest: float) -> Flow:
    """The flow with its samples in a table up to an amplitude [rad]; as it is where it has none."""
    if not (isinstance(flow, SecondOrderFlow) and isinstance(flow.force, Samples)):
        return flow
    from scipy.interpolate import RectBivariateSpline  # a third of a second of every start, and tables alone need it

    alone = bool(flow.setting.on_fast.all())
    amplitudes, speeds, phases = ALONE if alone else AMONG_OTHERS
    margin = 1e-3 * (band[1] - band[0])
    a, omega = np.linspace(0.0, largest, amplitudes), np.linspace(band[0] - margin, band[1] + margin, speeds)
    turn = np.exp(2j * np.pi * np.arange(phases) / phases)
    z = (a[:, None, None] * turn).repeat(speeds, 1).ravel()
    w = np.broadcast_to(omega[:, None], (amplitudes, speeds, phases)).ravel()
    force, pieces = flow.force, range(0, len(z), CHUNK)
    found = [force.values(flow.setting.at(w[i : i + CHUNK]), z[i : i + CHUNK])[1] for i in pieces]
    shares = np.fft.fft(np.concatenate(found).reshape(amplitudes, speeds, phases), axis=2) / phases
    # functions of |z| times exp(i m phase), m = 1 alone where only the whole turn matters
    multiples = (1,) if alone else tuple(range(1 - phases // 2, 1 + phases // 2))
    each = [shares.sum(axis=2) if alone else shares[:, :, m] for m in multiples]
    least = SMALLEST * max(float(np.max(np.abs(one))) for one in each)
    kept = [(m, one) for m, one in zip(multiples, each, strict=True) if np.max(np.abs(one)) > least]
    parts = tuple((RectBivariateSpline(a, omega, one.real), RectBivariateSpline(a, omega, one.imag)) for _, one in kept)
    return replace(flow, force=Tabulated(tuple(m for m, _ in kept), parts, largest))  # type: ignore[arg-type]
