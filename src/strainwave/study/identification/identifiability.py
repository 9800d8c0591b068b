"""Which parameters data do not tell, and what they tell instead."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from ...results import Floats
from ...sentences import listed

TOLERANCE = 1e-6  # of the largest singular value, columns of length 1; differences have errors of about 1e-8
SMALL = 1e-3  # of the largest entry: a parameter that does not take part
EQUAL = 0.02  # how well relative changes are known to be equal


def unidentifiable(
    jacobian: Floats, names: Sequence[str], values: ArrayLike | None = None, *, tolerance: float = TOLERANCE
) -> str | None:
    """Name the combination of parameters that data do not tell.

    Parameters
    ----------
    jacobian : (n, p) array
        Derivatives of the residual by the parameters.
    names : sequence of str
        Names of the p parameters.
    values : (p,) array_like, optional
        Their values: changes are then told relative to them, and a common factor is known as one. Values of 0 and
        none: in units of the parameters.
    tolerance : float
        Singular value, of columns of length 1 and the largest, up to which there is none.

    Returns
    -------
    str or None
        One sentence, or None where the data tell every parameter.
    """
    table = np.asarray(jacobian, float)
    scale = np.ones(len(names)) if values is None else np.abs(np.asarray(values, float))
    scale = np.where(scale > 0.0, scale, 1.0)
    sizes = np.linalg.norm(table, axis=0)
    idle = [name for name, size in zip(names, sizes, strict=True) if not size > 0.0]
    if idle:
        is_are = "it changes" if len(idle) == 1 else "they change"
        return f"the data do not tell {listed(idle)}: {is_are} nothing at these points; fix it or excite it"
    _, singular, right = np.linalg.svd(table / sizes, full_matrices=False)
    lost = right[singular <= tolerance * singular[0]]
    if not len(lost):
        return None
    change = _simplest(lost / (sizes * scale))
    part = np.abs(change) > SMALL * np.max(np.abs(change))
    found = [name for name, on in zip(names, part, strict=True) if on]
    sizes_of_change = change[part] * np.sign(change[part][0])
    if values is not None and np.all(np.abs(sizes_of_change / sizes_of_change[0] - 1.0) < EQUAL):
        return (
            f"the data tell {listed(found)} up to a common factor only: their ratios are identifiable; fix one of them"
        )
    largest = np.max(np.abs(sizes_of_change))
    unit = " %" if values is not None else ""
    changes = [f"{name} by {value / largest:+.3g}{unit}" for name, value in zip(found, sizes_of_change, strict=True)]
    return f"the data do not tell {listed(found)} apart: changing {listed(changes)} changes nothing; fix one of them"


def _simplest(lost: Floats) -> Floats:
    """A change (p,) among those that are lost (k, p) with as few parameters as elimination leaves."""
    rows = lost / np.max(np.abs(lost), axis=1, keepdims=True)
    for i in range(len(rows)):
        at = int(np.argmax(np.abs(rows[i])))
        rows[i] /= rows[i, at]
        for j in range(len(rows)):
            if j != i:
                rows[j] -= rows[j, at] * rows[i]
    return np.asarray(min(rows, key=lambda row: int(np.sum(np.abs(row) > SMALL * np.max(np.abs(row))))))
