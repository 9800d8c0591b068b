"""A drive at single speeds in time: its error equation beside closed forms, and its own motion (`drive_motion`)."""

from .time_case import Cycle as Cycle
from .time_case import TimeCase as TimeCase
from .time_case import cycle_of as cycle_of
from .time_case import speeds_in_time as speeds_in_time
from .time_case import time_case as time_case
