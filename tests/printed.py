"""Printed text compared as what it says: words as words, numbers to their last printed digit.

The last digits of a computed number depend on the processor: on its vector units, and on the kernels of BLAS for it.
"""

import re
from decimal import Decimal
from itertools import zip_longest

NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")


def same(one, other):
    """Whether two texts say the same: numbers within one unit of the last digit, integers and words exactly.

    Blanks in a row count as one, as numbers of other lengths move them. Where formats drop zeros at the end ("0.06" for
    0.0600), the longer of two numbers says what the last digit is.
    """
    if one == other:
        return True
    words = [re.sub(r" +", " ", NUMBER.sub("#", text)) for text in (one, other)]
    numbers = [NUMBER.findall(text) for text in (one, other)]
    return words[0] == words[1] and all(map(close, *numbers))


def close(one, other):
    """Whether two printed numbers differ by no more than a unit of the last digit."""
    if one.lstrip("+-").isdigit() and other.lstrip("+-").isdigit():
        return int(one) == int(other)
    a, b = Decimal(one), Decimal(other)
    unit = min(a.as_tuple().exponent, b.as_tuple().exponent)
    return abs(a - b) <= Decimal(1).scaleb(unit)


def says(text, fact):
    """Whether a text holds a fact: words with numbers."""
    pattern = NUMBER.pattern.join(map(re.escape, NUMBER.split(fact)))
    return any(same(place, fact) for place in re.findall(pattern, text))


def differences(said, printed):
    """Lines that do not say the same, in pairs."""
    pairs = zip_longest(said.rstrip().splitlines(), printed.rstrip().splitlines(), fillvalue="")
    return [pair for pair in pairs if not same(*pair)]
