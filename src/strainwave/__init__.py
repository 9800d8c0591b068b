"""strainwave: the nonlinear dynamic error of strain wave gears (harmonic drives).

Every public name is listed here and loaded when it is first used, so that importing the package costs nothing.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

if TYPE_CHECKING:
    from .files.entries import project_entry as project_entry
    from .files.own_gears import read_gears as read_gears
    from .files.project_text import project_text as project_text
    from .files.scan_file import ScanFile as ScanFile
    from .files.scan_file import read_scan as read_scan
    from .model.drive import HDC_40_050 as HDC_40_050
    from .model.drive import HDC_40_050_WARNING as HDC_40_050_WARNING
    from .model.drive import Drive as Drive
    from .model.excitation import Harmonic as Harmonic
    from .model.excitation import Harmonics as Harmonics
    from .model.excitation import KinematicError as KinematicError
    from .model.excitation import Line as Line
    from .model.excitation import NoError as NoError
    from .model.friction import Coulomb as Coulomb
    from .model.friction import LuGre as LuGre
    from .model.friction import Stribeck as Stribeck
    from .model.friction import Viscous as Viscous
    from .model.gears import catalogue as catalogue
    from .model.gears.error_spectrum import MEASURED_ERRORS as MEASURED_ERRORS
    from .model.gears.error_spectrum import MeasuredError as MeasuredError
    from .model.gears.error_spectrum import accuracy_spectrum as accuracy_spectrum
    from .model.gears.error_spectrum import peak_to_peak as peak_to_peak
    from .model.gears.fits import LawFit as LawFit
    from .model.gears.fits import fit_odd as fit_odd
    from .model.gears.limits import Finding as Finding
    from .model.gears.limits import check_limits as check_limits
    from .model.gears.limits import cubic_mean as cubic_mean
    from .model.hysteresis import BoucWen as BoucWen
    from .model.hysteresis import Parallel as Parallel
    from .model.laws import Backlash as Backlash
    from .model.laws import Cubic as Cubic
    from .model.laws import Linear as Linear
    from .model.laws import PiecewiseLinear as PiecewiseLinear
    from .model.laws import Play as Play
    from .model.laws import Polynomial as Polynomial
    from .model.measured import Knot as Knot
    from .model.measured import RoundedPiecewiseLinear as RoundedPiecewiseLinear
    from .model.measured import Tabulated as Tabulated
    from .model.measured import tabulated as tabulated
    from .model.orders import GearOrder as GearOrder
    from .model.orders import OrderMap as OrderMap
    from .model.orders import on_output_turn as on_output_turn
    from .model.orders import order_map as order_map
    from .model.oscillator import Oscillator as Oscillator
    from .model.sources import Source as Source
    from .model.sources import static_sources as static_sources
    from .model.train.drive_train import DriveTrain as DriveTrain
    from .model.train.motion import AngleTorque as AngleTorque
    from .model.train.motion import AtRest as AtRest
    from .model.train.motion import SpeedProfile as SpeedProfile
    from .model.train.motion import Steady as Steady
    from .model.train.motion import TorqueProfile as TorqueProfile
    from .model.train.shafts import Elastic as Elastic
    from .model.train.shafts import Free as Free
    from .model.train.shafts import Held as Held
    from .model.train.shafts import Load as Load
    from .model.train.shafts import Motor as Motor
    from .model.train.shafts import PositionLoop as PositionLoop
    from .model.train.shafts import SpeedLoop as SpeedLoop
    from .model.train.train_forms import SteadyTrain as SteadyTrain
    from .model.varying import GearDamping as GearDamping
    from .model.varying import NoVariation as NoVariation
    from .model.varying import Ripple as Ripple
    from .model.varying import Variation as Variation
    from .model.varying import VaryingOscillator as VaryingOscillator
    from .numerics.attractors.attractors import Attractor as Attractor
    from .numerics.attractors.basins import Basins as Basins
    from .numerics.attractors.basins import basins as basins
    from .numerics.attractors.lyapunov_exponent import LyapunovExponent as LyapunovExponent
    from .numerics.attractors.lyapunov_exponent import lyapunov_exponent as lyapunov_exponent
    from .numerics.attractors.poincare import OrbitDiagram as OrbitDiagram
    from .numerics.attractors.poincare import PoincareSection as PoincareSection
    from .numerics.attractors.poincare import orbit_diagram as orbit_diagram
    from .numerics.attractors.poincare import poincare_section as poincare_section
    from .numerics.curves.backbone import Backbone as Backbone
    from .numerics.curves.backbone import backbone as backbone
    from .numerics.curves.family import response_family as response_family
    from .numerics.curves.fold_curve import FoldCurve as FoldCurve
    from .numerics.curves.fold_curve import fold_curve as fold_curve
    from .numerics.curves.parameter_response import parameter_response as parameter_response
    from .numerics.curves.response import frequency_response as frequency_response
    from .numerics.curves.switching import switch_branch as switch_branch
    from .numerics.ensemble.ensemble import ensemble as ensemble
    from .numerics.ensemble.measures import Amplitude as Amplitude
    from .numerics.ensemble.measures import Extremes as Extremes
    from .numerics.ensemble.measures import Final as Final
    from .numerics.ensemble.measures import Mean as Mean
    from .numerics.ensemble.measures import Peak as Peak
    from .numerics.ensemble.measures import Poincare as Poincare
    from .numerics.ensemble.measures import Rms as Rms
    from .numerics.integration.simulate import Dop8 as Dop8
    from .numerics.integration.simulate import Dopri5 as Dopri5
    from .numerics.integration.simulate import Rk4 as Rk4
    from .numerics.integration.simulate import simulate as simulate
    from .numerics.orbits.find_orbit import find_orbit as find_orbit
    from .numerics.orbits.shooting import shoot as shoot
    from .plot.draw import draw_basins as draw_basins
    from .plot.draw import draw_orbit_diagram as draw_orbit_diagram
    from .plot.draw import draw_variability as draw_variability
    from .quantities import replace as replace
    from .results import Branch as Branch
    from .results import Orbit as Orbit
    from .results import SolveError as SolveError
    from .results import Status as Status
    from .results import Trajectory as Trajectory
    from .study.article.validate import Comparison as Comparison
    from .study.article.validate import compare as compare
    from .study.gear.energy import EnergyBalance as EnergyBalance
    from .study.gear.energy import energy_balance as energy_balance
    from .study.gear.hysteresis import HysteresisLoop as HysteresisLoop
    from .study.gear.hysteresis import hysteresis_loop as hysteresis_loop
    from .study.gear.hysteresis import lost_motion as lost_motion
    from .study.gear.hysteresis_fit import HysteresisFit as HysteresisFit
    from .study.gear.hysteresis_fit import fit_hysteresis as fit_hysteresis
    from .study.gear.parametric import ParametricResonance as ParametricResonance
    from .study.gear.parametric import parametric_resonances as parametric_resonances
    from .study.kinematic_error.budget import BudgetRow as BudgetRow
    from .study.kinematic_error.budget import BudgetTotal as BudgetTotal
    from .study.kinematic_error.budget import ErrorBudget as ErrorBudget
    from .study.kinematic_error.budget import error_budget as error_budget
    from .study.kinematic_error.parts import ErrorParts as ErrorParts
    from .study.kinematic_error.parts import error_parts as error_parts
    from .study.kinematic_error.scan import error_scan as error_scan
    from .study.kinematic_error.scan_results import ErrorScan as ErrorScan
    from .study.kinematic_error.scan_results import Reversal as Reversal
    from .study.kinematic_error.scan_results import ScanLine as ScanLine
    from .study.response.hysteresis_bands import HysteresisBand as HysteresisBand
    from .study.response.hysteresis_bands import Jump as Jump
    from .study.response.isolas import isolas as isolas
    from .study.response.jumps import Jumps as Jumps
    from .study.response.jumps import jumps as jumps
    from .study.sweep.ensemble_measure import EnsembleMeasure as EnsembleMeasure
    from .study.sweep.sampling import LatinHypercube as LatinHypercube
    from .study.sweep.sampling import LogUniform as LogUniform
    from .study.sweep.sampling import Normal as Normal
    from .study.sweep.sampling import Sobol as Sobol
    from .study.sweep.sampling import Uniform as Uniform
    from .study.sweep.sweep import sweep as sweep
    from .study.train.bode import Bode as Bode
    from .study.train.bode import bode as bode
    from .study.train.operating_point import operating_state as operating_state
    from .study.train.reductions import Reductions as Reductions
    from .study.train.reductions import compare_reductions as compare_reductions
    from .study.train.run import DriveRun as DriveRun
    from .study.train.run import drive_run as drive_run
    from .study.variability.result import Variability as Variability
    from .study.variability.variability import variability as variability
    from .theory.derivation import Derivation as Derivation
    from .theory.derivation import derivation as derivation
    from .theory.lyapunov import lyapunov as lyapunov
    from .theory.parametric import ParametricTongue as ParametricTongue
    from .theory.parametric import parametric_tongue as parametric_tongue
    from .theory.slow_flow.multiple_scales import SlowFlow as SlowFlow
    from .theory.slow_flow.multiple_scales import slow_flow as slow_flow
    from .theory.slow_flow.resonance import NONRESONANT as NONRESONANT
    from .theory.slow_flow.resonance import PRIMARY as PRIMARY
    from .theory.slow_flow.resonance import SUBHARMONIC as SUBHARMONIC
    from .theory.slow_flow.resonance import SUPERHARMONIC as SUPERHARMONIC
    from .theory.slow_flow.resonance import Resonance as Resonance
    from .theory.slow_flow.results import SteadyState as SteadyState
    from .theory.small_signal import SmallSignal as SmallSignal
    from .theory.small_signal import small_signal as small_signal
    from .theory.stability_proof import StabilityProof as StabilityProof

_HOME = {
    "plot.draw": ("draw_basins", "draw_orbit_diagram", "draw_variability"),
    "files.entries": ("project_entry",),
    "files.own_gears": ("read_gears",),
    "files.project_text": ("project_text",),
    "files.scan_file": ("ScanFile", "read_scan"),
    "model.drive": ("Drive", "HDC_40_050", "HDC_40_050_WARNING"),
    "model.gears.error_spectrum": ("MEASURED_ERRORS", "MeasuredError", "accuracy_spectrum", "peak_to_peak"),
    "model.train.drive_train": ("DriveTrain",),
    "model.excitation": ("Harmonic", "Harmonics", "KinematicError", "Line", "NoError"),
    "model.gears.fits": ("LawFit", "fit_odd"),
    "model.friction": ("Coulomb", "LuGre", "Stribeck", "Viscous"),
    "model.hysteresis": ("BoucWen", "Parallel"),
    "model.laws": ("Backlash", "Cubic", "Linear", "PiecewiseLinear", "Play", "Polynomial"),
    "model.gears.limits": ("Finding", "check_limits", "cubic_mean"),
    "model.measured": ("Knot", "RoundedPiecewiseLinear", "Tabulated", "tabulated"),
    "model.orders": ("GearOrder", "OrderMap", "on_output_turn", "order_map"),
    "model.train.motion": ("AngleTorque", "AtRest", "SpeedProfile", "Steady", "TorqueProfile"),
    "model.oscillator": ("Oscillator",),
    "model.train.shafts": ("Elastic", "Free", "Held", "Load", "Motor", "PositionLoop", "SpeedLoop"),
    "model.sources": ("Source", "static_sources"),
    "model.train.train_forms": ("SteadyTrain",),
    "model.varying": ("GearDamping", "NoVariation", "Ripple", "Variation", "VaryingOscillator"),
    "numerics.curves.backbone": ("Backbone", "backbone"),
    "numerics.attractors.attractors": ("Attractor",),
    "numerics.attractors.basins": ("Basins", "basins"),
    "numerics.curves.fold_curve": ("FoldCurve", "fold_curve"),
    "numerics.ensemble.ensemble": ("ensemble",),
    "numerics.curves.family": ("response_family",),
    "numerics.ensemble.measures": ("Amplitude", "Extremes", "Final", "Mean", "Peak", "Poincare", "Rms"),
    "numerics.integration.simulate": ("Dop8", "Dopri5", "Rk4", "simulate"),
    "numerics.attractors.lyapunov_exponent": ("LyapunovExponent", "lyapunov_exponent"),
    "numerics.orbits.find_orbit": ("find_orbit",),
    "numerics.curves.parameter_response": ("parameter_response",),
    "numerics.attractors.poincare": ("OrbitDiagram", "PoincareSection", "orbit_diagram", "poincare_section"),
    "numerics.curves.response": ("frequency_response",),
    "numerics.orbits.shooting": ("shoot",),
    "numerics.curves.switching": ("switch_branch",),
    "quantities": ("replace",),
    "results": ("Branch", "Orbit", "SolveError", "Status", "Trajectory"),
    "study.train.bode": ("Bode", "bode"),
    "study.train.run": ("DriveRun", "drive_run"),
    "study.sweep.ensemble_measure": ("EnsembleMeasure",),
    "study.gear.energy": ("EnergyBalance", "energy_balance"),
    "study.kinematic_error.budget": ("BudgetRow", "BudgetTotal", "ErrorBudget", "error_budget"),
    "study.kinematic_error.parts": ("ErrorParts", "error_parts"),
    "study.kinematic_error.scan": ("error_scan",),
    "study.gear.hysteresis": ("HysteresisLoop", "hysteresis_loop", "lost_motion"),
    "study.gear.hysteresis_fit": ("HysteresisFit", "fit_hysteresis"),
    "study.response.isolas": ("isolas",),
    "study.response.hysteresis_bands": ("HysteresisBand", "Jump"),
    "study.response.jumps": ("Jumps", "jumps"),
    "study.gear.parametric": ("ParametricResonance", "parametric_resonances"),
    "study.train.reductions": ("Reductions", "compare_reductions"),
    "study.sweep.sampling": ("LatinHypercube", "LogUniform", "Normal", "Sobol", "Uniform"),
    "study.kinematic_error.scan_results": ("ErrorScan", "Reversal", "ScanLine"),
    "study.sweep.sweep": ("sweep",),
    "study.train.operating_point": ("operating_state",),
    "study.article.validate": ("Comparison", "compare"),
    "study.variability.variability": ("variability",),
    "study.variability.result": ("Variability",),
    "theory.derivation": ("Derivation", "derivation"),
    "theory.lyapunov": ("lyapunov",),
    "theory.slow_flow.multiple_scales": ("SlowFlow", "slow_flow"),
    "theory.parametric": ("ParametricTongue", "parametric_tongue"),
    "theory.slow_flow.resonance": ("NONRESONANT", "PRIMARY", "SUBHARMONIC", "SUPERHARMONIC", "Resonance"),
    "theory.slow_flow.results": ("SteadyState",),
    "theory.small_signal": ("SmallSignal", "small_signal"),
    "theory.stability_proof": ("StabilityProof",),
}
_MODULE = {name: module for module, names in _HOME.items() for name in names}

__all__ = [*sorted(_MODULE), "catalogue"]


def __getattr__(name: str) -> Any:
    if name == "catalogue":
        return import_module(".model.gears.catalogue", __name__)
    if name in _MODULE:
        return getattr(import_module("." + _MODULE[name], __name__), name)
    raise AttributeError(f"strainwave has no name {name!r}; dir(strainwave) lists what it has")


def __dir__() -> list[str]:
    return sorted([*__all__, "__version__"])
