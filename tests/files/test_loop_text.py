"""Another loop in the author's file: units, comments and what stands beside the gains stay as they are."""

import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import strainwave as sw
from strainwave.files.reading import from_text
from strainwave.model.train.filters import apart, around

HEAD = """\
gear: CSG-32-100   # from the shelf
motor:
  inertia: 4.5 kg*cm^2
"""
TAIL = """\
load: {inertia: 5 kg*m^2}
damping: {ratio: 3 %}
speed: {from: 500 rpm, to: 3000 rpm, shaft: motor}
excitation: {kinematic_error: [{order: 2, amplitude: 23 arcsec}]}
"""
GAINS = """\
  loop:
    type: cascade  # since March
    K_v: {} 1/min  # as the drive has it
    K_p: {} mN*m*s/rad
    T_n: {} ms  # reset time
"""
BANDWIDTH = "  loop: {{type: cascade, {}lag: 0.5 ms}}  # kept\n"
NOTCH = sw.train.NotchFilter(1500.0, 600.0, 0.2)
WRITTEN = "{type: notch, frequency: 1500.0 rad/s, width: 600.0 rad/s, depth: 0.2}"


def having(text, core=None, filters=()):
    """The text of the project with other gains, and with more filters."""
    read = from_text(text, Path("axis.yaml"))
    own, about = apart(read.whole.motor.control)
    control = around(core or own, **about | {"filters": (*about.get("filters", ()), *filters)})
    train = read.train.with_motor(control=control)
    written = sw.project_text(replace(read, subject=train))
    found = apart(from_text(written, Path("axis.yaml")).whole.motor.control)[0]
    np.testing.assert_allclose(found, core or own, rtol=1e-9)
    return written


def test_gains_of_seven_digits_stay_short_and_in_the_authors_units():
    rng, text = np.random.default_rng(7), HEAD + GAINS.format(1500, 120, 25) + TAIL
    for _ in range(20):
        gains = [float(f"{x:.7g}") for x in rng.uniform(0.5, 2.0, 3) * (25.0, 0.12, 0.025)]
        written = having(text, sw.train.CascadeLoop(*gains))
        numbers = re.findall(r"([0-9.]+) (?:1/min|mN\*m\*s/rad|ms)", written)
        assert written == HEAD + GAINS.format(*numbers) + TAIL
        values = [float(number) * scale for number, scale in zip(numbers, (1 / 60, 1e-3, 1e-3), strict=True)]
        assert values == pytest.approx(gains, rel=1e-9)
        assert all(len(number) <= 11 for number in numbers)
        assert all(len(number) <= 8 for number in numbers[1:])


def test_a_gain_that_stays_is_left_as_it_is_written():
    text = HEAD + GAINS.format("1.5e3", "+120.0", "25.000") + TAIL
    assert having(text, sw.train.CascadeLoop(25.0, 0.12, 0.03)) == text.replace("25.000 ms", "30 ms")
    assert having(text, sw.train.CascadeLoop(25.0, 0.1 / 3.0, 0.025)) == text.replace("+120.0 mN", "33.33333333 mN")
    block = text.replace("+120.0 mN*m*s/rad", ">-\n      120\n      mN*m*s/rad")
    assert having(block, sw.train.CascadeLoop(25.0, 0.1, 0.03)) == text.replace("+120.0", "100").replace("25.000", "30")


@pytest.mark.parametrize(
    ("scatter", "left"),
    [
        ("scatter: {loop.bandwidth: 5 %, load.inertia: 4 %}  # sure\n", "scatter: {load.inertia: 4 %}  # sure\n"),
        (
            "scatter: {load.inertia: 4 %, motor.loop.bandwidth: 5 %, loop.damping: 2 %}\n",
            "scatter: {load.inertia: 4 %}\n",
        ),
        (
            "scatter:\n  # lots\n  loop.damping: 5 %  # soft\n  damping.ratio: 4 %  # worn\n",
            "scatter:\n  # lots\n  damping.ratio: 4 %  # worn\n",
        ),
        ("scatter: {loop.bandwidth: 5 %}\n# end\n", "# end\n"),
        (
            "scatter: {load.inertia: 4 %, loop.bandwidth: 5 %, damping.ratio: 9 %}\n"
            "scatter_correlation: [[1, 0.2, 0.5], [0.2, 1, 0.1], [0.5, 0.1, 1]]  # by hand\n",
            "scatter: {load.inertia: 4 %, damping.ratio: 9 %}\nscatter_correlation: [[1, 0.5], [0.5, 1]]  # by hand\n",
        ),
        (
            "scatter:\n  loop.bandwidth: 5 %\n  load.inertia: 4 %\n  damping.ratio: 9 %\n"
            "scatter_correlation:\n  - [1, 0, 0]\n  - [0, 1, 0.3]\n  - [0, 0.3, 1]\n",
            "scatter:\n  load.inertia: 4 %\n  damping.ratio: 9 %\nscatter_correlation:\n  - [1, 0.3]\n  - [0.3, 1]\n",
        ),
    ],
)
def test_the_scatter_of_a_bandwidth_goes_with_it(scatter, left):
    text = HEAD + BANDWIDTH.format("bandwidth: 30 Hz, damping: 0.8, ") + TAIL + scatter
    gains = "K_v: 40.5 1/s, K_p: 0.15 N*m*s/rad, T_n: 0.02 s, "
    expected = HEAD + BANDWIDTH.format(gains) + TAIL + left
    assert having(text, sw.train.CascadeLoop(40.5, 0.15, 0.02)) == expected
    assert having(text.replace("\n", "\r\n"), sw.train.CascadeLoop(40.5, 0.15, 0.02)) == expected.replace("\n", "\r\n")


LIST = "    filters:  # by Ann\n      - type: low_pass\n        frequency: 400 Hz  # fast\n      - {type: notch, "
LIST += "frequency: 90 Hz, width: 20 Hz}  # hum\n    # after\n"


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("    filters: [{type: low_pass, frequency: 400 Hz}]  # fl\n",
         f"    filters: [{{type: low_pass, frequency: 400 Hz}}, {WRITTEN}]  # fl\n"),
        (LIST, LIST.replace("# hum\n", f"# hum\n      - {WRITTEN}\n")),
        ("    filters:\n    - type: low_pass\n      frequency: 400 Hz  # fl\n  # after\n",
         f"    filters:\n    - type: low_pass\n      frequency: 400 Hz  # fl\n    - {WRITTEN}\n  # after\n"),
        ("    lag: 0.5 ms  # of the current\n",
         f"    lag: 0.5 ms  # of the current\n    filters: [{WRITTEN}]\n"),
    ],
)  # fmt: skip
def test_a_notch_stands_behind_the_filters_of_the_file(before, after):
    text = HEAD + GAINS.format(1500, 120, 25) + before + TAIL
    gains = sw.train.CascadeLoop(20.0, 0.1, 0.02)
    assert having(text, gains, (NOTCH,)) == HEAD + GAINS.format(1200, 100, 20) + after + TAIL
    assert having(text.replace("\n", "\r\n"), filters=(NOTCH,)) == text.replace(before, after).replace("\n", "\r\n")


def test_a_notch_is_added_where_a_bandwidth_gives_the_gains():
    text = HEAD + BANDWIDTH.format("bandwidth: 30 Hz, ") + TAIL
    gains = "K_v: 40.5 1/s, K_p: 0.15 N*m*s/rad, T_n: 0.02 s, "
    filtered = BANDWIDTH.format(gains).replace("0.5 ms}", f"0.5 ms, filters: [{WRITTEN}]}}")
    assert having(text, sw.train.CascadeLoop(40.5, 0.15, 0.02), (NOTCH,)) == HEAD + filtered + TAIL
    assert math.isclose(apart(from_text(HEAD + filtered + TAIL, Path("a.yaml")).whole.motor.control)[1]["lag"], 5e-4)
