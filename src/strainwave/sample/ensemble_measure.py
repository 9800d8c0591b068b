"""`EnsembleMeasure`: what a sweep keeps of trajectories, a whole chunk of them side by side."""

import contextlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from ..base.results import Floats
from ..compile.lanes import LANES
from ..numerics.ensemble.ensemble import ensemble
from ..numerics.ensemble.measures import Peak, Rms
from ..numerics.ensemble.request import LaneError, lanes_of, measures_and_method, method_of, spans
from ..numerics.ensemble.stepping import stepping_of


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
    """

    y0: tuple[float, ...]
    periods: int
    measures: tuple[Any, ...] = (Peak(), Rms())
    settle: int = 0
    method: Any = None
    whole_chunks: ClassVar[bool] = True

    def check(self, system: Any) -> None:
        """Refuse what would fail at every point of a sweep over variants of `system` (TypeError, ValueError)."""
        with contextlib.suppress(LaneError):  # of this variant: those of the sweep are others
            lanes_of(system, {}, self.y0)
        spans(self.periods, self.settle)
        measures_and_method(system, self.measures, self.method)

    def least_chunk(self, system: Any) -> int:
        """Fewest lanes that are worth a chunk.

        One block of adaptive steps; of fixed steps 32 blocks, since some are run again to estimate the error and
        lanes share a block with those of the same number of steps only.
        """
        return int(stepping_of(method_of(system, self.method)).blocks) * LANES

    def __call__(self, system: Any, values: Mapping[str, Floats]) -> Any:
        """Measure the variants of `system` with these values (n,) by path; a dataset over the dimension "lane"."""
        dataset = ensemble(
            system, dict(values), self.y0, periods=self.periods, settle=self.settle, measures=self.measures,
            threads=1, **{} if self.method is None else {"method": self.method},
        )  # fmt: skip
        small = {"status": "int8", "period": "int8", "steps": "int32"}  # of many points, each byte counts
        return dataset.assign({name: dataset[name].astype(kind) for name, kind in small.items() if name in dataset})
