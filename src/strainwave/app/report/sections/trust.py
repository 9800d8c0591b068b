"""What the numbers rest on: assumptions of the model, and how far each method was found to be off."""

from typing import Any

from ....base.sentences import listed
from ...view import View

MOTORS = {
    "held": "The motor turns at constant speed, as under an ideally stiff speed loop.",
    "free": "The motor is driven by its torque alone; no loop holds its speed.",
}


class Trust:
    """Assumptions in sentences, and a table of certificates."""

    heading = "Assumptions and certificates"

    def data(self, view: View) -> dict[str, Any]:
        """Assumptions of this model, and a row for each method with the difference that was found."""
        return {"assumptions": assumptions(view), "certificates": certificates(view)}


def assumptions(view: View) -> list[str]:
    """What the model takes for granted."""
    project = view.project
    said = []
    if view.analysis.train is None:
        said.append(MOTORS[project.motor])
    else:
        said.append("The motor has the loop and the friction that the file gives; a loop is computed without sampling.")
    if project.gear is not None:
        said.append(
            f"The stiffness is that of the datasheet of {project.gear.name}: a typical value; a single gear differs."
        )
    else:
        said.append("The torsion law is the one that the file writes out.")
    said += [
        "The gear is a spring and a damper without mass between motor and load; its parts count to either inertia.",
        "The kinematic error depends on the angle alone: load, temperature and wear do not change it.",
        "Shafts and housing are rigid, but for the couplings of the file.",
        "The teeth do not skip; a torque above the ratcheting torque is no result.",
    ]
    if project.left_out:
        said.append(
            f"The error equation of closed forms and proofs leaves out {listed(project.left_out)}; "
            "the steady motions of the whole drive have them."
        )
    return said


def certificates(view: View) -> list[dict[str, Any]]:
    """A row for each method: what it gave, what it was held against, and the relative difference."""
    exact, rows = view.analysis.exact, []
    orders = exact.curve.coefficients.shape[1] // 2
    against = "share of the motion in the harmonics that are left out"
    rows.append(_row(f"response curve, {orders} harmonics", against, exact.curve.tail))
    off = view.analysis.run_up.difference()
    if off is not None:
        rows.append(_row("response curve", "largest |x| of motions by integration, up and down through the range", off))
    for regime in view.analysis.regimes:
        used = regime.at_peak or regime.certificate
        if used is None or not regime.inside:
            continue
        what = f"multiple scales, order {used.order}, {regime.name} resonance of order {regime.order}"
        against = "its certificate" if used.valid else "its certificate: not valid, rely on the response curve"
        rows.append(_row(what, against, used.amplitude))
    return rows


def _row(what: str, against: str, difference: float | None) -> dict[str, Any]:
    return {"what": what, "held_against": against, "relative_difference": difference}
