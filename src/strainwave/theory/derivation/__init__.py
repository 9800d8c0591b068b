"""Derivations by SymPy: the error equation, and the second order of multiple scales."""
