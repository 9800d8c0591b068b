"""Rest and hunting of a drive train under its mean torques, with dry friction and an integrating loop."""

from dataclasses import dataclass
from itertools import product
from math import isnan, nan, pi
from typing import Any

import numpy as np

from ...base.facts import Fact
from ...base.law import states_of, torque_of
from ...base.number_text import counted, number
from ...base.records import Result
from ...base.results import Floats, SolveError
from ...base.units import ARCSEC, HERTZ
from ...model.excitation import NoError
from ...model.laws.dry import REST, breakaway, settled
from ...model.train.controls import CascadeLoop, Held, core_of, off_reference
from ...model.train.drive_train import DriveTrain
from ...model.train.motion import AtRest
from ...numerics.integration.methods import Dopri5
from ...numerics.integration.simulate import simulate
from ..motor_words import train_of
from ..operating_point import operating_state, repeats, with_mean_torques, with_more
from ..run import holds_its_place
from ..state_space import state_space
from ..train_curve import torques_of_angle, without_gravity

SLIPS, CYCLE_DIFFERENCE = 80, 1e-4  # slips that are followed, and relative difference of two turns of a cycle
LONGEST_WAIT = 1000.0  # time constants of the slowest motion without a slip, after which there is none
FADING_SHARE = 0.5  # of a slip half of them before: smaller ones may end
SMALLEST_SLIP = 1e-3  # of the largest slip: smaller ones are none
STUCK_INERTIA = 1e12  # times its inertia: a shaft that sticks
STILL_POLE = 1e-3  # of the largest pole: a smaller one is no motion
INTEGRATED_SAG = 1e-9  # rad for 1 N*m: deviation of a motor that an integrator holds
METHOD = Dopri5(rtol=1e-8)
ANGLE, SPEED = 2, 3  # states of the motor: its deviation [rad] and the rate of it


@dataclass(frozen=True, eq=False)
class Standstill(Result):
    """A drive train at rest under its mean torques.

    Attributes
    ----------
    sag : (float, float)
        Least and largest deviation [rad, output side] of the motor from its reference; dry friction holds any between.
    error : (float, float)
        The same of the pointing error of the load [rad], with the twist of gear and couplings.
    loads : (float, float)
        Least and largest torque [N*m] on the load: of its range, and of gravity at every angle.
    motor_friction, load_friction : float
        Break-away torque [N*m] of dry friction on the shafts.
    integrates : bool
        Whether the loop has an integrator that takes the motor to its reference.
    period, size : float
        Of hunting: period [s] and deviation of the motor [rad, output side], 0-to-peak; nan without hunting. Of hunting
        without a fixed period their mean and largest value.
    regular : bool
        Whether every cycle of hunting is like the one before.
    slips : int
        Slips that were followed until they repeated or ended.
    stuck : (float, float)
        Lowest natural frequency [rad/s] of the load on the gear while the motor sticks, and of the motor with its loop
        on the gear while the load sticks; nan for a shaft without dry friction, and where nothing vibrates.
    """

    sag: tuple[float, float]
    error: tuple[float, float]
    loads: tuple[float, float]
    motor_friction: float
    load_friction: float
    integrates: bool
    period: float
    size: float
    regular: bool
    slips: int
    stuck: tuple[float, float] = (nan, nan)

    @property
    def hunts(self) -> bool:
        """True if the motor sticks and slips for ever."""
        return self.period == self.period

    def facts(self) -> tuple[Fact, ...]:
        """Angles at rest, and hunting."""
        hunting = {"period_s": self.period, "size_arcsec": self.size / ARCSEC, "regular": self.regular}
        return (
            Fact("standstill.sag_arcsec", self.sag), Fact("standstill.pointing_error_arcsec", self.error),
            Fact("standstill.integrates", self.integrates),
            Fact("standstill.hunting", hunting if self.hunts else None),
            Fact("standstill.stuck_hz", tuple(None if isnan(w) else w / HERTZ for w in self.stuck)),
            Fact("", self.sentences(), "{}"),
        )  # fmt: skip

    def sentences(self) -> tuple[str, ...]:
        """Sentences on rest and hunting."""
        dry = DRY_TEXT.format(*friction) if any(friction := (self.motor_friction, self.load_friction)) else ""
        sag, error = map(_range, (self.sag, self.error))
        deviation = f"the motor deviates by {sag} (output) from its reference, the load by {error}"
        low, high = map(number, self.loads)
        under = "" if low == high else f", under a load torque of {low} to {high} N·m,"
        level = not dry and max(map(abs, (*self.sag, *self.error))) < LEVEL_ANGLE
        return (
            f"At standstill{under} {'the load has no pointing error' if level else deviation}{dry}.",
            *([self.hunting()] if self.integrates and self.motor_friction else []),
            *(text.format(w / HERTZ) for text, w in zip(STUCK_TEXTS, self.stuck, strict=True) if not isnan(w)),
        )

    def hunting(self) -> str:
        """Hunting: its size and its period."""
        if not self.hunts and self.slips >= SLIPS:
            return f"After {SLIPS} slips the motor still sticks and slips; the computation ends there."
        if not self.hunts:
            return f"No hunting was found: after a disturbance the motor stops within {counted(self.slips, 'slip')}."
        period = f"a period of {self.period:.4g} s"
        if not self.regular:
            period = f"an irregular period, {self.period:.4g} s on average"
        size = f"±{self.size / ARCSEC:.4g} arcsec (output)"
        return f"Hunting: the integrator makes the motor stick and slip by up to {size}, with {period}."


LEVEL_ANGLE = 0.001 * ARCSEC  # of an angle at rest that is not told
STUCK_TEXTS = (
    "While the motor sticks, the load vibrates on the gear at {:.4g} Hz.",
    "While the load sticks, the motor with its loop vibrates on the gear at {:.4g} Hz.",
)
DRY_TEXT = "; dry friction: {:.3g} N·m (motor), {:.3g} N·m (load)"


def _range(ends: tuple[float, float]) -> str:
    low, high = [number(round(value / ARCSEC, 6)) for value in ends]
    return f"{low} arcsec" if low == high else f"{low} to {high} arcsec"


def standstill(project: Any) -> Standstill:
    """Find where a drive rests under its mean torques, and whether its loop hunts.

    Dry friction of a shaft holds it anywhere within its break-away torque: rest is a set, whose ends have the friction
    with either sign. With an integrator and friction on the motor sticks and slips follow each other: the motor rests
    until the integrator breaks it away, slides, and sticks again. They are integrated from a kick until they repeat,
    which is hunting, or end; bristles (`LuGre`) count as the dry friction that they are at steady speeds. Gravity of an
    angle is left out there, friction of the meshing of all. A gear with hysteresis is where a slow load brings it.

    Parameters
    ----------
    project : Project or DriveTrain
        The drive with a loop that holds its motor's angle.

    Returns
    -------
    Standstill
        `sag` of the motor and `error` of the load, least and largest [rad, output side]; `period` [s] and `size` [rad,
        0-to-peak] of hunting.

    Raises
    ------
    ValueError
        If nothing holds the motor's angle.
    SolveError
        If a law cannot carry the torques.

    References
    ----------
    Armstrong-Helouvry, Dupont & Canudas de Wit 1994, Automatica 30(7), 1083-1138, sec. 4 (hunting).
    """
    train = with_mean_torques(train_of(project, "standstill")[1])
    mean, (lowest, highest) = train.load.end().excitation.mean, torques_of_angle(train.load.end().drag)
    low, high = getattr(project, "mean_range", None) or (mean, mean)
    train = without_gravity(train)._replace(error=NoError(), reference=AtRest(), omega=1.0)
    train = train.with_motor(drag=settled(train.motor.drag)).with_load(drag=settled(train.load.end().drag))
    if not _is_held(train):
        raise ValueError("the motor has no loop that holds its angle; give it a position loop or a cascade")
    frictions = float(breakaway(train.motor.drag)), float(breakaway(train.load.end().drag))
    loads = low + lowest, high + highest
    corners = [
        _rest(train, (push, drag + load - mean))
        for push, drag, load in {*product(*((-T, 0.0, T) for T in frictions), loads)}
    ]
    sag, error = [(min(column), max(column)) for column in zip(*corners, strict=True)]
    integrates = bool(np.ptp([_rest(train, (torque, 0.0))[0] for torque in (0.0, 1.0)]) < INTEGRATED_SAG)
    period, size, regular, slips = _hunting(train) if integrates and frictions[0] else (nan, nan, False, 0)
    held, heavy = train.with_motor(control=Held()), train.with_load(J=STUCK_INERTIA * train.load.end().J)
    stuck = [
        _vibration(shaft, operating_state(rests, 0.0)) if T else nan
        for shaft, rests, T in zip((held, heavy), (held, train), frictions, strict=True)
    ]
    return Standstill(sag, error, loads, *frictions, integrates, period, size, regular, slips, (stuck[0], stuck[1]))


def _vibration(train: DriveTrain, state: Floats) -> float:
    """Lowest natural frequency [rad/s] of a train about a state, without dry friction; nan where nothing vibrates."""
    poles = state_space(train, at=state).poles
    size = np.abs(poles[(poles.imag > 0.0) & (np.abs(poles) > STILL_POLE * np.max(np.abs(poles)))])
    return float(np.min(size, initial=np.inf)) if len(size) else nan


def standing(project: Any) -> Standstill | None:
    """Standstill of a drive with dry friction on its shafts or a cascade; None of others, and where none is found."""
    train = train_of(project, "standstill")[1]
    dry = breakaway(settled(train.motor.drag)) + breakaway(settled(train.load.end().drag))
    if not (dry or isinstance(core_of(train.motor.control), CascadeLoop)) or not _is_held(train):
        return None
    if not (repeats(train.motor.excitation) and repeats(train.load.end().excitation)):
        return None
    try:
        return standstill(project)
    except SolveError:
        return None


def _is_held(train: DriveTrain) -> bool:
    """True if a loop holds the motor's angle."""
    return not (train.motor.free or train.motor.held) and holds_its_place(train.motor)


def _rest(train: DriveTrain, pushes: tuple[float, ...]) -> tuple[float, float]:
    """Deviation of the motor over N and pointing error [rad] with torques [N*m] for friction of motor and load."""
    torques = map(with_more, (train.motor.excitation, train.load.end().excitation), pushes)
    state = operating_state(train.with_motor(excitation=next(torques)).with_load(excitation=next(torques)), 0.0)
    return float(off_reference(train.motor.control, state)[0] / train.N), float(train.pointing_error(state))


def _hunting(train: DriveTrain) -> tuple[float, float, bool, int]:
    """Period [s] and size [rad, output side] of hunting, whether it is regular, and the slips that were followed."""
    state = operating_state(train, 0.0)
    poles = state_space(train, at=state).poles
    fastest = float(np.max(np.abs(poles)))
    span = 2.0 * pi / fastest
    longest = LONGEST_WAIT / float(np.min(-poles.real[-poles.real > STILL_POLE**2 * fastest], initial=fastest))
    core, T = core_of(train.motor.control), breakaway(train.motor.drag)
    state[ANGLE] += 2.0 * T / torque_of(core, 1.0, 0.0, (0.0,) * states_of(core))  # twice what breaks it away
    t, angle, moves, rested = np.zeros(1), state[[ANGLE]], np.zeros(1, bool), False
    while not rested:
        run = simulate(train, state, (t[-1], t[-1] + span), method=METHOD)
        if not run.status:
            raise SolveError(f"the motion between two stops was not computed: {run.status.name}")
        state, slides = run.y[:, -1], np.abs(run.y[SPEED]) > REST
        t, angle, moves = np.append(t, run.t), np.append(angle, run.y[ANGLE]), np.append(moves, slides)
        rested, span = span >= longest and not np.any(slides), span if np.any(slides) else min(2.0 * span, longest)
        ends = np.flatnonzero(moves[:-1] & ~moves[1:]) + 1
        stops, times = np.append(angle[0], angle[ends]), np.append(0.0, t[ends])
        strokes, slips = np.abs(np.diff(stops)), len(ends)
        if slips and np.max(strokes[-4:]) < SMALLEST_SLIP * np.max(strokes):
            break
        if _is_cycle(stops):
            return float(times[-1] - times[-3]), float(strokes[-1]) / (2.0 * train.N), True, slips
        if slips >= SLIPS:
            period, size = _mean_cycle(stops, times)
            return period, size / train.N, False, slips
    return nan, nan, False, slips


def _is_cycle(stops: Floats) -> bool:
    """True if the last slips between stops [rad] are equally long and go to and fro."""
    strokes, turns = np.abs(np.diff(stops)), np.diff(stops[-3:])
    equal = len(strokes) > 5 and np.allclose(strokes[-4:], strokes[-1], rtol=CYCLE_DIFFERENCE)
    return bool(equal and turns[0] * turns[1] < 0.0)


def _mean_cycle(stops: Floats, times: Floats) -> tuple[float, float]:
    """Mean period [s] and size [rad] of the later ones of `SLIPS` slips between stops; nan where they fade or drift."""
    last, moments, strokes = stops[SLIPS // 2 :], times[SLIPS // 2 :], np.abs(np.diff(stops))
    middle = 0.5 * (np.max(last) + np.min(last))
    turns = moments[1:][(last[1:] - middle) * (last[:-1] - middle) < 0.0]
    if len(turns) < 2 or strokes[-1] < FADING_SHARE * strokes[SLIPS // 2]:
        return nan, nan
    return 2.0 * float(np.mean(np.diff(turns))), 0.5 * float(np.ptp(last))
