"""The derivation for a project: its reduction to the error equation in numbers; and the page of a derivation."""

from collections.abc import Sequence
from html import escape

import numpy as np

from ...base.facts import Fact, lines
from ...base.protocols import orders_of
from ...base.sentences import listed
from ...drive.project import Project
from ...theory.derivation.error_equation import Derivation
from ...theory.derivation.steps import Steps
from ...theory.slow_flow.setting import forcing_lines
from .page import plain_page

OF_RATIO = ("the motor's answer to the changing ratio", "the ripple of the motor's speed")
CASES = (
    "cases 1 to 4 hold for a cubic law, constant stiffness and damping, one excitation order and no mean torque; "
    "strainwave analyze covers every law and all orders"
)
STYLE = "tr > * { vertical-align: middle; } th { white-space: nowrap; } math { font-size: 1.1em; math-style: normal; }"


def reduction(project: Project) -> tuple[Fact, ...]:
    """The error equation of a project in numbers, at its middle speed, and what that leaves out of the drive."""
    system, drive = project.system(reduced=True), project.drive
    left = project.left_out + (OF_RATIO if project.motor == "free" and project.kinematic_error else ())
    motor = "an ideally held motor" if project.motor == "held" else "a motor that follows its torque"
    once = not any(order % 1 for order in orders_of(system))
    mean, orders, torque, error = forcing_lines(system) if once else (0.0, (), np.zeros(0), 0.0)
    sizes = np.abs(torque / system.J + (np.array(orders) * system.omega) ** 2 * error)
    amplitudes = zip(orders, sizes.tolist(), strict=True)
    rows = tuple((Fact("order", k, "order"), Fact("A_rad_per_s2", size, "A")) for k, size in amplitudes)
    return (
        Fact("subject", "the error equation" if project.whole is None else "the whole drive train", "subject: {}"),
        Fact("", motor, "the error equation includes {}, the gear and a rigid load"),
        Fact("left_out", left),
        Fact("", listed(left) or "nothing", "neglected in the error equation: {}"),
        Fact("J_kg_m2", project.J, "J = {}"), Fact("mu", drive.B / project.J, "mu = {} 1/s"),
        Fact("omega_0_rad_per_s", project.omega_0, "omega_0 = {} at rest"), Fact("law", repr(drive.law), "law: {}"),
        Fact("mean_N_m", mean, "mean torque {}"),
        Fact("omega_rad_per_s", float(system.omega), f"{'' if rows else 'no '}lines of the forcing at omega = {{}}"),
        Fact("lines", rows, "{}" if rows else ""),
        Fact("", CASES, "{}"),
    )  # fmt: skip


def derivation_page(steps: Derivation, title: str, facts: Sequence[Fact]) -> str:
    """Write the HTML page of a derivation, its formulas in MathML and as LaTeX to be copied."""
    equation = f"<pre>{escape(chr(10).join(lines(facts)))}</pre>" if facts else ""
    return plain_page(title, equation + "".join(map(_section, steps.parts)), STYLE)


def _section(part: Steps) -> str:
    row = "<tr><th>{}</th><td><math>{}</math></td></tr>"
    rows = "\n".join(row.format(escape(name), formula) for name, formula in part.mathml())
    return (
        f'<h2>{escape(part.title)}</h2>\n<div class="scroll"><table><tbody>\n{rows}\n</tbody></table></div>\n'
        f"<details><summary>LaTeX</summary><pre>{escape(part.aligned())}</pre></details>\n"
    )
