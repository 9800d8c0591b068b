"""Exact steps of a linear system whose input is held from sample to sample, and comes late."""

from math import ceil, log2

import numpy as np

from ...base.results import Floats

JUST = 1e-9  # of a period: rounding of a delay
TERMS, SMALLER = 12, 3  # of the series of an exponential, of a matrix below 2^-3


def held(A: Floats, B: Floats, period: float, delay: float) -> tuple[Floats, Floats]:
    """Matrices from sample to sample of x' = A x + B u, u held over a period and late by the delay.

    The states are x and the torques of the samples before that do not act yet or still act, the latest first.
    """
    T, n = period, len(A)
    whole = int(delay / T + JUST)
    part = max(delay / T - whole, 0.0)
    part = part if part > JUST else 0.0
    before = whole + (part > 0.0)
    matrix = np.zeros((n + 1, n + 1))
    matrix[:n, :n], matrix[:n, n] = A, B
    late, now = exponential(part * T * matrix), exponential((1.0 - part) * T * matrix)
    F, g = np.zeros((n + before, n + before)), np.zeros(n + before)
    F[:n, :n] = now[:n, :n] @ late[:n, :n]
    if part:
        F[:n, n + whole] = now[:n, :n] @ late[:n, n]
    if whole:
        F[:n, n + whole - 1] += now[:n, n]
    else:
        g[:n] = now[:n, n]
    if before:
        g[n] = 1.0
        F[n + 1 :, n:-1] = np.eye(before - 1)
    return F, g


def exponential(matrix: Floats) -> Floats:
    """Exponential of a matrix: scaling, series and squaring."""
    size = float(np.max(np.sum(np.abs(matrix), axis=0), initial=0.0))
    squarings = max(0, ceil(log2(size)) + SMALLER) if size else 0
    term = result = np.eye(len(matrix))
    for k in range(1, TERMS + 1):
        term = term @ matrix / (k * 2.0**squarings)
        result = result + term
    for _ in range(squarings):
        result = result @ result
    return result
