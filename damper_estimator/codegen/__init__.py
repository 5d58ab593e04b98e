"""Models as C99 and as FMUs, generated from the Python kernels."""

from damper_estimator.codegen.build import find_compiler
from damper_estimator.codegen.c_files import Choices, WrittenC, c_name, damper_of, write_c
from damper_estimator.codegen.c_source import kernel_source
from damper_estimator.codegen.fmu import WrittenFmu, write_fmu
from damper_estimator.codegen.values import Untranslatable

__all__ = [
    "Choices",
    "Untranslatable",
    "WrittenC",
    "WrittenFmu",
    "c_name",
    "damper_of",
    "find_compiler",
    "kernel_source",
    "write_c",
    "write_fmu",
]
