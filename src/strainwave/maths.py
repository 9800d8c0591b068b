"""Elementary functions that a law or an excitation may call on floats, arrays and symbols alike (`compile.maths`)."""

from .compile.maths import cos as cos
from .compile.maths import exp as exp
from .compile.maths import log as log
from .compile.maths import power as power
from .compile.maths import sign as sign
from .compile.maths import sin as sin
from .compile.maths import sqrt as sqrt
from .compile.maths import tanh as tanh
