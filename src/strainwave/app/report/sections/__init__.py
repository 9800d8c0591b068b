"""The sections of the report, a file each, with its part of the page beside it."""

from ..section import Section
from .advice import SpeedsToAvoid
from .compensation import Compensation
from .derived import DerivedQuantities
from .hysteresis import Hysteresis
from .motors import Motors
from .opening import Opening
from .parametric import ParametricResonances
from .resonances import Resonances
from .single_speeds import SingleSpeeds
from .speed_range import SpeedRange
from .stability import Stability
from .warnings import Warnings
from .whole_train import WholeTrain

SECTIONS: tuple[Section, ...] = (
    Opening(),
    Warnings(),
    Motors(),
    SpeedsToAvoid(),
    SpeedRange(),
    WholeTrain(),
    Compensation(),
    Hysteresis(),
    ParametricResonances(),
    Resonances(),
    SingleSpeeds(),
    Stability(),
    DerivedQuantities(),
)
