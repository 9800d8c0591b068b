"""A drive train with its sampled controller: what is measured, when, and how its torque comes to the motor.

Noise of measurements: numbers that are drawn anew for every sample and are the same in every run.

A number is a function of its seed, lane and place alone (the mixing function of Steele, Lea & Flood, Fast splittable
pseudorandom number generators, OOPSLA 2014): runs are reproducible to the bit, whatever thread computes a lane.
"""

from math import nan
from typing import Any, NamedTuple

import numpy as np

from ...base.protocols import need
from ...base.quantities import Angle, Ratio, Reals, Time, Torque
from ...compile.address import ByAddress, words_of
from ...compile.calls import at, put_at, value
from ...compile.elementwise import larger, select, smaller
from ...compile.jit import entry, kernel, kernel_as
from ...compile.tree import made, mapped, numbers
from ..excitation import Harmonic, Line, NoError
from ..laws.friction import positive
from ..train.commanded import Commanded, TorqueDriven
from ..train.controls import commanded, core_of
from ..train.drive_train import motor_motion
from .loops import Measurement, moved

_GOLDEN, _FIRST, _SECOND = 0x9E3779B97F4A7C15, 0xBF58476D1CE4E5B9, 0x94D049BB133111EB
_ALL, _PIECE = 2**64 - 1, 0xFFFF
_SCALE = 3.0**0.5 / 65536.0  # the sum of four numbers, each even over 2^16, has the variance 2^32/3


def _mixed(index: int, shift: int) -> float:
    x = np.uint64(index) * np.uint64(_GOLDEN) + np.uint64(_GOLDEN)
    x = (x ^ (x >> np.uint64(30))) * np.uint64(_FIRST)
    x = (x ^ (x >> np.uint64(27))) * np.uint64(_SECOND)
    x = x ^ (x >> np.uint64(31))
    return float(np.int64((x >> np.uint64(shift)) & np.uint64(_PIECE)))


@kernel_as(_mixed)
def piece(index: int, shift: int) -> float:
    """Whole number below 2^16 that belongs to an index: 16 bits, from bit `shift` on, of its 64 mixed ones."""
    x = (int(index) + 1) * _GOLDEN & _ALL
    x = (x ^ (x >> 30)) * _FIRST & _ALL
    x = (x ^ (x >> 27)) * _SECOND & _ALL
    x ^= x >> 31
    return float((x >> shift) & _PIECE)


@kernel
def place_of(seed: int, lane: int, sample: int, channel: int) -> int:
    """Place of a channel (0 to 3) in a sample of a lane."""
    return ((seed * 1048583 + lane) * 268435399 + sample) * 4 + channel


@kernel
def noise(seed: int, lane: int, sample: int, channel: int) -> float:
    """Noise of mean 0 and deviation 1, at most 3.46 in size: a sum of four even numbers."""
    index = place_of(seed, lane, sample, channel)
    return (piece(index, 0) + piece(index, 16) + piece(index, 32) + piece(index, 48) - 131070.0) * _SCALE


@kernel
def even(seed: int, lane: int, sample: int, channel: int) -> float:
    """Number that is evenly spread from 0 to 1."""
    return (piece(place_of(seed, lane, sample, channel), 0) + 0.5) / 65536.0


NO_ERROR = NoError()
ROUND = 6755399441055744.0  # 1.5 * 2^52: adding and subtracting it rounds to a whole number
HELD = 4  # place of the torque in force among the states of a train
LONGEST_DELAY = 7.0  # samples of delay
DELAY_ROUNDING = 1e-9  # of a period: rounding of a delay
UNGUARDED = 1e9  # N*m: the guard of a controller that adapts is never met
LOST = 20.0  # samples without a motor's angle after which the torque is 0 until it is back


class Sampling(NamedTuple):
    """Samples every `period`; a torque acts `delay` later and is at most `limit`; what the encoders give.

    An angle is rounded to the encoder's step `quantum`, 0 for none, after noise of a standard deviation. `load_encoder`
    is 1 where the load's angle is measured, 0 where not. A share `loss` of the motor's samples is lost, a NaN; `seed`
    fixes noise and losses.
    """

    period: Time = 250e-6
    delay: Time = 250e-6
    limit: Torque = 1e9
    motor_quantum: Angle = 0.0
    motor_noise: Angle = 0.0
    load_quantum: Angle = 0.0
    load_noise: Angle = 0.0
    loss: Ratio = 0.0
    load_encoder: int = 1
    seed: int = 1

    @property
    def lead(self) -> float:
        """Time [s] from a sample to the middle of the time in which its torque acts."""
        return self.delay + 0.5 * self.period

    def check(self) -> None:
        """Refuse times, limits and encoders that are none (ValueError)."""
        positive(self, "period", "limit")
        for name in ("delay", "motor_quantum", "motor_noise", "load_quantum", "load_noise"):
            if not getattr(self, name) >= 0.0:
                raise ValueError(f"Sampling.{name} is {getattr(self, name):g}; it must be zero or more")
        if not self.delay <= LONGEST_DELAY * self.period:
            raise ValueError(
                f"Sampling.delay is {self.delay:g} s; it must be at most {LONGEST_DELAY:g} periods, "
                f"{LONGEST_DELAY * self.period:g} s"
            )
        if not 0.0 <= self.loss < 1.0:
            raise ValueError(f"Sampling.loss is {self.loss:g}; it is a share, from 0 to below 1")
        if self.load_encoder not in (0, 1):
            raise ValueError(
                f"Sampling.load_encoder is {self.load_encoder}; it must be 1 with an encoder on the load, or 0 without"
            )


class Driven(NamedTuple):
    """A controller with a torque [N*m] added to its own, and an angle [rad] to what its motor follows."""

    loop: Any
    torque: Torque
    angle: Angle

    def start(self) -> Any:
        """Memory before the first sample."""
        return self.loop.start()

    def update(self, state: Any, m: Measurement) -> Any:
        """Memory after a sample, and the torque [N*m]."""
        state, torque = self.loop.update(state, moved(m, self.angle, 0.0, 0.0))
        return state, torque + self.torque


class Called(NamedTuple):
    """Controllers with their memories by address, so many words each: to a kernel the state is the number of one."""

    words: int
    size: int
    update_at: int

    def update(self, state: Any, m: Any) -> Any:
        """The same number, and the torque [N*m]; the memory is written where it is."""
        sample = (
            float(m.reference), float(m.speed), float(m.acceleration), float(m.motor), float(m.load), float(m.applied),
            float(m.cut),
        )  # fmt: skip
        return state, value(self.update_at, self.words + 8 * self.size * int(state), sample)


def _updated(
    model: Any, reference: float, speed: float, acceleration: float, motor: float, load: float, applied: float,
    cut: float,
) -> float:  # fmt: skip
    (state, controller), torque = at(model), 0.0
    m = Measurement(reference, speed, acceleration, motor, load, applied, cut)
    for _ in range(1):  # so that the compiler refuses a memory of another kind than the one before
        state, torque = controller.update(state, m)
    put_at(model, (state,))
    return float(torque)


def _floats(thing: Any) -> Any:
    return made(thing, map(_floats, thing)) if isinstance(thing, tuple) else float(thing)


class Memory(NamedTuple):
    """Memory of a closed loop between samples, beside the state of its train.

    `state` is the controller's; then the last eight torques, newest first; what the limit did to the last one; the last
    good deviation of the motor and how many samples it is old; counts of samples that were limited and lost.
    """

    state: Any
    torques: Any
    cut: Any
    deviation: Any
    age: Any
    limited: Any
    lost: Any


@kernel
def rounded(angle: Reals, quantum: Any) -> Any:
    """An angle in whole steps of an encoder; as it is where the step is 0."""
    step = select(quantum > 0.0, quantum, 1.0)
    return select(quantum > 0.0, ((angle / step + ROUND) - ROUND) * step, angle)


@kernel
def whole_periods(sampling: Any) -> int:
    """Whole periods in the delay."""
    return int(sampling.delay / sampling.period + DELAY_ROUNDING)


class ClosedLoop(NamedTuple):
    """A drive train whose motor a sampled controller drives.

    Its control is `Commanded` or `TorqueDriven`, or `Lagged(Commanded(), lag)` behind the lag of a current loop.
    """

    train: Any
    controller: Any
    sampling: Sampling

    def start(self) -> Memory:
        """Memory before the first sample."""
        return Memory(self.controller.start(), (0.0,) * 8, 0.0, 0.0, 0.0, 0.0, 0.0)

    def started(self, y: Any) -> Memory:
        """Memory before the first sample of a plant in a state, whose torque is in force and was before."""
        return self.start()._replace(torques=(y[HELD],) * 8)

    def measured(self, t: Any, y: Any, memory: Any, lane: int, sample: int) -> Any:
        """Measurement for the controller at a time [s]: a lost angle of the motor is the last good one, moved along.

        Returns the measurement, whether the motor's angle was lost, its deviation, and its age in samples.
        """
        s, train = self.sampling, self.train
        phase, omega = train.omega * t, train.omega
        motor = motor_motion(train, phase, y)[0]
        load = motor / train.N - train.load_error(y)
        reference = train.reference.value(phase)
        fast, quick = omega * train.reference.slope(phase), omega * omega * train.reference.curvature(phase)
        angle = rounded(motor + s.motor_noise * noise(s.seed, lane, sample, 0), s.motor_quantum)
        output = rounded(load + s.load_noise * noise(s.seed, lane, sample, 1), s.load_quantum)
        lost = select((even(s.seed, lane, sample, 2) < s.loss) | (angle != angle), 1.0, 0.0)
        deviation = select(lost > 0.0, memory.deviation, angle - reference)
        age = select(lost > 0.0, memory.age + 1.0, 0.0)
        seen = select(s.load_encoder == 1, output, nan)
        m = Measurement(reference, fast, quick, reference + deviation, seen, memory.torques[0], memory.cut)
        return m, lost, deviation, age

    def update(self, t: Any, y: Any, memory: Any, lane: int, sample: int) -> Any:
        """Memory after the sample at a time [s]."""
        m, lost, deviation, age = self.measured(t, y, memory, lane, sample)
        state, command = self.controller.update(memory.state, m)
        command = select(command == command, command, 0.0)
        request = select(age <= LOST, command, 0.0)
        torque = larger(smaller(request, self.sampling.limit), -self.sampling.limit)
        limited = memory.limited + select(torque != request, 1.0, 0.0)
        q = memory.torques
        return Memory(state, (torque, *q[:-1]), torque - command, deviation, age, limited, memory.lost + lost)

    def commanded(self, y: Any, memory: Any, later: int) -> Any:
        """State of the train with the torque that acts in the first part of a sample (later = 0) or in the second."""
        torque = memory.torques[whole_periods(self.sampling) + 1 - later]
        return commanded(self.train.motor.control, y, torque)

    def waits(self) -> Any:
        """Time [s] after a sample until another torque acts; the delay's whole periods are left out."""
        s = self.sampling
        left = s.delay - whole_periods(s) * s.period
        return select(left > DELAY_ROUNDING * s.period, left, 0.0)

    def watched(self, phase: Reals, y: Any) -> Any:
        """Pointing error [rad] of the load, and torque [N*m] in the gear."""
        return self.train.pointing_error(y), self.train.torque(phase, y)

    def period(self) -> Any:
        """Time [s] from one sample to the next."""
        return self.sampling.period

    def plant(self) -> Any:
        """System that is integrated between samples."""
        return self.train

    def called(self, loops: Any, memories: Any) -> Any:
        """Loops of one kind for machine code that calls their controllers, so that no kernel is of their kind.

        Returns the loop, for `jit.run`; loops and memories whose numbers are those of the rest; and a function of one
        of these memories, after the run, that gives the whole.
        """
        pairs = [(_floats(memory.state), loop.controller) for loop, memory in zip(loops, memories, strict=True)]
        words = np.array([words_of(pair) for pair in pairs])

        def addressed(_: Any) -> Any:
            update_at = entry(_updated, pairs[0], *[float] * len(Measurement._fields))
            return self._replace(controller=Called(int(words.ctypes.data), words.shape[1], update_at))

        def restored(memory: Any) -> Any:
            row = iter(words.view(np.float64)[int(memory.state)].tolist())
            return memory._replace(state=mapped(lambda _: next(row), pairs[0][0]))

        left = [loop._replace(controller=()) for loop in loops]
        return ByAddress(self, addressed), left, [m._replace(state=float(i)) for i, m in enumerate(memories)], restored

    def check(self) -> None:
        """Refuse a train without `Commanded()`, without motion of its motor, and a controller that is none."""
        need("ClosedLoop.train", self.train, "pointing_error")
        if not isinstance(core_of(self.train.motor.control), Commanded | TorqueDriven):
            raise ValueError(
                "ClosedLoop.train has a motor without commanded torque; use the train with "
                "motor._replace(control=Commanded())"
            )
        need("ClosedLoop.controller", self.controller, "start", "update(state, measurement)")
        for path, owner, name, number in numbers(self.controller):
            if name == "period" and abs(number - self.sampling.period) > DELAY_ROUNDING * self.sampling.period:
                raise ValueError(
                    f"ClosedLoop.controller.{path} of {type(owner).__name__} is {number:g} s and Sampling.period is "
                    f"{self.sampling.period:g} s; set both to the same value"
                )

    def finest(self) -> float:
        """Pointing error [rad] that its encoders do not tell from none: a step of them, or three times their noise."""
        s = self.sampling
        load = max(s.load_quantum, 3.0 * s.load_noise) * s.load_encoder
        return float(max(max(s.motor_quantum, 3.0 * s.motor_noise) / self.train.N, load))

    def quiet(self) -> "ClosedLoop":
        """The loop with ideal encoders, without limit, guards and lines of error or torque: what is linear of it."""
        s = self.sampling
        still = iter([_quiet(*number[1:]) for number in numbers(self) if isinstance(number[3], float)])
        loop: ClosedLoop = mapped(lambda _: next(still), self)
        loop = loop._replace(sampling=Sampling(s.period, s.delay, load_encoder=s.load_encoder))
        lines = any(isinstance(owner, Line) for _, owner, _, _ in numbers(self.train.error))
        return loop if lines else loop._replace(train=loop.train._replace(error=NO_ERROR))

    def with_inputs(self, torque: Any, angle: Any) -> "ClosedLoop":
        """The loop with a torque [N*m] added to its controller's, and an angle [rad] to what the motor follows."""
        return self._replace(controller=Driven(self.controller, torque, angle))


def _quiet(owner: Any, name: str, value: float) -> float:
    if name == "amplitude" and isinstance(owner, Line | Harmonic):
        return 0.0
    return UNGUARDED if name == "most" else value
