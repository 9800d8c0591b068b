"""Sentences of the library for somebody without Python: calls that they name give way to fields or options."""

import re
from ast import literal_eval
from shlex import quote
from typing import Any

# Calls that sentences of the library name, and what a project file or a command has in their place.
NO_PYTHON = {
    r", drive_run its motion in time, and system\(reduced=True\) gives the error equation alone": "",
    r"; drive_run computes its motion in time": "",
    r" or tail, or a method of less accuracy, such as Dopri5\(rtol=1e-6\)": "",
    r", or (use find_orbit\(SteadyTrain\(train, omega\)\)|integrate with simulate)": "",
    r"\bintegrate the drive with simulate\b": (
        "remove the error orders of the output turn; strainwave move integrates the drive in time"
    ),
    r", or give a sampled controller as `loop` of sw\.compensate": "",
    r"\bgive limits=MotorLimits\(torque\) or max_torque": "write 'max_torque: 3 N*m' into the group motor",
    r"\b(simulate from other states shows|isolas with resonance=PRIMARY looks for) them( from random starts)?": (
        "strainwave speed-map looks for them from random starts"
    ),
}
# The same, and the options of the commands.
CALLS = {
    r"\bat_speed\(\.\.\.\)": "--speed",
    r"\bcolumns=\['time', 'load_angle', \.\.\.\]": "--columns time,load_angle,...",
    r"\bNone for one to leave out\b": "- for one to leave out",
    r"\bgive a name or None for each\b": "give a name or - for each",
    r"\bjoint= says of which joint, columns= which\b": "--joint says of which joint, --column which",
    r"\bcolumns=\{'time': \.\.\.\}, or rate\b": "--column time=..., or --rate",
    r"\bunits= says": "--unit says",
    r"\bloosen (peak|gain|phase)_(sensitivity|margin)\b": r"loosen --\1-\2",
    r"(?<![\w./-])trim=0(?![\w.])": "--trim 0",
    r"`load_angles` of sw\.compensate, --load-angle of the command,": "--load-angle",
    r"\bgive one, such as Trapezoid\(angle, time\), or a `move` in the project file": (
        "write 'trapezoid, angle: 90 deg, time: 0.6 s' after the project file, or a group move into it"
    ),
}
GIVEN = re.compile(r"(?<![\w./-])(unit|column)s=(\{[^{}]*\})")


def without_calls(sentence: str) -> str:
    """A sentence of the library for somebody without Python: calls that it names give way to what they have."""
    for call, words in NO_PYTHON.items():
        sentence = re.sub(call, words, sentence)
    return sentence


def in_options(sentence: str, command: Any = None) -> str:
    """A sentence of the library with options in place of its calls, where the command has these."""
    typed = sentence = without_calls(sentence)
    for call, option in CALLS.items():
        typed = re.sub(call, option, typed)
    typed = GIVEN.sub(_pairs_as_typed, typed)
    available = None if command is None else {option for one in command.params for option in one.opts}
    named = set(re.findall(r"(?<!\S)--[a-z-]+", typed)) - set(re.findall(r"(?<!\S)--[a-z-]+", sentence))
    return typed if available is None or named <= available else sentence


def _pairs_as_typed(given: re.Match[str]) -> str:
    try:
        typed = [f"--{given[1]} {quote(f'{channel}={value}')}" for channel, value in literal_eval(given[2]).items()]
    except (ValueError, SyntaxError, AttributeError):  # no dictionary: it is no call
        return given[0]
    return " ".join(typed)
