"""Gears: the catalogue with its sources, fits of laws, limits, spectra of the kinematic error."""

from . import catalogue as catalogue
from .error_spectrum import accuracy_spectrum as accuracy_spectrum
from .error_spectrum import MEASURED_ERRORS as MEASURED_ERRORS
from .error_spectrum import MeasuredError as MeasuredError
from .error_spectrum import peak_to_peak as peak_to_peak
from .fits import fit_odd as fit_odd
from .fits import LawFit as LawFit
from .limits import check_limits as check_limits
from .limits import cubic_mean as cubic_mean
from .limits import Finding as Finding
from .gear import load_friction as load_friction
from .gear import no_load_drag as no_load_drag
from .life import bearing_life as bearing_life
from ..orders import Arrangement as Arrangement
from ..orders import GearOrder as GearOrder
from ..orders import OrderMap as OrderMap
from ..orders import on_output_turn as on_output_turn
from ..orders import order_map as order_map
from ..orders import Source as Source
from ..orders import static_sources as static_sources
from ..oscillator import GearDamping as GearDamping
from ..oscillator import NoVariation as NoVariation
from ..oscillator import Ripple as Ripple
from ..oscillator import Variation as Variation
from ..oscillator import VaryingOscillator as VaryingOscillator
from ..drive import HDC_40_050_WARNING as HDC_40_050_WARNING
