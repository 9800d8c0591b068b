"""One drive by every road: Python, commands, API of the app, scripts, notebook and report say the same of a quantity.

Every face gives each quantity that it tells, in one unit. By the same method two values are equal to 1e-9; printed ones
to the digits that are printed; a special point that the app's slider solves for on a coarser curve to 1e-6; values by
another method (an integrated motion beside a balance, the cells of a map beside a curve) within the errors stated here.
"""

import contextlib
import io
import json
import re
from collections import defaultdict
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from click.testing import CliRunner
from matplotlib import pyplot as plt

import strainwave as sw
from strainwave.app.commands import cli as command
from strainwave.app.console.library_words import without_calls
from strainwave.app.web import exports, views
from strainwave.app.web.requests import ScriptRequest, State
from strainwave.app.web.state import project_of
from strainwave.base.units import ARCSEC, RPM
from strainwave.files.variants.names import nominal_of
from strainwave.files.yaml_text import read
from strainwave.study.speed_map.decide import decide
from strainwave.study.speed_map.intervals import between, merged
from strainwave.study.speed_map.rules import rules_of

EXACT, SLIDER, PRINTED, MAP, MOTION = 1e-9, 2e-6, 1e-5, 2e-3, 2e-3
UNITS = {"arcsec": 1.0, "arcmin": 60.0, "deg": 3600.0, "mrad": 1e-3 / ARCSEC, "rad": 1.0 / ARCSEC}
NEUTRAL = "no motion on the curve is stable"
NUMBER = r"(-?\d[\d.]*(?:e[-+]?\d+)?)"


class Value(NamedTuple):
    """What a face says of a quantity: a number with its relative error, or a word."""

    face: str
    value: Any
    error: float = EXACT


def printed(face: str, text: str, pattern: str, scale: float = 1.0, error: float = 0.0) -> Value:
    """A number in a text, right to half a unit of its last digit besides an error of its own."""
    found = re.search(pattern.replace("NUMBER", NUMBER), text)
    assert found, f"{face}: no {pattern!r} in {text!r}"
    digits = found.group(1)
    decimals = len(digits.partition("e")[0].partition(".")[2])
    unit = 10.0 ** (int(digits.partition("e")[2] or 0) - decimals)
    value = float(digits)
    return Value(face, scale * value, error + (0.5001 * unit / abs(value) if value else 1.0))


def run(*words: str) -> str:
    """What a command prints, as its user would call it."""
    result = CliRunner().invoke(command.cli, list(words))
    assert result.exit_code == 0, f"strainwave {' '.join(words)}: {result.output}"
    return result.stdout


def script(project: sw.Project, view: str, folder: Path, **more: Any) -> str:
    """What the exported script of a view prints."""
    text = exports.script_of(ScriptRequest(state=State(project=project.text), view=view, **more))
    out = io.StringIO()
    with contextlib.chdir(folder), contextlib.redirect_stdout(out):
        exec(compile(text, f"{view}.py", "exec"), {"__name__": "__main__"})
    plt.close("all")
    return out.getvalue()


Told = Iterator[tuple[str, Value]]


def responses(path: Path, folder: Path) -> Told:
    """The largest oscillation under the nominal load, its speed, and the largest torque."""
    project = sw.read_project(path)
    found = project.response()
    seen = found.visited()
    top = seen[int(np.argmax(found.oscillation[seen]))]
    size, at = float(found.oscillation[top] / ARCSEC), float(found.omega[top])
    yield "oscillation", Value("Python", size)
    yield "its speed", Value("Python", at)
    yield "torque", Value("Python", found.usage.peak_torque)
    told = json.loads(run("response", str(path), "--json"))
    yield "oscillation", Value("response --json", told["oscillation"]["oscillation_arcsec"])
    yield "its speed", Value("response --json", at * told["oscillation"]["speed"] / project.speeds.own(at))
    text = run("response", str(path))
    factor = UNITS[re.search(r"largest oscillation: \S+ (\S+)", text).group(1)]
    yield "oscillation", printed("response", text, "largest oscillation: NUMBER", factor)
    card = words(found._repr_html_())
    yield "oscillation", printed("notebook", card, "error NUMBER rad at", 1.0 / ARCSEC)
    yield "torque", printed("notebook", card, "torque in it NUMBER N")
    swept = sw.sweep(sw.sample.largest, project, nominal(project))
    yield "oscillation", Value("sweep", swept["oscillation"].item() / ARCSEC)
    yield "torque", Value("sweep", swept["torque"].item())
    for face, whole, error in (("app", True, EXACT), ("app, slider", False, SLIDER)):
        shown = views.response(project_of(State(project=project.text)), whole)["largest"]
        yield "oscillation", Value(face, shown["oscillation_arcsec"], error)
        yield "torque", Value(face, shown["torque"], error if whole else MAP)
    out = script(project, "response", folder)
    yield "oscillation", printed("script", out, "oscillation NUMBER arcsec", error=SLIDER)
    at = alone(found)
    speed = project.speeds.scale * float(found.omega[at])
    shown = views.motion(project_of(State(project=project.text)), speed)
    yield "motion", Value("Python", float(found.oscillation[at] / ARCSEC), MOTION)
    yield "motion", Value("app", shown["oscillation_arcsec"], MOTION)
    out = script(project, "motion", folder, speed=speed)
    yield "motion", printed("script", out, "oscillates by NUMBER arcsec", error=MOTION)


def alone(found: Any) -> int:
    """The point with the largest oscillation at whose speed the curve has one motion only."""
    side = np.sign(found.omega[:, None] - found.omega[None, found.visited()])
    crossings = np.sum(side[1:] * side[:-1] < 0.0, axis=0) + np.sum(side == 0.0, axis=0)
    single = found.visited()[crossings == 1]
    return int(single[np.argmax(found.oscillation[single])])


def words(page: str) -> str:
    """The text of a page without its figures."""
    return re.sub(r"\s+", " ", re.sub("<style.*?</style>|<svg.*?</svg>|<[^>]*>", " ", page, flags=re.S))


def nominal(project: sw.Project) -> dict[str, list[str]]:
    """A grid of the one point that the file is."""
    value, unit = nominal_of(read(project.text).content, project.gear, "load.inertia")
    return {"load.inertia": [f"{value!r} {unit}"]}


def analyses(path: Path, folder: Path) -> Told:
    """What is judged over all loads of the drive: verdict, allowed speeds, largest oscillation and torque."""
    project, out = sw.read_project(path), folder / "report"
    results = json.loads(run("analyze", str(path), "-o", str(out), "--json"))
    file = json.loads((out / "results.json").read_text(encoding="utf-8"))
    page = words((out / "report.html").read_text(encoding="utf-8"))
    yield "analyzed oscillation", printed("report", page, "largest oscillation NUMBER arcsec at")
    yield "analyzed torque", printed("report", page, "Gear torque up to NUMBER N")
    yield (
        "analyzed oscillation",
        printed("verdict", results["verdict"]["answers"]["largest oscillation"], "NUMBER arcsec"),
    )
    for face, told in (("analyze --json", results), ("results.json", file)):
        yield "analyzed oscillation", Value(face, told["largest_oscillation"]["oscillation_arcsec"])
        yield "analyzed torque", Value(face, told["largest_torque"]["torque_Nm"])
        yield "answer", Value(face, told["verdict"]["answer"])
        cases = told["advice"]["by_load_torque"] or [told["advice"] | {"load_torque_Nm": project.mean_load_torque}]
        loads = [case["load_torque_Nm"] for case in cases]
        for load, case in zip(loads, cases, strict=True):
            bands = [(band["from_rpm"] * RPM, band["to_rpm"] * RPM) for band in case["bands"]]
            yield f"allowed by the motion under {load} N*m", Value(face, allowed(bands, project))
    decided = decide(project, rules_of(None, None, None, project.limit))
    for load, bands in zip(loads, decided.moving, strict=True):
        yield f"allowed by the motion under {load} N*m", Value("API", allowed(bands.forbidden, project))
    for face, told in (("analyze --json", results), ("results.json", file)):
        ends = tuple(band[end] for band in told["verdict"]["allowed_speeds"] for end in ("from_rpm", "to_rpm"))
        yield "allowed", Value(face, ends)
    told = json.loads(run("speed-map", str(path), "-o", str(folder / "map"), "--json"))
    yield "allowed", Value("speed-map --json", tuple(np.ravel(told["allowed_under_every_load_rpm"])))
    shown = views.mapped(project_of(State(project=project.text)), True, [], lambda *_: None)
    yield "allowed", Value("app", tuple(np.ravel(shown["allowed"])))
    said = re.findall(f"allowed: {NUMBER} to {NUMBER} rpm", script(project, "speed-map", folder))
    yield "allowed", Value("script", tuple(float(end) for pair in said for end in pair), PRINTED)
    response = views.response(project_of(State(project=project.text)), True)
    passes = response["passes"]
    if passes is not None:
        yield "passes", Value("app", passes)
        yield "passes", Value("analyze", file["verdict"]["answer"] == "pass")


def moves(path: Path, folder: Path) -> Told:
    """Pointing error, settling and torques of a move."""
    project = sw.read_project(path)
    try:
        found = sw.move(project)
    except sw.SolveError as error:  # a drive that the move throws off
        yield "refusal of the move", Value("Python", str(error))
        yield "refusal of the move", Value("move", refusal("move", str(path), "-o", str(folder / "move")))
        return
    told = json.loads(run("move", str(path), "-o", str(folder / "move"), "--json"))
    shown = views.moved(project_of(State(project=project.text)))
    error, out = told["pointing_error_rad"], script(project, "move", folder)
    yield "move", Value("Python", found.peak_error / ARCSEC)
    yield "move", Value("move --json", error["peak"] / ARCSEC)
    yield "move", Value("app", shown["peak_arcsec"])
    yield "move", printed("script", out, "pointing error NUMBER arcsec")
    yield "move rms", Value("Python", found.rms_error / ARCSEC)
    yield "move rms", Value("move --json", error["rms"] / ARCSEC)
    yield "move rms", Value("app", shown["rms_arcsec"])
    for face, settled in (
        ("Python", found.settling_time),
        ("move --json", told["settling_time_s"]),
        ("app", shown["settling_time"]),
    ):
        yield "settling", Value(face, settled)
    yield "motor torque", Value("Python", found.peak_motor_torque)
    yield "motor torque", Value("move --json", told["motor"]["peak_torque_N_m"])


def compared(paths: list[Path], folder: Path) -> dict[Path, list[tuple[str, Value]]]:
    """The rows of `compare`."""
    told = json.loads(run("compare", *map(str, paths), "-o", str(folder), "--json"))["drives"]
    return {
        path: [
            ("analyzed oscillation", Value("compare", row["oscillation_arcsec"])),
            ("analyzed torque", Value("compare", row["torque_N_m"])),
        ]
        for path, row in zip(paths, told, strict=True)
    }


def allowed(bands: Iterable[Any], project: sw.Project) -> tuple[float, ...]:
    """Ends [rad/s] of the speeds that no band forbids; what is narrower than the curves' own error is none."""
    wide = merged((low, high) for low, high in bands if high > low * (1.0 + MAP))
    return tuple(end for free in between(wide, project.speeds.limits, MAP) for end in free)


def differences(told: Iterable[tuple[str, Value]]) -> list[str]:
    """Where two faces say different things of one quantity, a sentence each."""
    by_quantity = defaultdict[str, list[Value]](list)
    for quantity, value in told:
        by_quantity[quantity].append(value)
    return [
        f"{quantity}: {one.face} says {one.value}, {other.face} says {other.value}"
        for quantity, values in by_quantity.items()
        for one, other in [(values[0], value) for value in values[1:]]
        if not same(one, other)
    ]


def same(one: Value, other: Value) -> bool:
    """Whether two values are equal within the sum of their errors; words and missing numbers are identical."""
    if not isinstance(one.value, tuple | float) or other.value is None:
        return bool(one.value == other.value)
    a, b = (np.atleast_1d(np.asarray(value.value, float)) for value in (one, other))
    error = one.error + other.error
    return len(a) == len(b) and bool(np.all(np.abs(a - b) <= error * np.maximum(np.abs(a), np.abs(b))))


def disagreements(texts: list[str], folder: Path) -> list[list[str]]:
    """Where the faces disagree on each of some drives."""
    paths = [folder / f"{i}.yaml" for i in range(len(texts))]
    for path, text in zip(paths, texts, strict=True):
        path.write_text(text, encoding="utf-8")
    why = {path: refused(path) for path in paths}
    moving = [path for path in paths if why[path] is None]
    rows = compared(moving, folder / "compared") if len(moving) > 1 else {}
    return [differences([*all_faces(path, folder / path.stem, why[path]), *rows.get(path, [])]) for path in paths]


def all_faces(path: Path, folder: Path, why: str | None) -> list[tuple[str, Value]]:
    """What every face says of a drive; of one without a steady motion `why`."""
    folder.mkdir()
    if why == NEUTRAL:
        return [("stable", Value(face, found)) for face, found in (("Python", False), *stable(path, folder))]
    if why is not None:
        return [("refusal", Value("Python", why)), ("refusal", Value("response", refusal("response", str(path))))]
    return [said for face in (responses, analyses, moves) for said in face(path, folder)]


def stable(path: Path, folder: Path) -> Iterator[tuple[str, bool]]:
    """Whether each face knows a stable motion of a drive that has none."""
    yield "response", NEUTRAL not in run("response", str(path))
    told = json.loads(run("analyze", str(path), "-o", str(folder / "report"), "--json"))["verdict"]
    yield "analyze", bool(told["allowed_speeds"]) or "no steady motion of the range is stable" not in told["headline"]
    yield "app", views.response(project_of(State(project=path.read_text())), True)["passes"] is not False
    yield "speed-map", "no stable steady motion" not in refusal("speed-map", str(path), "-o", str(folder / "map"))


def refusal(*words: str) -> str:
    """The sentence with which a command ends."""
    result = CliRunner().invoke(command.cli, list(words))
    assert result.exit_code == 1, result.output
    return result.stderr.splitlines()[-1].removeprefix("strainwave: ")


def refused(path: Path) -> str | None:
    """Why a drive has no response, or none that is stable."""
    try:
        return NEUTRAL if sw.read_project(path).response().sweep is None else None
    except sw.SolveError as error:
        return without_calls(str(error))
