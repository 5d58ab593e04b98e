"""Files that are dropped on the page: what is taken, what is refused, and that nothing is replaced or left half."""

import io
import os
import shutil
import zipfile
from pathlib import Path

import pytest

from damper_estimator.errors import InputError
from damper_estimator.studio import bench_form
from damper_estimator.studio.folder import Folder, Taken
from damper_estimator.studio.guard import UPLOAD, ServerAddress
from damper_estimator.studio.server import application
from damper_estimator.studio.uploads import receive

OWN = {"Host": "127.0.0.1:8050", "Origin": "http://127.0.0.1:8050"}


def sent(folder: Path, name: str, content: bytes, length: int | None = None) -> str:
    return receive(Folder(folder), name, io.BytesIO(content), len(content) if length is None else length)


def zipped(**members: bytes) -> bytes:
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in members.items():
            archive.writestr(name, content)
    return packed.getvalue()


def files(folder: Path) -> set[str]:
    return {str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file()}


def test_a_recording_is_taken_and_listed(folder):
    content = (folder / "hidden_fit.mcap").read_bytes()
    assert sent(folder, "run 7.mcap", content) == "run 7.mcap"
    assert (folder / "run 7.mcap").read_bytes() == content and "run 7.mcap" in Folder(folder).recordings()


def test_a_zipped_rosbag2_folder_is_unpacked(tmp_path):
    packed = zipped(**{"deep/bag/metadata.yaml": b"a: 1", "deep/bag/bag_0.mcap": b"x" * 5000, "deep/read.me": b"no"})
    assert sent(tmp_path, "drive.zip", packed) == "drive"
    assert files(tmp_path) == {"drive/metadata.yaml", "drive/bag_0.mcap"}
    with pytest.raises(Taken, match="drive exists already"):
        sent(tmp_path, "drive.zip", packed)


@pytest.mark.parametrize(
    "members",
    [
        {"../../evil.mcap": b"x", "../../metadata.yaml": b""},
        {"/tmp/evil.mcap": b"x", "/tmp/metadata.yaml": b""},
        {"a.mcap": b"x"},
        {"a/metadata.yaml": b"", "b/metadata.yaml": b""},
        {f"{i}.mcap": b"" for i in range(1200)} | {"metadata.yaml": b""},
    ],
)
def test_a_hostile_archive_writes_nothing_outside(tmp_path, members):
    (tmp_path / "own").mkdir()
    try:
        sent(tmp_path / "own", "bag.zip", zipped(**members))
    except InputError as error:
        assert "\n" not in str(error)
    assert all(name.startswith("own/bag/") for name in files(tmp_path))
    assert not Path("/tmp/evil.mcap").exists()


def test_an_archive_that_says_less_than_it_holds_or_does_not_fit_is_refused(tmp_path, monkeypatch):
    packed = zipped(**{"metadata.yaml": b"", "a.mcap": b"\0" * 10_000_000})
    real = shutil.disk_usage(tmp_path)
    monkeypatch.setattr(shutil, "disk_usage", lambda _: real._replace(free=500_000_000 + 100_000))
    with pytest.raises(InputError, match="does not fit on the disk"):
        sent(tmp_path, "bomb.zip", packed)
    with pytest.raises(InputError, match="do not fit on the disk"):
        sent(tmp_path, "big.mcap", b"x", 10**12)
    assert files(tmp_path) == set()


@pytest.mark.parametrize("content", [b"", b"PK\3\4 no archive", b"x" * 1000])
def test_a_damaged_archive_is_refused_in_one_line(tmp_path, content):
    with pytest.raises(InputError) as refused:
        sent(tmp_path, "bag.zip", content)
    assert "\n" not in str(refused.value) and files(tmp_path) == set()


@pytest.mark.parametrize(
    "name",
    [
        "../x.mcap",
        "/tmp/x.mcap",
        "a/../../x.mcap",
        "x.exe",
        "x",
        "",
        ".mcap",
        ".damper_studio/x.yaml",
        ".ssh/x.txt",
        "a\0.csv",
    ],
)
def test_hostile_names_are_refused(tmp_path, name):
    (tmp_path / "own").mkdir()
    with pytest.raises(InputError):
        sent(tmp_path / "own", name, b"x")
    assert files(tmp_path) == set()


def test_nothing_is_replaced_and_nothing_is_left_half(tmp_path):
    (tmp_path / "a.csv").write_bytes(b"mine")
    with pytest.raises(Taken):
        sent(tmp_path, "a.csv", b"yours")
    with pytest.raises(InputError, match="ended after 3 of 10 bytes"):
        sent(tmp_path, "b.csv", b"abc", 10)
    assert files(tmp_path) == {"a.csv"} and (tmp_path / "a.csv").read_bytes() == b"mine"


def test_a_file_is_not_written_through_a_link(tmp_path):
    (tmp_path / "own").mkdir()
    (tmp_path / "own" / "way").symlink_to(tmp_path)
    (tmp_path / "own" / "x.mcap").symlink_to(tmp_path / "y.mcap")
    for name in ("way/z.mcap", "x.mcap"):
        with pytest.raises(InputError):
            sent(tmp_path / "own", name, b"x")
    assert files(tmp_path) == set()


def test_the_server_accepts_files_from_its_own_pages_only(tmp_path):
    app, sessions = application(Folder(tmp_path), ServerAddress("127.0.0.1", 8050))
    client, page, content = app.server.test_client(), sessions.new(), os.urandom(3_000_000)

    def post(headers, name="a.mcap"):
        return client.post(f"{UPLOAD}?name={name}", data=content, headers=headers)

    assert post({"Host": OWN["Host"], "X-Studio-Page": page}).status_code == 403
    assert post(OWN | {"Origin": "http://evil.example", "X-Studio-Page": page}).status_code == 403
    assert post(OWN | {"Sec-Fetch-Site": "same-site", "X-Studio-Page": page}).status_code == 403
    assert post(OWN).status_code == 400 and post(OWN | {"X-Studio-Page": "x"}).status_code == 400
    assert files(tmp_path) == set()
    taken = post(OWN | {"X-Studio-Page": page})
    assert (taken.status_code, taken.text) == (200, "a.mcap") and (tmp_path / "a.mcap").read_bytes() == content
    assert post(OWN | {"X-Studio-Page": page}).status_code == 409
    assert post(OWN | {"X-Studio-Page": page}, "../b.mcap").status_code == 400
    sessions.close()


def test_the_form_corrects_a_guess_and_imports(tmp_path):
    import numpy as np

    t = np.arange(0.0, 3.0, 2e-3)
    x = 0.03 * np.sin(9.0 * t)
    f = 1500.0 * np.gradient(x, t) - 150.0
    rows = "\n".join(f"{a:.4f},{1e3 * b:.5f},{c:.3f}" for a, b, c in zip(t, x, f, strict=True))
    (tmp_path / "bare.csv").write_text(f"t,x,F\n{rows}\n")
    folder = Folder(tmp_path)
    guess = bench_form.guessed(folder, "bare.csv")
    assert guess.doubts and "To decide" in str(bench_form.form(guess))
    data = bench_form.kept(guess, "bare.csv")
    chosen = ["time in s", "damper displacement in mm", "damper force in N"]
    parts = bench_form.parts_of(folder, "bare.csv", bench_form.corrected(data, chosen, [[], [], []]))
    assert np.allclose(parts[0].dampers["damper"]["displacement"], x, atol=1e-7)
    turned = bench_form.parts_of(folder, "bare.csv", bench_form.corrected(data, chosen, [[], [], ["turn"]]))
    assert np.allclose(turned[0].dampers["damper"]["force"], -f, atol=1e-2)
    assert bench_form.imported(folder, parts) == ["bare.mcap"] and folder.recordings() == ["bare.mcap"]
    with pytest.raises(Taken):
        bench_form.imported(folder, parts)
    for wrong in (["left out"] * 3, [chosen[0], chosen[1], chosen[1]], ["nonsense"] * 3, [None] * 3, chosen[:2]):
        with pytest.raises(InputError):
            bench_form.parts_of(folder, "bare.csv", bench_form.corrected(data, wrong, [[]] * len(wrong)))
