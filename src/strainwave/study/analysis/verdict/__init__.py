"""Whether a drive is all right at its speeds and, if not, the smallest change that cures it."""

from .smallest import smallest_change as smallest_change
from .verdict import Answer as Answer
from .verdict import Judged as Judged
from .verdict import Verdict as Verdict
from .verdict import judged as judged
from .verdict import verdict_of as verdict_of
