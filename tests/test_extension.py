"""What a user defines in a few lines, outside the package, and uses as what the package defines itself."""

import html
import json
import re
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pytest
from click.testing import CliRunner
from matplotlib.figure import Figure
from scipy.integrate import solve_ivp

import strainwave as sw
from strainwave.app import commands
from strainwave.app.commands import cli
from strainwave.app.report.report import together
from strainwave.app.web import views
from strainwave.app.web.parameters import parameters
from strainwave.base.facts import Fact
from strainwave.base.records import Result
from strainwave.base.sentences import Angle, Speed
from strainwave.compile.elementwise import larger
from strainwave.files.fields.kinds import Quantity
from strainwave.files.fields.rows import field, group_text, read_file, rows_of
from strainwave.files.fields.schema import LoadSpec, ProjectSpec
from strainwave.files.reading import ProjectError, from_text
from strainwave.files.reference import project_schema, reference, template
from strainwave.files.variants.names import keys_of
from strainwave.files.yaml_text import read
from strainwave.maths import cos, sign, tanh
from strainwave.model.train.train_forms import AtLoad
from strainwave.plot import Axis, Panel, figure

DUFFING = sw.Oscillator(1.0, 0.1, sw.Cubic(1.0, 0.05), sw.Harmonic(1.0), 1.0)
START = (0.5, -0.2)
EXACT = sw.Dopri5(rtol=1e-12, atol=1e-14)
GRID = np.linspace(0.0, 1.0, 2001)  # of a turn
PULSED = np.arange(1, 60)  # orders


class Dogleg(NamedTuple):
    """A law: a spring that is stiffer beyond a torsion to either side."""

    K: float
    more: float
    at: float

    def torque(self, x):
        return self.K * x + self.more * (x + 0.5 * (abs(x - self.at) - abs(x + self.at)))

    def stiffness(self, x):
        return self.K + self.more * (1.0 + 0.5 * (sign(x - self.at) - sign(x + self.at)))

    def breakpoints(self):
        return -self.at, self.at


class Relaxing(NamedTuple):
    """A law with memory: a spring beside a second one that yields through a dashpot."""

    K: float
    K_fast: float
    time: float

    states = 1

    def torque(self, x, v, z):
        return self.K * x + self.K_fast * z[0]

    def stiffness(self, x):
        return self.K

    def z_rate(self, x, v, z):
        return (v - z[0] / self.time,)


class Pulses(NamedTuple):
    """An excitation: one soft pulse each turn, 1 + 2 r cos(angle) + 2 r^2 cos(2 angle) + ... (Poisson's kernel)."""

    torque_mean: float
    r: float

    def torque(self, angle):
        return self.torque_mean * (1.0 - self.r**2) / (1.0 - 2.0 * self.r * cos(angle) + self.r**2)


class TwoMasses(NamedTuple):
    """A system: two masses behind each other on springs, the second driven, the first on a stiffening spring."""

    damping: float
    cubic: float
    amplitude: float
    omega: float

    def rhs(self, phase, y):
        x, v, x2, v2 = y
        between = x2 - x + self.damping * (v2 - v)
        first = between - x - self.cubic * x**3 - self.damping * v
        return v, first, v2, self.amplitude * cos(phase) - between

    def state_names(self):
        return "x", "x'", "x2", "x2'"

    def orders(self):
        return (1,)


def dogleg_rates(t, y):
    x, v = y
    return [v, np.cos(1.3 * t) - 0.1 * v - x - 2.0 * np.sign(x) * max(abs(x) - 0.5, 0.0)]


def relaxing_rates(t, y):
    x, v, z = y
    return [v, np.cos(1.3 * t) - 0.1 * v - x - 0.4 * z, v - z / 0.7]


def pulsed_rates(t, y):
    return [y[1], 0.2 + 0.4 * 0.5**PULSED @ np.cos(1.3 * PULSED * t) - 0.1 * y[1] - y[0]]


def masses_rates(t, y):
    stiffness, damping = np.array([[2.0, -1.0], [-1.0, 1.0]]), 0.1 * np.array([[2.0, -1.0], [-1.0, 1.0]])
    x, v = y[::2], y[1::2]
    a = np.array([-0.2 * x[0] ** 3, 0.3 * np.cos(1.3 * t)]) - stiffness @ x - damping @ v
    return [v[0], a[0], v[1], a[1]]


OWN = {
    "law": (DUFFING._replace(law=Dogleg(1.0, 2.0, 0.5), omega=1.3), dogleg_rates),
    "law with memory": (DUFFING._replace(law=Relaxing(1.0, 0.4, 0.7), omega=1.3), relaxing_rates),
    "excitation": (sw.Oscillator(1.0, 0.1, sw.Linear(1.0), Pulses(0.2, 0.5), 1.3), pulsed_rates),
    "system": (TwoMasses(0.1, 0.2, 0.3, 1.3), masses_rates),
}
each_own = pytest.mark.parametrize(("system", "rates"), OWN.values(), ids=OWN.keys())


def started(system):
    return np.r_[START, np.zeros(len(system.state_names()) - 2)]


def step_of(rates):
    return 0.02 if rates is dogleg_rates else np.inf  # SciPy steps over the kinks of a law


@each_own
def test_simulation_of_what_a_user_defines_agrees_with_scipy(system, rates):
    y0 = started(system)
    run = sw.simulate(system, y0, 20.0, method=EXACT)
    other = solve_ivp(rates, (0, 20.0), y0, "DOP853", rtol=1e-12, atol=1e-13, max_step=step_of(rates)).y[:, -1]
    np.testing.assert_allclose(run.y[:, -1], other, rtol=0, atol=1e-7)


@pytest.mark.slow
@each_own
def test_ensemble_and_orbit_of_what_a_user_defines_agree_with_scipy(system, rates):
    y0, turn = started(system), 2.0 * np.pi / 1.3
    settled = solve_ivp(
        rates,
        (0, 130 * turn),
        y0,
        "DOP853",
        rtol=1e-10,
        atol=1e-12,
        max_step=step_of(rates),
        t_eval=129 * turn + turn * GRID,
    ).y[0]
    lanes = np.full(64, 1.3)
    found = sw.ensemble(system, {"omega": lanes}, y0, periods=1, settle=129, measures=(sw.Peak(),))
    np.testing.assert_allclose(found["peak"], np.max(np.abs(settled)), rtol=2e-5)
    orbit = sw.find_orbit(system)
    assert orbit.peak == pytest.approx(np.max(np.abs(settled)), rel=2e-4)


@pytest.mark.slow
def test_curves_of_a_users_law_with_kinks_and_of_the_same_in_the_library_are_equal():
    own = sw.frequency_response(OWN["law"][0], (0.9, 1.3), harmonics=15, points=20)
    law = sw.PiecewiseLinear(1.0, 3.0, 3.0, 0.5, 1.0)
    same = sw.frequency_response(OWN["law"][0]._replace(law=law), (0.9, 1.3), harmonics=15, points=20)
    np.testing.assert_allclose(own.peak[-1], same.peak[-1], rtol=1e-6)


def test_curves_of_a_users_linear_law_and_pulses_are_the_closed_forms():
    relaxing, pulsed = OWN["law with memory"][0], OWN["excitation"][0]
    one, many = (sw.frequency_response(system, (0.6, 1.3), points=20) for system in (relaxing, pulsed))
    s = 1j * one.omega
    np.testing.assert_allclose(one.peak, abs(1.0 / (s**2 + 0.1 * s + 1.0 + 0.4 * s * 0.7 / (1.0 + 0.7 * s))), rtol=1e-7)
    k = np.arange(1, 60)
    s = 1j * k * many.omega[-1]
    waves = np.exp(2j * np.pi * np.outer(GRID, k)) @ (0.4 * 0.5**k / (s**2 + 0.1 * s + 1.0))
    assert many.peak[-1] == pytest.approx(np.max(np.abs(0.2 + waves.real)), rel=1e-5)


class TopSpeed(NamedTuple):
    """Largest rate of the first state at the ends of the steps."""

    def start(self):
        return (0.0,)

    def update(self, sums, piece):
        return (larger(abs(piece.v1), sums[0]),)

    def results(self, sums, time):
        return {"top_speed": sums[0]}

    def unit(self):
        return "rad/s"


class Place(NamedTuple):
    """Where the first state ends."""

    def of_end(self, y):
        return {"end": y[0]}


@pytest.mark.parametrize("method", [sw.Dopri5(), sw.Dop8(), sw.Rk4()])
def test_measure_of_a_user_is_a_variable_of_an_ensemble(method):
    kept = sw.Peak(), TopSpeed(), Place(), sw.Final()
    found = sw.ensemble(DUFFING, {"omega": [0.7, 1.3]}, START, periods=5, measures=kept, method=method)
    assert (found["top_speed"].attrs["units"], found["peak"].attrs["units"]) == ("rad/s", "rad")
    run = sw.simulate(DUFFING._replace(omega=1.3), START, np.linspace(0.0, 10 * np.pi / 1.3, 2001))
    assert found["top_speed"].values[1] == pytest.approx(np.max(np.abs(run.y[1])), rel=2e-2)
    np.testing.assert_array_equal(found["end"], found["final"].values[0])


def test_measure_of_a_user_is_swept():
    measure = sw.EnsembleMeasure(START, periods=3, measures=(TopSpeed(), Place()))
    found = sw.sweep(measure, DUFFING, {"omega": [0.7, 1.3], "law.alpha": [0.0, 0.05]})
    whole = sw.ensemble(DUFFING, {"omega": [0.7, 1.3]}, START, periods=3, measures=(TopSpeed(), Place()))
    for name in ("top_speed", "end"):
        np.testing.assert_allclose(found[name].sel({"law.alpha": 0.05}), whole[name], rtol=1e-12)


class LevellingLoop(NamedTuple):
    """A control: a position loop whose torque levels off at a limit."""

    K_p: float
    K_d: float
    limit: float

    def torque(self, x, v):
        return self.limit * tanh((self.K_p * x + self.K_d * v) / self.limit)


class LaggingLoop(NamedTuple):
    """A control with a state of its own: a position loop whose torque follows at a rate."""

    K_p: float
    K_d: float
    rate: float

    states = 1

    def torque(self, x, v, z):
        return z[0]

    def z_rate(self, x, v, z):
        return (self.rate * (self.K_p * x + self.K_d * v - z[0]),)


ERROR = sw.KinematicError((sw.Line(2, 1.1e-4, 0.3),))
DRIVE = sw.Drive(5.26e-4, 5e-2, 50.0, 5.0, sw.Cubic(7160.0, 1e4))
LOOP = sw.train.PositionLoop(2.0, 0.05)
CONTROLS = {"levelling": LevellingLoop(2.0, 0.05, 0.1), "lagging": LaggingLoop(2.0, 0.05, 900.0)}
each_control = pytest.mark.parametrize("control", CONTROLS.values(), ids=CONTROLS.keys())
TIGHT = sw.Dopri5(rtol=1e-11, atol=1e-14)


def with_control(control, omega=190.0):
    return DRIVE.train(control=control, kinematic_error=ERROR, load_torque=sw.Harmonic(3.0), omega=omega)


def in_absolute_angles(t, y):
    theta_m, theta_l, speed_m, speed_l, *z = y
    x, v = theta_m - 190.0 * t, speed_m - 190.0
    wanted = 2.0 * x + 0.05 * v
    against = z[0] if z else 0.1 * np.tanh(wanted / 0.1)
    u = theta_m / 50 - theta_l - ERROR.value(theta_m)
    du = speed_m / 50 - speed_l - ERROR.slope(theta_m) * speed_m
    torque = DRIVE.law.torque(u) + 5.0 * du
    motor = -against - (1 / 50 - ERROR.slope(theta_m)) * torque
    load = 3.0 * np.cos(190.0 * t) + torque
    return [speed_m, speed_l, motor / DRIVE.J_m, load / DRIVE.J_l, *([900.0 * (wanted - z[0])] if z else [])]


@each_control
def test_simulation_with_a_users_control_agrees_with_scipy_in_absolute_angles(control):
    train = with_control(control)
    states = len(train.state_names())
    run = sw.simulate(train, np.zeros(states), 0.05, method=TIGHT)
    start = [0.0, 0.0, 190.0, 190.0 / 50, *([0.0] * (states - 4))]
    other = solve_ivp(in_absolute_angles, (0, 0.05), start, "DOP853", rtol=1e-12, atol=1e-14).y[:, -1]
    x, v, angle, speed = run.y[:4, -1]
    theta_m = 190.0 * 0.05 + angle
    found = [theta_m, theta_m / 50 - x, 190.0 + speed, (190.0 + speed) / 50 - v, *run.y[4:, -1]]
    np.testing.assert_allclose(found, other, rtol=1e-8, atol=1e-10)


@pytest.mark.slow
@each_control
def test_orbit_and_response_curve_with_a_users_control_are_where_it_settles(control):
    train = with_control(control)
    system = AtLoad(train, train.omega)
    orbit = sw.find_orbit(system, harmonics=15)
    y = orbit.state(np.zeros(1))[:, 0]
    end = sw.simulate(system, y, 2.0 * np.pi / train.omega, method=TIGHT).y[:, -1]
    curve = sw.frequency_response(system, (189.0, 190.0), harmonics=15)
    assert orbit.stable
    np.testing.assert_allclose(end, y, rtol=0, atol=1e-6 * np.max(np.abs(y)))
    assert curve.omega[-1] == pytest.approx(190.0)
    assert curve.peak[-1] == pytest.approx(orbit.peak, rel=1e-6)


def test_bode_of_a_users_control_is_that_of_its_linear_loop_and_of_the_textbook():
    omega = np.array([30.0, 150.0, 420.0])
    expected = sw.bode(DRIVE.train(control=LOOP), omega)
    found = sw.bode(DRIVE.train(control=CONTROLS["levelling"]), omega)
    np.testing.assert_allclose(found.motor, expected.motor, rtol=1e-3)  # differences over 1 mrad of a tanh
    s = 1j * omega
    gear, loop = DRIVE.law.K + DRIVE.B * s, (2.0 + 0.05 * s) * 900.0 / (900.0 + s)
    passed = gear * DRIVE.J_l * s**2 / (gear + DRIVE.J_l * s**2)  # stiffness of the gear with the load behind it
    textbook = s / (DRIVE.J_m * s**2 + loop + passed / DRIVE.N**2)
    np.testing.assert_allclose(sw.bode(DRIVE.train(control=CONTROLS["lagging"]), omega).motor, textbook, rtol=1e-6)


def test_powers_of_a_train_with_a_users_control_add_up():
    train = with_control(CONTROLS["lagging"])
    assert train.state_names()[2:5] == ("motor deviation", "motor deviation'", "control z1")
    run = sw.drive_run(train, np.zeros(5), 0.05, method=TIGHT)
    assert run.imbalance < 1e-8


@pytest.mark.parametrize("control", ["PD", LevellingLoop], ids=["text", "class"])
def test_what_is_no_control_is_refused(control):
    with pytest.raises(TypeError, match=r"^Motor\.control is "):
        with_control(control)


JOINT = """\
title: Joint with a loop
gear: {ratio: 50, law: {type: linear, K: 1e5 N*m/rad}}
motor: {inertia: 5 kg*cm^2, loop: {type: speed_loop, K_p: 0.5 N*m*s/rad, K_i: 20 N*m/rad}}
load: {inertia: 1 kg*m^2, drag: {type: angle_torque, amplitude: 80 N*m}}
damping: {ratio: 10 %}
speed: {from: 1500 rpm, to: 1600 rpm, shaft: motor}
excitation: {kinematic_error: [{order: 2, amplitude: 10 arcsec}]}
"""


def stored_energy(view):
    """A study in the shortest form: the energy in the gear at the largest error."""
    law, largest = view.project.drive.law, view.analysis.largest()
    data = {"stored_energy": {"largest_J": law.energy(largest.peak), "of": largest.of}}
    said = ["It is largest at " + Speed(largest.omega) + ", where the error is " + Angle(largest.peak) + "."]
    x = np.linspace(0.0, largest.peak, 50)
    panel = Panel("", view.angle.axis("torsion"), Axis("energy", "J"))
    panel.line(x, law.energy(x))
    drawn = [figure([[panel]], 300.0, "energy over torsion")]
    return sw.report.Part("Energy in the gear", data, said, [sw.report.Table(data)], figures=drawn, lines=said)


@pytest.mark.slow
def test_section_of_a_user_is_in_the_page_the_results_and_the_summary_of_a_report(tmp_path):
    (tmp_path / "joint.yaml").write_text(JOINT)
    folder = tmp_path / "report"
    report = sw.report.write(tmp_path / "joint.yaml", folder, sections=(*sw.report.SECTIONS, stored_energy))
    results = json.loads((folder / "results.json").read_text(encoding="utf-8"))
    largest = results["largest_error"]
    assert largest["of"] == "run-up of the whole drive train"  # its steady curve has no gravity
    stored = results["stored_energy"]
    assert stored["of"] == largest["of"]
    assert stored["largest_J"] == pytest.approx(0.5 * 1e5 * largest["peak_rad"] ** 2, rel=1e-12)
    sentence = (
        f"It is largest at {largest['motor_speed_rpm']:.5g} rpm at the motor, where the error is "
        f"{largest['peak_arcsec']:.4g} arcsec."
    )
    page = (folder / "report.html").read_text(encoding="utf-8")
    own = html.unescape(page[page.index("<h2>Energy in the gear</h2>") :])
    assert f"<p>{sentence}</p>" in own
    assert f'<td>stored_energy.largest_J</td><td class="n">{stored["largest_J"]:.5g}</td>' in own
    assert 'aria-label="energy over torsion"' in own
    assert page.index("<h2>The whole drive train</h2>") < page.index("<h2>Energy in the gear</h2>")
    assert sentence in report.summary


def test_a_command_is_one_file(tmp_path, monkeypatch):
    (tmp_path / "sag.py").write_text(
        "import click\n"
        "from strainwave.app.commands.options import json_option, project_argument\n"
        "from strainwave.app.console import to_json\n"
        "from strainwave.files.reading import read_project\n"
        "@click.command()\n"
        "@project_argument\n"
        "@json_option\n"
        "def sag(project, as_json):\n"
        '    """Say how far a torque of 100 N m twists the gear."""\n'
        "    twist = 100.0 / read_project(project).drive.law.K\n"
        "    click.echo(to_json({'twist_rad': twist}) if as_json else f'{twist:.3g} rad')\n"
    )
    (tmp_path / "joint.yaml").write_text(JOINT)
    monkeypatch.setattr(commands, "__path__", [*commands.__path__, str(tmp_path)])
    (found,) = cli.commands_in(tmp_path).items()
    assert found == ("sag", ("sag", "Say how far a torque of 100 N m twists the gear."))
    monkeypatch.setitem(cli.COMMANDS, *found)
    run = CliRunner().invoke(cli.cli, ["sag", str(tmp_path / "joint.yaml"), "--json"])
    assert json.loads(run.stdout) == {"twist_rad": 1e-3}
    assert CliRunner().invoke(cli.cli, ["sag", str(tmp_path / "gone.yaml")]).exit_code == cli.INVALID_PROJECT
    said = CliRunner().invoke(cli.cli, ["--help"]).stdout
    assert "sag" in said
    assert "twists the gear" in said


@dataclass(frozen=True, eq=False)
class Cooling(Result):
    """A result in the shortest form: what it shows is plain data."""

    time: np.ndarray
    temperature: np.ndarray

    def panels(self):
        panel = Panel("after the run", Axis("time", "min", 60.0), Axis("temperature", "K"))
        panel.line(self.time, self.temperature, label="housing")
        panel.level(300.0, "#222222", "air")
        return [panel]

    def __str__(self):
        return "Cooling"


def test_a_result_of_a_user_with_panels_has_its_figure_in_every_renderer():
    t = np.linspace(0.0, 3600.0, 50)
    found = Cooling(t, 300.0 + 40.0 * np.exp(-t / 900.0))
    axes = Figure().add_subplot()
    assert found.plot(axes) is axes
    words = axes.get_xlabel(), axes.get_ylabel(), axes.get_title()
    assert words == ("time (min)", "temperature (K)", "after the run")
    np.testing.assert_allclose(axes.lines[0].get_xdata(), t / 60.0)
    assert axes.get_legend_handles_labels()[1] == ["housing", "air"]
    drawn = figure([found.panels()], 300.0, "cooling")
    for text in (*words, "housing", "air"):
        assert f">{text}</text>" in drawn
        assert f">{text}</text>" in found._repr_html_()


SHORT = "s_curve, angle: 0.01 rad, time: 0.02 s"


def test_a_number_of_a_result_is_one_line(tmp_path, monkeypatch):
    facts, arrays = sw.results.Move.facts, sw.results.Move.arrays["time"]
    more = Fact("gear.largest_twist_rad", 1e-3, "twisted by at most {}")
    monkeypatch.setattr(sw.results.Move, "facts", lambda self: (*facts(self), more))
    monkeypatch.setattr(sw.results.Move, "twist", property(lambda self: 2.0 * self.time), raising=False)
    monkeypatch.setitem(sw.results.Move.arrays, "time", {**arrays, "twist": "rad"})
    (tmp_path / "joint.yaml").write_text(JOINT)
    printed = CliRunner().invoke(cli.cli, ["move", str(tmp_path / "joint.yaml"), SHORT, "-o", str(tmp_path)]).stdout
    project = sw.read_project(tmp_path / "joint.yaml")
    monkeypatch.setattr(views, "USUAL_MOVE", sw.SCurve(0.01, 0.02))
    found = sw.move(project, views.USUAL_MOVE)
    for text in (printed, str(found), found._repr_html_(), views.moved(project)["numbers"]):
        assert "twisted by at most 206.3 arcsec" in text
    assert json.loads((tmp_path / "move.json").read_text())["gear"]["largest_twist_rad"] == 1e-3
    columns = np.genfromtxt(tmp_path / "move.csv", delimiter=",", names=True)
    np.testing.assert_allclose(columns["twist_rad"], 2.0 * columns["time_s"], rtol=1e-6)
    assert found.save(tmp_path / "run.csv").read_text().partition("\n")[0].endswith("twist [rad]")
    np.testing.assert_array_equal(found.to_xarray()["twist"], 2.0 * found.time)


@pytest.fixture
def clamp(monkeypatch):
    """A field more of the group `load`: one row."""
    rows_of.cache_clear()
    row = field(Quantity("N*m", "positive"), "5 N*m", "Torque at which the clamp of the load slips.")
    monkeypatch.setattr(LoadSpec, "clamp", row, raising=False)
    yield
    monkeypatch.undo()
    rows_of.cache_clear()


@pytest.mark.usefixtures("clamp")
def test_a_project_field_is_one_row(tmp_path):
    text = JOINT.replace("drag:", "clamp: 30 N*cm, drag:")
    project = from_text(text, tmp_path / "joint.yaml")
    spec, problems = read_file(read(text).content, ProjectSpec, read(text))
    assert (spec.load.clamp, problems) == (0.3, [])
    assert "clamp: 0.3 N*m" in group_text(spec.load)
    for wrong, said in (
        ("30", "4:34: load.clamp: '30' has no unit; write for example 0.5 N*m or 20 N*cm"),
        ("-3 N*m", "4:34: load.clamp: '-3 N*m' is not positive"),
        ("3 N*m, clmap: 3 N*m", "4:41: load.clmap: unknown field; did you mean 'clamp'?"),
    ):
        with pytest.raises(ProjectError, match=re.escape(said)):
            from_text(text.replace("30 N*cm", wrong), tmp_path / "joint.yaml")
    schema = project_schema()["properties"]["load"]["properties"]["clamp"]
    assert schema["description"] == "Torque at which the clamp of the load slips [N*m], above 0."
    assert re.fullmatch(schema["pattern"] + ".*", "30 N*cm")
    assert "| `load.clamp` | Torque at which the clamp of the load slips. | N*m | above 0 |  |" in reference()
    assert "#  clamp: 5 N*m" in template({"load.inertia": "1 kg*m^2", "load.clamp": ""})
    slider = next(one for one in parameters(project) if one["name"] == "load.clamp")
    assert (slider["si_unit"], slider["sign"], slider["help"]) == (
        "N*m", "positive", "Torque at which the clamp of the load slips.",
    )  # fmt: skip
    assert keys_of(read(text).content, "clamp") == ("load", "clamp")
    assert sw.replaced(project, {"clamp": "7 N*m"}).text.count("7 N*m") == 1
    with pytest.raises(ValueError, match=r"load\.clamp: '7' has no unit"):
        sw.replaced(project, {"clamp": "7"})


def test_two_sections_with_one_key_are_refused():
    with pytest.raises(ValueError, match="two sections of the report have the key 'energy_J'; rename one of them"):
        together([{"title": "A drive"}, {"energy_J": 1.0}, {"energy_J": 2.0}])
