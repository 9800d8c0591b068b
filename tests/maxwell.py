"""A user's law with memory whose answers have closed forms: a spring beside a spring and a dashpot."""

from typing import NamedTuple


class Maxwell(NamedTuple):
    """A spring K beside a spring G in series with a dashpot, whose torque z relaxes in the time r."""

    K: float
    G: float
    r: float
    states = 1

    def torque(self, x, v, z):
        return self.K * x + z[0]

    def z_rate(self, x, v, z):
        return (self.G * v - z[0] / self.r,)

    def stiffness(self, x):
        return self.K + self.G + 0.0 * x

    def spring_stiffness(self, x):
        return self.K + 0.0 * x
