"""Requests that do not come from the studio's own page are refused."""

import json
import subprocess
import sys

import pytest

from damper_estimator.studio.folder import Folder
from damper_estimator.studio.guard import LARGEST_REQUEST, Door, is_loopback, new_token
from damper_estimator.studio.server import application

OWN = {"Host": "127.0.0.1:8050", "Origin": "http://127.0.0.1:8050"}


def client_of(folder, door):
    app, sessions = application(Folder(folder), door)
    return app.server.test_client(use_cookies=True), sessions


@pytest.fixture
def client(tmp_path):
    own, sessions = client_of(tmp_path, Door("127.0.0.1", 8050))
    yield own
    sessions.close()


def test_the_page_and_its_parts_come_from_the_studio_itself(client):
    page = client.get("/", headers={"Host": OWN["Host"]})
    assert page.status_code == 200
    assert b"http://" not in page.data.replace(b"http://www.w3.org", b"") and b"https://" not in page.data
    policy = page.headers["Content-Security-Policy"]
    assert "default-src 'self'" in policy and "unsafe-eval" not in policy
    assert "'unsafe-inline'" not in policy.split("script-src")[1].split(";")[0]
    assert page.headers["X-Content-Type-Options"] == "nosniff"


@pytest.mark.parametrize("host", ["evil.example:8050", "127.0.0.1:8051", "127.0.0.1", "", "192.168.1.2:8050"])
def test_another_host_is_refused(client, host):
    assert client.get("/", headers={"Host": host}).status_code == 403


@pytest.mark.parametrize("host", ["127.0.0.1:8050", "localhost:8050", "[::1]:8050"])
def test_names_of_this_machine_are_let_in(client, host):
    assert client.get("/", headers={"Host": host}).status_code == 200


@pytest.mark.parametrize(
    "origin", ["http://evil.example", "null", "http://127.0.0.1:9", "https://127.0.0.1:8050", None]
)
def test_a_change_from_another_origin_is_refused(client, origin):
    headers = {"Host": OWN["Host"]} | ({"Origin": origin} if origin else {})
    for path in ("/leave", "/_dash-update-component"):
        assert client.post(path, data="{}", headers=headers).status_code == 403
    if origin:
        assert client.get("/_dash-layout", headers=headers).status_code == 403


def test_a_large_request_is_refused(client):
    assert client.post("/leave", data=b"x" * (LARGEST_REQUEST + 1), headers=OWN).status_code == 413
    assert client.post("/leave", data=b"x" * 100, headers=OWN).status_code == 204
    endless = {"wsgi.input_terminated": True, "HTTP_TRANSFER_ENCODING": "chunked"}
    assert client.post("/leave", headers=OWN, environ_overrides=endless).status_code == 411


@pytest.mark.parametrize(
    "path", ["/assets/../server.py", "/assets/%2e%2e/server.py", "/etc/passwd", "/assets//etc/passwd"]
)
def test_no_file_of_the_machine_is_served(client, tmp_path, path):
    (tmp_path / "drive.mcap").write_bytes(b"recording")
    answer = client.get(path, headers={"Host": OWN["Host"]})
    assert b"root:" not in answer.data and b"def application" not in answer.data
    assert b"recording" not in client.get("/drive.mcap", headers={"Host": OWN["Host"]}).data


def test_with_a_token_nothing_is_told_without_it(tmp_path):
    token = new_token()
    door = Door("0.0.0.0", 8050, token)
    client, sessions = client_of(tmp_path, door)
    host = {"Host": "192.168.1.2:8050"}
    for path in ("/", "/_dash-layout", "/assets/studio.js", "/?token=wrong", "/_dash-layout?token=" + token):
        assert client.get(path, headers=host).status_code == 403
    assert client.post("/leave", data="x", headers=host | {"Origin": "http://192.168.1.2:8050"}).status_code == 403
    entered = client.get(f"/?token={token}", headers=host)
    cookie = entered.headers["Set-Cookie"]
    assert entered.status_code == 302 and entered.location == "/"
    assert cookie.startswith(door.cookie) and "HttpOnly" in cookie and "SameSite=Strict" in cookie
    client.set_cookie(door.cookie, token, domain="192.168.1.2")
    assert client.get("/", headers=host).status_code == 200
    assert client.get("/", headers={"Host": "evil.example:8050"}).status_code == 403
    sessions.close()


def test_loopback_is_known():
    assert all(is_loopback(host) for host in ("127.0.0.1", "127.1.2.3", "::1", "localhost"))
    assert not any(is_loopback(host) for host in ("0.0.0.0", "::", "192.168.1.2", "example.org"))


@pytest.mark.parametrize("words", [["--host", "0.0.0.0"], ["--host", "192.168.1.2"]])
def test_others_are_let_in_only_with_a_token(tmp_path, words):
    command = [sys.executable, "-m", "damper_estimator", "studio", str(tmp_path), "--no-browser", *words]
    done = subprocess.run(command, capture_output=True, text=True)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (1, "", 1)
    assert "add --token" in done.stderr


def test_a_missing_library_is_told_in_one_line(tmp_path):
    code = (
        "import sys; sys.modules['dash'] = None\nfrom damper_estimator.cli.main import main\n"
        f"sys.exit(main(['studio', {str(tmp_path)!r}, '--no-browser']))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert (done.returncode, done.stderr.count("\n")) == (1, 1)
    assert "pip install 'damper_estimator[studio]'" in done.stderr


def test_a_page_that_nobody_opened_is_told_to_load_again(client):
    body = {
        "output": "..recording.options..", "outputs": [], "inputs": [], "changedPropIds": [], "state": [],
    }  # fmt: skip
    answer = client.post("/_dash-update-component", data=json.dumps(body), headers=OWN, content_type="application/json")
    assert answer.status_code in (400, 500)
    assert client.get("/", headers={"Host": OWN["Host"]}).status_code == 200
