"""Computing with any system that has `rhs(phase, y)` and `omega`; no model is imported here."""

from .curves.backbone import backbone as backbone
from .curves.parameter_response import parameter_response as parameter_response
from .curves.response import response_family as response_family
from .curves.switching import switch_branch as switch_branch
from .ensemble.linear_loops import loop_response as loop_response
from .ensemble.loops import loop_ensemble as loop_ensemble
from .ensemble.loops import run_loop as run_loop
from .ensemble.measures import Amplitude as Amplitude
from .ensemble.measures import Extremes as Extremes
from .ensemble.measures import Final as Final
from .ensemble.measures import Mean as Mean
from .ensemble.measures import Peak as Peak
from .ensemble.measures import Rms as Rms
from .shooting import shoot as shoot

__all__: list[str]
