"""A small drive on a cubic spring whose motor is ideally held: its project file, and the same on a linear spring."""

PROJECT = """\
title: A small drive
gear: {ratio: 50, law: {type: cubic, K: 1e5 N*m/rad, alpha: 6.9e4 1/rad^2}}
motor: {inertia: 5 kg*cm^2, mode: held}
load: {inertia: 1 kg*m^2}
damping: {ratio: 5 %}
speed: {from: 1200 rpm, to: 1900 rpm, shaft: motor}
excitation: {kinematic_error: [{order: 2, amplitude: 10 arcsec}]}
"""
CUBIC = "{type: cubic, K: 1e5 N*m/rad, alpha: 6.9e4 1/rad^2}"
LINEAR = PROJECT.replace(CUBIC, "{type: linear, K: 1e5 N*m/rad}")


def at_the_load(text, low, high):
    """The text with a range of speeds [rpm] of the load's shaft."""
    return text.replace("from: 1200 rpm, to: 1900 rpm, shaft: motor", f"from: {low} rpm, to: {high} rpm, shaft: load")
