"""modelDescription.xml of an FMU, after the schemas of FMI 2.0 and 3.0, and the build description of a 3.0 one."""

from datetime import date
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from damper_estimator import __version__
from damper_estimator.codegen.fmu_variables import FIRST_INPUT, FIRST_PARAMETER, Output, Unit, outputs_of

_SI = {
    "m": {"m": 1}, "m/s": {"m": 1, "s": -1}, "m/s2": {"m": 1, "s": -2}, "N": {"kg": 1, "m": 1, "s": -2},
    "Pa": {"kg": 1, "m": -1, "s": -2}, "A": {"A": 1}, "s": {"s": 1}, "kg": {"kg": 1},
    "N/m": {"kg": 1, "s": -2}, "N.s/m": {"kg": 1, "s": -1}, "N s/m": {"kg": 1, "s": -1},
    "N/A": {"kg": 1, "m": 1, "s": -2, "A": -1}, "1/m": {"m": -1}, "s/m": {"s": 1, "m": -1}, "m^3": {"m": 3},
}  # fmt: skip


def model_description(unit: Unit, sources: list[str], today: date) -> bytes:
    """The description of one unit; ``sources`` are the names of its C files."""
    is_new = unit.version == "3.0"
    model = unit.damper.deployed.model
    root = Element("fmiModelDescription", {
        "fmiVersion": unit.version, "modelName": model.name, "instantiationToken" if is_new else "guid": unit.token,
        "description": f"damper; {model.source}"[:500], "generationTool": f"damper_estimator {__version__}",
        "generationDateAndTime": f"{today.isoformat()}T00:00:00Z", "variableNamingConvention": "flat",
    })  # fmt: skip
    state = "canGetAndSetFMUState" if is_new else "canGetAndSetFMUstate"
    kind = SubElement(root, "CoSimulation", {
        "modelIdentifier": unit.name, "canHandleVariableCommunicationStepSize": "true", state: "true",
    })  # fmt: skip
    if not is_new:
        kind.set("canNotUseMemoryManagementFunctions", "true")
        listed = SubElement(kind, "SourceFiles")
        for name in sources:
            SubElement(listed, "File", {"name": name})
    outputs = outputs_of(unit.damper)
    _units(SubElement(root, "UnitDefinitions"), unit, outputs)
    SubElement(root, "DefaultExperiment", {"startTime": "0", "stopTime": "10", "stepSize": "0.001"})
    variables = SubElement(root, "ModelVariables")
    (_variables_3 if is_new else _variables_2)(variables, unit, outputs)
    _structure(SubElement(root, "ModelStructure"), unit, outputs, is_new)
    return _bytes(root)


def build_description(unit: Unit, sources: list[str]) -> bytes:
    """How to compile the sources of an FMI 3.0 unit."""
    root = Element("fmiBuildDescription", {"fmiVersion": "3.0"})
    way = SubElement(root, "BuildConfiguration", {"modelIdentifier": unit.name})
    files = SubElement(way, "SourceFileSet", {"language": "C99", "compilerOptions": "-ffp-contract=off"})
    for name in sources:
        SubElement(files, "SourceFile", {"name": name})
    return _bytes(root)


def _bytes(root: Element) -> bytes:
    indent(root)
    return tostring(root, encoding="utf-8", xml_declaration=True) + b"\n"


def _units(parent: Element, unit: Unit, outputs: tuple[Output, ...]) -> None:
    used = {channel.unit for channel in unit.inputs if channel.present} | {out.unit for out in outputs}
    used |= {slot.parameter.unit for slot in unit.damper.deployed.model.slots} - {"1"}
    for name in sorted(used - {""}):
        unit_element = SubElement(parent, "Unit", {"name": name})
        if name == "degC":
            SubElement(unit_element, "BaseUnit", {"K": "1", "offset": "273.15"})
        elif name in _SI:
            SubElement(unit_element, "BaseUnit", {base: str(power) for base, power in _SI[name].items()})


def _entries(unit: Unit, outputs: tuple[Output, ...]) -> list[tuple[str, dict[str, str], dict[str, str]]]:
    """Kind, attributes common to both versions, and those of the type, of all variables except time."""
    entries = []
    for place, channel in enumerate(unit.inputs):
        if channel.present:
            common = {"name": channel.name, "valueReference": str(FIRST_INPUT + place), "causality": "input"}
            common |= {"variability": "continuous", "description": channel.meaning}
            entries.append(("Real", common, {"unit": channel.unit, "start": repr(channel.start)}))
    for out in outputs:
        common = {"name": out.name, "valueReference": str(out.reference), "causality": "output"}
        common |= {"variability": "continuous" if out.kind == "Real" else "discrete", "description": out.meaning}
        entries.append((out.kind, {**common, "initial": "calculated"}, {"unit": out.unit} if out.unit else {}))
    for place, slot in enumerate(unit.damper.deployed.model.slots):
        if unit.tunable[place]:
            common = {"name": slot.address, "valueReference": str(FIRST_PARAMETER + place), "causality": "parameter"}
            common |= {"variability": "tunable", "description": slot.parameter.meaning}
            typed = {"min": repr(float(slot.parameter.lower)), "max": repr(float(slot.parameter.upper))}
            typed |= {"unit": slot.parameter.unit} if slot.parameter.unit != "1" else {}
            entries.append(("Real", common, {**typed, "start": repr(slot.value)}))
    return entries


def _variables_2(parent: Element, unit: Unit, outputs: tuple[Output, ...]) -> None:
    for kind, common, typed in _entries(unit, outputs):
        SubElement(SubElement(parent, "ScalarVariable", common), kind, typed)


def _variables_3(parent: Element, unit: Unit, outputs: tuple[Output, ...]) -> None:
    SubElement(parent, "Float64", {
        "name": "time", "valueReference": "0", "causality": "independent", "variability": "continuous",
    })  # fmt: skip
    names = {"Real": "Float64", "Integer": "Int32", "Boolean": "Boolean"}
    for kind, common, typed in _entries(unit, outputs):
        SubElement(parent, names[kind], {**common, **typed})


def _structure(parent: Element, unit: Unit, outputs: tuple[Output, ...], is_new: bool) -> None:
    if is_new:
        for name in ("Output", "InitialUnknown"):
            for out in outputs:
                SubElement(parent, name, {"valueReference": str(out.reference)})
        return
    first = sum(channel.present for channel in unit.inputs) + 1
    for name in ("Outputs", "InitialUnknowns"):
        listed = SubElement(parent, name)
        for index in range(first, first + len(outputs)):
            SubElement(listed, "Unknown", {"index": str(index)})
