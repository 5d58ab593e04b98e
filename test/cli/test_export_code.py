"""The verb export: C and FMUs."""

import json
import shutil
import subprocess

import pytest

from damper_estimator.cli.main import main
from damper_estimator.codegen.build import find_compiler

needs_compiler = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")


def test_c_is_written_with_the_requested_name(tmp_path, capsys):
    words = [
        "export",
        "carrera_akutain",
        "--c",
        str(tmp_path / "out"),
        "--name",
        "front_left",
        "--json",
        str(tmp_path / "j"),
    ]
    assert main(words) == 0
    header = (tmp_path / "out" / "front_left.h").read_text()
    assert "int32_t front_left_step(" in header and "model carrera_akutain" in header and "SHA-256" in header
    assert "no inverse" in capsys.readouterr().out
    assert json.loads((tmp_path / "j").read_text())["state_bytes"] > 0


def test_a_damper_of_a_map_determines_filter_and_limits(tmp_path):
    path = tmp_path / "map.yaml"
    path.write_text(
        "filter: {cutoff: 33.0}\ndampers:\n  a:\n    displacement: {topic: /x, field: a}\n"
        "    command: {limits: [0.1, 1.7]}\n"
        "  b:\n    displacement: {topic: /x, field: b}\n"
    )
    words = ["export", "semi_active_yield", "--c", str(tmp_path), "--name", "a", "-s", str(path)]
    assert main([*words, "-d", "a"]) == 0
    header = (tmp_path / "a.h").read_text()
    assert "33 Hz" in header and "command from 0.1 to 1.7" in header
    assert main(words) == 1  # ambiguous damper


@pytest.mark.parametrize(
    ("words", "part"),
    [
        ([], "--c DIR"),
        (["--c", "x", "--name", "2nd"], "is not a C name"),
        (["--c", "x", "--limits", "1,0"], "are not a range"),
        (["--fmu", "missing/x.fmu", "--source-only"], "missing/x.fmu: cannot be written"),
    ],
)
def test_faults_are_reported_in_one_line(words, part, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["export", "semi_active_yield", *words]) == 1
    error = capsys.readouterr().err
    assert part in error and error.count("\n") == 1


def test_effects_of_the_measurement_chain_are_refused_by_name(tmp_path, capsys):
    path = tmp_path / "m.yaml"
    path.write_text("name: m\nsource: test\neffects:\n  - linear_viscous\n  - force_offset: {offset: 5.0}\n")
    assert main(["export", str(path), "--c", str(tmp_path)]) == 1
    assert "force_offset" in capsys.readouterr().err


@needs_compiler
def test_single_precision_reports_its_error(tmp_path, capsys):
    assert main(["export", "carrera_akutain", "--c", str(tmp_path), "--float", "--name", "a"]) == 0
    assert "single precision: the force differs by up to" in capsys.readouterr().out
    assert "double" not in (tmp_path / "a.c").read_text().split("#include", 1)[1]


def test_without_a_compiler_c_is_still_written(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("damper_estimator.codegen.c_files.find_compiler", lambda: None)
    assert main(["export", "carrera_akutain", "--c", str(tmp_path), "--float", "--name", "a"]) == 0
    assert (tmp_path / "a.c").exists() and "was not measured" in capsys.readouterr().out


@needs_compiler
def test_an_fmu_is_written_with_its_binary(tmp_path, capsys):
    assert main(["export", "renault_modified_bouc_wen", "--fmu", str(tmp_path / "a.fmu"), "--fmi", "3.0"]) == 0
    output = capsys.readouterr().out
    assert "sources and binary" in output and "not tunable" in output and "renault_hysteresis.alpha" in output


@pytest.mark.skipif(find_compiler() is None or shutil.which("g++") is None, reason="no C and C++ compilers")
def test_a_controller_in_cpp_links_it(tmp_path):
    assert main(["export", "carrera_akutain", "--c", str(tmp_path), "--name", "a"]) == 0
    (tmp_path / "main.cpp").write_text(
        '#include "a.h"\nint main() { a_state s; a_init(&s); return a_status_at(&s, 0) != A_STALE; }\n'
    )
    subprocess.run([find_compiler(), "-std=c99", "-c", "a.c"], cwd=tmp_path, check=True)
    subprocess.run(
        ["g++", "-Wall", "-Wextra", "-Werror", "main.cpp", "a.o", "-lm", "-o", "main"], cwd=tmp_path, check=True
    )
    subprocess.run([tmp_path / "main"], check=True)


@needs_compiler
def test_two_dampers_live_in_one_program(tmp_path):
    for name in ("front_left", "rear_left"):
        assert main(["export", "dahl", "--c", str(tmp_path), "--name", name]) == 0
    (tmp_path / "main.c").write_text(
        '#include "front_left.h"\n#include "rear_left.h"\n'
        "int main(void) { front_left_state a; rear_left_state b; front_left_init(&a); rear_left_init(&b); return 0; }\n"
    )
    sources = [str(tmp_path / f"{name}.c") for name in ("front_left", "rear_left", "main")]
    done = subprocess.run([find_compiler(), "-std=c99", *sources, "-lm", "-o", str(tmp_path / "two")], check=False)
    assert done.returncode == 0 and subprocess.run([tmp_path / "two"], check=False).returncode == 0


@pytest.mark.parametrize(
    ("option", "value"),
    [("--cutoff", "-3"), ("--cutoff", "nan"), ("--stale-after", "0"), ("--stale-after", "nan"), ("--lead", "-1"),
     ("--lead", "inf")],
)  # fmt: skip
def test_numbers_that_no_controller_can_use_are_refused(option, value, tmp_path, capsys):
    with pytest.raises(SystemExit) as stopped:
        main(["export", "carrera_akutain", "--c", str(tmp_path / "out"), option, value])
    assert stopped.value.code == 2 and not (tmp_path / "out").exists()
    last = capsys.readouterr().err.strip().splitlines()[-1]
    assert f"argument {option}: '{value}' is not a finite number" in last


def test_no_filter_and_no_lead_are_allowed(tmp_path):
    assert main(["export", "carrera_akutain", "--c", str(tmp_path), "--cutoff", "0", "--lead", "0"]) == 0
