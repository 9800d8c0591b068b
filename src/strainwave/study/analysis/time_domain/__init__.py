"""A drive in time: checks of its response curve, single speeds, and motions at one speed."""
