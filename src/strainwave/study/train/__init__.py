"""Bode plot, runs, operating point, reductions of a drive train."""
