"""The laws of a condensed problem, each with its own block of unknowns: the twist that it sees."""

from typing import Any, NamedTuple

import numpy as np

from ....results import Floats
from ..linear_algebra import extremes, padded, row_times
from ..piecewise import crossings_for, is_piecewise_linear
from ..sampling import Sampling


class NoSpring(NamedTuple):
    """The end of a chain of springs."""

    def torques(self, size: int, z: Any, synthesis: Any, r: Any) -> None:
        """No torque."""

    def stiffnesses(self, size: int, jacobian: Any) -> None:
        """No stiffness."""


NO_SPRING = NoSpring()


class Spring(NamedTuple):
    """A law with its torque in the balance (`Crossings` or `Sampling`), the samples of its twist, and the next one."""

    law: Any
    nonlinear: Any
    samples: Floats
    rest: Any

    def torques(self, size: int, z: Any, synthesis: Any, r: Any) -> None:
        """Write the coefficients of the torques to r, block by block, from those of the twists in z."""
        row_times(z[: size + 1], synthesis, self.samples)
        self.nonlinear.torque_series(self.law, z[: size + 1], self.samples, r[:size])
        self.rest.torques(size, z[size:], synthesis, r[size:])

    def stiffnesses(self, size: int, jacobian: Any) -> None:
        """Write their derivatives to the blocks on the diagonal; follows `torques` at the same twists."""
        self.nonlinear.stiffness_product(self.law, self.samples, jacobian[:size, :size])
        self.rest.stiffnesses(size, jacobian[size:, size:])

    def slack(self) -> float:
        """Middle [rad] of an orbit of the first law in its play, where any mean is in balance; 0 in contact."""
        return float(self.nonlinear.slack(self.law, self.samples))

    def ends(self) -> Any:
        """Places of the samples with the smallest and the largest twist of the first law."""
        return extremes(self.samples)


def springs_for(laws: tuple[Any, ...], harmonics: int, samples: int, back: Floats, double: Floats) -> Any:
    """Chain of the laws with their buffers; `back` and `double` are tables of the samples' analysis."""
    chain: Any = NO_SPRING
    for law in reversed(laws):
        nonlinear: Any
        if is_piecewise_linear(law):
            nonlinear = crossings_for(harmonics)
        else:
            wide = np.empty(4 * harmonics + 1), np.empty(4 * harmonics + 1), np.empty(4 * harmonics + 1)
            nonlinear = Sampling(padded(back), padded(double), np.empty(samples), *wide, 1)
        chain = Spring(law, nonlinear, np.empty(samples), chain)
    return chain
