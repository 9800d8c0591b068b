"""`EnsembleMeasure`: what a sweep keeps of trajectories, a whole chunk of them side by side."""

import contextlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from ...compile.lanes import LANES
from ...numerics.ensemble.ensemble import ensemble
from ...numerics.ensemble.gpu import machine_of
from ...numerics.ensemble.lane_checks import LaneError
from ...numerics.ensemble.measures import Peak, Rms
from ...numerics.ensemble.request import lanes_of, method_of, spans, what_and_how
from ...numerics.ensemble.stepping import stepping_of
from ...results import Floats
from .layout import LARGEST


@dataclass(frozen=True)
class EnsembleMeasure:
    """A measure for `sweep`: an `ensemble` of the points of each chunk.

    Parameters
    ----------
    y0 : tuple of float
        States at the start of every trajectory.
    periods : int
        Periods of the base angle over which is measured.
    measures : tuple
        What is kept of every trajectory, as in `ensemble`.
    settle : int
        Periods before that.
    method : Dop8, Rk4, Dopri5 or None
        Integrator; None is that of `ensemble`.
    device : {"cpu", "gpu"}
        Where it runs, as in `ensemble`; results of both agree to rounding, so a store is that of one of them.
    """

    y0: tuple[float, ...]
    periods: int
    measures: tuple[Any, ...] = (Peak(), Rms())
    settle: int = 0
    method: Any = None
    device: str = "cpu"
    whole_chunks: ClassVar[bool] = True

    def check(self, system: Any) -> None:
        """Refuse what would fail at every point of a sweep over variants of `system` (TypeError, ValueError)."""
        with contextlib.suppress(LaneError):  # of this variant: those of the sweep are others
            lanes_of(system, {}, self.y0)
        spans(self.periods, self.settle)
        what_and_how(system, self.measures, self.method)
        machine_of(self.device, 1)

    def least_chunk(self, system: Any) -> int:
        """Fewest lanes that are worth a chunk.

        One block of adaptive steps; of fixed steps 32 blocks, since some are run again to estimate the error and
        lanes share a block with those of the same number of steps only; on a graphics processor as many as there are.
        """
        if self.device == "gpu":
            return LARGEST
        return int(stepping_of(method_of(system, self.method)).blocks) * LANES

    def __call__(self, system: Any, values: Mapping[str, Floats]) -> Any:
        """Measure the variants of `system` with these values (n,) by path; a dataset over the dimension "lane"."""
        chosen = {} if self.method is None else {"method": self.method}
        found = ensemble(
            system, dict(values), self.y0, periods=self.periods, settle=self.settle, measures=self.measures,
            threads=1, device=self.device, **chosen,
        )  # fmt: skip
        small = {"status": "int8", "period": "int8", "steps": "int32"}  # of many points, each byte counts
        return found.assign({name: found[name].astype(kind) for name, kind in small.items() if name in found})
