"""Where motions end: attractors, basins, sections, exponents."""
