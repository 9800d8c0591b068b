"""Project files of drives at random: law, hysteresis or gap, motor, load and its torque, orders, limit, a move."""

import math

import numpy as np

ARCSEC = math.pi / 648000.0
LAWS = {
    "linear": "{{type: linear, K: {K:.6g} N*m/rad}}",
    "hardening": "{{type: cubic, K: {K:.6g} N*m/rad, alpha: {up:.6g} 1/rad^2}}",
    "softening": "{{type: cubic, K: {K:.6g} N*m/rad, alpha: -{down:.6g} 1/rad^2}}",
    "three slopes": "{{type: piecewise_linear, K1: {K:.6g} N*m/rad, K2: {K2:.6g} N*m/rad, K3: {K3:.6g} N*m/rad, "
    "T1: {T1:.6g} N*m, T2: {T2:.6g} N*m}}",
}
BESIDE = {
    "none": "",
    "hysteresis": "hysteresis: {{type: bouc_wen, K: {K_h:.5g} N*m/rad, ratio: 0, yield_twist: {yields:.4g} rad}}\n",
    "gap": "backlash: {{half_gap: {gap:.4g} rad}}\n",
}
MOTORS = {
    "held": "mode: held",
    "position": "loop: {{type: position, bandwidth: {hertz:.4g} Hz, damping: {zeta:.3g}}}",
    "speed": "loop: {{type: speed, bandwidth: {hertz:.4g} Hz, damping: {zeta:.3g}, lag: 0.3 ms}}, "
    "drag: {{type: coulomb, T_c: {T_c:.4g} N*m}}",
}
LOADS = {
    "plain": "",
    "gravity": ", drag: {{type: angle_torque, amplitude: {weight:.4g} N*m}}",
    "coupling": ", coupling: {{inertia: {J_g:.4g} kg*m^2, B: {B_g:.4g} N*m*s/rad, "
    "law: {{type: linear, K: {K_g:.5g} N*m/rad}}}}",
}
TORQUES = {
    "none": "",
    "mean": ", load_torque: {{mean: -{weight:.4g} N*m}}",
    "range": ", load_torque: {{mean: {{from: -{weight:.4g} N*m, to: 0 N*m}}}}",
}
MOVE = "move: {{profile: [{{type: s_curve, angle: 60 deg, time: 0.5 s}}]}}\n"


def project_text(
    rng: np.random.Generator, law: str, beside: str, motor: str, load: str = "plain", torque: str = "none"
) -> str:
    """A project file of a drive of these parts, with numbers at random."""
    N, J, K = int(rng.choice([50, 80, 100, 160])), 10 ** rng.uniform(-0.5, 1.0), 10 ** rng.uniform(4.2, 5.2)
    reach, ratio, omega_0 = 10 ** rng.uniform(-3.6, -3.0), rng.uniform(0.02, 0.08), math.sqrt(K / J)
    weight = K * reach * rng.uniform(0.2, 1.0)
    orders = sorted(rng.choice([1, 2, 3, 4, 6], int(rng.integers(1, 4)), replace=False).tolist())
    numbers = {
        "N": N, "J": J, "J_m": J / N**2 * 10 ** rng.uniform(-0.5, 0.6) * 1e4, "B": 2.0 * ratio * math.sqrt(K * J),
        "K": K, "K2": 1.5 * K, "K3": 1.8 * K, "T1": K * reach, "T2": 2.2 * K * reach,
        "up": rng.uniform(0.05, 0.5) / reach**2, "down": rng.uniform(0.005, 0.02) / reach**2,
        "K_h": K * rng.uniform(0.05, 0.4), "yields": reach * rng.uniform(0.1, 0.4),
        "gap": reach * rng.uniform(0.05, 0.3),
        "hertz": omega_0 / math.tau * rng.uniform(0.7, 3.0), "zeta": rng.uniform(0.6, 1.0), "T_c": 0.1 * weight / N,
        "weight": weight, "J_g": 0.1 * J, "B_g": 0.02 * math.sqrt(K * J), "K_g": 6.0 * K,
        "low": omega_0 * rng.uniform(0.15, 0.35), "high": omega_0 * rng.uniform(1.0, 1.6),
        "limit": reach * 10 ** rng.uniform(-0.5, 0.3) / ARCSEC,
    }  # fmt: skip
    errors = ", ".join(
        f"{{{{order: {k}, amplitude: {reach * ratio * rng.uniform(0.3, 1.5) / ARCSEC:.4g} arcsec, "
        f"phase: {rng.uniform(-180.0, 180.0):.1f} deg}}}}"
        for k in orders
    )
    form = (
        f"gear: {{{{ratio: {{N}}, law: {LAWS[law]}}}}}\n{BESIDE[beside]}"
        f"motor: {{{{inertia: {{J_m:.5g}} kg*cm^2, {MOTORS[motor]}}}}}\n"
        f"load: {{{{inertia: {{J:.5g}} kg*m^2{LOADS[load]}}}}}\n"
        "damping: {{B: {B:.5g} N*m*s/rad}}\n"
        "speed: {{from: {low:.6g} rad/s, to: {high:.6g} rad/s, shaft: motor}}\n"
        f"excitation: {{{{kinematic_error: [{errors}]{TORQUES[torque]}}}}}\n"
        "limit: {{oscillation: {limit:.5g} arcsec}}\n"
    )
    return (form + MOVE).format(**numbers)


def drive_at_random(rng: np.random.Generator) -> str:
    """A project file of a drive with any of the parts."""
    law, motor, load = (str(rng.choice(list(parts))) for parts in (LAWS, MOTORS, LOADS))
    beside = str(rng.choice(list(BESIDE), p=[0.5, 0.35, 0.15]))
    torque = "none" if load == "gravity" else str(rng.choice(list(TORQUES)))
    return project_text(rng, law, beside, motor, load, torque)
