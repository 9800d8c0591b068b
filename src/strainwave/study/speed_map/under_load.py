"""A drive under one load of the map, and all its stable steady motions through the range of speeds.

Campbell diagram of a nonlinear drive: motor speeds at which each order meets each resonance, against amplitude.
"""

from collections.abc import Iterable
from dataclasses import replace
from math import gcd, inf, pi, sqrt
from typing import Any, NamedTuple

import numpy as np

from ...base.law import depends, is_linear, states_of, torque_of
from ...base.number_text import number
from ...base.protocols import linear_part_of, orders_of
from ...base.quantities import number as real
from ...base.results import Floats, SolveError
from ...base.sentences import Sentence
from ...base.units import RPM
from ...drive.drive_response import DriveResponse
from ...drive.equation.left_out import left_out
from ...drive.jumps import doubled_spans
from ...drive.project import Project
from ...drive.state_space import state_space
from ...drive.steady import equation_curve, train_motions
from ...drive.train_curve import NO_MOTION, at_load, has_curve, refuse_free, without_gravity
from ...drive.two_turns import A_TURN, NONE_STABLE, beat_said
from ...model.excitation import Harmonic, NoError
from ...model.laws.springs import Linear
from ...model.oscillator import Oscillator
from ...model.train.drive_train import DriveTrain
from ...numerics.curves.backbone import backbone
from .bands import quasi_static, searched
from .intervals import Span, gaps
from .motions import OMEGA, Motions, UnderLoad
from .resonances import OperatingPoint, active_orders, equation_orders, operating_point
from .rules import Rules
from .search import Found, Settling, search

AMPLITUDES, HARMONICS = 24, 7
MOST_DAMPED = 0.5  # damping ratio of what is still a resonance
NO_RULES = Rules()
LEAST_MODE = 1e-3  # of the spring's natural frequency: a mode below it is the drift of a motor that nothing holds

SPEED_STEP = 0.025  # relative distance of the speeds of the search
LARGE_SHARE = 0.99  # of a motion under another load
HIGHEST_HARMONIC = 100  # harmonic of an order that may still meet a resonance
BEAT_TEXT = (
    "the error {}, {} s at {} and {} s at {}; the oscillation is that of the turn of "
    f"the motor in which the beat is largest; {A_TURN}"
)
UNSETTLED = (
    "starts do not settle in the steps they have, as the damping is very light or a part is very stiff: motions apart "
    "from the main curve may be missing"
)


class Case(NamedTuple):
    """A drive under one load: the load, its error equation with its operating point, and the whole train or None.

    `full_train` is that train also where the error equation is followed in its place, `held` whether its motor is held.
    """

    load: float
    equation: Any
    point: OperatingPoint
    train: DriveTrain | None
    full_train: DriveTrain | None = None
    held: bool = True

    @property
    def system(self) -> Any:
        """Integrated system: the error equation where that is the drive, or the whole train."""
        if self.train is None or (self.train.motor.held and not left_out(without_gravity(self.train))):
            return self.equation
        return at_load(self.train)

    @property
    def level(self) -> DriveTrain | None:
        """The train without gravity, whose motions repeat with every turn."""
        return self.train and without_gravity(self.train)

    @property
    def searched(self) -> bool:
        """True if other motions are looked for; where all is linear there is one, and one that drifts never repeats."""
        train = self.train
        if train is not None and not train.motor.free and state_space(train, speed=train.omega).drifts:
            return False
        part = None if self.system is self.equation else linear_part_of(self.system)
        laws = (self.equation.law,) if self.system is self.equation else None if part is None else part.laws
        return is_searched(self.equation) and not (laws and all(map(is_linear, laws)))


def is_searched(equation: Any) -> bool:
    """True if other motions are looked for: at constant damping and stiffness, where a motion repeats with a turn."""
    return isinstance(equation, Oscillator) and not any(order % 1 for order in orders_of(equation))


def slowest(case: Case) -> float:
    """Speed [rad/s] below which the drive follows its excitation: no harmonic that counts meets its resonance."""
    natural = sqrt(max(case.point.stiffness, 0.0) / case.equation.J)
    return natural / (HIGHEST_HARMONIC * max(equation_orders(case.equation), default=1))


def case_of(project: Project, load: float, span: Span) -> Case:
    """The drive of a project as it is, whose load is what the map calls `load`.

    Raises
    ------
    ValueError
        If the motor is free and the drive has parts that the error equation leaves out.
    SolveError
        If the law cannot carry the mean torque.
    """
    equation = project.system(0.5 * (span[0] + span[1]), reduced=True)
    point = operating_point(equation)
    train = project.train
    if train is not None:
        refuse_free(train)
        train = train._replace(omega=equation.omega) if has_curve(train) else None
    return Case(load, equation, point, train, project.whole if train is None else None, project.motor == "held")


def main_curve(case: Case, span: Span, level: float = inf) -> DriveResponse:
    """The curve of the drive from one end of the range to the other, in a beat with points at a level [rad].

    Raises
    ------
    SolveError
        If no stable periodic motion is found.
    """
    if case.train is not None:
        curve = train_motions(case.train, span, level, coexisting=False)
    else:
        others = searched(case.equation.law)
        curve = equation_curve(case.equation, span, level, case.full_train, coexisting=others, has_reference=case.held)
    if curve is None or curve.sweep is None:
        beats = curve is not None and curve.curve.beat
        raise SolveError(NONE_STABLE if beats else NO_MOTION if curve is None or len(curve.curve) else curve.message)
    return curve


def under_load(
    case: Case, span: Span, apart: float | None = SPEED_STEP, shift: float = 0.0, rules: Rules = NO_RULES,
    curve: DriveResponse | None = None,
) -> tuple[UnderLoad, tuple[Settling, ...]]:  # fmt: skip
    """All stable motions under a load; and the states that led to those apart from the main curve.

    The speeds of the search are `apart`, relative to each; None leaves it out. `shift` moves them by a share of that
    distance, so that those of many loads differ. The main curve may be known; of a beat it has points at the level of
    the rules. Where no motion is found there are no curves, and `remarks` says why.
    """
    slow = quasi_static(case.equation, case.point)
    try:
        response = curve or main_curve(case, span, rules.level(slow))
    except SolveError as error:
        return UnderLoad(case.load, (), slow, remarks=(str(error),)), ()
    loaded = of_curve(response, slow, case.load, gcd(*active_orders(case.equation)) or 1 if case.searched else 1)
    if response.curve.beat is not None:
        remarks = (*loaded.remarks, _beat(case.train or case.full_train, span), *filter(None, (response.rounding,)))
        loaded = replace(loaded, remarks=remarks)
    if apart is None or not case.searched:
        return loaded, ()
    speeds = searched_at(loaded, span, apart, shift)
    return extended(loaded, case, span, speeds[speeds >= slowest(case)], ())


def of_curve(response: DriveResponse, slow: float, load: float = 0.0, every: int = 1) -> UnderLoad:
    """The motions of one curve of a drive that oscillates by `slow` [rad] where it turns slowly."""
    sweep = response.sweep
    remarks = () if response.status else (f"{response.curve.message}; a speed without a known motion is forbidden",)
    if sweep is None:
        return UnderLoad(load, (Motions(response, every),), slow, remarks=remarks)
    jumps = tuple(
        (float(jump.value), up, jump.after > jump.before)
        for some, up in ((sweep.on_run_up, True), (sweep.on_run_down, False)) for jump in some
    )  # fmt: skip
    jumping = tuple((band.low, band.high) for band in sweep.jumping)
    doubled = doubled_spans(response.curve)
    return UnderLoad(load, (Motions(response, every),), slow, jumps, jumping, tuple(sweep.flips), doubled, (), remarks)


def _beat(train: DriveTrain | None, span: Span) -> str:
    """Sentence on the length of a beat at both ends of a range."""
    turns, text = beat_said(train)
    ends = [end for w in span for end in (number(2.0 * pi * turns / w, 3), f"{number(w / RPM, 5)} rpm")]
    return Sentence(BEAT_TEXT, text, *ends)


def extended(
    loaded: UnderLoad, case: Case, span: Span, speeds: Floats, seeds: tuple[Settling, ...]
) -> tuple[UnderLoad, tuple[Settling, ...]]:
    """The motions with those to which random starts at some speeds, and others, lead."""
    result: Found = search(case, loaded.curves, speeds, seeds, span)
    loaded = replace(
        loaded, curves=(*loaded.curves, *result.curves), loose=(*loaded.loose, *result.loose),
        remarks=loaded.remarks if result.settled else (*loaded.remarks, UNSETTLED),
    )  # fmt: skip
    return loaded, result.seeds


def untried(seeds: Iterable[Settling], loaded: UnderLoad, neighbour: UnderLoad) -> tuple[Settling, ...]:
    """Seeds of a load for its neighbour.

    Motions that no curve has lie at many speeds, and their seeds would add up from load to load: those near which the
    neighbour has one as large are left out.
    """
    sizes = dict[float, float]()
    for one in loaded.loose:
        sizes[one.omega] = max(sizes.get(one.omega, 0.0), one.oscillation)
    loose = np.array([one[:2] for one in neighbour.loose]).reshape(-1, 2)

    def met(seed: Settling) -> bool:
        some = loose[np.abs(loose[:, 0] - seed.omega) < SPEED_STEP * seed.omega, 1]
        return bool(np.any(some > LARGE_SHARE * sizes.get(seed.omega, inf)))

    return tuple(seed for seed in seeds if neighbour.curves and not met(seed))


def searched_at(loaded: UnderLoad, span: Span, apart: float, shift: float) -> Floats:
    """Speeds (n,) of the search: spread over the range, both ends, and where no stable motion is known."""
    steps = np.arange(np.log(span[1] / span[0]) / apart - shift)
    empty = [0.5 * (a + b) for a, b in gaps([(run[0, OMEGA], run[-1, OMEGA]) for run, _ in loaded.runs], span)]
    return np.unique(np.concatenate([span, span[0] * np.exp(apart * (steps + shift)), empty]))


class CampbellLine(NamedTuple):
    """Speed at which an order meets a resonance under one load.

    Attributes
    ----------
    load : float
        Torque [N*m] or inertia [kg*m^2].
    order : float
        Order on the motor's turn; that of the output's turn is 1/N.
    mode : int
        Number of the resonance, from 1 on by ascending frequency.
    amplitude : (n,) array
        Amplitude [rad, 0-to-peak] of the torsion's first harmonic, from 0 on.
    speed : (n,) array
        Motor speed [rad/s].
    excited : bool
        Whether something excites the order.
    """

    load: float
    order: float
    mode: int
    amplitude: Floats
    speed: Floats
    excited: bool

    def at(self, amplitude: float) -> float:
        """Motor speed [rad/s] at an amplitude [rad]; beyond the last one that of the last."""
        return float(np.interp(real("amplitude [rad]", amplitude), self.amplitude, self.speed))


def campbell(case: Case, largest: float, orders: tuple[float, ...]) -> list[CampbellLine]:
    """Lines of every order that is excited, and of further `orders`, up to a largest amplitude [rad]."""
    excited = orders_of_drive(case)
    amplitude, stiffness = stiffnesses(case, largest)
    some = resonances(case, stiffness)
    amplitude, some = amplitude[[rows.size > 0 for rows in some]], [rows for rows in some if rows.size]
    if not some:
        return []
    count = min(rows.shape[1] for rows in some)  # a mode may be a resonance at some amplitudes alone
    modes = np.array([np.sort(rows[0, np.argsort(rows[1])[:count]]) for rows in some]).T  # (modes, amplitudes)
    return [
        CampbellLine(case.load, order, 1 + mode, amplitude, speeds / order, order in excited)
        for order in sorted({*excited, *orders})
        for mode, speeds in enumerate(modes)
    ]


def orders_of_drive(case: Case) -> tuple[float, ...]:
    """Orders on the motor's turn that something excites."""
    orders = set(equation_orders(case.equation))
    if case.train is not None and not case.train.motor.held:
        angles = 2.0 * pi * np.arange(512) / 512
        torque, drag = case.train.motor.excitation, case.train.motor.drag
        size = np.abs(np.fft.rfft(torque.torque(angles) + 0.0 * angles))
        alive = size > 1e-12 * max(float(np.max(size)), 1e-300)
        orders |= {k for k in torque.orders() if k > 0 and (k > 256 or alive[k])}
        resting = (0.0 * angles,) * states_of(drag)
        cogging = np.abs(np.fft.rfft(torque_of(drag, angles, case.train.omega, resting) + 0.0 * angles))
        orders |= set((1 + np.flatnonzero(cogging[1:] > 1e-9 * max(float(np.max(cogging)), 1e-300))).tolist())
    return tuple(sorted(orders))


def stiffnesses(case: Case, largest: float) -> tuple[Floats, Floats]:
    """Amplitudes (n,) [rad] from 0 on, and the stiffness (n,) [N*m/rad] of the spring's free vibration at each."""
    start = np.array([0.0]), np.array([case.point.stiffness])
    varying = not hasattr(case.equation, "B")  # damping that varies is a part of its own
    if varying or depends(case.equation.law) > 1 or not largest > 0.0:
        return start
    mean = Harmonic(0.0, mean=case.point.mean_torque)
    quiet = case.equation._replace(excitation=mean, error=NoError())
    vibration = backbone(quiet, largest * np.arange(1, AMPLITUDES) / (AMPLITUDES - 1), harmonics=HARMONICS)
    stiffness = case.equation.J * vibration.omega**2
    if not start[1][0] > 0.0:
        return vibration.amplitude, stiffness
    return np.append(start[0], vibration.amplitude), np.append(start[1], stiffness)


def resonances(case: Case, stiffness: Floats) -> list[Floats]:
    """Natural frequencies [rad/s] and damping ratios (2, modes) with each stiffness [N*m/rad] as the gear's law."""
    natural = np.sqrt(np.maximum(stiffness, 0.0) / case.equation.J)
    train = case.level
    if train is None or case.system is case.equation:
        return [np.array([[omega], [0.0]]) for omega in natural.tolist()]
    unit = float(np.max(np.abs(stiffness), initial=0.0)) or 1.0
    once = state_space(train._replace(law=Linear(unit)), speed=train.omega).A
    twice = state_space(train._replace(law=Linear(2.0 * unit)), speed=train.omega).A
    every = np.linalg.eigvals(once + (stiffness / unit - 1.0)[:, None, None] * (twice - once))
    return [_resonant(poles, omega) for poles, omega in zip(every, natural.tolist(), strict=True)]


def _resonant(poles: Any, natural: float) -> Floats:
    """Natural frequencies [rad/s] and damping ratios (2, modes) of what swings among poles [1/s]."""
    resonant = poles[(poles.imag > LEAST_MODE * natural) & (-poles.real < MOST_DAMPED * np.abs(poles))]
    return np.array([np.abs(resonant), -resonant.real / np.abs(resonant)])
