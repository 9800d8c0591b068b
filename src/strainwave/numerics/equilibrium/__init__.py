"""Where a system rests: operating points, slow loading."""
