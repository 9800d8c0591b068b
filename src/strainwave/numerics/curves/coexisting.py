"""Orbits that coexist at one frequency: those that a harmonic alone allows, corrected by harmonic balance.

A vibration of amplitude a under a force of amplitude D needs |k(a) - J w^2 + i B w| a = D, with the equivalent
stiffness k(a) of the law (describing function). Every root is a guess: inside a bistable band there are three.

Nayfeh & Mook 1979, Nonlinear Oscillations, sec. 4.1.1; Krack & Gross 2019, sec. 2.3 (one harmonic).
"""

from typing import Any

import numpy as np

from ...results import Floats
from ..balance.fourier import orders
from ..balance.guess import drive, linear_response, one_harmonic
from ..balance.second_order import SecondOrder
from .trace import solve

SIZES = np.geomspace(1e-4, 1.0, 40)  # amplitudes at which the law is asked, of the largest that the damping allows
FINE = np.geomspace(1e-4, 1.0, 313)  # and those between them
BETWEEN = np.array([np.interp(FINE, SIZES, row) for row in np.eye(len(SIZES))]).T
NEAR = 0.02  # relative distance to an orbit from which Newton's method goes to it
CLOSE = 1.5  # factor above a force within which it is looked at closely
LEAST = 1e-4  # damping that counts at least, of critical
MATTERS = 1e-3  # of the largest force: lines below it make no second orbit of their own


def new_orbits(problem: Any, some: list[Floats], known: list[Floats]) -> list[Floats]:
    """Orbits to which guesses lead, without the known ones; a guess next to a known orbit leads to it."""
    found: list[Floats] = []
    for guess in some:
        if any(same(guess, other, NEAR) for other in known):
            continue
        point = solve(problem, guess)
        if point is not None and not any(same(point, other) for other in [*known, *found]):
            found.append(point)
    return found


def same(a: Floats, b: Floats, tolerance: float = 1e-5) -> bool:
    """Whether two points of a branch at one value of the parameter are the same."""
    return float(np.linalg.norm(a - b)) <= tolerance * float(np.linalg.norm(b[:-1]))


def guesses(problem: Any, values: tuple[float, float]) -> dict[float, list[Floats]]:
    """Guesses for every orbit at some base frequencies, where a line of the excitation alone allows more than one."""
    found: dict[float, list[Floats]] = {value: [] for value in values}
    if not (isinstance(problem, SecondOrder) and problem.leaf == problem.omega_leaf):
        return found
    system, h = problem.system, len(problem.tau) // 2
    k = orders(h, problem.stride) / problem.turns
    w = np.concatenate([k * value for value in values])
    force = np.concatenate([drive(system, k * value, problem.tau, problem.error) for value in values])
    mass, loss, size = system.J * w * w, system.B * w, np.abs(force)
    lines = np.flatnonzero(size > MATTERS * size.max())
    if not len(lines):
        return found
    reach = size[lines] / np.maximum(loss, LEAST * mass)[lines]  # no vibration is larger
    top = float(reach.max())
    means, stiffness = one_harmonic(system.law, float(problem.tau[0]), top * SIZES)
    mass, loss, size, force = mass[lines, None], loss[lines, None], size[lines, None] / top, force[lines]
    pull = np.hypot(stiffness - mass, loss) * SIZES
    falls = pull[:, 1:] < np.minimum(pull[:, :-1], CLOSE * size)
    if not falls.any():  # one amplitude to each force
        return found
    bottom = BETWEEN @ stiffness - mass
    low = np.hypot(bottom, loss) * FINE < size
    changes = low[:, 1:] != low[:, :-1]
    for row in np.flatnonzero(changes.sum(axis=1) > 1).tolist():
        line = int(lines[row])
        value, i = values[line // h], line % h
        for place in np.flatnonzero(changes[row]).tolist():
            guess = linear_response(problem, value)
            response = force[row] / (bottom[row, place] + 1j * loss[row, 0])
            guess[0], guess[1 + i], guess[1 + h + i] = BETWEEN[place] @ means, response.real, -response.imag
            found[value].append(guess)
    return found
