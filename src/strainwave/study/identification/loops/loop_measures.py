"""What a datasheet measures on a law: width of its loop, lost motion, backlash, from the closed form of one motion."""

import math

import numpy as np
from scipy.optimize import brentq

from ....results import Floats
from .loop_model import FULL, Path, Shape, torque, ways

SMALL_LOOP = 0.04  # of the rated torque
FARTHEST = 60


class Twisted:
    """A candidate law that is twisted slowly from torque to torque, from rest; offsets and start left out."""

    def __init__(self, shape: Shape, p: Floats) -> None:
        self.shape, self.given = shape, dict(zip(shape.names(), p.tolist(), strict=True))
        still = {"torsion_offset": 0.0, "torque_offset": 0.0, "start": 0.0}
        self.spring = shape._replace(n=0, free_beta=False)
        self.p = np.array([(self.given | still)[name] for name in self.spring.names()])
        self.x = self.a = 0.0

    def _at(self, x: float, direction: float) -> tuple[float, float]:
        """Torque [N*m] at a torsion that is reached in one direction, and the state there."""
        one = Path(np.zeros(1, np.int64), np.ones(1), np.zeros(1))
        value = float(torque(self.spring, self.p, one, np.array([x])).value[0])
        if not self.shape.n:
            return value, 0.0
        twist = self.given["yield_twist"]
        way = max(direction * (x - self.x), 0.0) / twist
        a = direction * float(ways(direction * self.a, way, self.shape.n, self.given.get("kappa", 0.0)))
        return value + self.given["K"] * twist * a, a

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
