"""The error equation and its multiple scales, derived by SymPy: only this package knows it.

SymPy is an optional extra; `sp` is None without it.
"""

try:
    import sympy as sp
except ImportError:
    sp = None

__all__ = ["sp"]
