"""The group `controller` of a project file: samples and encoders, read, written and read again, and complaints."""

import math
from dataclasses import replace
from pathlib import Path

import pytest

import strainwave as sw
from strainwave.files.reading import ProjectError, from_text
from strainwave.study.compensation.bench import bench_of

ARCSEC = math.pi / (180.0 * 3600.0)
DRIVE = """\
gear: CSG-40-50
motor: {{inertia: 4.5e-4 kg*m^2, loop: {{bandwidth: 30 Hz}}{most}}}
controller: {controller}
load: {{inertia: 10 kg*m^2}}
damping: {{ratio: 0.02}}
speed: {{from: 50 rpm, to: 1500 rpm, shaft: motor}}
excitation: {{kinematic_error: [{{order: 2, amplitude: 23 arcsec}}]}}
"""


def project(controller, most=", max_torque: 3 N*m"):
    return from_text(DRIVE.format(controller=controller, most=most), Path("axis.yaml"))


GIVEN = {
    "{period: 500 us, delay: 100 us, motor_encoder: 17 bit, load_encoder: 24 bit}": sw.controllers.Sampling(
        5e-4, 1e-4, 3.0, math.tau / 131072, 0.0, math.tau / 16777216, 0.0, 0.0, 1
    ),
    "{}": sw.controllers.Sampling(250e-6, 250e-6, 3.0, math.tau / 65536, load_encoder=0),
    "{period: 1 ms, load_encoder: none}": sw.controllers.Sampling(1e-3, 1e-3, 3.0, math.tau / 65536, load_encoder=0),
    "{delay: 0 s, motor_encoder: {steps: 4000, noise: 2 arcsec}, load_encoder: {noise: 1 arcsec}, loss: 1 %}": (
        sw.controllers.Sampling(250e-6, 0.0, 3.0, math.tau / 4000, 2.0 * ARCSEC, 0.0, ARCSEC, 0.01, 1)
    ),
}


@pytest.mark.parametrize("controller", GIVEN)
def test_the_group_gives_the_sampling_and_is_written_so_that_it_reads_back_the_same(controller):
    found = project(controller)
    assert found.sampling == pytest.approx(GIVEN[controller], rel=1e-12)
    again = from_text(sw.project_text(replace(found, title="another")), Path("axis.yaml"))
    assert again.sampling == found.sampling  # to the bit


def test_the_limit_is_that_of_the_motor():
    assert project("{}", ", max_torque: 7 N*m").sampling.limit == 7.0
    assert project("{}", ", max_speed: 3000 rpm").sampling.limit == sw.controllers.Sampling().limit
    assert project("{}", "").sampling.limit == sw.controllers.Sampling().limit


def test_a_bench_takes_the_controller_of_the_file_and_assumes_one_where_there_is_none():
    found = project("{period: 500 us, motor_encoder: 12 bit}")
    bench = bench_of(found)
    assert bench.sampling == found.sampling
    assert bench.remarks == ()
    assumed = bench_of(replace(found, sampling=None))
    assert assumed.sampling == sw.controllers.Sampling(
        limit=3.0, motor_quantum=math.tau / 2**16, load_quantum=math.tau / 2**24
    )
    assert "Assumed: samples every 250 us" in assumed.remarks[0]


def test_steps_that_are_no_whole_number_are_not_written():
    odd = replace(project("{}"), sampling=sw.controllers.Sampling(limit=3.0, motor_quantum=1e-3))
    with pytest.raises(ValueError, match="project 'axis' cannot be written as a project file"):
        sw.project_text(odd)


WRONG = {
    "none": ["3:13: controller: 'none' is not a group of fields; write for example 'controller: {period: 250 us, "],
    "{period: 0 s}": ["3:22: controller.period: '0 s' is not positive"],
    "{period: 250}": ["3:22: controller.period: '250' has no unit"],
    "{dela: 250 us}": ["3:14: controller.dela: unknown field; did you mean 'delay'?"],
    "{delay: 2 ms}": ["3:21: controller.delay: is 0.002 s; it must be at most 7 periods, 0.00175 s"],
    "{zebra: 2}": [
        "3:14: controller.zebra: unknown field; known here: period, delay, motor_encoder, load_encoder, loss"
    ],
    "{loss: 2}": ["3:20: controller.loss: is 2; it is a share, from 0 to below 1"],
    "{motor_encoder: 16}": ["3:29: controller.motor_encoder: '16' is not an encoder; write 16 bit, or {steps: 65536, "],
    "{motor_encoder: none}": ["3:29: controller.motor_encoder: 'none' is not an encoder"],
    "{motor_encoder: 99 bit}": ["3:29: controller.motor_encoder: '99 bit' is not between 1 and 40 bit"],
    "{motor_encoder: {}}": ["3:29: controller.motor_encoder.steps: is missing; write steps a turn, for example 65536"],
    "{load_encoder: {step: 3, steps: 1}}": [
        "3:29: controller.load_encoder.step: unknown field; did you mean 'steps'?",
        "3:45: controller.load_encoder.steps: '1' is not between 2 and 2^40 steps a turn",
    ],
    "{load_encoder: {steps: 2.5, noise: -1 arcsec}}": [
        "controller.load_encoder.steps: '2.5' is not a whole number",
        "controller.load_encoder.noise: '-1 arcsec' is negative",
    ],
}


@pytest.mark.parametrize("controller", WRONG)
def test_complaints_name_the_field_with_line_and_column(controller):
    with pytest.raises(ProjectError) as told:
        project(controller)
    lines = str(told.value).splitlines()
    assert len(lines) == len(WRONG[controller])
    for line, said in zip(lines, WRONG[controller], strict=True):
        assert line.startswith("axis.yaml:3:")
        assert said in line
