"""Axes with a sampled cascade by hand: eigenvalues from sample to sample, and the open loop by its aliases.

Nothing of the package is in here. The torque of a sample acts from the delay on and is held for a period; lag and
filter go on between the samples. At a sample w = v + K_v (x + sum x/T_p), and the torque is -K_p (w + sum w/T_n), the
sums with that sample.
"""

from dataclasses import astuple, dataclass, replace

import numpy as np
from scipy.linalg import expm
from scipy.optimize import brentq

ALIASES = 4000


@dataclass(frozen=True)
class Axis:
    """Motor and load [kg*m^2], gear K, B behind N, viscous drag of the motor, coupling (inertia, K, B) or none."""

    J_m: float
    J_l: float
    N: float
    K: float
    B: float
    drag: float
    coupling: tuple[float, float, float] | None
    K_v: float
    K_p: float
    T_n: float
    T_p: float | None
    lag: float
    filter: tuple[str, float, float] | None  # kind, frequency [rad/s], damping ratio or width [rad/s]
    encoder: str
    period: float
    delay: float

    def matrices(self):
        """Inertias, dampings and stiffnesses on (motor, what is on the gear, load behind the coupling)."""
        J = [self.J_m, self.J_l] if self.coupling is None else [self.J_m, self.coupling[0], self.J_l]
        n = len(J)
        C, K = np.zeros((n, n)), np.zeros((n, n))
        gear = np.zeros(n)
        gear[:2] = 1.0 / self.N, -1.0
        C += self.B * np.outer(gear, gear)
        K += self.K * np.outer(gear, gear)
        C[0, 0] += self.drag
        if self.coupling is not None:
            twist = np.array([0.0, 1.0, -1.0])
            K += self.coupling[1] * np.outer(twist, twist)
            C += self.coupling[2] * np.outer(twist, twist)
        return np.array(J), C, K

    def filtered(self, s):
        """Transfer of filter and lag at complex frequencies [1/s]."""
        out = 1.0 / (1.0 + self.lag * s)
        if self.filter is not None:
            kind, w, d = self.filter
            low = s * s + 2.0 * d * w * s + w * w
            out = out * (w * w / low if kind == "low_pass" else (s * s + 0.1 * d * s + w * w) / (s * s + d * s + w * w))
        return out

    def continuous(self):
        """x' = A x + b u with lag and filter, and rows of the angle that the position loop sees and of the speed."""
        J, C, K = self.matrices()
        n = len(J)
        A = np.block([[np.zeros((n, n)), np.eye(n)], [-K / J[:, None], -C / J[:, None]]])
        b = np.zeros(2 * n)
        b[n] = 1.0 / self.J_m
        through = 0.0
        into = b  # column of the torque on the motor
        if self.filter is not None:  # filter in controllable form, then the lag
            kind, w, d = self.filter
            a = 2.0 * d * w if kind == "low_pass" else d
            F = np.array([[0.0, 1.0], [-w * w, -a]])
            out, through = (np.array([w * w, 0.0]), 0.0) if kind == "low_pass" else (np.array([0.0, 0.1 * d - a]), 1.0)
        else:
            F, out, through = np.zeros((0, 0)), np.zeros(0), 1.0
        k = len(F)
        g = np.zeros(k)
        g[-1:] = 1.0
        if self.lag:
            size = 2 * n + 1 + k
            whole, put = np.zeros((size, size)), np.zeros(size)
            whole[: 2 * n, : 2 * n], whole[: 2 * n, 2 * n] = A, into
            whole[2 * n, 2 * n], whole[2 * n, 2 * n + 1 :] = -1.0 / self.lag, out / self.lag
            put[2 * n] = through / self.lag
            whole[2 * n + 1 :, 2 * n + 1 :], put[2 * n + 1 :] = F, g
        else:
            size = 2 * n + k
            whole, put = np.zeros((size, size)), np.zeros(size)
            whole[: 2 * n, : 2 * n], whole[: 2 * n, 2 * n :] = A, np.outer(into, out)
            put[: 2 * n] = through * into
            whole[2 * n :, 2 * n :], put[2 * n :] = F, g
        angle, speed = np.zeros(size), np.zeros(size)
        angle[0 if self.encoder == "motor" else n - 1] = 1.0 if self.encoder == "motor" else self.N
        speed[n] = 1.0
        return whole, put, angle, speed

    def eigenvalues(self, speed_by_difference=False):
        """Of the map from sample to sample; the speed is that of the sample, or the difference of two angles over T."""
        A, b, angle, rate = self.continuous()
        T, n = self.period, len(A)
        whole = int(self.delay / T + 1e-9)
        part = max(self.delay / T - whole, 0.0)
        part = part if part > 1e-9 else 0.0
        M = np.zeros((n + 1, n + 1))
        M[:n, :n], M[:n, n] = A, b
        first, second = expm(part * T * M), expm((1.0 - part) * T * M)
        old = whole + 1  # torques of the samples before
        size = n + old + 3  # and the sums of x and w, and the last angle of the motor

        def unit(i):
            return np.eye(size)[i]

        x = np.pad(angle, (0, size - n))
        v = np.pad(rate, (0, size - n))
        motor = unit(0)
        if speed_by_difference:
            v = (motor - unit(n + old + 2)) / T
        sum_x = unit(n + old) + T * x
        w = v + self.K_v * (x + (sum_x / self.T_p if self.T_p else 0.0))
        sum_w = unit(n + old + 1) + T * w
        torque = -self.K_p * (w + sum_w / self.T_n)
        late = [torque, *(unit(n + i) for i in range(old))]
        rows = second[:n, :n] @ (first[:n, :n] @ np.eye(n, size) + np.outer(first[:n, n], late[whole + 1]))
        rows = rows + np.outer(second[:n, n], late[whole])
        step = np.vstack([rows, torque, *(unit(n + i) for i in range(old - 1)), sum_x, sum_w, motor])
        if not self.T_p:  # a sum that nothing reads
            step = np.delete(np.delete(step, n + old, 0), n + old, 1)
        return np.linalg.eigvals(step)

    def open_loop(self, omega):
        """L(exp(j omega T)), the sum over the aliases of what the controller sees of its held, late torque."""
        J, C, K = self.matrices()
        T, n = self.period, len(J)
        k = np.arange(-ALIASES, ALIASES + 1) * 2.0 * np.pi / T
        s = 1j * (np.asarray(omega)[:, None] + k)
        Z = s[:, :, None, None] ** 2 * np.diag(J) + s[:, :, None, None] * C + K
        moved = np.linalg.solve(Z, np.broadcast_to(np.eye(n)[:, :1], (*s.shape, n, 1)))[..., 0]
        held = (1.0 - np.exp(-s * T)) / s * np.exp(-s * self.delay) * self.filtered(s) / T
        seen = moved[..., 0] if self.encoder == "motor" else self.N * moved[..., n - 1]
        x, v = np.sum(held * seen, axis=1), np.sum(held * s * moved[..., 0], axis=1)
        z = np.exp(1j * np.asarray(omega) * T)
        total = z / (z - 1.0) * T  # of backward Euler
        w = v + self.K_v * x * (1.0 + (total / self.T_p if self.T_p else 0.0))
        return self.K_p * w * (1.0 + total / self.T_n)

    def text(self, more=""):
        """The axis as a project file."""
        loop = f"type: cascade, K_v: {self.K_v!r} 1/s, K_p: {self.K_p!r} N*m*s/rad, T_n: {self.T_n!r} s"
        loop += f", T_p: {self.T_p!r} s" if self.T_p else ""
        loop += f", lag: {self.lag!r} s" if self.lag else ""
        loop += f", encoder: {self.encoder}" if self.encoder != "motor" else ""
        if self.filter is not None:
            kind, w, d = self.filter
            last = f"damping: {d!r}" if kind == "low_pass" else f"width: {d!r} rad/s, depth: 0.1"
            loop += f", filters: [{{type: {kind}, frequency: {w!r} rad/s, {last}}}]"
        drag = f", drag: {{type: viscous, B: {self.drag!r} N*m*s/rad}}" if self.drag else ""
        load = f"inertia: {self.J_l!r} kg*m^2"
        if self.coupling is not None:
            J, K, B = self.coupling
            law = f"{{type: linear, K: {K!r} N*m/rad}}"
            load += f", coupling: {{inertia: {J!r} kg*m^2, B: {B!r} N*m*s/rad, law: {law}}}"
        return f"""title: axis
gear: {{ratio: {self.N!r}, law: {{type: linear, K: {self.K!r} N*m/rad}}}}
motor: {{inertia: {self.J_m!r} kg*m^2, loop: {{{loop}}}{drag}}}
controller: {{period: {self.period!r} s, delay: {self.delay!r} s}}
load: {{{load}}}
damping: {{B: {self.B!r} N*m*s/rad}}
speed: {{from: 300 rpm, to: 3000 rpm, shaft: motor}}
excitation: {{kinematic_error: [{{order: 2, amplitude: 20 arcsec}}]}}
{more}"""


def drawn(rng):
    """Axis with random numbers."""
    N, J_m = float(rng.choice([50, 80, 100, 160])), rng.uniform(1.0, 8.0) * 1e-4
    J_l, f = J_m * N * N * rng.uniform(0.3, 3.0), rng.uniform(20.0, 90.0)
    K = J_l * (2.0 * np.pi * f) ** 2 / (1.0 + J_l / (J_m * N * N))
    B = 2.0 * rng.uniform(0.02, 0.08) * np.sqrt(K * J_l)
    coupling = None
    if rng.random() < 0.3:
        coupling = (0.1 * J_l, K * rng.uniform(1.0, 4.0), 0.3 * B)
    bandwidth = rng.uniform(30.0, 200.0)
    K_p = (J_m + J_l / N**2) * bandwidth
    lag = float(rng.choice([0.0, rng.uniform(2e-4, 2e-3)]))
    filters = [
        None,
        ("low_pass", rng.uniform(600.0, 1500.0), 0.7),
        ("notch", 2.0 * np.pi * 1.4 * f, rng.uniform(60, 200)),
    ]
    period = float(rng.choice([1.25e-4, 2.5e-4, 5e-4, 1e-3]))
    own = Axis(
        J_m, J_l, N, K, B, rng.choice([0.0, 1e-3]), coupling, bandwidth / rng.uniform(5.0, 10.0), K_p,
        rng.uniform(3.0, 8.0) / bandwidth, float(rng.choice([0.0, 0.5])) or None, lag, filters[rng.integers(3)],
        str(rng.choice(["motor", "motor", "load"])), period,
        period * rng.choice([0.0, 0.5, 1.0, rng.uniform(0.0, 2.5)]),
    )  # fmt: skip
    return Axis(*(_plain(value) for value in astuple(own)))


def _plain(value):
    if isinstance(value, tuple):
        return tuple(_plain(item) for item in value)
    return value.item() if isinstance(value, np.generic) else value


def at_edge(axis, largest):
    """The axis with gains of its speed loop that give the largest |eigenvalue|; None where it has none such."""

    def over(log_gain):
        return np.max(np.abs(replace(axis, K_p=float(np.exp(log_gain))).eigenvalues())) - largest

    tried = np.log(axis.K_p) + np.linspace(-1.5, 4.0, 56)
    sizes = np.array([over(x) for x in tried])
    at = np.flatnonzero((sizes[:-1] < 0.0) & (sizes[1:] > 0.0))
    if not len(at):
        return None
    return replace(axis, K_p=float(np.exp(brentq(over, tried[at[-1]], tried[at[-1] + 1], xtol=1e-13))))


def edges(count, seed=1):
    """So many axes whose largest |eigenvalue| is within 1e-3 of 1, below and above in turn."""
    rng, found = np.random.default_rng(seed), []
    while len(found) < count:
        off = 10.0 ** rng.uniform(-4.5, -3.0) * (-1.0 if len(found) % 2 else 1.0)
        if (axis := at_edge(drawn(rng), 1.0 + off)) is not None:
            found.append(axis)
    return found


def within(count, seed=2):
    """So many axes with a stable loop."""
    rng, found = np.random.default_rng(seed), []
    while len(found) < count:
        axis = drawn(rng)
        if np.max(np.abs(axis.eigenvalues())) < 1.0:
            found.append(axis)
    return found


def margins_by_hand(axis):
    """Phase margins [deg] by their frequency, and factors of the gain, from the Nyquist curve of the aliases."""
    top = np.pi / axis.period
    poles = axis.eigenvalues().astype(complex)
    poles = np.log(poles[np.abs(poles) > 1e-9])[:, None] / axis.period
    near = (np.abs(poles.imag) + np.abs(poles.real) * np.linspace(-3.0, 3.0, 41)).ravel()
    grid = np.concatenate([np.geomspace(1.0, top, 400), near[(near > 1.0) & (near < top)]])
    grid = np.unique(grid)
    L = np.concatenate([axis.open_loop(part) for part in np.array_split(grid, len(grid) // 50)])

    def root(part, i):
        return brentq(lambda w: float(part(axis.open_loop([w])[0])), grid[i], grid[i + 1], xtol=1e-9, rtol=1e-9)

    size = np.log(np.abs(L))
    gains = [root(lambda z: np.log(abs(z)), i) for i in np.flatnonzero(size[:-1] * size[1:] < 0.0)]
    real = [i for i in np.flatnonzero(L.imag[:-1] * L.imag[1:] < 0.0) if L[i].real < 0.0 and grid[i + 1] < 0.999 * top]
    phases = [root(lambda z: z.imag, i) for i in real]
    factors = [1.0 / abs(axis.open_loop([w])[0]) for w in phases]
    end = axis.open_loop([top])[0].real
    if end < 0.0:
        factors.append(-1.0 / end)
    return np.degrees(np.angle(-axis.open_loop(gains))), np.array(factors)
