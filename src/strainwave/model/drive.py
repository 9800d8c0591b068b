"""The two-inertia drive of the article and its reduction to one equation for the dynamic error."""

from math import sqrt
from typing import Any, Literal, NamedTuple

from ..base.above import above
from ..base.law import spring_stiffness
from ..base.protocols import Law, need
from ..base.quantities import SMALLEST, AngularSpeed, Damping, Inertia, Ratio, checked, choice, shown
from .excitation import Harmonic, Harmonics, KinematicError, NoError, shortest
from .laws.friction import NO_FRICTION
from .laws.springs import Cubic
from .oscillator import Oscillator
from .train.controls import FREE
from .train.drive_train import DriveTrain
from .train.motion import STEADY
from .train.shafts import NO_DRAG, Load, Motor


class Drive(NamedTuple):
    """Motor (J_m), strain wave gear (ratio N, damping B across the spring, torsion law) and load (J_l)."""

    J_m: Inertia
    J_l: Inertia
    N: Ratio
    B: Damping
    law: Any

    def _repr_html_(self) -> str:
        """Numbers in a notebook."""
        return str(above("card")(self))

    @property
    def J(self) -> float:
        """Inertia N^2 J_m J_l/(N^2 J_m + J_l) [kg m^2] of the error equation with the motor free."""
        J_m, J_l, N = self._inertias()
        reflected = N * N * J_m
        return reflected * J_l / (reflected + J_l)

    def _inertias(self) -> tuple[float, float, float]:
        """Inertias and ratio, checked where they are numbers: SymPy runs the formulas too."""
        J_m, J_l, N, *_ = self if _symbolic(self) else checked(self)
        return J_m, J_l, N

    @property
    def mu(self) -> float:
        """Damping parameter B/J [1/s] with the motor free."""
        return self.B / self.J

    @property
    def omega_0(self) -> float:
        """Natural frequency sqrt(T'(0)/J) [rad/s] with the motor free, T' being that of the law's spring alone.

        Hysteresis adds its stiffness until it yields: small vibrations are faster, and larger ones lie between.
        """
        return _natural_frequency(self.law, self.J)

    @property
    def loop_inertia(self) -> float:
        """Inertia [kg*m^2, motor side] that a loop of the motor turns: the motor, and the rigid load over N^2."""
        J_m, J_l, N = self._inertias()
        return J_m + J_l / (N * N)

    @property
    def omega_0_held(self) -> float:
        """Natural frequency sqrt(T'(0)/J_l) [rad/s] with the motor held at constant speed (the vendors' formula).

        As `omega_0` of the law's spring alone: of a gear of the catalogue K1, whatever hysteresis lies beside it.
        """
        return _natural_frequency(self.law, self._inertias()[1])

    def error_equation(
        self,
        *,
        motor_torque: Harmonic | Harmonics | None = None,
        load_torque: Harmonic | Harmonics | None = None,
        kinematic_error: KinematicError | None = None,
        omega: AngularSpeed = 1.0,
        motor: Literal["free", "held"] = "free",
    ) -> Oscillator:
        """Reduce the drive to the equation of its dynamic error x = theta_m/N - theta_l.

        With the motor free (driven by torque, as in the article) the inertia is `J` and
        tau = J (T_m/(N J_m) - T_l/J_l) (the article prints a wrong factor in it); with a kinematic error this drops the
        speed ripple, terms of order N e'.
        With the motor held (a stiff speed loop) the inertia is J_l and tau = -T_l.

        Parameters
        ----------
        motor_torque : Harmonic or Harmonics, optional
            Torque on the motor [N*m, motor side].
        load_torque : Harmonic or Harmonics, optional
            Torque on the load [N*m, output side], positive along the output's motion: a resisting load is negative.
        kinematic_error : KinematicError, optional
            Lines of the gear's kinematic error [rad, output side].
        omega : float
            Speed of the base angle [rad/s] that all orders refer to.
        motor : {"free", "held"}
            A motor that follows its torque, or one that keeps its speed.

        Raises
        ------
        ValueError
            If `motor` is neither mode, a motor torque is given for a held motor, an inertia or N is not positive, or a
            number is out of range.
        TypeError
            If a torque or the kinematic error is of another kind.
        """
        J_m, J_l, N = self._inertias()
        choice("motor", motor, "free", "held")
        if motor == "held" and motor_torque is not None:
            raise ValueError("a held motor keeps its speed whatever its torque; drop motor_torque or use motor='free'")
        reflected, free = N * N * J_m, motor == "free"
        of_motor = N * J_l / (reflected + J_l)
        of_load = -reflected / (reflected + J_l) if free else -1.0
        terms = _scaled("motor_torque", motor_torque, of_motor) + _scaled("load_torque", load_torque, of_load)
        excitation = shortest(Harmonics(terms) if terms else None)
        error = NoError() if kinematic_error is None else kinematic_error
        system = Oscillator(self.J if free else self.J_l, self.B, self.law, excitation, omega, error)
        return system if _symbolic(system) else checked(system)

    def train(
        self,
        *,
        motor_torque: Any = None,
        load_torque: Any = None,
        kinematic_error: KinematicError | None = None,
        omega: AngularSpeed = 1.0,
        control: Any = FREE,
        motor_drag: Any = NO_DRAG,
        load_drag: Any = NO_DRAG,
        reference: Any = STEADY,
        friction: Any = NO_FRICTION,
    ) -> DriveTrain:
        """Return the whole drive train, of which the error equations are reductions.

        Parameters
        ----------
        motor_torque, load_torque : Harmonic, Harmonics, TorqueProfile or any object with torque(base angle), optional
            Torques [N*m] on the motor and on the load, both along the motion.
        kinematic_error : KinematicError, optional
            Lines of the gear's kinematic error [rad, output side], of the motor's own angle.
        omega : float
            Speed of the base angle [rad/s]; 1 where torques and reference are functions of the time.
        control : Free, Held, SpeedLoop, PositionLoop or any object with torque(x, v) of the deviation
            Control that keeps the motor on its reference.
        motor_drag, load_drag : law
            Torque against each shaft, as a law of its angle and speed: friction, gravity.
        reference : Steady, AtRest or SpeedProfile
            Motion of the motor that the loop keeps and the state's deviation counts from.
        friction : LoadFriction, optional
            Friction of the meshing, a share of the torque that the gear transmits.

        Raises
        ------
        ValueError, TypeError
            With one sentence on what is wrong with which part.
        """
        error = NoError() if kinematic_error is None else kinematic_error
        motor = Motor(self.J_m, shortest(motor_torque), motor_drag, control)
        load = Load(self.J_l, shortest(load_torque), load_drag)
        train = DriveTrain(motor, self.N, self.B, self.law, load, omega, error, reference, friction)
        return train if _symbolic(train) else checked(train)

    def to_control(self, **options: Any) -> Any:
        """Linear train with a free motor as a `control.StateSpace` of python-control; see `state_space`."""
        return self.train().to_control(**options)

    def check(self) -> None:
        """Refuse inertias and a ratio that are not positive (ValueError)."""
        for name in ("J_m", "J_l", "N"):
            if not (value := getattr(self, name)) >= SMALLEST:
                raise ValueError(f"Drive.{name} is {value:g}; it must be positive, {SMALLEST:g} up")
        need("Drive.law", self.law, "torque")


def _symbolic(thing: object) -> bool:
    return any(_symbolic(item) for item in thing) if isinstance(thing, tuple) else hasattr(thing, "free_symbols")


def _natural_frequency(law: Law, inertia: float) -> float:
    stiffness = float(spring_stiffness(law, 0.0))
    if stiffness < 0.0:
        raise ValueError(f"{law} has the stiffness {stiffness:g} N*m/rad at rest: there is no natural frequency")
    return sqrt(stiffness / inertia)


def _scaled(name: str, torque: Harmonic | Harmonics | None, factor: float) -> tuple[Harmonic, ...]:
    if torque is None:
        return ()
    if not isinstance(torque, Harmonic | Harmonics):
        raise TypeError(f"{name} is {shown(torque)}; it must be a Harmonic(amplitude, ...) or Harmonics of several")
    if not _symbolic(torque):
        torque = checked(torque)
    terms = torque.terms if isinstance(torque, Harmonics) else (torque,)
    return tuple(h._replace(amplitude=factor * h.amplitude, mean=factor * h.mean) for h in terms)


# The article's Table 3. HDC_40_050_WARNING says why these are not the numbers of a real size-40 gear.
HDC_40_050 = Drive(J_m=5.26e-4, J_l=5.0e-2, N=50.0, B=0.017, law=Cubic(K=7160.0, alpha=0.1))

HDC_40_050_WARNING = (
    "HDC_40_050 holds the article's Table 3, not a real size-40 gear: catalogues give K1 = 1e5 N*m/rad (here 7160, 14 "
    "times softer), fits of catalogue curves give alpha = 6.9e4 rad^-2 (here 0.1, which makes the cubic term vanish), "
    "a damping ratio of 0.01 to 0.05 is usual (here 0.0005), and the article's 5000 rpm at the motor exceed the "
    "4000 rpm of size 40."
)
