"""Numbers of a model as the fields of a struct in C, which a user of the code changes without exporting again.

The floats of a model are recorded by name. One that decides a branch (a comparison in `if`, a function of the module
math) is fixed: it stands in the code as it is. So do integers. What the code does not use is no field.
"""

import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeVar

from ...quantities import parameters
from ...tree import mapped
from .c_code import RESERVED, struct
from .traced import Decided, Recording, literal

T = TypeVar("T")


@dataclass(frozen=True)
class Parameters:
    """The floats of a model by their names in C.

    Attributes
    ----------
    model : NamedTuple
        Holds the exported values.
    fixed : frozenset of str
        Names of those that stay numbers.
    """

    model: Any
    fixed: frozenset[str] = frozenset()

    def recorded(self, recording: Recording) -> Any:
        """Return the model with recorded parameters in the place of its floats."""
        names = iter(_names(self.model))

        def of(value: Any) -> Any:
            if not isinstance(value, float):
                return value
            name = next(names)
            return value if name in self.fixed else recording.parameter(name)

        return mapped(of, self.model)

    def struct(self, name: str, bodies: list[str]) -> tuple[list[str], list[str]]:
        """Type of the struct and its instance with the exported values, of those that bodies of functions use."""
        used = set(re.findall(r"p->(\w+)", "\n".join(bodies)))
        floats = [(path, value, unit) for path, value, unit in parameters(self.model) if isinstance(value, float)]
        kept = [(field, *rest) for field, rest in zip(_names(self.model), floats, strict=True) if field in used]
        kept = kept or [("none", "no number can change", 0.0, "")]
        declared = struct(
            f"{name}_parameters", [k[0] for k in kept], [f"{path} [{u or '-'}]" for _, path, _, u in kept]
        )
        values = [f"    .{field} = {literal(value)}," for field, _, value, _ in kept]
        return declared, [f"const {name}_parameters {name}_default = {{", *values, "};"]


def with_parameters(model: Any, record: Callable[[Parameters], T]) -> T:
    """What a function records of the parameters of a model, with those fixed that decide a branch."""
    known = Parameters(model)
    while True:
        try:
            return record(known)
        except Decided as decided:
            known = Parameters(model, known.fixed | decided.names)


def _names(model: Any) -> list[str]:
    """Names in C of the floats of a model: their paths with underscores, made different where these are equal."""
    found: dict[str, None] = {}
    for i, (path, value, _) in enumerate(parameters(model)):
        if isinstance(value, float):
            name = path.replace(".", "_")
            known = re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", name) and name not in RESERVED and name not in found
            found[name if known else f"parameter_{i}"] = None
    return list(found)
