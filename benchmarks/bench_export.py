"""Generated C on this machine: mean and worst time of a step over an hour of road and of the inverse; sizes.

The mean is processor time. The worst step is timed with a clock around every call, which itself costs about 30 ns; the
same hour runs three times and the smallest of the three times of each step counts, to exclude interrupts.
"""

import ctypes
import subprocess
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

from damper_estimator.codegen import Choices, damper_of
from damper_estimator.codegen.build import FLAGS, build_library, find_compiler
from damper_estimator.codegen.c_source import Damper
from damper_estimator.codegen.compiled_damper import CompiledDamper, inputs
from damper_estimator.model import load_model

RATE, SECONDS, ROUNDS = 1000, 3600, 3
LIMITS = (0.0, 2.0)
MODELS = (
    ("carrera_akutain", None),
    ("mr_damper_on_mount", None),
    ("semi_active_yield", LIMITS),
    ("semi_active_on_mount", LIMITS),
)
TIMER = """#define _POSIX_C_SOURCE 199309L
#include "NAME.h"
#include <time.h>
static int64_t at(clockid_t clock)
{
    struct timespec t;
    clock_gettime(clock, &t);
    return t.tv_sec * INT64_C(1000000000) + t.tv_nsec;
}
int64_t whole(int64_t n, const NAME_input *in);
void each(int64_t n, const NAME_input *in, const REAL *wanted, int32_t inverts, int32_t *times);
int64_t whole(int64_t n, const NAME_input *in)
{
    NAME_state state; NAME_output out; int64_t start;
    NAME_init(&state);
    start = at(CLOCK_THREAD_CPUTIME_ID);
    for (int64_t i = 0; i < n; ++i) { NAME_step(&state, &in[i], &out); }
    return at(CLOCK_THREAD_CPUTIME_ID) - start;
}
void each(int64_t n, const NAME_input *in, const REAL *wanted, int32_t inverts, int32_t *times)
{
    NAME_state state; NAME_output out; int32_t took; int64_t start;
    NAME_init(&state);
    for (int64_t i = 0; i < n; ++i) {
        start = at(CLOCK_MONOTONIC);
        NAME_step(&state, &in[i], &out);
        if (inverts) { start = at(CLOCK_MONOTONIC); INVERSE }
        took = (int32_t)(at(CLOCK_MONOTONIC) - start);
        if (took < times[i]) { times[i] = took; }
    }
}
"""


def road(seconds: int) -> np.ndarray:
    """Displacement (n,) in m of a damper on a road: noise with a falling spectrum, 15 mm rms, up to 30 Hz."""
    random = np.random.default_rng(1)
    n = seconds * RATE
    frequency = np.fft.rfftfreq(n, 1.0 / RATE)
    shape = np.where((frequency > 0.3) & (frequency < 30.0), 1.0 / np.maximum(frequency, 0.3), 0.0)
    x = np.fft.irfft(shape * np.exp(2j * np.pi * random.random(frequency.size)), n)
    return 0.015 * x / x.std()


def measure(damper: Damper, given: np.ndarray, wanted: np.ndarray, folder: Path) -> dict[str, float]:
    """Times in ns and sizes in bytes."""
    CompiledDamper(damper, folder)
    text = TIMER.replace("NAME", damper.name).replace("REAL", "double")
    inverse = (
        f"{damper.name}_answer a; {damper.name}_inverse(&state, wanted[i], &a);" if damper.limits else "(void)wanted;"
    )
    (folder / "timer.c").write_text(text.replace("INVERSE", inverse))
    library = folder / "timer.so"
    build_library(
        [folder / f"{damper.name}.c", folder / "timer.c"], library, None, [f for f in FLAGS if f != "-Werror"]
    )
    c = ctypes.CDLL(str(library))
    c.whole.restype = ctypes.c_int64
    n, pointer = ctypes.c_int64(given.size), given.ctypes.data_as(ctypes.c_void_p)
    found = {"step": min(c.whole(n, pointer) for _ in range(ROUNDS)) / given.size}
    for key, inverts in (("worst", 0), ("inverse", 1)):
        if inverts and damper.limits is None:
            continue
        times = np.full(given.size, 2**31 - 1, np.int32)
        for _ in range(ROUNDS):
            c.each(n, pointer, wanted.ctypes.data_as(ctypes.c_void_p), inverts, times.ctypes.data_as(ctypes.c_void_p))
        found[key] = float(times.mean() if inverts else times.max())
        if inverts:
            found["inverse_worst"] = float(times.max())
    object_file = folder / "size.o"
    subprocess.run(
        [find_compiler(), "-std=c99", "-Os", "-c", folder / f"{damper.name}.c", "-o", object_file], check=True
    )
    sizes = (
        subprocess.run(["size", object_file], capture_output=True, text=True, check=True).stdout.split("\n")[1].split()
    )
    return {**found, "code": float(sizes[0])}


def main() -> None:
    """Prints a row per model."""
    if find_compiler() is None:
        sys.exit("no C compiler is installed")
    seconds = int(sys.argv[1]) if len(sys.argv) > 1 else SECONDS
    x = road(seconds)
    stamp = np.arange(x.size, dtype=np.int64) * (10**9 // RATE)
    given = inputs(stamp, x, command=1.0 + np.sin(stamp * 3e-9))
    wanted = 800.0 * np.sin(stamp * 7e-9)
    for name, limits in MODELS:
        damper, _ = damper_of(load_model(name), Choices(name="damper", limits=limits))
        damper = replace(damper, limits=limits)
        with tempfile.TemporaryDirectory() as folder:
            found = measure(damper, given, wanted, Path(folder))
            ram = CompiledDamper(damper, Path(folder)).made.ram
        print(
            f"{name:22s} step {found['step']:6.0f} ns, worst {found['worst'] / 1000.0:6.1f} us"
            + (
                f"; inverse {found['inverse']:6.0f} ns, worst {found['inverse_worst'] / 1000.0:6.1f} us"
                if limits
                else ""
            )
            + f"; code {found['code'] / 1024.0:.1f} KiB, state {ram} bytes",
            flush=True,
        )


if __name__ == "__main__":
    main()
