"""Made logs of joints for `identify_log`: two inertias by hand, set-valued friction, independent of the package.

    python benchmarks/joint_logs.py reversing 30      # or: rests, oneway, outside, current; how many

The motor has a sampled cascade; fourth-order steps of 1/16000 s, friction of the load that sticks. Seeds are fixed.
"""

import sys
import time

import numpy as np
from numba import njit
from scipy.interpolate import CubicSpline

import strainwave as sw

ARCSEC, TURN = np.pi / 648_000, 2.0 * np.pi
STEP = 1.0 / 16_000.0
GEARS = {  # K1, K2, K3, T1, T2, ratio, motor inertia
    "CSG-17-100": (10000.0, 14000.0, 16000.0, 3.9, 12.0, 100.0, 0.079e-4),
    "CSG-25-100": (31000.0, 50000.0, 57000.0, 14.0, 48.0, 100.0, 0.413e-4),
    "CSG-32-80": (67000.0, 110000.0, 120000.0, 29.0, 108.0, 80.0, 1.69e-4),
    "CSG-40-50": (100000.0, 140000.0, 180000.0, 54.0, 196.0, 50.0, 4.5e-4),
}


@njit(cache=True)
def spring(x, K1, K2, K3, T1, T2, gap, uneven):
    a = max(abs(x) - gap, 0.0)
    x1 = T1 / K1
    x2 = x1 + (T2 - T1) / K2
    t = K1 * a if a < x1 else (T1 + K2 * (a - x1) if a < x2 else T2 + K3 * (a - x2))
    return t * (1.0 + uneven) if x >= 0.0 else -t * (1.0 - uneven)


@njit(cache=True)
def rates(y, u, sign, p, lines):
    """Rates of motor angle, speed, torsion, its rate, hysteresis, second mode (angle, speed); torque on the load."""
    N, Jm, Jl, B, Kb, xy, G, phi, Fv, drag, Fcm, Fvm, mu, J2, w2 = p[:15]
    qm, vm, x, vx, z, r, vr = y
    ql, vl = qm / N - x, vm / N - vx
    e, d, dl = 0.0, 0.0, 0.0
    for i in range(lines.shape[0]):
        a = lines[i, 0] * qm + lines[i, 1] * ql + lines[i, 3]
        e += lines[i, 2] * np.cos(a)
        d -= lines[i, 2] * lines[i, 0] * np.sin(a)
        dl -= lines[i, 2] * lines[i, 1] * np.sin(a)
    vg = vx - d * vm - dl * vl
    T = spring(x - e, p[15], p[16], p[17], p[18], p[19], p[20], p[21]) + B * vg + Kb * z
    dz = vg - abs(z / xy) * (0.5 * abs(vg) * np.sign(z) + 0.5 * vg)
    fm = vm / np.sqrt(vm * vm + 0.25) * (Fcm + 0.6 * Fcm * np.exp(-((vm / 3.0) ** 2)) + mu * abs(T) / N) + Fvm * vm
    am = (u - fm - (1.0 / N - d) * T) / Jm
    mode = J2 * (w2 * w2 * r + 0.02 * w2 * vr)  # what a mass on the load does to it; r is its distance
    on = T - G * np.sin(ql + phi) - Fv * vl - drag * vl * abs(vl) + mode
    al = 0.0 if sign == 0.0 else (on - sign * p[22]) / Jl
    ar = -al - w2 * w2 * r - 0.02 * w2 * vr
    return np.array([vm, am, vx, am / N - al, dz, vr, ar]), on


@njit(cache=True)
def stepped(y, u, sign, p, lines, h):
    k1 = rates(y, u, sign, p, lines)[0]
    k2 = rates(y + 0.5 * h * k1, u, sign, p, lines)[0]
    k3 = rates(y + 0.5 * h * k2, u, sign, p, lines)[0]
    k4 = rates(y + h * k3, u, sign, p, lines)[0]
    return y + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)


@njit(cache=True)
def loose(y, u, p, lines):
    """Which way a load at rest is pushed off: 0 where it sticks."""
    on = rates(y, u, 0.0, p, lines)[1]
    return 0.0 if abs(on) <= p[22] else np.sign(on)


@njit(cache=True)
def run(ref, every, p, lines, gains):
    """Motor angle, load angle, motor speed, torque, torsion at every step."""
    Kp, Kv, Ki = gains
    n, N, h = ref.shape[0], p[0], STEP
    y = np.zeros(7)
    y[0], y[1] = ref[0, 0], ref[0, 1]
    hold, x = p[6] * np.sin(y[0] / N + p[7]), 0.0
    for _ in range(200):
        x -= (spring(x, p[15], p[16], p[17], p[18], p[19], p[20], p[21]) - hold) / p[17]
    y[2] = x
    sum_ = u = hold / N
    out = np.zeros((n, 5))
    sign = np.sign(y[1])
    for k in range(n):
        if k % every == 0:
            ev = ref[k, 1] + Kp * (ref[k, 0] - y[0]) - y[1]
            sum_ += Ki * ev * h * every
            u = Kv * ev + sum_
        out[k] = np.array([y[0], y[0] / N - y[2], y[1], u, y[2]])
        if sign == 0.0:
            sign = loose(y, u, p, lines)
        before = y[1] / N - y[3]
        after = stepped(y, u, sign, p, lines, h)
        vl = after[1] / N - after[3]
        if sign != 0.0 and vl * sign < 0.0 < before * sign:  # at rest for a moment: it sticks unless it is pushed on
            part = before / (before - vl)
            y = stepped(y, u, sign, p, lines, part * h)
            y[3] = y[1] / N
            sign = loose(y, u, p, lines)
            y = stepped(y, u, sign, p, lines, (1.0 - part) * h)
        else:
            y = after
        if sign == 0.0:
            y[3] = y[1] / N
    return out


def profile(motion, T, t, w, rng):
    """Reference angle and speed (n, 2) of the motor."""
    if motion == "runup":
        v = np.interp(t, [0.0, T], [0.45 * w, 1.5 * w])
    elif motion == "constant":
        v = np.interp(t, [0.0, 0.1 * T, T], [0.0, 0.7 * w, 0.7 * w])
    elif motion == "tofro":
        v = np.interp(t, np.array([0.0, 0.05, 0.2, 0.4, 0.5, 0.6, 0.8, 0.95, 1.0]) * T,
                      [0.0, 0.0, 1.3 * w, 1.3 * w, 0.0, -1.3 * w, -1.3 * w, 0.0, 0.0])  # fmt: skip
    else:
        v, d = np.zeros_like(t), T / 6.0
        shares = [0.1, 0.25, 0.35, 0.5] if motion == "rests" else [0.0, 0.3, 0.6, 0.9]
        for i in range(6):
            top = rng.uniform(0.3, 1.6) * w * (1 if i % 2 == 0 else -1)
            v += np.interp(t, i * d + d * np.array(shares), [0.0, top, top, 0.0], left=0.0, right=0.0)
    return np.column_stack([np.concatenate([[0.0], np.cumsum(0.5 * (v[1:] + v[:-1])) * STEP]), v])


def made(seed, motion=None, outside=None, shaft=None):
    """A log (dict of channels), and the truth (dict); another drive where the loop of the motor is unstable.

    With `shaft`, the motor's Coulomb [N*m], viscous [N*m*s/rad] and load-proportional friction, or True for drawn ones,
    it has a current.
    """
    rng = np.random.default_rng(seed)
    gear = str(rng.choice(list(GEARS)))
    motion = motion or str(rng.choice(["tofro", "trapezoids"]))
    K1, K2, K3, T1, T2, N, Jm = GEARS[gear]
    law = np.array([K1, K2, K3, T1, T2]) * (1.0 + rng.uniform(-0.1, 0.1, 5))
    J = K1 / (TURN * rng.uniform(9.0, 18.0)) ** 2
    B = J * np.sqrt(law[0] / J) / rng.uniform(12.0, 35.0)
    A, phases = rng.uniform(20.0, 45.0) * ARCSEC, rng.uniform(-3.0, 3.0, 4)
    lines = [[2.0, 0.0, A, phases[0]]]
    for i, (j, k, most) in enumerate(((4.0, 0.0, 0.4), (2.0, 2.0, 0.4), (1.0, 0.0, 0.3)), 1):
        if rng.random() < 0.6:
            lines.append([j, k, rng.uniform(0.1, most) * A, phases[i]])
    yield_twist = rng.uniform(0.15, 0.4) * np.pi / 10800
    hysteresis = rng.choice([0.0, rng.uniform(0.01, 0.05)]) * T2
    G, phi = rng.uniform(0.0, 0.5) * T2, rng.uniform(-1.0, 1.0)
    Fc, Fv = rng.uniform(0.0, 0.02, 2) * T2 * np.array([1.0, 0.5])
    Fm = rng.uniform(0.01, 0.05) * T2 / N
    motor_friction, own = (Fm, Fm / 100.0, 0.1), np.random.default_rng(seed + 50_000)
    if shaft is not None:
        drawn = Fm, Fm * own.uniform(0.002, 0.02), own.uniform(0.0, 0.15)
        motor_friction = drawn if shaft is True else shaft
    gap, uneven, drag, J2, w2 = 0.0, 0.0, 0.0, 0.0, 1.0
    w = np.sqrt(K1 / J) / 2.0
    if outside == "gap":
        gap = rng.uniform(10.0, 40.0) * ARCSEC
    elif outside == "asymmetry":
        uneven = rng.uniform(0.05, 0.15)
    elif outside == "drag":
        drag = rng.uniform(0.02, 0.08) * T2 / (w / N) ** 2
    elif outside == "resonance":
        J2, w2 = rng.uniform(0.05, 0.2) * J, np.sqrt(K1 / J) * rng.uniform(1.6, 3.5)
        J -= J2
    p = np.array([N, Jm, J, B, hysteresis / yield_twist, yield_twist, G, phi, Fv, drag, *motor_friction, J2, w2,
                  *law, gap, uneven, Fc])  # fmt: skip
    T, rate = 6.0, float(rng.choice([250.0, 500.0, 1000.0, 2000.0, 4000.0]))
    t = np.arange(int(T / STEP) + 200) * STEP
    motor = Jm + (J + J2) / N**2
    wb = TURN * 12.0
    out = run(profile(motion, T, t, w, rng), 4, p, np.array(lines), (wb / 2.0, 3.0 * motor * wb, 1.5 * motor * wb**2))
    if not np.all(np.isfinite(out)):
        return made(seed + 100_000, motion, outside, shaft)
    stamps = np.arange(2, int(T * rate) - 1) / rate
    if jitter := float(rng.choice([0.0, 0.02, 0.2])):
        stamps = stamps + rng.uniform(-jitter, jitter, len(stamps)) / rate
    if rng.random() < 0.5:
        stamps = stamps[rng.random(len(stamps)) > 0.005]
    skew, noise, bits = rng.uniform(0.0, 1e-3), 0.0 if motion == "rests" else 0.3, rng.integers(17, 25, 2)
    qm = CubicSpline(t, out[:, 0])(stamps)
    ql = CubicSpline(t, out[:, 1])(stamps + skew)
    unit = TURN / 2.0**bits
    floor = np.hypot(noise * ARCSEC, unit[1] / np.sqrt(12.0))
    log = {
        "time": stamps,
        "motor_angle": np.round(qm / unit[0]) * unit[0],
        "load_angle": np.round((ql + 0.3 + noise * ARCSEC * rng.standard_normal(len(ql))) / unit[1]) * unit[1],
    }
    reach = float(np.max(np.abs(spring_of(out[:, 4], law))))
    truth = dict(zip(("K1", "K2", "K3", "T1", "T2"), law.tolist(), strict=True)) | {
        "B": B, "skew": skew, "coulomb": Fc, "viscous": Fv, "gravity": G, "J": J + J2, "gear": gear, "motion": motion,
        "floor": floor, "reach": reach, "rate": rate, "bits": bits, "hysteresis": hysteresis, "yield": yield_twist,
        "lines": {(int(a), int(b)): c for a, b, c, _ in lines}, "N": N,
    }  # fmt: skip
    if shaft is not None:
        names = ("motor_inertia", "motor_coulomb", "motor_viscous", "motor_load_friction")
        log["current"], more = current_of(out[:, 3], t, stamps, own)
        truth |= more | dict(zip(names, (Jm, *motor_friction), strict=True))
    return log, truth


def current_of(u, t, stamps, rng):
    """Current [A] of a motor's torque, a mean over a period of the control: noise, an offset, a skew, counts."""
    constant, skew, bits = rng.uniform(0.03, 0.3), rng.uniform(-5e-4, 2e-3), rng.integers(10, 15)
    exact = np.interp(stamps + skew, t + 2.0 * STEP, np.convolve(u, np.ones(4) / 4.0)[3:]) / constant
    most = np.max(np.abs(exact))
    noise, offset = rng.uniform(0.002, 0.02) * most, rng.uniform(-0.03, 0.03) * most
    step = 2.4 * most / 2.0**bits
    read = np.round((exact + offset + noise * rng.standard_normal(len(exact))) / step) * step
    return read, {"torque_constant": constant, "current_skew": skew}


def spring_of(x, law):
    """Torques of torsions (n,)."""
    return np.array([spring(v, *law, 0.0, 0.0) for v in x[::16]])


NUMBERS = ("K1", "K2", "K3", "T1", "T2", "B", "skew", "coulomb", "viscous", "gravity", "line(2, 0)")
OF_CURRENT = ("torque_constant", "motor_inertia", "motor_coulomb", "motor_viscous", "motor_load_friction",
              "current_skew")  # fmt: skip
RELATIVE = ("K1", "K2", "K3", "T1", "T2", "B", "gravity", "line(2, 0)", *OF_CURRENT[:4])


def fitted(log, truth):
    """What `identify_log` finds with its defaults, and the CPU time it takes."""
    start = time.process_time()
    found = sw.identify_log(log, gear=truth["gear"], load_inertia=truth["J"])
    return found, time.process_time() - start


def held_out(log, truth):
    """Residual of the last 30 % by numbers from the first 70 %, over the floor."""
    t = log["time"]
    cut = t[0] + 0.7 * (t[-1] - t[0])
    head = {name: values[t < cut] for name, values in log.items()}
    found = sw.identify_log(head, gear=truth["gear"], load_inertia=truth["J"])
    rest = np.concatenate([residual[times > cut] for times, residual in found.residuals(log)])
    return float(np.sqrt(np.mean(rest**2)) / truth["floor"])


def errors(found, truth):
    """Error and deviation of each number that is told, and whether its interval covers."""
    of = truth | {"line(2, 0)": truth["lines"][2, 0]}
    rows = {}
    for name in (*NUMBERS, *OF_CURRENT):
        try:
            value, (low, high) = found.value(name), found.interval(name, 0.95)
        except ValueError:
            continue
        error = value - of[name]
        rows[name] = (abs(error) / (of[name] if name in RELATIVE else 1.0), low <= of[name] <= high)
    return rows


def reversing(many, first=1, held=True, shaft=None, motion=None):
    """Errors, coverage and time of logs with reversals."""
    rows, full, cpu, out = {name: [] for name in (*NUMBERS, *OF_CURRENT)}, 0, [], {"tofro": [], "trapezoids": []}
    for seed in range(first, first + many):
        log, truth = made(seed, motion, shaft=shaft)
        found, seconds = fitted(log, truth)
        told = errors(found, truth)
        full += found.usable and {"K1", "B", "skew", "coulomb", "gravity"} <= set(told)
        cpu.append(seconds)
        for name, row in told.items():
            rows[name].append(row)
        if held:
            out[truth["motion"]].append(held_out(log, truth))
        missed = ", ".join(f"{name} {error:.2g}" for name, (error, covers) in told.items() if not covers)
        over = found.answer.residual / truth["floor"]
        drive = f"{seed} {truth['gear']} {truth['motion']} {truth['rate']:g} Hz {truth['bits']}"
        said = "" if found.usable else found.headline()
        print(f"{drive} {over:.3f} floors, {seconds:.1f} s; missed: {missed or 'none'}; {said}", flush=True)
    print(f"full answers {full} of {many}; CPU {np.median(cpu):.2f} s in the median")
    for name, some in rows.items():
        if some:
            size = np.array([error for error, _ in some])
            covers = np.mean([covers for _, covers in some])
            print(f"{name:19} {len(some):4} told, median {np.median(size):.2g}, 90 % {np.quantile(size, 0.9):.2g}, "
                  f"covers {100 * covers:.1f} %")  # fmt: skip
    pooled = [covers for some in rows.values() for _, covers in some]
    print(f"all intervals cover {100 * np.mean(pooled):.2f} % of {len(pooled)}")
    for motion, some in out.items():
        if some:
            print(f"{motion}: held-out within 1.5 floors in {100 * np.mean(np.array(some) < 1.5):.0f} % of {len(some)}")


def rests(many, first=9001):
    """Logs with rests of half a second between moves, of an encoder that counts without noise."""
    reversing(many, first, held=False, motion="rests")


def current(many, first=3001):
    """Logs with a current of the motor: 24 of them are in benchmarks/README.md."""
    reversing(many, first, held=False, shaft=True)


def oneway(many, first=1001):
    """Logs of one direction, or one speed: which numbers are said to be unknown."""
    said = wrong = 0
    for seed in range(first, first + many):
        log, truth = made(seed, "runup" if seed % 2 else "constant")
        found, _ = fitted(log, truth)
        names = {name for group, _ in found.tied for name in group}
        right = {"coulomb", "skew"} <= names
        said, wrong = said + right, wrong + bool({"coulomb", "skew", "viscous"} & set(found.values))
        missed = [name for name, (_, covers) in errors(found, truth).items() if not covers]
        print(seed, truth["motion"], truth["gear"], found.headline(), sorted(names), "missed", missed, flush=True)
    print(f"unknown numbers said in {said} of {many}; a number for one of them in {wrong}")


def warned(found, kind):
    """Whether an answer is refused, or says that more moves the load, or that it saw torques of one sign only."""
    unseen = kind in ("gap", "asymmetry") and "asymmetry" in found.unidentified
    return not found.usable or found.answer.more > 0.0 or unseen


def outside(many, first=2001):
    """Logs of machines outside the class: refused or named."""
    kinds, named = ("gap", "asymmetry", "drag", "resonance"), 0
    for seed in range(first, first + many):
        kind = kinds[seed % 4]
        log, truth = made(seed, outside=kind)
        found, seconds = fitted(log, truth)
        named += warned(found, kind)
        print(seed, kind, truth["gear"], truth["motion"], found.headline(), f"{seconds:.1f} s", flush=True)
    print(f"refused or named {named} of {many}")


if __name__ == "__main__":
    study = {"reversing": reversing, "rests": rests, "oneway": oneway, "outside": outside, "current": current}[
        sys.argv[1]
    ]
    study(*(int(number) for number in sys.argv[2:]))
