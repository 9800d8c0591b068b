"""The drive train: shafts, couplings, motor, motions."""
