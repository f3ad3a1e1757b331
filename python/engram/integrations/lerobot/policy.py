"""A policy of LeRobot as one of engram.evaluate."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from engram.datasets.spaces import ANGLES, CONTROL_MODE, Spaces
from engram.integrations.lerobot.vector_env import CAMERAS
from engram.integrations.periodic import Lockstep


class LeRobotPolicy(Lockstep):
    """Evaluates a policy of LeRobot, during its training or later.

    ::

        evaluation = PeriodicEvaluation("RememberColor3-VLA-v0", every=2_000, obs="rgb")
        evaluation(step, LeRobotPolicy(policy, preprocessor, postprocessor))

    Episodes begin together, with ``policy.reset()``: ``num_envs`` is the number of episodes, as
    PeriodicEvaluation has it, and ``threads`` is 1.

    Args:
        policy: A PreTrainedPolicy; it is in evaluation mode during a call, and as before after it.
        preprocessor, postprocessor: Its own, as of ``lerobot.policies.make_pre_post_processors``.
        angles: As of ``LeRobotEnv``.
    """

    def __init__(
        self,
        policy: Any,
        preprocessor: Callable[[Any], Any],
        postprocessor: Callable[[Any], Any],
        *,
        angles: str = ANGLES[0],
    ) -> None:
        super().__init__(self._actions)
        self._policy = policy
        self._processors = preprocessor, postprocessor
        self._angles = angles

    def _actions(self, seen: dict[str, Any], begins: np.ndarray) -> np.ndarray:
        import torch
        from lerobot.envs.utils import preprocess_observation

        if begins.all():
            self._policy.reset()
        proprio = seen["proprio"]
        spaces = Spaces(CONTROL_MODE, proprio.shape[1] == 8)
        images = {camera: seen["rgb"][..., 3 * i : 3 * i + 3] for i, camera in enumerate(CAMERAS)}
        state = spaces.proprio(proprio, self._angles)
        batch = preprocess_observation({"pixels": images, "agent_pos": state})
        batch["task"] = list(seen["instruction"])
        before, after = self._processors
        training = self._policy.training
        self._policy.eval()
        try:
            with torch.inference_mode():
                return after(self._policy.select_action(before(batch))).to("cpu").numpy()
        finally:
            self._policy.train(training)
