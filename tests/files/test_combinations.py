"""Every combination of law, backlash, hysteresis, control, drag and load that a project file allows can be compiled.

The compiler finds all types of what an analysis computes with; `typed_code.py` says how. Every law is in a gear, alone
and behind backlash; every hysteresis is beside one; and every pair of the choices for a train is in one, with laws by
their kind.
"""

import json
import random
import subprocess
import sys
from itertools import combinations, product
from pathlib import Path

import pytest
from canonical import DISSIPATIVE, LAWS

import strainwave as sw
from strainwave.base.law import depends
from strainwave.files.fields.entries import loop_types
from strainwave.files.fields.rows import law_types
from strainwave.files.reading import ProjectError, from_text

SCRIPT = Path(__file__).parent.parent / "typed_code.py"
KNOWN = {name: law for name, law in (LAWS | DISSIPATIVE).items() if type(law) in law_types().values()}
FRICTION = {name: law for name, law in DISSIPATIVE.items() if depends(law) > 1 and not isinstance(law, sw.Parallel)}
DRY, LUGRE, GRAVITY = sw.laws.Coulomb(0.02), DISSIPATIVE["LuGre"], sw.train.AngleTorque(0.3)
RIPPLES = "stiffness: {ripples: [{order: 2, depth: 12 %}]}\n"
TRAIN = {
    "law": (LAWS["Cubic"], LAWS["PiecewiseLinear"], DISSIPATIVE["Parallel, nested"]),
    "backlash": (False, True),
    "control": (
        "mode: held",
        "mode: free",
        "loop: {bandwidth: 9 Hz, lag: 1 ms}",
        *("loop: " + sw.project_entry(c(2.0, 0.3)) for c in loop_types().values() if c is not sw.train.CascadeLoop),
        "loop: {type: cascade, K_v: 2 1/s, K_p: 0.3 N*m*s/rad, T_n: 0.5 s, "
        "filters: [{type: notch, frequency: 9 Hz, width: 3 Hz}]}",
    ),
    "motor_drag": (None, DRY, sw.Parallel(GRAVITY, LUGRE)),
    "load_drag": (DRY, GRAVITY, LUGRE),
    "coupling": (None, LAWS["Linear"], DISSIPATIVE["Parallel, nested"]),
    "error": (True, False),
}


def entry(field, law):
    return "" if law is None else f", {field}: {sw.project_entry(law)}"


def text_of(law, backlash=False, hysteresis=None, control="mode: held", motor_drag=None, load_drag=None,
            coupling=None, error=True, varies=""):  # fmt: skip
    """Project file of a combination."""
    behind = "" if coupling is None else f", coupling: {{inertia: 0.1 kg*m^2{entry('law', coupling)}}}"
    lines = "kinematic_error: [{order: 2, amplitude: 1e-4 rad}], " if error else ""
    return (
        f"gear: {{ratio: 50{entry('law', law)}}}\n"
        + ("backlash: {half_gap: 0.05 mrad}\n" if backlash else "")
        + (f"hysteresis: {sw.project_entry(hysteresis)}\n" if hysteresis else "")
        + f"motor: {{inertia: 4.5 kg*cm^2, {control}{entry('drag', motor_drag)}}}\n"
        f"load: {{inertia: 1.2 kg*m^2{entry('drag', load_drag)}{behind}}}\n"
        f"damping: {{B: 10 N*m*s/rad}}\n{varies}"
        "speed: {from: 1000 rpm, to: 2000 rpm, shaft: motor}\n"
        f"excitation: {{{lines}load_torque: {{mean: -0.1 N*m, lines: [{{order: 2, amplitude: 0.01 N*m}}]}}}}\n"
    )


def gears():
    """Files of every law alone, behind backlash, with a stiffness that varies, and beside each kind of hysteresis."""
    for law in KNOWN.values():
        yield text_of(law)
        yield text_of(law, backlash=True)
    yield from (text_of(law, varies=RIPPLES) for law in (LAWS["Cubic"], LAWS["PiecewiseLinear"], LAWS["Play"]))
    yield from (text_of(LAWS["Cubic"], hysteresis=friction) for friction in FRICTION.values())
    yield text_of(LAWS["PiecewiseLinear"], True, LUGRE)


def trains():
    """Choices for trains until every pair of them is in one, the next one with the most new pairs."""
    rows = [row for row in product(*TRAIN.values()) if not row[1] or depends(row[0]) == 1]
    rows = random.Random(1).sample(rows, 400)
    missing = {pair for row in rows for pair in pairs(row)}
    while missing:
        best = max(rows, key=lambda row: len(pairs(row) & missing))
        missing -= pairs(best)
        yield text_of(**dict(zip(TRAIN, best, strict=True)))


def pairs(row):
    return set(combinations(enumerate(map(repr, row)), 2))


def legal(text):
    try:
        return from_text(text, Path("project.yaml"))
    except ProjectError:
        return None


def untyped(texts):
    """What of the drives cannot be compiled, found in a process of its own."""
    run = subprocess.run([sys.executable, SCRIPT], input=json.dumps(texts), capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr[-2000:]
    return json.loads(run.stdout)


@pytest.mark.slow
def test_every_law_behind_backlash_and_beside_hysteresis_has_types():
    projects = [project for text in gears() if (project := legal(text))]
    laws = {type(part) for project in projects for part in (project.drive.law, *project.drive.law)}
    assert laws >= set(law_types().values()) - {sw.train.AngleTorque, sw.laws.Viscous}
    assert untyped([project.text for project in projects]) == []


@pytest.mark.slow
def test_every_pair_of_choices_for_a_train_has_types():
    texts = list(trains())
    assert all(legal(text).train is not None for text in texts)
    assert untyped(texts) == []
