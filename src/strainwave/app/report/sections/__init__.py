"""The sections of the report, each with its part of the page beside its file."""

from ..section import Section
from .advice import Compensation, SpeedsToAvoid
from .derived import DerivedQuantities, Hysteresis, ParametricResonances, Provenance, Stability, Trust
from .opening import Opening, Warnings
from .resonances import Resonances
from .speed_range import BeatOfTurns, SingleSpeeds, SpeedRange
from .whole_train import Motors, RunUpOfTrain, WholeTrain

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
