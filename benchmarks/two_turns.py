"""Random drives in two turns: both envelopes of the balance against an integration over three output turns.

    python benchmarks/two_turns.py --drives 50 --seed 5

Every drive has two lines or more of the kinematic error, of both turns, a hardening law, a motor held or with a loop or
a cascade, gravity or none, a linear or a hardening coupling or none. The integration begins at the state of the balance
at angle 0 and has one output turn to leave it; the next three count. Both are compared in the turns from angle 0 on.
Prints a line a drive: the envelopes, their differences, the growth of disturbances, and the time of the balance on the
thread.
"""

import argparse
import math
import time

import numpy as np
from scipy.integrate import simpson

import strainwave as sw
from strainwave.drive.two_turns import two_turn_motion
from strainwave.model.train.train_forms import AtLoad, own_state

PLACES, NEAR = 512, 3  # samples of a turn, and those to both sides of a crest


def drive_at_random(rng: np.random.Generator) -> sw.DriveTrain:
    """Drive whose order 2 is around its natural frequency."""
    N = float(rng.choice([30.0, 50.0, 51.0, 80.0, 101.0, 40.5]))
    K, J = 10 ** rng.uniform(4, 5), 10 ** rng.uniform(-0.3, 0.5)
    B, alpha = 2.0 * rng.uniform(0.02, 0.08) * math.sqrt(K * J), 10 ** rng.uniform(3.5, 5.0)
    orders = [2.0, 2.0 - 2.0 / N, *rng.permuted([4.0, 1.0 / N, 4.0 - 4.0 / N])[: rng.integers(3)]]
    size = rng.uniform(2e-5, 2e-4)
    error = sw.KinematicError(tuple(sw.Line(k, size * rng.uniform(0.3, 1.0), rng.uniform(0.0, 6.0)) for k in orders))
    J_m = J / N**2 * rng.uniform(0.5, 2.0)
    kind = str(rng.choice(["held", "position", "cascade"]))
    control = sw.train.Held()
    if kind != "held":
        control = sw.train.from_bandwidth(2.0 * math.pi * rng.uniform(15.0, 40.0), J_m + J / N**2, kind=kind)
    law, load = sw.Cubic(K, alpha), sw.train.Load(J)
    if rng.random() < 0.6:
        gravity = sw.train.AngleTorque(K * rng.uniform(2e-4, 1.2e-3), 1, rng.uniform(0.0, 6.0))
        load = load._replace(drag=gravity)
    if (behind := rng.random()) < 0.5:
        coupling = sw.Linear(3.0 * K) if behind < 0.25 else sw.Cubic(3.0 * K, alpha)
        load = sw.train.Elastic(0.3 * J, 0.01 * B, coupling, load._replace(J=0.7 * J))
    speed = 0.5 * math.sqrt(K / J) * rng.uniform(0.4, 1.6)
    return sw.DriveTrain(sw.train.Motor(J_m, control=control), N, B, law, load, speed, error)


def oscillations(error: np.ndarray, first: int) -> np.ndarray:
    """Largest |error - mean| of each turn from number `first` on, by a polynomial through samples around each crest."""
    sizes = []
    for begin in range(first * PLACES, len(error) - PLACES - NEAR, PLACES):
        mean = simpson(error[begin : begin + PLACES + 1]) / PLACES
        wide = np.abs(error[begin - NEAR : begin + PLACES + NEAR + 1] - mean)
        largest = float(np.max(wide[NEAR : NEAR + PLACES + 1]))
        places = np.arange(NEAR, len(wide) - NEAR)
        for j in places[(wide[places] > 0.95 * largest) & (wide[places] >= wide[places - 1])]:
            if wide[j] >= wide[j + 1]:
                p = np.polynomial.Polynomial.fit(np.arange(-NEAR, NEAR + 1), wide[j - NEAR : j + NEAR + 1], 2 * NEAR)
                x = np.linspace(-1.0, 1.0, 2001)
                largest = max(largest, float(np.max(p(x[(j + x >= NEAR) & (j + x <= NEAR + PLACES)]))))
        sizes.append(largest)
    return np.array(sizes)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--drives", type=int, default=50)
    parser.add_argument("--seed", type=int, default=5)
    parser.add_argument("--first", type=int, default=0, help="number of the first drive of the seed")
    given, worst, refused = parser.parse_args(), 0.0, 0
    print("drive    ratio waves   largest [rad]  differs  smallest [rad]  differs  growth [1/s]  time [s]")
    for i in range(given.first, given.first + given.drives):
        train = drive_at_random(np.random.default_rng([given.seed, i]))
        before = time.thread_time()
        try:
            motion = two_turn_motion(train, train.omega)
        except (ValueError, RuntimeError) as error:
            refused += 1
            print(f"{i:5d} {train.N:8g} {error}", flush=True)
            continue
        took, turns = time.thread_time() - before, motion.oscillations.shape[1]
        t = 2.0 * np.pi / train.omega * np.arange(4 * turns * PLACES + NEAR + 1) / PLACES
        start = own_state(AtLoad(train, train.omega), tuple(motion.states(0, np.zeros(1))[:, 0].tolist()))
        run = sw.simulate(train, start, t, method=sw.Dopri5(rtol=1e-11, atol=1e-15))
        sizes = oscillations(train.pointing_error(tuple(run.y)), turns)
        balanced = oscillations(motion.states(0, train.omega * t)[0], turns)
        own, other = ((np.max(some), np.min(some)) for some in (balanced, sizes))
        apart = [abs(a / b - 1.0) for a, b in zip(own, other, strict=True)]
        if motion.stable[0]:
            worst = max(worst, *apart)
        print(
            f"{i:5d} {train.N:8g} {len(motion.pairs):5d} {own[0]:15.8e} {apart[0]:8.1e} {own[1]:15.8e} {apart[1]:8.1e} "
            f"{motion.growth[0]:13.4g} {took:9.3f}",
            flush=True,
        )
    print(f"largest difference of stable motions {worst:.1e}; {refused} of {given.drives} drives refused")


if __name__ == "__main__":
    main()
