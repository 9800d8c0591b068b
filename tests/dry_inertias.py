"""A motor with its loop, a gear and a load, dry friction on both shafts: equations by hand, stops located by SciPy.

Each shaft slides one way or sticks; `solve_ivp` ends where a slip ends or a torque exceeds the break-away torque.
"""

import math
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

import strainwave as sw

ARCSEC = math.pi / 648_000.0
SAMPLE = 1e-4  # s
SPARE = 1e-9  # of the break-away torque by which it is exceeded


class Friction(NamedTuple):
    """Sliding and break-away torque [N*m], speed [rad/s] by which it has fallen, and viscous part [N*m*s/rad]."""

    low: float
    high: float
    speed: float
    viscous: float = 0.0

    def at(self, v):
        return self.low + (self.high - self.low) * math.exp(-((v / self.speed) ** 2))

    def law(self):
        dry = sw.laws.Coulomb(self.low) if self.low == self.high else sw.laws.Stribeck(self.low, self.high, self.speed)
        return sw.Parallel(dry, sw.laws.Viscous(self.viscous)) if self.viscous else dry


class DryInertias(NamedTuple):
    """Inertias [kg*m^2], ratio, stiffness, damping, frictions, gravity [N*m] and its phase, lines, gains of the loop.

    The torque of the motor is -K_p (w + z/T_n) with w = d' + K_v d and z' = w of its deviation d from the reference;
    without T_n it has no integral.
    """

    J_m: float
    J_l: float
    N: float
    K: float
    B: float
    motor: Friction
    load: Friction
    gravity: float
    phase: float
    lines: tuple[tuple[int, float], ...]
    K_v: float
    K_p: float
    T_n: float | None

    def train(self, reference=None):
        control = (
            sw.train.CascadeLoop(self.K_v, self.K_p, self.T_n)
            if self.T_n
            else sw.train.PositionLoop(self.K_p * self.K_v, self.K_p)
        )
        error = sw.KinematicError(tuple(sw.Line(k, a * ARCSEC) for k, a in self.lines))
        drag = sw.Parallel(sw.train.AngleTorque(self.gravity, 1, self.phase), self.load.law())
        return sw.train.DriveTrain(
            sw.train.Motor(self.J_m, drag=self.motor.law(), control=control), self.N, self.B, sw.Linear(self.K),
            sw.train.Load(self.J_l, drag=drag), error=error,
            reference=sw.train.AtRest() if reference is None else reference,
        )  # fmt: skip

    def own(self, train, y):
        """Angles and speeds of motor and load, and the integral, from a state of the package's train at rest."""
        x, x_rate, d, d_rate, *z = y
        at = float(train.reference.value(0.0)) + d
        return np.array([at, d_rate, at / self.N - x, d_rate / self.N - x_rate, z[0] if z else 0.0])

    def pulls(self, y, reference):
        """Torques [N*m] on motor and load without dry friction, and the rate of the integral."""
        motor, motor_rate, load, load_rate, z = y
        d, d_rate = motor - reference[0], motor_rate - reference[1]
        error = sum(a * ARCSEC * math.cos(k * motor) for k, a in self.lines)
        slope = -sum(k * a * ARCSEC * math.sin(k * motor) for k, a in self.lines)
        twist, rate = motor / self.N - load - error, (1.0 / self.N - slope) * motor_rate - load_rate
        torque, w = self.K * twist + self.B * rate, d_rate + self.K_v * d
        asked = -self.K_p * (w + (z / self.T_n if self.T_n else 0.0))
        on_motor = asked - (1.0 / self.N - slope) * torque - self.motor.viscous * motor_rate
        gravity = self.gravity * math.sin(load + self.phase)
        return on_motor, torque - gravity - self.load.viscous * load_rate, w

    def run(self, y, segments, rtol=1e-9):
        """Times, states (5, n) and angles of the reference along segments (begin, end, t -> angle, speed)."""
        times, states, asked, y = [], [], [], np.array(y, float)
        for begin, end, reference in segments:
            t, signs = begin, None
            while t < end:
                signs = self._signs(y, reference(t), signs)
                for place, sign in ((1, signs[0]), (3, signs[1])):
                    y[place] = 0.0 if sign == 0.0 else y[place]
                part = self._slide(y, t, end, reference, signs, rtol)
                at = np.linspace(t, part.t[-1], 2 + int((part.t[-1] - t) / SAMPLE))
                times.append(at)
                states.append(part.sol(at))
                asked += [reference(time)[0] for time in at]
                t, y = part.t[-1], part.y[:, -1].copy()
        return np.concatenate(times), np.concatenate(states, axis=1), np.array(asked)

    def _signs(self, y, reference, before):
        found = []
        for i, (v, pull) in enumerate(zip(y[1:4:2], self.pulls(y, reference)[:2], strict=True)):
            rests = abs(v) < 1e-9 if before is None else before[i] * v <= 0.0
            high = (self.motor, self.load)[i].high
            sticks = rests and 0.0 < high >= abs(pull)
            found.append(0.0 if sticks else math.copysign(1.0, pull if rests else v))
        return found

    def _slide(self, y, t, end, reference, signs, rtol):
        def rates(t, y):
            *pulls, w = self.pulls(y, reference(t))
            shafts = zip(pulls, signs, (self.motor, self.load), (self.J_m, self.J_l), y[1:4:2], strict=True)
            motor, load = [(pull - s * f.at(v)) / J if s else 0.0 for pull, s, f, J, v in shafts]
            return [y[1], motor, y[3], load, w]

        def guard(i, friction):
            def spare(t, y):
                if signs[i]:
                    return signs[i] * y[1 + 2 * i] + 1e-11 if friction.high else 1.0
                return (1.0 + SPARE) * friction.high - abs(self.pulls(y, reference(t))[i])

            spare.terminal, spare.direction = True, -1
            return spare

        guards = [guard(0, self.motor), guard(1, self.load)]
        options = {"rtol": rtol, "atol": 1e-13, "events": guards, "max_step": 2e-3, "dense_output": True}
        return solve_ivp(rates, (t, end), y, "DOP853", **options)


def drawn(draw):
    """A random drive of a joint or a table: cascade or position loop, Coulomb or Stribeck, gravity, two lines."""
    N, J_l = draw.choice((50.0, 80.0, 100.0, 120.0)), 10.0 ** draw.uniform(-0.5, 1.0)
    hertz = draw.uniform(15.0, 40.0)
    K = J_l * (2.0 * math.pi * hertz) ** 2
    J_m = J_l / N**2 * draw.uniform(0.5, 4.0)
    J, omega = J_m + J_l / N**2, 2.0 * math.pi * draw.uniform(8.0, 25.0)
    gravity = draw.choice((0.0, draw.uniform(5.0, 60.0)))
    scale = J * omega * draw.uniform(0.5, 3.0)  # N*m on the motor
    rise = draw.choice((1.0, draw.uniform(1.2, 1.8)))
    motor = Friction(scale, scale * rise, draw.uniform(0.5, 5.0), draw.choice((0.0, 0.1 * scale)))
    low = draw.choice((0.0, draw.uniform(0.1, 1.0))) * scale * N
    load = Friction(low, low * draw.choice((1.0, 1.4)), draw.uniform(0.01, 0.1))
    T_n = draw.choice((None, 4.0 * 0.5 / omega))
    lines = ((1, draw.uniform(2.0, 10.0)), (2, draw.uniform(5.0, 20.0)))
    damping = 2.0 * draw.uniform(0.01, 0.05) * math.sqrt(K * J_l)
    return DryInertias(
        J_m, J_l, N, K, damping, motor, load, gravity, draw.uniform(0.0, 3.0), lines, 0.25 * omega, J * omega, T_n
    )
