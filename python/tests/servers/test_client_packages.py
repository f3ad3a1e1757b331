"""Released clients of the protocols, and plain ones, against our server."""

from __future__ import annotations

import json
import urllib.request
from typing import Any

import numpy as np
import pytest
from policy_servers import TASK, decode_npy, encode_npy, engram_serve

import engram

SEED = 4242424242


def play(infer) -> tuple[bool, float]:
    """An episode with a client's function of facts and observation."""
    env = engram.make(TASK, obs_mode="rgb")
    obs, info = env.reset(seed=SEED)
    total, step, over = 0.0, 0, False
    while not over:
        facts = {"env_id": TASK, "seed": SEED, "step": step}
        action = infer(obs["rgb"], obs["proprio"], env.language_instruction, facts)
        obs, reward, terminated, truncated, info = env.step(np.asarray(action, np.float32))
        total, step, over = total + reward, step + 1, terminated or truncated
    env.close()
    return bool(info["success_once"]), total


@pytest.fixture(scope="module")
def oracle() -> tuple[bool, float]:
    env = engram.make(TASK, obs_mode="rgb")
    env.reset(seed=SEED)
    total, over = 0.0, False
    while not over:
        _, reward, terminated, truncated, info = env.step(env.act("oracle"))
        total, over = total + reward, terminated or truncated
    env.close()
    return bool(info["success_once"]), total


@pytest.mark.parametrize("package", ["openpi_client.websocket_client_policy", "policy_websocket"])
def test_openpi_clients(package, oracle):
    client_class = pytest.importorskip(package).WebsocketClientPolicy
    with engram_serve("--policy", "oracle") as url:
        host, port = url.removeprefix("openpi://").split(":")
        client = client_class(host=host, port=int(port))
        assert client.get_server_metadata()["server"] == "engram"

        def infer(rgb, proprio, prompt, facts):
            keys = {
                "observation/image": rgb[..., :3],
                "observation/wrist_image": rgb[..., 3:],
                "observation/state": proprio,
                "prompt": prompt,
            }
            return client.infer({**keys, "engram": facts})["actions"][0]

        assert play(infer) == oracle
        with urllib.request.urlopen(f"http://{host}:{port}/healthz") as response:
            assert response.read() == b"OK\n"
        with pytest.raises(RuntimeError, match="oracle needs env_id"):
            client.infer({"prompt": ""})


def test_a_client_of_json_numpy(oracle):
    json_numpy = pytest.importorskip("json_numpy")
    with engram_serve("--policy", "oracle", "--protocol", "act") as url:
        address = url.replace("act://", "http://") + "/act"

        def post(body: dict[str, Any]) -> Any:
            request = urllib.request.Request(address, json_numpy.dumps(body).encode())
            request.add_header("Content-Type", "application/json")
            with urllib.request.urlopen(request) as response:
                return json_numpy.loads(response.read())

        def infer(rgb, proprio, prompt, facts):
            return post({"image": rgb[..., :3], "instruction": prompt, "engram": facts})

        def infer_encoded(rgb, proprio, prompt, facts):
            return post({"encoded": json_numpy.dumps({"instruction": prompt, "engram": facts})})

        assert play(infer) == oracle
        assert play(infer_encoded) == oracle
        assert "oracle needs env_id" in post({"instruction": ""})["error"]


class PlainGr00t:
    """What Isaac-GR00T's client does, in pyzmq and msgpack alone."""

    def __init__(self, url: str) -> None:
        import zmq

        self.socket = zmq.Context.instance().socket(zmq.REQ)
        self.socket.connect(url.replace("gr00t://", "tcp://"))

    def call(self, endpoint: str, data: Any = None) -> Any:
        import msgpack

        request = {"endpoint": endpoint} | ({} if data is None else {"data": data})
        self.socket.send(msgpack.packb(request, default=encode_npy))
        return msgpack.unpackb(self.socket.recv(), object_hook=decode_npy)


def test_a_client_of_plain_zmq(oracle):
    with engram_serve("--policy", "oracle", "--protocol", "gr00t") as url:
        client = PlainGr00t(url)
        assert client.call("ping")["status"] == "ok"

        def infer(rgb, proprio, prompt, facts):
            observation = {
                "video": {"image": rgb[None, None, ..., :3]},
                "state": {"state": proprio[None, None]},
                "language": {"task": [[prompt]]},
            }
            data = {"observation": observation, "options": {"engram": facts}}
            answer, _info = client.call("get_action", data)
            assert answer["action"].shape == (1, 1, 7)
            return answer["action"][0, 0]

        assert play(infer) == oracle
        assert client.call("reset", {"options": None}) == {}
        assert "allowed" in client.call("kill")["error"]


def test_odd_requests_have_an_answer_and_do_no_harm(oracle):
    """Whatever a client sends, it gets a sentence, and the next one is served."""
    from engram.servers import codecs

    facts = {"env_id": TASK, "seed": SEED, "step": 0}
    odd = [
        3,
        [],
        {},
        {"engram": 3},
        {"engram": {**facts, "env_id": "../../etc"}},
        {"engram": {**facts, "env_id": None}},
        {"engram": {**facts, "seed": -1}},
        {"engram": {**facts, "seed": "x"}},
        {"engram": {**facts, "step": -1}},
        {"engram": {**facts, "step": 999_999}},
        {"engram": {**facts, "proprio": "here"}},
        {"engram": {**facts, "proprio": [1.0, 2.0]}},
        {"engram": facts, "image": np.zeros(3), "observation/image": np.zeros((2, 2))},
        {"engram": facts, "image": "x", "observation/image": "x"},
    ]
    with engram_serve("--policy", "oracle") as url:
        from websockets.sync.client import connect

        for request in odd:
            with connect(url.replace("openpi", "ws"), proxy=None) as socket:
                socket.recv()
                socket.send(codecs.pack_openpi(request))
                answer = socket.recv(timeout=20)
                assert isinstance(answer, str), request
                assert 0 < len(answer) < 500
    with engram_serve("--policy", "oracle", "--protocol", "act") as url:
        address = url.replace("act://", "http://") + "/act"
        for request in odd:
            sent = urllib.request.Request(address, codecs.pack_json(request))
            with urllib.request.urlopen(sent) as response:
                assert json.loads(response.read())["error"], request
    with engram_serve("--policy", "oracle", "--protocol", "gr00t") as url:
        client = PlainGr00t(url)
        for request in odd:
            assert client.call("get_action", request)["error"], request
            assert client.call("get_action", {"observation": request})["error"], request
        seen = {"video": {}, "state": {}, "language": {}}
        for request in odd[:-2]:  # whose fault is not in the pictures
            data = {"observation": seen, "options": request}
            assert client.call("get_action", data)["error"], request
        assert client.call("ping")["status"] == "ok"
