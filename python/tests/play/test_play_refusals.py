"""Attacks from outside the page: they are refused and counted, and the page plays on."""

from __future__ import annotations

import contextlib
import http.client
import json
import random
import socket
import subprocess
import sys
import time

import pytest
from play_server import SECONDS, Server, serving
from test_messages import mutated
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

TASK = "RememberColor3-VLA-v0"


def request(server: Server, path: str, method: str = "GET", **headers: str) -> tuple[int, str]:
    """Sends a path just as it is."""
    connection = http.client.HTTPConnection(server.host, timeout=SECONDS)
    connection.putrequest(method, path, skip_host="Host" in headers)
    for name, value in headers.items():
        connection.putheader(name.replace("_", "-"), value)
    connection.endheaders()
    answer = connection.getresponse()
    body = answer.read().decode(errors="replace")
    connection.close()
    return answer.status, body


def counted(server: Server, reason: str, attack) -> None:
    """The attack raises the count of its reason."""
    before = server.refused().get(reason, 0)
    attack()
    assert server.refused().get(reason, 0) > before


@pytest.mark.parametrize("path", ["/", "/tasks.json", "/socket", "/x/", "//", "/%00/", "/%C3%A9/"])
def test_without_the_token_nothing_is_served(server, path):
    def attack():
        status, body = request(server, path)
        assert status == 403
        assert "token" in body

    counted(server, "token", attack)


def test_a_token_that_is_nearly_right_is_wrong(server):
    for token in (server.token[:-1], server.token + "A", server.token.swapcase(), ""):
        assert request(server, f"/{token}/")[0] == 403


@pytest.mark.parametrize(
    "path",
    [
        "../app.py", "..%2fapp.py", "%2e%2e/app.py", "page/index.html", "/etc/passwd",
        "..\\app.py", "picture/../../app.py", "picture/../app.jpg", "task/.json", "index.html/",
        "picture/RememberColor3-VLA-v0.png", "picture/%00.jpg", "style.css%00", "__init__.py",
    ],
)  # fmt: skip
def test_no_path_leads_to_a_file(server, path):
    def attack():
        status, body = request(server, f"/{server.token}/{path}")
        assert status == 404
        assert body == "no such page\n"

    counted(server, "path", attack)


@pytest.mark.parametrize("host", ["evil.example", "evil.example:80", "127.0.0.1.evil.example", ""])
def test_other_names_of_the_machine_are_refused(server, host):
    counted(server, "host", lambda: _is(403, request(server, f"/{server.token}/", Host=host)))


def test_a_tunnel_may_have_another_port(server):
    assert request(server, f"/{server.token}/", Host="localhost:9999")[0] == 200


@pytest.mark.parametrize(
    "origin", ["http://evil.example", "null", "https://{host}", "http://{host}.x"]
)
def test_foreign_origins_are_refused(server, origin):
    origin = origin.format(host=server.host)
    path = f"/{server.token}/"
    counted(server, "origin", lambda: _is(403, request(server, path, Origin=origin)))
    with pytest.raises(InvalidStatus) as error:
        connect(server.link.replace("http:", "ws:") + "socket", origin=origin)
    assert error.value.response.status_code == 403


def test_sockets_without_an_origin_are_refused(server):
    def attack():
        with pytest.raises(InvalidStatus):
            connect(server.link.replace("http:", "ws:") + "socket")

    counted(server, "origin", attack)


def test_other_sites_cannot_load_what_is_served(server):
    path = f"/{server.token}/tasks.json"
    assert request(server, path, Sec_Fetch_Site="cross-site")[0] == 403
    assert request(server, path, Sec_Fetch_Site="same-origin")[0] == 200


def test_other_sites_can_open_the_page_in_a_window_only(server):
    """The file that the browser is given leads there; frames and scripts get nothing."""
    window = {"Sec_Fetch_Site": "cross-site", "Sec_Fetch_Mode": "navigate"}
    page, tasks = f"/{server.token}/", f"/{server.token}/tasks.json"
    assert request(server, page, **window, Sec_Fetch_Dest="document")[0] == 200
    assert request(server, page, **window, Sec_Fetch_Dest="iframe")[0] == 403
    assert request(server, tasks, **window, Sec_Fetch_Dest="document")[0] == 403
    assert request(server, "/wrong/", **window, Sec_Fetch_Dest="document")[0] == 403


@pytest.mark.parametrize("method", ["POST", "PUT", "DELETE", "OPTIONS"])
def test_nothing_can_be_sent_but_messages(server, method):
    status, _ = request(server, f"/{server.token}/", method)
    assert status == 405


def test_the_page_loads_nothing_from_other_origins(server):
    connection = http.client.HTTPConnection(server.host, timeout=SECONDS)
    connection.request("GET", f"/{server.token}/")
    answer = connection.getresponse()
    page = answer.read().decode()
    policy = answer.headers["Content-Security-Policy"]
    assert "default-src 'none'" in policy
    assert "unsafe" not in policy
    assert answer.headers["Referrer-Policy"] == "no-referrer"
    assert answer.headers["X-Content-Type-Options"] == "nosniff"
    assert "http://" not in page
    assert "https://" not in page


def _is(status: int, answer: tuple[int, str]) -> None:
    assert answer[0] == status


# --- messages ---


def test_a_message_that_is_too_large_ends_the_connection(server):
    def attack():
        with server.page() as page:
            page.receive("hello")
            page.socket.send('{"do": "' + "x" * 20_000 + '"}')
            assert page.closed() == 1009

    counted(server, "oversized or broken message", attack)


def test_bytes_and_broken_frames_are_refused(server):
    with server.page() as page:
        page.receive("hello")
        page.socket.send(b"\x00\x01")
        assert "bytes given" in page.socket.recv(timeout=SECONDS)
        page.socket.socket.sendall(b"\xff\xff\xff\xff\xff\xff")
        with pytest.raises(ConnectionClosed):
            page.socket.recv(timeout=SECONDS)


def test_ten_thousand_random_messages_do_no_harm(server):
    rng = random.Random(4242)
    before = server.refused().get("message", 0)
    with server.page() as page:
        page.receive("hello")
        sent = 0
        while sent < 10_000:
            text = mutated(rng)
            # Valid messages that start episodes are left out; they have tests of their own.
            if not text.isprintable() or not any(
                k in text for k in ('"play"', '"watch"', '"grid"')
            ):
                page.socket.send(text)
                sent += 1
                while True:
                    try:
                        page.socket.recv(timeout=0)
                    except TimeoutError:
                        break
        page.socket.send('{"do": "play", "id": "RememberColor3-VLA-v0", "seed": "1"}')
        while '"opened"' not in str(page.socket.recv(timeout=SECONDS)):
            pass
    assert server.refused()["message"] > before + 5_000
    assert server.process.poll() is None


@pytest.mark.parametrize(
    ("message", "words"),
    [
        ({"do": "play", "id": "Nothing-v0"}, "no task"),
        ({"do": "play", "id": "../x", "seed": "1"}, "no task"),
        ({"do": "play", "id": TASK, "pins": {"target": 99}}, "target"),
        ({"do": "play", "id": TASK, "constants": {"COLORS": 99}}, "COLORS"),
        ({"do": "step", "a": [0] * 7, "n": 1}, "play first"),
        ({"do": "run", "on": True}, "play first"),
        ({"do": "save"}, "no finished episode"),
        ({"do": "review"}, "no finished episode"),
        ({"do": "frame", "n": 0}, "watch first"),
        ({"do": "watch", "id": TASK, "source": "process"}, "no policy 'process'"),
        ({"do": "stored", "folder": 0, "task": 0, "episode": 0}, "no folder 0"),
    ],
    ids=lambda value: str(value)[:30],
)
def test_impossible_requests_are_reported(server, message, words):
    with server.page() as page:
        fields = dict(message)
        page.send(fields.pop("do"), **fields)
        while True:
            received = page.socket.recv(timeout=SECONDS)
            assert isinstance(received, str)
            if '"error"' in received:
                break
        assert words in received


# --- tabs, and the end ---


def test_a_second_tab_is_notified_and_can_take_over(server):
    with server.page() as first, server.page() as second:
        first.receive("hello")
        second.receive("busy")
        second.send("play", id=TASK)  # ignored
        second.send("take")
        first.receive("taken")
        with pytest.raises(ConnectionClosed) as error:
            first.socket.recv(timeout=SECONDS)
        assert error.value.rcvd is not None
        assert error.value.rcvd.code == 4001
        second.receive("hello")
        second.play(TASK, 3)


class SuspendedTab:
    """A tab that sends, but reads nothing: neither pictures nor farewells."""

    def __init__(self, server: Server) -> None:
        host, _, port = server.host.rpartition(":")
        self._socket = socket.socket()
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        self._socket.connect((host, int(port)))
        self._socket.sendall(
            f"GET /{server.token}/socket HTTP/1.1\r\nHost: {server.host}\r\n"
            f"Origin: http://{server.host}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
            "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n\r\n"
            "".encode()
        )
        time.sleep(1)

    def send(self, kind: str, **fields) -> None:
        text = json.dumps({"do": kind, **fields}).encode()
        self._socket.sendall(bytes([0x81, 0x80 | len(text)]) + bytes(4) + text)

    def __enter__(self) -> SuspendedTab:
        return self

    def __exit__(self, *_error) -> None:
        self._socket.close()


@pytest.mark.parametrize("pictures", [0, 3000])  # that fill all buffers on the way
def test_a_tab_that_stands_still_is_taken_over_at_once(server, pictures):
    with SuspendedTab(server) as first, server.page() as second:
        first.send("watch", id=TASK, source="oracle", seed="1")
        time.sleep(2)  # the episode is played in the background
        for i in range(pictures):
            first.send("frame", n=i % 20)
        time.sleep(2)
        second.receive("busy")
        start = time.monotonic()
        second.send("take")
        second.receive("hello")
        second.play(TASK, 3)
        assert time.monotonic() - start < 3


def test_of_two_tabs_that_take_over_one_plays(server):
    with SuspendedTab(server), server.page() as second, server.page() as third:
        second.receive("busy")
        third.receive("busy")
        second.send("take")
        third.send("take")
        start = time.monotonic()
        players = []
        for page in (second, third):
            with contextlib.suppress(ConnectionClosed, TimeoutError):
                page.socket.recv(timeout=SECONDS)  # hello
                while True:
                    page.socket.recv(timeout=2)
            if page.socket.close_code is None:
                players.append(page)
        assert time.monotonic() - start < 8
        assert len(players) == 1
        players[0].play(TASK, 3)


def test_the_server_ends_with_its_page(tmp_path):
    with serving(tmp_path / "out", stay=False) as server:
        with server.page() as page:
            page.play(TASK)
            page.send("run", on=True)
        assert server.process.wait(SECONDS) == 0
        assert not (tmp_path / "out").exists()


def test_ctrl_c_ends_it_and_reports_refused_requests(tmp_path):
    with serving(tmp_path / "out") as server, server.page() as page:
        page.play(TASK)
        page.send("run", on=True)
        request(server, "/")
        log = server.end()
        assert server.process.returncode == 130
        assert "refused: 1 token" in log
        assert "Traceback" not in log


def test_the_engram_command_becomes_the_server(tmp_path):
    variants = tmp_path / "variants.json"
    one = {"id": "RememberColor4-v0", "base": "RememberColor9-VLA-v0", "constants": {"COLORS": 4}}
    variants.write_text(json.dumps({"variants": [one]}))
    words = ("engram", "--variants", str(variants), "play")
    with serving(tmp_path / "out", command=words) as server, server.page() as page:
        assert server.get("tasks.json")[-1]["id"] == "RememberColor4-v0"
        assert page.play("RememberColor4-v0", 3)["score"]["sweep"] is None
        assert "Traceback" not in server.end()
        assert server.process.returncode == 130


def test_it_listens_on_this_machine_only(server):
    port = int(server.host.rpartition(":")[2])
    others = {
        info[4][0]
        for info in socket.getaddrinfo(socket.gethostname(), port, socket.AF_INET)
        if not str(info[4][0]).startswith("127.")
    }
    for address in others:
        with pytest.raises(ConnectionRefusedError):
            socket.create_connection((str(address), port), timeout=5)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--port", "70000"], "0 to 65535"),
        (["--policy-command", ""], "a command needed"),
        (["--out", ""], "the name of a folder needed"),
        (["--folder", "/nowhere"], "engram collect"),
        (["--host", "256.1.1.1"], "256.1.1.1"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else "",
)
def test_invalid_options_are_reported_in_a_sentence(tmp_path, arguments, words):
    command = [sys.executable, "-m", "engram.play", "--no-open", *arguments]
    done = subprocess.run(command, capture_output=True, text=True, timeout=SECONDS, cwd=tmp_path)
    assert done.returncode != 0
    assert words in done.stderr
    assert "Traceback" not in done.stderr
