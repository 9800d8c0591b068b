"""The plant in C: motor, gear and load of a drive train under the torques on its two shafts, in fixed steps.

The code has no equation of its own: `DriveTrain.rhs` and the step of the integration method are recorded.

How stiff a train is depends on its state, as that of friction under load does, and what its inputs will be is not
known here. A step is therefore taken in parts where it would be too long. What a part of length h changes is compared
with h (f + g)/2, f and g the rates before and behind it: of an oscillation of frequency w they differ by (h w)^2/12,
and where the method is unstable by more than either.
"""

import math
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from ...base.law import breakpoints_of
from ...base.protocols import Law, with_parts
from ...base.quantities import checked, number, numbers, shown
from ...drive.state_space import state_space
from ...model.laws.dry import SMOOTHED, law_width, smoothed
from ...model.train.controls import FREE
from ...model.train.drive_train import DriveTrain, motor_motion
from ...model.train.motion import AtRest
from ...numerics.integration.methods import Dop8, FixedStep
from .c_code import CCode, Parameters, as_name, function, guarded, opening, struct, text_of, with_parameters
from .traced import Recording

INPUTS = (
    ("motor_torque", "N*m", "torque on the motor, held over the step"),
    ("load_torque", "N*m", "torque on the load along its motion; one that resists is negative"),
)
OUTPUTS = (
    ("motor_angle", "rad", "angle of the motor"),
    ("motor_speed", "rad/s", "speed of the motor"),
    ("load_angle", "rad", "angle of the load"),
    ("load_speed", "rad/s", "speed of the load"),
    ("pointing_error", "rad", "motor_angle/N - load_angle"),
    ("gear_torque", "N*m", "torque that the gear transmits, output side"),
)
LARGEST_STEP = 1.0  # in units of the fastest pole: beyond it explicit methods are inaccurate, and soon unstable
BEYOND = 1.01  # times a breakpoint: the slope behind it
MOST_PARTS = 65536  # of a step
DIFFER = 0.02  # of h times the larger rate: h w is 0.5, or a decay of which a step is half the time constant
REST, ROUNDING = 1e-12, 4e-15  # differences that are none, absolute in rad and relative to the largest state
SHORTER = 0.25  # of the difference that is allowed: below it the next part is twice as long


class Input(NamedTuple):
    """A torque that comes from outside."""

    value: Any

    def torque(self, angle: Any) -> Any:
        """Torque [N*m] at any base angle."""
        return self.value


@dataclass(frozen=True)
class Plant:
    """A drive train without its control loop, in fixed steps.

    Attributes
    ----------
    train : DriveTrain
        The train with a free motor at rest, without torques of its own.
    step : float
        Length of a step [s].
    method : Rk4 or Dop8
        Scheme of the steps.
    start : tuple of float
        State to begin with.
    fastest : float
        Fastest pole [1/s] at rest and where the laws are stiffest: what is small beside it is no speed.
    """

    train: DriveTrain
    step: float
    method: FixedStep
    start: tuple[float, ...]
    fastest: float

    def under(self, motor_torque: Any, load_torque: Any) -> DriveTrain:
        """Return the train under torques [N*m] on its shafts."""
        end = self.train.load.end()._replace(excitation=Input(load_torque))
        motor = self.train.motor._replace(excitation=Input(motor_torque))
        return self.train._replace(motor=motor, load=self.train.load.with_end(end))

    def outputs(self, y: Any) -> tuple[Any, ...]:
        """Values of `OUTPUTS` in a state."""
        train = self.train
        angle, speed = motor_motion(train, 0.0, y)
        error = train.load_error(y)
        return angle, speed, angle / train.N - error, train.load_speed(0.0, y), error, train.torque(0.0, y)

    def states(self) -> tuple[tuple[str, str], ...]:
        """Name and unit of every state."""
        names = tuple(name.replace("motor deviation", "motor angle") for name in self.train.state_names())
        return tuple((name, _unit(name)) for name in names)


def plant_of(train: Any, step: Any = None, method: Any = None, start: Any = None) -> Plant:
    """Plant of a drive train: its control, its reference and the torques of its own are left out.

    Parameters
    ----------
    train : DriveTrain
        Motor, gear and load.
    step : float, optional
        Length of a step [s]. Default: as many steps of the method per shortest time scale as it has.
    method : Rk4 or Dop8, optional
        Default: `Dop8()`.
    start : (states,) array_like, optional
        State to begin with, as of the train with a free motor. Default: zeros.

    Raises
    ------
    TypeError
        If the method has no fixed steps.
    ValueError
        If the step is too long for the fastest motion of the train, or `start` has another number of states.
    """
    train = checked(with_parts("export", train, "power_names"))
    method = Dop8() if method is None else method
    if not isinstance(method, FixedStep):
        raise TypeError(f"method is {shown(method)}; C code takes fixed steps: give Rk4() or Dop8()")
    train = smoothed(train._replace(motor=train.motor._replace(control=FREE), reference=AtRest(), omega=1.0))
    states = len(train.state_names())
    begun = (0.0,) * states if start is None else tuple(numbers("start", start, count=states).tolist())
    fastest = _fastest(train)
    unloaded = Plant(train, 0.0, method, begun, fastest).under(0.0, 0.0)
    longest = LARGEST_STEP / fastest if fastest else math.inf
    if step is None:
        step = 2.0 * math.pi * longest / method.steps if fastest else 1e-3
    step = number("step [s]", step, positive=True)
    if step > longest:
        raise ValueError(
            f"the step is {step:g} s and the fastest motion of the train takes steps up to {longest:.3g} s; give a "
            "shorter one"
        )
    return Plant(unloaded, step, method, begun, fastest)


def _fastest(train: DriveTrain) -> float:
    """Size [1/s] of the fastest pole of the train, at rest and where its laws are stiffest."""
    standstill = np.zeros(len(train.state_names()))
    stiff = standstill.copy()
    for index, law in ((0, train.law), *zip(train.twists(), train.load.couplings(), strict=True)):
        stiff[index] = _stiffest(law)
    return max(float(np.max(np.abs(state_space(train, at=state).poles))) for state in (standstill, stiff))


def _stiffest(law: Law) -> float:
    """Twist [rad] behind a breakpoint of a law where it is stiffest; 0 where that is none."""
    twists: list[float] = [0.0, *(BEYOND * twist for twist in breakpoints_of(law))]
    return max(twists, key=lambda twist: float(law.stiffness(twist)) if len(twists) > 1 else 0.0)


class Stepped:
    """System for a scheme whose steps are recorded: its rates are those of the C function."""

    def __init__(self, recording: Recording, count: int) -> None:
        self.recording, self.count = recording, count

    def rhs(self, _phase: Any, y: Any) -> Any:
        """Rates of the state."""
        return self.recording.called("rates(p, c, in, {0}, {1})", y, self.count)


def creep_of(train: DriveTrain) -> list[str]:
    """A sentence on the dry friction of the shafts in code of equal steps, if there is any."""
    if not any(law_width(drag) for drag in (train.motor.drag, train.load.end().drag)):
        return []
    width = f"{SMOOTHED:g} rad/s of the motor and {SMOOTHED / train.N:.3g} rad/s of the load"
    return [f"dry friction is smoothed below {width}, where the shafts creep and do not stick"]


def plant_code(plant: Plant, name: str) -> CCode:
    """C code of a plant.

    Raises
    ------
    Unrecordable
        If a law of the train branches on a value.
    ValueError
        If `name` is no name in C.
    """
    name = as_name(name)
    facts = [
        f"Steps of {plant.step!r} s by {type(plant.method.scheme).__name__}; in SI units and radians.",
        f"Where a state is too stiff for a step, it is taken in equal parts, at most {MOST_PARTS}.",
        "The control loop of the train is left out: its torque is the input motor_torque.",
        "It computes what Python does, to the last bits where products and sums are not fused (-ffp-contract=off).",
        *(f"{fact[0].upper()}{fact[1:]}." for fact in creep_of(plant.train)),
    ]
    top = opening(name, "motor, strain wave gear and load under torques on both shafts.", facts, plant.train)
    numbers, bodies = with_parameters(plant.train, lambda numbers: (numbers, _recorded(plant, numbers)))
    declared, default = numbers.struct(name, [line for body in bodies.values() for line in body])
    header = guarded(name, top, declared, *_declared(plant, name))
    return CCode(name, header, text_of(top, *_defined(plant, name, bodies, default)))


def _declared(plant: Plant, name: str) -> list[list[str]]:
    states = plant.states()
    listed = ", ".join(f"{i} {state} [{unit or '-'}]" for i, (state, unit) in enumerate(states))
    p = f"const {name}_parameters *p"
    called = [
        f"/* The state to begin with. */\nvoid {name}_init({name}_state *state);",
        f"/* One step of {name.upper()}_STEP seconds: state and outputs after it. It gives 0, or 1 where the state is\n"
        f"   too stiff for {MOST_PARTS} parts of a step, or grows beyond bounds: it is then as it was before. */\n"
        f"int {name}_step({p}, {name}_state *state, const {name}_inputs *in, {name}_outputs *out);",
        f"/* One step of h seconds, at most {name.upper()}_STEP; as {name}_step, without outputs. */\n"
        f"int {name}_advance({p}, {name}_state *state, const {name}_inputs *in, double h);",
        f"/* Time derivatives of a state. */\n"
        f"void {name}_rates({p}, const {name}_inputs *in, const {name}_state *state, {name}_state *rate);",
        f"/* Outputs in a state. */\nvoid {name}_read({p}, const {name}_state *state, {name}_outputs *out);",
    ]
    return [
        [f"extern const {name}_parameters {name}_default;"],
        [f"#define {name.upper()}_STATES {len(states)}", f"#define {name.upper()}_STEP {plant.step!r}"],
        struct(f"{name}_state", [f"y[{len(states)}]"], [listed]),
        *(
            struct(f"{name}_{kind}", [field for field, _, _ in given], [f"[{unit}] {what}" for _, unit, what in given])
            for kind, given in (("inputs", INPUTS), ("outputs", OUTPUTS))
        ),
        *([text] for text in called),
    ]


def _defined(plant: Plant, name: str, bodies: dict[str, list[str]], default: list[str]) -> list[list[str]]:
    n, p = len(plant.states()), f"const {name}_parameters *p"
    state, inside = f"{name}_state *state", f"const {name}_inputs *in"
    arguments = f"{p}, const double c[], {inside}"
    early = [f"double c[{max(1, sum(line.startswith('c[') for line in bodies['early']))}];", "early(p, c);"]
    return [
        [f'#include "{name}.h"', "#include <math.h>", "#include <string.h>"],
        default,
        ["/* What the parameters alone decide. */", *function(f"static void early({p}, double c[])", bodies["early"])],
        function(f"static void rates({arguments}, const double y[], double dy[])", bodies["rates"]),
        function(f"static void part({arguments}, const double y[], double h, double z[])", bodies["step"]),
        ["/* What a part changes less h times its mean rate, over what that may be. */", *_difference(plant)],
        function(f"void {name}_init({state})", Recording.stored([f"state->y[{i}]" for i in range(n)], plant.start)),
        function(
            f"void {name}_rates({p}, {inside}, const {state}, {name}_state *rate)",
            [*early, "rates(p, c, in, state->y, rate->y);"],
        ),
        function(f"void {name}_read({p}, const {state}, {name}_outputs *out)", bodies["outputs"]),
        function(f"int {name}_advance({p}, {state}, {inside}, double h)", [*early, *_in_parts(n)]),
        function(
            f"int {name}_step({p}, {state}, {inside}, {name}_outputs *out)",
            [
                f"const int failed = {name}_advance(p, state, in, {name.upper()}_STEP);",
                *("if (!failed) {", f"    {name}_read(p, state, out);", "}", "return failed;"),
            ],
        ),
    ]


def _difference(plant: Plant) -> list[str]:
    units = [plant.fastest or 1.0 if unit == "rad/s" else 1.0 for _, unit in plant.states()]
    body = f"""\
static const double unit[] = {{{", ".join(map(repr, units))}}};
double size = 0.0, worst = 0.0;
for (int i = 0; i < {len(units)}; i++) {{
    size = fmax(size, fabs(y[i]));
}}
for (int i = 0; i < {len(units)}; i++) {{
    const double most = {DIFFER} * h * fmax(fabs(f[i]), fabs(g[i])) + unit[i] * ({REST} + {ROUNDING} * size);
    const double share = fabs(z[i] - y[i] - 0.5 * h * (f[i] + g[i])) / most;
    worst = (share <= worst || worst != worst) ? worst : share;
}}
return worst;"""
    given = "const double y[], const double f[], const double z[], const double g[], double h"
    return function(f"static double difference({given})", body.split("\n"))


def _in_parts(n: int) -> list[str]:
    """Body of a function that goes on by h seconds: in one part, or in 2, 4, 8 ... where that is too long."""
    body = f"""\
double y[{n}], f[{n}], z[{n}], g[{n}], parts = 1.0, done = 0.0;
memcpy(y, state->y, sizeof y);
rates(p, c, in, y, f);
while (done < parts) {{
    part(p, c, in, y, h / parts, z);
    rates(p, c, in, z, g);
    const double found = difference(y, f, z, g, h / parts);
    if (found <= 1.0) {{
        memcpy(y, z, sizeof y);
        memcpy(f, g, sizeof f);
        done += 1.0;
        if (found <= {SHORTER} && parts > 1.0 && fmod(done, 2.0) == 0.0) {{
            parts *= 0.5;
            done *= 0.5;
        }}
    }} else if (parts < {MOST_PARTS}.0) {{
        parts *= 2.0;
        done *= 2.0;
    }} else {{
        return 1;
    }}
}}
memcpy(state->y, y, sizeof y);
return 0;"""
    return body.split("\n")


def _given_state(recording: Recording, n: int) -> tuple[Any, ...]:
    return tuple(recording.given(f"y[{i}]") for i in range(n))


def _recorded(plant: Plant, numbers: Parameters) -> dict[str, list[str]]:
    """Bodies of the functions, by name."""
    n = len(plant.states())
    early, rates = _rates(plant, numbers, n)
    return {"early": early, "rates": rates, "outputs": _outputs(plant, numbers, n), "step": _step(plant, n)}


def _rates(plant: Plant, numbers: Parameters, n: int) -> tuple[list[str], list[str]]:
    recording = Recording()
    torques = (recording.given(f"in->{field}") for field, _, _ in INPUTS)
    train = replace(plant, train=numbers.recorded(recording)).under(*torques)
    rates = train.rhs(0.0, _given_state(recording, n))
    early, late = recording.apart(rates)
    unused = ["(void)p, (void)c;"]
    return unused + early, unused + late + recording.stored([f"dy[{i}]" for i in range(n)], rates)


def _outputs(plant: Plant, numbers: Parameters, n: int) -> list[str]:
    recording = Recording()
    values = replace(plant, train=numbers.recorded(recording)).outputs(_given_state(recording, n))
    fields = [f"out->{field}" for field, _, _ in OUTPUTS]
    kept = ["(void)p;", "const double *y = state->y;"]
    return kept + recording.code(values) + recording.stored(fields, values)


def _step(plant: Plant, n: int) -> list[str]:
    recording = Recording()
    y, h = _given_state(recording, n), recording.given("h")
    after = plant.method.scheme.step(Stepped(recording, n), 0.0, h, y, h)
    return recording.code(after) + recording.stored([f"z[{i}]" for i in range(n)], after)


def _unit(name: str) -> str:
    if " z" in name:
        return ""
    return "rad/s" if name.endswith("'") else "rad"
