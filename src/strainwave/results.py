"""What the verbs return: a status that is a sentence, and frozen results that print themselves and can be saved."""

import os
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from uuid import uuid4

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


class Status(Enum):
    """How a computation ended: the value is the sentence for the user, with its remedy. Truthy when all is well."""

    OK = "finished"
    DIVERGED = "the solution left every bound; check the sign of damping and stiffness, or start closer to equilibrium"
    TOO_MANY_STEPS = "the step limit was reached; ask for a shorter time, a larger tolerance or more steps"
    NO_CONVERGENCE = "the iteration did not converge; start closer to a solution or take more harmonics"
    INTERRUPTED = "interrupted by the user; what was finished is kept"

    def __bool__(self) -> bool:
        return self is Status.OK


class SolveError(RuntimeError):
    """A computation failed and the caller asked for an exception; the message says where, the value, and the remedy."""


@dataclass(frozen=True, eq=False)
class Trajectory:
    """A solution in time.

    Attributes
    ----------
    t : (n,) array
        Times [s].
    y : (states, n) array
        States; for an `Oscillator` x [rad] and x' [rad/s].
    rate : (states, n) array
        Time derivatives of the states at `t`.
    status : Status
        `Status.OK`, or why the solution ends before the last time asked for. All values are finite.
    message : str
        One sentence with the place where it ended.
    steps, rejected, switches : int
        Accepted steps, rejected steps, and crossings of a breakpoint of the law that were located.
    """

    t: Floats
    y: Floats
    rate: Floats
    status: Status
    message: str
    steps: int
    rejected: int
    switches: int

    def peak(self, component: int = 0, after: float = -np.inf) -> float:
        """Largest absolute value of a state, between the samples too (cubic Hermite interpolation).

        Parameters
        ----------
        component : int
            Which state; 0 is the dynamic error x.
        after : float
            Look at times t >= after [s] only.
        """
        use = self.t >= after
        t, x, v = self.t[use], self.y[component, use], self.rate[component, use]
        if len(t) == 0:
            raise ValueError(f"no sample at t >= {after} s; the trajectory ends at {self.t[-1]} s")
        best = float(np.max(np.abs(x)))
        if len(t) == 1:
            return best
        h = np.diff(t)
        dx = np.diff(x)
        # x(s) on [0, 1]: a s^3 + b s^2 + c s + x0
        c, d = v[:-1] * h, v[1:] * h
        a, b = c + d - 2.0 * dx, 3.0 * dx - 2.0 * c - d
        root = np.sqrt(np.maximum(b * b - 3.0 * a * c, 0.0))
        q = -(b + np.where(b >= 0.0, root, -root))
        for top, bottom in ((q, 3.0 * a), (c, q)):
            with np.errstate(over="ignore"):
                s = np.divide(top, bottom, out=np.zeros_like(top), where=bottom != 0.0)
            s = np.clip(s, 0.0, 1.0)
            best = max(best, float(np.max(np.abs(((a * s + b) * s + c) * s + x[:-1]))))
        return best

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write t and y as CSV (`.csv`) or NumPy (`.npz`); the file appears only when it is complete."""
        path = Path(path)
        if path.suffix == ".npz":
            with atomic(path) as part, open(part, "wb") as stream:
                np.savez(stream, t=self.t, y=self.y, rate=self.rate, status=self.status.name)
        elif path.suffix == ".csv":
            names = ["x_rad", "v_rad_per_s"] if len(self.y) == 2 else [f"y{i}" for i in range(len(self.y))]
            with atomic(path) as part:
                header = ",".join(["t_s", *names])
                np.savetxt(part, np.vstack([self.t, self.y]).T, delimiter=",", header=header, comments="", fmt="%.12g")
        else:
            raise ValueError(f"cannot save a trajectory as {path.name!r}; use a name that ends in .csv or .npz")
        return path

    def __str__(self) -> str:
        return (
            f"Trajectory: {len(self.t)} samples, t = {self.t[0]:.6g} .. {self.t[-1]:.6g} s\n"
            f"  largest |state|: {', '.join(f'{v:.6g}' for v in np.max(np.abs(self.y), axis=1))}\n"
            f"  {self.steps} steps, {self.rejected} rejected, {self.switches} switches\n"
            f"  status: {self.message}"
        )


class atomic:
    """Context manager: a temporary sibling of `path` that replaces it on success and vanishes on any error."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def __enter__(self) -> str:
        # Not tempfile: its files are readable by their owner alone, and so would be the result.
        self.part = self.path.with_name(f".{self.path.name}.{uuid4().hex}")
        return str(self.part)

    def __exit__(self, kind: object, value: object, trace: object) -> None:
        if kind is None:
            os.replace(self.part, self.path)
        else:
            self.part.unlink(missing_ok=True)
