"""A measured Bode plot: its numbers, and the fit of a drive to them."""
