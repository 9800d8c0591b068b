"""Questions of an engineer, answered by theory and numerics side by side."""

from ..drive.friction.standstill import standstill as standstill
from ..drive.operating_point import operating_state as operating_state
from ..drive.postures import Link as Link
from ..drive.postures import two_link as two_link
from ..drive.two_turns import two_turn_motion as two_turn_motion
from ..drive.two_turns import two_turn_response as two_turn_response
from ..theory.parametric import parametric_resonances as parametric_resonances
from .analysis.hardening import hardening as hardening
from .analysis.time_domain.comparison import compare_with_integration as compare_with_integration
from .compensation.compensate import compensation_bench as compensation_bench
from .compensation.designs import COMPENSATORS as COMPENSATORS
from .compensation.designs import Compensator as Compensator
from .compensation.prediction import speed_table as speed_table
from .gear.energy import efficiency as efficiency
from .gear.energy import energy_balance as energy_balance
from .gear.error_parts import error_parts as error_parts
from .gear.hysteresis_loop import lost_motion as lost_motion
from .move.profiles import Dwell as Dwell

__all__: list[str]
