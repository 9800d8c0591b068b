"""A free decay: its windows, its computation by averaging, and the fit."""
