"""A cascade with filters, lag and integrals: complex algebra, margins by python-control, motions by SciPy."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import strainwave as sw
from strainwave.files.reading import from_text
from strainwave.model.train.controls import tuning_of
from strainwave.model.train.filters import around

N, B = 100.0, 25.0
HZ = 2.0 * math.pi


class Axis:
    """A random axis under a cascade, and its transfer functions, polynomials in s with the highest power first."""

    def __init__(self, seed, encoder="motor"):
        chance = np.random.default_rng(seed)
        self.J_m, self.J_l, self.K = chance.uniform(3e-4, 6e-4), chance.uniform(2.0, 6.0), chance.uniform(3e4, 9e4)
        self.mean, self.omega = chance.uniform(-100.0, 100.0), chance.uniform(30.0, 200.0)
        J, bandwidth = self.J_m + self.J_l / N**2, HZ * chance.uniform(20.0, 40.0)
        self.gains = bandwidth / 5.0 * chance.uniform(0.5, 1.0), J * bandwidth, chance.uniform(5.0, 8.0) / bandwidth
        self.lag = chance.choice([0.0, 4e-4])
        self.filters = tuple(self.filter(chance, kind) for kind in chance.integers(0, 3, chance.integers(0, 3)))
        self.T_p = chance.uniform(4.5, 8.0) / self.gains[0] if seed % 2 else math.inf
        self.encoder, self.mixing = encoder, HZ * chance.uniform(5.0, 10.0) if encoder == "both" else 0.0
        if encoder != "motor":
            self.K, self.gains, self.T_p = 3.0 * self.K, (0.5 * self.gains[0], *self.gains[1:]), 2.0 * self.T_p
        T_p = 0.0 if math.isinf(self.T_p) else self.T_p
        control = sw.train.CascadeLoop(*self.gains)
        self.control = around(control, self.lag, self.filters, T_p, encoder, self.mixing)

    @staticmethod
    def filter(chance, kind):
        w = HZ * chance.uniform(200.0, 400.0)
        if kind == 0:
            return sw.train.LowPassFilter(w, chance.uniform(0.5, 1.0))
        if kind == 1:
            return sw.train.NotchFilter(w, 0.4 * w, chance.uniform(0.05, 0.5))
        return sw.train.BiquadFilter(w, 0.7, 1.3 * w, chance.uniform(0.1, 0.5))

    @staticmethod
    def polynomials(one):
        if isinstance(one, sw.train.NotchFilter):
            return [1.0, one.depth * one.width, one.frequency**2], [1.0, one.width, one.frequency**2]
        bottom = [1.0 / one.frequency**2, 2.0 * one.damping / one.frequency, 1.0]
        if isinstance(one, sw.train.LowPassFilter):
            return [1.0], bottom
        return [1.0 / one.zero_frequency**2, 2.0 * one.zero_damping / one.zero_frequency, 1.0], bottom

    def twist(self, factor=1.0):
        """Amplitude [rad] under 20 N*m of order 1 at the load, the loop's torque times a factor."""
        s = 1j * self.omega
        *above, below = self.controller()
        gear = self.K + B * s
        by_motor, by_load = (factor * np.polyval(one, s) / np.polyval(below, s) for one in above)
        matrix = [
            [self.J_m * s * s + by_motor + gear / N**2, by_load - gear / N],
            [-gear / N, self.J_l * s * s + gear],
        ]
        motor, load = np.linalg.solve(np.array(matrix), [0.0, 20.0])
        return abs(motor / N - load)

    def controller(self):
        """Numerators of the torque against the angles of motor and load, and the denominator."""
        K_v, K_p, T_n = self.gains
        common, below = K_p * np.array([1.0, 1.0 / T_n]), np.array([1.0, 0.0, 0.0])
        speed, place = [1.0, 0.0, 0.0], [K_v, K_v / self.T_p]
        if math.isinf(self.T_p):
            speed, place, below = speed[:-1], place[:-1], below[:-1]
        for one in self.filters:
            top, bottom = self.polynomials(one)
            common, below = np.polymul(common, top), np.polymul(below, bottom)
        below = np.polymul(below, [self.lag, 1.0]) if self.lag else below
        speed, place, w = np.polymul(common, speed), np.polymul(common, place), self.mixing
        if self.encoder == "motor":
            return np.polyadd(speed, place), [0.0], below
        if self.encoder == "load":
            return speed, N * place, below
        mixed = np.polyadd(np.polymul(speed, [1.0, w]), np.polymul(place, [1.0, 0.0]))
        return mixed, N * w * place, np.polymul(below, [1.0, w])

    def train(self, law=None, **given):
        drive = sw.Drive(self.J_m, self.J_l, N, B, law or sw.Linear(self.K))
        return drive.train(control=self.control, omega=self.omega, **given)


AXES = [(seed, "motor") for seed in range(20)]
AXES += [(seed, encoder) for seed in range(8) for encoder in ("load", "both")]


@pytest.mark.parametrize(("seed", "encoder"), AXES)
def test_the_steady_motion_is_that_of_complex_algebra_and_the_integral_holds_the_mean(seed, encoder):
    axis = Axis(seed, encoder)
    orbit = sw.find_orbit(axis.train(load_torque=sw.Harmonic(20.0, 1, mean=axis.mean)))
    assert orbit.amplitude(1) == pytest.approx(axis.twist(), rel=1e-9)
    x, _, motor_at, *_ = orbit.coefficients[0]
    assert x == pytest.approx(-axis.mean / axis.K, rel=1e-9)  # the gear's twist alone: the motor does not give way
    assert motor_at == pytest.approx(0.0 if encoder == "motor" else N * x, abs=1e-12)  # the load does not give way
    assert orbit.stable


def test_a_moving_average_is_its_transfer_within_what_is_said_and_moves_an_axis_as_that_does():
    span = 1.5e-3
    w = np.linspace(1e-3, 60.0, 6001) / span
    found = np.ones_like(w, complex)
    for one in sw.train.MovingAverageFilter(span).sections():
        top, bottom = Axis.polynomials(one)
        found *= np.polyval(top, 1j * w) / np.polyval(bottom, 1j * w)
        assert np.all(np.roots(bottom).real < 0.0)
    off = np.abs(found - (1.0 - np.exp(-1j * w * span)) / (1j * w * span))
    for most, below in ((0.002, 0.3), (0.055, 1.0), (0.16, math.inf)):
        assert np.max(off[w * span <= 2.0 * math.pi * below]) < most
    axis = Axis(2)
    axis.control = around(sw.train.CascadeLoop(*axis.gains), axis.lag, (sw.train.MovingAverageFilter(span),))
    orbit = sw.find_orbit(axis.train(load_torque=sw.Harmonic(20.0, 1, mean=axis.mean)))
    axis.filters, s = (), 1j * axis.omega
    assert orbit.amplitude(1) == pytest.approx(axis.twist((1.0 - np.exp(-s * span)) / (s * span)), rel=1e-7)


@pytest.mark.parametrize(("seed", "encoder"), AXES)
def test_margins_and_poles_are_those_of_python_control(seed, encoder):
    control = pytest.importorskip("control")
    axis = Axis(seed, encoder)
    gear, load = np.array([B / N, axis.K / N]), [axis.J_l, B, axis.K]
    plant_below = np.polysub(np.polymul([axis.J_m, *(gear / N)], load), np.polymul(gear, gear))
    plant_below[-2:] = 0.0  # a free body: two poles at 0
    by_motor, by_load, below = axis.controller()
    above = np.polyadd(np.polymul(by_motor, load), np.polymul(by_load, gear))
    loop = control.tf(above, np.polymul(below, plant_below))
    gain, phase, _, _, phase_at, _ = control.stability_margins(loop, returnall=True)
    found = sw.margins(axis.train())
    np.testing.assert_allclose(found.gain_crossings, np.sort(phase_at), rtol=1e-6)
    np.testing.assert_allclose(np.degrees(found.phase_margins), np.asarray(phase)[np.argsort(phase_at)], atol=1e-4)
    np.testing.assert_allclose(np.sort(found.gain_margins), np.sort(gain), rtol=1e-6)
    poles = np.array(sorted(axis.train().to_control().poles(), key=lambda p: (round(p.real, 3), p.imag)))
    roots = np.roots(np.polyadd(np.polymul(below, plant_below), above))
    np.testing.assert_allclose(poles, sorted(roots, key=lambda p: (round(p.real, 3), p.imag)), rtol=1e-6)
    assert found.stable == bool(np.all(roots.real < 0.0))


@pytest.mark.slow
@pytest.mark.parametrize(("seed", "encoder"), [(3, "motor"), (7, "motor"), (3, "load"), (5, "both")])
def test_a_nonlinear_axis_with_its_error_moves_as_equations_written_by_hand(seed, encoder):
    axis, error = Axis(seed, encoder), sw.KinematicError((sw.Line(1, 4e-5, 0.3), sw.Line(2, 1.2e-4)))
    law = sw.Cubic(axis.K, 3e5)
    orbit = sw.find_orbit(axis.train(law, kinematic_error=error, load_torque=sw.Harmonic(0.0, mean=axis.mean)))
    K_v, K_p, T_n = axis.gains
    w, count = axis.omega, len(axis.filters)

    def rates(t, y):
        d, speed, load, load_speed, integral, place, mixed, *states = y
        angle, turning = w * t + d, w + speed
        e = sum(line.amplitude * math.cos(line.order * angle + line.phase) for line in error.lines)
        slope = sum(-line.order * line.amplitude * math.sin(line.order * angle + line.phase) for line in error.lines)
        u = angle / N - load - e
        torque = axis.K * u * (1.0 + 3e5 * u * u) + B * (turning / N - load_speed - slope * turning)
        off = N * load - w * t
        seen = {"motor": d, "load": off, "both": mixed}[encoder]
        aside = speed + K_v * (seen + place / axis.T_p)
        given, own = K_p * (aside + integral / T_n), []
        for i, one in enumerate(
            axis.filters
        ):  # p'' + a p' + w^2 p = input, output h input + (b - h a) p' + (1 - h) w^2 p
            p, rate = states[2 * i : 2 * i + 2]
            W, a, b, h = one.shape()
            own += [rate, given - a * rate - W * W * p]
            given = h * given + (b - h * a) * rate + (1.0 - h) * W * W * p
        if axis.lag:
            own.append((given - states[-1]) / axis.lag)
            given = states[-1]
        pull = torque * (1.0 / N - slope)
        mixing = speed + axis.mixing * (off - mixed)
        of_load = load_speed, (torque + axis.mean) / axis.J_l
        return [speed, (-given - pull) / axis.J_m, *of_load, aside, seen, mixing, *own]

    turn = 2.0 * math.pi / w
    start = np.zeros(7 + 2 * count + bool(axis.lag))
    start[3] = w / N
    turns = math.ceil((6.0 if encoder == "motor" else 12.0) / turn)
    ends = solve_ivp(rates, (0.0, turns * turn), start, "DOP853", [0.0, turns * turn], rtol=1e-9, atol=1e-12).y[:, -1]
    times = np.linspace(turns * turn, (turns + 1) * turn, 1001)
    found = solve_ivp(rates, times[[0, -1]], ends, "DOP853", times, rtol=1e-9, atol=1e-12)
    x = (w * found.t + found.y[0]) / N - found.y[2]
    assert orbit.peak == pytest.approx(np.max(np.abs(x)), rel=1e-5)
    assert orbit.coefficients[0][2] == pytest.approx(np.mean(found.y[0][:-1]), abs=1e-8)


DRIVE = """\
gear: {ratio: 100, law: {type: cubic, K: 5e4 N*m/rad, alpha: 1e5 1/rad^2}}
motor: {inertia: 4.5 kg*cm^2, loop: LOOP}
load: {inertia: 5 kg*m^2}
damping: {ratio: 2.5 %}
speed: {from: 200 rpm, to: 2000 rpm, shaft: motor}
excitation: {kinematic_error: [{order: 2, amplitude: 25 arcsec}]}
"""
GAINS = "K_v: 30 1/s, K_p: 0.12 N*m*s/rad, T_n: 16 ms"
FILTERS = "filters: [{type: notch, frequency: 150 Hz, width: 60 Hz}, {type: low_pass, frequency: 400 Hz}]"
BOTH = ", lag: 0.2 ms, encoder: both, mixing_frequency: 8 Hz"
AVERAGE = ", filters: [{type: moving_average, time: 1 ms}]"


def control_of(loop, tmp_path):
    return from_text(DRIVE.replace("LOOP", loop), tmp_path / "axis.yaml").train.motor.control


@pytest.mark.parametrize(
    "more",
    [f", T_p: 150 ms, lag: 0.5 ms, {FILTERS}", "", ", T_p: 150 ms", AVERAGE, ", encoder: load", BOTH],
)
def test_a_project_file_gives_a_cascade_and_what_is_written_reads_back(more, tmp_path):
    K_v = 4.0 if "encoder" in more else 30.0
    loop = f"{{type: cascade, {GAINS}{more}}}".replace("K_v: 30", f"K_v: {K_v}")
    found = control_of(loop, tmp_path)
    project = from_text(DRIVE.replace("LOOP", loop), tmp_path / "axis.yaml")
    again = from_text(sw.project_text(project.train), tmp_path / "axis.yaml")
    assert again.train.motor.control == found
    core = found
    while hasattr(core, "loop"):
        core = core.loop
    assert core == sw.train.CascadeLoop(K_v, 0.12, 0.016)


def test_a_cascade_by_its_bandwidth_has_the_speed_loop_of_that_bandwidth(tmp_path):
    found = control_of("{type: cascade, bandwidth: 30 Hz, damping: 1}", tmp_path)
    J = 4.5e-4 + 5.0 / N**2
    assert found == pytest.approx((7.5 * HZ, J * 30.0 * HZ, 4.0 / (30.0 * HZ)), rel=1e-12)
    assert tuning_of(found, J)[:2] == pytest.approx((30.0 * HZ, 1.0))
    filtered = control_of(f"{{type: cascade, bandwidth: 30 Hz, damping: 1, {FILTERS}}}", tmp_path)
    assert filtered.loop.loop == found
    slow = control_of("{type: cascade, bandwidth: 30 Hz, damping: 1, T_p: 0.2 s}", tmp_path)
    assert slow == sw.train.PositionIntegral(found, 0.2)
    mixed = "{type: cascade, bandwidth: 20 Hz, damping: 1, encoder: both, mixing_frequency: 8 Hz}"
    assert control_of(mixed, tmp_path).frequency == pytest.approx(8.0 * HZ)


@pytest.mark.parametrize(
    ("loop", "said"),
    [
        ("{type: cascade, K_v: 0 1/s, K_p: 0.1 N*m*s/rad, T_n: 16 ms}", "K_v: '0 1/s' is not positive"),
        (f"{{type: cascade, {GAINS}, filters: [{{type: nothc, frequency: 150 Hz}}]}}", "did you mean 'notch'"),
        (
            f"{{type: cascade, {GAINS}, filters: [{{type: notch, frequency: 150 Hz}}]}}",
            r"filters\[0\]\.width: is missing",
        ),
        ("{type: cascade, K_v: 30 Hz, K_p: 0.1 N*m*s/rad, T_n: 16 ms}", "may be turns or radians a second"),
        (
            "{type: speed, K_p: 0.1 N*m*s/rad, K_d: 1e-4 kg*m^2, " + FILTERS + "}",
            "which no filter takes; leave K_d out",
        ),
        ("{type: speed, bandwidth: 30 Hz, T_p: 0.1 s}", "T_p: is the integral time of a cascade's position loop"),
        ("{type: speed, K_p: 0.1 N*m*s/rad, T_p: 0.1 s}", "it must be a CascadeLoop, in whose position loop T_p"),
        ("{bandwidth: 30 Hz, encoder: load}", "encoder: 'load' needs a position loop around a speed loop"),
        ("{type: speed, K_p: 0.1 N*m*s/rad, encoder: load}", "encoder: 'load' needs a position loop around"),
        (f"{{type: cascade, {GAINS}, encoder: output}}", "encoder: 'output' is not known"),
        (f"{{type: cascade, {GAINS}, encoder: both}}", "mixing_frequency: is missing; with both encoders write"),
        (f"{{type: cascade, {GAINS}, mixing_frequency: 8 Hz}}", "mixing_frequency: mixes two encoders; write"),
    ],
)
def test_a_wrong_cascade_gets_its_sentence(loop, said, tmp_path):
    with pytest.raises(ValueError, match=said):
        control_of(loop, tmp_path)


@pytest.mark.parametrize(("encoder", "K_v"), [("motor", 2000.0), ("load", 60.0), ("both", 900.0)])
def test_an_unstable_cascade_is_refused_with_the_gain_at_which_it_is_stable(encoder, K_v, tmp_path):
    w = 8.0 * HZ
    mixing = ", mixing_frequency: 8 Hz" if encoder == "both" else ""
    gains = f"K_v: {K_v} 1/s, K_p: 0.12 N*m*s/rad, T_n: 4 ms, lag: 0.5 ms"
    loop = f"{{type: cascade, {gains}, encoder: {encoder}{mixing}}}"
    with pytest.raises(ValueError, match=r"the loop is stable with K_v up to [\d.]+ 1/s, but has ") as refused:
        control_of(loop, tmp_path)
    limit = float(str(refused.value).split("up to ")[1].split()[0])
    motor, load, K = 4.5e-4, 5.0, 5e4
    gear = np.array([2.0 * 0.025 * math.sqrt(K * load), K])

    def growth(K_v):
        speed = 0.12 * np.array([1.0, 250.0])
        of_motor = {"motor": [1.0, w], "load": [0.0], "both": [1.0, 0.0]}[encoder]
        by_motor = np.polymul(speed, np.polyadd([1.0, w, 0.0], K_v * np.array(of_motor)))
        by_load = {"motor": 0.0, "load": 1.0, "both": w}[encoder] * K_v * speed
        by_load = np.polymul(by_load, [1.0, w]) if encoder == "load" else by_load
        below = np.polymul(
            np.polymul([5e-4, 1.0, 0.0], [1.0, w]),
            np.polysub(np.polymul([motor, *(gear / N**2)], [load, *gear]), np.polymul(gear / N, gear / N)),
        )
        above = np.polyadd(np.polymul(by_motor, [load, *gear]), np.polymul(by_load, gear))
        return np.max(np.roots(np.polyadd(below, above)).real)

    assert growth(0.98 * limit) < 0.0 < growth(1.02 * limit)
