"""Hysteresis, energy, parametric resonance of a gear."""
