"""Writes the C of a model to disk: options and results."""

import re
import tempfile
from dataclasses import dataclass, replace
from hashlib import sha256
from pathlib import Path

import numpy as np

from damper_estimator.codegen.build import FLAGS, find_compiler
from damper_estimator.codegen.c_source import Damper, Sources, sources, today
from damper_estimator.codegen.compiled_damper import CompiledDamper, inputs
from damper_estimator.codegen.values import Untranslatable
from damper_estimator.control import checked_limits, usable_limits
from damper_estimator.errors import InputError
from damper_estimator.files import write_text
from damper_estimator.model import DamperModel
from damper_estimator.model.model_files import model_yaml
from damper_estimator.runtime import deployed
from damper_estimator.signals import DamperSignals
from damper_estimator.signals.fusion import Fusion

CUTOFF, MAX_GAP, STALE_AFTER = 60.0, 0.1, 0.1  # Hz, s, s
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")


@dataclass(frozen=True)
class Choices:
    """Options of an export.

    Attributes:
        name: prefix of functions and files; "" for the model's name.
        cutoff: Hz of the filter, 0 for none; None for that of the fit, else 60.
        max_gap, lead: s, as in ``runtime.Deployed``.
        fusion, signals: the same.
        limits: lowest and highest command; None for those of the signals or of the fit.
        stale_after: s without a sample after which the status is STALE.
        single: single precision.
        checksum: of the model's file; "" for that of the model's YAML.
    """

    name: str = ""
    cutoff: float | None = None
    max_gap: float = MAX_GAP
    lead: float = 0.0
    fusion: Fusion | None = None
    signals: DamperSignals | None = None
    limits: tuple[float, float] | None = None
    stale_after: float = STALE_AFTER
    single: bool = False
    checksum: str = ""

    def with_map(self, cutoff: float, fusion: Fusion | None, signals: DamperSignals) -> "Choices":
        """The same options with the values of a damper in a signal map."""
        return replace(self, cutoff=cutoff, fusion=fusion, signals=signals)


@dataclass(frozen=True)
class WrittenC:
    """The result of `write_c`.

    Attributes:
        header, source: files.
        ram: bytes of the state.
        without_inverse: why there is no inverse; "" with an inverse.
        error: of single precision, largest difference of force over the largest force; NaN in double precision and
            without a compiler.
    """

    header: Path
    source: Path
    ram: int
    without_inverse: str
    error: float


def c_name(text: str) -> str:
    """A valid C name from any text; "" if nothing is left."""
    name = re.sub(r"\W+", "_", text.encode("ascii", "ignore").decode()).strip("_").lower()
    return f"damper_{name}" if name[:1].isdigit() else name


def damper_of(model: DamperModel, choices: Choices) -> tuple[Damper, str]:
    """The damper to export, and why it has no inverse ("" if it has one).

    Raises:
        InputError: for an invalid C name, or if the model cannot be deployed.
    """
    name = choices.name or c_name(model.name)
    if not _NAME.fullmatch(name):
        raise InputError(f"name {name!r} is not a C name; use letters, digits and underscores")
    cutoff = float(model.fit.get("cutoff") or CUTOFF) if choices.cutoff is None else choices.cutoff
    deployed_model = deployed(model, cutoff, choices.max_gap, choices.lead, choices.fusion, choices.signals)
    reason, limits = "", None
    try:
        limits = checked_limits(model, choices.limits or usable_limits(name, deployed_model)[0])
    except InputError as error:
        if choices.limits is not None:
            raise
        reason = str(error)
    checksum = choices.checksum or sha256(model_yaml(model).encode()).hexdigest()
    return Damper(name, deployed_model, limits, choices.single, choices.stale_after, checksum), reason


def sources_of(damper: Damper) -> Sources:
    """The texts of both files.

    Raises:
        InputError: names the effect that cannot be written in C.
    """
    try:
        return sources(damper, today())
    except Untranslatable as error:
        raise InputError(f"model {damper.deployed.model.name}: cannot be written in C: {error}") from error


def write_c(model: DamperModel, folder: Path, choices: Choices | None = None) -> WrittenC:
    """Writes ``NAME.h`` and ``NAME.c``.

    Raises:
        InputError: if the model cannot be deployed or written in C, or the folder cannot be written.
    """
    damper, reason = damper_of(model, choices or Choices())
    made = sources_of(damper)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot be created ({error.strerror}); choose another folder") from error
    header, source = folder / f"{damper.name}.h", folder / f"{damper.name}.c"
    write_text(header, made.header)
    write_text(source, made.source)
    error = single_error(damper) if damper.single and find_compiler() else float("nan")
    return WrittenC(header, source, made.ram, reason, error)


def single_error(damper: Damper, seconds: float = 10.0) -> float:
    """Largest difference of force between single and double precision, over the largest force: for a sine of 20 mm
    swept from 0.5 to 6.5 Hz, at 1 kHz.
    """
    time = np.arange(0.0, seconds, 1e-3)
    x = 0.02 * np.sin(2.0 * np.pi * (0.5 + 3.0 * time / seconds) * time)
    low, high = damper.limits or (np.nan, np.nan)
    command = low + (high - low) * (0.5 + 0.5 * np.sin(time))
    given, quick = inputs(np.round(1e9 * time).astype(np.int64), x, command=command), (*FLAGS, "-O0")
    with tempfile.TemporaryDirectory() as folder:
        one, other = (
            CompiledDamper(replace(damper, single=single), Path(folder) / str(single), None, quick).run(given)[0][
                "force"
            ]
            for single in (True, False)
        )
    return float(np.max(np.abs(one - other)) / max(np.max(np.abs(other)), 1e-9))
