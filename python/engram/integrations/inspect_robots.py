"""An embodiment and tasks of inspect-robots.

from inspect_robots import eval
from engram.integrations.inspect_robots import EngramEmbodiment, make_task

id = "RememberColor3-VLA-v0"
(log,) = eval(make_task(id, episodes=50), policy, EngramEmbodiment(id))
"""

from __future__ import annotations

from typing import Any

import numpy as np
from inspect_robots.embodiment import (
    PRIVILEGED_SUCCESS,
    RENDERABLE,
    RESETTABLE,
    SEEDABLE,
    EmbodimentBase,
    EmbodimentInfo,
)
from inspect_robots.scene import Scene
from inspect_robots.scorer import success_at_end
from inspect_robots.spaces import (
    ActionSemantics,
    Box,
    CameraSpec,
    ObservationSpace,
    StateField,
    StateSpec,
)
from inspect_robots.task import Task
from inspect_robots.types import Action, Observation, StepResult

from engram import _core
from engram.datasets.spaces import CONTROL_MODE, CONTROL_RATE, Spaces
from engram.errors import InvalidArgumentError
from engram.factory import make
from engram.tasks import describe

CAMERAS = ("base_camera", "hand_camera")
# Their name there, and how they write rotations.
_MODES = {
    "pd_ee_delta_pose": ("eef_delta_pose", "axis_angle"),
    "pd_ee_delta_pos": ("eef_delta_pos", "none"),
    "pd_joint_delta_pos": ("joint_delta", "none"),
    "pd_joint_pos": ("joint_pos", "none"),
}
_DOCS = """\
A Franka Panda with a two-finger gripper at a table. World frame: x away from the robot, y to its
left, z up; metres and radians. The hand points down at rest.
Translations of 1 ask for 0.1 m in a step, rotations of 1 for -0.1 rad about the world's axes (a
positive number turns the negative way), changes of joints of 1 for 0.1 rad; a step reaches about
two fifths of that. Gripper: 1 open, -1 closed; 0 half closes it, so send 1 to keep it open.
Until a cue is over, actions of some tasks are replaced by zeros. What was shown has to be
remembered: it is not shown again.
"""


class EngramEmbodiment(EmbodimentBase):  # type: ignore[misc]
    """A task of engram as a simulated robot.

    A scene's ``init_seed`` is the seed of the episode; without one it is the seed of the reset. The
    last step of an episode that has succeeded at any time is terminated with the reason "success".

    Args:
        id: Task.
        control_mode: pd_ee_delta_pose, pd_ee_delta_pos, pd_joint_delta_pos or pd_joint_pos.
        **options: Others of ``engram.make``, except obs_mode.
    """

    def __init__(self, id: str, *, control_mode: str = CONTROL_MODE, **options: Any) -> None:
        if control_mode not in _MODES:
            raise InvalidArgumentError(
                f"control_mode: {control_mode!r} given, {', '.join(_MODES)} allowed"
            )
        joints = options.setdefault("joint_proprio", control_mode == "pd_joint_pos")
        given: Any = {"control_mode": control_mode, **options}
        self._env: Any = make(id, obs_mode="rgb", **given)
        self._instruction = ""
        self.info = _info(id, self._env, Spaces(control_mode, bool(joints)))

    def reset(self, scene: Scene, *, seed: int | None = None) -> Observation:
        """Begins the episode of the scene."""
        seen, _ = self._env.reset(seed=seed if scene.init_seed is None else scene.init_seed)
        self._instruction = self._env.unwrapped.language_instruction
        return self._observation(seen)

    def step(self, action: Action) -> StepResult:
        """One control step of 0.05 s."""
        data = np.asarray(action.data, np.float32)
        seen, reward, terminated, truncated, info = self._env.step(data)
        succeeded = bool(info["success_once"])
        solved = succeeded and (terminated or truncated)
        return StepResult(
            observation=self._observation(seen),
            reward=float(reward),
            terminated=bool(terminated or solved),
            termination_reason="success" if solved else "failure" if terminated else None,
            truncated=bool(truncated and not solved),
            info={"success": succeeded},
        )

    def close(self) -> None:
        """Ends the environment."""
        self._env.close()

    def _observation(self, seen: dict[str, Any]) -> Observation:
        images = {name: seen["rgb"][..., 3 * i : 3 * i + 3] for i, name in enumerate(CAMERAS)}
        state = {"proprio": np.asarray(seen["proprio"], np.float64)}
        return Observation(images=images, state=state, instruction=self._instruction)


def _info(id: str, env: Any, spaces: Spaces) -> EmbodimentInfo:
    mode, rotation = _MODES[spaces.control_mode]
    height, width, _ = env.observation_space["rgb"].shape
    proprio = StateField("proprio", (len(spaces.proprio_names),), "m, rad", "float64")
    return EmbodimentInfo(
        name=f"engram/{id}",
        action_space=Box(
            env.action_space.shape,
            env.action_space.low.astype(np.float64),
            env.action_space.high.astype(np.float64),
            ActionSemantics(mode, rotation, "continuous", "world", spaces.action_names),
        ),
        observation_space=ObservationSpace(
            cameras=tuple(CameraSpec(name, height, width) for name in CAMERAS),
            state=StateSpec((proprio,)),
        ),
        control_hz=float(CONTROL_RATE),
        is_simulated=True,
        capabilities=frozenset({SEEDABLE, RESETTABLE, RENDERABLE, PRIVILEGED_SUCCESS}),
        docs=f"{_DOCS}`proprio`: {', '.join(spaces.proprio_names)}.",
        environment_id="engram",
        environment_revision=_core.version(),
    )


def make_task(id: str, *, episodes: int = 50, seed: int = 4242424242) -> Task:
    """The protocol's episodes of a task: scene i has the seed ``seed`` + i."""
    description = describe(id)
    scenes = [
        Scene(id=f"{id}-{seed + i}", instruction=description["instruction"], init_seed=seed + i)
        for i in range(episodes)
    ]
    return Task(id, scenes, success_at_end(), max_steps=description["horizon"])
