"""Friction of a gear from what catalogues print: its efficiency, and its running and starting torque without load."""

from ...quantities import number, shown
from ...units import RPM
from ..laws.friction import Coulomb, Viscous
from ..laws.hysteresis import Parallel
from ..laws.meshing import LoadFriction

RUNNING = 2000.0 * RPM  # input speed [rad/s] at which catalogues give efficiency and running torque
CREEP = 1.0  # rad/s of the motor, 10 rpm: over which the sign of dry friction is smoothed


def load_friction(efficiency: float, torque: float, ratio: float, running_torque: float = 0.0) -> LoadFriction:
    """Return the friction of the meshing that gives an efficiency at one torque.

    The motor gives T (1 + mu)/N + T_0 for the output torque T, so that efficiency = 1/(1 + mu + N T_0/T).

    Parameters
    ----------
    efficiency : float
        Output over input power, above 0 and at most 1.
    torque : float
        Output torque T [N*m] that it holds for.
    ratio : float
        Ratio N.
    running_torque : float
        Torque T_0 without load [N*m, motor side] at the speed that it holds for.

    Raises
    ------
    ValueError
        If a number is out of range, the running torque alone loses more than the efficiency says, or the friction
        would lock the gear.
    """
    eta, T = number("efficiency", efficiency, positive=True), number("torque [N*m]", torque, positive=True)
    N, T_0 = number("ratio", ratio, positive=True), number("running_torque [N*m]", running_torque)
    if eta > 1.0:
        raise ValueError(f"efficiency is {eta:g}; it must be at most 1, 77 % is 0.77")
    if T_0 < 0.0:
        raise ValueError(f"running_torque is {T_0:g} N*m; it must not be negative")
    mu = 1.0 / eta - 1.0 - N * T_0 / T
    if not 0.0 <= mu < 1.0:
        why = "the running torque alone loses more than that" if mu < 0.0 else "the load could not drive the motor"
        raise ValueError(
            f"an efficiency of {shown(eta)} at {T:g} N*m with {T_0:g} N*m of running torque gives a friction of "
            f"{mu:.3g} of the torque, and it must be from 0 to 1: {why}; check which number is right"
        )
    return LoadFriction(mu)


def no_load_drag(running_torque: float, starting_torque: float, speed: float = RUNNING) -> Parallel:
    """Return the drag on the motor of a gear without load: dry friction and, up to the running torque, viscous.

    Parameters
    ----------
    running_torque : float
        Torque [N*m, motor side] at the input `speed`.
    starting_torque : float
        Torque [N*m, motor side] that starts the gear: its dry friction.
    speed : float
        Input speed [rad/s] of the running torque. Default: 2000 rpm, as in catalogues.

    Raises
    ------
    ValueError
        If a number is not positive, or the running torque is below the starting one.
    """
    running = number("running_torque [N*m]", running_torque, positive=True)
    starting = number("starting_torque [N*m]", starting_torque, positive=True)
    at = number("speed [rad/s]", speed, positive=True)
    if running < starting:
        raise ValueError(
            f"running_torque is {running:g} and starting_torque {starting:g} N*m; dry and viscous friction together "
            "need at least as much at speed, give a Stribeck law as drag"
        )
    return Parallel(Coulomb(starting, CREEP), Viscous((running - starting) / at))
