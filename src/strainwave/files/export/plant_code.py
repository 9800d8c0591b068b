"""C code of a plant, in fixed steps.

The code has no equation of its own: `DriveTrain.rhs` and the step of the integration method are recorded.

How stiff a train is depends on its state, as that of friction under load does, and what its inputs will be is not
known here. A step is therefore taken in parts where it would be too long. What a part of length h changes is compared
with h (f + g)/2, f and g the rates before and behind it: of an oscillation of frequency w they differ by (h w)^2/12,
and where the method is unstable by more than either.
"""

from dataclasses import replace
from typing import Any

from .c_code import CCode, Parameters, as_name, function, guarded, opening, struct, text_of, with_parameters
from .plant import INPUTS, OUTPUTS, Plant, creep_of
from .traced import Recording

MOST_PARTS = 65536  # parts of a step
DIFFERENCE = 0.02  # of h times the larger rate: h w is 0.5, or a decay of which a step is half the time constant
ZERO_RAD, ROUNDING = (
    1e-12,
    4e-15,
)  # differences that are none, absolute in rad and relative to the largest state
SMALL_DIFFERENCE = 0.25  # of the difference that is allowed: below it the next part is twice as long


class Stepped:
    """System for a scheme whose steps are recorded: its rates are those of the C function."""

    def __init__(self, recording: Recording, count: int) -> None:
        self.recording, self.count = recording, count

    def rhs(self, _phase: Any, y: Any) -> Any:
        """Rates of the state."""
        return self.recording.called("rates(p, c, in, {0}, {1})", y, self.count)


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
    """Parts of the header: sizes, structs and functions."""
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
    """Parts of the source: the parameters and the functions, whose recorded bodies are given by name."""
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
    """Function of the difference between a part of a step and its mean rate, as a share of the largest one allowed."""
    units = [plant.fastest or 1.0 if unit == "rad/s" else 1.0 for _, unit in plant.states()]
    body = f"""\
static const double unit[] = {{{", ".join(map(repr, units))}}};
double size = 0.0, worst = 0.0;
for (int i = 0; i < {len(units)}; i++) {{
    size = fmax(size, fabs(y[i]));
}}
for (int i = 0; i < {len(units)}; i++) {{
    const double most = {DIFFERENCE} * h * fmax(fabs(f[i]), fabs(g[i])) + unit[i] * ({ZERO_RAD} + {ROUNDING} * size);
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
        if (found <= {SMALL_DIFFERENCE} && parts > 1.0 && fmod(done, 2.0) == 0.0) {{
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
    early, late = recording.early_and_late(rates)
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
