"""Basis of the numbers: assumptions, the observed error of each method, the proof of stability, and the origin."""

import platform
from hashlib import sha256
from html import escape
from importlib import metadata
from shlex import quote
from typing import Any

from ....base.archive import version
from ....base.facts import Fact, data
from ....base.sentences import listed
from ....base.terminal import printable
from ....files.sources import source_facts
from ....plot.portrait import proof_panels
from ....plot.svg import figure
from ...view import View
from ..section import Part, Table

SOFTWARE = ("numpy", "scipy", "numba")
MOTORS = {
    "held": "The motor turns at constant speed, as under an ideally stiff speed loop.",
    "free": "The motor is driven by its torque alone, without a control loop.",
    "train": "The motor has the control loop and friction of the project file; the loop is computed as continuous.",
}


def trust(view: View) -> Part:
    """Assumptions of this model, and a row for each method with its observed difference."""
    data = {"assumptions": assumptions(view), "certificates": certificates(view)}
    return Part("Assumptions and certificates", data, tables=[*map(Table, data.values())], appendix=True)


def assumptions(view: View) -> list[str]:
    """Assumptions of the model in sentences."""
    project, gear = view.project, view.project.gear
    texts = [
        MOTORS["train" if view.analysis.train is not None else project.motor],
        "The torsion law is the one written in the project file."
        if gear is None
        else f"The stiffness is the typical datasheet value of {gear.name}; an individual gear differs.",
        "The gear is a massless spring and damper between motor and load; its mass is part of their inertias.",
        "The kinematic error depends on the angle alone, not on load, temperature or wear.",
        "Shafts and housing are rigid, except for the couplings in the project file.",
        "Ratcheting (skipping teeth) is not computed: results above the ratcheting torque are invalid.",
    ]
    reduced = f"The error equation, for closed forms and proofs, neglects {listed(project.left_out)}; "
    return texts + [reduced + "the steady motions of the whole drive include this."] * bool(project.left_out)


def certificates(view: View) -> list[dict[str, Any]]:
    """A row for each method: its result, its reference, and the relative difference."""
    equation, rows = "" if view.analysis.train_curve is None else " of the error equation", []
    # without a train both names are empty, and one row is left
    for name, curve in {"": view.analysis.drive.curve, equation: view.analysis.exact.curve}.items():
        size = f"{curve.coefficients.shape[1] // 2} harmonics"
        reference = "share of the motion in the omitted harmonics"
        if (waves := curve.waves) is not None:
            size = f"{len(waves.pairs) - 1} waves"
            reference = "largest share of the motion in one omitted wave"
        rows.append(_certificate(f"response curve{name}, {size}", reference, curve.tail))
    if (beat := view.analysis.beat) is not None and beat.difference is not None:
        reference = "largest |error - mean| of each turn by time integration, at the largest oscillation"
        rows.append(_certificate("beating motion", reference, beat.difference))
    difference = view.analysis.run_up.difference()
    if difference is not None:
        reference = "largest |x| by time integration of a run-up and a run-down"
        rows.append(_certificate(f"response curve{equation}", reference, difference))
    for regime in view.analysis.regimes:
        certificate = regime.at_peak or regime.certificate
        if certificate is None or not regime.inside:
            continue
        method = f"multiple scales of order {certificate.order}, {regime.name} resonance of error order {regime.order}"
        reference = "error estimate" + (": not valid, use the response curve" if not certificate.valid else "")
        rows.append(_certificate(method, reference, certificate.amplitude))
    return rows


def _certificate(method: str, reference: str, difference: float | None) -> dict[str, Any]:
    return {"what": method, "held_against": reference, "relative_difference": difference}


SCOPES = {
    "global": "Globally stable", "local": "Locally stable", "set": "Converges to the gap", "none": "No claim",
}  # fmt: skip


def stability(view: View) -> Part:
    """The proof that the error decays, with the phase portrait, or the reason without one."""
    proof = view.analysis.stability
    facts = {name: getattr(proof, name) for name in ("holds", "scope", "claim", "reason", "obstacle")}
    claim = SCOPES[proof.scope] + (": " + proof.claim if proof.scope != "none" else "") + "."
    region, panels = str(proof.region or "none"), proof_panels(proof)
    drawn = [figure([panels], 400.0, "phase portrait without excitation")] if panels else []
    return Part(
        "Stability without excitation", {"stability": facts | {"region": region}}, [claim],
        notes=[f"Stability region: {region}. Reason: " + proof.reason + "."], figures=drawn, appendix=True,
    )  # fmt: skip


def provenance(view: View) -> Part:
    """Source of each number, the whole project file, the SHA-256 of its text (UTF-8), versions, and the command."""
    path, text = view.project.path, view.project.text
    versions = {"strainwave": version(), "python": platform.python_version()}
    made = {
        "project_sha256": sha256(text.encode()).hexdigest(),
        "versions": versions | {name: metadata.version(name) for name in SOFTWARE},
        "command": f"strainwave analyze {_word(path.name)} -o {_word(path.stem)}",
    }
    parts = {"sources": data([Fact("rows", source_facts(view.project))])["rows"], "provenance": made}
    file = f"<pre>{escape(text)}</pre>", "Same project file, versions and machine: the command writes identical files."
    tables = [*map(Table, parts.values())]
    return Part("Project and provenance", parts, tables=tables, figures=[file], appendix=True)


def _word(name: str) -> str:
    """A file name as one word of a shell, which no command takes for an option."""
    return quote(printable(f"./{name}" if name.startswith("-") else name))
