"""A turntable whose controller and encoders are known: a project file of the tests of compensation."""

PROJECT = """\
title: Turntable
gear: {ratio: 50, law: {type: linear, K: 2e4 N*m/rad}}
motor: {inertia: 2 kg*cm^2, loop: {bandwidth: 25 Hz}, max_torque: 5 N*m}
controller: {period: 2 ms, delay: 0.5 ms, motor_encoder: 20 bit, load_encoder: 26 bit}
load: {inertia: 0.8 kg*m^2}
damping: {ratio: 25 %}
speed: {from: 300 rpm, to: 1200 rpm, shaft: motor}
excitation: {kinematic_error: [{order: 1, amplitude: 2 arcsec}, {order: 2, amplitude: 20 arcsec}]}
"""
