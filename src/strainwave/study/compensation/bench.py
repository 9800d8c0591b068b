"""The bench of a drive: its train under a sampled loop, the model of it, and the plant, which may differ."""

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...base.law import depends, states_of
from ...base.protocols import Control, lacking, lines_of, terms_of
from ...base.quantities import checked
from ...base.results import Floats, SolveError
from ...drive.motor_words import train_of
from ...drive.operating_point import operating_state, with_more
from ...drive.project import Project
from ...drive.speeds import BASES, Speeds
from ...drive.train_curve import follows_its_angle, without_gravity
from ...drive.two_turns import beat_said
from ...model.controllers.closed_loop import ClosedLoop, Sampling
from ...model.controllers.loops import Cascade, Notch, SampledPD, sampled_filter
from ...model.excitation import Harmonic, KinematicError, Line, mean_torque
from ...model.gears.gear import Gear
from ...model.laws import Linear
from ...model.laws.hysteresis import Parallel
from ...model.orders import order_pair
from ...model.oscillator import Oscillator
from ...model.train.commanded import Commanded, TorqueDriven
from ...model.train.controls import USUAL, CascadeLoop, Lagged, PositionLoop, SpeedLoop, from_bandwidth
from ...model.train.drive_train import DriveTrain
from ...model.train.filters import Filtered, PositionIntegral, apart
from ...model.train.motion import AngleTorque, Steady
from ...numerics.ensemble.linear_loops import LoopResponse, loop_response, multipliers
from ...numerics.ensemble.loops import LoopRun, run_loop
from ...numerics.operating_point import loaded_state
from ..analysis.design_variables import stiffer

COMMANDED, TORQUE_DRIVEN = Commanded(), TorqueDriven()
ANGLES = 2.0 * np.pi * np.arange(256) / 256  # of a vibration over which a stiffness is a mean
STAYS = 1e-5  # of a pole from 1: that of a law's memory, and what rounding makes of it


@dataclass(frozen=True)
class Bench:
    """A drive under a sampled loop.

    The drive is a train, or, with the motor's control `TorqueDriven()`, the error equation of a free motor.

    Attributes
    ----------
    model : DriveTrain
        Model of the drive: controllers are designed on it.
    plant : DriveTrain
        The drive that is run.
    loop : controller
        The loop that keeps the motor on its reference: what everything is compared with.
    sampling : Sampling
        Period, delay, limit and encoders.
    gear : Gear or None
        Record whose largest torque the gear is compared with.
    remarks : tuple of str
        Assumptions, as sentences.
    backward : KinematicError or None
        The model's kinematic error in backward motion, where it is another.
    """

    model: DriveTrain
    plant: DriveTrain
    loop: Any
    sampling: Sampling
    gear: Gear | None = None
    remarks: tuple[str, ...] = ()
    backward: KinematicError | None = None

    @property
    def lag(self) -> float:
        """Lag [s] of the current loop, behind which a commanded torque acts."""
        return float(getattr(self.model.motor.control, "lag", 0.0))

    @property
    def lead(self) -> float:
        """Time [s] from a sample to the middle of the time in which its torque acts; the lag counts as a delay."""
        return self.sampling.lead + self.lag

    def at_speed(self, speed: float) -> "Bench":
        """The bench at a motor speed [rad/s]: with the kinematic error of backward motion where that is another."""
        if speed > 0.0 or self.backward is None:
            return self
        model, alike = self.model._replace(error=self.backward), self.plant.error == self.model.error
        return replace(self, model=model, plant=self.plant._replace(error=self.backward) if alike else self.plant)

    @property
    def equation(self) -> bool:
        """True where the drive is the error equation: x is its error, and nothing holds the motor."""
        return isinstance(self.model.motor.control, TorqueDriven)

    @property
    def speeds(self) -> Speeds:
        """Name and unit of its speeds: of the motor, or of the forcing of an error equation."""
        return BASES["forcing" if self.equation else "motor"]

    @property
    def orders(self) -> tuple[Any, ...]:
        """Orders of the lines of kinematic error and torques, ascending; floats where one is of the output's turn."""
        return tuple(sorted({line.order for line in lines_in(self.model)}))

    @property
    def against(self) -> tuple[Harmonic, ...]:
        """Lines of the motor's torque [N*m] that stand against the known torques of the motor and of a rigid load.

        In an error equation x'' = T_m/(N J_m) - T_l/J_l + ..., so that N J_m/J_l T_l cancels a load torque T_l; in a
        train -T_l/N bears it, with the `twists` of the gear.
        """
        model, load = self.model, self.model.load
        of_load = model.N * model.motor.J / load.end().J if self.equation else -1.0 / model.N
        parts = ((model.motor.excitation, -1.0), (load.end().excitation, of_load if load is load.end() else 0.0))
        return tuple(
            term._replace(amplitude=factor * term.amplitude, mean=0.0)
            for torque, factor in parts if factor for term in torque_lines(torque)
        )  # fmt: skip

    def twists(self, speed: float) -> tuple[Line, ...]:
        """Lines of the gear's twist [rad] that bear a rigid load's torque at a motor speed [rad/s], T + B u' = -T_l."""
        model, load, lines = self.model, self.model.load, []
        for term in torque_lines(load.end().excitation) if load is load.end() and not self.equation else ():
            stiffness = float(model.law.stiffness(self.start(speed, model=True)[0]))
            twist = -term.amplitude * np.exp(1j * term.phase) / (stiffness + 1j * term.order * speed * model.B)
            lines.append(Line(term.order, float(np.abs(twist)), float(np.angle(twist))))
        return tuple(lines)

    @property
    def repeat(self) -> float:
        """Turns of the motor after which all lines repeat: 1, or those of a beat where one is of the output's turn."""
        beats = math.gcd(*(order_pair(order, self.model.N)[1] for order in self.orders if order % 1))
        return self.model.N / beats if beats else 1.0

    @property
    def table_turns(self) -> float:
        """Turns of the shaft, in one of the motor, on whose turn all orders are whole: of the motor or the output."""
        return 1.0 / self.model.N if self.repeat > 1.0 else 1.0

    @property
    def memory(self) -> int:
        """Internal states of the model's laws with memory: of the gear and of couplings."""
        laws = (self.model.law, *self.model.load.couplings())
        return sum(states_of(law) for law in laws if not lacking(law, "torque"))

    def closed(self, controller: Any, speed: float, *, model: bool = False) -> ClosedLoop:
        """The drive, or its model, at a motor speed [rad/s] under a controller."""
        train = self.model if model else self.plant
        return ClosedLoop(train._replace(omega=float(speed), reference=Steady()), controller, self.sampling)

    def response(self, speed: float, orders: Any = None, output: Any = None, size: float = 0.0) -> LoopResponse:
        """Response of the model under the plain loop at orders of a motor speed [rad/s], at positive frequencies.

        A law with memory stays where it is left: its pole at 1, one for each internal state, is no motion of the loop.
        With a `size` [rad] a spring has the stiffness of a vibration of that amplitude, its describing function.
        """
        loop, state = self.closed(self.loop, speed, model=True), self.start(speed, model=True)
        if size and depends(law := self.model.law) == 1:
            torque = law.torque(state[0] + size * np.cos(ANGLES))
            stiffness = 2.0 * float(np.mean(torque * np.cos(ANGLES))) / size
            loop = loop._replace(train=loop.train._replace(law=Linear(stiffness)))
        frequencies = abs(speed) * np.array(self.orders if orders is None else orders, float)
        result = loop_response(loop, frequencies, at=state, output=output)
        return replace(result, poles=self._moving(result.poles, 1))

    def growth(self, controller: Any, speed: float, *, model: bool = False) -> float:
        """Rate [1/s] at which the small motion grows that does so most under a controller; it decays where negative.

        It is that of the sampled loop about the state in which the mean torques hold it.
        """
        loop, repeat = self.closed(controller, speed, model=model), 2.0 * np.pi * self.repeat / abs(speed)
        roots, time = multipliers(loop, repeat, at=self.start(speed, model=model))
        samples = round(time / self.sampling.period)
        largest = float(np.max(np.abs(self._moving(roots, samples)), initial=1e-300))
        return float(np.log(largest)) / time

    def _moving(self, roots: Any, samples: int) -> Any:
        """Poles or multipliers over samples without those of a law's memory, which stays where it is left."""
        still = np.argsort(np.abs(roots - 1.0))[: self.memory]
        return np.delete(roots, still[np.abs(roots[still] - 1.0) < STAYS * samples])

    def run(self, controller: Any, speed: float, duration: float) -> LoopRun:
        """The drive at a motor speed [rad/s] under a controller, over a time [s]."""
        return run_loop(self.closed(controller, speed), duration, y0=self.start(speed))

    def start(self, speed: float, *, model: bool = False) -> Floats:
        """State (states,) in which the mean torques hold the drive; zeros where none is found."""
        try:
            return self.held(speed, model=model)
        except (SolveError, ValueError):
            return np.zeros(len((self.model if model else self.plant).state_names()))

    def held(self, speed: float, *, model: bool = False) -> Floats:
        """As `start`, but SolveError says why none is found; zeros where the plain loop holds no torque by itself."""
        train, gains = self.model if model else self.plant, self.loop
        if self.equation:
            inertia, end = train.N * train.motor.J, train.load.end()
            push = mean_torque(train.motor.excitation) / inertia - mean_torque(end.excitation) / end.J
            x, *z = loaded_state(train.law, push / (1.0 / (train.N * inertia) + 1.0 / end.J))
            others = len(train.state_names()) - 5 - len(z)
            return np.array([x, 0.0, 0.0, 0.0, 0.0, *z, *(0.0,) * others])
        while isinstance(gains, Notch):
            gains = gains.loop
        if isinstance(gains, Cascade) and gains.K_v and gains.K_i:
            control: Any = CascadeLoop(gains.K_v, gains.K_p, gains.K_p / gains.K_i)
            integral, stiffness, behind = 4, gains.K_i, 5  # indices of the integral, and of the states behind it
        elif isinstance(gains, SampledPD) and gains.K_p:
            control, integral, stiffness, behind = PositionLoop(gains.K_p, gains.K_d), 2, gains.K_p, 4
        else:
            return np.zeros(len(train.state_names()))
        state = operating_state(train.with_motor(control=control), float(speed))
        torque = [-stiffness * state[integral]] * (2 if self.lag else 1)
        return np.concatenate([state[:4], torque, state[behind:]])

    def with_stiffness(self, share: float) -> "Bench":
        """The bench with a drive whose gear is stiffer by a share than the model says."""
        law = stiffer(self.plant.law, share)
        if law is None:
            raise ValueError(
                f"the stiffness of {type(self.plant.law).__name__} cannot be scaled by its numbers; give `plant`, the "
                "train that differs from the model"
            )
        return replace(self, plant=self.plant._replace(law=law))


def torque_lines(torque: Any) -> tuple[Any, ...]:
    """Lines of a torque that have an amplitude; none of one that does not list them."""
    return tuple(term for term in terms_of(torque) if getattr(term, "amplitude", 0.0))


def lines_in(train: DriveTrain) -> tuple[Any, ...]:
    """Lines of a train's kinematic error [rad], and of the torques [N*m] on its motor and its load."""
    errors = tuple(line for line in lines_of(train.error) if line.amplitude)
    return (*errors, *torque_lines(train.motor.excitation), *torque_lines(train.load.end().excitation))


def _train(project: Any) -> tuple[str, DriveTrain]:
    """As `train_of`; of a project with the speeds of a forcing and a free motor that of its error equation."""
    forced = isinstance(project, Project) and not project.speeds.by_motor
    if not forced or not isinstance(project.system(), Oscillator):
        return train_of(project, "a compensation")
    if project.motor == "held":
        raise ValueError(
            "the motor of this error equation is held: motor torque does not change the error; write 'mode: free' in "
            "its group motor, or give the speeds of the motor and a loop"
        )
    return "torque", project.subject.with_motor(control=TORQUE_DRIVEN)


def bench_of(
    project: Project | DriveTrain, sampling: Sampling | None = None, loop: Any = None, plant: DriveTrain | None = None
) -> Bench:
    """The bench of a project, or of a train itself, with the gains of its loop sampled.

    Raises
    ------
    ValueError
        If it has no whole train, neither a kinematic error nor a line of torque, or a loop that cannot be sampled.
    """
    remarks: list[str] = []
    name, train = _train(project)
    inertia = project.loop_inertia if name else train.loop_inertia
    gear, loaded = getattr(project, "gear", None), getattr(project, "loaded_error", None)
    backward = loaded and loaded.backward and loaded.under(-getattr(project, "mean_load_torque", 0.0), backward=True)
    if not lines_in(train):
        raise ValueError(
            "this drive has neither a kinematic error nor a periodic torque: there is nothing to cancel; add "
            "excitation: {kinematic_error: ...} in the project file"
        )
    if broken := [line.order for line in lines_of(train.error) if line.amplitude and line.order % 1]:
        if train.N % 1 or train.N < 2:
            raise ValueError(
                f"order {broken[0]:.6g} depends on both turns; this needs a whole ratio of at least 2, not "
                f"{train.N:.6g}; remove the order"
            )
        for order in broken:
            order_pair(order, train.N)
        remarks.append(f"The error {beat_said(train)[1]}.")
    timing = _sampling(project, sampling, remarks)
    control, lag = train.motor.control, apart(train.motor.control)[1].get("lag", 0.0)
    if isinstance(control, Lagged):
        control = control.loop
    driven = isinstance(control, TorqueDriven)
    if driven and loop is None:
        loop = SampledPD(0.0, 0.0, timing.period)
        remarks.append(
            "Computed with the error equation, as the speeds are those of a forcing: a motor torque "
            f"adds 1/(N J_m) = {1.0 / (train.N * train.motor.J):.4g} rad/s^2 per N*m to x''; there is no plain loop."
        )
    elif loop is None:
        loop = _sampled(control, inertia, timing, remarks)
    outside = TORQUE_DRIVEN if driven else Lagged(COMMANDED, lag) if lag else COMMANDED
    model = checked(train.with_motor(control=outside)._replace(reference=Steady()))
    other = model if plant is None else plant.with_motor(control=outside)
    return Bench(model, checked(other), checked(loop), checked(timing), gear, tuple(remarks), backward)


def steady_bench_of(
    project: Project | DriveTrain,
    sampling: Sampling | None = None,
    loop: Any = None,
    plant: DriveTrain | None = None,
    load_angle: float | None = None,
) -> Bench:
    """The bench of steady motions: as `bench_of`, with gravity held at its torque at an angle of the load [rad].

    Gravity follows the load's angle, which turns N times slower than the motor: to the vibration it is a constant
    torque. Left as it is, its slow twist of the gear would be counted as an error that no order explains. Without an
    angle it is held at 0.
    """
    bench = bench_of(project, sampling, loop, plant)
    if not (follows_its_angle(bench.model) or follows_its_angle(bench.plant)):
        if load_angle:
            raise ValueError("no torque on this load depends on its angle; remove load_angles")
        return bench
    angle = load_angle or 0.0
    plain, torque = _at_rest(bench.plant, angle)
    more = " `load_angles` of sw.compensate, --load-angle of the command, sets others." if load_angle is None else ""
    remark = (
        f"Gravity varies {bench.plant.N:g} times more slowly than the motor turns. Assumed: constant gravity torque "
        f"of {torque:.4g} N*m, at a load angle of {np.degrees(angle):.4g} deg.{more}"
    )
    return replace(bench, model=_at_rest(bench.model, angle)[0], plant=plain, remarks=(*bench.remarks, remark))


def _at_rest(train: DriveTrain, load_angle: float) -> tuple[DriveTrain, float]:
    """The train with a constant torque [N*m] in place of gravity, that of an angle of the load [rad]."""
    end = train.load.end()
    parts = end.drag if isinstance(end.drag, Parallel) else (end.drag,)
    torque = 0.0 - sum(float(part.torque(load_angle)) for part in parts if isinstance(part, AngleTorque))
    return without_gravity(train).with_load(excitation=with_more(end.excitation, torque)), torque


def _sampling(project: Project | DriveTrain, sampling: Sampling | None, remarks: list[str]) -> Sampling:
    if sampling is not None:
        given: Sampling = checked(sampling)
        return given
    named: Sampling | None = getattr(project, "sampling", None)
    if named is not None:
        return named
    limit = getattr(getattr(project, "motor_limits", None), "most", np.inf)
    limit_text = f"the motor's limit of {limit:.4g} N*m" if limit < np.inf else "no limit of the motor's torque"
    remarks.append(
        "Assumed: samples every 250 us, one period of delay, encoders of 16 bits (motor) and 24 bits (load), "
        f"{limit_text}."
    )
    turn = 2.0 * np.pi
    return Sampling(limit=min(limit, 1e9), motor_quantum=turn / 2**16, load_quantum=turn / 2**24)


def _sampled(control: Control, inertia: float, sampling: Sampling, remarks: list[str]) -> Any:
    period = sampling.period
    if hasattr(control, "at_load"):
        raise ValueError(
            "a compensation closes the sampled loop on the motor's encoder, and the position loop of this drive sees "
            "the load; write 'encoder: motor' in motor.loop, or give a sampled controller as `loop` of sw.compensate"
        )
    if isinstance(control, PositionLoop):
        return SampledPD(control.K_p, control.K_d, period)
    if isinstance(control, SpeedLoop):
        if control.K_d:
            remarks.append("The sampled loop omits the gain K_d of the speed loop, which acts as inertia.")
        return SampledPD(control.K_i, control.K_p, period)
    if isinstance(control, PositionIntegral):
        return _sampled(control.loop, inertia, sampling, remarks)._replace(K_x=1.0 / control.T_p)
    if isinstance(control, CascadeLoop):
        return Cascade(control.K_v, control.K_p, control.K_p / control.T_n, period)
    if isinstance(control, Filtered):
        return sampled_filter(_sampled(control.loop, inertia, sampling, remarks), control.filter.shape(), period)
    if depends(control) == 1 and not lacking(control, "torque"):
        remarks.append(f"The drive's own motor is {type(control).__name__}; a sampled controller needs a loop.")
    loop = from_bandwidth(USUAL.bandwidth, inertia)
    remarks.append("The project has no loop of the motor; a position loop of 30 Hz with damping 0.7 is assumed.")
    return SampledPD(loop.K_p, loop.K_d, period)
