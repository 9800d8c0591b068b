"""The phase portrait of a proof: motions are those of SciPy, the boundary is a level of V through the saddles."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import strainwave as sw
from strainwave.plot.panels import panels_of

SOFT = sw.Oscillator(1.0, 0.3, sw.Cubic(1.0, -0.25), sw.Harmonic(0.0), 1.0)
LIGHT = sw.HDC_40_050.error_equation(motor_torque=sw.Harmonic(10.0), omega=10.47)
LAWS = {
    "hardening": LIGHT,
    "softening": SOFT,
    "softening under a torque": SOFT._replace(excitation=sw.Harmonic(0.0, mean=0.2)),
    "one saddle": SOFT._replace(law=sw.Polynomial((0.0, 1.0, 0.4))),
    "three slopes": SOFT._replace(law=sw.PiecewiseLinear(2.0, 3.0, 4.0, 0.5, 1.5)),
    "backlash": SOFT._replace(law=sw.Backlash(1.0, 0.5)),
    "linear, overdamped": SOFT._replace(B=7.0, law=sw.Linear(1.0)),
}


def curves(system, label):
    (panel,) = panels_of(sw.lyapunov(system))
    return [curve for curve in panel.curves if curve.label == label]


def times_damped(system):
    """Factor of the damping that the title says; 1 where it says none."""
    (panel,) = panels_of(sw.lyapunov(system))
    return int(panel.title.split(", ")[1].split()[0]) if "," in panel.title else 1


@pytest.mark.parametrize("name", LAWS)
def test_a_dozen_motions_fall_through_the_levels_of_v_to_the_rest(name):
    proof = sw.lyapunov(LAWS[name])
    motions = curves(LAWS[name], "motions")
    assert len(motions) == 12
    top = proof.V(motions[0].x[0], motions[0].y[0])
    for motion in motions:
        assert proof.contains(float(motion.x[0]), float(motion.y[0]))
        V = proof.V(motion.x, motion.y)
        assert V[0] == pytest.approx(top, rel=0.02)  # all from one level
        assert np.all(np.diff(V) < 1e-6 * V[0])
        assert V[-1] < 0.05 * V[0]


@pytest.mark.parametrize("name", ["hardening", "softening under a torque", "one saddle"])
def test_motions_are_on_those_of_scipy_with_the_damping_that_the_title_says(name):
    proof, times = sw.lyapunov(LAWS[name]), times_damped(LAWS[name])
    drawn = proof.system._replace(B=times * proof.system.B)
    for motion in curves(LAWS[name], "motions")[::4]:
        start, sizes = (motion.x[0], motion.y[0]), (np.ptp(motion.x), np.ptp(motion.y))
        end = 20.0 * drawn.J / drawn.B
        exact = solve_ivp(drawn.rhs, (0.0, end), start, "DOP853", np.linspace(0.0, end, 40001), rtol=1e-10, atol=1e-12)
        for x, v in list(zip(motion.x, motion.y, strict=True))[::40]:
            assert np.min(np.hypot((exact.y[0] - x) / sizes[0], (exact.y[1] - v) / sizes[1])) < 1e-3


def test_a_turn_of_a_light_damping_is_drawn_to_decay_like_many():
    """Over so many turns of the drive itself, integrated by SciPy, the amplitude falls as over one that is drawn."""
    times, drive = times_damped(LIGHT), sw.lyapunov(LIGHT).system
    assert times > 100
    assert times_damped(LAWS["linear, overdamped"]) == 1
    motion = curves(LIGHT, "motions")[0]
    crests = [np.interp(0.0, -motion.y[i : i + 2], motion.x[i : i + 2]) for i in down(motion.y)][
        1:3
    ]  # small ones: a/2.6
    assert crests[0] > crests[1] > 0.0

    def turned(_, y):
        return y[1]

    turned.direction = -1.0
    end = 1.05 * times * 2.0 * np.pi / sw.HDC_40_050.omega_0
    run = solve_ivp(drive.rhs, (0.0, end), (crests[0], 0.0), "DOP853", events=turned, rtol=1e-9, atol=1e-12)
    assert run.y_events[0][times][0] == pytest.approx(crests[1], rel=0.1)  # of second order in the damping drawn


def down(v):
    """Places where a rate falls through zero."""
    return np.flatnonzero((v[:-1] > 0.0) & (v[1:] <= 0.0))


@pytest.mark.parametrize(("name", "saddles"), [("softening", 2), ("softening under a torque", 2), ("one saddle", 1)])
def test_the_boundary_is_the_level_of_the_lower_saddle_and_motions_leave_beyond_the_saddles(name, saddles):
    proof = sw.lyapunov(LAWS[name])
    (boundary,), (marks,) = curves(LAWS[name], "boundary of the stability region"), curves(LAWS[name], "saddle")
    assert len(marks.x) == saddles
    assert all(x in proof.equilibria for x in marks.x)
    drawn = np.isfinite(boundary.y) & (boundary.y != 0.0)
    assert proof.V(boundary.x[drawn], boundary.y[drawn]) == pytest.approx(proof.region.energy_limit, rel=1e-9)
    assert np.min(proof.V(marks.x, 0.0 * marks.x)) == pytest.approx(proof.region.energy_limit, rel=1e-9)
    leaving = curves(LAWS[name], "motions that escape")
    assert len(leaving) == saddles
    for motion in leaving:
        assert abs(motion.x[-1]) > 1.5 * abs(motion.x[0])


@pytest.mark.parametrize(
    "system",
    [
        SOFT._replace(B=1e4),
        SOFT._replace(law=sw.PiecewiseLinear(340.0, 440.0, 540.0, 0.29, 0.75), excitation=sw.Harmonic(0.0, mean=1e6)),
        SOFT._replace(B=1e-9, law=sw.Linear(1e9)),
    ],
    ids=["overdamped 5000 times", "a rest far beyond the corners", "next to no damping"],
)
def test_extreme_drives_are_drawn_with_a_v_that_never_rises(system):
    proof = sw.lyapunov(system)
    for motion in curves(system, "motions"):
        assert np.all(np.diff(proof.V(motion.x, motion.y)) < 1e-6 * proof.V(motion.x[0], motion.y[0]))


def test_a_global_claim_has_neither_boundary_nor_saddle():
    assert curves(LIGHT, "boundary of the stability region") == curves(LIGHT, "saddle") == []


def test_a_law_of_the_user_that_takes_numbers_alone_is_drawn_as_far_as_it_was_examined():
    class Stop(sw.Linear):
        def torque(self, x):
            return self.K * (x if x < 0.5 else 2.0 * x - 0.5)

        def stiffness(self, x):
            return self.K if x < 0.5 else 2.0 * self.K

        def energy(self, x):
            return self.K * (0.5 * x * x if x < 0.5 else x * x - 0.5 * x + 0.125)

    (panel,) = panels_of(sw.lyapunov(SOFT._replace(law=Stop(1.0)), span=1.0))
    assert panel.xlim == pytest.approx((-1.03, 1.03))


def test_damping_that_changes_is_drawn_as_it_is():
    system = sw.gears.VaryingOscillator(1.0, sw.gears.GearDamping(0.2), sw.Cubic(1.0, -0.2), sw.Harmonic(0.0), 2.0)
    (panel,) = panels_of(sw.lyapunov(system))
    assert "damping" not in panel.title
    assert any(curve.label == "boundary of the stability region" for curve in panel.curves)


def test_where_nothing_is_claimed_there_is_no_figure():
    proof = sw.lyapunov(SOFT._replace(B=-0.1))
    assert panels_of(proof) == []
    with pytest.raises(TypeError, match="there is no figure of"):
        proof.plot()


def test_the_proof_draws_itself():
    axes = sw.lyapunov(SOFT).plot()
    assert axes.get_xlabel() == "x (rad)"
    assert len(axes.lines) > 12
