"""What the Save panel writes: what it says of it, exports for controllers and simulation, and nothing over a file."""

import zipfile

import pytest

from damper_estimator.codegen import find_compiler
from damper_estimator.errors import InputError
from damper_estimator.studio.folder import Taken
from damper_estimator.studio.saving import save


def test_a_saved_model_names_its_step_and_error(session, folder):
    session.set(session.model.slots[0].address, -950.0)
    said = save(session, "model", "mine.yaml", replace=False)
    assert said.startswith("step 1: ") and f"{session.history.now.step.rmse_unseen_n:.3g} N unseen" in said
    assert session.saved_as(session.history.now) == "mine.yaml" and "mine.yaml" in session.folder.models()


def test_c_is_written_as_the_command_line_writes_it(session, folder):
    said = save(session, "c", "front_left.c", replace=False)
    assert "front_left.h" in said and "no inverse" in said and "step 0" in said
    session.model.to_c(folder / "again", name="front_left", signals=session.here.signal_map, damper="passenger_front")
    for name in ("front_left.h", "front_left.c"):
        assert (folder / name).read_text() == (folder / "again" / name).read_text()


def test_neither_file_of_an_export_is_replaced_without_asking(session, folder):
    (folder / "front_left.h").write_text("mine")
    with pytest.raises(Taken, match=r"front_left\.h: exists already"):
        save(session, "c", "front_left.c", replace=False)
    assert (folder / "front_left.h").read_text() == "mine" and not (folder / "front_left.c").exists()
    save(session, "c", "front_left.c", replace=True)
    assert "front_left_step" in (folder / "front_left.h").read_text()


def test_a_name_that_c_does_not_take_is_refused(session):
    with pytest.raises(InputError, match="is not a C name"):
        save(session, "c", "front-left.c", replace=False)


@pytest.mark.skipif(find_compiler() is None, reason="there is no C compiler")
@pytest.mark.parametrize(("kind", "version"), [("fmu2", "2.0"), ("fmu3", "3.0")])
def test_an_fmu_has_sources_and_a_binary(session, folder, kind, version):
    said = save(session, kind, "damper.fmu", replace=False)
    assert f"FMI {version}" in said and "binary for this platform" in said
    names = zipfile.ZipFile(folder / "damper.fmu").namelist()
    assert any(name.startswith("binaries/") for name in names) and "sources/damper.c" in names


def test_without_a_compiler_an_fmu_has_sources_only_and_says_why(session, folder, monkeypatch):
    monkeypatch.setattr("damper_estimator.studio.saving.find_compiler", lambda: None)
    said = save(session, "fmu2", "damper.fmu", replace=False)
    assert "sources only: a binary needs a C compiler" in said
    assert not any(name.startswith("binaries/") for name in zipfile.ZipFile(folder / "damper.fmu").namelist())


def test_a_kind_that_does_not_exist_is_refused(session):
    with pytest.raises(InputError, match="choose what to save"):
        save(session, "secrets", "x.yaml", replace=False)
