"""The translator: the same numbers for every accepted function, otherwise a refusal that names the fault."""

import ctypes
import math

import numpy as np
import pytest

from damper_estimator.codegen import support
from damper_estimator.codegen.build import build_library, find_compiler
from damper_estimator.codegen.translator import Translator
from damper_estimator.codegen.values import LONG, REAL, Array, Number, Untranslatable, whole

needs_compiler = pytest.mark.skipif(find_compiler() is None, reason="no C compiler is installed")
SPECIAL = (0.0, -0.0, 1.0, -1.0, 2.5, -7.25, 1e-300, 1e300, math.inf, -math.inf, math.nan)


def chooses(a, b):
    nan = b != b
    return min(a, b) + 2.0 * max(b, a) if not a < b <= 3.0 or nan else abs(a) ** 2 - a


def signs(a, b):
    side = b if a > 0.0 else -b if a < 0.0 else 0.0
    low, high = (a, b) if a < b else (b, a)
    low, high = high, low
    return side + low - 3.0 * high


def loops(a, b):
    total, count = 0.0, 0
    for i in range(2, 9):
        if i == 7:
            break
        if i % 3 == 1:
            continue
        total += i / 4 * a
        count += 1
    while count > -5:
        count -= 2
        total -= count // 2 + (count - 1) % 3
    return total * b


def rounds(a, b):
    part = int(a)
    return float(part % 7) + part // 3 + b


def repeats(a, b):
    turn = 0.5 * a
    for _ in range(3):
        turn += b * turn
    return turn


FUNCTIONS = (chooses, signs, loops, rounds, repeats)


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    folder = tmp_path_factory.mktemp("c")
    translator = Translator()
    made = [translator.function(f, [Number(REAL, "a"), Number(REAL, "b")]) for f in FUNCTIONS]
    body = translator.source(made).replace("static double test_translator_", "double call_")
    whole_part = "static int64_t whole_part(double x) { return x > -9e18 && x < 9e18 ? (int64_t)x : INT64_MIN; }\n"
    declared = "".join(f"double call_{f.__name__}(double a, double b);\n" for f in FUNCTIONS)
    includes = "#include <math.h>\n#include <stdbool.h>\n#include <stdint.h>\n"
    (folder / "f.c").write_text(includes + declared + whole_part + body)
    build_library([folder / "f.c"], folder / "f.so")
    return ctypes.CDLL(str(folder / "f.so"))


@needs_compiler
@pytest.mark.parametrize("function", FUNCTIONS, ids=lambda f: f.__name__)
def test_numbers_are_those_of_python_special_ones_included(library, function):
    called = getattr(library, f"call_{function.__name__}")
    called.restype, called.argtypes = ctypes.c_double, [ctypes.c_double] * 2
    for a in SPECIAL:
        for b in SPECIAL:
            if function is rounds and not abs(a) < 1e18:
                continue  # Python has no whole part of these
            with np.errstate(all="ignore"):
                expected = float(function(np.float64(a), np.float64(b)))
            found = called(a, b)
            assert math.isnan(expected) == math.isnan(found)
            assert math.isnan(expected) or (found == expected and math.copysign(1, found) == math.copysign(1, expected))


@pytest.mark.parametrize("value", [*np.linspace(-2.0, 4.0, 61), math.nan, math.inf, -math.inf])
def test_interpolation_and_search_are_numpys(value):
    knots, values = np.array([-1.0, 0.0, 0.5, 2.0, 3.0]), np.array([5.0, -1.0, 0.0, 4.0, 4.5])
    assert np.array_equal(support.interpolated(value, knots, values), np.interp(value, knots, values), equal_nan=True)
    assert support.place_right(knots, value) == np.searchsorted(knots, value, side="right")


def test_integers_are_divided_as_python_divides_them():
    for number in range(-9, 10):
        assert support.floor_rest(number, 4) == number % 4
        assert support.floor_divided(number, 4) == number // 4


def uses_a_list(a, b):
    return [a, b][0]


def allocates(a, b):
    c = np.empty(int(a))
    c[0] = b
    return c[0]


def calls_itself(a, b):
    return calls_itself(b, a)


def calls_the_unknown(a, b):
    return np.linalg.norm(a) + b


@pytest.mark.parametrize(
    "function", [uses_a_list, allocates, calls_itself, calls_the_unknown], ids=lambda f: f.__name__
)
def test_constructs_without_counterpart_are_refused_by_name(function):
    with pytest.raises(Untranslatable, match=function.__name__):
        Translator().function(function, [Number(REAL, "a"), Number(REAL, "b")])


def reads(values, i):
    rest = values[1:]
    return rest[0] + i


def writes(values, i):
    rest = values[1:]
    rest[0] = 2.0 * i


def hands_over(values, i):
    writes(values, i)


@pytest.mark.parametrize(("function", "const"), [(reads, True), (writes, False), (hands_over, False)])
def test_arrays_that_are_only_read_are_const(function, const):
    values = Array(REAL, "values", whole(0), ("n",), frozenset())
    made = Translator().function(function, [values, Number(LONG, "i")])
    assert ("const double *values" in made.text.split("{")[0]) == const
