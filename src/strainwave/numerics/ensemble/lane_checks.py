"""Which lanes of an ensemble have parameters that no single system may have, without a look at every lane."""

from collections.abc import Mapping
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...base.quantities import checked, replace
from ...base.results import Floats


class LaneError(ValueError):
    """Some lanes of an ensemble cannot be computed: `lanes` (n,) says which, `reason` why the first of them cannot."""

    def __init__(self, reason: str, lanes: NDArray[np.bool_]) -> None:
        super().__init__(f"lane {int(np.argmax(lanes))}: {reason}")
        self.reason, self.lanes = reason, lanes

    def __reduce__(self) -> Any:
        return LaneError, (self.reason, self.lanes)  # between processes


def check_lanes(system: Any, varied: Mapping[str, Floats]) -> None:
    """Raise a LaneError if `checked` refuses the variant of a lane, with the sentence for the first of them.

    Given the others, the values of a parameter that a model allows are an interval, or all but 0. Where the corners of
    the box of all values are allowed (with 0, where that lies inside), all lanes are; else the box is halved.
    """
    if not varied:
        return
    table = np.array(list(varied.values()))
    refused = np.zeros(table.shape[1], bool)
    width = None
    waiting = [np.arange(table.shape[1])]
    while waiting:
        lanes = waiting.pop()
        part = table if width is None else table[:, lanes]
        low, high = part.min(axis=1), part.max(axis=1)
        width = np.maximum(high - low, 1e-300) if width is None else width
        sides = [
            sorted({a, b, 0.0} if a < 0.0 < b else {a, b}) for a, b in zip(low.tolist(), high.tolist(), strict=True)
        ]
        corners = int(np.prod([len(side) for side in sides], dtype=float))
        if corners == 1:
            refused[lanes] = bool(_refusal(system, varied, part[:, 0]))
        elif len(lanes) <= corners:
            refused[lanes] = [bool(_refusal(system, varied, values)) for values in part.T]
        elif any(_refusal(system, varied, corner) for corner in product(*sides)):
            widest = int(np.argmax((high - low) / width))
            below = part[widest] <= 0.5 * (low[widest] + high[widest])
            waiting += [lanes[~below], lanes[below]]
    if refused.any():
        raise LaneError(_refusal(system, varied, table[:, int(np.argmax(refused))]), refused)


def _refusal(system: Any, varied: Mapping[str, Floats], values: Any) -> str:
    """Return what `checked` says against the variant with these values, "" if nothing."""
    try:
        checked(replace(system, {path: float(value) for path, value in zip(varied, values, strict=True)}))
    except (TypeError, ValueError) as error:
        return str(error)
    return ""
