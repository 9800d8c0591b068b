"""What a datasheet measures on a law: width of its loop, lost motion, backlash, from the closed form of one motion."""

import math

from scipy.optimize import brentq

from ....results import Floats
from .loop_model import FULL, Shape, way_of_one

SMALL_LOOP = 0.04  # of the rated torque
FARTHEST = 60


class Twisted:
    """A candidate law that is twisted slowly from torque to torque, from rest; offsets and start left out."""

    def __init__(self, shape: Shape, p: Floats) -> None:
        self.shape, self.given = shape, dict(zip(shape.names(), p.tolist(), strict=True))
        self.x = self.a = 0.0

    def _at(self, x: float, direction: float) -> tuple[float, float]:
        """Torque [N*m] at a torsion that is reached in one direction, and the state there."""
        value = self._spring(x)
        if not self.shape.n:
            return value, 0.0
        twist = self.given["yield_twist"]
        way = max(direction * (x - self.x), 0.0) / twist
        a = direction * way_of_one(direction * self.a, way, self.shape.n, self.given.get("kappa", 0.0))
        return value + self.given["K"] * twist * a, a

    def _spring(self, x: float) -> float:
        p = self.given
        way = max(abs(x) - p.get("half_gap", 0.0), 0.0)
        x1, x2 = p.get("x1", math.inf), p.get("x2", math.inf)
        value = p["K1"] * min(way, x1)
        if way > x1:
            value += p["K2"] * (min(way, x2) - x1)
        if way > x2:
            value += p["K3"] * (way - x2)
        return math.copysign(value, x)

    def to(self, target: float, direction: float, *, stay: bool = True) -> float:
        """Torsion [rad] at which the torque [N*m] is the target, in one direction; the law stays there if wanted."""

        def missing(way: float) -> float:
            return direction * (self._at(self.x + direction * way, direction)[0] - target)

        if missing(0.0) >= 0.0:
            return self.x
        far = abs(target) / self.given["K1"] + abs(self.x) + 1e-12
        for _ in range(FARTHEST):
            if missing(far) > 0.0:
                break
            far *= 2.0
        x = self.x + direction * float(brentq(missing, 0.0, far, xtol=1e-15, rtol=1e-13))
        if stay:
            a = self._at(x, direction)[1]
            self.x, self.a = x, math.copysign(min(abs(a), FULL), a)
        return x


def loop_sizes(shape: Shape, p: Floats, full: float) -> tuple[float, float]:
    """Width [rad] at no torque and from end to end of the loop 0 -> +full -> -full -> +full [N*m]."""
    law = Twisted(shape, p)
    law.to(full, 1.0)
    first = law.to(0.0, -1.0, stay=False)
    low = law.to(-full, -1.0)
    second = law.to(0.0, 1.0, stay=False)
    return first - second, law.to(full, 1.0) - low


def hysteresis_loss(shape: Shape, p: Floats, full: float) -> float:
    """Hysteresis loss [rad]: width of the loop at no torque after a full load [N*m]."""
    return loop_sizes(shape, p, full)[0]


def lost_motion(shape: Shape, p: Floats, rated: float) -> float:
    """Lost motion [rad]: torsion between the ends of the loop at +-4 % of the rated torque [N*m]."""
    return loop_sizes(shape, p, SMALL_LOOP * rated)[1]
