"""Whether a drive is all right at its speeds and, if not, the smallest change that cures it."""

from .one_curve import Judged as Judged
from .one_curve import judged as judged
from .smallest import smallest_change as smallest_change
from .verdict import Answer as Answer
from .verdict import Verdict as Verdict
from .verdict import verdict_of as verdict_of
