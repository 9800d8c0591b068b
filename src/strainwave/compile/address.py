"""Memory of a model as words, so that a kernel is compiled once for all models of one kind.

The words are the numbers of a NamedTuple in memory: floats, integers, and arrays as address and shape, at any depth.
A kernel gets their address, and that of the function that takes them (`jit.entry`), as plain integers; `calls` has what
it does with both. Addresses are arguments and never constants: nothing on disk holds one.
"""

from collections.abc import Callable
from ctypes import addressof, c_char
from typing import Any

import numpy as np

from .tree import shown

RECENT_OBJECTS = 16  # objects whose words are kept for the next kernel
_recent: tuple[tuple["ByAddress", Any], ...] = ()


class ByAddress:
    """An argument of `jit.run` that machine code gets by address, and a kernel run as Python as it is.

    Parameters
    ----------
    thing : Any
        What a kernel run as Python gets.
    addressed : callable
        addressed(words): what machine code gets. `words(thing)` gives the address of the words of a model or of an
        array, which stay in memory as long as the result is used; of another `ByAddress` what machine code gets for it.
    cache_key : str
        Name under which the result is kept for the next kernels that get the same thing; "" keeps none.
    """

    def __init__(self, thing: Any, addressed: Callable[[Callable[[Any], Any]], Any], cache_key: str = "") -> None:
        self.thing, self.addressed, self.cache_key = thing, addressed, cache_key
        self.owners: list[Any] = []

    def native(self) -> Any:
        """Return the form for machine code; the memory that it needs is kept as long as this object."""
        global _recent
        for recent, made in _recent:
            if self.cache_key and recent.thing is self.thing and recent.cache_key == self.cache_key:
                self.owners.append(recent)
                return made
        made = self.addressed(self._address)
        if self.cache_key:
            _recent = (self, made), *_recent[: RECENT_OBJECTS - 1]
        return made

    def _address(self, thing: Any) -> Any:
        """Address of the words of a thing, whose memory this object keeps."""
        if isinstance(thing, ByAddress):
            self.owners.append(thing)
            return thing.native()
        memory = thing if isinstance(thing, np.ndarray) else words_of(thing)
        self.owners.append((thing, memory))
        return address_of(memory)


def kind_of(thing: Any) -> Any:
    """Key of what words do not tell: the classes of models, lengths of tuples, types of numbers and arrays."""
    kind = type(thing)
    if kind is float or kind is int:
        return kind
    if isinstance(thing, tuple):
        return kind, *map(kind_of, thing)
    return (thing.dtype.str, thing.ndim) if kind is np.ndarray else kind


def address_of(array: Any) -> int:
    """Address of the first entry of a contiguous array."""
    try:
        return addressof(c_char.from_buffer(array))
    except (TypeError, ValueError):  # read-only, or empty: four times as slow
        return int(array.__array_interface__["data"][0])


def words_of(thing: Any) -> Any:
    """Words (int64) of a model, an array or a tuple; its arrays are not copied: they must be contiguous and outlive it.

    Raises
    ------
    TypeError
        If it holds what is no number, array or model.
    """
    items: list[Any] = []
    _collect(thing, items)
    words = np.zeros(len(items) + 1, np.int64)
    whole, floats = words.data, words.view(np.float64).data
    for i, item in enumerate(items):
        try:
            kind = floats if isinstance(item, (float, np.floating)) else whole
            kind[i] = int(item) if isinstance(item, np.bool_) else item
        except (TypeError, ValueError):
            raise TypeError(
                f"a model holds {shown(item)}, and compiled code takes floats, whole numbers up to 2^63, tuples, "
                "models and arrays; give it as one of these, or set STRAINWAVE_JIT=0"
            ) from None
    return words


def word_of_leaf(thing: Any, leaf: int) -> int:
    """Place of a leaf of a model among its words."""
    items: list[Any] = []
    _collect(thing, items)
    return [i for i, item in enumerate(items) if isinstance(item, (float, np.floating))][leaf]


def _collect(thing: Any, items: list[Any]) -> None:
    if isinstance(thing, tuple):
        for item in thing:
            _collect(item, items)
    elif isinstance(thing, np.ndarray):
        if not thing.flags.c_contiguous:
            raise TypeError(
                f"a model holds an array of shape {thing.shape} whose numbers do not follow each other in memory, "
                "which compiled code does not take; give np.ascontiguousarray of it, or set STRAINWAVE_JIT=0"
            )
        items += [address_of(thing), *thing.shape]
    elif thing is not None:
        items.append(thing)
