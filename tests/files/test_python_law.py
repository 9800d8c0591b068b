"""A law of the user's own in a Python file beside the project file."""

import math
import os
import pickle
import signal
import subprocess
import sys

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import strainwave as sw
from strainwave.files.reading import ProjectError, read_project

LAWS = '''\
"""Laws of a user."""

from typing import Annotated, Any, NamedTuple

from strainwave.maths import exp, sqrt


class Saturating(NamedTuple):
    """T = K x/sqrt(1 + (x/s)^2), which grows no further than K s."""

    K: Annotated[float, "N*m/rad"] = 1e5
    s: Annotated[float, "rad"] = 2e-3

    def torque(self, x):
        return self.K * x / sqrt(1.0 + (x / self.s) * (x / self.s))

    def stiffness(self, x):
        w = 1.0 + (x / self.s) * (x / self.s)
        return self.K / (w * sqrt(w))


class Growing(NamedTuple):
    """T = K s sinh(x/s)."""

    K: Annotated[float, "N*m/rad"] = 1e5
    s: Annotated[float, "rad"] = 2e-3

    def torque(self, x):
        return 0.5 * self.K * self.s * (exp(x / self.s) - exp(-x / self.s))

    def stiffness(self, x):
        return 0.5 * self.K * (exp(x / self.s) + exp(-x / self.s))

    def energy(self, x):
        return self.s * self.s * (self.stiffness(x) - self.K)

    def turning_points(self):
        return ()


class Doubled(NamedTuple):
    """Twice another law."""

    law: Any

    def torque(self, x):
        return 2.0 * self.law.torque(x)

    def stiffness(self, x):
        return 2.0 * self.law.stiffness(x)


class Raises(Saturating):
    def torque(self, x):
        return [][1]


class Infinite(Saturating):
    def torque(self, x):
        return 1e308 * 10.0 * (1.0 + x)


class OtherSlope(Saturating):
    def stiffness(self, x):
        return 0.5 * self.K + 0.0 * x


class NoUnit(NamedTuple):
    K: float

    def torque(self, x):
        return self.K * x


class NoSlope(NamedTuple):
    K: Annotated[float, "N*m/rad"]

    def torque(self, x):
        return self.K * x


class NoLaw(NamedTuple):
    K: Annotated[float, "N*m/rad"]
'''
PROJECT = """\
gear: {{ratio: 50, law: {law}}}
motor: {{inertia: 6 kg*cm^2}}
load: {{inertia: 1.3 kg*m^2}}
damping: {{B: 20 N*m*s/rad}}
speed: {{from: 500 rpm, to: 3000 rpm, shaft: motor}}
excitation: {{kinematic_error: [{{order: 2, amplitude: 23 arcsec}}]}}
"""


@pytest.fixture
def project(tmp_path):
    """Read a project whose gear has a law, beside a file of laws."""
    (tmp_path / "mylaws.py").write_text(LAWS, encoding="utf-8")

    def read(law):
        path = tmp_path / "project.yaml"
        path.write_text(PROJECT.format(law=law), encoding="utf-8")
        return read_project(path)

    return read


def test_a_law_of_a_python_file_is_read_with_units(project):
    law = project("{python: mylaws.py:Saturating, K: 3 Nm/arcmin, s: 0.1 deg}").drive.law
    assert type(law).__name__ == "Saturating"
    assert law == pytest.approx((3.0 * 10800.0 / math.pi, 0.1 * math.pi / 180.0), rel=1e-14)
    assert project("mylaws.py:Saturating").drive.law == (1e5, 2e-3)


def test_a_law_that_says_where_its_torque_turns_is_proved_by_lyapunov(project):
    system = project("{python: mylaws.py:Growing, K: 1e5 N*m/rad, s: 1 mrad}").system(130.0)
    proof = sw.lyapunov(system._replace(excitation=sw.Harmonic(0.0, mean=200.0)))
    assert (proof.scope, proof.asymptotic) == ("global", True)
    assert proof.rest == pytest.approx((1e-3 * math.asinh(2.0),) * 2, rel=1e-12)


def test_laws_stand_inside_each_other_whoever_wrote_them(project):
    own = "{python: mylaws.py:Saturating, K: 1e4 N*m/rad}"
    mixed = project(f"{{type: parallel, first: {{type: linear, K: 1e5 N*m/rad}}, second: {own}}}").drive.law
    assert mixed.torque(1e-4, 0.0, ()) == pytest.approx(10.0 + 1.0 / math.sqrt(1.0025), rel=1e-12)
    doubled = project("{python: mylaws.py:Doubled, law: {type: linear, K: 1e4 N*m/rad}}").drive.law
    assert doubled.law == sw.Linear(1e4)
    assert project(f"{{python: mylaws.py:Doubled, law: {own}}}").drive.law.stiffness(0.0) == 2e4


def test_the_same_file_is_run_once_and_its_laws_can_be_pickled(project):
    laws = [project("mylaws.py:Saturating").drive.law for _ in range(2)]
    assert type(laws[0]) is type(laws[1])
    assert pickle.loads(pickle.dumps(laws[0])) == laws[0]


def test_a_process_that_has_not_read_the_file_gets_the_law_too(project, tmp_path):
    law = project("{python: mylaws.py:Doubled, law: {python: mylaws.py:Saturating, K: 1e4 N*m/rad}}").drive.law
    (tmp_path / "law.pickle").write_bytes(pickle.dumps(law))
    code = "import pickle, sys; print(pickle.load(open(sys.argv[1], 'rb')).stiffness(0.0))"
    command = [sys.executable, "-c", code, str(tmp_path / "law.pickle")]
    run = subprocess.run(command, capture_output=True, text=True, check=False)
    assert run.stdout.strip() == "20000.0", run.stderr


@pytest.mark.slow
def test_a_drive_with_such_a_law_moves_as_equations_written_by_hand(project):
    system = project("{python: mylaws.py:Saturating, K: 1e5 N*m/rad, s: 0.5 mrad}").system(130.0)
    orbit = sw.find_orbit(system)
    e = 23.0 * math.pi / 648000.0

    def rates(t, y):
        u, du = y[0] - e * math.cos(260.0 * t), y[1] + 260.0 * e * math.sin(260.0 * t)
        return [y[1], -(20.0 * du + 1e5 * u / math.sqrt(1.0 + (u / 0.5e-3) ** 2)) / 1.3]

    end = 60.0 * 2.0 * math.pi / 130.0
    times = np.linspace(end - 2.0 * math.pi / 130.0, end, 400)
    exact = solve_ivp(rates, (0.0, end), [0.0, 0.0], method="DOP853", rtol=1e-10, atol=1e-14, t_eval=times)
    assert orbit.peak == pytest.approx(np.max(np.abs(exact.y[0])), rel=2e-4)  # of samples 1/400 of a turn apart


@pytest.mark.parametrize(
    ("law", "said"),
    [
        ("other.py:MyLaw", "1:24: gear.law: other.py is not beside the project file; put it there, or check its name"),
        (
            "mylaws.py:Missing",
            "gear.law: mylaws.py has no law 'Missing'; its NamedTuples with a torque are Saturating, G",
        ),
        ("mylaws.py:NoLaw", "gear.law: mylaws.py has no law 'NoLaw'; its NamedTuples with a torque are Saturating"),
        ("{python: ../mylaws.py:MyLaw}", "gear.law: '../mylaws.py' is no plain file name; put the Python file beside"),
        (f"{{python: {'x' * 300}.py:MyLaw}}", "is no plain file name; put the Python file beside the project file"),
        ("{python: mylaws}", "gear.law: 'mylaws' names no class of a Python file; write for example mylaws.py:MyLaw"),
        ("{python: link.py:Saturating}", "gear.law: 'link.py' is no plain file name; put the Python file beside the"),
        ("mylaws.py:Raises", "gear.law: Raises.torque at 0 rad raises IndexError: list index out of range; correct it"),
        ("mylaws.py:Infinite", "gear.law: Infinite.torque at 0 rad gives inf; it must be a finite number"),
        ("mylaws.py:OtherSlope", "gear.law: OtherSlope.stiffness at 1.237e-05 rad gives 5e+04 N*m/rad and its torque"),
        (
            "{python: mylaws.py:NoUnit, K: 5 N*m/rad}",
            "gear.law.python: NoUnit.K has no unit; write in the class K: Anno",
        ),
        ("{python: mylaws.py:NoSlope, K: 5 N*m/rad}", "gear.law.python: NoSlope has no stiffness(x), the slope of its"),
        ("{python: mylaws.py:Doubled}", "gear.law.law: is missing; write it, for example {type: linear"),
        ("broken.py:MyLaw", "gear.law: broken.py does not run: ZeroDivisionError: division by zero in line 2; correct"),
        (
            "typo.py:MyLaw",
            "gear.law: typo.py does not run: SyntaxError: '(' was never closed (typo.py, line 1) in line 1",
        ),
        ("stops.py:MyLaw", "gear.law: stops.py does not run: SystemExit: 3 in line 1; correct it"),
        ("empty.py:MyLaw", "gear.law: empty.py has no law 'MyLaw'; no NamedTuple there has a torque"),
    ],
)
def test_what_is_wrong_with_a_python_law_is_said_in_one_sentence(project, tmp_path, law, said):
    (tmp_path / "broken.py").write_text("x = 1\ny = x / 0\n")
    (tmp_path / "typo.py").write_text("print(\n")
    (tmp_path / "stops.py").write_text("raise SystemExit(3)\n")
    (tmp_path / "empty.py").write_text("import math\n")
    outside = tmp_path.parent / f"outside_{tmp_path.name}.py"
    outside.write_text(LAWS)
    (tmp_path / "link.py").symlink_to(outside)
    with pytest.raises(ProjectError) as refusal:
        project(law)
    (line,) = str(refusal.value).splitlines()
    assert said in line


def test_no_file_is_left_behind_by_reading(project, tmp_path):
    project("mylaws.py:Saturating")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["mylaws.py", "project.yaml"]


@pytest.mark.parametrize("end", ["", "x = 1 / 0"])
def test_a_file_that_changes_the_folder_leaves_that_of_the_process(project, tmp_path, end):
    (tmp_path / "moves.py").write_text(f"import os\nos.chdir('/')\n{LAWS}\n{end}\n".replace(LAWS, "" if end else LAWS))
    folder = os.getcwd()
    if end:
        with pytest.raises(ProjectError, match=r"moves\.py does not run: ZeroDivisionError"):
            project("moves.py:Saturating")
    else:
        project("moves.py:Saturating")
    assert os.getcwd() == folder


def test_a_file_that_does_not_end_is_interrupted_with_a_sentence(tmp_path):
    (tmp_path / "endless.py").write_text("import sys\nprint('begun', file=sys.stderr, flush=True)\nwhile True: pass\n")
    (tmp_path / "project.yaml").write_text(PROJECT.format(law="endless.py:MyLaw"))
    command = [sys.executable, "-m", "strainwave", "response", str(tmp_path / "project.yaml")]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as run:
        assert run.stderr.readline() == "begun\n"
        run.send_signal(signal.SIGINT)
        try:
            out, err = run.communicate(timeout=60)
        finally:
            run.kill()
    assert (run.returncode, out, err) == (130, "", "strainwave: interrupted; nothing was written; run it again\n")
