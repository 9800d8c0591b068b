"""Numbers of a drive that an engineer can change: loop, error lines, mean torque, inertia, damping, stiffness."""

from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np

from ...base.law import depends, is_spring, spring_stiffness
from ...base.protocols import Law, System, lines_of, terms_of
from ...base.quantities import parameters, replace
from ...base.results import SolveError
from ...base.units import ARCSEC
from ...drive.loops.instability import fastest_growth
from ...drive.operating_point import mean_torque, with_more
from ...drive.project import Project
from ...drive.steady import top_of
from ...drive.train_curve import in_turns
from ...model.drive import Drive
from ...model.train.controls import FASTEST, HERTZ, CascadeLoop, PositionLoop, SpeedLoop, core_of, with_core
from ...model.train.drive_train import DriveTrain
from ...model.train.filters import apart
from ..speed_map.error_equation import operating_point

CHANGES = 0.1, 0.3  # relative; the second where the first does next to nothing
ONE_WAY, BOTH_WAYS = (1.0,), (1.0, -1.0)
LEAST_BEND = 0.01  # relative change of the stiffness by the mean torque, from which on it counts
DAMPING = "damping of the gear"
ROUNDING = 1e-9  # of a pole's size: less growth than this is none
POWERS: dict[type, tuple[dict[str, int], dict[str, int]]] = {  # of bandwidth and damping ratio, with which gains go
    PositionLoop: ({"K_p": 2, "K_d": 1}, {"K_d": 1}),
    SpeedLoop: ({"K_p": 1, "K_i": 2}, {"K_i": -2}),
    CascadeLoop: ({"K_v": 1, "K_p": 1, "T_n": -1}, {"T_n": 2}),
}


class Subject(NamedTuple):
    """A drive: its error equation, the whole train where that is followed, and the range of speeds [rad/s].

    `project` is None where the equation is all that is known, `load_torque` [N*m] the constant torque of the load where
    the drive has a range of them.
    """

    system: Any
    train: DriveTrain | None
    speeds: tuple[float, float]
    project: Project | None = None
    load_torque: float | None = None

    @property
    def model(self) -> Any:
        """The model that is followed: the train, else the error equation."""
        return self.system if self.train is None else self.train

    def with_model(self, model: Any) -> "Subject":
        """The same with another model in place of the one that is followed."""
        return self._replace(system=model) if self.train is None else self._replace(train=model)

    def of_drive(self, drive: Drive) -> "Subject":
        """The same with the error equation of another drive."""
        if self.project is None:
            return self
        return self._replace(system=self.project.equation_of(drive, self.load_torque))

    @property
    def has_memory(self) -> bool:
        """True if the law of the gear or of a coupling has friction or memory."""
        couplings = () if self.train is None else self.train.load.couplings()
        return any(depends(law) > 1 for law in (self.model.law, *couplings))

    @property
    def load_torques(self) -> tuple[Any, ...]:
        """Terms of the torque on the load, of an error equation of its excitation."""
        excitation = self.system.excitation if self.train is None else self.train.load.end().excitation
        return terms_of(excitation)

    def largest(self, harmonics: int, coexisting: bool, pairs: Any) -> tuple[float, float] | None:
        """Speed [rad/s] and size [rad] of its largest |error - mean|, as `top_of`."""
        crest = top_of(self.model, self.speeds, harmonics, coexisting, pairs)
        return crest and crest[:2]


class DesignVariable(NamedTuple):
    """One number of a drive that can be changed.

    Attributes
    ----------
    what : str
        Its name.
    value : float
        Where it stands, in `unit`.
    unit : str
        In which engineers give it.
    changed_by : callable
        The drive after a relative change; a sentence on why it cannot be changed so.
    signs : tuple of float
        Directions that may help.
    changes : tuple of float
        Relative changes to try, ascending.
    by : float
        Size [N*m] of a change of a torque, per relative change; 0 of all else.
    """

    what: str
    value: float
    unit: str
    changed_by: Callable[[float], Subject | str]
    signs: tuple[float, ...] = BOTH_WAYS
    changes: tuple[float, ...] = CHANGES
    by: float = 0.0


def design_variables(subject: Subject, amplitude: Callable[[float], float], torque: float) -> Iterator[DesignVariable]:
    """Design variables of a drive, what is changed most easily first.

    Parameters
    ----------
    subject : Subject
        The drive.
    amplitude : callable
        Amplitude [rad] of an order in its error at the peak.
    torque : float
        Largest torque in the gear [N*m], to which changes of the mean torque are related.
    """
    train = subject.train
    if train is not None:
        yield from _of_loop(subject, train)
    yield from _of_error(subject, amplitude)
    if (preload := _preload(subject, torque)) is not None:
        yield preload
    yield from _of_load(subject)
    yield from _of_parts(subject)


def _of_loop(subject: Subject, train: DriveTrain) -> Iterator[DesignVariable]:
    """Bandwidth and damping of the motor's loop, as `from_bandwidth` takes them."""
    control = train.motor.control
    loop, lag = core_of(control), apart(control)[1].get("lag", 0.0)
    inertia = train.loop_inertia
    if isinstance(loop, SpeedLoop):
        inertia += loop.K_d
        tuning = loop.K_p / inertia, 0.5 * loop.K_p / (loop.K_i * inertia) ** 0.5 if loop.K_i > 0.0 else 0.0
    elif isinstance(loop, CascadeLoop):
        tuning = loop.K_p / inertia, 0.5 * (loop.T_n * loop.K_p / inertia) ** 0.5
    elif isinstance(loop, PositionLoop):
        stiff = loop.K_p > 0.0
        tuning = (loop.K_p / inertia) ** 0.5, 0.5 * loop.K_d / (loop.K_p * inertia) ** 0.5 if stiff else 0.0
    else:
        return
    bandwidth, damping = tuning

    def changed_by(powers: dict[str, int], share: float, wider: float) -> Subject | str:
        if bandwidth * wider * lag > FASTEST:
            return f"the bandwidth would be above half the inverse lag, {FASTEST / lag / HERTZ:.4g} Hz"
        gains = {n: getattr(loop, n) * (1.0 + share) ** power for n, power in powers.items()}
        other = train.with_motor(control=with_core(control, loop._replace(**gains)))
        moves = control is not loop or isinstance(loop, CascadeLoop)
        if moves and (pole := fastest_growth(other)).real > ROUNDING * abs(pole):
            return "the loop would be unstable"
        return subject._replace(train=other)

    faster, calmer = next(powers for kind, powers in POWERS.items() if isinstance(loop, kind))
    if bandwidth > 0.0:
        yield DesignVariable("bandwidth of the loop", bandwidth / HERTZ, "Hz", lambda s: changed_by(faster, s, 1.0 + s))
    if damping > 0.0:
        yield DesignVariable("damping of the loop", damping, "", lambda s: changed_by(calmer, s, 1.0))


def _of_error(subject: Subject, amplitude: Callable[[float], float]) -> Iterator[DesignVariable]:
    """The line of the kinematic error that matters: made smaller, and cancelled by feed-forward."""
    model = subject.model
    i = line_that_matters(model.error, amplitude)
    if i is None:
        return
    line = model.error.lines[i]

    def changed_by(share: float) -> Subject:
        return subject.with_model(replace(model, {f"error.lines.{i}.amplitude": (1.0 + share) * line.amplitude}))

    name, size = f"kinematic error of order {in_turns(line.order, subject.train)}", line.amplitude / ARCSEC
    yield DesignVariable(name, size, "arcsec", changed_by, (-1.0,), (1.0,))
    yield DesignVariable(name, size, "arcsec", changed_by, (-1.0,))


def line_that_matters(error: Any, amplitude: Callable[[float], float]) -> int | None:
    """Number of the line whose order is the largest in the error at its peak; None where there is none."""
    sizes = {i: amplitude(line.order) for i, line in enumerate(lines_of(error)) if line.amplitude}
    return max(sizes, key=sizes.__getitem__) if sizes else None


def _preload(subject: Subject, torque: float) -> DesignVariable | None:
    """More mean torque on the load, where the gear's law bends under it; None where the load has a range of torques."""
    system, train = subject.system, subject.train
    if subject.load_torque is not None or not is_spring(system):
        return None

    def with_preload(excitation: Any, share: float) -> Any:
        return with_more(excitation, share * (torque if mean_torque(excitation).mean >= 0.0 else -torque))

    def changed_by(share: float) -> Subject:
        if train is None:
            return subject._replace(system=system._replace(excitation=with_preload(system.excitation, share)))
        return subject._replace(train=train.with_load(excitation=with_preload(train.load.end().excitation, share)))

    if not _changes_stiffness(system, system._replace(excitation=with_preload(system.excitation, CHANGES[0]))):
        return None
    mean = sum(term.mean for term in subject.load_torques)
    return DesignVariable("preload", abs(float(mean)), "N·m", changed_by, ONE_WAY, by=torque)


def _changes_stiffness(system: System, loaded: Any) -> bool:
    """True if a preload that the law carries changes the stiffness at the operating point."""
    try:
        before, after = operating_point(system).stiffness, operating_point(loaded).stiffness  # 0 in the play of a gear
        return abs(after - before) > LEAST_BEND * before
    except SolveError:
        return False


def _of_load(subject: Subject) -> Iterator[DesignVariable]:
    """Inertia of the load, behind its couplings; the gains of a loop stay as they are."""
    name, unit, train, project = "inertia of the load", "kg·m²", subject.train, subject.project
    if train is not None:
        J = train.load.end().J
        yield DesignVariable(name, J, unit, lambda s: subject._replace(train=train.with_load(J=(1.0 + s) * J)))
    elif project is not None:
        drive = project.drive
        yield DesignVariable(
            name, drive.J_l, unit, lambda s: subject.of_drive(drive._replace(J_l=(1.0 + s) * drive.J_l))
        )  # fmt: skip


def _of_parts(subject: Subject) -> Iterator[DesignVariable]:
    """Damping and stiffness of the gear, and of every coupling of a train."""
    model = subject.model
    for p in parameters(model):
        if p.path in ("B", "damping.B") and p.value > 0.0:
            yield _number(subject, DAMPING, p.path, p.value, "N·m·s/rad")
    yield from _stiffness(subject, "gear", "law", model.law)
    couplings = () if subject.train is None else subject.train.load.couplings()
    for i, law in enumerate(couplings):
        name = "coupling" if len(couplings) == 1 else f"coupling {i + 1}"
        path = "load" + i * ".load"
        B = next(p.value for p in parameters(model) if p.path == f"{path}.B")
        if B > 0.0:
            yield _number(subject, f"damping of the {name}", f"{path}.B", B, "N·m·s/rad")
        yield from _stiffness(subject, name, f"{path}.law", law)


def _number(subject: Subject, what: str, path: str, value: float, unit: str) -> DesignVariable:
    model = subject.model

    def changed_by(share: float) -> Subject:
        return subject.with_model(replace(model, {path: (1.0 + share) * value}))

    return DesignVariable(what, value, unit, changed_by, ONE_WAY)


def _stiffness(subject: Subject, name: str, path: str, law: Law) -> Iterator[DesignVariable]:
    """A stiffer law, where its numbers say how."""
    if stiffer(law, CHANGES[0]) is None:
        return
    model, value = subject.model, float(spring_stiffness(law, 0.0))

    def changed_by(share: float) -> Subject:
        new = stiffer(law, share)
        return subject.with_model(replace(model, {f"{path}.{p.path}": p.value for p in parameters(new)}))

    yield DesignVariable(f"stiffness of the {name}", 1e-3 * value, "kN·m/rad", changed_by, ONE_WAY)


def stiffer(law: Law, share: float) -> Any:
    """The law with more torque by a share at every torsion; None where its numbers do not say how."""
    factor = 1.0 + share
    changes = {}
    for p in parameters(law):
        if "N*m" in p.unit:
            changes[p.path] = p.value / factor if p.unit.startswith("1/") else factor * p.value
    changed = replace(law, changes)
    if depends(law) > 1:
        return changed if changes else None
    x = np.geomspace(1e-5, 1e-1, 9)
    same = np.allclose(changed.torque(x), factor * law.torque(x), rtol=1e-9, atol=0.0)
    return changed if same else None
