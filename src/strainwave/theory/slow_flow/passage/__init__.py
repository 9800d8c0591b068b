"""Motions of a slow flow in time: passages through resonance at a finite rate, and basins."""
