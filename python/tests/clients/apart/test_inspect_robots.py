"""inspect-robots as released: its conformance module, and evaluations by its own program."""

from __future__ import annotations

import pytest

pytest.importorskip("inspect_robots")

import numpy as np
from doc_blocks import groups
from inspect_robots.conformance import assert_embodiment_conformant
from inspect_robots.eval import eval as evaluate
from inspect_robots.policy import PolicyBase, PolicyInfo
from inspect_robots.types import Action, ActionChunk

import engram
from engram.integrations.inspect_robots import EngramEmbodiment, make_task

MODES = ("pd_ee_delta_pose", "pd_ee_delta_pos", "pd_joint_delta_pos", "pd_joint_pos")


class Player(PolicyBase):
    """One of engram's own policies."""

    def __init__(self, embodiment, name):
        self.embodiment, self.name, self.seen = embodiment, name, []
        self.info = PolicyInfo(name, embodiment.info.action_space)

    def act(self, observation):
        self.seen.append(observation)
        return ActionChunk([Action(self.embodiment._env.act(self.name))])


@pytest.mark.parametrize("mode", MODES)
def test_it_is_conformant(mode):
    embodiment = EngramEmbodiment("RememberColor3-VLA-v0", control_mode=mode)
    assert_embodiment_conformant(embodiment.info)
    embodiment.close()


@pytest.mark.parametrize("id", ["RememberColor3-VLA-v0", "ShellGameTouch-VLA-v0"])
@pytest.mark.parametrize("name", ["oracle", "sweep"])
def test_an_evaluation_counts_as_engram_does(id, name, tmp_path):
    embodiment = EngramEmbodiment(id)
    policy = Player(embodiment, name)
    (log,) = evaluate(make_task(id, episodes=4), policy, embodiment, log_dir=str(tmp_path))
    embodiment.close()
    assert log.status == "success"
    expected = []
    env = engram.make(id, obs_mode="rgb")
    for i in range(4):
        seen, _ = env.reset(seed=4242424242 + i)
        if i == 0:
            first = policy.seen[0]
            np.testing.assert_array_equal(first.images["base_camera"], seen["rgb"][..., :3])
            np.testing.assert_array_equal(first.images["hand_camera"], seen["rgb"][..., 3:])
            np.testing.assert_array_equal(first.state["proprio"], seen["proprio"])
            assert first.instruction == env.unwrapped.language_instruction
        over = False
        while not over:
            _, _, terminated, truncated, info = env.step(env.act(name))
            over = terminated or truncated
        expected.append(bool(info["success_once"]))
    env.close()
    assert log.results.metrics["success_at_end"] == np.mean(expected)


def test_the_block_of_its_page_runs(tmp_path):
    (block,) = [b for group in groups() for b in group if b.elsewhere == "inspect_robots"]
    assert block.run(tmp_path).splitlines()[-1] == "0.0"


def test_other_modes_are_refused():
    with pytest.raises(engram.InvalidArgumentError, match="control_mode: 'pd_ee_pose' given"):
        EngramEmbodiment("RememberColor3-VLA-v0", control_mode="pd_ee_pose")
