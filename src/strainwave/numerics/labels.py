"""Labels of the points of a branch, and how the continuation of one ends."""

START, STEP, FOLD, TOP, BOUND = range(5)  # what the next correction is for, and the label of the point it gives
DOUBLING, BRANCH_POINT, NEIMARK_SACKER = 5, 6, 7  # labels of points that are found afterwards
# Outcome: full buffer, left the range, closed loop, step too small, no start, grown beyond all bounds.
RUNNING, END, CLOSED, STUCK, LOST, UNBOUNDED = range(6)
