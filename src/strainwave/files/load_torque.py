"""The range of torques that the load of a project has, and the drive under each of them."""

from dataclasses import replace
from typing import Any

from ..model.excitation import Harmonic, Harmonics
from ..model.train.drive_train import DriveTrain
from ..study.analysis.load_range import LoadRange, torques_of_angle
from ..study.analysis.train_curve import without_gravity


def load_remark(project: Any) -> tuple[str, ...]:
    """Which torque of the load one curve is for, where the load has a range of them."""
    if (load := project.load_range) is None:
        return ()
    terms = () if project.load_torque is None else project.load_torque.terms
    mean = sum(term.mean for term in terms)
    return (
        f"The curve is for a load torque of {mean:.4g} N*m, of the range from {load.low:.4g} to {load.high:.4g} N*m "
        "that gravity or the file gives; `strainwave analyze` follows the range.",
    )


def load_range(project: Any) -> LoadRange | None:
    """Torques of the load of a project: see `Project.load_range`."""
    terms = () if project.load_torque is None else project.load_torque.terms
    mean = sum(term.mean for term in terms)
    low, high = project.mean_range or (mean, mean)
    if project.train is not None:
        least, most = torques_of_angle(project.train.load.end().drag)
        low, high = low + least, high + most

    def at(torque: float) -> tuple[Any, DriveTrain | None]:
        excitation, train = under(project.load_torque, torque), project.train
        if train is not None:
            train = without_gravity(train)
            end = train.load.end()
            train = train._replace(load=train.load.with_end(end._replace(excitation=excitation)))
        return replace(project, load_torque=excitation, train=train).system(reduced=True), train

    return LoadRange(low, high, mean, at) if low < high else None


def under(given: Harmonics | None, torque: float) -> Harmonics:
    """A load torque with another mean [N*m]."""
    terms = () if given is None else given.terms
    mean = sum(term.mean for term in terms)
    return Harmonics((*terms, Harmonic(0.0, mean=torque - mean)))
