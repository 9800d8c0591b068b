"""What would make the error smaller: what can be turned, other gears, and the peak computed again for each."""

from .knobs import Subject as Subject
from .remedies import Remedy as Remedy
from .remedies import remedies as remedies
from .remedies import what_helps as what_helps
from .remedies import with_other_damping as with_other_damping
