"""Campbell diagram of a nonlinear drive: motor speeds at which an order meets a resonance, against the amplitude."""

from collections.abc import Iterable, Iterator, Sequence
from math import pi
from typing import Any, NamedTuple

import numpy as np

from ...base.law import depends, states_of, torque_of
from ...base.quantities import number
from ...base.results import Floats
from ...drive.state_space import state_space
from ...model.excitation import Harmonic, NoError
from ...model.laws.springs import Linear
from ...numerics.curves.backbone import backbone
from .error_equation import PEAK_AMPLIFICATION, equation_orders
from .intervals import Span
from .motions import OMEGA, OSCILLATION, LoadMotions
from .under_load import Case

LINE_AMPLITUDES, LINE_HARMONICS = 24, 7  # points of a line, and harmonics of its free vibration
LINE_DISTANCE = 0.1  # relative distance of speeds, within which a peak belongs to a line
MOST_DAMPED = 0.5  # damping ratio of what is still a resonance
LEAST_MODE = 1e-3  # of the spring's natural frequency: a mode below it is the drift of a motor that nothing holds
TURN_SAMPLES = 512  # of a turn, from which the orders of the motor's torques come


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
        return float(np.interp(number("amplitude [rad]", amplitude), self.amplitude, self.speed))


def campbell(case: Case, largest: float, orders: tuple[float, ...]) -> list[CampbellLine]:
    """Lines of every order that is excited, and of further `orders`, up to a largest amplitude [rad]."""
    excited = orders_of_drive(case)
    amplitude, stiffness = stiffnesses(case, largest)
    each = resonances(case, stiffness)
    amplitude, each = amplitude[[table.size > 0 for table in each]], [table for table in each if table.size]
    if not each:
        return []
    count = min(table.shape[1] for table in each)  # a mode may be a resonance at some amplitudes alone
    least_damped = [frequency[np.argsort(damping)[:count]] for frequency, damping in each]
    modes = np.sort(least_damped, axis=1).T  # (modes, amplitudes)
    return [
        CampbellLine(case.load, order, 1 + mode, amplitude, speeds / order, order in excited)
        for order in sorted({*excited, *orders})
        for mode, speeds in enumerate(modes)
    ]


def orders_of_drive(case: Case) -> tuple[float, ...]:
    """Orders on the motor's turn that something excites."""
    orders = set(equation_orders(case.equation))
    if case.train is not None and not case.train.motor.held:
        angles = 2.0 * pi * np.arange(TURN_SAMPLES) / TURN_SAMPLES
        torque, drag = case.train.motor.excitation, case.train.motor.drag
        lines = _orders_in(torque.torque(angles) + 0.0 * angles, 1e-12)
        orders |= {k for k in torque.orders() if k > TURN_SAMPLES // 2 or k in lines}
        resting = (0.0 * angles,) * states_of(drag)
        orders |= _orders_in(torque_of(drag, angles, case.train.omega, resting) + 0.0 * angles, 1e-9)
    return tuple(sorted(orders))


def _orders_in(torque: Floats, least: float) -> set[int]:
    """Orders from 1 on of samples (n,) over a turn whose amplitude is above a share of the largest, the mean's too."""
    size = np.abs(np.fft.rfft(torque))
    return set((1 + np.flatnonzero(size[1:] > least * max(float(np.max(size)), 1e-300))).tolist())


def stiffnesses(case: Case, largest: float) -> tuple[Floats, Floats]:
    """Amplitudes (n,) [rad] from 0 on, and the stiffness (n,) [N*m/rad] of the spring's free vibration at each."""
    small = np.array([0.0]), np.array([case.point.stiffness])
    varying = not hasattr(case.equation, "B")  # damping that varies is a part of its own
    if varying or depends(case.equation.law) > 1 or not largest > 0.0:
        return small
    mean = Harmonic(0.0, mean=case.point.mean_torque)
    quiet = case.equation._replace(excitation=mean, error=NoError())
    amplitudes = largest * np.arange(1, LINE_AMPLITUDES) / (LINE_AMPLITUDES - 1)
    vibration = backbone(quiet, amplitudes, harmonics=LINE_HARMONICS)
    stiffness = case.equation.J * vibration.omega**2
    if not case.point.stiffness > 0.0:
        return vibration.amplitude, stiffness
    return np.append(small[0], vibration.amplitude), np.append(small[1], stiffness)


def resonances(case: Case, stiffness: Floats) -> list[Floats]:
    """Natural frequencies [rad/s] and damping ratios (2, modes) for each stiffness (n,) [N*m/rad] of the gear."""
    natural = np.sqrt(np.maximum(stiffness, 0.0) / case.equation.J)
    train = case.level
    if train is None or case.system is case.equation:
        return [np.array([[omega], [0.0]]) for omega in natural.tolist()]
    unit = float(np.max(np.abs(stiffness), initial=0.0)) or 1.0
    once = state_space(train._replace(law=Linear(unit)), speed=train.omega).A
    twice = state_space(train._replace(law=Linear(2.0 * unit)), speed=train.omega).A
    every = np.linalg.eigvals(once + (stiffness / unit - 1.0)[:, None, None] * (twice - once))
    return [_modes(poles, omega) for poles, omega in zip(every, natural.tolist(), strict=True)]


def _modes(poles: Any, natural: float) -> Floats:
    """Natural frequencies [rad/s] and damping ratios (2, modes) of what swings among poles [1/s]."""
    resonant = poles[(poles.imag > LEAST_MODE * natural) & (-poles.real < MOST_DAMPED * np.abs(poles))]
    return np.array([np.abs(resonant), -resonant.real / np.abs(resonant)])


def lines_of(
    cases: Iterable[Case], by_load: Sequence[LoadMotions], orders: tuple[float, ...]
) -> list[CampbellLine]:  # fmt: skip
    """Lines of the Campbell diagram under every load, up to the largest oscillation that any stable motion has."""
    largest = max((float(np.max(run[:, OSCILLATION])) for loaded in by_load for run, _ in loaded.runs), default=0.0)
    return [line for case in cases for line in campbell(case, largest, orders)]


def resonances_of(loaded: LoadMotions, lines: list[CampbellLine]) -> Iterator[Span]:
    """Speeds over which every excited resonance bends: from small amplitudes to the peaks that lie on its line."""
    peaks = [run[np.argmax(run[:, OSCILLATION])] for run, _ in loaded.runs]
    tops = [(float(row[OMEGA]), float(row[OSCILLATION])) for row in peaks
            if row[OSCILLATION] > PEAK_AMPLIFICATION * loaded.quasi_static]  # fmt: skip
    for line in lines:
        if line.excited:
            bent = [speed for speed, size in tops if abs(speed / line.at(size) - 1.0) < LINE_DISTANCE]
            speeds = [float(line.speed[0]), *bent]
            yield min(speeds), max(speeds)
