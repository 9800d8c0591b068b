"""A log of an axis that SciPy made from equations written by hand, and its project file.

A motor with a position loop turns an SHG-25-100 (three slopes) with a rigid load that gravity pulls at; one line of
kinematic error. 100 rad/s falls to 70 in 2 s; the line of order 2 meets the resonance on the way. What the project file
does not know may be added: a line of any order, a gap, dry friction, asymmetry, damping by the square of the rate.
"""

from functools import cache
from math import copysign, cos, hypot, sin

import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import make_interp_spline

import strainwave as sw

N, J_M, J_L, B = 100.0, 4e-4, 2.2, 9.0
K1, K2, T1, GRAVITY, ERROR, PHASE = 33e3, 48e3, 14.0, 8.0, 1.9e-4, 0.4
K_P, K_D = 60.0, 0.25
RATE, NOISE = 1000.0, 2e-6
RECORD = sw.catalogue.gear("SHG-25-100").law

PROJECT = """
title: axis
gear: SHG-25-100
motor: {inertia: 4 kg*cm^2, loop: {type: position_loop, K_p: 60 N*m/rad, K_d: 0.25 N*m*s/rad}}
load: {inertia: 2.2 kg*m^2, drag: {type: angle_torque, amplitude: 8 N*m}}
damping: {B: 14 N*m*s/rad}
speed: {from: 70 rad/s, to: 100 rad/s, shaft: motor}
excitation: {kinematic_error: [{order: 2, amplitude: 30 arcsec, phase: 0.2 rad}]}
limit: {oscillation: 100 arcsec}
"""


def torque(u, gap=0.0, softer=0.0):
    """Three slopes, which change at T1 and at the record's T2; behind a gap, and softer one way."""
    size = max(abs(u) - gap, 0.0)
    first = T1 / K1
    second = first + (RECORD.T2 - T1) / K2
    if size <= first:
        found = K1 * size
    elif size <= second:
        found = T1 + K2 * (size - first)
    else:
        found = RECORD.T2 + RECORD.K3 * (size - second)
    return copysign(found * (1.0 - softer * (u < 0.0)), u)


@cache
def angles(line=(0.0, 0.0), gap=0.0, softer=0.0, dry=0.0, square=0.0):
    """Time, motor angle and load angle without noise; a line is its order and amplitude [rad]."""
    order, size = line

    def reference(t):
        return 100.0 * t - 7.5 * t * t, 100.0 - 15.0 * t

    def rhs(t, y):
        motor, motor_speed, load, load_speed = y.tolist()
        angle, speed = reference(t)
        u = motor / N - load - ERROR * cos(2.0 * motor + PHASE) - size * cos(order * motor)
        slope = 1.0 / N + 2.0 * ERROR * sin(2.0 * motor + PHASE) + order * size * sin(order * motor)  # du/dmotor
        rate = slope * motor_speed - load_speed
        gear = torque(u, gap, softer) + B * rate + square * abs(rate) * rate + dry * rate / hypot(rate, 2e-3)
        control = K_P * (angle - motor) + K_D * (speed - motor_speed)
        return motor_speed, (control - slope * gear) / J_M, load_speed, (gear - GRAVITY * sin(load)) / J_L

    t = np.arange(2000) / RATE
    start = (0.0, 100.0, -ERROR * np.cos(PHASE), 1.0)
    y = solve_ivp(rhs, (0.0, t[-1]), start, "DOP853", t, rtol=1e-10, atol=1e-13, max_step=1e-3).y
    return t, y[0], y[2]


def measured(seed=1, **unknown):
    """The log with noise of the load's encoder."""
    t, motor, load = angles(**unknown)
    return {
        "time": t,
        "motor_angle": motor,
        "load_angle": load + NOISE * np.random.default_rng(seed).standard_normal(2000),
    }


def current(log, constant):
    """Current [A] of the motor by its loop, which has the exact angle."""
    t, motor = log["time"], log["motor_angle"]
    speed = make_interp_spline(t, motor, 5)(t, 1)
    return (K_P * (100.0 * t - 7.5 * t * t - motor) + K_D * (100.0 - 15.0 * t - speed)) / constant
