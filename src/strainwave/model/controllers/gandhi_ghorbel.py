"""The law of Gandhi & Ghorbel: the load's angle by the kinematic error, and a loop on it."""

from typing import Any, NamedTuple

from ...base.protocols import need
from ...base.quantities import Damping, Inertia, Ratio, Time, TorsionalStiffness


class GandhiGhorbel(NamedTuple):
    """Torque with which a rigid gear with kinematic error follows its reference, and PD gains on its output.

    With theta_l = theta_m/N - e(theta_m), Psi = 1/N - e' and Psi' = -e'' by the motor's angle, the torque is
    Psi (tau_d + K_p e_l + K_d e_l'), e_l = theta_r - theta_l, and tau_d = (J_m/Psi^2 + J_l) theta_r'' - J_m Psi'/Psi^4
    theta_r'^2 + (B_m/Psi^2 + B_l) theta_r'. On a rigid gear V = (J_m/Psi^2 + J_l) e_l'^2/2 + K_p e_l^2/2 decays for
    positive gains. The gear's compliance is not in the law. (Gandhi & Ghorbel, Closed-loop compensation of kinematic
    error in harmonic drives for precision control applications, IEEE Trans. Control Syst. Technol. 10(6), 2002,
    759-768; the form is that of claim 1 of US patent 6459940.)

    Its memory is the last deviation, the filtered rate, and whether there was a sample.
    """

    error: Any
    N: Ratio
    J_m: Inertia
    J_l: Inertia
    K_p: TorsionalStiffness
    K_d: Damping
    period: Time
    B_m: Damping = 0.0
    B_l: Damping = 0.0
    filter: Time = 0.0

    def start(self) -> Any:
        """Memory before the first sample."""
        return 0.0, 0.0, 0.0

    def update(self, state: Any, m: Any) -> Any:
        """Memory after a sample, and the torque [N*m]."""
        last, slow, begun = state
        e = self.error
        off = (m.reference - m.motor) / self.N + e.value(m.motor)
        raw = begun * (off - last) / self.period
        rate = slow + (raw - slow) * (self.period / (self.period + self.filter))
        psi, bend = 1.0 / self.N - e.slope(m.motor), -e.curvature(m.motor)
        speed, acceleration, square = m.speed / self.N, m.acceleration / self.N, psi * psi
        wanted = (
            (self.J_m / square + self.J_l) * acceleration
            - self.J_m * bend / (square * square) * speed * speed
            + (self.B_m / square + self.B_l) * speed
        )
        return (off, rate, 1.0 + 0.0 * begun), psi * (wanted + self.K_p * off + self.K_d * rate)

    def check(self) -> None:
        """Refuse an error that is none (TypeError), and gains that are not positive (ValueError)."""
        for method in ("value", "slope", "curvature"):
            need("GandhiGhorbel.error", self.error, method)
        for name in ("K_p", "K_d", "period"):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"GandhiGhorbel.{name} is {getattr(self, name):g}; it must be positive")
