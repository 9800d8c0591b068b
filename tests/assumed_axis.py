"""An axis whose file says which of its numbers are assumed."""

from pathlib import Path

from strainwave.files.reading import from_text

AXIS = """\
title: axis
gear: CSG-40-50
motor: {loop: {type: cascade, bandwidth: BAND}}
load: {inertia: 1.3 kg*m^2}
damping: {ratio: RATIO}
speed: {from: 250 rpm, to: 3000 rpm, shaft: motor}
limit: {oscillation: 60 arcsec}
excitation: {kinematic_error: [{order: 2, amplitude: 23 arcsec}]}
"""
ASSUMED = "sources: {motor.loop: assumed, damping: assumed, load.inertia: measured}\n"


def axis(ratio="3 %", band="30 Hz", more=ASSUMED):
    return from_text(AXIS.replace("RATIO", ratio).replace("BAND", band) + more, Path("axis.yaml"))
