"""The torsion of a gear from the angles of its two shafts."""

from collections.abc import Mapping
from typing import Any

import numpy as np

LARGEST = 0.5  # of the load's turn, and
NO_MORE = 0.02  # rad: what a gear may twist


def with_torsion(channels: Mapping[str, Any], N: float) -> dict[str, Any]:
    """Channels with the torsion theta_m/N - theta_l [rad]; a load that turns against the motor is counted with it.

    Raises
    ------
    ValueError
        If an angle is missing, or the angles are not those of a gear of this ratio.
    """
    for name in ("motor_angle", "load_angle"):
        if name not in channels:
            raise ValueError(f"log has no channel {name!r}; it has {', '.join(channels)}: name the column of it")
    motor, load = (np.asarray(channels[name], float) for name in ("motor_angle", "load_angle"))
    if motor.shape != load.shape:
        raise ValueError(f"log: motor_angle has {len(motor)} samples and load_angle {len(load)}; give equally many")
    known = np.isfinite(motor) & np.isfinite(load)
    if np.count_nonzero(known) < 2:
        raise ValueError("log: motor_angle and load_angle have no two samples in common; give both at the same times")
    sense = -1.0 if np.cov(motor[known], load[known])[0, 1] < 0.0 else 1.0
    torsion = motor / N - sense * load
    turned, twisted = float(np.ptp(load[known])), float(np.ptp(torsion[known]))
    if twisted > max(LARGEST * turned, NO_MORE):
        raise ValueError(
            f"log: motor_angle turns {np.ptp(motor[known]):.4g} rad and load_angle {turned:.4g} rad, which is no gear "
            f"of ratio {N:g}; give both on their own shafts"
        )
    return {**channels, "torsion": torsion}
