"""Sentences that carry their values: in SI for users of the library, in the units of its face for readers of a report.

A face renders a sentence once, from the values; nothing reads numbers out of finished text.
"""

from collections.abc import Callable, Iterable
from typing import Any

from .number_text import rounded

AT_MOTOR = " at the motor"  # shaft of a speed in a text


class Quantity:
    """Values of one kind in a sentence, written between words; without values its unit alone.

    Parameters
    ----------
    values : float
        In SI.
    digits : int
        Significant digits in SI; a face may write fewer.
    between : str
        Text between two values.
    bare : bool
        True to leave the unit out.
    ways : tuple of int
        Rounding of each value, down (-1) or up (1); default: to the nearest.
    """

    unit = ""

    def __init__(
        self, *values: float, digits: int = 6, between: str = " and ", bare: bool = False, ways: tuple[int, ...] = ()
    ) -> None:
        self.ways = ways or (0,) * len(values)
        self.values, self.digits, self.between, self.bare = tuple(map(float, values)), digits, between, bare

    def written(self, number: Callable[[float, int], str], unit: str) -> str:
        """Write the values with a function of one of them and its way to round, and a unit."""
        text = self.between.join(map(number, self.values, self.ways))
        return text if self.bare else f"{text} {unit}".lstrip()

    def __add__(self, other: str) -> "Sentence":
        return Sentence("{}{}", self, other)

    def __radd__(self, other: str) -> "Sentence":
        return Sentence("{}{}", other, self)

    def __str__(self) -> str:
        return self.written(lambda value, side: f"{rounded(value, self.digits, side):.{self.digits}g}", self.unit)


class Speed(Quantity):
    """Speeds of the base angle [rad/s]."""

    unit = "rad/s"


class Angle(Quantity):
    """Angles of the output side [rad]."""

    unit = "rad"


class Sentence(str):
    """Text in SI that keeps the values it is made of: Sentence("jumps at {} and {}", Speed(155.0), Speed(168.0))."""

    parts: tuple[Any, ...]

    def __new__(cls, text: str = "", *values: Any) -> "Sentence":
        """Fill each {} of a text with a quantity, another sentence, or what is written as `str` writes it.

        Texts and quantities can also be added: "jumps at " + Speed(155.0).
        """
        parts: list[Any] = []
        for words, value in zip(text.split("{}") if values else [text], [*values, ""], strict=True):
            item = value if isinstance(value, Quantity) else str(value)
            parts += [words, *(item.parts if isinstance(item, Sentence) else [item])]
        self = super().__new__(cls, "".join(map(str, parts)))
        self.parts = tuple(part for part in parts if part != "")
        return self

    def __getnewargs__(self) -> tuple[Any, ...]:
        return "{}" * len(self.parts), *self.parts  # between processes

    def __str__(self) -> str:
        return self  # str(error) keeps the values of an error's sentence

    def __add__(self, other: str) -> "Sentence":
        return Sentence("{}{}", self, other)

    def __radd__(self, other: str) -> "Sentence":
        return Sentence("{}{}", other, self)

    def join(self, parts: Iterable[str]) -> "Sentence":
        """Join sentences with this one between them."""
        some = [piece for part in parts for piece in (self, part)][1:]
        return Sentence("{}" * len(some), *some)

    def told(self, written: Callable[[Quantity], str]) -> str:
        """Render the sentence with a function that writes a quantity; the shaft of its speeds is named once.

        A speed in a user's unit is not called omega.
        """
        pairs = zip(self.parts, (*self.parts, "")[1:], strict=True)
        text = "".join(
            (part.removesuffix("omega = ") if isinstance(after, Speed) else part)
            if isinstance(part, str) else written(part)
            for part, after in pairs
        )  # fmt: skip
        first, shaft, others = text.partition(AT_MOTOR)
        return first + shaft + others.replace(AT_MOTOR, "")


def listed(parts: Iterable[str], between: str = " and ") -> Sentence:
    """Join sentences as "a, b and c"."""
    some = list(parts)
    return Sentence(between).join([Sentence(", ").join(some[:-1]), some[-1]] if len(some) > 1 else some)


def told(data: object, written: Callable[[Quantity], str]) -> Any:
    """Plain data (dictionaries, lists, tuples) with every sentence in it rendered."""
    if isinstance(data, Sentence):
        return data.told(written)
    if isinstance(data, dict):
        return {key: told(item, written) for key, item in data.items()}
    if isinstance(data, list | tuple):
        return [told(item, written) for item in data]
    return data
