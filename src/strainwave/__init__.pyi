"""The table of contents: every public name once, with its home.

Type checkers read this file; `__init__.py` loads from it what is used. A star takes all names of a room.
"""

# Rooms that are namespaces too: their names are also names of the package
from .model import gears as gears
from .model import laws as laws
from .model import train as train
from .numerics.ensemble import measures as measures
from .sample import sampling as sampling
from . import plot as plot
from .app import report as report
from .model.gears import *
from .model.laws import *
from .model.train import *
from .plot import draw as draw
from .numerics.ensemble.measures import Amplitude as Amplitude
from .numerics.ensemble.measures import Extremes as Extremes
from .numerics.ensemble.measures import Final as Final
from .numerics.ensemble.measures import Mean as Mean
from .numerics.ensemble.measures import Peak as Peak
from .numerics.ensemble.measures import Poincare as Poincare
from .numerics.ensemble.measures import Rms as Rms
from .sample.sampling import LatinHypercube as LatinHypercube
from .sample.sampling import LogUniform as LogUniform
from .sample.sampling import Normal as Normal
from .sample.sampling import Sobol as Sobol
from .sample.sampling import Uniform as Uniform

# Systems: what moves, and what excites it
from .model.drive import HDC_40_050 as HDC_40_050
from .model.drive import HDC_40_050_WARNING as HDC_40_050_WARNING
from .model.drive import Drive as Drive
from .model.oscillator import Oscillator as Oscillator
from .model.excitation import Harmonic as Harmonic
from .model.excitation import Harmonics as Harmonics
from .model.excitation import KinematicError as KinematicError
from .model.excitation import Line as Line
from .model.excitation import NoError as NoError
from .model.varying import GearDamping as GearDamping
from .model.varying import NoVariation as NoVariation
from .model.varying import Ripple as Ripple
from .model.varying import Variation as Variation
from .model.varying import VaryingOscillator as VaryingOscillator
from .model.orders import GearOrder as GearOrder
from .model.orders import OrderMap as OrderMap
from .model.orders import on_output_turn as on_output_turn
from .model.orders import order_map as order_map
from .model.orders import Source as Source
from .model.orders import static_sources as static_sources

# Integration
from .numerics.integration.methods import AdaptiveStep as AdaptiveStep
from .numerics.integration.methods import Dop8 as Dop8
from .numerics.integration.methods import Dopri5 as Dopri5
from .numerics.integration.methods import FixedStep as FixedStep
from .numerics.integration.methods import Rk4 as Rk4
from .numerics.integration.schemes import runge_kutta as runge_kutta
from .numerics.integration.simulate import simulate as simulate
from .numerics.ensemble.ensemble import ensemble as ensemble

# Periodic responses
from .numerics.shooting import find_orbit as find_orbit
from .numerics.shooting import shoot as shoot
from .numerics.curves.response import frequency_response as frequency_response
from .numerics.curves.response import response_family as response_family
from .numerics.curves.parameter_response import parameter_response as parameter_response
from .numerics.curves.switching import switch_branch as switch_branch
from .numerics.curves.fold_curve import FoldCurve as FoldCurve
from .numerics.curves.fold_curve import fold_curve as fold_curve
from .numerics.curves.backbone import Backbone as Backbone
from .numerics.curves.backbone import backbone as backbone

# Attractors
from .numerics.attractors.attractors import Attractor as Attractor
from .numerics.attractors.basins import Basins as Basins
from .numerics.attractors.basins import basins as basins
from .numerics.attractors.poincare import OrbitDiagram as OrbitDiagram
from .numerics.attractors.poincare import PoincareSection as PoincareSection
from .numerics.attractors.poincare import orbit_diagram as orbit_diagram
from .numerics.attractors.poincare import poincare_section as poincare_section
from .numerics.attractors.lyapunov_exponent import LyapunovExponent as LyapunovExponent
from .numerics.attractors.lyapunov_exponent import lyapunov_exponent as lyapunov_exponent

# Closed forms and proofs
from .theory.slow_flow.flow import SlowFlow as SlowFlow
from .theory.slow_flow.flow import slow_flow as slow_flow
from .theory.slow_flow.setting import NONRESONANT as NONRESONANT
from .theory.slow_flow.setting import PRIMARY as PRIMARY
from .theory.slow_flow.setting import SUBHARMONIC as SUBHARMONIC
from .theory.slow_flow.setting import SUPERHARMONIC as SUPERHARMONIC
from .theory.slow_flow.setting import Resonance as Resonance
from .theory.slow_flow.results import SteadyState as SteadyState
from .theory.passage.passage import passage as passage
from .theory.passage.moving import DelayedJump as DelayedJump
from .theory.passage.moving import Passage as Passage
from .theory.passage.moving import Passages as Passages
from .theory.small_signal import SmallSignal as SmallSignal
from .theory.small_signal import small_signal as small_signal
from .theory.small_signal import ParametricTongue as ParametricTongue
from .theory.small_signal import parametric_tongue as parametric_tongue
from .theory.lyapunov import lyapunov as lyapunov
from .theory.stability_proof import StabilityProof as StabilityProof
from .theory.derivation import Derivation as Derivation
from .theory.derivation import derivation as derivation

# Studies: response, jumps
from .drive.jumps import Jumps as Jumps
from .drive.jumps import jumps as jumps
from .drive.jumps import HysteresisBand as HysteresisBand
from .drive.jumps import Jump as Jump
from .study.analysis.isolas import isolas as isolas
from .study.analysis.hardening import Hardening as Hardening
from .study.analysis.hardening import hardening as hardening
from .study.analysis.validity import validity_map as validity_map
from .study.analysis.validity import ValidityMap as ValidityMap
from .study.analysis.validity import validity_in_general as validity_in_general
from .study.analysis.validity import GeneralValidity as GeneralValidity

# Studies: motion at a speed
from .study.analysis.in_time.drive_motion import DriveMotion as DriveMotion
from .study.analysis.in_time.drive_motion import drive_motion as drive_motion

# Studies: speed map
from .study.speed_map.speed_map import speed_map as speed_map
from .study.speed_map.result import SpeedMap as SpeedMap
from .study.speed_map.under_load import CampbellLine as CampbellLine
from .study.speed_map.rules import VendorRule as VendorRule

# Studies: kinematic error
from .study.identification.orders.error_scan import error_scan as error_scan
from .study.identification.orders.error_result import ErrorScan as ErrorScan
from .study.identification.orders.error_result import Reversal as Reversal
from .study.identification.orders.error_result import ScanLine as ScanLine
from .study.kinematic_error.budget import BudgetRow as BudgetRow
from .study.kinematic_error.budget import BudgetTotal as BudgetTotal
from .study.kinematic_error.budget import ErrorBudget as ErrorBudget
from .study.kinematic_error.budget import error_budget as error_budget
from .study.kinematic_error.parts import ErrorParts as ErrorParts
from .study.kinematic_error.parts import error_parts as error_parts

# Studies: gear
from .study.gear.hysteresis import HysteresisLoop as HysteresisLoop
from .study.gear.hysteresis import hysteresis_loop as hysteresis_loop
from .study.gear.hysteresis import lost_motion as lost_motion
from .study.gear.hysteresis import HysteresisFit as HysteresisFit
from .study.gear.hysteresis import fit_hysteresis as fit_hysteresis
from .study.gear.efficiency import Efficiency as Efficiency
from .study.gear.efficiency import efficiency as efficiency
from .study.gear.energy import EnergyBalance as EnergyBalance
from .study.gear.energy import energy_balance as energy_balance
from .study.gear.parametric import ParametricResonance as ParametricResonance
from .study.gear.parametric import parametric_resonances as parametric_resonances

# Studies: identification
from .study.identification.friction.friction_fit import fit_friction as fit_friction
from .study.identification.friction.friction_model import FrictionCandidate as FrictionCandidate
from .study.identification.friction.friction_model import FrictionFit as FrictionFit
from .study.identification.loops.loop_fit import fit_loop as fit_loop
from .study.identification.loops.loop_result import LoopCandidate as LoopCandidate
from .study.identification.loops.loop_result import LoopFit as LoopFit

# Studies: drive train
from .drive.loop_margin import Bode as Bode
from .drive.loop_margin import bode as bode
from .drive.state_space import StateSpace as StateSpace
from .drive.state_space import state_space as state_space
from .drive.margins import Margins as Margins
from .drive.margins import margins as margins
from .drive.run import DriveRun as DriveRun
from .drive.run import drive_run as drive_run
from .drive.operating_point import operating_state as operating_state
from .drive.reductions import Reductions as Reductions
from .drive.reductions import compare_reductions as compare_reductions

# Sampled controllers, and what they leave of the error
from .model import controllers as controllers
from .model.controllers import *
from .numerics.sampled.linear import LoopResponse as LoopResponse
from .numerics.sampled.linear import loop_response as loop_response
from .numerics.sampled.loops import loop_ensemble as loop_ensemble
from .numerics.sampled.loops import run_loop as run_loop
from .numerics.sampled.loops import LoopEnsemble as LoopEnsemble
from .numerics.sampled.loops import LoopRun as LoopRun
from .study.compensation.compensate import compensate as compensate
from .study.compensation.compensate import compensation_bench as compensation_bench
from .study.compensation.monitoring import Monitored as Monitored
from .study.compensation.monitoring import monitor as monitor
from .study.compensation.prediction import PredictionTable as PredictionTable
from .study.compensation.prediction import prediction_table as prediction_table
from .study.compensation.prediction import speed_table as speed_table
from .study.compensation.runup import CompensatedRunup as CompensatedRunup
from .study.compensation.runup import compensated_runup as compensated_runup
from .study.compensation.moves import CompensatedMove as CompensatedMove
from .study.compensation.moves import MoveScore as MoveScore
from .study.compensation.moves import compensated_move as compensated_move
from .study.compensation.designs import COMPENSATORS as COMPENSATORS
from .study.compensation.designs import Compensator as Compensator
from .study.compensation.result import Compensation as Compensation
from .study.compensation.result import CompensationBench as CompensationBench
from .study.compensation.result import Residual as Residual
from .study.compensation.result import Robustness as Robustness
from .study.compensation.result import TorqueUse as TorqueUse
from .study.compensation.result import Units as Units
from .study.identification.compare_laws import LawComparison as LawComparison
from .study.identification.compare_laws import compare_laws as compare_laws
from .study.identification.identified import Identified as Identified
from .study.identification.identify import identify as identify
from .study.identification.orders.order_result import OrderLine as OrderLine
from .study.identification.orders.order_result import OrderScan as OrderScan
from .study.identification.orders.order_scan import order_scan as order_scan
from .study.identification.log import Gap as Gap
from .study.identification.log import Log as Log
from .study.identification.log import LogSegment as LogSegment
from .study.identification.run import Run as Run
from .study.identification.free_decay.decay import DecayFit as DecayFit
from .study.identification.free_decay.decay import fit_decay as fit_decay
from .study.identification.discrepancy import Discrepancy as Discrepancy
from .study.identification.discrepancy import MissingTerm as MissingTerm
from .study.identification.discrepancy import discrepancy as discrepancy
from .study.identification.response_curve.response_fit import ResponseFit as ResponseFit
from .study.identification.response_curve.response_fit import fit_response as fit_response
from .study.identification.fitted import unidentifiable as unidentifiable
from .study.identification.intervals import Interval as Interval
from .study.identification.intervals import bootstrap as bootstrap
from .study.identification.intervals import sandwich as sandwich
from .study.identification.intervals import spread as spread

# Studies: a move
from .study.move.move import move as move
from .study.move.result import Move as Move
from .study.move.result import Pass as Pass
from .study.move.profiles import AngleProfile as AngleProfile
from .study.move.profiles import Dwell as Dwell
from .study.move.profiles import SCurve as SCurve
from .study.move.profiles import Trapezoid as Trapezoid
from .drive.asked import Payload as Payload
from .drive.asked import MotorLimits as MotorLimits

# Studies: sweeps, variability, the article
from .sample.sweep import sweep as sweep
from .sample.sweep import EnsembleMeasure as EnsembleMeasure
from .sample.variability import variability as variability
from .sample.result import Variability as Variability
from .study.article.validate import Comparison as Comparison
from .study.article.validate import compare as compare

# Studies: design
from .study.design.design import design as design
from .study.design.result import Candidate as Candidate
from .study.design.result import Design as Design
from .study.design.result import Sensitivity as Sensitivity
from .study.design.specification import DutySegment as DutySegment
from .study.design.specification import Specification as Specification
from .model.train.controls import Tuning as Tuning

# Files
from .files.fields.entries import project_entry as project_entry
from .files.design import design_text as design_text
from .files.design import read_specification as read_specification
from .files.own_gears import read_gears as read_gears
from .drive.project import Project as Project
from .files.reading import read_project as read_project
from .files.project_text import project_text as project_text
from .files.identified.identify_drive import IdentifiedDrive as IdentifiedDrive
from .files.identified.identify_drive import identify_drive as identify_drive
from .files.variants.replaced import replaced as replaced
from .files.variants.comparison import ProjectComparison as ProjectComparison
from .files.variants.comparison import compare_projects as compare_projects
from .files.variants.scatter import Exceedance as Exceedance
from .files.variants.scatter import exceedance as exceedance
from .files.variants.scatter import scattered as scattered
from .files.variants.project_sweep import sweep_project as sweep_project
from .files.scan_file import read_profile as read_profile
from .files.order_tables.order_table import OrderTable as OrderTable
from .files.order_tables.format import OrderFormat as OrderFormat
from .files.order_tables.format import TableResidual as TableResidual
from .files.export.export import Exported as Exported
from .files.export.export import export as export
from .files.logs.read import read_log as read_log
from .files.scan_file import ScanFile as ScanFile
from .files.scan_file import read_scan as read_scan

# Results, and models with other values
from .base.archive import load as load
from .base.results import Branch as Branch
from .base.results import Orbit as Orbit
from .base.results import SolveError as SolveError
from .base.results import Status as Status
from .base.results import Trajectory as Trajectory
from .base.quantities import replace as replace

__version__: str
__all__: list[str]
