"""Torsion laws: springs, backlash, hysteresis and friction, tables of measured values."""

from .springs import Backlash as Backlash
from .springs import Cubic as Cubic
from .springs import Linear as Linear
from .springs import PiecewiseLinear as PiecewiseLinear
from .springs import Play as Play
from .springs import Polynomial as Polynomial
from .measured import Knot as Knot
from .rounded import RoundedPiecewiseLinear as RoundedPiecewiseLinear
from .measured import Tabulated as Tabulated
from .measured import tabulated as tabulated
from .hysteresis import BoucWen as BoucWen
from .hysteresis import Parallel as Parallel
from .friction import ContactDamping as ContactDamping
from .friction import Coulomb as Coulomb
from .friction import LuGre as LuGre
from .friction import QuadraticDamping as QuadraticDamping
from .friction import Stribeck as Stribeck
from .friction import Viscous as Viscous
from .friction import LoadFriction as LoadFriction
