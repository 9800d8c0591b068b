"""What drives and controls do with the text of a file, written from their public sources and not from the writers.

Each function returns what the machine adds at angles of the encoder [rad], in the unit of the table.
"""

import math
import re

import numpy as np

import strainwave as sw

ARCSEC = math.pi / 648_000.0
DEGREE = math.pi / 180.0

ANGLE = sw.OrderTable(
    (sw.Line(1, 4 * ARCSEC, -1.0), sw.Line(2, 23 * ARCSEC, 0.3), sw.Line(4, 2 * ARCSEC, 2.0)),
    ratio=120.0,
    zero=0.4,
    source='rig 3, "slow" */ *) é\nsecond line',
)
TORQUE = sw.OrderTable((sw.Line(2, 0.01, 0.3), sw.Line(12, 0.005, 2.0)), unit="N*m", zero=0.1)
TWO_WAYS = sw.OrderTable(
    (sw.Line(2, 20 * ARCSEC, 0.3),),
    backward=(sw.Line(2, 17 * ARCSEC, 0.5), sw.Line(3, 1 * ARCSEC, 0.0)),
    mean=5 * ARCSEC,
    mean_backward=-5 * ARCSEC,
    ratio=50.0,
    zero=-0.2,
)

# What each format needs to hold the tables above.
OPTIONS = {
    "json": {},
    "csv": {},
    "points": {},
    "grid": {},
    "c": {},
    "st": {},
    "hal": {},
    "linuxcnc": {"span": (-18.0, 18.0)},
    "twincat": {},
    "sinumerik": {"capacity": 16_000},
    "onstepx": {"steps_per_degree": 25_600.0},
    "beckhoff": {},
    "moteus": {"torque_constant": 0.05},
}
TORQUES = ("beckhoff", "moteus")  # the formats that hold torques alone
NO_REMARKS = ("moteus", "onstepx")  # reading needs the options again, and knows no zero mark


def table_for(name):
    return TORQUE if name in TORQUES else ANGLE


def moteus(text, torque_constant, angle):
    """mjbots/moteus fw/bldc_servo.h: int8 table times a scale [A], straight lines between entries."""
    scale = float(re.search(r"cogging_dq_scale (\S+)", text).group(1))
    table = [int(v) for v in re.findall(r"cogging_dq_comp\.\d+ (-?\d+)", text)]
    assert len(table) == 1024
    assert all(-128 <= v <= 127 for v in table)
    out = []
    for position in np.mod(angle / (2.0 * math.pi), 1.0):
        left = min(1023, int(1024 * position))
        a, b = table[left] * scale, table[(left + 1) % 1024] * scale
        out.append((a + (b - a) * (position - left / 1024) * 1024) * torque_constant)
    return np.array(out)


def linuxcnc(text, position, velocity):
    """LinuxCNC's usrmotintf.cc, command.c, control.c with type 0: trims of 32 bits; position in degrees, result too."""
    rows = []
    for line in text.splitlines():
        try:
            nominal, forward, reverse = map(float, line.split())
        except ValueError:
            break
        rows.append((nominal, np.float32(nominal - forward), np.float32(nominal - reverse)))
    assert len(rows) <= 256
    assert all(np.diff([row[0] for row in rows]) > 0.0)
    nominal, forward, reverse = (np.array(column, float) for column in zip(*rows, strict=True))
    return np.interp(position, nominal, forward if velocity > 0.0 else reverse)


def sinumerik(text, position):
    """Extended Functions K3: what is added to the actual position of a modulo axis, degrees."""
    at = {int(i): float(v) for i, v in re.findall(r"\$AA_ENC_COMP\[0,(\d+),AX1\]=(\S+)", text)}
    one = {k: float(re.search(rf"\$AA_ENC_COMP_{k}\[0,AX1\]=(\S+)", text).group(1)) for k in ("STEP", "MIN", "MAX")}
    assert one["MIN"] + one["STEP"] * (len(at) - 1) == one["MAX"] == 360.0
    places = one["MIN"] + one["STEP"] * np.arange(len(at))
    return np.interp(np.mod(position, 360.0), places, [at[i] for i in range(len(at))])


def twincat(text, position, which=""):
    """Tc2_MC2: Compensation by Position, degrees."""
    body = re.search(rf"OrderTable{which} : ARRAY.*?\];", text, re.DOTALL).group()
    pairs = [tuple(map(float, pair)) for pair in re.findall(r"Position := (\S+), Compensation := ([^)]+)\)", body)]
    return np.interp(np.mod(position, 360.0), *np.array(pairs).T)


def beckhoff(text, angle):
    """Object 0x32CB by the bytes of each row: gain times the sum of r cos(n angle + phi)."""
    data = {int(sub, 16): bytes.fromhex(hexa) for sub, hexa in re.findall(r"0x32CB:(..) +\S+ +\S+ +([0-9A-F]+)", text)}
    single = {sub: float(np.frombuffer(raw, "<f4")[0]) for sub, raw in data.items() if len(raw) == 4}
    total = np.zeros_like(angle)
    for k in range(9):
        n = int(np.frombuffer(data[7 + 3 * k], "<u4")[0])
        total += single[2] * single[9 + 3 * k] * np.cos(n * angle + DEGREE * single[8 + 3 * k])
    return total


def onstepx(text, steps_per_degree):
    """OnStepX's Pec.cpp on one turn of the worm: sidereal seconds (0, 1, ...) and steps added until then."""
    buffer = {int(n): int(s) for n, s in re.findall(r":WR(\d+),([+-]\d+)#", text)}
    assert text.endswith(":$QZ!#\n")
    worm = len(buffer)
    limit = round(steps_per_degree / 240.0)
    added = [0.0]
    for index in range(worm):
        entry = buffer[index - 1 if index else worm - 1]
        added.append(added[-1] + max(-limit, min(limit, entry)))
    return np.arange(worm + 1), np.array(added)
