"""`engram play` with a policy server."""

from __future__ import annotations

import subprocess
import sys
from typing import Any

import numpy as np
import pytest
from play_server import serving
from policy_servers import TASK, openpi_server, results_of

SECONDS = 60


def swaying(request: dict[str, Any]) -> np.ndarray:
    """Actions as a function of all frames since the last question."""
    light = request["observation/image"].mean() + request["observation/state"].sum()
    return 0.3 * np.sin(light * np.arange(1, 8)) * np.ones((6, 1))


def test_a_server_is_watched_and_plays_as_in_an_evaluation(tmp_path):
    with openpi_server(swaying) as url:
        words = ("--policy-server", url, "--history", "since-last", "--replan", "4")
        with serving(tmp_path, *words) as server, server.page() as page:
            assert page.receive("hello")["sources"][-1] == "process"
            page.send("watch", id=TASK, source="process", seed="4242424242")
            playback = page.receive("playback")
            page.send("grid", id=TASK, source="process", seed="1")  # sixteen episodes in flight
            page.receive("grid")
            page.send("run", on=True)
            while page.receive("grid").get("elapsed", 0) < 6:
                page.send("seen", n=0)
        result = results_of("eval", TASK, "--episodes", "1", *words)
    assert playback["result"]["return"] == pytest.approx(result["tasks"][0]["returns"][0])


def test_a_failure_of_the_server_is_shown(tmp_path):
    with (
        openpi_server(lambda _: np.full((1, 7), np.nan)) as url,
        serving(tmp_path, "--policy-server", url) as server,
        server.page() as page,
    ):
        page.send("watch", id=TASK, source="process")
        with pytest.raises(AssertionError, match=f"policy server {url} answered with nan"):
            page.receive("playback")


def test_options_of_servers_are_refused_before_the_page_opens():
    for words, message in (
        (("--policy-server", "http://x"), "openpi|gr00t|act|vla-eval://HOST:PORT needed"),
        (("--policy-server", "act://x", "--history", "x"), "history: 'x' given"),
        (("--policy-server", "act://x", "--policy-command", "y"), "--policy-command"),
    ):
        done = subprocess.run(
            [sys.executable, "-m", "engram", "play", "--no-open", *words],
            capture_output=True,
            text=True,
            check=False,
            timeout=SECONDS,
        )
        assert done.returncode != 0
        assert message in done.stderr
        assert done.stderr.count("\n") == 1
