"""Basis of the numbers: assumptions, the observed error of each method, the proof of stability, and the origin."""

import platform
from hashlib import sha256
from importlib.metadata import version
from shlex import quote
from typing import Any

from .... import __version__
from ....base.facts import Fact, data
from ....base.sentences import listed, printable
from ....files.notes import source_facts
from ...view import View

SOFTWARE = ("numpy", "scipy", "numba")
MOTORS = {
    "held": "The motor turns at constant speed, as under an ideally stiff speed loop.",
    "free": "The motor is driven by its torque alone; no loop holds its speed.",
}


class Trust:
    """Assumptions in sentences, and a table of certificates."""

    heading = "Assumptions and certificates"

    def data(self, view: View) -> dict[str, Any]:
        """Assumptions of this model, and a row for each method with its observed difference."""
        return {"assumptions": assumptions(view), "certificates": certificates(view)}


def assumptions(view: View) -> list[str]:
    """Assumptions of the model in sentences."""
    project = view.project
    texts = []
    if view.analysis.train is None:
        texts.append(MOTORS[project.motor])
    else:
        texts.append(
            "The motor has the loop and the friction that the file gives; a loop is computed without sampling."
        )
    if project.gear is not None:
        texts.append(
            f"The stiffness is that of the datasheet of {project.gear.name}: a typical value; a single gear differs."
        )
    else:
        texts.append("The torsion law is the one that the file writes out.")
    texts += [
        "The gear is a spring and a damper without mass between motor and load; its parts count to either inertia.",
        "The kinematic error depends on the angle alone: load, temperature and wear do not change it.",
        "Shafts and housing are rigid, but for the couplings of the file.",
        "Skipping teeth are not computed: results above the ratcheting torque are void.",
    ]
    if project.left_out:
        texts.append(
            f"The error equation of closed forms and proofs leaves out {listed(project.left_out)}; "
            "the steady motions of the whole drive have them."
        )
    return texts


def certificates(view: View) -> list[dict[str, Any]]:
    """A row for each method: its result, its reference, and the relative difference."""
    equation, rows = "" if view.analysis.train_curve is None else " of the error equation", []
    for name, curve in {"": view.analysis.response.curve, equation: view.analysis.exact.curve}.items():
        size = f"{curve.coefficients.shape[1] // 2} harmonics"
        reference = "share of the motion in the harmonics that are left out"
        if (waves := curve.waves) is not None:
            size, reference = (
                f"{len(waves.pairs) - 1} waves",
                "share of the motion in each wave that is left out, at most",
            )
        rows.append(_row(f"response curve{name}, {size}", reference, curve.tail))
    if (beat := view.analysis.beat) is not None and beat.difference is not None:
        reference = "largest |error - mean| of each turn by integration, at the largest oscillation"
        rows.append(_row("motion that beats", reference, beat.difference))
    difference = view.analysis.run_up.difference()
    if difference is not None:
        reference = "largest |x| of motions by integration, up and down through the range"
        rows.append(_row(f"response curve{equation}", reference, difference))
    for regime in view.analysis.regimes:
        certificate = regime.at_peak or regime.certificate
        if certificate is None or not regime.inside:
            continue
        method = f"multiple scales, order {certificate.order}, {regime.name} resonance of order {regime.order}"
        reference = "its certificate" if certificate.valid else "its certificate: not valid, rely on the response curve"
        rows.append(_row(method, reference, certificate.amplitude))
    return rows


def _row(method: str, reference: str, difference: float | None) -> dict[str, Any]:
    return {"what": method, "held_against": reference, "relative_difference": difference}


class Stability:
    """The proof that the error decays, or the reason without one."""

    heading = "Stability without excitation"
    template = "stability.html.j2"
    appendix = True

    def data(self, view: View) -> dict[str, Any]:
        """Scope, claim and region of the proof."""
        proof = view.analysis.stability
        said = {name: getattr(proof, name) for name in ("holds", "scope", "claim", "reason", "obstacle")}
        return {"stability": said | {"region": str(proof.region or "none")}}

    def lines(self, view: View, data: dict[str, Any]) -> list[str]:
        """The proof in a line: its claim, or the reason without one; of the drive alone, not of its error equation."""
        proof = data["stability"]
        claim = f"no proof: {proof['obstacle']}" if proof["scope"] == "none" else f"{proof['scope']}; {proof['claim']}"
        return [f"stability: {claim}"] if view.analysis.train_curve is None else []


class Provenance:
    """Source of each number, the whole project file, the SHA-256 of its text (UTF-8), versions, and the command."""

    heading = "Project and provenance"
    template = "provenance.html.j2"
    appendix = True

    def data(self, view: View) -> dict[str, Any]:
        """Hash, versions and command."""
        path = view.project.path
        versions = {"strainwave": __version__, "python": platform.python_version()}
        return {
            "sources": data([Fact("rows", source_facts(view.project))])["rows"],
            "provenance": {
                "project_sha256": sha256(view.project.text.encode()).hexdigest(),
                "versions": versions | {name: version(name) for name in SOFTWARE},
                "command": f"strainwave analyze {_word(path.name)} -o {_word(path.stem)}",
            },
        }


def _word(name: str) -> str:
    """A file name as one word of a shell, which no command takes for an option."""
    return quote(printable(f"./{name}" if name.startswith("-") else name))
