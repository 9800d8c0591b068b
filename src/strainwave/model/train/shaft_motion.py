"""How the motor and the load of a drive train move: the same functions for every class of control and of load.

The motor's own states are (theta_m - reference, its rate), none where it is held. Those of the load are, for every
coupling from the gear on, (twist, its rate, z of its law), and then z of the load's drag.
"""

from typing import Any

from ...compile.jit import chosen, kernel
from ...law import class_of, energy_of, losses_of, rest, share, states_of, torque_of, z_rate_of
from .shafts import Elastic, Free, Held, PositionLoop, SpeedLoop


@chosen
def deviation_of(control: Any, y: Any) -> Any:
    """Deviation (angle [rad], speed [rad/s]) of the motor from its reference, from the train's state."""
    return _no_deviation if class_of(control) is Held else _own_deviation


def _own_deviation(control: Any, y: Any) -> Any:
    return y[2], y[3]


def _no_deviation(control: Any, y: Any) -> Any:
    return 0.0 * y[0], 0.0 * y[0]


@chosen
def internal_states(control: Any, y: Any) -> Any:
    """States of the train after those of the motor."""
    return _after_two if class_of(control) is Held else _after_four


def _after_two(control: Any, y: Any) -> Any:
    return y[2:]


def _after_four(control: Any, y: Any) -> Any:
    return y[4:]


@chosen
def acceleration_of(control: Any, J: Any, torque: Any, reference: Any, deviation: Any) -> Any:
    """Acceleration [rad/s^2] of a motor under a torque without that of its control; `reference` is its reference's."""
    return _prescribed if class_of(control) is Held else _driven


def _prescribed(control: Any, J: Any, torque: Any, reference: Any, deviation: Any) -> Any:
    return reference


def _driven(control: Any, J: Any, torque: Any, reference: Any, deviation: Any) -> Any:
    stiff, damped, heavy = gains_of(control)
    drive = torque - stiff * deviation[0] - damped * deviation[1]
    return (drive + heavy * reference) / (J + heavy)


@chosen
def control_torque(control: Any, J: Any, torque: Any, acceleration: Any, reference: Any, deviation: Any) -> Any:
    """Torque [N*m] of the control, where the motor accelerates like this under it and the other `torque`."""
    return _holding if class_of(control) is Held else _looped


def _holding(control: Any, J: Any, torque: Any, acceleration: Any, reference: Any, deviation: Any) -> Any:
    return J * acceleration - torque


def _looped(control: Any, J: Any, torque: Any, acceleration: Any, reference: Any, deviation: Any) -> Any:
    stiff, damped, heavy = gains_of(control)
    return -stiff * deviation[0] - damped * deviation[1] - heavy * (acceleration - reference)


@chosen
def gains_of(control: Any) -> Any:
    """Gains of a control on the deviation of the angle, of the speed and of the acceleration."""
    return {Free: _no_gains, PositionLoop: _position_gains, SpeedLoop: _speed_gains}[class_of(control)]


def _no_gains(control: Any) -> Any:
    return 0.0, 0.0, 0.0


def _position_gains(control: Any) -> Any:
    return control.K_p, control.K_d, 0.0


def _speed_gains(control: Any) -> Any:
    return control.K_i, control.K_p, control.K_d


@chosen
def motor_rates(control: Any, deviation: Any, acceleration: Any) -> Any:
    """Rates of the motor's own states; `acceleration` [rad/s^2] is that of the deviation."""
    return _no_rates if class_of(control) is Held else _own_rates


def _own_rates(control: Any, deviation: Any, acceleration: Any) -> Any:
    return deviation[1], acceleration


def _no_rates(control: Any, deviation: Any, acceleration: Any) -> Any:
    return ()


@chosen
def load_rates(load: Any, phase: Any, motion: Any, states: Any, torque: Any) -> Any:
    """Acceleration [rad/s^2] of what sits on the gear, and the rates of the load's states.

    `motion` is the (angle, speed) of the gear's output and `torque` [N*m] what the gear gives.
    """
    return _elastic_rates if class_of(load) is Elastic else _rigid_rates


def _rigid_rates(load: Any, phase: Any, motion: Any, states: Any, torque: Any) -> Any:
    angle, speed = motion
    z = share(load.drag, states)
    drag, rates = torque_of(load.drag, angle, speed, z), z_rate_of(load.drag, angle, speed, z)
    return (torque + load.excitation.torque(phase) - drag) / load.J, rates


def _elastic_rates(load: Any, phase: Any, motion: Any, states: Any, torque: Any) -> Any:
    twist, speed, z = states[0], states[1], states[2:]
    behind = motion[0] - twist, motion[1] - speed
    own = share(load.law, z)
    passed = torque_of(load.law, twist, speed, own) + load.B * speed
    here = (torque - passed) / load.J
    there, rates = load_rates(load.load, phase, behind, rest(load.law, z), passed)
    return here, (speed, here - there, *z_rate_of(load.law, twist, speed, own), *rates)


@chosen
def load_twist(load: Any, states: Any) -> Any:
    """Twist [rad] of all couplings together and its rate, from the load's states; of their rates, the rates."""
    return _elastic_twist if class_of(load) is Elastic else _rigid_twist


def _rigid_twist(load: Any, states: Any) -> Any:
    return 0.0, 0.0


def _elastic_twist(load: Any, states: Any) -> Any:
    twist, rate = load_twist(load.load, rest(load.law, states[2:]))
    return states[0] + twist, states[1] + rate


@chosen
def load_energy(load: Any, motion: Any, states: Any) -> Any:
    """Energy [J] in the load: kinetic, and stored in its laws."""
    return _elastic_energy if class_of(load) is Elastic else _rigid_energy


def _rigid_energy(load: Any, motion: Any, states: Any) -> Any:
    angle, speed = motion
    return 0.5 * load.J * speed * speed + energy_of(load.drag, angle, share(load.drag, states))


def _elastic_energy(load: Any, motion: Any, states: Any) -> Any:
    twist, speed, z = states[0], states[1], states[2:]
    behind = motion[0] - twist, motion[1] - speed
    here = 0.5 * load.J * motion[1] * motion[1] + energy_of(load.law, twist, share(load.law, z))
    return here + load_energy(load.load, behind, rest(load.law, z))


@chosen
def load_powers(load: Any, phase: Any, motion: Any, states: Any) -> Any:
    """Powers [W]: what the load torque puts in, then what the load's drag and each coupling lose."""
    return _elastic_powers if class_of(load) is Elastic else _rigid_powers


def _rigid_powers(load: Any, phase: Any, motion: Any, states: Any) -> Any:
    angle, speed = motion
    return load.excitation.torque(phase) * speed, total(losses_of(load.drag, angle, speed, share(load.drag, states)))


def _elastic_powers(load: Any, phase: Any, motion: Any, states: Any) -> Any:
    twist, speed, z = states[0], states[1], states[2:]
    behind = motion[0] - twist, motion[1] - speed
    lost = load.B * speed * speed + total(losses_of(load.law, twist, speed, share(load.law, z)))
    return (*load_powers(load.load, phase, behind, rest(load.law, z)), lost)


@chosen
def total(values: Any) -> Any:
    """Sum of a tuple of numbers, 0 for an empty one."""
    return _sum if len(values) else _zero


def _zero(values: Any) -> Any:
    return 0.0


@kernel
def _summed(values: Any) -> Any:
    amount = values[0]
    for i in range(1, len(values)):
        amount = amount + values[i]
    return amount


def _sum(values: Any) -> Any:
    return _summed(values)


def load_names(load: Any, number: int = 1) -> tuple[str, ...]:
    """Names of the load's states."""
    if not isinstance(load, Elastic):
        return tuple(f"load z{i + 1}" for i in range(states_of(load.drag)))
    name = f"coupling {number}"
    own = tuple(f"{name} z{i + 1}" for i in range(states_of(load.law)))
    return (name, f"{name}'", *own, *load_names(load.load, number + 1))


def coupling_laws(load: Any) -> tuple[Any, ...]:
    """Laws of the couplings between the gear and the load, from the gear on."""
    return (load.law, *coupling_laws(load.load)) if isinstance(load, Elastic) else ()
