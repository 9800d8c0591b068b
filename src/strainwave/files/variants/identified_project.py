"""The project of a drive whose joint was identified: its numbers, where they are from, and their scatter."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ...drive.demands.motor_limits import MotorLimits
from ...drive.project import Project
from ...drive.sources import Source
from ...model.excitation import Harmonic, KinematicError, Line
from ...model.laws.friction import Coulomb, LoadFriction, Viscous
from ...model.laws.hysteresis import BoucWen, Parallel
from ...model.laws.springs import PiecewiseLinear
from ...model.train.drive_train import DriveTrain
from ...model.train.motion import AngleTorque
from ...study.identification.joint import solve
from ...study.identification.joint.answer import Answer
from ...study.identification.joint.model import Joint, Pair, line_names
from ..fields.groups import ASSUMED, MEASURED
from ..project_text import project_text
from ..reading import from_text

LAW = ("K1", "K2", "K3", "T1", "T2")
SURE = 3.4  # standard deviations that an amplitude of a line in the project is away from 0: a file takes 30 %
SLOWEST_SHARE = 0.05  # of the log's fastest speed: where the range of a project begins
GEAR_ALONE = """gear: {gear}
motor: {{mode: held}}
load: {{inertia: {inertia!r} kg*m^2}}
damping: {{quality: 20}}
speed: {{from: {slowest!r} rad/s, to: {fastest!r} rad/s, shaft: motor}}
excitation: {{kinematic_error: [{{order: 2, amplitude: 1 arcsec}}]}}
"""  # of a project of which the gear and the load are known


def identified_project(answer: Answer, gear: str | None, given: Project | None) -> Project:
    """The project with the numbers found, and their scatter: of a drive that was given, or of a gear by its name."""
    joint, identified = answer.joint, answer.estimates.values
    untold = {name: joint.scales[name].first for name in (*LAW, "B") if name not in identified}
    numbers = joint.values | untold
    before = _first_project(str(gear), joint) if given is None else given
    lines = _certain_lines(answer)
    train = _with_load_numbers(before.subject, numbers, identified)
    if lines:
        train = train._replace(error=KinematicError(tuple(lines.values())))
    scatter, correlation = _scatter(answer, list(lines))
    after = replace(
        before, subject=_with_motor_numbers(train, identified), motor_limits=_limits(before.motor_limits, identified),
        sources=(*before.sources, *_sources(identified, error_assumed=gear is not None and not lines)),
        scatter=scatter, correlation=correlation,
    )  # fmt: skip
    return from_text(project_text(after), before.path)


def _first_project(gear: str, joint: Joint) -> Project:
    """The project of a gear and a load alone, over the speeds of the logs."""
    fastest = float(np.max(np.abs(np.concatenate([piece.motor_rate for piece in joint.pieces]))))
    slowest, inertia = SLOWEST_SHARE * fastest, joint.values["inertia"]
    text = GEAR_ALONE.format(gear=gear, inertia=inertia, slowest=slowest, fastest=fastest)
    return from_text(text, Path("identified.yaml"))


def _with_load_numbers(train: DriveTrain, numbers: dict[str, float], identified: dict[str, float]) -> DriveTrain:
    """The drive train with spring, hysteresis and damping of the gear, and inertia, friction and gravity of the load.

    Dry and viscous friction are those that the logs tell.
    """
    K1, K2, K3, T1, T2 = (numbers[name] for name in LAW)
    law: Any = PiecewiseLinear(K1, K2, K3, T1, max(T2, T1))
    if numbers["hysteresis"]:
        law = Parallel(law, BoucWen(numbers["hysteresis"], 0.0, numbers["yield_twist"]))
    size, phase = _wave(numbers, ("gravity_sin", "gravity_cos"))
    drag = _with_friction(AngleTorque(size, 1, -phase), identified, "")
    train = train.with_load(J=numbers["inertia"], drag=drag)._replace(law=law)
    if numbers["gravity_mean"]:
        train = train.with_load(excitation=Harmonic(0.0, mean=-numbers["gravity_mean"]))
    if numbers["load_friction"] > 0.0:
        train = train._replace(friction=LoadFriction(numbers["load_friction"]))
    return train._replace(B=numbers["B"]) if "B" in identified else train


def _with_motor_numbers(train: DriveTrain, identified: dict[str, float]) -> DriveTrain:
    """The drive train with the motor's inertia and friction, where a channel of torque tells them."""
    if identified.get("motor_inertia", 0.0) > 0.0:
        train = train.with_motor(J=identified["motor_inertia"])
    friction = _with_friction(None, identified, "motor_")
    return train if friction is None else train.with_motor(drag=friction)


def _limits(limits: MotorLimits | None, identified: dict[str, float]) -> MotorLimits | None:
    """Limits of the motor, with its torque constant where a current tells it."""
    if "torque_constant" not in identified:
        return limits
    return (limits or MotorLimits())._replace(K_t=identified["torque_constant"])


def _sources(identified: dict[str, float], *, error_assumed: bool) -> list[Source]:
    """Sources of the parts of the project that the logs tell, and of a kinematic error that they do not."""
    measured = {"gear": {*LAW} & {*identified}, "damping": {"B"} & {*identified}}
    sources = [Source(name, "", MEASURED) for name, numbers in measured.items() if numbers]
    return [*sources, Source("excitation.kinematic_error", "", ASSUMED)] if error_assumed else sources


def _certain_lines(answer: Answer) -> dict[Pair, Line]:
    """Lines of the kinematic error that stand out of their scatter, by their turns of motor and load."""
    joint = answer.joint
    certain = [pair for pair in joint.lines if is_certain(answer, pair)]
    return {(j, k): Line(j + k / joint.ratio, *_wave(joint.values, line_names((j, k)))) for j, k in certain}


def _with_friction(law: Any, identified: dict[str, float], shaft: str) -> Any:
    """A law, or None, with the dry and viscous friction that was found of a shaft."""
    for name, kind in (("coulomb", Coulomb), ("viscous", Viscous)):
        if identified.get(shaft + name, 0.0) > 0.0:
            part = kind(identified[shaft + name])
            law = part if law is None else Parallel(law, part)
    return law


def _scatter(answer: Answer, lines: Sequence[Pair]) -> tuple[Any, Any]:
    """Deviations of the numbers that were found, relative, by their names in the file, and their correlation."""
    names = {name: f"gear.law.{name}" for name in LAW}
    names |= {"B": "damping.B", "motor_inertia": "motor.inertia"}
    names |= {f"line({j}, {k})": f"excitation.kinematic_error.{i}.amplitude" for i, (j, k) in enumerate(lines)}
    fit, values = answer.estimates, list(answer.estimates.values)
    indices = [values.index(name) for name in names if name in values]
    part = fit.covariance[np.ix_(indices, indices)]
    size = np.sqrt(np.diag(part))
    rows = [(names[values[i]], float(sd / fit.values[values[i]])) for i, sd in zip(indices, size, strict=True)]
    return tuple(rows), tuple(map(tuple, (part / np.outer(size, size)).tolist())) if len(indices) > 1 else None


def _wave(values: dict[str, float], names: Sequence[str]) -> tuple[float, float]:
    """Amplitude and phase of a cosine and a sine: amplitude cos(angle + phase)."""
    a, b = (values[name] for name in names)
    return float(np.hypot(a, b)), float(np.arctan2(-b, a))


def is_certain(answer: Answer, pair: Pair) -> bool:
    """True for a line that stands out of its scatter: other than order 2, which every gear has, as those looked for."""
    name, fit = f"line({pair[0]}, {pair[1]})", answer.estimates
    if name not in fit.values:
        return False
    index, least = list(fit.values).index(name), max(solve.SURE, solve.POWER_OF_TERM * len(answer.joint.weights))
    return bool(fit.values[name] ** 2 > fit.covariance[index, index] * (SURE**2 if pair == (2, 0) else least))
