"""The page is opened without its address in a command line, which all users can read."""

from __future__ import annotations

import html
import os
import re
import stat
import sys
import time
from pathlib import Path
from urllib.parse import unquote, urlsplit

from play_server import SECONDS, serving

# A browser that writes down what it was given.
BROWSER = """#!/bin/sh
printf '%s' "$1" >"$0.new"; mv "$0.new" "$0.given"
"""


def test_the_browsers_command_line_has_no_token(tmp_path, monkeypatch):
    browser = tmp_path / "browser"
    browser.write_text(BROWSER)
    browser.chmod(0o755)
    monkeypatch.setenv("BROWSER", f"{browser} %s")
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    given = tmp_path / "browser.given"
    with serving(tmp_path / "out", opens=True) as server:
        end = time.monotonic() + SECONDS
        while not given.exists():
            assert time.monotonic() < end
            time.sleep(0.02)
        address = given.read_text()
        assert server.token not in address
        for process in Path("/proc").glob("[0-9]*/cmdline"):
            try:
                assert server.token.encode() not in process.read_bytes()
            except OSError:
                continue
        file = Path(unquote(urlsplit(address).path))
        assert stat.S_IMODE(file.stat().st_mode) == 0o600
        assert stat.S_IMODE(file.parent.stat().st_mode) == 0o700
        assert file.stat().st_uid == os.getuid()
        (link,) = re.findall(r'content="0; url=([^"]*)"', file.read_text())
        assert html.unescape(link) == server.link
        with server.page() as page:
            page.receive("hello")
            assert not file.parent.exists()
        server.end()


def test_the_file_is_gone_if_the_page_never_opens(tmp_path, monkeypatch):
    monkeypatch.setenv("BROWSER", "true %s")
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    with serving(tmp_path / "out", opens=True) as server:
        end = time.monotonic() + SECONDS
        while not list(tmp_path.glob("engram-play-*")):
            assert time.monotonic() < end
            time.sleep(0.02)
        server.end()
    assert not list(tmp_path.glob("engram-play-*"))


def test_without_a_place_for_the_file_the_address_is_still_served(tmp_path, monkeypatch):
    monkeypatch.setenv("BROWSER", "true %s")
    with serving(tmp_path / "out", opens=True, program=UNWRITABLE) as server:
        assert len(server.get("tasks.json")) >= 97
        assert "no browser was opened" in server.end()


# A Python whose folder of temporary files is missing.
UNWRITABLE = (sys.executable, "-c", """
import runpy, sys, tempfile
tempfile.tempdir = "/nowhere"
sys.argv = ["engram play", *sys.argv[2:]]
runpy.run_module("engram.play", run_name="__main__")
""")  # fmt: skip
