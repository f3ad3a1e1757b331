"""The oracle through every protocol: the same bytes as without a server."""

from __future__ import annotations

import json

import numpy as np
import pytest
from policy_servers import (
    TASK,
    engram_serve,
    observation,
    openpi_server,
    results_of,
    run_engram,
    without_name,
)

import engram
from engram.servers import ServerError, ServerPolicy

TASKS = (TASK, "ShellGameTouch-VLA-v0", "BlinkCountButtonPressEasy-VLA-v0")
PROTOCOLS = ("openpi", "gr00t", "act")


@pytest.fixture(scope="module")
def own():
    """Results without a server, by policy."""
    return {
        policy: without_name(
            results_of("eval", *TASKS, "--episodes", "5", "--obs", "rgb", "--policy", policy)
        )
        for policy in ("oracle", "blind", "sweep")
    }


@pytest.mark.parametrize("protocol", PROTOCOLS)
def test_results_of_the_command_are_the_same_bytes(protocol, own):
    with engram_serve("--policy", "oracle", "--protocol", protocol) as url:
        server = ("--policy-server", url, "--tell-episodes")
        through = results_of("eval", *TASKS, "--episodes", "5", *server)
    assert through["tasks"][0]["model"]["config"]["server"] == url
    assert without_name(through) == own["oracle"]


@pytest.mark.parametrize("policy", ["blind", "sweep"])
def test_other_policies(policy, own):
    with engram_serve("--policy", policy) as url:
        server = ("--policy-server", url, "--tell-episodes")
        assert without_name(results_of("eval", *TASKS, "--episodes", "5", *server)) == own[policy]


@pytest.mark.parametrize("protocol", PROTOCOLS)
def test_chunks_of_which_a_part_is_used(protocol, own):
    """And all frames, of which the oracle needs none."""
    with engram_serve("--policy", "oracle", "--protocol", protocol, "--chunk", "16") as url:
        for query, longest in (("replan=5", 5), ("history=since-last", 1), ("history=3,2", 1)):
            result = engram.evaluate(
                f"{url}?{query}", TASKS, episodes=5, tell_episodes=True, threads=2
            )
            assert result["tasks"][0]["action_chunk_size"] == longest
            assert [task.pop("action_chunk_size") for task in result["tasks"]]
            expected = json.loads(own["oracle"])
            assert [task.pop("action_chunk_size") for task in expected["tasks"]]
            # Digests are of questions and answers, which are others: but for the first question.
            for task, same in zip(result["tasks"], expected["tasks"]):
                digests = task.pop("digests"), same.pop("digests")
                assert digests[0]["first_observations"] == digests[1]["first_observations"]
            assert without_name(result) == json.dumps(expected)


@pytest.mark.parametrize(
    ("protocol", "keys", "mode"),
    [
        ("openpi", "droid", "pd_joint_pos"),
        ("gr00t", "mikasa", "pd_joint_delta_pos"),
        ("act", "mikasa", "pd_joint_pos"),
    ],
)
def test_joint_space(protocol, keys, mode):
    """Actions of 8 and states of 8."""
    joints = ("--control-mode", mode, "--joint-proprio")
    words = ("eval", *TASKS, "--episodes", "3", "--obs", "rgb", *joints)
    own = results_of(*words, "--policy", "oracle")
    assert {task["control_mode"] for task in own["tasks"]} == {mode}
    served = ("--policy", "oracle", "--protocol", protocol, "--server-keys", keys)
    with engram_serve(*served, *joints) as url:
        server = ("--policy-server", url, "--tell-episodes", "--server-keys", keys)
        through = results_of(*words, *server, "--server-state", "joints8")
    assert without_name(through) == without_name(own)


def test_a_client_with_another_proprio_is_told():
    words = ("eval", TASK, "--episodes", "1", "--joint-proprio", "--server-state", "joints8")
    with engram_serve("--policy", "oracle") as url:
        done = run_engram(*words, "--policy-server", url, "--tell-episodes")
    assert done.returncode == 1
    assert "proprio of 8 numbers given, 7 needed; engram serve needs --joint-proprio" in done.stderr


@pytest.mark.long
@pytest.mark.parametrize("protocol", PROTOCOLS)
def test_all_tasks(protocol):
    """In chunks of 8, from the state, which is faster to send than pictures."""
    tasks = [task["id"] for task in engram.list()][:97]  # other tests register more
    words = ("eval", *tasks, "--episodes", "2", "--obs", "state")
    own = results_of(*words, "--policy", "oracle")
    with engram_serve("--policy", "oracle", "--protocol", protocol, "--chunk", "8") as url:
        through = results_of(*words, "--policy-server", url, "--tell-episodes")
    assert {task.pop("action_chunk_size") for task in through["tasks"]} == {8}
    assert {task.pop("action_chunk_size") for task in own["tasks"]} == {1}
    for task in (*through["tasks"], *own["tasks"]):
        del task["digests"]  # of questions and answers: chunks are other answers
    assert without_name(through) == without_name(own)


def test_rules_and_constants_are_those_of_the_client():
    changed = ("--rules", "original", "--set", "EMPTY_PHASE_STEPS=2,3")
    words = ("eval", TASK, "--episodes", "3", "--obs", "rgb", *changed)
    with engram_serve("--policy", "oracle", *changed) as url:
        through = results_of(*words, "--policy-server", url, "--tell-episodes")
    assert without_name(through) == without_name(results_of(*words, "--policy", "oracle"))


def test_record(tmp_path):
    """An episode's picture is that of the oracle."""
    words = ("record", TASK, "--seed", "4242424242", "--at", "24", "--size", "64")
    with engram_serve("--policy", "oracle", "--chunk", "4") as url:
        server = ("--policy-server", url, "--tell-episodes")
        report = results_of(*words, "--out", str(tmp_path / "a.png"), *server)
    assert report["action_chunk_size"] == 4
    assert report["model"]["config"]["server"] == url
    own = results_of(*words, "--out", str(tmp_path / "b.png"), "--policy", "oracle")
    assert report["success_once"] is own["success_once"]
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()


def test_an_episode_that_is_not_told_is_refused():
    with engram_serve("--policy", "oracle", "--protocol", "act") as url:
        done = run_engram("eval", TASK, "--episodes", "1", "--policy-server", url)
    assert done.returncode == 1
    assert "reports: oracle needs env_id, seed and step of the episode" in done.stderr
    assert done.stderr.count("\n") == 1


def test_a_client_that_changes_the_actions_is_told_so():
    """Here: one that takes the gripper's sign for LIBERO's."""
    with engram_serve("--policy", "oracle") as url, pytest.raises(ServerError) as caught:
        engram.evaluate(f"{url}?actions=libero", TASK, episodes=1, tell_episodes=True)
    assert "the client's robot is elsewhere than this policy has moved it" in str(caught.value)


def test_a_learnt_policy(tmp_path):
    """A function of the user's, over a server: the same results as without one."""
    (tmp_path / "mine.py").write_text(
        "import numpy as np\n"
        "class Mine:\n"
        "    def __init__(self, scale):\n"
        "        self.scale, self.seen = scale, {}\n"
        "    @classmethod\n"
        "    def load(cls, file):\n"
        "        return cls(float(open(file).read()))\n"
        "    def __call__(self, o):\n"
        "        actions = np.zeros((len(o['first']), 7), np.float32)\n"
        "        for i, first in enumerate(o['first']):\n"
        "            name = o['worker'], o['slot'][i]\n"
        "            light = o['rgb'][i].mean() / 255 + o['proprio'][i].sum()\n"
        "            self.seen[name] = light + (0 if first else 0.5 * self.seen[name])\n"
        "            actions[i] = self.scale * np.sin(self.seen[name] * np.arange(7))\n"
        "        return actions\n"
    )
    (tmp_path / "agent.pt").write_text("0.7")
    loader = f"{tmp_path / 'mine.py'}:Mine.load"
    import importlib.util

    spec = importlib.util.spec_from_file_location("mine", tmp_path / "mine.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    own = engram.evaluate(module.Mine(0.7), TASK, episodes=4, num_envs=3)
    for protocol in PROTOCOLS:
        words = ("--policy", str(tmp_path / "agent.pt"), "--loader", loader)
        with engram_serve(*words, "--protocol", protocol) as url:
            through = engram.evaluate(url, TASK, episodes=4, num_envs=3)
            # Two bridges, whose sessions have to be apart.
            command = results_of(
                "eval", TASK, "--episodes=4", "--num-envs=2", "--threads=2", "--policy-server", url
            )
        for results in (through, command):
            assert results["tasks"][0]["returns"] == own["tasks"][0]["returns"]


def test_serve_refuses_in_a_sentence(tmp_path):
    for words, message in (
        (("--policy", "agent.pt"), "--policy: 'agent.pt' given; oracle, sweep"),
        (("--policy", "agent.pt", "--loader", "x"), "--loader: 'x' given, FILE.py:NAME needed"),
        (("--policy", "agent.pt", "--loader", "no.py:f"), "there is no file 'no.py'"),
        (("--policy", "oracle", "--port", "70000"), "a whole number from 0 to 65535 needed"),
        (("--policy", "oracle", "--server-keys", "x"), "keys: 'x' given; mikasa, libero"),
        (("--policy", "oracle", "--set", "A"), "--set: 'A' given, NAME=VALUE needed"),
    ):
        done = run_engram("serve", *words)
        assert done.returncode == 2, words
        assert message in done.stderr


def test_a_fresh_queue_for_each_episode():
    """Actions that are left of a chunk are not used in the next episode."""
    asked = []

    def act(request):
        asked.append(request["observation/state"])
        return np.full((16, 7), len(asked), np.float32)

    with openpi_server(act) as url:
        policy = ServerPolicy(url, history="since-last")
        for step in range(3):
            assert policy(observation(step=step))[0].tolist() == [[1] * 7]
        assert policy(observation(step=0))[0].tolist() == [[2] * 7]  # another episode
        assert [len(states) for states in asked] == [1, 1]
        policy.close()
