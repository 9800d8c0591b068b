"""A sampled controller in C: one update a sample, recorded from the controller's own method."""

from typing import Any

from ...base.protocols import need
from ...base.quantities import floated, shown
from ...compile.tree import is_model, leaves, mapped, numbers
from ...model.controllers.closed_loop import LOST
from .c_code import CCode, Parameters, as_name, function, guarded, opening, struct, text_of, with_parameters
from .traced import Recording, literal

HELD = ("hold_torque", "hold_count")
UPDATE_COMMENT = f"""/* Torque [N*m] for a measurement; changes the state.
 * Where a number would not be finite, the state stays, the last torque is given again, and hold_count counts;
 * after {LOST:g} of them in a row the torque is 0. */"""


def controller_code(controller: Any, measurement: Any, name: str) -> CCode:
    """C code of a controller.

    Parameters
    ----------
    controller : NamedTuple
        With `start()` and `update(state, measurement) -> (state, torque)`, without branches.
    measurement : NamedTuple
        Any measurement; only the names of its fields count.
    name : str
        Beginning of the names in C.

    Raises
    ------
    Unrecordable
        If `update` branches on a value.
    TypeError
        If the controller, its state or the measurement is of another kind.
    ValueError
        If `name` is no name in C.
    """
    name = as_name(name)
    need("the controller", controller, "start", "update")
    controller = floated(controller)
    if not is_model(measurement) or not all(isinstance(value, float) for value in measurement):
        raise TypeError(f"the measurement is {shown(measurement)}; it must be a NamedTuple of floats")
    start = _started(controller)
    if not start.keys().isdisjoint(HELD):
        raise TypeError(f"{type(controller).__name__}.start() has a field {' or '.join(HELD)}; give it another name")
    top = opening(name, f"{type(controller).__name__}, one update a sample.", ["In SI units and radians."], controller)

    def recorded(numbers: Parameters) -> tuple[Parameters, list[str], list[str]]:
        return numbers, _begun(numbers, tuple(start)), _updated(numbers, measurement, tuple(start))

    numbers, begun, updated = with_parameters(controller, recorded)
    declared, default = numbers.struct(name, begun + updated)
    given = f"const {name}_parameters *p, {name}_state *state"
    init, update = f"void {name}_init({given})", f"double {name}_update({given}, const {name}_inputs *in)"
    header = guarded(
        name, top, declared, [f"extern const {name}_parameters {name}_default;"],
        struct(f"{name}_state", [*start, *HELD]), struct(f"{name}_inputs", measurement._fields),
        ["/* Start. */", f"{init};"], [UPDATE_COMMENT, f"{update};"],
    )  # fmt: skip
    opened = [f'#include "{name}.h"', "#include <math.h>"]
    return CCode(name, header, text_of(top, opened, default, function(init, begun), function(update, updated)))


def _started(controller: Any) -> dict[str, float]:
    """First state of a controller: numbers by their names in C."""
    state, name = controller.start(), type(controller).__name__
    if not isinstance(state, tuple):
        raise TypeError(f"{name}.start() is {shown(state)}; it must be a tuple of floats")
    values = {}
    for path, _, _, value in numbers(state):
        if not isinstance(value, float):
            raise TypeError(f"{name}.start() has the whole number {value} at {path}; a state is a tuple of floats")
        values[as_name("_".join(part if part.isidentifier() else f"s{part}" for part in path.split(".")))] = value
    return values


def _begun(numbers: Parameters, fields: tuple[str, ...]) -> list[str]:
    """Body of the function that gives the first state."""
    recording = Recording()
    begun = tuple(leaves(numbers.recorded(recording).start()))
    fields_in_c = [f"state->{field}" for field in (*fields, *HELD)]
    return ["(void)p;", *recording.code(begun), *recording.stored(fields_in_c, (*begun, 0.0, 0.0))]


def _updated(numbers: Parameters, measurement: Any, fields: tuple[str, ...]) -> list[str]:
    """Body of the function that updates the state."""
    recording = Recording()
    controller = numbers.recorded(recording)
    before = iter([recording.value(f"state->{field}") for field in fields])  # read before any of them is written
    state = mapped(lambda _: next(before), controller.start())
    measured = type(measurement)(*[recording.given(f"in->{field}") for field in measurement._fields])
    state, torque = controller.update(state, measured)
    after = tuple(leaves(state))
    if len(after) != len(fields):
        who = type(controller).__name__
        raise TypeError(f"{who}.update returns {len(after)} numbers as the state and start() has {len(fields)}")
    new = ", ".join(map(literal, (torque, *after)))
    return [
        "(void)p, (void)in;",
        *recording.code((*after, torque)),
        f"const double found[] = {{{new}}};",
        "double off = 0.0; /* NaN where a number is not finite */",
        f"for (int i = 0; i < {len(after) + 1}; i++) {{",
        "    off += found[i] - found[i];",
        "}",
        "if (off != 0.0) {",
        "    state->hold_count += 1.0;",
        f"    return state->hold_count <= {LOST} ? state->hold_torque : 0.0;",
        "}",
        *recording.stored([f"state->{field}" for field in fields], after),
        *recording.stored(["state->hold_torque", "state->hold_count"], (torque, 0.0)),
        "return state->hold_torque;",
    ]
