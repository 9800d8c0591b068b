"""Harmonic balance of systems that are linear around a few laws, in the twists that these laws see."""
