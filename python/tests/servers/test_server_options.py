"""Options of policy servers: addresses, keys, layouts, conventions; what is refused."""

from __future__ import annotations

import io
import json
import struct

import numpy as np
import pytest
from policy_servers import TASK, observation, openpi_server

import engram
from engram.servers import ServerPolicy, conventions
from engram.servers.bridge import Bridge
from engram.servers.keys import PRESETS, keys_of
from engram.servers.options import OPTIONS, History, ServerOptions, is_url

URL = "openpi://127.0.0.1:1"


def test_addresses():
    options = ServerOptions.parse("gr00t://host?replan=4&history=3,2")
    assert (options.url, options.port) == ("gr00t://host:5555", 5555)
    assert (options.replan, options.history) == (4, History(3, 2))
    assert ServerOptions.parse("act://[::1]:9/predict").url == "act://[::1]:9/predict"
    assert ServerOptions.parse(URL + "?replan=4", replan=5).replan == 5
    assert is_url("act://x")
    assert not is_url("oracle")
    assert not is_url("http://x")


@pytest.mark.parametrize(
    ("url", "options", "message"),
    [
        ("http://x", {}, "openpi|gr00t|act|vla-eval://HOST:PORT needed"),
        ("openpi://", {}, "HOST:PORT needed"),
        ("openpi://x:99999", {}, "a port from 1 to 65535 allowed"),
        ("openpi://me:secret@x", {}, "no user and no fragment allowed"),
        ("openpi://x?speed=3", {}, "option 'speed' given, keys, state"),
        (URL, {"keys": "pusht"}, "keys: 'pusht' given; mikasa, libero, droid or a FILE.json"),
        (URL, {"keys": "no.json"}, "keys: 'no.json'"),
        (URL, {"state": "x"}, "state: 'x' given, tcp7, tcp7_continuous, libero8"),
        (URL, {"actions": "x"}, "actions: 'x' given, mikasa, libero, oxe allowed"),
        (URL, {"image": "big"}, "image: 'big' given, a whole number 8 to 4096 needed"),
        (URL, {"replan": 0}, "replan: '0' given, a whole number 1 to 1000 needed"),
        (URL, {"history": "all"}, "history: 'all' given; last, since-last or N,STRIDE allowed"),
        (URL, {"history": "1,1"}, "history: '1,1' given"),
        (URL, {"reset": "x"}, "reset: 'x' given, reconnect, message, none allowed"),
    ],
)
def test_refused(url, options, message):
    with pytest.raises(engram.InvalidArgumentError) as caught:
        ServerPolicy(url, **options)
    assert message in str(caught.value)


def test_evaluate_takes_an_address_or_a_function():
    with pytest.raises(engram.InvalidArgumentError, match="a function needed, or the address"):
        engram.evaluate("oracle", TASK)
    with pytest.raises(engram.InvalidArgumentError, match="replan: 'x' given"):
        engram.evaluate(policy=URL + "?replan=x", ids=TASK)
    seen = []

    def act(request):
        seen.append(request)
        return np.zeros((25, 7))

    with openpi_server(act) as url:
        result = engram.evaluate(policy=f"{url}?image=32", ids=TASK, episodes=2, name="mine")
    model = result["tasks"][0]["model"]
    assert model == {"name": "mine", "config": {"server": url, "image": "32"}}
    assert seen[0]["observation/image"].shape == (32, 32, 3)
    assert "engram" not in seen[0]  # nobody is told


def test_the_bridge_gives_errors_to_the_simulator():
    """A refusal comes out as message 5."""
    hello = struct.pack("<9I", 0x4D474E45, 1, 1, 128, 128, 6, 7, 7, 8)

    def refuse(_dim):
        raise engram.InvalidArgumentError("keys: 'x' given")

    sink = io.BytesIO()
    message = struct.pack("<II", 1, len(hello)) + hello
    assert Bridge(refuse).run(io.BytesIO(message), sink) == 1
    assert sink.getvalue() == struct.pack("<II", 5, 15) + b"keys: 'x' given"


# --- keys ---


def test_a_file_of_keys(tmp_path):
    file = tmp_path / "keys.json"
    file.write_text(
        json.dumps(
            {
                "preset": "libero",
                "wrist": None,
                "state": {"eef": [0, 3], "grip": [6, 8]},
                "actions": ["move", "grip"],
                "size": [64, 96],
                "convention": "mikasa",
                "extra": {"unnorm_key": "mine"},
            }
        )
    )
    seen = []

    async def talk(socket):
        from engram.servers.codecs import pack_openpi, unpack

        async for message in socket:
            seen.append(unpack(message))
            await socket.send(pack_openpi({"move": np.ones((3, 6)), "grip": np.zeros((3, 1))}))

    from policy_servers import socket_server

    with socket_server(talk) as url:
        policy = ServerPolicy(url, keys=str(file))
        assert policy(observation())[0].tolist() == [[1] * 6 + [0]] * 3
        policy.close()
    (request,) = seen
    assert {name: np.shape(value) for name, value in request.items()} == {
        "observation/image": (64, 96, 3),
        "eef": (3,),
        "grip": (2,),
        "prompt": (),
        "unnorm_key": (),
    }


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("[", "Expecting value"),
        ("[]", "an object needed"),
        ('{"preset": "x"}', "preset 'x' given, mikasa, libero, droid allowed"),
        ('{"wirst": "x"}', "'wirst' given; preset, base, wrist"),
        ('{"base": 3}', "base: 3 given, a name needed"),
        ('{"prompt": null}', "prompt: None given, a name needed"),
        ('{"state": {"a": 3}}', '{"name": [start, stop], ...} needed'),
        ('{"layout": "x"}', "layout: 'x' given, tcp7"),
        ('{"size": 224}', "[height, width] or null needed"),
        ('{"actions": "a"}', "a list of names needed"),
        ('{"extra": 1}', "an object needed"),
    ],
)
def test_files_of_keys_that_are_refused(content, message, tmp_path):
    file = tmp_path / "keys.json"
    file.write_text(content)
    with pytest.raises(engram.InvalidArgumentError) as caught:
        keys_of("openpi", str(file))
    assert message in str(caught.value)


def test_joints_need_joint_proprio():
    with openpi_server(lambda _: np.zeros((1, 7))) as url:
        policy = ServerPolicy(url, keys="droid")
        with pytest.raises(engram.InvalidArgumentError, match="joint angles needed, and policies"):
            policy(observation())
        policy.close()


def test_joints_are_passed_on_where_there_are_some():
    """A simulator whose proprio is seven angles and the gripper's width, and actions of 8."""
    seen = []

    def act(request):
        seen.append(request)
        return np.zeros((4, 8))

    joints = np.arange(8, dtype=np.float32)[None]
    with openpi_server(act) as url:
        policy = ServerPolicy(url, keys="droid", action_dim=8)
        assert policy(observation(proprio=joints))[0].shape == (4, 8)
        with pytest.raises(engram.InvalidArgumentError, match="the TCP's pose needed"):
            ServerPolicy(url, action_dim=8)(observation(proprio=joints))
        policy.close()
    assert seen[0]["observation/joint_position"].tolist() == list(range(7))
    assert seen[0]["observation/gripper_position"].tolist() == [7]


def test_a_server_may_ask_for_a_size():
    async def talk(socket):
        from engram.servers.codecs import pack_openpi, unpack

        async for message in socket:
            size = unpack(message)["observation/image"].shape[0]
            await socket.send(pack_openpi({"actions": np.full((1, 7), size)}))

    from policy_servers import in_thread

    async def run(ready):
        from websockets.asyncio.server import serve

        from engram.servers.codecs import pack_openpi

        async def greet(socket):
            await socket.send(pack_openpi({"image_resolution": [96, 96]}))
            await talk(socket)

        async with serve(greet, "127.0.0.1", 0) as server:
            ready(next(iter(server.sockets)).getsockname()[1])
            await server.serve_forever()

    with in_thread(run) as port:
        for image, size in ((None, 96), ("native", 128), ("64", 64)):
            policy = ServerPolicy(f"openpi://127.0.0.1:{port}", image=image)
            assert policy(observation())[0][0, 0] == size
            policy.close()


def test_reset_by_message_and_by_connection():
    talks = []

    async def talk(socket):
        from engram.servers.codecs import pack_openpi, unpack

        talks.append([])
        async for message in socket:
            request = unpack(message)
            talks[-1].append(request.get("reset", False))
            await socket.send(pack_openpi({"actions": np.zeros((1, 7))}))

    from policy_servers import socket_server

    with socket_server(talk) as url:
        for reset, expected in (
            ("reconnect", [[False, False], [False]]),
            ("message", [[True, False, False, True, False]]),
            ("none", [[False, False, False]]),
        ):
            talks.clear()
            policy = ServerPolicy(url, reset=reset)
            for step in (0, 1, 0):
                policy(observation(step=step))
            policy.close()
            assert talks == expected


# --- conventions ---


def matrix_of_vector(vector):
    angle = np.linalg.norm(vector)
    x, y, z = vector / angle
    k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * k @ k


def test_rotation_vectors():
    rng = np.random.default_rng(2)
    angles = rng.uniform(-np.pi, np.pi, (200, 3)) * [1, 0.5, 1]
    vectors = conventions.rotation_vector(angles)
    assert (np.linalg.norm(vectors, axis=-1) <= np.pi + 1e-9).all()
    for matrix, vector in zip(conventions.matrix_of(angles), vectors):
        assert np.allclose(matrix, matrix_of_vector(vector))
    small = np.array([1e-9, -2e-9, 3e-9])
    assert np.allclose(conventions.rotation_vector(small), small, rtol=1e-6, atol=0)
    assert conventions.rotation_vector(np.zeros(3)).tolist() == [0, 0, 0]


def test_state_layouts():
    proprio = np.array([0.1, 0.2, 0.3, np.pi, 0, 0.5, 0.06], np.float32)
    assert conventions.state_of("tcp7", proprio).tolist() == proprio.tolist()
    flipped = proprio * [1, 1, 1, -1, 1, 1, 1]  # the same rotation, but for rounding
    turn = conventions.matrix_of(proprio[3:6])
    for given in (proprio, flipped):
        state = conventions.state_of("tcp7_continuous", given)
        np.testing.assert_allclose(state, proprio, atol=1e-6)
        libero = conventions.state_of("libero8", given)
        assert libero[:3].tolist() == proprio[:3].tolist()
        assert libero[3] > 3
        assert np.allclose(matrix_of_vector(libero[3:6]), turn, atol=1e-6)
        assert np.allclose(libero[6:], [0.03, -0.03])
        oxe = conventions.state_of("oxe8", given)
        assert np.allclose(oxe, [0.1, 0.2, 0.3, np.pi, 0, 0.5, 0, 0.75])
        rpy = conventions.state_of("libero_rpy8", given)
        assert np.allclose(rpy, [0.1, 0.2, 0.3, np.pi, 0, 0.5, 0.03, -0.03])


FAMILIES = {task["family"]: task["id"] for task in engram.list() if task["action_dim"] == 7}


def frames_of(id, steps=60):
    """Proprio (episodes, steps + 1, 7) of the oracle."""
    env = engram.make_vec(id, 2, after_end="hold")
    frames = [env.reset(seed=1)[1]["proprio"].copy()]
    for _ in range(steps):
        frames.append(env.step(env.act("oracle"))[-1]["proprio"].copy())
    env.close()
    return np.stack(frames, 1)


def turns_of(layout, frames):
    """The three numbers of rotation in the states of an episode."""
    states = [conventions.state_of(layout, frames[0])]
    for frame in frames[1:]:
        states.append(conventions.state_of(layout, frame, states[-1]))
    return np.array(states)[:, 3:6]


@pytest.mark.parametrize("family", FAMILIES)
def test_states_do_not_jump_in_a_demonstration(family):
    """A jump is by pi or more; the hand of ShellGamePick really turns by 0.8 rad in a step."""
    for frames in frames_of(FAMILIES[family]):
        for layout in ("tcp7_continuous", "libero8", "libero_rpy8", "oxe8"):
            turns = turns_of(layout, frames)
            assert np.abs(np.diff(turns, axis=0)).max() < 1.5, layout
            assert turns[0, 0] > 0


def test_rotation_vectors_go_on_through_every_direction_of_the_hand():
    down = conventions.matrix_of(np.array([np.pi, 0, 0]))
    frames = []
    for turn in np.linspace(0, 5, 101):  # about an axis between the world's
        m = matrix_of_vector((turn + 1e-6) * np.array([0.6, 0.64, 0.48])) @ down
        angles = np.arctan2(m[2, 1], m[2, 2]), -np.arcsin(m[2, 0]), np.arctan2(m[1, 0], m[0, 0])
        frames.append([0, 0, 0, *angles, 0])
    turns = turns_of("libero8", np.array(frames, np.float32))
    angle = np.linalg.norm(turns, axis=-1, keepdims=True)
    whole = np.concatenate([np.cos(angle / 2), np.sin(angle / 2) * turns / angle], -1)
    assert ((whole[1:] * whole[:-1]).sum(-1) > np.cos(0.026)).all()  # half of 0.05 rad
    assert whole[0, 1] > 0.9
    assert whole[-1, 1] < 0  # in the other half by then


@pytest.mark.parametrize("convention", ["libero", "oxe"])
def test_actions_move_the_robot_as_the_convention_says(convention):
    """In the simulator: translation, turn and gripper, each in its own direction and amount."""
    metres, radians = {"libero": (0.05, 0.5), "oxe": (1, 1)}[convention]
    shut, wide = {"libero": (1, -1), "oxe": (0, 1)}[convention]

    def moved(action, steps=1):
        env = engram.make(TASK, pins={"robot_noise": [0] * 7}, freeze_cue=False)
        _, info = env.reset(seed=1)
        before = np.array(info["proprio"])
        sent = conventions.to_engram(convention, np.array([action], np.float64))[0]
        for _ in range(steps):
            info = env.step(sent.astype(np.float32))[-1]
        env.close()
        after = np.array(info["proprio"])
        turn = conventions.matrix_of(after[3:6]) @ conventions.matrix_of(before[3:6]).T
        return after[:3] - before[:3], turn, after[6]

    # Ten centimetres along x: the arm covers two fifths in a step (docs/robot.md).
    way, _, width = moved([0.1 / metres, 0, 0, 0, 0, 0, wide])
    assert 0.03 < way[0] < 0.045
    assert np.abs(way[1:]).max() < 0.01
    assert width == pytest.approx(0.08, abs=1e-3)
    # A turn by a tenth of a radian about each of the world's axes, counterclockwise.
    for axis in range(3):
        action = np.zeros(7)
        action[3 + axis], action[6] = 0.1 / radians, wide
        _, turn, _ = moved(action)
        vector = np.array([turn[2, 1], turn[0, 2], turn[1, 0]])
        assert 0.02 < vector[axis] < 0.06
        assert np.abs(np.delete(vector, axis)).max() < 0.015
    _, _, width = moved([0, 0, 0, 0, 0, 0, shut], steps=8)
    assert width < 0.005


def test_conventions_have_inverses():
    rng = np.random.default_rng(4)
    actions = rng.uniform(-1, 1, (50, 7))
    theirs = conventions.from_engram("libero", actions)
    assert np.allclose(conventions.to_engram("libero", theirs), actions)
    assert conventions.to_engram("mikasa", actions) is actions


def test_presets_are_whole():
    """Every preset names a layout and a convention, and slices of its state."""
    for protocol, presets in PRESETS.items():
        assert "mikasa" in presets
        for name, keys in presets.items():
            assert keys.layout in conventions.LAYOUTS, (protocol, name)
            assert keys.convention in conventions.ACTIONS
            width = 7 if keys.layout == "tcp7" else 8
            assert all(0 <= a < b <= width for a, b in keys.state.values())


def test_the_command_has_the_same_options():
    from pathlib import Path

    text = (Path(__file__).parents[3] / "apps" / "policy_server.cc").read_text()
    from engram.servers.options import flag_of

    assert all(f'"{flag_of(name)}"' in text for name in OPTIONS)
    assert text.count('{"--') == len(OPTIONS)
