"""Laws of a project file by the place where they stand: in the gear, beside it, on a shaft."""

from collections.abc import Iterator
from functools import partial
from typing import Annotated, Any

from pydantic import AfterValidator, BeforeValidator

from ..base.law import depends
from ..model.laws.hysteresis import BoucWen
from ..model.train.motion import AngleTorque
from .entries import EXAMPLE_LAW, Wrong, law_types, read_entry, refusal
from .yaml_text import Keys


def _parts(law: Any, keys: Keys = ()) -> Iterator[tuple[Keys, Any]]:
    """Laws that a law is made of, at any depth, with their places in its entry; itself where it is made of none."""
    inside = [(name, part) for name, part in zip(law._fields, law, strict=True) if hasattr(part, "torque")]
    for name, part in inside:
        yield from _parts(part, (*keys, name))
    if not inside:
        yield keys, law


def _pass(law: Any, wrong: list[Wrong]) -> Any:
    if wrong:
        raise refusal(*wrong)
    return law


def _not_of_a_shaft(law: Any) -> list[Wrong]:
    sentence = "AngleTorque follows the angle of a shaft; write it as drag under motor or load"
    return [Wrong(keys, sentence) for keys, part in _parts(law) if isinstance(part, AngleTorque)]


def _drag(law: Any) -> Any:
    """Pass what opposes a shaft; a spring does not."""
    wrong = []
    for keys, part in _parts(law):
        if depends(part) == 1 and not isinstance(part, AngleTorque):
            remedy = "write friction, or angle_torque for gravity"
            wrong.append(Wrong(keys, f"{type(part).__name__} is a spring, which ties a shaft to the ground; {remedy}"))
        if isinstance(part, BoucWen) and part.ratio > 0.0:
            what = f"{part.ratio:g} of this torque is a spring, which ties a shaft to the ground"
            wrong.append(Wrong((*keys, "ratio"), f"{what}; write 'ratio: 0', or lugre"))
    return _pass(law, wrong)


def _gear_law(law: Any) -> Any:
    """Pass a law that holds a gear together."""
    _pass(law, _not_of_a_shaft(law))
    rest = float(law.stiffness(0.0))
    if not rest > 0.0 and not (hasattr(law, "breakpoints") and law.breakpoints()):
        remedy = "; write {type: parallel, first: a spring, second: the friction}" if depends(law) > 1 else ""
        raise ValueError(f"the stiffness at rest is {rest:g} N*m/rad; it must be positive{remedy}")
    return law


def _hysteresis(law: Any) -> Any:
    """Pass what stands beside a gear's law and loses energy."""
    if depends(law) == 1:
        raise ValueError(
            f"{type(law).__name__} is a spring, which loses no energy; write for example {EXAMPLE_HYSTERESIS}, and a "
            "spring as gear.law"
        )
    return _pass(law, _not_of_a_shaft(law))


def _read(for_example: str) -> BeforeValidator:
    return BeforeValidator(partial(read_entry, known=law_types(), for_example=for_example))


EXAMPLE_HYSTERESIS = "{type: bouc_wen, K: 6e4 N*m/rad, ratio: 0, yield_twist: 0.08 mrad}"
EXAMPLE_DRAG = "{type: coulomb, T_c: 0.05 N*m, width: 1 rad/s}"
GearLaw = Annotated[Any, AfterValidator(_gear_law), _read(EXAMPLE_LAW)]
Hysteresis = Annotated[Any, AfterValidator(_hysteresis), _read(EXAMPLE_HYSTERESIS)]
Drag = Annotated[Any, AfterValidator(_drag), _read(EXAMPLE_DRAG)]
