"""Campbell diagram of a nonlinear drive: motor speeds at which each order meets each resonance, against amplitude.

The free vibration of the gear's spring about the operating point (`backbone`) gives a stiffness for every amplitude;
with that stiffness the train is linear, and its modes meet the orders. For a rigid load and a held motor that is the
backbone of the error equation itself.
"""

from math import pi
from typing import NamedTuple

import numpy as np

from ...law import depends, states_of, torque_of
from ...model.excitation import Harmonic, NoError
from ...model.laws.springs import Linear
from ...numerics.curves.backbone import backbone
from ...results import Floats
from ..response.resonances import active_orders
from ..train.state_space import state_space
from .under_load import Case

AMPLITUDES, HARMONICS = 24, 7
MOST_DAMPED = 0.5  # damping ratio of what is still a resonance
LEAST = 1e-3  # of the spring's natural frequency: a mode below it is the drift of a motor that nothing holds


class CampbellLine(NamedTuple):
    """Where an order meets a resonance under one load.

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
        return float(np.interp(amplitude, self.amplitude, self.speed))


def campbell(case: Case, largest: float, orders: tuple[float, ...]) -> list[CampbellLine]:
    """Lines of every order that is excited, and of further `orders`, up to a largest amplitude [rad]."""
    excited = orders_of_drive(case)
    amplitude, stiffness = stiffnesses(case, largest)
    some = [resonances(case, k) for k in stiffness.tolist()]
    amplitude, some = amplitude[[found.size > 0 for found in some]], [found for found in some if found.size]
    if not some:
        return []
    count = min(found.shape[1] for found in some)  # a mode may be a resonance at some amplitudes alone
    modes = np.array([np.sort(found[0, np.argsort(found[1])[:count]]) for found in some]).T  # (modes, amplitudes)
    return [
        CampbellLine(case.load, order, 1 + mode, amplitude, speeds / order, order in excited)
        for order in sorted({*excited, *orders})
        for mode, speeds in enumerate(modes)
    ]


def orders_of_drive(case: Case) -> tuple[int, ...]:
    """Orders on the motor's turn that something excites."""
    some = set(active_orders(case.equation))
    if case.train is not None and not case.train.motor.held:
        angles = 2.0 * pi * np.arange(512) / 512
        torque, drag = case.train.motor.excitation, case.train.motor.drag
        size = np.abs(np.fft.rfft(torque.torque(angles) + 0.0 * angles))
        alive = size > 1e-12 * max(float(np.max(size)), 1e-300)
        some |= {k for k in torque.orders() if k > 0 and (k > 256 or alive[k])}
        resting = (0.0 * angles,) * states_of(drag)
        cogging = np.abs(np.fft.rfft(torque_of(drag, angles, case.train.omega, resting) + 0.0 * angles))
        some |= set((1 + np.flatnonzero(cogging[1:] > 1e-9 * max(float(np.max(cogging)), 1e-300))).tolist())
    return tuple(sorted(some))


def stiffnesses(case: Case, largest: float) -> tuple[Floats, Floats]:
    """Amplitudes (n,) [rad] from 0 on, and the stiffness (n,) [N*m/rad] of the spring's free vibration at each."""
    start = np.array([0.0]), np.array([case.point.stiffness])
    if depends(case.equation.law) > 1 or not largest > 0.0:
        return start
    if not hasattr(case.equation, "B"):  # damping that varies is a part of its own
        return start
    mean = Harmonic(0.0, mean=case.point.mean_torque)
    quiet = case.equation._replace(excitation=mean, error=NoError())
    found = backbone(quiet, largest * np.arange(1, AMPLITUDES) / (AMPLITUDES - 1), harmonics=HARMONICS)
    own = case.equation.J * found.omega**2
    if not start[1][0] > 0.0:
        return found.amplitude, own
    return np.append(start[0], found.amplitude), np.append(start[1], own)


def resonances(case: Case, stiffness: float) -> Floats:
    """Natural frequencies [rad/s] and damping ratios (2, modes) with a stiffness [N*m/rad] as the gear's law."""
    own = np.sqrt(max(stiffness, 0.0) / case.equation.J)
    if case.train is None or case.system is case.equation:
        return np.array([[own], [0.0]])
    linear = case.train._replace(law=Linear(stiffness))
    poles = state_space(linear, speed=case.train.omega).poles
    resonant = poles[(poles.imag > LEAST * own) & (-poles.real < MOST_DAMPED * np.abs(poles))]
    return np.array([np.abs(resonant), -resonant.real / np.abs(resonant)])
