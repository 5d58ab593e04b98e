"""Every callback of the page, called with names that lead out of the folder: nothing outside is opened or written.

An audit hook sees every file and directory that this process opens, in whatever thread.
"""

import json
import os
import socket
import sys
from pathlib import Path

import pytest

from damper_estimator.studio.folder import Folder
from damper_estimator.studio.guard import ServerAddress
from damper_estimator.studio.server import application
from damper_estimator.studio.sessions import Sessions

OWN = {"Host": "127.0.0.1:8050", "Origin": "http://127.0.0.1:8050"}
SECRET = "name: secret\neffects:\n- coulomb: {force: 77.0}\n"
_seen: list[str] = []
_watched: list[str] = []


def _watch(event: str, arguments: tuple) -> None:
    watched = _watched[:1]  # the studio's threads go on while a test ends
    if watched and event in (
        "open",
        "os.listdir",
        "os.scandir",
        "os.mkdir",
        "os.rename",
        "os.remove",
        "sqlite3.connect",
    ):
        names = [os.fsdecode(path) for path in arguments if isinstance(path, str | bytes | os.PathLike)]
        _seen.extend(name for name in names if any(watched[0] in place for place in (name, os.path.realpath(name))))


sys.addaudithook(_watch)


@pytest.fixture
def outside(folder, tmp_path_factory):
    """A folder next to the studio's, with files of every kind that it reads; pipes, devices and links lead there."""
    place = tmp_path_factory.mktemp("elsewhere")
    for name in ("secret.yaml", "secret", "metadata.yaml"):
        (place / name).write_text(SECRET)
    (place / "secret.mcap").write_bytes((folder / "hidden_fit.mcap").read_bytes())
    for suffix in (".yaml", ".mcap", ".csv", ".c", ""):
        (folder / f"link{suffix}").symlink_to(place / f"secret{suffix}")
        os.mkfifo(folder / f"pipe{suffix}")
    (folder / "null.yaml").symlink_to("/dev/zero")
    (folder / "way").symlink_to(place)
    (folder / "round").symlink_to("round")
    (folder / "bag").mkdir()
    (folder / "bag" / "metadata.yaml").write_text("rosbag2_bagfile_information: {relative_file_paths: [pipe.mcap]}\n")
    os.mkfifo(folder / "bag" / "pipe.mcap")
    opened = socket.socket(socket.AF_UNIX)
    here = Path.cwd()
    os.chdir(folder)  # the name of a socket is short
    opened.bind("socket.yaml")
    os.chdir(here)
    _watched[:], _seen[:] = [str(place)], []
    yield place
    _watched.clear()
    opened.close()


def hostile(place: Path) -> list[str]:
    """Names that a page may never reach something by."""
    files = ["secret.yaml", "secret", "secret.mcap", "new.yaml", ""]
    absolute = [str(place / name) for name in files]
    up = [f"../{place.name}/{name}" for name in files] + [f"bag/../../{place.name}/{name}" for name in files]
    links = [f"link{suffix}" for suffix in (".yaml", ".mcap", ".csv", ".c", "")] + [f"way/{name}" for name in files]
    odd = ["pipe.yaml", "pipe.mcap", "pipe.csv", "pipe", "null.yaml", "socket.yaml", "round", "bag", "bag/pipe.mcap"]
    devices = [
        "/dev/zero",
        "/dev/stdin",
        "/proc/self/environ",
        "~/.ssh/id_rsa",
        "file:///etc/passwd",
        "a\0b",
        "x" * 5000,
    ]
    return [*absolute, *up, *links, *odd, *devices]


def request_of(spec: dict, page: str, name: object) -> dict:
    """A request of one callback in which every value that the page chooses is a name."""

    def value(item: dict) -> object:
        if item["property"] == "n_clicks":
            return 3
        known = {"page": page, "theme": "light", "kind": "model", "tool": "zoom", "mode": "kept"}
        if item["id"] in known:
            return known[item["id"]]
        if item["id"] == "address":
            return {"query": f"?session={name}&recording={name}&model={name}&map={name}&damper={name}", "tab": name}
        return [name] if item["id"] in ("recordings", "unseen", "models") else name

    def filled(item: dict) -> object:
        if not item["id"].startswith("{"):
            return {"id": item["id"], "property": item["property"], "value": value(item)}
        one = {key: name if isinstance(v, list) else v for key, v in json.loads(item["id"]).items()}
        return [{"id": one, "property": item["property"], "value": 3 if item["property"] == "n_clicks" else name}]

    inputs, state = ([filled(item) for item in spec[kind]] for kind in ("inputs", "state"))
    first = next((item for item in spec["inputs"] if item["property"] == "n_clicks"), spec["inputs"][0])
    output = spec["output"]
    parts = output.strip(".").split("...") if output.startswith("..") else [output]
    outputs = [_output(part) for part in parts]
    return {
        "output": output,
        "outputs": outputs if output.startswith("..") else outputs[0],
        "inputs": inputs,
        "state": state,
        "changedPropIds": [f"{first['id']}.{first['property']}"],
    }


def _output(part: str) -> object:
    name, _, prop = part.rpartition(".")
    if not name.startswith("{"):
        return {"id": name, "property": prop}
    return [{"id": json.loads(name.replace('["ALL"]', '"x"')), "property": prop}]


def ended(sessions: Sessions, page: str) -> None:
    """Waits until no work runs for a page, or for one that the request made, and lets them go."""
    for name, (session, _) in list(sessions._open.items()):
        if session.job is not None:
            session.job.wait(20.0)
            assert session.job.state == "failed" and "should not have happened" not in session.job.error
        sessions.leave(name)
    assert page not in sessions._open


def test_no_callback_reaches_anything_outside(folder, outside):
    app, sessions = application(Folder(folder), ServerAddress("127.0.0.1", 8050))
    client = app.server.test_client()
    specs = client.get("/_dash-dependencies", headers=OWN).json
    served = [spec for spec in specs if not spec["clientside_function"]]
    assert len(served) > 20
    before = {path: path.read_bytes() for path in outside.iterdir()}
    _seen.clear()
    answered = set()
    for spec in served:
        for name in hostile(outside):
            page = sessions.new()
            body = json.dumps(request_of(spec, page, name))
            answer = client.post("/_dash-update-component", data=body, headers=OWN, content_type="application/json")
            answered.add(answer.status_code)
            assert b"77.0" not in answer.data
            ended(sessions, page)
    assert not _seen
    assert {path: path.read_bytes() for path in outside.iterdir()} == before
    assert {200, 204} & answered
    sessions.close()


def test_no_session_of_a_callback_with_a_name_that_is_no_text(folder, outside):
    app, sessions = application(Folder(folder), ServerAddress("127.0.0.1", 8050))
    client = app.server.test_client()
    served = [s for s in client.get("/_dash-dependencies", headers=OWN).json if not s["clientside_function"]]
    for spec in served:
        for name in (None, 3, {"a": 1}, [str(outside / "secret.yaml")], True):
            page = sessions.new()
            body = json.dumps(request_of(spec, page, name))
            client.post("/_dash-update-component", data=body, headers=OWN, content_type="application/json")
            ended(sessions, page)
    assert not _seen
    sessions.close()


def test_the_listing_does_not_look_at_what_leads_out(folder, outside):
    opened = Folder(folder)
    assert opened.models() == ["before.yaml"] and opened.maps() == []
    assert opened.recordings() == ["bag", "hidden_fit.mcap", "hidden_unseen.mcap"]
    assert not _seen
