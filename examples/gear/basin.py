"""
Is the drive stable, and from where?
====================================

A gear that softens, T = K (u + alpha u³) with alpha < 0, pushes back less and less, and beyond u = 1/sqrt(-alpha) it
pushes away. Lyapunov's method names a region that no motion leaves; 400 starts, integrated, attack that claim.

The number: energy of the lowest start that runs away, over the energy of the region, ``K/(4 |alpha|)``. The proof says
that it cannot be below 1; as little is dissipated before the drive is lost, it is not far above.
"""

import matplotlib.pyplot as plt
import numpy as np

import strainwave as sw

DRIVE = sw.Drive(J_m=4.5e-4, J_l=1.3, N=50.0, B=5.0, law=sw.Cubic(K=1e5, alpha=-1.5e4))


def comes_back(system, x, v):
    """Whether the motion from (x [rad], v [rad/s]) decays."""
    run = sw.simulate(system, (x, v), 0.5, method=sw.Dopri5(rtol=1e-7))
    return bool(run.status)


def main():
    system = DRIVE.error_equation(motor="free")
    proof = sw.lyapunov(system)
    region = proof.region
    x_edge, v_edge = region.x_high, np.sqrt(2 * region.energy_limit / DRIVE.J)
    starts = np.random.default_rng(0).uniform(-1.3, 1.3, (400, 2)) * (x_edge, v_edge)
    back = np.array([comes_back(system, x, v) for x, v in starts])
    inside = np.array([proof.contains(x, v) for x, v in starts])
    between = np.abs(starts[:, 0]) < x_edge
    assert back[inside].all(), "a start inside the region ran away: the proof is wrong"

    _, axes = plt.subplots(figsize=(7, 4), layout="constrained")
    x, v = np.meshgrid(np.linspace(-1.0, 1.0, 301) * x_edge, np.linspace(-1.3, 1.3, 301) * v_edge)
    axes.contourf(x * 1e3, v, proof.V(x, v), levels=[0, region.energy_limit], colors=["#9ecae1"])
    axes.plot(*(starts[back].T * [[1e3], [1]]), "o", ms=4, color="#0072B2", label="comes to rest")
    axes.plot(*(starts[~back].T * [[1e3], [1]]), "x", ms=5, color="#D55E00", label="runs away")
    axes.plot([-x_edge * 1e3, x_edge * 1e3], [0, 0], "kD", ms=6, label="saddles")
    axes.set(
        xlabel="dynamic error x (mrad)", ylabel="its rate x' (rad/s)", title="proved region (shaded) and 400 starts"
    )
    axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
    lost = starts[~back & between]
    return float(np.min(proof.V(lost[:, 0], lost[:, 1]))) / (1e5 / (4 * 1.5e4))


if __name__ == "__main__":
    print(f"lowest energy that runs away, over the limit of the proof: {main():.3f}")
    plt.show()
