"""Checks of the generated C by compilers, sanitizers and cppcheck, and the error of its single precision."""

import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from c_runner import python_line, random_model, recorded, rough

from damper_estimator.codegen import Choices, damper_of, one_sample, write_fmu
from damper_estimator.codegen.build import FLAGS, build_library, find_compiler
from damper_estimator.codegen.c_files import single_error
from damper_estimator.codegen.compiled_damper import CompiledDamper
from damper_estimator.model import library_models, load_model
from damper_estimator.runtime.estimates import FIELDS
from damper_estimator.signals.admission import DUPLICATE

BAGS = Path(__file__).parents[2] / "bags"
LIMITS = (0.0, 2.0)
COMMANDED = {name for name, path in library_models().items() if "semi_active" in path.read_text(encoding="utf-8")}
needs_compiler = pytest.mark.skipif(find_compiler() is None, reason="no C compiler is installed")


def exported(name: str, single: bool = False):
    return damper_of(load_model(name), Choices(name="d", limits=LIMITS if name in COMMANDED else None, single=single))[
        0
    ]


@pytest.mark.parametrize("compiler", ["gcc", "clang"])
@pytest.mark.parametrize("single", [False, True])
@pytest.mark.parametrize(
    "name", ["carrera_akutain", "semi_active_on_mount", "renault_modified_bouc_wen", "force_surface"]
)
def test_compilers_emit_no_warnings(name, single, compiler, tmp_path):
    if shutil.which(compiler) is None:
        pytest.skip(f"{compiler} is not installed")
    for level in ("-O0", "-O3"):
        CompiledDamper(exported(name, single), tmp_path / level, compiler, (*FLAGS, level))


@pytest.mark.parametrize("compiler", ["gcc", "clang"])
@pytest.mark.parametrize("seed", range(3))
def test_compilers_emit_no_warnings_for_random_chains(seed, compiler, tmp_path):
    if shutil.which(compiler) is None:
        pytest.skip(f"{compiler} is not installed")
    CompiledDamper(damper_of(random_model(100 + seed), Choices(name="d"))[0], tmp_path, compiler)


MAIN = """#include "d.h"
#include <stdio.h>
int main(void)
{
    static d_state state;
    d_input in;
    d_output out = { 0 };
    double sum = 0.0;
    d_init(&state);
    INVERSE(NAN_BEFORE)
    while (fread(&in, sizeof(in), 1, stdin) == 1) {
        (void)d_step(&state, &in, &out);
        (void)d_status_at(&state, in.stamp);
        INVERSE(out.force * 1.1)
        sum += out.force;
    }
    return printf("%g\\n", sum) < 0;
}
"""


@needs_compiler
@pytest.mark.parametrize(
    "name", ["carrera_akutain", "semi_active_on_mount", "mr_damper_with_play", "renault_modified_bouc_wen"]
)
def test_sanitizers_find_nothing_on_rough_and_random_inputs(name, tmp_path):
    damper = exported(name)
    CompiledDamper(damper, tmp_path)
    text = MAIN.replace("NAN_BEFORE", "500.0")
    inverse = "{ d_answer a; d_inverse(&state, \\1, &a); sum += a.evaluations; }" if damper.limits else ""
    (tmp_path / "main.c").write_text(re.sub(r"INVERSE\((.*?)\)$", inverse, text, flags=re.MULTILINE))
    checks = ["-fsanitize=address,undefined,float-cast-overflow", "-fno-sanitize-recover=all", "-g", "-O1"]
    call = [find_compiler(), "-std=c99", *checks, "d.c", "main.c", "-lm", "-o", "main"]
    built = subprocess.run(call, cwd=tmp_path, capture_output=True, text=True, check=False)
    if built.returncode and "asan" in built.stderr:
        pytest.skip(f"the sanitizers are not installed: {built.stderr.strip().splitlines()[-1]}")
    assert built.returncode == 0, built.stderr
    for seed in range(3):
        given = rough(seed, 3000)
        given["reach"] = np.arange(given.size) % 3 == 0
        wild = _wild(seed, 2000)
        for data in (given, wild):
            ran = subprocess.run([tmp_path / "main"], input=data.tobytes(), capture_output=True, check=False)
            assert ran.returncode == 0, ran.stderr.decode()[-2000:]


def _wild(seed: int, size: int) -> np.ndarray:
    """Inputs of random bits, like those of a broken sender; stamps within the range of ROS messages."""
    random = np.random.default_rng(seed)
    given = np.frombuffer(random.bytes(size * one_sample.INPUT.itemsize), one_sample.INPUT).copy()
    step = random.integers(-(10**7), 3 * 10**7, size)
    given["stamp"] = np.where(random.random(size) < 0.02, random.integers(-2 * 10**18, 2 * 10**18, size), step.cumsum())
    given["displacement"] = np.where(random.random(size) < 0.5, random.normal(0.0, 0.1, size), given["displacement"])
    given["acceleration_stamp"] = given["stamp"]
    return given


# Rules of MISRA C:2012 from which the generated code deviates; docs/export.md says why.
DEVIATIONS = {"2.4", "7.2", "8.7", "8.9", "10.4", "10.6", "10.8", "12.1", "14.1", "15.5", "15.7", "17.8"}


@pytest.mark.skipif(shutil.which("cppcheck") is None, reason="cppcheck is not installed")
@pytest.mark.parametrize("name", ["carrera_akutain", "semi_active_on_mount", "renault_modified_bouc_wen"])
def test_cppcheck_and_misra_have_only_the_listed_deviations(name, tmp_path):
    CompiledDamper(exported(name), tmp_path)
    call = ["cppcheck", "--enable=warning,performance,portability", "--std=c99", "--quiet", "--addon=misra",
            "--suppress=missingIncludeSystem", "--error-exitcode=0", "d.c"]  # fmt: skip
    output = subprocess.run(call, cwd=tmp_path, capture_output=True, text=True, check=False).stderr
    rules = set(re.findall(r"misra-c2012-(\d+\.\d+)", output))
    other = [line for line in output.splitlines() if re.search(r"(error|warning|performance|portability):", line)]
    assert not other, other
    assert rules <= DEVIATIONS, {rule: next(x for x in output.splitlines() if rule in x) for rule in rules - DEVIATIONS}


@needs_compiler
@pytest.mark.parametrize("name", library_models())
def test_single_precision_is_exact_to_a_ten_thousandth(name):
    assert single_error(exported(name), seconds=4.0) < 1e-4


@needs_compiler
def test_single_precision_follows_a_recording(tmp_path):
    given = recorded(BAGS / "passenger_road.mcap", "passenger_front")[:6000]
    given["stamp"] -= given["stamp"][0]
    found, verdict = CompiledDamper(exported("carrera_akutain", single=True), tmp_path).run(given)
    good = verdict < DUPLICATE
    force = python_line(exported("carrera_akutain"), given).numbers[good, FIELDS.index("force"), 0]
    assert np.max(np.abs(found["force"][good] - force)) < 1e-4 * np.max(np.abs(force))


@needs_compiler
@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_the_sources_of_an_fmu_compile_without_warnings(version, tmp_path):
    path = tmp_path / "x.fmu"
    write_fmu(load_model("semi_active_yield"), path, Choices(name="x", limits=LIMITS), version)
    shutil.unpack_archive(path, tmp_path / "in", "zip")
    sources = sorted((tmp_path / "in" / "sources").glob("*.c"))
    for compiler in filter(shutil.which, ("gcc", "clang")):
        build_library(sources, tmp_path / "x.so", compiler, (*FLAGS, "-Wno-unused-parameter", "-O3"))


def test_nothing_is_allocated_and_nothing_is_global(tmp_path):
    if find_compiler() is None or shutil.which("nm") is None:
        pytest.skip("needs a compiler and nm")
    CompiledDamper(exported("semi_active_on_mount"), tmp_path)
    subprocess.run([find_compiler(), "-std=c99", "-O1", "-c", "d.c", "-o", "d.o"], cwd=tmp_path, check=True)
    symbols = subprocess.run(["nm", "d.o"], cwd=tmp_path, capture_output=True, text=True, check=True).stdout.split("\n")
    kinds = {line.split()[-1]: line.split()[-2] for line in symbols if line.strip()}
    assert not {name for name, kind in kinds.items() if kind in "bBdDC"}, "mutable global data"
    assert {name for name, kind in kinds.items() if kind == "U"} <= {
        "exp", "expm1", "pow", "tanh", "log", "sin", "cos", "sincos", "sqrt", "atan", "memset", "memcpy",
        "_GLOBAL_OFFSET_TABLE_",
    }  # fmt: skip
