"""A model as a functional mock-up unit (FMI 2.0 or 3.0, co-simulation): the C of `write_c` behind FMI's functions."""

import platform
import sys
import tempfile
import zipfile
from dataclasses import dataclass, replace
from hashlib import sha256
from importlib.resources import files
from pathlib import Path

import numpy as np

from damper_estimator.codegen.build import FLAGS, build_library, find_compiler
from damper_estimator.codegen.c_files import Choices, damper_of, sources_of
from damper_estimator.codegen.c_source import today
from damper_estimator.codegen.description import build_description, model_description
from damper_estimator.codegen.fmu_variables import Unit, inputs_of
from damper_estimator.codegen.values import literal
from damper_estimator.errors import InputError
from damper_estimator.model import DamperModel
from damper_estimator.model.element import labels

VERSIONS = ("2.0", "3.0")
_PARTS = {"2.0": "fmi2.c", "3.0": "fmi3.c"}
_NAME = "damper"  # of the C inside: each unit is a separate library
_STAMP = (1980, 1, 1, 0, 0, 0)  # of the files in the archive: one model yields the same bytes on the same day


@dataclass(frozen=True)
class WrittenFmu:
    """The result of `write_fmu`.

    Attributes:
        binary: whether it contains one for this platform.
        untunable: addresses of parameters that an importing program cannot change, because other numbers are computed
            from them when a model is loaded.
    """

    path: Path
    binary: bool
    untunable: tuple[str, ...]


def write_fmu(
    model: DamperModel, path: Path, choices: Choices | None = None, version: str = "2.0", binary: bool = True
) -> WrittenFmu:
    """Writes an FMU with sources and, on request, a binary for this platform; in double precision, without fusion.

    Raises:
        InputError: if the model cannot be deployed or written in C, no compiler is installed for a requested binary, or
            the file cannot be written.
    """
    if version not in VERSIONS:
        raise InputError(f"FMI {version}: is unknown; choose {' or '.join(VERSIONS)}")
    if binary and find_compiler() is None:
        raise InputError(
            f"{path}: the binary needs a C compiler (CC, cc, gcc or clang); install one, or write "
            "only the sources (--source-only)"
        )
    damper, _ = damper_of(model, replace(choices or Choices(), single=False, fusion=None))
    tunable = tunable_parameters(model)
    texts = sources_of(replace(damper, name=_NAME))
    token = f"{{{sha256((texts.source + version).encode()).hexdigest()[:32]}}}"
    unit = Unit(damper.name, damper, version, token, tunable, inputs_of(damper))
    inside = {
        "damper.h": texts.header,
        "damper.c": texts.source,
        "config.h": configuration(unit),
        "unit.h": _text("unit.h"),
        _PARTS[version]: _text(_PARTS[version]),
    }
    members = {f"sources/{name}": text.encode() for name, text in inside.items()}
    members["modelDescription.xml"] = model_description(unit, sorted(n for n in inside if n.endswith(".c")), today())
    if version == "3.0":
        members["sources/buildDescription.xml"] = build_description(unit, sorted(n for n in inside if n.endswith(".c")))
    if binary:
        members[_binary_place(unit)] = _compiled(inside, version)
    _write(path, members)
    untunable = tuple(slot.address for slot, free in zip(model.slots, tunable, strict=True) if not free)
    return WrittenFmu(path, binary, untunable)


def tunable_parameters(model: DamperModel) -> tuple[bool, ...]:
    """For every slot of a model: whether it can change while the model runs.

    It cannot if an effect computes its settings from its parameters (tables, slopes), which would then be outdated. A
    call of ``prepare`` with other values shows whether it does.
    """
    free = []
    for _, element in labels(model.effects):
        given = np.asarray(element.effect.prepare(element.parameters, element.settings), float)
        other = {
            name: tuple(1.5 * v + 1e-3 * (i + 1) for i, v in enumerate(value))
            if isinstance(value, tuple)
            else 1.1 * value + 1e-3
            for name, value in element.parameters.items()
        }
        same = np.array_equal(given, np.asarray(element.effect.prepare(other, element.settings), float))
        free += [same] * sum(np.atleast_1d(value).size for value in element.parameters.values())
    return tuple(free)


def configuration(unit: Unit) -> str:
    """``config.h``: the part of the C that is specific to this unit."""
    slots = unit.damper.deployed.model.slots
    columns = {
        "static const double LOWEST": [literal(float(slot.parameter.lower)).code for slot in slots],
        "static const double HIGHEST": [literal(float(slot.parameter.upper)).code for slot in slots],
        "static const bool TUNABLE": ["true" if free else "false" for free in unit.tunable],
    }
    arrays = [f"{head}[{max(len(v), 1)}] = {{ {', '.join(v) or '0'} }};" for head, v in columns.items()]
    present = ", ".join("true" if channel.present else "false" for channel in unit.inputs)
    starts = ", ".join(literal(float(channel.start)).code for channel in unit.inputs)
    return "\n".join(
        [
            "/* What distinguishes this unit from another. */",
            "#ifndef CONFIG_H",
            "#define CONFIG_H",
            "",
            "#include <stdbool.h>",
            "",
            f'#define TOKEN "{unit.token}"',
            f"#define INVERTS {int(unit.damper.limits is not None)}",
            f"enum {{ PARAMETERS = {max(len(slots), 1)} }};",
            *arrays,
            f"static const bool IS_INPUT[{len(unit.inputs)}] = {{ {present} }};",
            f"static const double INPUT_START[{len(unit.inputs)}] = {{ {starts} }};",
            "",
            "#endif",
            "",
        ]
    )


def _text(name: str) -> str:
    return (files("damper_estimator.codegen") / "fmi" / name).read_text(encoding="utf-8")


def _binary_place(unit: Unit) -> str:
    systems = {"linux": ("linux", ".so"), "darwin": ("darwin", ".dylib"), "win32": ("windows", ".dll")}
    system, suffix = systems.get(sys.platform, ("linux", ".so"))
    machine = {"arm64": "aarch64", "amd64": "x86_64"}.get(platform.machine().lower(), platform.machine().lower())
    if unit.version == "3.0":
        return f"binaries/{machine}-{system}/{unit.name}{suffix}"
    old = {"linux": "linux64", "darwin": "darwin64", "windows": "win64"}[system]
    return f"binaries/{old if machine == 'x86_64' else f'{machine}-{system}'}/{unit.name}{suffix}"


def _compiled(inside: dict[str, str], version: str) -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        for name, text in inside.items():
            (Path(folder) / name).write_text(text, encoding="utf-8")
        target = Path(folder) / "unit.so"
        parts = [Path(folder) / name for name in ("damper.c", _PARTS[version])]
        build_library(parts, target, None, (*FLAGS, "-Wno-unused-parameter"))
        return target.read_bytes()


def _write(path: Path, members: dict[str, bytes]) -> None:
    try:
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
            for name, content in members.items():
                archive.writestr(zipfile.ZipInfo(name, _STAMP), content, zipfile.ZIP_DEFLATED)
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({error.strerror}); choose another path") from error
