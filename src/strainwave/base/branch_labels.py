"""Labels of the points of a branch, outcomes of its continuation, and the multiplier below which an orbit is stable."""

START, STEP, FOLD, TOP, BOUND = range(5)  # what the next correction is for, and the label of the point it gives
DOUBLING, BRANCH_POINT, NEIMARK_SACKER = 5, 6, 7  # labels of points that are found afterwards
# Outcome: full buffer, left the range, closed loop, step too small, no start, grown beyond all bounds.
RUNNING, END, CLOSED, STUCK, LOST, UNBOUNDED = range(6)
DECAYS = 1.0 - 1e-10  # a Floquet multiplier below it: that of a neutral orbit is 1 but for rounding
