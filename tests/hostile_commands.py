# ruff: noqa: E501
"""Calls of the commands with options, files and arguments that make no sense: the same ones for the same seed."""

import os
import re
import shlex
import signal
import traceback
import warnings
from contextlib import contextmanager
from opcode import opmap
from pathlib import Path
from random import Random
from shutil import rmtree

import click
import numpy as np
from click.testing import CliRunner

import strainwave as sw
from strainwave.app.commands.cli import cli
from strainwave.compile.tree import shown
from strainwave.files.yaml_text import FileError

TIMES = 0.01 * np.arange(200)
TURN = np.linspace(0.0, 4.0 * np.pi, 240, endpoint=False)
PROJECT = """
gear: CSG-40-50
motor: {inertia: 4.5 kg*cm^2, loop: {bandwidth: 30 Hz, damping: 0.7}, max_torque: 3 N*m}
load: {inertia: 1.3 kg*m^2}
damping: {ratio: 3 %}
speed: {from: 100 rad/s, to: 180 rad/s, shaft: motor}
limit: {oscillation: 100 arcsec}
excitation: {kinematic_error: [{order: 2, amplitude: 23 arcsec}]}
scatter: {load.inertia: 3 %}
"""
SENTENCES = (ValueError, TypeError, sw.SolveError, RuntimeError, FileNotFoundError, ModuleNotFoundError)
ROOT = str(Path(sw.__file__).parent)
LONGEST = 900  # letters of a sentence


def table(*columns, names):
    """Text of a CSV file."""
    rows = [",".join(names), *(",".join(f"{value:.12g}" for value in row) for row in zip(*columns, strict=True))]
    return "\n".join(rows) + "\n"


OWN = ("app", "watch")  # they go on until they are stopped
LINEAR = PROJECT.replace("CSG-40-50", "{ratio: 50, law: {type: linear, K: 5e4 N*m/rad}}")  # computed five times as fast
COLUMNS = "time [s],motor_angle [rad],load_angle [rad],torque [N*m]"
SPECIFICATION = """
load: {inertia: 1.3 kg*m^2}
speed: {from: 2 rpm, to: 40 rpm}
limit: {oscillation: 900 arcsec}
torque: {mean: 20 N*m, peak: 40 N*m}
motor: {rotor_inertias: [0.5 kg*cm^2]}
damping: {ratio: 20 %}
ratios: [50]
series: [CSG]
largest: {size: 20}
"""
S = 1j * np.geomspace(10.0, 1000.0, 40)  # 1/s
LOAD, BOND = 1.3 / 2500.0, (4.4e4 + 20.0 * S) / 2500.0  # at the motor
PLANT = (LOAD * S**2 + BOND) / (S * (6e-4 * LOAD * S**2 + (6e-4 + LOAD) * BOND))
FILES = {
    "axis.yaml": PROJECT,
    "linear.yaml": LINEAR,
    "other.yaml": LINEAR.replace("1.3", "2.6"),
    "spec.yaml": SPECIFICATION,
    "log.csv": table(
        TIMES,
        10.0 * TIMES,
        0.2 * TIMES - 1.12e-4 * np.cos(20.0 * TIMES),
        np.cos(20.0 * TIMES),
        names=COLUMNS.split(","),
    ),
    "scan.csv": table(TURN, 1e-4 * np.cos(2.0 * TURN), names=("angle [rad]", "error [rad]")),
    "loop.csv": table(
        1e-3 * np.sin(TURN), 40.0 * np.sin(TURN) + 2.0 * np.cos(TURN), names=("torsion [rad]", "torque [N*m]")
    ),
    "bode.csv": table(S.imag / (2.0 * np.pi), PLANT.real, PLANT.imag, names=("frequency [Hz]", "real", "imaginary")),
    "profile.csv": table(0.1 * TIMES, 0.01 * TIMES, names=("time [s]", "angle [rad]")),
    "table.csv": "angle_rad,value\n0,0\n1.5707963267948966,1e-4\n3.141592653589793,0\n4.71238898038469,-1e-4\n",
    "empty.yaml": "",
    "bytes.csv": "\x00\x01\x02",
}
VALID = {
    "analyze": "axis.yaml --check",
    "catalogue": "CSG-40-50",
    "compare": "linear.yaml other.yaml -o out",
    "compensate": "axis.yaml --controller inverse --speed 600rpm --load-angle 0deg --seed 1",
    "completion": "bash",
    "demo": "-o out",
    "derive": "axis.yaml -o steps.html",
    "design": "spec.yaml -o out",
    "doctor": "--json",
    "exceedance": "axis.yaml --count 32 --seed 0 --limit 100arcsec",
    "export": "axis.yaml --to c -o plant.c --step 1e-4s",
    "fit-bode": "axis.yaml bode.csv --free J_m,K --quantity plant",
    "fit-loop": "loop.csv --rated-torque 90N*m --ratio 50",
    "identify": "axis.yaml log.csv -o out --load-inertia 1.3kg*m^2",
    "move": "axis.yaml 'trapezoid, angle: 0.01 rad, time: 0.01 s' -o out --start 0deg --window 1arcmin",
    "new": "--title axis --gear CSG-40-50 --load-inertia 1.3kg*m^2 -o new.yaml",
    "order-scan": "log.csv --channel torque --angle motor_angle --orders 2",
    "order-scan,scan": "scan.csv --ratio 50 --orders 2 --false-alarm 0.01",
    "order-table": "table.csv out.h --format c --points 8 --prefix x --speed 5rpm",
    "read-log": "log.csv --ratio 50 --trim 0",
    "reproduce": "--json",
    "response": "axis.yaml -o out.csv",
    "schema": "--markdown",
    "skill": "",
    "speed-map": "axis.yaml -o out --loads 0N*m --speeds 960rpm:1000rpm --limit 100arcsec",
    "tune": "axis.yaml -o out --goal compliance --gain K_p --load 0N*m",
    "sweep": "axis.yaml --grid load.inertia=1.3kg*m^2 -o out",
}
TEXTS = (
    "", " ", "nan", "inf", "-inf", "-1", "0", "1e400", "1e-400", "9" * 400, "-563 rpm", "5", "5 N*m", "5 rpm", "5 rad",
    "5 Hz", "5 s", "5 parsec", "5 kg*m^2", "1e300 rpm", "1e-300 s", "nan rad", "inf N*m", "2 %", "1,5", "1..2", "2..1 rpm",
    "1:2:3", "a=b", "=", "a=", "=1", "a=b=c", "gear.K1", "load.inertia=1 kg*m^2..2 kg*m^2", "1,2,3", "2,2", "a,b", "-",
    "--", "x" * 3000, "\x1b[31m", "é½漢", "\udcff", "$HOME", "../../x", "/", "/dev/null", ".", "axis.yaml",
    "log.csv", "scan.csv", "loop.csv", "empty.yaml", "bytes.csv", "missing.csv", "out", "no/such/folder/x", "%s%n", "{}",
    "[1, 2]", "True", "1e3", "3.7", "0x10", "2 kg/0.3 m", "1 kg*m", "90deg/0.5s", "1 rpm/1 rpm", "CSG-40-50", "csv",
)  # fmt: skip


class Late(BaseException):
    """A call took longer than it may."""


@contextmanager
def within(seconds):
    """Stop what takes longer (`Late`): so many seconds of the processor, or thirty times as many of waiting."""

    def late(*_):
        raise Late

    timers = {signal.SIGPROF: (signal.ITIMER_PROF, seconds), signal.SIGALRM: (signal.ITIMER_REAL, 30.0 * seconds)}
    before = {sign: signal.signal(sign, late) for sign in timers}
    for timer, time in timers.values():
        signal.setitimer(timer, time, 1.0)  # again, as Python drops what is raised in a `__del__`
    try:
        yield
    finally:
        for sign, (timer, _) in timers.items():
            signal.setitimer(timer, 0.0)
            signal.signal(sign, before[sign])


def inner(error):
    """Last line of the package that an error came through."""
    lines = [
        f"{Path(f.filename).name}:{f.lineno}"
        for f in traceback.extract_tb(error.__traceback__)
        if f.filename.startswith(ROOT)
    ]
    return lines[-1] if lines else ""


def fault(error):
    """What is unsound about an error; "" for nothing: a statement of the package raised it, with words."""
    place = error.__traceback__
    while place.tb_next is not None:
        place = place.tb_next
    code = place.tb_frame.f_code
    said = f"{type(error).__name__}: {shown(str(error))} @ {Path(code.co_filename).name}:{place.tb_lineno}"
    if not isinstance(error, SENTENCES):
        return said
    raised = code.co_code[place.tb_lasti] == opmap["RAISE_VARARGS"]
    if not (raised and code.co_filename.startswith(ROOT)):
        return f"{said} < {inner(error)}"
    return "" if len(str(error).split()) > 3 and len(str(error)) <= LONGEST else f"no sentence: {said}"


def valid_command(name):
    """Arguments of a command that make sense."""
    return [name.partition(",")[0], *shlex.split(VALID[name])]


def hostile_command(name, seed):
    """Arguments of a command, one or two of which make no sense."""
    rng = Random(f"{name} {seed}")
    arguments = valid_command(name)
    name = arguments[0]
    options = [
        option for option in command(name).params if option.param_type_name == "option" and option.name != "help"
    ]
    for _ in range(rng.choice((1, 1, 1, 2))):
        draw = rng.random()
        if draw < 0.45 and len(arguments) > 1:
            arguments[rng.randrange(1, len(arguments))] = rng.choice(TEXTS)
        elif draw < 0.9 and options:
            option = rng.choice(options)
            arguments += [rng.choice(option.opts)] + ([] if option.is_flag else [rng.choice(TEXTS)])
        elif draw < 0.95:
            arguments.append(rng.choice(TEXTS))
        elif len(arguments) > 1:
            del arguments[rng.randrange(1, len(arguments))]
    return arguments


def command(name):
    """A command of a name."""
    return cli.get_command(click.Context(cli), name)


def answer_of(arguments, seconds):
    """How a command ends in a folder of its own ("done", "refused", "late"), and what is unsound about that."""
    for path in Path().iterdir():  # what an earlier one has written, which a later one would refuse to replace
        rmtree(path) if path.is_dir() else path.unlink()
    for name, text in FILES.items():
        Path(name).write_text(text, encoding="utf-8")
    os.environ["STRAINWAVE_DEBUG"] = "1"
    try:
        with within(seconds), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            warnings.simplefilter("error", RuntimeWarning)
            run = CliRunner().invoke(cli, arguments)
    except Late:
        return "late", ""
    finally:
        del os.environ["STRAINWAVE_DEBUG"]
    if isinstance(run.exception, Exception):
        expected = isinstance(run.exception, FileError) or (
            isinstance(run.exception, OSError) and run.exception.strerror
        )
        return "refused", "" if expected else fault(run.exception)
    if run.exit_code not in (0, 1, 2, 3):
        return "refused", f"exit code {run.exit_code}"
    numbers = re.search(r".{0,60}\bnan\b.{0,40}", run.stdout, re.IGNORECASE)
    if run.exit_code == 0 and numbers and "nan" not in " ".join(arguments):
        return "done", numbers[0]
    if run.exit_code and not run.output.strip():
        return "refused", "silent"
    return ("refused" if run.exit_code else "done"), ""
