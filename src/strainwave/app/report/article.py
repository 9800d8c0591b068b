"""Reproduction of the source article: its Tables 3 and 4 as printed, corrected and integrated; page, CSV, figures."""

import math
from collections.abc import Sequence
from functools import partial
from html import escape
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...base.results import Floats
from ...model.drive import HDC_40_050
from ...plot.curves import LIGHT, slow_response_panels
from ...plot.panels import BLACK, BLUE, DASHES, ORANGE, TIME, Axis, Note, Panel
from ...plot.portrait import proof_panels
from ...plot.svg import figure
from ...theory import article
from ...theory.article import FORMS
from ...theory.lyapunov import lyapunov
from ...theory.resonance import PRIMARY, SUBHARMONIC, SUPERHARMONIC
from ...theory.slow_flow.flow import SlowFlow
from ...theory.slow_flow.results import SlowResponse
from ..console import as_csv, columns, number, slug
from .page import plain_page
from .section import html_table
from .sections.single_speeds import overlaid

EVERY = 4  # sample of a motion in its file, 16 per cycle of the fastest component
SETS = {
    "derived": "mu and omega_0 derived from Table 3, alpha = 0.1",
    "alpha 1": "mu and omega_0 derived from Table 3, alpha = 1 as in the printed formulas (E2)",
    "printed": "printed mu = 0.129 1/s and omega_0 = 37.2 rad/s, alpha = 0.1",
}
CORRECTED, AS_PRINTED = ", multiple scales", article.AS_PRINTED
TABLE_3 = ("mu", "omega_0", "omega_0 as a frequency", "A", "static error")
TABLE_4 = (  # name of a row, of its quantity, and the ends of that: as printed, corrected, integration, second order
    ("largest |x| from rest", "largest |x|", AS_PRINTED, CORRECTED, ", integration", f"{CORRECTED} of second order"),
    ("largest |x|, steady", "steady peak", AS_PRINTED, CORRECTED, "", None),
    ("RMS difference", "normalised RMS difference", AS_PRINTED, "", None, ", second order"),
    ("component at {}", "steady amplitude at {}", AS_PRINTED, CORRECTED, "", None),  # that near omega_0, of a resonance
)
KEYS = (
    "case", "quantity", "unit", "printed", "formula_as_printed", "formula_corrected", "integration", "second_order",
    "reproduced_by", "why",
)  # fmt: skip
FORM_HEADS = ("part of the article", "formula", "as printed", "correct", "erratum")
CYCLES, LATE = 6.0, 0.2  # of the close view: free cycles, and its begin as a share
SIGMA = {PRIMARY: "σ = ω − ω₀", SUPERHARMONIC: "σ = 3ω − ω₀", SUBHARMONIC: "σ = ω − 3ω₀"}
X, A = Axis("x", "mrad", 1e-3), Axis("amplitude a", "mrad", 1e-3)
TITLE = "The article's Tables 3 and 4, recomputed"
Row = dict[str, Any]


def header() -> tuple[str, ...]:
    """Sentences on what is computed, from which start, over which window, and by which method."""
    mu, omega_0 = HDC_40_050.mu, HDC_40_050.omega_0
    return (
        f"Drive: HDC-40-050, Table 3 of the article, {article.MOTOR_TORQUE:g} N*m cos(omega t) at the motor.",
        f"Derived from Table 3: mu = {mu:.6g} 1/s, omega_0 = {omega_0:.6g} rad/s, A = {article.AMPLITUDE:.6g} rad/s^2.",
        f"Printed in the article: mu = {article.PRINTED_MU} 1/s, omega_0 = {article.PRINTED_OMEGA_0} rad/s.",
        "Initial state: at rest, x = x' = 0.",
        f"Time window: 0 to {article.LONG:g}/mu for the largest |x|, 0 to {article.SHORT:g}/mu for the RMS difference "
        "(relative to the RMS of x).",
        "Method: Runge-Kutta 5(4) of Dormand and Prince, tolerance 1e-9, and shooting; first-order multiple scales.",
        "Formula as printed: without alpha (E2), constant beta_0 in case 1 (E10), swapped coefficients in case 4 (E6).",
        "Printed: numerical / analytical value of the article, which does not tell whether it is from rest or steady.",
    )


def tables(result: article.Reproduction) -> dict[str, list[Row]]:
    """Rows of both tables by their titles, of Table 4 for each set of parameters; their keys are KEYS."""
    cells = {(cell.parameters, cell.case, cell.quantity): cell for cell in result.cells}
    by_title = {"Table 3": [_row(cells, "derived", "", name, name, "", "", None, None) for name in TABLE_3]}
    for parameters, meaning in SETS.items():
        by_title[f"Table 4: {meaning}"] = [
            _row(cells, parameters, case.name, name.format(multiple), base.format(multiple), *ends)
            for case, multiple in zip(article.CASES, article.NEAR, strict=True)
            for name, base, *ends in (TABLE_4 if multiple else TABLE_4[:-1])
        ]
    return by_title


def _row(cells: dict[Any, article.Cell], parameters: str, case: str, name: str, base: str, *ends: str | None) -> Row:
    """One row from its cells: as printed, corrected, by integration, of second order."""
    row = [None if end is None else cells.get((parameters, case, base + end)) for end in ends]
    printed = [number(cell.printed) for cell in (row[2], row[1]) if cell and cell.printed is not None]
    agree = [name for name, cell in zip(KEYS[4:7], row, strict=False) if cell and cell.verdict == "reproduced"]
    best = next(cell for cell in row[2::-1] if cell)
    speed = cells.get((parameters, case, "omega"))
    values = [cell.value if cell else None for cell in row]
    verdict = ", ".join(agree).replace("_", " ") or ("none" if printed else None)
    where, both = f"{case} {number(speed.value)} rad/s" if speed else "", " / ".join(dict.fromkeys(printed)) or None
    return dict(zip(KEYS, (where, name, best.unit, both, *values, verdict, best.why), strict=True))


def shown(rows: Sequence[Row], second_order: bool) -> list[list[Any]]:
    """Heads and cells of a table, a case named once, with or without the second order."""
    keys = [key for key in KEYS[3:-1] if second_order or key != "second_order"]
    table = [["case", "quantity", *(key.replace("_", " ") for key in keys)]]
    for before, row in pairwise([{"case": ""}, *rows]):
        case = row["case"] if row["case"] != before["case"] else ""
        table.append([case, f"{row['quantity']} ({row['unit']})", *(row[key] for key in keys)])
    return table


def reasons(by_title: dict[str, list[Row]]) -> list[str]:
    """Sentences on printed numbers that are met or not, each once."""
    return list(dict.fromkeys(row["why"] for rows in by_title.values() for row in rows))


def regimes(runs: Sequence[article.Run]) -> list[list[Panel]]:
    """A row for each regime: the decay of the free vibration from rest, and a close view of some of its cycles."""
    rows = []
    for case, system, t, exact, theory, rms in runs:
        omega_0, end = math.sqrt(system.law.K / system.J), float(t[-1])
        title = f"{case.name}, ω = {number(system.omega)} rad/s: RMS difference {number(rms, 2)} %"
        decay, close = Panel(title, TIME, X), Panel("a close view", TIME, X)
        overlaid(decay, (t, exact), (t, theory), int(end * omega_0))
        first, last = np.searchsorted(t, [LATE * end, LATE * end + CYCLES * 2.0 * math.pi / omega_0])
        part = slice(int(first), int(last))
        close.line(t[part], exact[part], LIGHT, "integration", width=4.0)
        close.line(t[part], theory[part], ORANGE, "multiple scales", DASHES, 1.3)
        decay.xlim, close.xlim = (0.0, end), (float(t[first]), float(t[last]))
        rows.append([decay, close])
    return rows


def detuning(flow: SlowFlow, omega: ArrayLike) -> Floats:
    """Detuning sigma = p omega - q omega_0 [rad/s] of frequencies [rad/s]."""
    return flow.resonance.p * np.asarray(omega) - flow.resonance.q * flow.omega_0


def responses(curves: Sequence[tuple[SlowFlow, SlowResponse]]) -> list[list[Panel]]:
    """The forced amplitude C over the frequency, and the amplitudes a of the three resonances over sigma."""
    omega_0 = curves[0][0].omega_0

    def forced(omega: Floats) -> Floats:
        return np.abs(article.AMPLITUDE / (omega_0**2 - omega**2))

    panel = Panel("no resonance: C = A/(ω₀² − ω²)", Axis("forcing frequency ω", "rad/s"), Axis("|C|", "mrad", 1e-3))
    panel.log, panel.xlog, panel.xlim, panel.ylim = True, True, (3.0, 1800.0), (5e-5, 1.0)
    omega, marks = np.geomspace(0.01 * omega_0, 4.0 * omega_0, 800), np.array([10.47, omega_0 / 3.0, 3.0 * omega_0])
    panel.line(omega, forced(omega), BLUE, width=2.0)
    panel.points(marks, forced(marks), BLACK, "frequencies of Table 4", "o", BLACK)
    names = ("10.47 rad/s", "ω₀/3", "3ω₀")
    panel.notes = [Note(x, float(forced(x)), name) for x, name in zip(marks, names, strict=True)]
    panels = [panel, *(_over_sigma(*curve) for curve in curves)]
    return [panels[:2], panels[2:]]


def _over_sigma(flow: SlowFlow, response: SlowResponse) -> Panel:
    """States of one resonance over sigma: stable and unstable, a = 0, and where a pair of them begins."""
    (panel,) = slow_response_panels(response, partial(detuning, flow))
    times = flow.system.excitation.amplitude / flow.system.J / article.AMPLITUDE
    panel.title = f"{flow.resonance}, T_m = {number(times * article.MOTOR_TORQUE)} N·m"
    panel.x, panel.y, panel.ylim = Axis(f"detuning {SIGMA[flow.resonance]}", "rad/s"), A, (None, 1.1 * response.peak[1])
    folds = zip(detuning(flow, response.folds), response.fold_amplitudes, strict=True)
    panel.notes = [Note(x, y, f"σ = {number(x)}") for x, y in folds]
    return panel


def files(result: article.Reproduction, second_order: bool) -> dict[str, Any]:
    """Contents of the folder by file names: the page, its figures as SVG, tables and curves as CSV."""
    titled, responded, proof = tables(result), article.curves(), lyapunov(article.derived_system())
    existence = ". ".join(f"{flow.resonance}: {flow.existence}" for flow, _ in responded)
    contents: dict[str, Any] = {}
    body = [f"<p>{escape(line)}</p>" for line in (*header(), f"Rule: {result.rule}.")]
    for (title, rows), name in zip(titled.items(), ("table-3", *(f"table-4-{slug(key)}" for key in SETS)), strict=True):
        contents[f"{name}.csv"] = as_csv(list(KEYS), [row.values() for row in rows])
        heads, *cells = shown(rows, second_order)
        body.append(f"<h2>{escape(title)}</h2>{html_table(heads, cells)}")
    body += [f'<p class="note">{escape(why[0].upper() + why[1:])}.</p>' for why in reasons(titled)]
    body.append(f"<h2>Formulas</h2>{html_table(FORM_HEADS, FORMS)}")
    for name, title, panels, height, note in (
        ("regimes", "Runge-Kutta and multiple scales", regimes(result.runs), 205.0, "From rest to 5/mu"),
        ("responses", "Responses over the detuning", responses(responded), 260.0, existence),
        ("phase-portrait", "Phase portrait", [proof_panels(proof)], 420.0, proof.claim),
    ):
        contents[f"{name}.svg"] = svg = figure(panels, height, title)
        body.append(f"<h2>{title}</h2><figure>{svg}<figcaption>{escape(note)}.</figcaption></figure>")
    for run in result.runs:
        motions = {"t_s": run.t, "x_integration_rad": run.integration, "x_multiple_scales_rad": run.multiple_scales}
        contents[f"regime-{run.case.name}.csv"] = [(key, values[::EVERY]) for key, values in motions.items()]
    for flow, response in responded:
        coordinates = response.coordinates()
        arrays = columns(coordinates, response.variables())
        name = f"response-{slug(str(flow.resonance))}.csv"
        contents[name] = [("sigma_rad_per_s", detuning(flow, coordinates["omega"][1])), *arrays]
    return {"article.html": plain_page(TITLE, "\n".join(body)), **contents}
