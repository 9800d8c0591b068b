"""Harmonic balance: the equations of one periodic motion."""
