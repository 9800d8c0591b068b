"""`response_family`: one response curve for each member of a family of systems, in threads.

Kernels release the interpreter's lock, so that threads share the work; every member takes the same harmonics.
"""

from concurrent.futures import ThreadPoolExecutor
from typing import Any

from numpy.typing import ArrayLike

from ...quantities import checked, numbers, positive_count, replace, shown
from ...results import Branch
from ..balance.rates import periodic
from .response import frequencies, response_curves


def response_family(
    system: Any,
    span: tuple[float, float],
    parameters: dict[str, ArrayLike],
    *,
    harmonics: int | None = None,
    points: int = 200,
    threads: int = 2,
) -> list[Branch]:
    """Follow the response curve of every member of a family.

    Parameters
    ----------
    system : Oscillator
        The system that all members are variants of.
    span : (float, float)
        Range of omega [rad/s].
    parameters : dict of str to (members,) array_like
        Path of a parameter to its values, one per member (SI units), as in ``{"law.alpha": alphas, "B": dampings}``.
    harmonics, points
        As in `frequency_response`.
    threads : int
        How many curves to follow at a time.

    Returns
    -------
    list of Branch
        In the order of the members; a curve that fails has its own status.

    Raises
    ------
    ValueError
        If the arrays have different lengths, there are none, or a path does not exist.
    """
    if not isinstance(parameters, dict) or not parameters:
        raise TypeError(f"parameters are {shown(parameters)}; they must be a dict of path to values of every member")
    values = {path: numbers(path, v) for path, v in parameters.items()}
    lengths = {len(v) for v in values.values()}
    if len(lengths) != 1:
        raise ValueError(f"the values of a family must be arrays of one length, not of lengths {sorted(lengths)}")
    positive_count("threads", threads)
    lo, hi = frequencies(span)
    columns = {path: v.tolist() for path, v in values.items()}
    system = periodic("response_family", checked(system))
    members = [checked(replace(system, {p: c[i] for p, c in columns.items()})) for i in range(lengths.pop())]
    if threads == 1:
        return response_curves(members, lo, hi, harmonics, 1, points)
    with ThreadPoolExecutor(threads) as pool:
        return response_curves(members, lo, hi, harmonics, 1, points, pool.map)
