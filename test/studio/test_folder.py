"""Nothing outside of the studio's folder is reached, and nothing in it is replaced unasked."""

import os

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from damper_estimator.errors import InputError
from damper_estimator.studio.folder import LARGEST_YAML, Folder, Taken


@pytest.fixture
def outside(tmp_path):
    """The studio's folder next to a folder that does not belong to it."""
    (tmp_path / "own" / "below").mkdir(parents=True)
    (tmp_path / "secret.yaml").write_text("effects:\n- coulomb\n")
    return tmp_path / "own"


@pytest.mark.parametrize("name", ["../secret.yaml", "below/../../secret.yaml", "/etc/passwd", "", "a\0b", ".."])
def test_a_name_that_leads_out_is_refused(outside, name):
    with pytest.raises(InputError, match="is not a name in the studio's folder"):
        Folder(outside).path(name)


def test_a_symbolic_link_out_of_the_folder_is_refused(outside):
    (outside / "link.yaml").symlink_to(outside.parent / "secret.yaml")
    (outside / "way").symlink_to(outside.parent)
    for name in ("link.yaml", "way/secret.yaml", "way"):
        with pytest.raises(InputError, match="leads out of the studio's folder"):
            Folder(outside).path(name)


def test_a_recording_whose_files_are_links_out_of_the_folder_is_refused(outside):
    (outside / "below" / "metadata.yaml").write_text("rosbag2_bagfile_information: {}\n")
    (outside / "below" / "part.mcap").symlink_to(outside.parent / "secret.yaml")
    with pytest.raises(InputError, match="leads out"):
        Folder(outside).existing("below")


@settings(deadline=None)
@given(parts=st.lists(st.sampled_from(["..", ".", "below", "a", "/", "//", "~", "link"]), min_size=1, max_size=8))
def test_no_name_ever_leads_out(tmp_path_factory, parts):
    root = tmp_path_factory.getbasetemp() / "root"
    (root / "below").mkdir(parents=True, exist_ok=True)
    if not (root / "link").is_symlink():
        (root / "link").symlink_to("/")
    try:
        found = Folder(root).path("/".join(parts))
    except InputError:
        return
    assert found.is_relative_to(root.resolve())


def test_what_is_there_is_listed_by_kind(folder):
    (folder / "map.yaml").write_text("filter: {cutoff: 50.0}\n")
    (folder / "notes.yaml").write_text("a: b\n")
    (folder / ".hidden.mcap").write_bytes(b"")
    (folder / "deep").mkdir()
    os.link(folder / "before.yaml", folder / "deep" / "other.yaml")
    opened = Folder(folder)
    assert opened.recordings() == ["hidden_fit.mcap", "hidden_unseen.mcap"]
    assert opened.models() == ["before.yaml", "deep/other.yaml"]
    assert opened.maps() == ["map.yaml"]


def test_a_file_is_replaced_only_when_asked(outside):
    opened = Folder(outside)
    assert opened.target("new/model.yaml", ".yaml", replace=False).parent.is_dir()
    (outside / "old.yaml").write_text("")
    with pytest.raises(Taken, match="exists already"):
        opened.target("old.yaml", ".yaml", replace=False)
    assert opened.target("old.yaml", ".yaml", replace=True) == outside / "old.yaml"


@pytest.mark.parametrize("name", ["model.txt", "below", "../out.yaml", ".yaml", "/tmp/out.yaml"])
def test_nothing_is_written_elsewhere_or_under_a_wrong_name(outside, name):
    with pytest.raises(InputError):
        Folder(outside).target(name, ".yaml", replace=True)


def test_a_yaml_file_too_large_for_a_model_is_not_read(outside):
    (outside / "huge.yaml").write_text("effects: []\n" + "#" * LARGEST_YAML)
    assert Folder(outside).models() == []
    with pytest.raises(InputError, match="larger than 1 MB"):
        Folder(outside).existing("huge.yaml")


def test_a_missing_folder_is_reported(tmp_path):
    with pytest.raises(InputError, match="is no folder"):
        Folder(tmp_path / "nowhere")
