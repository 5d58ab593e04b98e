"""FMUs: valid for FMPy, the same forces as the line, and errors instead of crashes."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from c_runner import python_line, recorded

from damper_estimator.codegen import Choices, build, damper_of, write_fmu
from damper_estimator.codegen.compiled_damper import inputs
from damper_estimator.codegen.fmu import tunable_parameters
from damper_estimator.control import InverseModel
from damper_estimator.errors import InputError
from damper_estimator.model import load_model
from damper_estimator.runtime.estimates import FIELDS

fmpy = pytest.importorskip("fmpy", reason="FMPy is not installed")
pytest.importorskip("fmpy.validation")
pytest.importorskip("fmpy.fmi3")
needs_compiler = pytest.mark.skipif(build.find_compiler() is None, reason="no C compiler is installed")
both = pytest.mark.parametrize("version", ["2.0", "3.0"])
BAGS = Path(__file__).parents[2] / "bags"
LIMITS = (0.0, 2.0)


class Instance:
    """One instance of an FMU of any version, with access by the variables' names."""

    def __init__(self, path: Path, folder: Path, start: float = 0.0):
        self.description = fmpy.read_model_description(str(path))
        unpacked = fmpy.extract(str(path), str(folder))
        made = {"2.0": fmpy.fmi2.FMU2Slave, "3.0": fmpy.fmi3.FMU3Slave}[self.description.fmiVersion]
        kind = self.description.coSimulation
        self.fmu = made(
            guid=self.description.guid or self.description.instantiationToken, unzipDirectory=unpacked,
            modelIdentifier=kind.modelIdentifier, instanceName="one",
        )  # fmt: skip
        self.references = {v.name: (v.valueReference, v.type) for v in self.description.modelVariables}
        self.fmu.instantiate()
        if self.is_old:
            self.fmu.setupExperiment(startTime=start)
            self.fmu.enterInitializationMode()
        else:
            self.fmu.enterInitializationMode(startTime=start)
        self.fmu.exitInitializationMode()

    @property
    def is_old(self) -> bool:
        return self.description.fmiVersion == "2.0"

    def set(self, **values: float) -> None:
        for name, value in values.items():
            reference, _ = self.references[name.replace("__", ".")]
            (self.fmu.setReal if self.is_old else self.fmu.setFloat64)([reference], [value])

    def get(self, name: str) -> float:
        reference, kind = self.references[name]
        kind = {"Float64": "Float64", "Int32": "Int32"}.get(kind, kind)
        return getattr(self.fmu, f"get{kind}")([reference])[0]

    def step(self, time: float, length: float) -> None:
        self.fmu.doStep(currentCommunicationPoint=time, communicationStepSize=length)


@pytest.fixture(scope="module")
def units(tmp_path_factory):
    """Path of a unit by model and version."""
    folder, made = tmp_path_factory.mktemp("units"), {}

    def of(model: str, version: str, **choices) -> Path:
        if (model, version) not in made:
            path = folder / f"{model}_{version[0]}.fmu"
            write_fmu(load_model(model), path, Choices(name=model, **choices), version)
            made[model, version] = path
        return made[model, version]

    return of


@needs_compiler
@both
@pytest.mark.parametrize("model", ["carrera_akutain", "semi_active_on_mount", "renault_modified_bouc_wen", "dahl"])
def test_fmpy_finds_nothing_wrong(units, version, model):
    limits = LIMITS if model.startswith("semi") else None
    assert fmpy.validation.validate_fmu(str(units(model, version, limits=limits))) == []


@needs_compiler
@both
@pytest.mark.parametrize(
    ("model", "bag", "name"),
    [
        ("carrera_akutain", "passenger_road", "passenger_front"),
        ("semi_active_on_mount", "semi_active_road", "semi_active"),
    ],
)
def test_steps_of_a_recording_give_the_forces_of_the_line(units, version, model, bag, name, tmp_path):
    raw = recorded(BAGS / f"{bag}.mcap", name)[:1500]
    raw = raw[np.diff(raw["stamp"], prepend=0) > 0]
    stamp = raw["stamp"] - raw["stamp"][0]
    command = 1.0 + np.sin(stamp * 4e-9)
    is_active = model.startswith("semi")
    given = inputs(stamp, raw["displacement"], **({"command": command} if is_active else {}))
    exported, _ = damper_of(load_model(model), Choices(name="d", limits=LIMITS if is_active else None))
    answered = python_line(replace(exported, limits=None), given)
    unit = Instance(units(model, version, limits=LIMITS if is_active else None), tmp_path)
    inverse = InverseModel(load_model(model), LIMITS) if is_active else None
    for i in range(given.size):
        unit.set(displacement=given["displacement"][i])
        if inverse:
            unit.set(command=command[i], desired_force=500.0)
        time = stamp[i] / 1e9
        unit.step(time, (stamp[i + 1] - stamp[i]) / 1e9 if i + 1 < given.size else 0.002)
        for label in ("velocity", "force"):
            assert unit.get(label) == answered.numbers[i, FIELDS.index(label), 0]
        assert unit.get("status") == answered.status[i, 0]
        if inverse:
            inverse.solve(answered.blocks[0, :, i], slope=True)
            assert unit.get("current") == inverse.again(500.0).current


@needs_compiler
@both
def test_invalid_input_is_an_error_and_changes_nothing(units, version, tmp_path):
    unit = Instance(units("carrera_akutain", version), tmp_path)
    for i in range(100):
        unit.set(displacement=0.01 * np.sin(0.1 * i))
        unit.step(1e-3 * i, 1e-3)
    before = unit.get("force")
    for wrong in (np.nan, np.inf, 2e6):
        unit.set(displacement=wrong)
        with pytest.raises(Exception, match=r"(?i)status 3|error"):
            unit.step(0.1, 1e-3)
    unit.set(displacement=0.01)
    for time, length in ((0.05, 1e-3), (np.nan, 1e-3), (1e12, 1e-3), (0.1, -1.0), (0.1, np.nan)):
        with pytest.raises(Exception, match=r"(?i)status 3|error"):
            unit.step(time, length)
    with pytest.raises(Exception, match=r"(?i)status 3|error"):
        unit.set(gas_spring__static_force=-1.0)
    assert unit.get("force") == before
    unit.step(0.1, 1e-3)
    assert np.isfinite(unit.get("force"))


@needs_compiler
@both
def test_instances_have_separate_parameters(units, version, tmp_path):
    one, other = (Instance(units("coulomb", version), tmp_path / name) for name in ("one", "other"))
    address = next(s.address for s in load_model("coulomb").slots if s.parameter.linear)
    value = one.get(address)
    other.set(**{address.replace(".", "__"): 0.5 * value})
    for i in range(50):
        for unit in (one, other):
            unit.set(displacement=0.01 * np.sin(0.3 * i))
            unit.step(1e-3 * i, 1e-3)
    assert one.get(address) == value and other.get(address) == 0.5 * value
    changed = load_model("coulomb").with_values({address: 0.5 * value})
    given = inputs(np.arange(50) * 10**6, 0.01 * np.sin(0.3 * np.arange(50)))
    for unit, model in ((one, load_model("coulomb")), (other, changed)):
        expected = python_line(damper_of(model, Choices(name="d"))[0], given).numbers[-1, FIELDS.index("force"), 0]
        assert unit.get("force") == expected


@needs_compiler
@both
def test_a_saved_state_is_restored(units, version, tmp_path):
    unit = Instance(units("dahl", version), tmp_path)

    def drive(first: int) -> list[float]:
        forces = []
        for i in range(first, first + 40):
            unit.set(displacement=0.01 * np.sin(0.3 * i))
            unit.step(1e-3 * i, 1e-3)
            forces.append(unit.get("force"))
        return forces

    drive(0)
    state = unit.fmu.getFMUstate() if unit.is_old else unit.fmu.getFMUState()
    first = drive(40)
    (unit.fmu.setFMUstate if unit.is_old else unit.fmu.setFMUState)(state)
    assert drive(40) == first
    (unit.fmu.freeFMUstate if unit.is_old else unit.fmu.freeFMUState)(state)


def test_parameters_that_settings_are_prepared_from_are_not_tunable():
    model = load_model("renault_modified_bouc_wen")
    fixed = {s.address for s, free in zip(model.slots, tunable_parameters(model), strict=True) if not free}
    assert fixed == {s.address for s in model.slots if s.address.startswith("renault_hysteresis")}
    assert all(tunable_parameters(load_model("carrera_akutain")))


@both
def test_without_a_compiler_a_source_fmu_is_written_on_request(monkeypatch, tmp_path, version):
    monkeypatch.setattr("damper_estimator.codegen.fmu.find_compiler", lambda: None)
    path = tmp_path / "x.fmu"
    with pytest.raises(InputError, match="C compiler.*--source-only"):
        write_fmu(load_model("coulomb"), path, Choices(name="x"), version)
    made = write_fmu(load_model("coulomb"), path, Choices(name="x"), version, binary=False)
    assert not made.binary
    description = fmpy.read_model_description(str(path))
    assert description.coSimulation.modelIdentifier == "x"
    parameter = next(v for v in description.modelVariables if v.causality == "parameter")
    assert parameter.variability == "tunable" and parameter.unit and parameter.min is not None and parameter.description
