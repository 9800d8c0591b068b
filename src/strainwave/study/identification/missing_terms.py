"""Terms that the law of an identified system may lack, and what each would change of the outputs."""

from typing import Any, NamedTuple

import numpy as np

from ...base.quantities import Ratio
from ...base.results import Floats
from ...model.laws.friction import Coulomb, QuadraticDamping
from ...model.laws.hysteresis import Parallel
from ...model.laws.springs import Polynomial
from .lane_march import lanes_of
from .window_fit import EFFECT, LeastSquares, Point

TERMS = ("x^2", "x^3", "x^5", "|v| v", "v^3", "sign v")
SIGN_WIDTH = 0.02  # of the rate's size: over which the dry friction that is looked for changes its sign


class CubicDamping(NamedTuple):
    """Torque c v^3."""

    c: Ratio

    def torque(self, _x: Any, v: Any) -> Any:
        """Torque at the rate v."""
        return self.c * v * v * v

    def stiffness(self, x: Any) -> Any:
        """No stiffness: 0."""
        return 0.0 * x


def term_columns(problem: LeastSquares, point: Point) -> dict[str, Floats]:
    """Derivative of the residuals (n,) by each term, the starts taken out; none without a law on top."""
    system = problem.experiment.driven
    if not hasattr(system, "law"):
        return {}
    first = problem.windows[0].record
    sizes = problem.sizes(first)
    x, v = float(sizes[0]), float(sizes[min(1, len(sizes) - 1)])
    stiffness = float(system.law.stiffness(x)) if hasattr(system.law, "stiffness") else 0.0
    torque, width = abs(stiffness) * x or 1.0, SIGN_WIDTH * v
    amounts = [torque / x**2, torque / x**3, torque / x**5, torque / (v * v), torque / v**3, torque]
    model = problem.experiment.model(point.values, first.step, problem.parts, problem.experiment.delays(point.values))

    def with_terms(on: int) -> Any:
        c = [EFFECT * amount if i == on else 0.0 for i, amount in enumerate(amounts)]
        springs = Polynomial((0.0, 0.0, c[0], c[1], 0.0, c[2]))
        drags = Parallel(QuadraticDamping(c[3]), Parallel(CubicDamping(c[4]), Coulomb(c[5], width)))
        return model._replace(law=Parallel(model.law, Parallel(springs, drags)))

    lanes = lanes_of([with_terms(i) for i in (-1, *range(len(amounts)))])
    columns: list[list[Floats]] = [[] for _ in TERMS]
    for w, start, by_start in zip(problem.windows, point.starts, point.by_start, strict=True):
        for i, column in enumerate(problem.differences(w, point.values, lanes, start, by_start).T):
            columns[i].append(column / EFFECT)
    stacked = {name: np.concatenate(parts) for name, parts in zip(TERMS, columns, strict=True)}
    return {name: column for name, column in stacked.items() if np.all(np.isfinite(column)) and np.any(column)}
