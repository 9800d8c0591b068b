"""The binary of a unit without FMPy: friction under load over long steps, and a step that is refused and why."""

import ctypes
import zipfile

import numpy as np
from c_compiler import doubles, needs_cc
from scipy.integrate import solve_ivp

import strainwave as sw

MU, WIDTH, INERTIA, LOAD = 0.2, 0.1, 1e-5, -50.0
MOTOR = -LOAD / 50.0 * (1.0 + 0.3 * MU)
LOGGER = ctypes.CFUNCTYPE(
    None, ctypes.c_void_p, ctypes.c_char_p, ctypes.c_int, ctypes.c_char_p, ctypes.c_char_p, ctypes.c_char_p
)
SPEED, STUCK = 12, 101 + 3  # value references: motor_speed, and the state of the motor's speed


class Callbacks(ctypes.Structure):
    _fields_ = (
        ("log", LOGGER), ("allocate", ctypes.c_void_p), ("release", ctypes.c_void_p), ("done", ctypes.c_void_p),
        ("environment", ctypes.c_void_p),
    )  # fmt: skip


class Unit:
    """A unit of FMI 2.0 under constant torques."""

    def __init__(self, folder, train):
        path = sw.export(train, folder / "unit.fmu", to="fmu2").path
        with zipfile.ZipFile(path) as unit:
            binary = next(name for name in unit.namelist() if name.startswith("binaries/"))
            token = unit.read("sources/token.h").decode().split('"')[1]
            self.code = ctypes.CDLL(unit.extract(binary, folder))
        libc, self.said = ctypes.CDLL(None), []
        log = LOGGER(lambda _, __, ___, ____, text, _____: self.said.append(text.decode()))
        addresses = (ctypes.cast(getattr(libc, name), ctypes.c_void_p) for name in ("calloc", "free"))
        self.callbacks = Callbacks(log, *addresses, None, None)
        self.code.fmi2Instantiate.restype = ctypes.c_void_p
        self.me = ctypes.c_void_p(
            self.code.fmi2Instantiate(b"one", 1, token.encode(), b"", ctypes.byref(self.callbacks), 0, 0)
        )
        self.set((1, 2), (MOTOR, LOAD))

    def set(self, references, values):
        count = len(values)
        assert self.code.fmi2SetReal(self.me, (ctypes.c_uint * count)(*references), count, doubles(*values)) == 0

    def get(self, reference):
        value = doubles(0.0)
        assert self.code.fmi2GetReal(self.me, (ctypes.c_uint * 1)(reference), 1, value) == 0
        return value[0]

    def step(self, time, span):
        return self.code.fmi2DoStep(self.me, ctypes.c_double(time), ctypes.c_double(span), 0)


@needs_cc
def test_a_unit_follows_friction_under_load_over_steps_of_ten_milliseconds(tmp_path):
    drive = sw.Drive(J_m=INERTIA, J_l=1.3, N=50.0, B=40.0, law=sw.Linear(3e4))
    unit = Unit(tmp_path, drive.train(friction=sw.laws.LoadFriction(MU, WIDTH)))
    speeds = []
    for i in range(50):
        assert unit.step(0.01 * i, 0.01) == 0
        speeds.append(unit.get(SPEED))

    def rhs(_, y):
        a, w, b, v = y
        torque = 3e4 * (a / 50 - b) + 40.0 * (w / 50 - v)
        return (
            w,
            (MOTOR - torque / 50 - MU * abs(torque) / 50 * w / np.hypot(w, WIDTH)) / INERTIA,
            v,
            (torque + LOAD) / 1.3,
        )

    run = solve_ivp(rhs, (0.0, 0.5), (0.0,) * 4, "LSODA", 0.01 * np.arange(1, 51), rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(speeds, run.y[1], atol=1e-4 * np.max(np.abs(run.y[1])))


@needs_cc
def test_a_unit_refuses_a_step_from_a_state_that_it_cannot_follow(tmp_path):
    drive = sw.Drive(J_m=INERTIA, J_l=1.3, N=50.0, B=40.0, law=sw.Linear(3e4))
    unit = Unit(tmp_path, drive.train(friction=sw.laws.LoadFriction(MU, 1e-9)))
    unit.set((101, STUCK), (1e-3, 1e-10))
    assert unit.step(0.0, 0.01) == 3
    assert unit.said[-1].startswith("the state is too stiff for the smallest part of a step")
    assert unit.step(0.0, -1.0) == 3
    assert unit.said[-1].startswith("the step is not positive")
