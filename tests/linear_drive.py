"""A drive whose largest error has a closed form: linear, with a held motor and a rigid load."""

LINEAR = """\
gear: {ratio: 50, law: {type: linear, K: 1e5 N*m/rad}}
motor: {inertia: 5 kg*cm^2, mode: held}
load: {inertia: 1 kg*m^2}
damping: {B: 40 N*m*s/rad}
speed: {from: 100 rad/s, to: 200 rad/s, shaft: motor}
excitation: {kinematic_error: [{order: 2, amplitude: 1e-4 rad}]}
"""
SCATTERED = f"""\
title: Linear
{LINEAR}\
limit: {{oscillation: 160 arcsec}}
scatter: {{damping.B: 10 %, load.inertia: 5 %}}
"""


def closed_form(J, B, omega, K=1e5, amplitude=1e-4):
    """|x| of J x'' + B (x' - e') + K (x - e) = 0 with e = amplitude cos(2 omega t)."""
    s = 2j * omega
    return amplitude * abs((B * s + K) / (J * s * s + B * s + K))
