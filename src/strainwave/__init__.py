"""strainwave: the nonlinear dynamic error of strain wave gears (harmonic drives).

Every public name is listed here and loaded when it is first used, so that importing the package costs nothing.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

if TYPE_CHECKING:
    from .app.draw import draw_basins as draw_basins
    from .app.draw import draw_orbit_diagram as draw_orbit_diagram
    from .app.draw import draw_variability as draw_variability
    from .app.entries import project_entry as project_entry
    from .app.own_gears import read_gears as read_gears
    from .app.project_text import project_text as project_text
    from .app.scan_file import ScanFile as ScanFile
    from .app.scan_file import read_scan as read_scan
    from .model import catalogue as catalogue
    from .model.drive import HDC_40_050 as HDC_40_050
    from .model.drive import HDC_40_050_WARNING as HDC_40_050_WARNING
    from .model.drive import Drive as Drive
    from .model.drive_train import DriveTrain as DriveTrain
    from .model.error_spectrum import MEASURED_ERRORS as MEASURED_ERRORS
    from .model.error_spectrum import MeasuredError as MeasuredError
    from .model.error_spectrum import accuracy_spectrum as accuracy_spectrum
    from .model.error_spectrum import peak_to_peak as peak_to_peak
    from .model.excitation import Harmonic as Harmonic
    from .model.excitation import Harmonics as Harmonics
    from .model.excitation import KinematicError as KinematicError
    from .model.excitation import Line as Line
    from .model.excitation import NoError as NoError
    from .model.fits import LawFit as LawFit
    from .model.fits import fit_odd as fit_odd
    from .model.friction import Coulomb as Coulomb
    from .model.friction import LuGre as LuGre
    from .model.friction import Stribeck as Stribeck
    from .model.friction import Viscous as Viscous
    from .model.hysteresis import BoucWen as BoucWen
    from .model.hysteresis import Parallel as Parallel
    from .model.laws import Backlash as Backlash
    from .model.laws import Cubic as Cubic
    from .model.laws import Linear as Linear
    from .model.laws import PiecewiseLinear as PiecewiseLinear
    from .model.laws import Play as Play
    from .model.laws import Polynomial as Polynomial
    from .model.limits import Finding as Finding
    from .model.limits import check_limits as check_limits
    from .model.limits import cubic_mean as cubic_mean
    from .model.measured import Knot as Knot
    from .model.measured import RoundedPiecewiseLinear as RoundedPiecewiseLinear
    from .model.measured import Tabulated as Tabulated
    from .model.measured import tabulated as tabulated
    from .model.motion import AngleTorque as AngleTorque
    from .model.motion import AtRest as AtRest
    from .model.motion import SpeedProfile as SpeedProfile
    from .model.motion import Steady as Steady
    from .model.motion import TorqueProfile as TorqueProfile
    from .model.orders import GearOrder as GearOrder
    from .model.orders import OrderMap as OrderMap
    from .model.orders import on_output_turn as on_output_turn
    from .model.orders import order_map as order_map
    from .model.oscillator import Oscillator as Oscillator
    from .model.shafts import Elastic as Elastic
    from .model.shafts import Free as Free
    from .model.shafts import Held as Held
    from .model.shafts import Load as Load
    from .model.shafts import Motor as Motor
    from .model.shafts import PositionLoop as PositionLoop
    from .model.shafts import SpeedLoop as SpeedLoop
    from .model.sources import Source as Source
    from .model.sources import static_sources as static_sources
    from .model.train_forms import SteadyTrain as SteadyTrain
    from .model.varying import GearDamping as GearDamping
    from .model.varying import NoVariation as NoVariation
    from .model.varying import Ripple as Ripple
    from .model.varying import Variation as Variation
    from .model.varying import VaryingOscillator as VaryingOscillator
    from .numerics.attractors import Attractor as Attractor
    from .numerics.backbone import Backbone as Backbone
    from .numerics.backbone import backbone as backbone
    from .numerics.basins import Basins as Basins
    from .numerics.basins import basins as basins
    from .numerics.ensemble import ensemble as ensemble
    from .numerics.family import response_family as response_family
    from .numerics.fold_curve import FoldCurve as FoldCurve
    from .numerics.fold_curve import fold_curve as fold_curve
    from .numerics.integrate import Dop8 as Dop8
    from .numerics.integrate import Dopri5 as Dopri5
    from .numerics.integrate import Rk4 as Rk4
    from .numerics.integrate import simulate as simulate
    from .numerics.lyapunov_exponent import LyapunovExponent as LyapunovExponent
    from .numerics.lyapunov_exponent import lyapunov_exponent as lyapunov_exponent
    from .numerics.measures import Amplitude as Amplitude
    from .numerics.measures import Extremes as Extremes
    from .numerics.measures import Final as Final
    from .numerics.measures import Mean as Mean
    from .numerics.measures import Peak as Peak
    from .numerics.measures import Poincare as Poincare
    from .numerics.measures import Rms as Rms
    from .numerics.orbits import find_orbit as find_orbit
    from .numerics.parameter_sweep import parameter_response as parameter_response
    from .numerics.poincare import OrbitDiagram as OrbitDiagram
    from .numerics.poincare import PoincareSection as PoincareSection
    from .numerics.poincare import orbit_diagram as orbit_diagram
    from .numerics.poincare import poincare_section as poincare_section
    from .numerics.response import frequency_response as frequency_response
    from .numerics.shooting import shoot as shoot
    from .numerics.switching import switch_branch as switch_branch
    from .quantities import replace as replace
    from .results import Branch as Branch
    from .results import Orbit as Orbit
    from .results import SolveError as SolveError
    from .results import Status as Status
    from .results import Trajectory as Trajectory
    from .study.bode import Bode as Bode
    from .study.bode import bode as bode
    from .study.drive_runs import DriveRun as DriveRun
    from .study.drive_runs import drive_run as drive_run
    from .study.energy import EnergyBalance as EnergyBalance
    from .study.energy import energy_balance as energy_balance
    from .study.ensemble_measure import EnsembleMeasure as EnsembleMeasure
    from .study.error_budget import BudgetRow as BudgetRow
    from .study.error_budget import BudgetTotal as BudgetTotal
    from .study.error_budget import ErrorBudget as ErrorBudget
    from .study.error_budget import error_budget as error_budget
    from .study.error_parts import ErrorParts as ErrorParts
    from .study.error_parts import error_parts as error_parts
    from .study.error_scan import error_scan as error_scan
    from .study.hysteresis import HysteresisLoop as HysteresisLoop
    from .study.hysteresis import hysteresis_loop as hysteresis_loop
    from .study.hysteresis import lost_motion as lost_motion
    from .study.hysteresis_bands import HysteresisBand as HysteresisBand
    from .study.hysteresis_bands import Jump as Jump
    from .study.hysteresis_fit import HysteresisFit as HysteresisFit
    from .study.hysteresis_fit import fit_hysteresis as fit_hysteresis
    from .study.isolas import isolas as isolas
    from .study.jumps import Jumps as Jumps
    from .study.jumps import jumps as jumps
    from .study.parametric import ParametricResonance as ParametricResonance
    from .study.parametric import parametric_resonances as parametric_resonances
    from .study.reductions import Reductions as Reductions
    from .study.reductions import compare_reductions as compare_reductions
    from .study.sampling import LatinHypercube as LatinHypercube
    from .study.sampling import LogUniform as LogUniform
    from .study.sampling import Normal as Normal
    from .study.sampling import Sobol as Sobol
    from .study.sampling import Uniform as Uniform
    from .study.scan_results import ErrorScan as ErrorScan
    from .study.scan_results import Reversal as Reversal
    from .study.scan_results import ScanLine as ScanLine
    from .study.sweep import sweep as sweep
    from .study.train_point import operating_state as operating_state
    from .study.validate import Comparison as Comparison
    from .study.validate import compare as compare
    from .study.variability import variability as variability
    from .study.variability_result import Variability as Variability
    from .theory.derivation import Derivation as Derivation
    from .theory.derivation import derivation as derivation
    from .theory.lyapunov import lyapunov as lyapunov
    from .theory.multiple_scales import SlowFlow as SlowFlow
    from .theory.multiple_scales import slow_flow as slow_flow
    from .theory.parametric import ParametricTongue as ParametricTongue
    from .theory.parametric import parametric_tongue as parametric_tongue
    from .theory.resonance import NONRESONANT as NONRESONANT
    from .theory.resonance import PRIMARY as PRIMARY
    from .theory.resonance import SUBHARMONIC as SUBHARMONIC
    from .theory.resonance import SUPERHARMONIC as SUPERHARMONIC
    from .theory.resonance import Resonance as Resonance
    from .theory.slow_results import SteadyState as SteadyState
    from .theory.small_signal import SmallSignal as SmallSignal
    from .theory.small_signal import small_signal as small_signal
    from .theory.stability_proof import StabilityProof as StabilityProof

_HOME = {
    "app.draw": ("draw_basins", "draw_orbit_diagram", "draw_variability"),
    "app.entries": ("project_entry",),
    "app.own_gears": ("read_gears",),
    "app.project_text": ("project_text",),
    "app.scan_file": ("ScanFile", "read_scan"),
    "model.drive": ("Drive", "HDC_40_050", "HDC_40_050_WARNING"),
    "model.error_spectrum": ("MEASURED_ERRORS", "MeasuredError", "accuracy_spectrum", "peak_to_peak"),
    "model.drive_train": ("DriveTrain",),
    "model.excitation": ("Harmonic", "Harmonics", "KinematicError", "Line", "NoError"),
    "model.fits": ("LawFit", "fit_odd"),
    "model.friction": ("Coulomb", "LuGre", "Stribeck", "Viscous"),
    "model.hysteresis": ("BoucWen", "Parallel"),
    "model.laws": ("Backlash", "Cubic", "Linear", "PiecewiseLinear", "Play", "Polynomial"),
    "model.limits": ("Finding", "check_limits", "cubic_mean"),
    "model.measured": ("Knot", "RoundedPiecewiseLinear", "Tabulated", "tabulated"),
    "model.orders": ("GearOrder", "OrderMap", "on_output_turn", "order_map"),
    "model.motion": ("AngleTorque", "AtRest", "SpeedProfile", "Steady", "TorqueProfile"),
    "model.oscillator": ("Oscillator",),
    "model.shafts": ("Elastic", "Free", "Held", "Load", "Motor", "PositionLoop", "SpeedLoop"),
    "model.sources": ("Source", "static_sources"),
    "model.train_forms": ("SteadyTrain",),
    "model.varying": ("GearDamping", "NoVariation", "Ripple", "Variation", "VaryingOscillator"),
    "numerics.backbone": ("Backbone", "backbone"),
    "numerics.attractors": ("Attractor",),
    "numerics.basins": ("Basins", "basins"),
    "numerics.fold_curve": ("FoldCurve", "fold_curve"),
    "numerics.ensemble": ("ensemble",),
    "numerics.family": ("response_family",),
    "numerics.measures": ("Amplitude", "Extremes", "Final", "Mean", "Peak", "Poincare", "Rms"),
    "numerics.integrate": ("Dop8", "Dopri5", "Rk4", "simulate"),
    "numerics.lyapunov_exponent": ("LyapunovExponent", "lyapunov_exponent"),
    "numerics.orbits": ("find_orbit",),
    "numerics.parameter_sweep": ("parameter_response",),
    "numerics.poincare": ("OrbitDiagram", "PoincareSection", "orbit_diagram", "poincare_section"),
    "numerics.response": ("frequency_response",),
    "numerics.shooting": ("shoot",),
    "numerics.switching": ("switch_branch",),
    "quantities": ("replace",),
    "results": ("Branch", "Orbit", "SolveError", "Status", "Trajectory"),
    "study.bode": ("Bode", "bode"),
    "study.drive_runs": ("DriveRun", "drive_run"),
    "study.ensemble_measure": ("EnsembleMeasure",),
    "study.energy": ("EnergyBalance", "energy_balance"),
    "study.error_budget": ("BudgetRow", "BudgetTotal", "ErrorBudget", "error_budget"),
    "study.error_parts": ("ErrorParts", "error_parts"),
    "study.error_scan": ("error_scan",),
    "study.hysteresis": ("HysteresisLoop", "hysteresis_loop", "lost_motion"),
    "study.hysteresis_fit": ("HysteresisFit", "fit_hysteresis"),
    "study.isolas": ("isolas",),
    "study.hysteresis_bands": ("HysteresisBand", "Jump"),
    "study.jumps": ("Jumps", "jumps"),
    "study.parametric": ("ParametricResonance", "parametric_resonances"),
    "study.reductions": ("Reductions", "compare_reductions"),
    "study.sampling": ("LatinHypercube", "LogUniform", "Normal", "Sobol", "Uniform"),
    "study.scan_results": ("ErrorScan", "Reversal", "ScanLine"),
    "study.sweep": ("sweep",),
    "study.train_point": ("operating_state",),
    "study.validate": ("Comparison", "compare"),
    "study.variability": ("variability",),
    "study.variability_result": ("Variability",),
    "theory.derivation": ("Derivation", "derivation"),
    "theory.lyapunov": ("lyapunov",),
    "theory.multiple_scales": ("SlowFlow", "slow_flow"),
    "theory.parametric": ("ParametricTongue", "parametric_tongue"),
    "theory.resonance": ("NONRESONANT", "PRIMARY", "SUBHARMONIC", "SUPERHARMONIC", "Resonance"),
    "theory.slow_results": ("SteadyState",),
    "theory.small_signal": ("SmallSignal", "small_signal"),
    "theory.stability_proof": ("StabilityProof",),
}
_MODULE = {name: module for module, names in _HOME.items() for name in names}

__all__ = [*sorted(_MODULE), "catalogue"]


def __getattr__(name: str) -> Any:
    if name == "catalogue":
        return import_module(".model.catalogue", __name__)
    if name in _MODULE:
        return getattr(import_module("." + _MODULE[name], __name__), name)
    raise AttributeError(f"strainwave has no name {name!r}; dir(strainwave) lists what it has")


def __dir__() -> list[str]:
    return sorted([*__all__, "__version__"])
