"""The sections of the report."""

from typing import Any

from .advice import compensation, postures, remedies, speeds_to_avoid
from .basis import provenance, stability, trust
from .derived import derived_quantities, hysteresis, parametric_resonances
from .opening import cautions, opening
from .resonances import resonances
from .speed_range import beat_of_turns, single_speeds, speed_range
from .whole_train import motors, run_up_of_train, whole_train

SECTIONS: tuple[Any, ...] = (
    opening, cautions, motors, speeds_to_avoid, postures, remedies, speed_range, beat_of_turns, whole_train,
    compensation, hysteresis, parametric_resonances, derived_quantities, trust, provenance, run_up_of_train, resonances,
    single_speeds, stability,
)  # fmt: skip
