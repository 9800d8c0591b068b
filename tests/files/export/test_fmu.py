"""Functional mock-up units, simulated by FMPy, against the Python plant: its `validate` alone would not load them."""

import math
import shutil
import zipfile
from functools import cache

import numpy as np
import pytest
from c_compiler import doubles, needs_cc
from scipy.integrate import solve_ivp

import strainwave as sw
from strainwave.files.export import fmu
from strainwave.files.export.plant import OUTPUTS, plant_of

fmpy = pytest.importorskip("fmpy", reason="FMPy (extra `fmi`) is not installed")

DRIVE = sw.HDC_40_050._replace(law=sw.Cubic(7160.0, 1e3), B=1.0)
TRAIN = DRIVE.train(
    kinematic_error=sw.KinematicError((sw.Line(2, 1e-4), sw.Line(4, 3e-5, 0.7))), load_drag=sw.train.AngleTorque(0.4)
)
MOTOR, LOAD, END = 0.5, -1.0, 0.5
NAMES = [name for name, _, _ in OUTPUTS]
TIMES = np.linspace(0.0, END, 501)
KINDS = ["fmu2", "fmu3"]


@cache
def run_up():
    """Outputs (6, 501) of the Python train over a run-up through its resonance, by an integrator of SciPy."""
    plant = plant_of(TRAIN, 1e-4)
    train = plant.under(MOTOR, LOAD)
    run = solve_ivp(
        lambda _, y: train.rhs(0.0, tuple(y)), (0.0, END), np.zeros(4), "DOP853", TIMES, rtol=1e-12, atol=1e-14
    )
    assert run.success
    return np.array(plant.outputs(tuple(run.y)))


def simulated(path, kind="CoSimulation", interval=1e-3, **options):
    signals = np.array(
        [(0.0, MOTOR, LOAD), (END, MOTOR, LOAD)], [(n, float) for n in ("time", "motor_torque", "load_torque")]
    )
    run = fmpy.simulate_fmu(
        str(path), stop_time=END, output_interval=interval, step_size=interval, fmi_type=kind, input=signals, **options
    )
    return np.array([run[name] for name in NAMES])


@needs_cc
@pytest.mark.parametrize("kind", KINDS)
def test_fmpy_runs_through_the_resonance_as_python_does(kind, tmp_path):
    path = sw.export(TRAIN, tmp_path / "joint.fmu", to=kind, step=1e-4).path
    ours, theirs = run_up(), simulated(path)
    assert 2.0 * ours[1, -1] > 1.5 * DRIVE.omega_0  # order 2 has gone through the resonance
    assert np.max(np.abs(ours[4])) > 2.0 * abs(ours[4, -1])  # and there was a peak on the way
    assert np.max(np.abs(theirs - ours) / np.max(np.abs(ours), axis=1, keepdims=True)) < 1e-8


@needs_cc
@pytest.mark.parametrize("kind", KINDS)
def test_steps_between_communication_points_are_equal_and_at_most_the_step(kind, tmp_path):
    path = sw.export(TRAIN, tmp_path / "joint.fmu", to=kind, step=1e-4).path
    ours, theirs = run_up()[:, ::10], simulated(path, interval=1e-2)
    assert np.max(np.abs(theirs - ours) / np.max(np.abs(ours), axis=1, keepdims=True)) < 1e-8


@needs_cc
def test_model_exchange_gives_the_rates_of_the_train(tmp_path):
    path = sw.export(TRAIN, tmp_path / "joint.fmu", to="fmu2", step=1e-4).path
    folder, description = fmpy.extract(str(path)), fmpy.read_model_description(str(path))
    unit = fmpy.instantiate_fmu(folder, description, fmi_type="ModelExchange")
    unit.setupExperiment(startTime=0.0)
    unit.enterInitializationMode()
    references = {variable.name: variable.valueReference for variable in description.modelVariables}
    unit.setReal([references["motor_torque"], references["load_torque"]], [MOTOR, LOAD])
    unit.exitInitializationMode()
    unit.enterContinuousTimeMode()
    y, rates, found = doubles(1e-4, -0.03, 0.4, 20.0), doubles(*[0.0] * 4), doubles(*[0.0] * 4)
    unit.setContinuousStates(y, 4)
    unit.getDerivatives(rates, 4)
    unit.getContinuousStates(found, 4)
    assert list(found) == list(y)
    train = plant_of(TRAIN, 1e-4).under(MOTOR, LOAD)
    np.testing.assert_allclose(list(rates), train.rhs(0.0, tuple(y)), rtol=1e-12)
    unit.terminate()
    unit.freeInstance()


@needs_cc
def test_model_exchange_runs_with_the_integrator_of_fmpy(tmp_path):
    path = sw.export(TRAIN, tmp_path / "joint.fmu", to="fmu2", step=1e-4).path
    ours, theirs = run_up(), simulated(path, "ModelExchange", relative_tolerance=1e-10)
    assert (
        np.max(np.abs(theirs - ours) / np.max(np.abs(ours), axis=1, keepdims=True)) < 2e-6
    )  # as accurate as CVode is here


@needs_cc
@pytest.mark.parametrize("kind", KINDS)
def test_a_state_can_be_set_saved_and_restored(kind, tmp_path):
    path = sw.export(TRAIN, tmp_path / "joint.fmu", to=kind, step=1e-4).path
    still = simulated(path, start_values={"state motor angle'": 7.0})
    assert still[1, 0] == 7.0
    folder, description = fmpy.extract(str(path)), fmpy.read_model_description(str(path))
    unit = fmpy.instantiate_fmu(folder, description, fmi_type="CoSimulation")
    if kind == "fmu2":
        unit.setupExperiment(startTime=0.0)
    unit.enterInitializationMode()
    unit.exitInitializationMode()
    get, put = (unit.getReal, unit.setReal) if kind == "fmu2" else (unit.getFloat64, unit.setFloat64)
    put([1], [MOTOR])
    unit.doStep(currentCommunicationPoint=0.0, communicationStepSize=0.01)
    kept, before = unit.getFMUState(), get([11, 12, 13])
    unit.doStep(currentCommunicationPoint=0.01, communicationStepSize=0.01)
    after = get([11, 12, 13])
    unit.setFMUState(kept)
    assert get([11, 12, 13]) == before != after
    unit.doStep(currentCommunicationPoint=0.01, communicationStepSize=0.01)
    assert get([11, 12, 13]) == after
    unit.freeFMUState(kept)
    with pytest.raises(Exception, match=r"fmi\dSet"):
        put([1], [math.nan])
    with pytest.raises(Exception, match=r"fmi\dGet"):
        get([99])
    unit.terminate()
    unit.freeInstance()


@needs_cc
@pytest.mark.parametrize("kind", KINDS)
def test_a_unit_begins_with_the_given_state(kind, tmp_path):
    path = sw.export(TRAIN, tmp_path / "joint.fmu", to=kind, start=(2e-4, -0.1, 3.0, 7.0)).path
    assert simulated(path)[[0, 1, 4], 0] == pytest.approx((3.0, 7.0, 2e-4), rel=1e-15)
    starts = {v.name: v.start for v in fmpy.read_model_description(str(path)).modelVariables}
    assert float(starts["state x'"]) == -0.1


@needs_cc
@pytest.mark.parametrize("kind", KINDS)
def test_the_description_is_valid_and_names_what_it_depends_on(kind, tmp_path):
    path = sw.export(TRAIN, tmp_path / "joint.fmu", to=kind, step=1e-4).path
    assert fmpy.validation.validate_fmu(str(path)) == []
    description = fmpy.read_model_description(str(path), validate_variable_names=True, validate_model_structure=True)
    units = {variable.name: variable.unit for variable in description.modelVariables if variable.causality == "output"}
    assert units == {name: unit for name, unit, _ in OUTPUTS}
    for output in description.outputs:  # on no input: a loop through the unit needs no iteration
        assert [v.name for v in output.dependencies] == [f"state {name}" for name, _ in plant_of(TRAIN).states()]


@pytest.mark.parametrize("kind", KINDS)
def test_the_same_train_gives_the_same_bytes(kind, tmp_path):
    first, second = (sw.export(TRAIN, tmp_path / folder / "joint.fmu", to=kind).path for folder in _folders(tmp_path))
    assert first.read_bytes() == second.read_bytes()
    assert first.read_bytes() != sw.export(DRIVE, tmp_path / "joint.fmu", to=kind).path.read_bytes()


def _folders(tmp_path):
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        yield name


@pytest.mark.parametrize("kind", KINDS)
def test_without_a_compiler_the_unit_holds_the_sources_and_says_so(kind, tmp_path, monkeypatch):
    monkeypatch.setattr(fmu.shutil, "which", lambda _: None)
    found = sw.export(TRAIN, tmp_path / "joint.fmu", to=kind, step=1e-5)
    assert found.notes == ("no compiler cc was found: the FMU contains the sources only; compile them on the target",)
    with zipfile.ZipFile(found.path) as unit:
        names = unit.namelist()
    assert {"modelDescription.xml", "sources/plant.c", f"sources/fmi{kind[-1]}.c"} < set(names)
    assert not [name for name in names if name.startswith("binaries")]


def test_a_compiler_that_fails_is_quoted_and_nothing_is_written(tmp_path, monkeypatch):
    failing = shutil.which("false")
    monkeypatch.setattr(fmu.shutil, "which", lambda _: failing)
    with pytest.raises(RuntimeError, match=r"could not build the unit: no reason given; export to C and build it"):
        sw.export(TRAIN, tmp_path / "joint.fmu", to="fmu2")
    assert list(tmp_path.iterdir()) == []


@needs_cc
@pytest.mark.parametrize("kind", KINDS)
def test_two_instances_do_not_touch_each_other_and_an_endless_step_is_refused(kind, tmp_path):
    path = sw.export(TRAIN, tmp_path / "joint.fmu", to=kind, step=1e-4).path
    folder, description = fmpy.extract(str(path)), fmpy.read_model_description(str(path))
    units = [fmpy.instantiate_fmu(folder, description, fmi_type="CoSimulation") for _ in range(2)]
    for unit in units:
        if kind == "fmu2":
            unit.setupExperiment(startTime=0.0)
        unit.enterInitializationMode()
        unit.exitInitializationMode()

    def calls(unit):
        return (unit.getReal, unit.setReal) if kind == "fmu2" else (unit.getFloat64, unit.setFloat64)

    (driven, put), (still, _) = map(calls, units)
    begun = driven([11, 12, 13])
    put([1], [MOTOR])
    units[0].doStep(currentCommunicationPoint=0.0, communicationStepSize=0.01)
    moved = driven([11, 12, 13])
    assert still([11, 12, 13]) == begun != moved
    for span in (1e300, math.inf, math.nan, 0.0, -0.01):
        with pytest.raises(Exception, match=r"fmi\dDoStep"):
            units[0].doStep(currentCommunicationPoint=0.01, communicationStepSize=span)
    assert driven([11, 12, 13]) == moved
    units[0].reset()
    assert driven([11, 12, 13]) == begun
    for unit in units:
        unit.freeInstance()
