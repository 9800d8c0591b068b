"""A joint with all that the error equation leaves out, and with memory: a motor's loop, gravity, hysteresis.

A gear whose motor is ideally held, so that the error equation is the whole drive, and which jumps.

A specification of a joint, which few gears serve.
"""

JOINT = """\
title: joint
gear: SHG-32-100
hysteresis: {type: bouc_wen, K: 5e4 N*m/rad, ratio: 0, yield_twist: 0.1 mrad}
motor: {inertia: 4.5 kg*cm^2, loop: {bandwidth: 30 Hz, damping: 0.7}}
load: {inertia: 5 kg*m^2, drag: {type: angle_torque, amplitude: 60 N*m}}
damping: {ratio: 2.5 %}
speed: {from: 300 rpm, to: 1200 rpm, shaft: motor}
limit: {oscillation: 60 arcsec}
excitation:
  kinematic_error: [{order: 2, amplitude: 25 arcsec}, {order: 4, amplitude: 5 arcsec}]
  load_torque: {mean: -20 N*m}
"""

HELD = """\
title: CSG-40-50
gear: CSG-40-50
motor: {mode: held}
load: {inertia: 1 kg*m^2}
damping: {ratio: 3 %}
speed: {from: 500 rpm, to: 4000 rpm, shaft: motor}
excitation:
  kinematic_error: [{order: 2, amplitude: 19.9 arcsec}]
  load_torque: {mean: 0 N*m}
limit: {oscillation: 120 arcsec}
"""

SPECIFICATION = """\
title: Joint
load: {inertia: 1.3 kg*m^2}
speed: {from: 10 rpm, to: 30 rpm}
limit: {oscillation: 200 arcsec}
motor: {rotor_inertias: [1 kg*cm^2, 5 kg*cm^2], loop: {bandwidth: 30 Hz}}
damping: {ratio: 3 %}
largest: {size: 40}
ratios: [50]
series: [CSG]
"""
