"""The commands `engram serve` and `engram servers`, and the bridge of `--policy-server`."""

from __future__ import annotations

import argparse
import os
import signal
import sys
from typing import Any, NoReturn


def main(arguments: list[str] | None = None) -> int:
    """Runs one of the three: the first word names it."""
    words = sys.argv[1:] if arguments is None else arguments
    if words[:1] == ["bridge"]:
        return bridge(words[1:])
    if words[:1] == ["check"]:
        from engram.servers.checking.command import check_server

        return check_server(words[1:])
    from engram.servers.serving.command import serve

    return serve(words[1:] if words[:1] == ["serve"] else words)


def bridge(words: list[str]) -> int:
    """A policy server, or a command with its own pipes, behind the pipes of a simulator."""
    from engram.servers.bridge import run_bridge, serve_pipes
    from engram.servers.options import add_arguments, given_arguments
    from engram.servers.policy import ServerPolicy

    parser = argparse.ArgumentParser(prog="engram.servers bridge", description=bridge.__doc__)
    parser.add_argument("url", nargs="?")
    parser.add_argument("--command")
    parser.add_argument("--timeout", type=float, default=300.0)
    add_arguments(parser)
    parsed = parser.parse_args(words)

    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the command handles Ctrl-C and ends this process

    if parsed.command is not None:
        from engram.servers.piped import PipedBridge

        piped = PipedBridge(parsed.command, parsed.server_replan, parsed.server_history)
        return run_bridge(piped, sys.stdout.buffer)

    def make(action_dim: int) -> Any:
        return ServerPolicy(
            parsed.url, action_dim=action_dim, timeout=parsed.timeout, **given_arguments(parsed)
        )

    return serve_pipes(make)


def run() -> NoReturn:
    """The whole command."""
    code = main()
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)  # without waiting for connections


if __name__ == "__main__":
    run()
