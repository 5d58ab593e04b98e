"""Runs generated C on this machine on arrays of inputs, to measure error and speed, and for tests.

``run`` and ``invert`` are C loops around the generated functions, so that no sample needs a call from Python.
"""

import ctypes
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from damper_estimator.codegen import one_sample
from damper_estimator.codegen.build import FLAGS, build_library
from damper_estimator.codegen.c_source import Damper, Sources, sources, today
from damper_estimator.files import write_text

RUNNER = """#include "NAME.h"

void run(int64_t n, const NAME_input *in, NAME_output *out, int32_t *verdict);
void run(int64_t n, const NAME_input *in, NAME_output *out, int32_t *verdict)
{
    NAME_state state;
    NAME_init(&state);
    for (int64_t i = 0; i < n; ++i) {
        verdict[i] = NAME_step(&state, &in[i], &out[i]);
    }
}
"""
INVERTER = """
void invert(int64_t n, const NAME_input *in, NAME_output *out, int32_t *verdict, const REAL *wanted,
    NAME_answer *answer);
void invert(int64_t n, const NAME_input *in, NAME_output *out, int32_t *verdict, const REAL *wanted,
    NAME_answer *answer)
{
    NAME_state state;
    NAME_init(&state);
    for (int64_t i = 0; i < n; ++i) {
        verdict[i] = NAME_step(&state, &in[i], &out[i]);
        if (verdict[i] < 4) {
            NAME_inverse(&state, wanted[i], &answer[i]);
        }
    }
}
"""


def precise(dtype: np.dtype, single: bool) -> np.dtype:
    """A struct's type in single or double precision."""
    if not single:
        return dtype
    return np.dtype([(n, "f4" if dtype[n] == np.float64 else dtype[n]) for n in dtype.names], align=True)


class CompiledDamper:
    """A damper's C, written into a folder and compiled there; final.

    Attributes:
        made: the sources.
        library: the file.
    """

    def __init__(self, damper: Damper, folder: Path, compiler: str | None = None, flags: Sequence[str] = FLAGS):
        """Raises InputError without a compiler, and Untranslatable as ``sources``."""
        self.made: Sources = sources(damper, today())
        self._single = damper.single
        folder.mkdir(parents=True, exist_ok=True)
        text = (RUNNER + (INVERTER if damper.limits else "")).replace("NAME", damper.name)
        files = {
            f"{damper.name}.h": self.made.header,
            f"{damper.name}.c": self.made.source,
            "runner.c": text.replace("REAL", "float" if damper.single else "double"),
        }
        for name, content in files.items():
            write_text(folder / name, content)
        self.library = folder / "lib.so"
        build_library([folder / f"{damper.name}.c", folder / "runner.c"], self.library, compiler, flags)
        self._functions = ctypes.CDLL(str(self.library))

    def run(self, given: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Outputs (n,) and verdicts (n,) for inputs (n,) of ``one_sample.INPUT``."""
        inputs, outputs, verdict = self._arrays(given)
        self._functions.run(ctypes.c_int64(given.size), *map(_pointer, (inputs, outputs, verdict)))
        return outputs, verdict

    def invert(self, given: np.ndarray, wanted: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The same and the answers to desired forces (n,) in N."""
        inputs, outputs, verdict = self._arrays(given)
        answers = np.zeros(given.size, precise(one_sample.ANSWER, self._single))
        wanted = np.ascontiguousarray(wanted, np.float32 if self._single else float)
        self._functions.invert(ctypes.c_int64(given.size), *map(_pointer, (inputs, outputs, verdict, wanted, answers)))
        return outputs, verdict, answers

    def _arrays(self, given: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        inputs = np.ascontiguousarray(given.astype(precise(one_sample.INPUT, self._single)))
        outputs = np.zeros(given.size, precise(one_sample.OUTPUT, self._single))
        return inputs, outputs, np.zeros(given.size, np.int32)


def _pointer(array: np.ndarray) -> ctypes.c_void_p:
    return array.ctypes.data_as(ctypes.c_void_p)


def inputs(stamp: np.ndarray, displacement: np.ndarray, **channels: np.ndarray) -> np.ndarray:
    """Inputs (n,) of ``one_sample.INPUT``; a channel (n,) arrives at every sample where it is not NaN.

    ``stamp`` (n,) int64 ns, ``displacement`` (n,) m.
    """
    given = np.zeros(stamp.size, one_sample.INPUT)
    given["stamp"], given["displacement"] = stamp, displacement
    for name, values in channels.items():
        given[name] = values
        given[f"{name}_arrived"] = ~np.isnan(given[name])
    return given
