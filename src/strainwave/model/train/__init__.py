"""The drive train: motor with its control, shafts and couplings, load, motions and torques."""

from .drive_train import DriveTrain as DriveTrain
from .controls import Commanded as Commanded
from .controls import Free as Free
from .controls import Held as Held
from .controls import PositionLoop as PositionLoop
from .controls import SpeedLoop as SpeedLoop
from .controls import CascadeLoop as CascadeLoop
from .controls import Lagged as Lagged
from .filters import Filtered as Filtered
from .filters import LowPassFilter as LowPassFilter
from .filters import NotchFilter as NotchFilter
from .filters import BiquadFilter as BiquadFilter
from .filters import MovingAverageFilter as MovingAverageFilter
from .filters import PositionIntegral as PositionIntegral
from .controls import Tuning as Tuning
from .controls import from_bandwidth as from_bandwidth
from .shafts import Elastic as Elastic
from .shafts import Load as Load
from .shafts import Motor as Motor
from .motion import AngleTorque as AngleTorque
from .motion import AtRest as AtRest
from .motion import Segment as Segment
from .motion import SpeedProfile as SpeedProfile
from .motion import Steady as Steady
from .motion import TorqueProfile as TorqueProfile
from .train_forms import SteadyTrain as SteadyTrain
