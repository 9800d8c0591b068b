"""The torques and speeds of a speed map against the limits of its gear."""

import numpy as np

from ...model.gears.gear import Gear
from ...model.gears.limits import check_limits
from ...results import Floats
from ...units import RPM


def beyond_ratings(gear: Gear | None, speeds: Floats, loads: Floats, torque: Floats, unit: str) -> tuple[str, ...]:
    """Sentences about limits of a gear that cells pass: speeds (m,) [rad/s], loads (n,), torques (n, m) [N*m]."""
    if gear is None:
        return ()
    known = np.where(np.isfinite(torque), torque, 0.0)
    load, at = np.unravel_index(np.argmax(known), known.shape)
    findings = check_limits(gear, peak_torque=float(known[load, at]), max_speed=float(speeds[-1]))
    where = f" (at {speeds[at] / RPM:.5g} rpm under {loads[load]:.4g} {unit})"
    return tuple(
        finding.sentence + ("" if finding.unit == "rpm" else where) for finding in findings if finding.exceeded
    )
