"""A design as a project file."""

from collections.abc import Mapping

from ..base.quantities import floated
from ..model.gears import catalogue
from ..model.gears.gear import Gear
from ..study.design.result import Candidate
from ..study.design.specification import Specification
from .fields import groups, schema
from .fields.groups import CATALOGUE, ErrorLine
from .fields.rows import texts_of


def design_text(
    specification: Specification, candidate: Candidate, *, own: Mapping[str, Gear] | None = None, file: str = ""
) -> str:  # fmt: skip
    """Write a design as a project file: its drive with the worst load, through the speeds and all torques of the duty.

    Parameters
    ----------
    specification : Specification
        The specification.
    candidate : Candidate
        A design of the answer.
    own : dict of str to Gear, optional
        Gears of the user's own, by their names, that stand before those of the catalogue.
    file : str
        Name of their file, which is to lie beside the project file.

    Returns
    -------
    str
        YAML that `read_project` reads.

    Raises
    ------
    ValueError
        If a project file does not take the loop of the motor.
    """
    spec, c = specification, floated(candidate)
    low, high = spec.speeds
    record = own[c.gear] if own and c.gear in own else catalogue.gear(c.gear)
    usual = spec.accuracy_of(record) if spec.accuracy or record.accuracy is None else CATALOGUE
    error, peak, tuned = spec.kinematic_error, spec.torques[-1], spec.tuned(c.load_inertia)
    loop = spec.loop if tuned == c.load_inertia else spec.control(c.motor_inertia + tuned / c.ratio**2)
    written = schema.ProjectSpec(
        title=f"{spec.title}: {c.gear}" if spec.title else c.gear,
        gear=schema.NamedGear(name=c.gear, file=file) if own and c.gear in own else c.gear,
        motor=schema.MotorSpec(inertia=c.motor_inertia, **({"mode": "held"} if loop is None else {"loop": loop})),
        load=schema.LoadSpec(inertia=c.load_inertia),
        damping=schema.DampingSpec(B=c.B),
        speed=schema.SpeedSpec(**{"from": low, "to": high, "shaft": "load"}),
        excitation=groups.ExcitationSpec(
            **({"accuracy": usual} if error is None else {"kinematic_error": list(map(ErrorLine.of, error.lines))}),
            load_torque=groups.LoadTorqueSpec(mean=groups.TorqueRange(**{"from": -peak, "to": peak})) if peak else None,
        ),
        limit=schema.LimitSpec(oscillation=spec.limit),
    )
    return "".join(f"{key}: {text}\n" for key, text in texts_of(written).items())
