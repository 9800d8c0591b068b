"""`fit_bode`: a measured Bode plot over that of the drive, and the numbers of the drive that fit it."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from itertools import product
from math import exp, log, nan, pi
from typing import Any, ClassVar, NamedTuple

import numpy as np
from scipy.optimize import least_squares
from scipy.signal import cont2discrete

from ....base.facts import Fact
from ....base.quantities import number, shown
from ....base.records import Labelled
from ....base.results import Complexes, Floats
from ....drive.loops.margins import MotorLoop
from ....drive.motor_words import motor_name, train_of
from ....drive.state_space import StateSpace, state_space
from ....model.laws.springs import Linear
from ....model.train.controls import FREE, HERTZ
from ....model.train.drive_train import DriveTrain
from ..fitted import Fit, derivatives, refuse_unidentifiable
from ..intervals import Spread, spread
from .measured_bode import MeasuredBode

UNITS = {"J_m": "kg*m^2", "J_l": "kg*m^2", "K": "N*m/rad", "B": "N*m*s/rad", "delay": "s", "gain": ""}
BLOCKS = {  # of a project file: number, block with it and the ratio, and what has the source "measured"
    "J_m": ("motor: {{inertia: {0!r} kg*m^2}}", "motor.inertia"),
    "J_l": ("load: {{inertia: {0!r} kg*m^2}}", "load.inertia"),
    "K": ("gear: {{ratio: {1:.15g}, law: {{type: linear, K: {0!r} N*m/rad}}}}", "gear.law"),
    "B": ("damping: {{B: {0!r} N*m*s/rad}}", "damping.B"),
}
USUAL_NUMBERS = ("J_m", "J_l", "K", "B", "delay")
STARTS = (1.0, 0.4, 2.5)  # of the stiffness
START_DAMPING = 0.01  # damping ratio of a start without damping
FARTHEST_LOG = 5.0  # logarithm of the factor that a number may be off from its start
STEP, START_EVALUATIONS = 1e-4, 12  # of the unknowns for differences, and evaluations of a start
TOLERANCE = 1e-4  # of the largest singular value: what the points tell
MISFIT_RATIO = 1.3  # times the noise: a residual beyond it is no noise
SIZE_CHANGE, FREQUENCY_CHANGE = 0.1, 0.02  # relative differences between two amplitudes that are named
NO_PHASE = "without a measured phase the delay is not identifiable"
MISFIT_TEXT = "the model error is {} times the noise and is not included in the intervals"
RISE_CAUSES = "rises", "backlash, or a stiffening spring"
FALL_CAUSES = "falls", "friction inside the gear that slips, or a softening spring"
DRY_CAUSE = "dry friction is a smaller part of a larger torque"
LOSS_CAUSE = "saturation, or damping that grows with the motion"
NO_SPREAD = Spread(np.empty((0, 0)), np.empty(0), np.empty(0))


class ModelledBode(NamedTuple):
    """The Bode plot of a train, as one was measured, about a speed [rad/s] of the motor."""

    train: DriveTrain
    measured: MeasuredBode
    speed: float

    def start(self) -> dict[str, float]:
        """Numbers of the train as it is; without damping a small one."""
        linear, end = state_space(self.train, speed=self.speed), self.train.load.end()
        response = linear.response([np.sqrt(self.measured.omega[0] * self.measured.omega[-1])])[:, -1, 0]
        K = (response[linear.outputs.index("gear torque")] / response[linear.outputs.index("error")]).real
        B = self.train.B or 2.0 * START_DAMPING * (K * end.J) ** 0.5
        return {"J_m": self.train.motor.J, "J_l": end.J, "K": float(K), "B": float(B), "delay": 0.0, "gain": 1.0}

    def of(self, values: dict[str, float]) -> Complexes:
        """Response (n,) with other numbers, those that are not given being the train's."""
        train, omega = self.train, self.measured.omega
        law = Linear(values["K"]) if "K" in values else train.law
        train = train._replace(law=law, B=values.get("B", train.B)).with_motor(J=values.get("J_m", train.motor.J))
        train = train.with_load(J=values.get("J_l", train.load.end().J))
        factor = values.get("gain", 1.0) * np.exp(-1j * omega * values.get("delay", 0.0))
        if self.measured.quantity == "plant":
            free = state_space(train.with_motor(control=FREE), speed=self.speed)
            return np.asarray(factor * _speed_over_torque(free, omega, self.measured.hold))
        L = factor * MotorLoop(train, None, self.speed)(omega)
        return np.asarray(L if self.measured.quantity == "open loop" else L / (1.0 + L))

    def off(self, computed: Complexes) -> Floats:
        """Residual: relative differences in size, and in phase where that was measured, over the noise if known."""
        value, noise = self.measured.value, self.measured.deviation
        weight = np.abs(value) / noise if np.all(noise > 0.0) else 1.0
        if not self.measured.phased:
            return np.asarray((np.abs(computed / value) - 1.0) * weight)
        ratio = (computed / value - 1.0) * weight * np.sqrt(2.0)
        return np.concatenate([ratio.real, ratio.imag])


def _speed_over_torque(free: StateSpace, omega: Floats, hold: float) -> Complexes:
    """Response (n,) of a free motor's speed to its torque, which is continuous or constant for a time [s]."""
    i = free.inputs.index("motor torque")
    if not hold:
        return np.asarray(free.response(omega)[0, i])
    n, column = len(free.A), free.B[:, [i]]
    A, B, *_ = cont2discrete((free.A, column, free.C[:1], free.D[:1, [i]]), hold)
    turn = np.exp(1j * omega * hold)[:, None, None] * np.eye(n)
    return np.asarray(np.linalg.solve(turn - A, B.astype(complex))[:, :, 0] @ free.C[0])


@dataclass(frozen=True, eq=False)
class BodeFit(Fit):
    """A measured Bode plot, that of the drive, and the numbers of the drive that fit it.

    Attributes
    ----------
    measured : MeasuredBode
        The measurement.
    values : dict of str to float
        Numbers that were fitted: `J_m` of the motor and `J_l` of the load [kg*m^2], `K` [N*m/rad] and `B` [N*m*s/rad]
        of the gear, `delay` [s], `gain`; empty for a comparison.
    covariance, freedom, unidentified
        As of `Fit`.
    start : dict of str to float
        The drive's own numbers, by the same names.
    computed, model : (n,) complex arrays
        Response with the numbers fitted, and of the drive as it is.
    missed : float
        Root mean square of what the fit leaves over the noise; nan where the noise is not known.
    loop : str
        What drives the motor, in words.
    ratio : float
        Ratio of the gear, for `yaml`.
    dependence : tuple of str
        What changes with the amplitude, where two were measured.
    """

    rows: ClassVar[str] = "frequency"
    by_logarithm: ClassVar[tuple[str, ...]] = ("J_m", "J_l", "K", "B", "gain")

    measured: MeasuredBode
    values: dict[str, float]
    covariance: Floats
    freedom: Floats
    unidentified: dict[str, str]
    start: dict[str, float]
    computed: Complexes
    model: Complexes
    missed: float
    loop: str
    ratio: float
    dependence: tuple[str, ...] = ()

    @property
    def yaml(self) -> str:
        """Numbers fitted as blocks of a project file with their source; empty for a comparison."""
        names = [name for name in BLOCKS if name in self.values]
        lines = [BLOCKS[name][0].format(self.values[name], self.ratio) for name in names]
        sources = ", ".join(f"{BLOCKS[name][1]}: measured" for name in names)
        return "\n".join([*lines, f"sources: {{{sources}}}\n"]) if names else ""

    def coordinates(self) -> Labelled:
        """Frequencies."""
        return self.measured.coordinates()

    def variables(self) -> Labelled:
        """Responses measured, of the drive as it is, and with the numbers fitted."""
        value = self.measured.variables()["value"]
        return {"measured": value} | {n: (value[0], getattr(self, n), value[2]) for n in ("model", "computed")}

    def facts(self) -> tuple[Fact, ...]:
        """Measurement and assumptions, misfit of model and fit, and the numbers with their intervals."""
        facts = list(self.measured.facts())
        if self.measured.quantity != "plant":
            facts.append(Fact("loop", self.loop, "loop of the drive: {}"))
        for name, response in (("drive", self.model), ("fit", self.computed))[: 1 + bool(self.values)]:
            size, phase = self._differences(response)
            facts.append(Fact(f"{name}.off_dB", size, "off by {} dB"))
            facts.append(Fact(f"{name}.off_degrees", phase, "{} degrees rms" if self.measured.phased else ""))
        if self.values:
            facts.append(Fact("numbers", tuple(self._row(name) for name in self.values), "{}"))
        lacks = self.values and self.missed > MISFIT_RATIO
        return (
            *facts, Fact("left_over_noise", self.missed, MISFIT_TEXT if lacks else ""),
            Fact("unidentified", tuple(self.unidentified.values()), "{}"),
            Fact("dependence_on_amplitude", self.dependence, "{}"), Fact("project", self.yaml),
        )  # fmt: skip

    def _row(self, name: str) -> tuple[Fact, ...]:
        low, high = self.interval(name)
        return (
            Fact("name", name, "number"), Fact("value", self.values[name], "value"), Fact("low", low, "from"),
            Fact("high", high, "to (95 %)"), Fact("given", self.start[name], "drive"),
            Fact("unit", UNITS[name], "unit"),
        )  # fmt: skip

    def _differences(self, response: Complexes) -> tuple[float, float]:
        """Root mean square differences from the measurement in dB and degrees."""
        ratio = response / self.measured.value
        size, phase = np.sqrt(np.mean([np.log(np.abs(ratio)) ** 2, np.angle(ratio) ** 2], axis=1)).tolist()
        return 20.0 / log(10.0) * size, 180.0 / pi * phase if self.measured.phased else nan


def fit_bode(
    measured: MeasuredBode | Sequence[MeasuredBode], project: Any, *, free: Sequence[str] | None = None,
    speed: float = 0.0,
) -> BodeFit:  # fmt: skip
    """Compare a measured Bode plot with that of a drive, and fit the drive's numbers to it.

    Least squares of the complex relative differences, each over its noise where that is known, from several starts of
    the stiffness; intervals allow for residuals that are coloured.

    Parameters
    ----------
    measured : MeasuredBode, or two of them
        From `read_frd`, `measured_bode` or `bode_of_records`. The first is fitted; of a second one with another
        amplitude it is said what changes with the amplitude: backlash, friction.
    project : Project or DriveTrain
        The drive with start values, about which it is linear; its loop counts for "open loop" and "closed loop".
    free : sequence of str, optional
        Numbers to fit, of `J_m`, `J_l`, `K`, `B`, `delay` [s] and `gain`, a factor where the scale of the measurement
        is not known; none: comparison alone. Default: all but the gain, without a phase without the delay.
    speed : float
        Speed of the motor [rad/s] at which it was measured, which friction depends on.

    Returns
    -------
    BodeFit
        `values`, the numbers found, in SI (J_m, J_l, K, B, delay, gain); `covariance` (p, p) of the free ones;
        responses `computed` with them and `model` of the drive as it is, complex (n,) arrays.

    Raises
    ------
    ValueError
        If a name is another, or the measurement does not tell the numbers apart.

    References
    ----------
    Pintelon & Schoukens 2012, System Identification: A Frequency Domain Approach, sec. 9.3 (weighted least squares).
    """
    plots = (measured,) if isinstance(measured, MeasuredBode) else tuple(measured)
    if len(plots) not in (1, 2):
        raise ValueError(f"measured has {len(plots)} Bode plots; give one, or two of different amplitudes")
    plot, (name, train) = plots[0], train_of(project, "fit_bode")
    loop = name or motor_name(train.motor.control, train.loop_inertia)
    if plot.quantity != "plant" and (train.motor.free or train.motor.held):
        raise ValueError(f"the {plot.quantity} was measured, but the motor of the drive has no loop; add a loop")
    modelled = ModelledBode(train, plot, number("speed [rad/s]", speed))
    start, unknown = modelled.start(), {} if plot.phased else {"delay": NO_PHASE}
    names = tuple(name for name in USUAL_NUMBERS if name not in unknown) if free is None else tuple(free)
    wrong = next((name for name in names if name not in UNITS or names.count(name) > 1 or name in unknown), None)
    if wrong is not None:
        raise ValueError(unknown.get(wrong) or f"free has {shown(wrong)}; name each once, of {', '.join(UNITS)}")
    dependence = amplitude_dependence(*plots) if len(plots) == 2 else ()
    values, scatter = _fitted(modelled, names, start) if names else ({}, NO_SPREAD)
    model, computed = modelled.of({}), modelled.of(values)
    noisy = bool(np.all(plot.deviation > 0.0))
    missed = float(np.sqrt(np.mean(modelled.off(computed) ** 2))) if noisy else nan
    return BodeFit(
        measured=plot, values=values, covariance=scatter.covariance, freedom=scatter.freedom, unidentified=unknown,
        start=start, computed=computed, model=model, missed=missed, loop=loop, ratio=train.N, dependence=dependence,
    )  # fmt: skip


def _fitted(modelled: ModelledBode, names: Sequence[str], start: dict[str, float]) -> tuple[dict[str, float], Spread]:
    """Values by name, and their scatter."""
    count, fastest = len(modelled.measured.omega), float(modelled.measured.omega[-1])

    def values(late: float, p: Floats) -> dict[str, float]:
        pairs = zip(names, p.tolist(), strict=True)
        return {name: (late + x) / fastest if name == "delay" else start[name] * exp(x) for name, x in pairs}

    def residual_after(late: float, p: Floats) -> Floats:
        return modelled.off(modelled.of(values(late, p)))

    def size_residual(p: Floats) -> Floats:  # leads to the fit from farther away
        return np.asarray(np.log(np.abs(modelled.of(values(0.0, p)) / modelled.measured.value)))

    begins = [np.array([log(factor) if name == "K" else 0.0 for name in names]) for factor in STARTS]
    ways: Any = {"bounds": (-FARTHEST_LOG, FARTHEST_LOG), "diff_step": STEP}
    rough = [least_squares(size_residual, begin, max_nfev=START_EVALUATIONS, **ways) for begin in begins]
    fits = [
        (late, least_squares(partial(residual_after, late), fit.x, x_scale="jac", **ways))
        for late, fit in product(_delays(modelled) if "delay" in names else (0.0,), rough)
    ]
    late, best = min(fits, key=lambda fit: float(fit[1].cost))
    misfit, x = partial(residual_after, late), np.asarray(best.x)
    for name, moved in zip(names, np.abs(x), strict=True):
        if moved > 0.99 * FARTHEST_LOG:
            raise ValueError(f"{name} reaches the end of its search range; remove it from free")
    J = derivatives(misfit, x, np.full(len(names), STEP))
    refuse_unidentifiable(J, names, np.ones(len(names)), TOLERANCE)
    scatter = spread(J, misfit(x), len(J) // count * [count])  # records: real and imaginary part
    solved = values(late, x)
    sizes = np.array([1.0 / fastest if name == "delay" else solved[name] for name in names])
    return solved, scatter._replace(covariance=scatter.covariance * np.outer(sizes, sizes))


def _delays(modelled: ModelledBode) -> tuple[float, ...]:
    """Phases [rad] of the delay at the highest frequency to begin with: 0, and how late a measurement is beyond pi."""
    if not modelled.measured.phased:
        return (0.0,)
    omega, ratio = modelled.measured.omega, modelled.measured.value / modelled.of({})
    late = -float(np.polyfit(omega / omega[-1], np.unwrap(np.angle(ratio)), 1)[0])
    return (0.0, late) if late > pi else (0.0,)


def amplitude_dependence(first: MeasuredBode, second: MeasuredBode) -> tuple[str, ...]:
    """Say what changes from the smaller to the larger amplitude of two measurements of one quantity."""
    small, large = sorted((first, second), key=lambda plot: plot.amplitude)
    if not small.amplitude < large.amplitude or small.quantity != large.quantity:
        raise ValueError("two Bode plots need one quantity and different amplitudes; give amplitude= of each")
    between = f"from the amplitude {small.amplitude:g} to {large.amplitude:g}"
    before, after = _resonance(small), _resonance(large)
    grid = small.omega[(small.omega >= large.omega[0]) & (small.omega < 0.7 * min(before, after))]
    sizes = np.interp(grid, large.omega, np.abs(large.value)) / np.interp(grid, small.omega, np.abs(small.value))
    ratio, sentences = float(np.median(sizes)) if len(grid) else 1.0, []
    if abs(after / before - 1.0) > FREQUENCY_CHANGE:
        moves, cause = RISE_CAUSES if after > before else FALL_CAUSES
        sentences.append(f"{between} the resonance {moves} {before / HERTZ:.4g} -> {after / HERTZ:.4g} Hz: {cause}")
    if abs(ratio - 1.0) > SIZE_CHANGE:
        cause = DRY_CAUSE if ratio > 1.0 else LOSS_CAUSE
        sentences.append(f"{between} the response below the resonance changes by the factor {ratio:.3g}: {cause}")
    return tuple(sentences) or (f"{between} neither the resonance nor the response below it changes",)


def _resonance(bode: MeasuredBode) -> float:
    """Frequency [rad/s] of the highest crest above a straight line, in logarithms."""
    x, y = np.log(bode.omega), np.log(np.abs(bode.value))
    y = y - np.polyval(np.polyfit(x, y, 1), x)
    i = int(np.argmax(y[1:-1])) + 1
    a, b, _ = np.polyfit(x[i - 1 : i + 2] - x[i], y[i - 1 : i + 2], 2)
    return float(np.exp(x[i] + np.clip(-0.5 * b / min(a, -1e-300), x[i - 1] - x[i], x[i + 1] - x[i])))
