"""Sampled controllers of the motor, what they measure, and the loop that they close around a drive train."""

from .adaptive import AdaptiveCancellation as AdaptiveCancellation
from .closed_loop import ClosedLoop as ClosedLoop
from .closed_loop import Sampling as Sampling
from .feedforward import AngleFeedforward as AngleFeedforward
from .feedforward import InverseDynamics as InverseDynamics
from .feedforward import TorqueTable as TorqueTable
from .gandhi_ghorbel import GandhiGhorbel as GandhiGhorbel
from .loops import Cascade as Cascade
from .loops import LoadIntegral as LoadIntegral
from .loops import SampledPD as SampledPD
from .measurement import Measurement as Measurement
from .monitor import Average as Average
from .monitor import Demodulator as Demodulator
from .monitor import Tracker as Tracker
from .notch import Notch as Notch
from .notch import notch as notch
from .observer import DisturbanceObserver as DisturbanceObserver
from .repetitive import Repetitive as Repetitive
from .shaping import Shaped as Shaped
from .shaping import shaped as shaped
from .speed_table import SpeedTable as SpeedTable
