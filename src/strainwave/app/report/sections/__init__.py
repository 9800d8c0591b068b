"""The sections of the report, a file each, with its part of the page beside it."""

from ..section import Section
from .advice import SpeedsToAvoid
from .compensation import Compensation
from .derived import DerivedQuantities
from .hysteresis import Hysteresis
from .motors import Motors
from .opening import Opening
from .parametric import ParametricResonances
from .provenance import Provenance
from .resonances import Resonances
from .single_speeds import BeatOfTurns, SingleSpeeds
from .speed_range import SpeedRange
from .stability import Stability
from .trust import Trust
from .warnings import Warnings
from .whole_train import RunUpOfTrain, WholeTrain

SECTIONS: tuple[Section, ...] = (
    Opening(),
    Warnings(),
    Motors(),
    SpeedsToAvoid(),
    SpeedRange(),
    BeatOfTurns(),
    WholeTrain(),
    Compensation(),
    Hysteresis(),
    ParametricResonances(),
    DerivedQuantities(),
    Trust(),
    Provenance(),
    RunUpOfTrain(),
    Resonances(),
    SingleSpeeds(),
    Stability(),
)
