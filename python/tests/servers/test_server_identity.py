"""What servers tell of themselves: kept with a run, and held against the run that is made again."""

from __future__ import annotations

import contextlib
import hashlib
import json
import shlex
import sys
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest
from policy_servers import TASK, engram_serve, in_thread, observation, run_engram

import engram
from engram.servers import ServerError, ServerPolicy
from engram.servers.codecs import pack_openpi, pack_vla_eval, unpack
from engram.servers.identity import identity_in

LOADER = """
import numpy as np

def load(file):
    value = float(open(file).read())
    return lambda seen: np.full((len(seen["slot"]), 4, 7), value, np.float32)
"""


@contextlib.contextmanager
def served(folder: Path, weights: str, protocol: str) -> Any:
    """A server of engram with a policy whose weights are a number; its URL and its checkpoint."""
    (folder / "loader.py").write_text(LOADER)
    (folder / "agent.txt").write_text(weights)
    checkpoint = "sha256:" + hashlib.sha256(weights.encode()).hexdigest()
    loader = f"{folder / 'loader.py'}:load"
    words = ("--policy", str(folder / "agent.txt"), "--loader", loader, "--protocol", protocol)
    with engram_serve(*words) as url:
        yield url, checkpoint


def evaluated(out: Path, *words: str) -> Path:
    """The folder of a run."""
    done = run_engram("eval", TASK, "--episodes", "2", "--out", str(out), *words)
    assert done.returncode == 0, done.stderr
    return next(out.glob("*/*/settings.json")).parent


@pytest.mark.parametrize("protocol", ["openpi", "gr00t"])
def test_a_run_names_the_checkpoint(tmp_path: Path, protocol: str) -> None:
    with served(tmp_path, "0.25", protocol) as (url, first):
        run = evaluated(tmp_path / "out", "--policy-server", url)
        told = json.loads((run / "policy.json").read_text())
        assert told["checkpoint"] == first
        assert told["policy"] == "agent.txt"
        assert (told["server"], told["version"]) == ("engram", engram.__version__)
        again = reproduced(run, url)
        assert again["verdict"] == "same"
        assert again["checkpoints"] == {"run": first, "again": first}
    # 0.250 is the same number, so that the answers are equal.
    for weights, repeats in (("0.250", None), ("0.5", True)):
        with served(tmp_path, weights, protocol) as (url, other):
            again = reproduced(run, url)
            assert again["verdict"] == "policy"
            assert again["checkpoints"] == {"run": first, "again": other}
            assert again["policy_repeats"] is repeats


def test_runs_of_python_name_it_too(tmp_path: Path) -> None:
    with served(tmp_path, "0.25", "openpi") as (url, checkpoint):
        engram.evaluate(url, TASK, episodes=2, output=tmp_path / "server")
    (run,) = (tmp_path / "server").glob("*/*")
    assert json.loads((run / "policy.json").read_text())["checkpoint"] == checkpoint

    class Mine:
        identity: ClassVar[dict[str, Any]] = {"checkpoint": "mine", "layers": np.int64(3)}

        def __call__(self, seen: dict[str, Any]) -> Any:
            return np.zeros((len(seen["slot"]), 7), np.float32)

    for policy, told in (Mine(), {"checkpoint": "mine", "layers": 3}), (Mine().__call__, None):
        out = tmp_path / f"own-{told is None}"
        engram.evaluate(policy, TASK, episodes=2, output=out)
        (run,) = out.glob("*/*")
        found = run / "policy.json"
        assert (json.loads(found.read_text()) if found.exists() else None) == told
    # A run of another policy is not resumed.
    (run / f"{TASK}.json").unlink()
    (run / "policy.json").write_text('{"checkpoint": "other"}')
    with pytest.raises(engram.UnavailableError, match='tells checkpoint "mine", and told "other"'):
        engram.evaluate(Mine(), TASK, episodes=2, resume=run)


def reproduced(run: Path, url: str) -> dict[str, Any]:
    done = run_engram("reproduce", str(run), "--json", "--policy-server", url)
    return json.loads(done.stdout)


def test_a_command_with_chunks_names_it_too(tmp_path: Path) -> None:
    policy = tmp_path / "telling.py"
    examples = Path(__file__).resolve().parents[2] / "examples"
    policy.write_text(
        f"import sys\nsys.path.insert(0, {str(examples)!r})\nimport pipe_policy\n"
        "pipe_policy.send(9, sys.argv[1].encode())\npipe_policy.main()\n"
    )

    def words(told: str) -> list[str]:
        command = shlex.join([sys.executable, str(policy), told])
        return ["--policy-command", command, "--replan", "2"]

    run = evaluated(tmp_path / "out", *words('{"checkpoint": ["a", 1]}'))
    assert json.loads((run / "policy.json").read_text()) == {"checkpoint": ["a", 1]}
    refused = run_engram("eval", TASK, "--episodes", "1", *words("[]"))
    assert refused.returncode == 1
    assert "it told of itself something else than a JSON object" in refused.stderr


@contextlib.contextmanager
def telling_server(greetings: list[Any]) -> Any:
    """Another of openpi's metadata for each connection."""
    from websockets.asyncio.server import serve

    async def talk(socket: Any) -> None:
        await socket.send(pack_openpi(greetings.pop(0)))
        async for _ in socket:
            await socket.send(pack_openpi({"actions": np.zeros((1, 7), np.float32)}))

    async def run(ready: Any) -> None:
        async with serve(talk, "127.0.0.1", 0) as server:
            ready(next(iter(server.sockets)).getsockname()[1])
            await server.serve_forever()

    with in_thread(run) as port:
        yield f"openpi://127.0.0.1:{port}"


def test_a_server_that_changes_its_checkpoint_is_refused() -> None:
    greetings = [{"checkpoint": "a", "up": 1}, {"up": 2}, {"checkpoint": "a"}, {"checkpoint": "b"}]
    with telling_server(greetings) as url:
        policy = ServerPolicy(url)
        for _ in range(3):
            policy(observation())
            assert policy.identity == {"checkpoint": "a", "up": 1}
        with pytest.raises(ServerError, match="tells checkpoint 'b', and told 'a' before"):
            policy(observation())
        policy.close()


def test_model_servers_of_vla_eval_are_named() -> None:
    from websockets.asyncio.server import serve

    async def talk(socket: Any) -> None:
        async for message in socket:
            asked = unpack(message)
            kind = {"hello": "hello", "observation": "action"}.get(asked["type"])
            if kind is not None:
                told = {"model_server": "OpenVLAServer", "capabilities": {}}
                payload = told if kind == "hello" else {"actions": np.zeros((1, 7), np.float32)}
                answer = {"type": kind, "payload": payload, "seq": asked["seq"], "timestamp": 0.0}
                await socket.send(pack_vla_eval(answer))

    async def run(ready: Any) -> None:
        async with serve(talk, "127.0.0.1", 0) as server:
            ready(next(iter(server.sockets)).getsockname()[1])
            await server.serve_forever()

    with in_thread(run) as port:
        policy = ServerPolicy(f"vla-eval://127.0.0.1:{port}")
        policy(observation())
        assert policy.identity == {"model_server": "OpenVLAServer", "capabilities": {}}
        policy.close()


def test_metadata_are_kept_as_json_has_them() -> None:
    deep: Any = 1
    for _ in range(20):
        deep = [deep]
    metadata = {
        "checkpoint": "a\udc80",
        "pose": np.arange(2.0),
        "number": np.float32(0.5),
        "none": float("nan"),
        "bytes": b"x",
        3: (True, None),
        "deep": deep,
    }
    told = identity_in(metadata)
    assert told["checkpoint"] == "a?"
    assert told["pose"] == [0.0, 1.0]
    assert (told["number"], told["none"], told["bytes"]) == (0.5, None, None)
    assert told["3"] == [True, None]
    assert json.loads(json.dumps(told, allow_nan=False)) == told
    assert identity_in({"checkpoint": "a", "much": "x" * 100_000}) == {"checkpoint": "a"}
    assert identity_in({"checkpoint": "x" * 100_000}) == {}
    assert identity_in(None) == identity_in([1]) == {}
