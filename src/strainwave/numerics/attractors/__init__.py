"""Ends of motions: attractors, basins, sections, exponents."""
