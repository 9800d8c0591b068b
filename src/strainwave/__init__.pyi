"""The table of contents: every public name at the top once, with its home; namespaces have tables of their own.

Type checkers read this file; `__init__.py` loads from it what is used.
"""

# Namespaces: every public name is at the top or in one of them
from .model import laws as laws
from .model import train as train
from .model import controllers as controllers
from .model import gears as gears
from . import fit as fit
from . import sample as sample
from . import numerics as numerics
from . import theory as theory
from . import study as study
from . import results as results
from . import plot as plot
from .app import report as report

# A drive: laws, gear, error, load
from .model.gears import catalogue as catalogue
from .model.laws.springs import Linear as Linear
from .model.laws.springs import Cubic as Cubic
from .model.laws.springs import Polynomial as Polynomial
from .model.laws.springs import PiecewiseLinear as PiecewiseLinear
from .model.laws.springs import Backlash as Backlash
from .model.laws.springs import Play as Play
from .model.laws.hysteresis import BoucWen as BoucWen
from .model.laws.hysteresis import Parallel as Parallel
from .model.laws.measured import tabulated as tabulated
from .model.excitation import Harmonic as Harmonic
from .model.excitation import Harmonics as Harmonics
from .model.excitation import Line as Line
from .model.excitation import KinematicError as KinematicError
from .model.excitation import NoError as NoError
from .model.oscillator import Oscillator as Oscillator
from .model.drive import Drive as Drive
from .model.drive import HDC_40_050 as HDC_40_050
from .model.train.drive_train import DriveTrain as DriveTrain

# A project: its file and its variants
from .drive.project import Project as Project
from .files.reading import read_project as read_project
from .files.project_text import project_text as project_text
from .files.fields.entries import project_entry as project_entry
from .files.variants.replaced import replaced as replaced
from .base.archive import load as load
from .drive.demands.motor_limits import MotorLimits as MotorLimits
from .drive.demands.payload import Payload as Payload
from .drive.demands.move_task import Feedforward as Feedforward
from .drive.postures import Posture as Posture
from .files.fields.csv_files import read_postures as read_postures
from .files.own_gears import read_gears as read_gears

# Motion in time
from .numerics.integration.simulate import simulate as simulate
from .numerics.integration.methods import Dopri5 as Dopri5
from .numerics.integration.methods import Rk4 as Rk4
from .numerics.integration.methods import Dop8 as Dop8
from .drive.run import drive_run as drive_run
from .study.analysis.time_domain.drive_motion import drive_motion as drive_motion
from .numerics.ensemble.ensemble import ensemble as ensemble
from .numerics.ensemble.measures import Peak as Peak
from .numerics.ensemble.measures import Rms as Rms
from .numerics.ensemble.measures import Amplitude as Amplitude
from .numerics.ensemble.measures import Final as Final

# Periodic motions
from .numerics.balanced_orbit import find_orbit as find_orbit
from .numerics.curves.response import frequency_response as frequency_response
from .study.analysis.isolas import isolas as isolas
from .numerics.attractors.basins import basins as basins
from .drive.jumps import jumps as jumps

# Closed forms and proofs
from .theory.slow_flow.flow import slow_flow as slow_flow
from .theory.resonance import Resonance as Resonance
from .theory.resonance import PRIMARY as PRIMARY
from .theory.resonance import SUPERHARMONIC as SUPERHARMONIC
from .theory.resonance import SUBHARMONIC as SUBHARMONIC
from .theory.resonance import NONRESONANT as NONRESONANT
from .theory.lyapunov import lyapunov as lyapunov
from .theory.small_signal import small_signal as small_signal

# The motor's loop
from .drive.loops.bode import bode as bode
from .drive.loops.margins import margins as margins
from .drive.state_space import state_space as state_space
from .study.tuning.tune import tune as tune

# Speeds, moves, design
from .study.speed_map.speed_map import speed_map as speed_map
from .study.move.move import move as move
from .study.move.run_up import run_up as run_up
from .study.move.postures import move_postures as move_postures
from .study.move.profiles import Trapezoid as Trapezoid
from .study.move.profiles import SCurve as SCurve
from .study.move.profiles import AngleProfile as AngleProfile
from .files.fields.csv_files import read_profile as read_profile
from .study.design.design import design as design
from .study.design.specification import Specification as Specification
from .study.design.specification import DutySegment as DutySegment
from .files.specification import read_specification as read_specification
from .files.design_text import design_text as design_text

# Cancel the error, and export
from .study.compensation.compensate import compensate as compensate
from .study.compensation.monitoring import monitor as monitor
from .study.compensation.prediction import prediction_table as prediction_table
from .files.order_table import OrderTable as OrderTable
from .files.export.export import export as export

# From measurements
from .study.identification.run import Run as Run
from .study.identification.log import Log as Log
from .files.logs.read import read_log as read_log
from .files.frd import read_frd as read_frd
from .files.logs.scan_file import read_scan as read_scan
from .study.identification.orders.order_scan import order_scan as order_scan
from .study.identification.orders.error_scan import error_scan as error_scan
from .study.identification.loops.loop_fit import fit_loop as fit_loop
from .study.identification.identify import identify as identify
from .files.variants.identify_log import identify_log as identify_log
from .study.gear.hysteresis_loop import hysteresis_loop as hysteresis_loop

# Many drives
from .sample.sweeping import sweep as sweep
from .sample.ensemble_measure import EnsembleMeasure as EnsembleMeasure
from .files.variants.comparison import compare as compare
from .files.variants.scatter import exceedance as exceedance
from .sample.sampling import Normal as Normal
from .sample.sampling import Uniform as Uniform

# Results
from .base.results import Orbit as Orbit
from .base.results import Branch as Branch
from .base.results import Trajectory as Trajectory
from .base.results import Status as Status
from .base.results import SolveError as SolveError
from .theory.slow_flow.flow import SlowFlow as SlowFlow
from .theory.slow_flow.results import SteadyState as SteadyState
from .theory.stability_proof import StabilityProof as StabilityProof
from .plot import draw as draw

__version__: str
__all__: list[str]
