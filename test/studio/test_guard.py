"""Requests that do not come from the studio's own page are refused."""

import json
import socket
import subprocess
import sys

import pytest

from damper_estimator.studio.folder import Folder
from damper_estimator.studio.guard import LARGEST_REQUEST, ServerAddress, is_loopback, new_token, usable_address
from damper_estimator.studio.server import application

OWN = {"Host": "127.0.0.1:8050", "Origin": "http://127.0.0.1:8050"}


def client_of(folder, address):
    app, sessions = application(Folder(folder), address)
    return app.server.test_client(use_cookies=True), sessions


@pytest.fixture
def client(tmp_path):
    client, sessions = client_of(tmp_path, ServerAddress("127.0.0.1", 8050))
    yield client
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


ARRIVE = {
    "output": "..page.data...open-message.children@x..",
    "outputs": [],
    "inputs": [{"id": "address", "property": "data", "value": {"query": "", "tab": "t"}}],
    "changedPropIds": ["address.data"],
    "state": [],
}
LINK = {"Sec-Fetch-Mode": "navigate", "Sec-Fetch-Dest": "document"}


def arrived(client, headers):
    """The answer to the request with which a page asks for its session."""
    specs = client.get("/_dash-dependencies", headers=headers).json
    found = next(
        item
        for item in specs or []
        if item["inputs"] == [{"id": "address", "property": "data"}] and "page" in item["output"]
    )
    parts = [part.rpartition(".") for part in found["output"].strip(".").split("...")]
    body = ARRIVE | {"output": found["output"], "outputs": [{"id": i, "property": p} for i, _, p in parts]}
    return client.post("/_dash-update-component", json=body, headers=headers)


def test_reading_the_page_makes_no_session_and_its_own_request_makes_one(tmp_path):
    client, sessions = client_of(tmp_path, ServerAddress("127.0.0.1", 8050))
    for path in ("/", "/_dash-layout", "/_dash-dependencies", "/?recording=a.mcap&model=dahl&session=abcdefgh"):
        for _ in range(20):
            assert client.get(path, headers={"Host": OWN["Host"]}).status_code == 200
    assert len(sessions) == 0
    assert arrived(client, OWN).status_code == 200 and len(sessions) == 1
    sessions.close()


@pytest.mark.parametrize("site", ["cross-site", "same-site", "anything"])
def test_other_sites_get_nothing_and_create_nothing(tmp_path, site):
    client, sessions = client_of(tmp_path, ServerAddress("127.0.0.1", 8050))
    headers = OWN | {"Sec-Fetch-Site": site}
    for path in ("/_dash-layout", "/_dash-dependencies", "/assets/studio.js", "/"):
        for kind in ({}, {"Sec-Fetch-Mode": "no-cors", "Sec-Fetch-Dest": "image"}, LINK | {"Sec-Fetch-Dest": "iframe"}):
            assert client.get(path, headers=headers | kind).status_code == 403
    for path in ("/_dash-update-component", "/leave", "/"):
        assert client.post(path, data="{}", headers=headers | LINK).status_code == 403
    followed = client.get("/?recording=a.mcap", headers={"Host": OWN["Host"], "Sec-Fetch-Site": site} | LINK)
    assert followed.status_code == 200 and b'http-equiv="refresh"' in followed.data and b"script" not in followed.data
    assert len(sessions) == 0
    sessions.close()


def test_the_token_comes_before_a_session(tmp_path):
    token = new_token()
    client, sessions = client_of(tmp_path, ServerAddress("127.0.0.1", 8050, token))
    assert client.post("/_dash-update-component", json=ARRIVE, headers=OWN).status_code == 403
    for wrong in ("", "x" * len(token), token[:-1], token + "x"):
        client.set_cookie("damper_studio_8050", wrong, domain="127.0.0.1")
        assert client.post("/_dash-update-component", json=ARRIVE, headers=OWN).status_code == 403
    assert len(sessions) == 0
    entered = client.get(f"/?token={token}&session=abcdefgh&recording=a+b.mcap", headers={"Host": OWN["Host"]})
    assert entered.location == "/?session=abcdefgh&recording=a+b.mcap"
    sessions.close()


def test_names_that_are_allowed_are_let_in_and_no_others(tmp_path):
    address = ServerAddress("0.0.0.0", 8050, new_token(), ("rig.local", "Bench"))
    assert all(address.knows(host) for host in ("rig.local:8050", "RIG.local:8050", "bench:8050", "10.0.0.2:8050"))
    assert not any(
        address.knows(host) for host in ("rig.local", "rig.local:80", "evil.example:8050", "rig.local.evil:8050")
    )
    assert address.url.startswith("http://rig.local:8050/?token=")


def test_the_address_that_is_printed_can_be_opened():
    assert usable_address("192.168.1.2") == "192.168.1.2" and usable_address("rig.local") == "rig.local"
    for host in ("0.0.0.0", "::"):
        assert usable_address(host) not in ("0.0.0.0", "::", "")
    assert "0.0.0.0" not in ServerAddress("0.0.0.0", 8050, "t").url


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--host", "192.0.2.77", "--token"], "choose an address of this machine"),
        (["--host", "no.such.name.invalid", "--token"], "choose an address of this machine"),
        (["--allow-host", "http://rig"], "give only a name"),
    ],
)
def test_an_address_or_name_that_cannot_be_is_refused_in_one_line(tmp_path, words, said):
    command = [sys.executable, "-m", "damper_estimator", "studio", str(tmp_path), "--no-browser", "--port", "0", *words]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (1, "", 1)
    assert said in done.stderr


def test_a_taken_port_is_said_and_names_the_option(tmp_path):
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = str(taken.getsockname()[1])
        command = [sys.executable, "-m", "damper_estimator", "studio", str(tmp_path), "--no-browser", "--port", port]
        done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (1, "", 1)
    assert port in done.stderr and "choose another port with --port" in done.stderr


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


def test_with_a_token_nothing_is_reported_without_it(tmp_path):
    token = new_token()
    address = ServerAddress("0.0.0.0", 8050, token)
    client, sessions = client_of(tmp_path, address)
    host = {"Host": "192.168.1.2:8050"}
    for path in ("/", "/_dash-layout", "/assets/studio.js", "/?token=wrong", "/_dash-layout?token=" + token):
        assert client.get(path, headers=host).status_code == 403
    assert client.post("/leave", data="x", headers=host | {"Origin": "http://192.168.1.2:8050"}).status_code == 403
    entered = client.get(f"/?token={token}", headers=host)
    cookie = entered.headers["Set-Cookie"]
    assert entered.status_code == 302 and entered.location == "/"
    assert cookie.startswith(address.cookie) and "HttpOnly" in cookie and "SameSite=Strict" in cookie
    client.set_cookie(address.cookie, token, domain="192.168.1.2")
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


def test_a_missing_library_is_reported_in_one_line(tmp_path):
    code = (
        "import sys; sys.modules['dash'] = None\nfrom damper_estimator.cli.main import main\n"
        f"sys.exit(main(['studio', {str(tmp_path)!r}, '--no-browser']))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert (done.returncode, done.stderr.count("\n")) == (1, 1)
    assert "pip install 'damper_estimator[studio]'" in done.stderr


def test_a_page_that_nobody_opened_is_reported_to_load_again(client):
    body = {
        "output": "..recording.options..", "outputs": [], "inputs": [], "changedPropIds": [], "state": [],
    }  # fmt: skip
    answer = client.post("/_dash-update-component", data=json.dumps(body), headers=OWN, content_type="application/json")
    assert answer.status_code in (400, 500)
    assert client.get("/", headers={"Host": OWN["Host"]}).status_code == 200
