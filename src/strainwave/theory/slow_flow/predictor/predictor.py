"""The predictor: the slow flow over one sample of a controller, in bounded time and without allocation.

The slow state z is integrated over the sample in the frame that turns with the excitation, while speed and amplitude
change linearly, and x is put together again from all components. So the prediction stays on the branch that the drive
is on, jumps where the drive jumps, and has its transient. A step predicts by Adams and Bashforth's method of third
order and corrects by Adams and Moulton's of fourth, with one evaluation of the rate (Hairer, Norsett & Wanner 1993,
Solving Ordinary Differential Equations I, sec. III.1): steady states are its fixed points.
"""

import math
from typing import Any, NamedTuple

from ....base.quantities import Reals, States, shown
from ....compile.jit import kernel
from .linear_drive import LinearDrive, fast_speed, hard, power, turned

OK, BEYOND, JUMP, OUT, INVALID = 0, 1, 2, 3, 4
LARGEST_JUMP = 0.05  # of the speed, from one sample to the next
WILD = 10.0  # times the largest valid torsion: from here on the former state is held
LARGEST_ANGLE = 1e9  # rad: the angles of a sound state are below it

SENTENCES = {
    OK: "the prediction is inside its range and its validity",
    BEYOND: (
        "the vibration is larger than what the certificate holds valid (10 %); use second order, a lower excitation, "
        "or integrate"
    ),
    JUMP: (
        f"the speed has changed by more than {100 * LARGEST_JUMP:.0f} % in one sample, which is not slow; give the "
        "speed in smaller steps"
    ),
    OUT: (
        "speed or amplitude is outside the range of the predictor and the nearest end of the range is used; make a "
        "predictor with a wider range"
    ),
    INVALID: "speed, amplitude or state is not finite and the last valid value is held; check the measurement",
}

REFUSED_START = (
    "the start of a predictor has a number that is not finite, or a vibration ten times as large as the certificate "
    "holds valid; give finite numbers and a smaller z, such as that of a steady state"
)


class PredictorState(NamedTuple):
    """State of a predictor, carried from one sample to the next.

    Attributes
    ----------
    re, im : float
        z = a exp(-i phase) [rad].
    re_rate, im_rate, re_rate_1, im_rate_1, re_rate_2, im_rate_2 : float
        Its rate [rad/s], and those one and two steps before.
    angle, free : float
        Base angle [rad], and without resonance the angle of the free part [rad].
    omega, amplitude : float
        Last valid speed of the base angle [rad/s] and factor on the torque lines.
    """

    re: float
    im: float
    re_rate: float
    im_rate: float
    re_rate_1: float
    im_rate_1: float
    re_rate_2: float
    im_rate_2: float
    angle: float
    free: float
    omega: float
    amplitude: float


class Prediction(NamedTuple):
    """Answer of a predictor.

    Attributes
    ----------
    amplitude, phase : float
        a [rad, 0-to-peak] and lag [rad, from -pi to pi] of the component near omega_0.
    x, rate : float
        Dynamic error x [rad] and x' [rad/s], all components together.
    flag : int
        0 (`OK`), or the most serious of: 1 the vibration is beyond what the certificate holds valid (`BEYOND`), 2 the
        speed jumped (`JUMP`), 3 an input was outside the range and clipped (`OUT`), 4 an input or the state was not
        finite and the last valid one is held (`INVALID`).
    state : PredictorState
        For the next call.
    """

    amplitude: float
    phase: float
    x: float
    rate: float
    flag: int
    state: PredictorState


@kernel
def is_finite(value: Reals) -> Any:
    """True for a finite number."""
    return value - value == 0.0


@kernel
def is_sound(state: PredictorState, largest: Any) -> Any:
    """True for a state of finite numbers whose z is not above `largest` [rad]."""
    total = state.re_rate + state.im_rate + state.re_rate_1 + state.im_rate_1 + state.re_rate_2 + state.im_rate_2
    total += state.re + state.im + state.omega + state.amplitude
    bounded = abs(state.angle) <= LARGEST_ANGLE and abs(state.free) <= LARGEST_ANGLE
    return is_finite(total) and bounded and abs(state.re) <= largest and abs(state.im) <= largest


@kernel
def clipped(value: Reals, low: Reals, high: Reals) -> Any:
    """The nearest number of a range."""
    return low if value < low else (high if value > high else value)


@kernel
def wrapped(angle: Reals, turn: Reals) -> Any:
    """Angle [rad] less whole turns."""
    return angle - turn * math.floor(angle / turn)


@kernel
def square(z: complex) -> Any:
    """Square of the size of a complex number."""
    return z.real * z.real + z.imag * z.imag


@kernel
def state_of(z: complex, rates: Any, angle: Any, free: Any, omega: Any, amplitude: Any) -> Any:
    """The state of these numbers."""
    now, one, two = rates
    slow = (z.real, z.imag, now.real, now.imag, one.real, one.imag, two.real, two.imag)
    return PredictorState(*slow, angle, free, omega, amplitude)


@kernel
def at_rest(predictor: Any) -> Any:
    """A state without vibration, in which a predictor goes on that was given none."""
    return state_of(0j, (0j, 0j, 0j), 0.0, 0.0, predictor.speeds[0], predictor.amplitudes[0])


@kernel
def combined(h: Reals, weights: States, rates: Any) -> Any:
    """Sum of four rates with weights, times h."""
    re = im = 0.0
    for i in range(4):
        re += weights[i] * rates[i].real
        im += weights[i] * rates[i].imag
    return complex(h * re, h * im)


@kernel
def step(predictor: Any, z: complex, rates: Any, omega: Reals, amplitude: Reals, h: Reals) -> Any:
    """One step of h [s] to a speed and an amplitude, from z and its last three rates; and the small harmonics there."""
    guess = z + combined(h / 12.0, (0.0, 23.0, -16.0, 5.0), (0j, *rates))
    rate, small = predictor.force.rate(predictor.drive, omega, amplitude, guess)
    newer = (rate, rates[0], rates[1])
    return z + combined(h / 24.0, (9.0, 19.0, -5.0, 1.0), (rate, *rates)), newer, small


@kernel
def advanced(predictor: Any, state: PredictorState, omega: Reals, amplitude: Reals) -> Any:
    """State z [rad] at the next sample, its last three rates, and the small harmonics."""
    z = complex(state.re, state.im)
    now, one = complex(state.re_rate, state.im_rate), complex(state.re_rate_1, state.im_rate_1)
    rates = (now, one, complex(state.re_rate_2, state.im_rate_2))
    h, share = predictor.sample / predictor.steps, 1.0 / predictor.steps
    for i in range(predictor.steps):
        left = (predictor.steps - 1 - i) * share
        now_omega, size = omega + left * (state.omega - omega), amplitude + left * (state.amplitude - amplitude)
        z, rates, small = step(predictor, z, rates, now_omega, size, h)
    return z, rates, small


@kernel
def step_back(predictor: Any, z: complex, rate: complex, omega: Reals, amplitude: Reals) -> Any:
    """State and rate one step earlier, at constant speed and amplitude, by the Runge-Kutta method."""
    force, drive, h = predictor.force, predictor.drive, -predictor.sample / predictor.steps
    k2, _ = force.rate(drive, omega, amplitude, z + 0.5 * h * rate)
    k3, _ = force.rate(drive, omega, amplitude, z + 0.5 * h * k2)
    k4, _ = force.rate(drive, omega, amplitude, z + h * k3)
    z = z + h / 6.0 * (rate + 2.0 * (k2 + k3) + k4)
    return z, force.rate(drive, omega, amplitude, z)[0]


@kernel
def swing(predictor: Any, z: complex, omega: Reals, amplitude: Reals) -> Any:
    """Torsion [rad] that the first-order motion may reach about its mean: the sum of all amplitudes."""
    total = math.sqrt(square(z))
    for i in range(len(predictor.drive.lines)):
        c = hard(predictor.drive, predictor.drive.lines[i], omega, amplitude)
        total += math.sqrt(square(c))
    return total


@kernel
def motion(predictor: Any, state: Any, small: Any) -> Any:
    """Dynamic error x [rad] and x' [rad/s] of a state."""
    drive, omega, amplitude = predictor.drive, state.omega, state.amplitude
    z, fast = complex(state.re, state.im), fast_speed(drive, omega)
    base, free = turned(state.angle / predictor.q), turned(state.free)
    turn = power(base, predictor.p) if drive.ratio > 0.0 else free
    vibration, speed = z * turn, complex(state.re_rate - fast * z.imag, state.im_rate + fast * z.real) * turn
    x, rate = predictor.mean + vibration.real, speed.real
    for i in range(len(drive.lines)):
        line = drive.lines[i]
        wave = hard(drive, line, omega, amplitude) + complex(line.error_re, line.error_im)
        wave *= power(base, predictor.q * line.order)
        x += wave.real
        rate -= omega * line.order * wave.imag
    value, slope = predictor.force.motion(drive, small, omega, state.angle, state.free)
    return x + value, rate + slope


class Predictor(NamedTuple):
    """The slow flow as a controller runs it; made by `SlowFlow.predictor`.

    All that `update` does is arithmetic on floats: it takes bounded time and allocates nothing. Compiled functions may
    call it too.

    Attributes
    ----------
    sample : float
        Time from one call to the next [s].
    steps : int
        Steps of the integration in it.
    speeds, amplitudes : (float, float)
        Range of the speed of the base angle [rad/s], and of the factor on the torque lines.
    reach : float
        Torsion about its mean [rad] up to which the certificate holds the flow valid.
    mean : float
        Mean of x [rad] at first order.
    p, q : int
        The resonance; (0, 1) without one.
    drive, force : NamedTuple
        The linear drive, and what drives its slow flow.
    """

    sample: float
    steps: int
    speeds: tuple[float, float]
    amplitudes: tuple[float, float]
    reach: float
    mean: float
    p: int
    q: int
    drive: LinearDrive
    force: Any

    def start(self, omega: Reals, amplitude: Reals = 1.0, z: Any = 0j, angle: Reals = 0.0) -> Any:
        """State of a drive at a speed [rad/s], clipped to the range.

        Parameters
        ----------
        omega, amplitude : float
            Speed of the base angle [rad/s] and factor on the torque lines; finite.
        z : complex
            a exp(-i phase) [rad] of the component near omega_0, such as `SteadyState.z`; 0 where it is at rest.
        angle : float
            Base angle [rad].

        Raises
        ------
        ValueError
            If one of them is not finite, or z is ten times as large as what the certificate holds valid.
        """
        omega, amplitude, z, angle = float(omega), float(amplitude), complex(z), float(angle)
        if not (is_finite(omega + amplitude + angle) and max(abs(z.real), abs(z.imag)) <= WILD * self.reach):
            raise ValueError(REFUSED_START)
        omega = clipped(omega, self.speeds[0], self.speeds[1])
        amplitude = clipped(amplitude, self.amplitudes[0], self.amplitudes[1])
        rate, _ = self.force.rate(self.drive, omega, amplitude, z)
        before, one = step_back(self, z, rate, omega, amplitude)
        _, two = step_back(self, before, one, omega, amplitude)
        return state_of(z, (rate, one, two), angle, 0.0, omega, amplitude)

    def update(self, omega: Reals, amplitude: Reals, state: PredictorState) -> Any:
        """Predict the motion at the next sample.

        Parameters
        ----------
        omega : float
            Speed of the base angle [rad/s] at the next sample; it changes linearly from the last one.
        amplitude : float
            Factor on the torque lines of the excitation at the next sample (1: the system's own; the mean torque and
            the kinematic error keep theirs).
        state : PredictorState
            From `start`, or of the last prediction.

        Returns
        -------
        Prediction
            Amplitude, phase, x, x', a flag and the state at the next sample. Never NaN, whatever is given.
        """
        flag, omega, amplitude = OK, float(omega), float(amplitude)
        if not is_sound(state, WILD * self.reach):
            flag, state = INVALID, at_rest(self)
        if not (is_finite(omega) and is_finite(amplitude)):
            flag = INVALID
            omega = omega if is_finite(omega) else state.omega
            amplitude = amplitude if is_finite(amplitude) else state.amplitude
        new_omega = clipped(omega, self.speeds[0], self.speeds[1])
        new_amplitude = clipped(amplitude, self.amplitudes[0], self.amplitudes[1])
        if flag == OK and (new_omega != omega or new_amplitude != amplitude):
            flag = OUT
        if flag == OK and abs(new_omega - state.omega) > LARGEST_JUMP * abs(state.omega):
            flag = JUMP
        z, rates, small = advanced(self, state, new_omega, new_amplitude)
        size = swing(self, z, new_omega, new_amplitude)
        if flag == OK and not size <= self.reach:
            flag = BEYOND
        if not (size <= WILD * self.reach and is_finite(rates[0].real + rates[0].imag)):
            z, rates = complex(state.re, state.im), (0j, 0j, 0j)
        angle = wrapped(state.angle + 0.5 * self.sample * (state.omega + new_omega), 2.0 * math.pi * self.q)
        free = wrapped(state.free + self.sample * self.drive.omega_0, 2.0 * math.pi) if self.p == 0 else 0.0
        after = state_of(z, rates, angle, free, new_omega, new_amplitude)
        x, slope = motion(self, after, small)
        if not is_finite(x + slope):
            x, slope = self.mean, 0.0
        return Prediction(math.sqrt(square(z)), -math.atan2(z.imag, z.real) + 0.0, x, slope, flag, after)

    def meaning(self, flag: int) -> str:
        """Say what a flag means, in one sentence."""
        if flag not in SENTENCES:
            raise ValueError(f"flag is {shown(flag)}; a prediction has one of {', '.join(map(str, SENTENCES))}")
        return SENTENCES[int(flag)]
