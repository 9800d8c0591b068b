"""Allowed speeds of a project by every face that tells them, and projects at random."""

import json
import re
from pathlib import Path

import numpy as np
from click.testing import CliRunner
from random_projects import drive_at_random

import strainwave as sw
from strainwave.app.commands import cli as command
from strainwave.base.units import RPM
from strainwave.study.speed_map.decide import decide
from strainwave.study.speed_map.rules import rules_of

POSTURES = "postures: [{{inertia: {0:.4g} kg*m^2}}, {{name: out, inertia: {1:.4g} kg*m^2, torque: -{2:.4g} N*m}}]\n"
LOOP = "loop: {type: cascade, bandwidth: 20 Hz, damping: 0.8}"
SAMPLED = "controller: {period: 250 us, delay: 250 us}\n"


def told(path: Path, folder: Path) -> dict[str, list[float]]:
    """Ends [rpm] of the allowed speeds by face; a drive that nothing is known of has none."""
    project = sw.read_project(path)
    decided = decide(project, rules_of(None, None, None, project.limit))
    rows = {"API": np.ravel(decided.allowed) / RPM}
    result = CliRunner().invoke(command.cli, ["speed-map", str(path), "--json"])
    if not any(found.curves for found in decided.by_load):
        assert result.exit_code == 1, result.output
    else:
        assert result.exit_code == 0, result.output
        rows["speed-map"] = np.ravel(json.loads(result.stdout)["allowed_under_every_load_rpm"])
    result = CliRunner().invoke(command.cli, ["analyze", str(path), "-o", str(folder), "--json"])
    assert result.exit_code == 0, result.output
    written = json.loads((folder / "results.json").read_text(encoding="utf-8"))
    for face, verdict in (("analyze", json.loads(result.stdout)["verdict"]), ("report", written["verdict"])):
        rows[face] = [band[end] for band in verdict["allowed_speeds"] for end in ("from_rpm", "to_rpm")]
    said = written["verdict"]["answers"].get("without a change", "")
    if digits := re.findall(r"[\d.]+", said.removesuffix(".")):
        np.testing.assert_allclose(np.array(digits, float), rows["report"], rtol=2e-3)
    return {face: list(map(float, row)) for face, row in rows.items()}


def project_at_random(rng: np.random.Generator) -> str:
    """A project of any parts; some of them have postures, a cascade, samples or a weak motor."""
    text = drive_at_random(rng)
    J = float(re.search(r"load: \{inertia: ([\d.e+-]+)", text).group(1))
    if rng.random() < 0.2 and "backlash" not in text:
        text += POSTURES.format(J * rng.uniform(0.5, 0.9), J * rng.uniform(1.1, 1.6), 2.0 * J)
    if rng.random() < 0.3:
        text = text.replace("mode: held", LOOP)
        text += SAMPLED if LOOP in text and rng.random() < 0.5 else ""
    return text
