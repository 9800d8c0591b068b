"""The sections of the report."""

from typing import Any

from .basis import provenance, stability, trust
from .cautions import cautions
from .controllers import compensation
from .derived import derived_quantities
from .gear_torsion import hysteresis, parametric_resonances
from .opening import opening
from .remedies import remedies
from .resonances import resonances
from .single_speeds import single_speeds
from .speed_range import beat_of_turns, speed_range
from .speeds_to_avoid import speeds_to_avoid
from .variants import motors, postures
from .whole_train import run_up_of_train, whole_train

SECTIONS: tuple[Any, ...] = (
    opening, cautions, motors, speeds_to_avoid, postures, remedies, speed_range, beat_of_turns, whole_train,
    compensation, hysteresis, parametric_resonances, derived_quantities, trust, provenance, run_up_of_train, resonances,
    single_speeds, stability,
)  # fmt: skip
