"""The command `engram serve`."""

from __future__ import annotations

import argparse
import asyncio
import json
import signal
import sys
from typing import Any

import engram
from engram._distribution import install_command
from engram.servers.keys import keys_of
from engram.servers.options import PORTS, bracketed
from engram.servers.serving.policies import SCRIPTED, ScriptedPolicy, ServedPolicy, load_policy

PROTOCOLS = ("openpi", "gr00t", "act")


def serve(words: list[str]) -> int:
    """Serves a policy until Ctrl-C; returns the exit code."""
    options = parser().parse_args(words)
    try:
        for file in options.tasks:
            engram.load_tasks(file)
        for file in options.variants:
            engram.load_variants(file)
        return asyncio.run(_run(options, _policy(options)))
    except KeyboardInterrupt:
        return 130
    except ModuleNotFoundError as error:
        what = install_command("servers")
        print(f"engram serve: {error}; `{what}` installs what it needs", file=sys.stderr)
    except (OSError, engram.Error) as error:
        print(f"engram serve: {error}", file=sys.stderr)
        return 2 if isinstance(error, engram.InvalidArgumentError) else 1
    return 1


def parser() -> argparse.ArgumentParser:
    """Options of the command."""
    result = argparse.ArgumentParser(
        prog="engram serve",
        description="Serves a policy by a protocol of policy servers, until Ctrl-C.",
    )
    add = result.add_argument
    add("--policy", required=True, metavar="NAME|FILE", help=f"{'|'.join(SCRIPTED)}, or agent.pt")
    add("--loader", metavar="FILE.py:NAME", help="function that makes a policy of the file")
    add("--protocol", choices=PROTOCOLS, default="openpi")
    add("--host", default="127.0.0.1", help="address to listen at, default 127.0.0.1")
    add("--port", type=_port, help="default: the protocol's own; 0: a free one")
    add("--chunk", type=_chunk, default=1, help="actions of an answer, default 1 (1 to 1000)")
    add("--server-keys", default="mikasa", metavar="NAME|FILE.json", help="as of eval")
    add("--rules", choices=("reference", "original"), default="reference", help="as of the client")
    add("--physics", choices=("engram", "mujoco"), default="engram", help="as of the client")
    add("--control-mode", metavar="MODE", help="as of the client")
    add("--joint-proprio", action="store_true", help="as of the client")
    add("--set", action="append", default=[], metavar="NAME=VALUE", help="as of the client")
    add("--option", action="append", default=[], metavar="NAME=VALUE", help="as of the client")
    add("--tasks", action="append", default=[], metavar="FILE", help="docs/cpp_tasks.md")
    add("--variants", action="append", default=[], metavar="FILE", help="docs/variants.md")
    return result


def _policy(options: argparse.Namespace) -> ServedPolicy:
    if options.policy in SCRIPTED:
        environment = {
            "rules": options.rules,
            "physics": options.physics,
            "control_mode": options.control_mode,
            "joint_proprio": options.joint_proprio,
            "constants": _values("--set", options.set),
            "task_options": _values("--option", options.option),
        }
        return ScriptedPolicy(options.policy, options.chunk, environment)
    if options.loader is None:
        raise engram.InvalidArgumentError(
            f"--policy: {options.policy!r} given; {', '.join(SCRIPTED)}, or a file and --loader "
            "FILE.py:NAME, the function that loads it, such as "
            "python/learners/src/engram_learners/inference.py:PolicyRunner.load for agent.pt"
        )
    return load_policy(options.loader, options.policy)


def _values(option: str, words: list[str]) -> dict[str, Any] | None:
    """NAME=VALUE, where the value is a number or a list of numbers."""
    result = {}
    for word in words:
        name, equals, value = word.partition("=")
        try:
            result[name] = json.loads(f"[{value}]" if "," in value else value)
        except ValueError:
            equals = ""
        if not name or not equals:
            raise engram.InvalidArgumentError(f"{option}: {word!r} given, NAME=VALUE needed")
    return result or None


async def _run(options: argparse.Namespace, policy: ServedPolicy) -> int:
    from engram.servers.serving.protocols import SERVERS
    from engram.servers.serving.reading import Reader

    keys = keys_of(options.protocol, options.server_keys)
    if keys.flat:
        raise engram.InvalidArgumentError(
            f"--server-keys: {options.server_keys!r} given; flat keys are for clients alone"
        )
    reader = Reader(policy, keys)
    port = PORTS[options.protocol] if options.port is None else options.port
    host = options.host

    def ready(bound: int) -> None:
        print(f"engram serve: {options.protocol}://{bracketed(host)}:{bound}", flush=True)
        if host not in ("127.0.0.1", "::1", "localhost"):
            print(
                f"engram serve: listens at {host}: everybody who reaches it can ask, and it is "
                "sent unencrypted",
                file=sys.stderr,
            )

    server = asyncio.ensure_future(SERVERS[options.protocol](reader, host, port, ready))
    code = 0

    def stop(number: int) -> None:
        nonlocal code
        code = 128 + number
        server.cancel()

    loop = asyncio.get_running_loop()
    for number in (signal.SIGINT, signal.SIGTERM):
        loop.add_signal_handler(number, stop, number)
    try:
        await server
    except asyncio.CancelledError:
        return code
    return code


def _port(text: str) -> int:
    return _number(text, 0, 65535)


def _chunk(text: str) -> int:
    return _number(text, 1, 1000)


def _number(text: str, low: int, high: int) -> int:
    if not text.isascii() or not text.isdigit() or not low <= int(text[:9]) <= high:
        raise argparse.ArgumentTypeError(
            f"{text!r} given; a whole number from {low} to {high} needed"
        )
    return int(text)
