"""Sampled controllers of the motor, what they measure, and the loop that they close around a drive train."""

from .adaptive import AdaptiveCancellation as AdaptiveCancellation
from .adaptive import Repetitive as Repetitive
from .closed_loop import ClosedLoop as ClosedLoop
from .closed_loop import Sampling as Sampling
from .feedforward import AngleFeedforward as AngleFeedforward
from .feedforward import InverseDynamics as InverseDynamics
from .feedforward import SpeedTable as SpeedTable
from .feedforward import TorqueTable as TorqueTable
from .loops import Cascade as Cascade
from .loops import DisturbanceObserver as DisturbanceObserver
from .loops import Measurement as Measurement
from .loops import Notch as Notch
from .loops import SampledPD as SampledPD
from .loops import notch as notch
from .monitor import Average as Average
from .monitor import Demodulator as Demodulator
from .monitor import Tracker as Tracker
