"""Many drives once: how they vary, one store, and what is made of the results."""

from ..files.variants.comparison import compare as compare
from ..files.variants.project_sweep import largest as largest
from ..files.variants.scatter import exceedance as exceedance
from ..files.variants.scatter import scattered as scattered
from .ensemble_measure import EnsembleMeasure as EnsembleMeasure
from .sampling import LatinHypercube as LatinHypercube
from .sampling import LogUniform as LogUniform
from .sampling import Normal as Normal
from .sampling import Sobol as Sobol
from .sampling import Uniform as Uniform
from .sweeping import sweep as sweep

__all__: list[str]
