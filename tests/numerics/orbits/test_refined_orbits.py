"""Orbits of laws with memory are refined by shooting: beside them SciPy's integration of the same equations."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import strainwave as sw
from strainwave.base.results import Status
from strainwave.numerics import shooting
from strainwave.numerics.steady import settle


@pytest.mark.slow
def test_an_orbit_with_hysteresis_is_that_of_an_integration_that_has_settled():
    # At this speed a step of Newton's method stays above the tolerance of the finest integration.
    J, B, ratio, limit, F, omega = 0.9144449594, 0.04758858562, 0.3326170325, 0.4418159468, 0.3672845472, 1.1
    system = sw.Oscillator(J, B, sw.BoucWen(1.0, ratio, limit), sw.Harmonic(F), omega)

    def rhs(t, y):
        x, v, z = y
        torque = ratio * x + (1.0 - ratio) * z
        slip = abs(z / limit) * (0.5 * abs(v) * np.sign(z) + 0.5 * v)
        return v, (F * np.cos(omega * t) - B * v - torque) / J, v - slip

    turn = 2.0 * np.pi / omega  # a disturbance shrinks to 0.31 in each
    start = solve_ivp(rhs, (0.0, 20.0 * turn), (0.0, 0.0, 0.0), method="DOP853", rtol=1e-10, atol=1e-12).y[:, -1]
    times = np.linspace(0.0, turn, 4001)
    end = solve_ivp(rhs, (0.0, turn), start, t_eval=times, method="DOP853", rtol=1e-10, atol=1e-12, max_step=turn / 400)
    orbit = sw.find_orbit(system)
    assert orbit.status
    assert orbit.peak == pytest.approx(np.max(np.abs(end.y[0])), rel=1e-6)
    assert orbit.state(0.0)[:2] == pytest.approx(end.y[:2, 0], rel=1e-6)


FAR = [(0.1, 0.1, 0.2, 1.1, start) for start in ((-2.0, 0.0), (2.0, 1.0), (0.0, -2.0), (0.5, 2.0))]
CREEPING = [  # B, alpha, forcing, omega, start: Newton's method begins anew more often
    (0.04818584019180427, 0.18478026596501337, 0.16863489125613576, 1.4683012382163327, (1.84818649, -1.74073692)),
    (0.04214907211877238, 0.23638880035316392, 0.0978059164275667, 1.4559924580771164, (-1.91522335, -1.8797595)),
]


@pytest.mark.slow
@pytest.mark.parametrize(("B", "alpha", "force", "omega", "start"), FAR + CREEPING)
def test_shooting_from_far_away_finds_a_motion_on_which_an_integration_stays(B, alpha, force, omega, start):
    system = sw.Oscillator(1.0, B, sw.Cubic(1.0, alpha), sw.Harmonic(force), omega)
    period = 2.0 * np.pi / omega

    def rates(t, y):
        return y[1], force * np.cos(omega * t) - B * y[1] - y[0] - alpha * y[0] ** 3

    orbit = sw.numerics.shoot(system, start)
    assert orbit.status
    begin = orbit.state(0.0) if alpha > 0.1 else start
    settled = solve_ivp(rates, (0.0, 100.0 * period), begin, rtol=1e-10, atol=1e-12).y[:, -1]
    assert orbit.state(0.0) == pytest.approx(settled, abs=1e-6)


@pytest.mark.parametrize("law", [sw.Cubic(1.0, 0.5), sw.BoucWen(1.0, 0.3, 0.4)])
def test_an_interrupt_while_an_orbit_is_closed_stops_the_study(law, monkeypatch):
    def stopped(*args, **how):
        return replace(sw.simulate(*args, **how), status=Status.INTERRUPTED)

    monkeypatch.setattr(shooting, "simulate", stopped)
    system = sw.Oscillator(1.0, 0.1, law, sw.Harmonic(0.2), 0.8)
    with pytest.raises(KeyboardInterrupt):
        settle(system, (0.1, 0.0, 0.0)[: 2 if isinstance(law, sw.Cubic) else 3], time=10.0)
