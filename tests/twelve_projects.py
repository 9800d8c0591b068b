"""Twelve project files: every kind of motor, law, load and damping, two of them of the examples."""

from pathlib import Path

EXAMPLES = Path(__file__).resolve().parent.parent / "examples" / "projects"
CUBIC = "gear: {ratio: 50, law: {type: cubic, K: 1e5 N*m/rad, alpha: 6.9e4 1/rad^2}, rated_torque: 178 N*m}\n"
CATALOGUE = "gear: CSG-40-50\n"
LOAD = "load: {inertia: 1.3 kg*m^2}\n"
DAMPED = "damping: {ratio: 3 %}\n"
FAST = "speed: {from: 1000 rpm, to: 2500 rpm, shaft: motor}\n"
ERROR = """\
excitation:
  kinematic_error: [{order: 2, amplitude: 23 arcsec, phase: 20 deg}, {order: 4, amplitude: 3 arcsec}]
"""

LOOP_BY_BANDWIDTH = """\
gear: SHG-25-100
motor: {loop: {bandwidth: 30 Hz, damping: 0.7}}
load: {inertia: 2.1 kg*m^2}
damping: {ratio: 4 %}
speed: {from: 3 rpm, to: 21 rpm, shaft: load}
limit: {oscillation: 60 arcsec}
excitation:
  kinematic_error: [{order: 2, amplitude: 23 arcsec}]
  load_torque: {mean: {from: -60 N*m, to: 10 N*m}, lines: [{order: 1, amplitude: 2 N*m}]}
"""
LAGGED_SPEED_LOOP = """\
motor:
  inertia: 4.5 kg*cm^2
  loop: {type: speed_loop, K_p: 0.5 N*m*s/rad, K_i: 20 N*m/rad, lag: 0.5 ms}
  drag: {type: coulomb, T_c: 0.05 N*m}
"""
POSITION_LOOP = """\
motor: {inertia: 4.5 kg*cm^2, loop: {type: position_loop, K_p: 60 N*m/rad, K_d: 0.5 N*m*s/rad}}
load:
  inertia: 1 kg*m^2
  coupling: {inertia: 0.3 kg*m^2, B: 5 N*m*s/rad, law: {type: cubic, K: 4e5 N*m/rad, alpha: 0.1 1/rad^2}}
damping: {B: 20 N*m*s/rad}
"""
TWO_COUPLINGS = """\
motor: {inertia: 4.5 kg*cm^2, mode: held}
load:
  inertia: 1 kg*m^2
  drag: {type: angle_torque, amplitude: 40 N*m}
  couplings:
    - {inertia: 0.2 kg*m^2, law: {type: linear, K: 4e5 N*m/rad}}
    - {inertia: 0.1 kg*m^2, law: {type: linear, K: 6e5 N*m/rad}}
damping: {B: 20 N*m*s/rad}
"""
FREE = """\
motor: {mode: free}
speed: {from: 100 rad/s, to: 250 rad/s, shaft: motor}
excitation: {motor_torque: {mean: 1 N*m, lines: [{order: 2, amplitude: 0.2 N*m}]}}
"""
HYSTERESIS = "hysteresis: {type: bouc_wen, K: 6e4 N*m/rad, ratio: 0, yield_twist: 0.08 mrad}\n"
VARYING = """\
motor: {inertia: 4.5 kg*cm^2}
stiffness: {ripples: [{order: 2, depth: 5 %}]}
damping: {ratio: 3 %, ripples: [{order: 4, depth: 10 %}], warming: 10 K}
"""

PROJECTS = {
    "antenna": (EXAMPLES / "antenna.yaml").read_text(encoding="utf-8"),
    "article": (EXAMPLES / "article.yaml").read_text(encoding="utf-8"),
    "catalogue gear, motor not named": CATALOGUE + LOAD + DAMPED + FAST + ERROR,
    "accuracy class of the catalogue": CATALOGUE + LOAD + "damping: {quality: 20}\nexcitation: {accuracy: catalogue}\n"
    "speed: {at: [900 rpm, 30 rev/min], shaft: motor}\n",
    "loop by bandwidth, payload": LOOP_BY_BANDWIDTH,
    "speed loop with a lag, friction": CUBIC + LAGGED_SPEED_LOOP + LOAD + "damping: {B: 20 N*m*s/rad}\n" + FAST + ERROR,
    "position loop, coupling": CUBIC + POSITION_LOOP + FAST + ERROR,
    "two couplings, gravity": CUBIC + TWO_COUPLINGS + FAST + ERROR,
    "free motor with a torque": CATALOGUE + LOAD + DAMPED + FREE,
    "hysteresis": CATALOGUE + HYSTERESIS + LOAD + DAMPED + FAST + ERROR,
    "backlash": CATALOGUE + "backlash: {half_gap: 0.05 mrad}\nmotor: {mode: held}\ndamping: {B: 20 N*m*s/rad}\n"
    + LOAD + FAST + ERROR,
    "varying stiffness and damping": CUBIC + VARYING + LOAD + FAST + ERROR,
}  # fmt: skip
