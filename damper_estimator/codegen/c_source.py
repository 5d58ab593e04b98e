"""One damper as C99: a header with the public structs and functions, and a source file."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import UTC, date, datetime

import numpy as np

from damper_estimator import __version__
from damper_estimator.codegen import one_sample, texts
from damper_estimator.codegen.translator import CFunction, Translator
from damper_estimator.codegen.values import REAL, Array, Constant, Number, Record, kind_of, literal, whole
from damper_estimator.compiled import plain
from damper_estimator.control import command_search as search
from damper_estimator.control.inverse import HORIZON, LEAD
from damper_estimator.model.element import walk
from damper_estimator.runtime import Deployed
from damper_estimator.signals.layout import ROWS


@dataclass(frozen=True)
class Sources:
    """The two files and their properties.

    Attributes:
        name: prefix of all public names.
        header, source: texts.
        inverts: whether there is an inverse.
        ram: bytes of the state in NumPy's layout.
    """

    name: str
    header: str
    source: str
    inverts: bool
    ram: int


@dataclass(frozen=True)
class Damper:
    """A damper to export.

    Attributes:
        deployed: the model with filter, limits and region.
        limits: lowest and highest command of the inverse; None for a damper without an inverse.
        single: single precision.
        stale_after: s without a sample after which the status is STALE.
        checksum: of the model's file.
    """

    name: str
    deployed: Deployed
    limits: tuple[float, float] | None = None
    single: bool = False
    stale_after: float = 0.1
    checksum: str = ""


def sources(damper: Damper, today: date) -> Sources:
    """Both files of a damper.

    Raises:
        Untranslatable: if an effect's kernel uses a construct without counterpart in C.
    """
    translator, model = Translator(damper.single), damper.deployed.model
    state = state_of(damper)
    types = {"state": state, "input": one_sample.INPUT, "output": one_sample.OUTPUT, "answer": one_sample.ANSWER}
    for suffix, dtype in types.items():
        translator.struct(dtype, f"{damper.name}_{suffix}")
    interface = _Interface(damper, translator)
    functions = interface.functions()
    kept = ["state", "input", "output", *(["answer"] if damper.limits else [])]
    heading = texts.heading(model, damper, today, __version__)
    structs = "\n\n".join(texts.struct(damper.name, suffix, types[suffix], translator.c_type) for suffix in kept)
    header = texts.header(damper, heading, structs)
    body = translator.source(functions).strip()
    prelude = texts.PRELUDE.replace("REAL", translator.real).replace("SUFFIX", translator.suffix)
    parts = [
        heading,
        f'#include "{damper.name}.h"\n\n#include <math.h>',
        texts.numbers(damper, translator.suffix),
        *([prelude] if "whole_part(" in body else []),
        body,
        *interface.visible(initial(damper)),
    ]
    return Sources(damper.name, header, "\n\n".join(parts) + "\n", damper.limits is not None, state.itemsize)


def today() -> date:
    """The date for the files."""
    return datetime.now(UTC).date()


def kernel_source(kernel: Callable) -> str:
    """An effect's kernel and the functions that it calls, in C.

    Raises:
        Untranslatable: if it uses a construct without counterpart in C.
    """
    translator, known = Translator(), {"kinematics": (ROWS, 1), "force": (1,)}
    names = ("parameters", "settings", "kinematics", "state", "force")
    arguments = [Array(REAL, name, whole(0), known.get(name, ("size",)), frozenset()) for name in names]
    return translator.source([translator.function(plain(kernel), arguments)])


def state_of(damper: Damper) -> np.dtype:
    """The type of a damper's record."""
    program = damper.deployed.model.program
    solvers = program.table.shape[0] if program.series else 0
    return one_sample.state_type(program.motions, program.forces, program.states, solvers, damper.limits is not None)


def initial(damper: Damper) -> np.ndarray:
    """(1,) of the damper's record before the first sample."""
    record, deployed = np.zeros(1, state_of(damper)), damper.deployed.record()
    for name in record.dtype.names:
        if name in deployed.dtype.names:
            record[name] = deployed[name]
    record["slow"] = record["felt"] = np.nan
    record["stale_after"] = round(damper.stale_after * 1e9)
    if damper.limits is not None:
        record["limits"], record["times"] = damper.limits, (HORIZON, LEAD)
        record["sample"] = record["remembered"][..., search.LAST] = np.nan
    return record


class _Interface:
    """The functions that a program calls; final."""

    def __init__(self, damper: Damper, translator: Translator):
        program = damper.deployed.model.program
        kernels = tuple(
            plain(e.effect.kernel) for e in walk(damper.deployed.model.effects) if e.effect.kernel is not None
        )
        self._damper, self._translator = damper, translator
        state = state_of(damper)
        self._kernels, self._table = Constant(kernels), Constant(np.ascontiguousarray(program.table))
        self._model = [self._kernels, self._table, *(
            Array("real", f"state->{name}", whole(0), (size,), frozenset())
            for name, size in (("parameters", program.parameters.size), ("settings", program.settings.size))
        )]  # fmt: skip
        records = {"state": state, "input": one_sample.INPUT, "output": one_sample.OUTPUT, "answer": one_sample.ANSWER}
        self._records = {name: Record(name, dtype, frozenset()) for name, dtype in records.items()}

    def _calls(self) -> dict[str, tuple]:
        state = self._records["state"]
        step = one_sample.step if self._damper.limits is None else one_sample.step_and_follow
        calls = {
            "step": (step, [*self._model, state, self._records["input"], self._records["output"]]),
            "status_at": (one_sample.status_at, [state, Number("long", "now")]),
        }
        if self._damper.limits is not None:
            wanted = Number("real", "desired")
            calls["inverse"] = (one_sample.inverse, [*self._model, state, wanted, self._records["answer"]])
        return calls

    def functions(self) -> list[CFunction]:
        """The translations behind the interface."""
        return [self._translator.function(*call) for call in self._calls().values()]

    def visible(self, record: np.ndarray) -> list[str]:
        """Texts of the functions that the header declares."""
        written = []
        for verb, (function, arguments) in self._calls().items():
            translated = self._translator.function(function, arguments)
            written.append(texts.visible(self._damper, verb, self._translator.call_code(translated, arguments)))
        return [*texts.beginnings(self._damper, self._assignments(record)), *written]

    def _assignments(self, record: np.ndarray) -> list[str]:
        lines = []
        for name in record.dtype.names:
            values = np.atleast_1d(record[name][0]).reshape(-1)
            kind = kind_of(record.dtype[name].base)
            is_list = bool(record.dtype[name].shape)
            lines += self._filled(f"state->{name}", values, kind, is_list)
        return lines

    def _filled(self, place: str, values: np.ndarray, kind: str, is_list: bool) -> Sequence[str]:
        codes = [literal(float(v) if kind == REAL else int(v), self._translator.suffix).code for v in values]
        if not is_list:
            return [f"{place} = {codes[0]};"]
        if len(set(codes)) == 1 and len(codes) > 3:
            return [f"for (int32_t k = 0; k < {len(codes)}; ++k) {{", f"    {place}[k] = {codes[0]};", "}"]
        return [f"{place}[{i}] = {code};" for i, code in enumerate(codes)]
