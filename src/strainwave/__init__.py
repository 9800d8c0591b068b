"""strainwave: the nonlinear dynamic error of strain wave gears (harmonic drives).

A *project* is a project file, read by `read_project`: the whole drive. A *system* is its error equation,
`drive.error_equation(...)`; a *train* is the whole drive in numbers, `drive.train(...)`. Numbers are SI and radians.

Of a project: `report.write` (is the drive all right, and what would help), `project.response` (error at each speed,
jumps), `speed_map` (speeds to avoid), `drive_motion` (motion at one speed), `run_up` (error of a run through the
speeds), `move` (worst error and settling of a move), `tune` (gains of the motor's loop), `compensate` (what a
controller leaves), `exceedance` (how likely a drive exceeds its limit), `compare`, `replaced` (other numbers), `export`
(C, FMU, simulators).
Of a system: `find_orbit` (error at one speed), `frequency_response`, `simulate` (error in time), `slow_flow` (a
formula, and how good it is), `theory.derive` (the formulas, from Lagrange on), `study.hardening` (what a stiffer law
gains), `lyapunov` (does every motion decay), `basins` (where it comes to rest), `sweep` and
`ensemble` (many variants, drives of one type).
Of a train: `margins` and `bode` (the motor's loop), `state_space`, `drive_run` (a run in time).
From measurements: `identify_log` (stiffness, damping, error from a log), `fit_loop` (stiffness from a loop on a
bench), `fit.fit_bode` (from a Bode plot), `error_scan` and `order_scan` (orders),
`fit.arrangement` (ratio and arrangement from both encoders).
For a joint to be built: `design` (gears of the catalogue that do what is asked), `catalogue.gear`.

Namespaces have the rest: `laws`, `train`, `controllers`, `gears`, `fit`, `sample`, `numerics`, `theory`, `study`,
`results`, `plot`, `report`. `__init__.pyi` beside this file is the table of contents. A name is loaded when it is first
used, so that importing the package costs nothing.
"""

from . import maths as maths
from .base.above import contents

__version__ = "0.3.0"

__all__, __getattr__, _names = contents(__name__, __file__)


def __dir__() -> list[str]:
    return [*_names(), "__version__"]
