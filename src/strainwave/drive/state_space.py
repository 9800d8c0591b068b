"""A drive train about an operating point as matrices: x' = A x + B u, y = C x + D u; for python-control, too."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from ..base.protocols import with_parts
from ..base.quantities import number, numbers
from ..base.records import Along, Labelled, Result
from ..base.results import Complexes, Floats
from ..base.terminal import on_screen
from ..model.excitation import Harmonic, NoError
from ..model.laws.dry import sliding
from ..model.train.controls import motor_states
from ..model.train.drive_train import DriveTrain, coupling_twist
from ..model.train.motion import AtRest, Steady
from ..numerics.balance.rates import jacobians_at

Names = tuple[str, ...]

INTERNAL = " z"  # in the name of an internal state, as "gear z1"
ROUNDING = 1e-9  # of the largest pole: a smaller one is at 0
STEP = 1e-3  # units of the states for differences: x [rad] far inside any law's bends
DIFFERENCE = 6e-9  # of a state: half of the difference of the torque, as of the rates
UNITS = {"motor torque": "N*m", "load torque": "N*m", "motor speed": "rad/s", "load speed": "rad/s",
         "motor deviation": "rad", "motor deviation'": "rad/s", "error": "rad", "gear torque": "N*m"}  # fmt: skip


@dataclass(frozen=True, eq=False)
class StateSpace(Result):
    """Small motions of a drive train about a state: deviations x of the states, torques u, outputs y.

    Attributes
    ----------
    A, B, C, D : (states, states), (states, inputs), (outputs, states), (outputs, inputs) arrays
        Matrices in SI: x' = A x + B u, y = C x + D u.
    inputs, outputs, states : tuples of str
        Names, the units as `units` gives them. The inputs are torques on the motor, unless it is held, and on the load;
        the outputs the speeds of motor and load, the motor's deviation from its reference, the error theta_m/N -
        theta_l between motor and load, and the torque in the gear. A held motor has a speed and a deviation of 0.
    at : (states,) array
        The state about which it is linear.
    speed : float
        Speed of the motor [rad/s] there.
    """

    rows: ClassVar[str] = "rate"
    arrays: ClassVar[Along] = {
        ("rate", "state"): {"A": ""}, ("rate", "input"): {"B": ""},
        ("output", "state"): {"C": ""}, ("output", "input"): {"D": ""},
    }  # fmt: skip

    A: Floats
    B: Floats
    C: Floats
    D: Floats
    inputs: Names
    outputs: Names
    states: Names
    at: Floats
    speed: float

    def units(self, names: Names) -> Names:
        """Units of states, inputs or outputs by their names; empty for internal states of laws and controls."""
        return tuple(map(_unit, tuple(names)))

    @property
    def poles(self) -> Complexes:
        """Eigenvalues (states,) of A [1/s]."""
        return np.linalg.eigvals(self.A).astype(complex)

    @property
    def stable(self) -> bool:
        """True if every pole decays; a free motor, which drifts, is not stable.

        States of a law with memory add poles at 0, which only say that they stay where they are: these do not count.
        """
        return bool(np.all(self.moving.real < 0.0))

    @property
    def memory(self) -> int:
        """Number of internal states of laws and of the control."""
        return sum(INTERNAL in name for name in self.states)

    @property
    def moving(self) -> Complexes:
        """Poles [1/s] but for those at 0 of states that stay where they are."""
        size = np.abs(self.poles)
        at_rest = np.sort(size)[: self.memory] <= ROUNDING * np.max(size, initial=0.0)
        return np.asarray(self.poles[np.argsort(size)[int(np.sum(at_rest)) :]])

    @property
    def drifts(self) -> bool:
        """True if no torque follows the motor's angle, as with a speed loop without an integral."""
        return "motor deviation" in self.states and not np.any(self.A[:, self.states.index("motor deviation")])

    def response(self, omega: ArrayLike) -> Complexes:
        """Frequency response (outputs, inputs, n) at frequencies [rad/s], y over u."""
        unit = np.eye(len(self.A))
        grid = numbers("omega", omega)
        states = np.linalg.solve(1j * grid[:, None, None] * unit - self.A, self.B.astype(complex))
        return np.asarray(np.moveaxis(self.C @ states + self.D, 0, -1), complex)

    def coordinates(self) -> Labelled:
        """Names of rates, states, inputs and outputs, each with its unit beside it."""
        rates = [f"{name}'" for name in self.states]
        named = {"rate": rates, "state": self.states, "input": self.inputs, "output": self.outputs}
        axes: dict[str, tuple[str, list[str], str]] = {name: (name, list(row), "") for name, row in named.items()}
        for name in ("state", "input", "output"):
            axes[f"unit of {name}"] = (name, list(self.units(tuple(named[name]))), "")
        return axes

    def __str__(self) -> str:
        lines = [f"StateSpace: {len(self.states)} states, motor at {self.speed:g} rad/s"]
        for kind, names in (("states", self.states), ("inputs", self.inputs), ("outputs", self.outputs)):
            lines.append(f"  {kind}: " + ", ".join(f"{name} [{_unit(name) or '-'}]" for name in names))
        poles = sorted((p for p in self.poles.tolist() if p.imag >= 0.0), key=abs)
        lines.append(
            "  poles [1/s]: " + ", ".join(f"{p.real:.4g}" + (f" ± {p.imag:.4g}j" if p.imag > 0 else "") for p in poles)
        )
        return on_screen("\n".join(lines))


def state_space(train: DriveTrain, *, at: ArrayLike | None = None, speed: float = 0.0) -> StateSpace:
    """Linearise a drive train, without kinematic error, about an operating point.

    Parameters
    ----------
    train : DriveTrain
        The train with its control loop; its own excitations, kinematic error and reference are left out.
    at : (states,) array_like, optional
        State about which it is linear, for instance x under a mean torque (`operating_state`). Default: zeros.
    speed : float
        Speed of the motor [rad/s] there, which friction depends on. Default: standstill.

    Returns
    -------
    StateSpace
        Matrices `A`, `B`, `C`, `D` in SI with the names and units of states, inputs and outputs. Derivatives are
        central differences, right to about 1e-9 of the largest.

    Raises
    ------
    ValueError
        If `at` has not as many numbers as the train has states.
    """
    train = with_parts("state_space", train, "power_names")
    names = train.state_names()
    state = np.zeros(len(names)) if at is None else numbers("at", at, count=len(names))
    speed = number("speed", speed)
    plain = sliding(undriven(train)._replace(omega=1.0), speed)
    turning = plain._replace(reference=Steady(), omega=speed) if speed else plain
    inputs = ("load torque",) if train.motor.held else ("motor torque", "load torque")
    unforced = driven(turning, "motor", Harmonic(0.0))
    A = jacobians_at(unforced, np.zeros(1), state[:, None], np.full(len(state), STEP))[:, :, 0]
    B = np.stack([_of_unit_torque(turning, name.split()[0], state) for name in inputs], axis=1)
    outputs = ("motor speed", "load speed", "motor deviation", "error", "gear torque")
    C = np.stack([_outputs_by_state(unforced, state, j) for j in range(len(state))], axis=1)
    D = np.zeros((len(outputs), len(inputs)))
    return StateSpace(A, B, C, D, inputs=inputs, outputs=outputs, states=names, at=state, speed=speed)


def undriven(train: DriveTrain) -> DriveTrain:
    """Return the train at rest, without kinematic error."""
    return train._replace(error=NoError(), reference=AtRest())


def driven(train: DriveTrain, source: str, torque: Harmonic) -> DriveTrain:
    """Return the train with this torque on one shaft, "motor" or "load", and none on the other."""
    none = Harmonic(0.0)
    turned = train.with_motor(excitation=torque if source == "motor" else none)
    return turned.with_load(excitation=torque if source == "load" else none)


def _of_unit_torque(train: DriveTrain, source: str, state: Floats) -> Floats:
    """Rates (states,) for a unit torque on a shaft; a torque acts linearly."""
    up = np.array(driven(train, source, Harmonic(0.0, mean=1.0)).rhs(0.0, tuple(state.tolist())))
    down = np.array(driven(train, source, Harmonic(0.0, mean=-1.0)).rhs(0.0, tuple(state.tolist())))
    return np.asarray(0.5 * (up - down))


def _outputs_by_state(train: DriveTrain, state: Floats, j: int) -> Floats:
    """Derivatives (outputs,) of the outputs by a state: all but the torque in the gear are linear."""
    unit = np.eye(len(state))[j]
    (angle, rate), (twist, twist_rate) = motor_states(train.motor.control, unit)[0], coupling_twist(train, unit)
    load = rate / train.N - unit[1] - twist_rate
    up = float(train.torque(0.0, tuple((state + DIFFERENCE * unit).tolist())))
    down = float(train.torque(0.0, tuple((state - DIFFERENCE * unit).tolist())))
    return np.array([rate, load, angle, unit[0] + twist, (up - down) / (2.0 * DIFFERENCE)], float)


def _unit(name: str) -> str:
    if name in UNITS:
        return UNITS[name]
    if name.startswith(("x", "coupling")) and INTERNAL not in name:
        return "rad/s" if name.endswith("'") else "rad"
    return ""


def to_control(train: DriveTrain, *, at: ArrayLike | None = None, speed: float = 0.0) -> Any:
    """Linearise a drive train for python-control (extra `control`).

    Parameters
    ----------
    train, at, speed
        As `state_space`, whose matrices these are: about standstill and zero states by default.

    Returns
    -------
    control.StateSpace
        Inputs `motor_torque`, unless the motor is held, and `load_torque` [N*m]; outputs `motor_angle` and `load_angle`
        [rad], deviations from the reference; states by the names of the train, with `_` and `_rate`.

    Raises
    ------
    ModuleNotFoundError
        If python-control is not installed.
    ValueError
        As `state_space`.
    """
    try:
        import control
    except ImportError:
        raise ModuleNotFoundError("this function needs python-control; pip install 'strainwave[control]'") from None
    linear = state_space(train, at=at, speed=speed)
    outputs = np.zeros((2, len(linear.states)))
    if not train.motor.held:
        outputs[:, linear.states.index("motor deviation")] = 1.0, 1.0 / train.N
    outputs[1, [0, *train.twists()]] = -1.0
    return control.ss(
        linear.A, linear.B, outputs, np.zeros((2, len(linear.inputs))), remove_useless_states=False,
        inputs=list(map(_named, linear.inputs)), outputs=["motor_angle", "load_angle"],
        states=list(map(_named, linear.states)),
    )  # fmt: skip


def _named(name: str) -> str:
    """Name without what python-control gives a meaning to."""
    return name.replace(" ", "_").replace("'", "_rate")
