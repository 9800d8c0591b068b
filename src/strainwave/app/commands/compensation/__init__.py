"""`strainwave compensate` and its output."""
