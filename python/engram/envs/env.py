"""One environment as a gymnasium.Env."""

from __future__ import annotations

from copy import deepcopy
from typing import TYPE_CHECKING, Any

import gymnasium
import numpy as np

from engram._args import options as option_args
from engram._args.keywords import check_single
from engram._args.methods import checked_actions
from engram.envs.compat import ObsT
from engram.envs.copies import Copier
from engram.envs.ended import ENDED
from engram.envs.spec import spec_of
from engram.envs.vector_env import VectorEnv
from engram.envs.window import Window
from engram.errors import BadStateError

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from engram.envs.mujoco_state import MujocoState
    from engram.typing import EnvOptions, ObsMode, Policy

METADATA = {"render_modes": ["human", "rgb_array"], "render_fps": 20}


class Env(gymnasium.Env[ObsT, np.ndarray]):
    """One environment: a batch of one, for code that cannot use batches.

    ``reset`` and ``step`` return copies. Episodes end by the task's rule (``terminated``) or at its
    horizon (``truncated``); then call ``reset``.

    Args:
        id: Task, such as "RememberColor9-VLA-v0".
        obs_mode: See ``VectorEnv``.
        **options: Those of ``VectorEnv``, except num_envs, autoreset_mode and copy.
            ``threads`` is 1, unless the environment is to be drawn by several. ``render_mode`` is
            None, unless it is "rgb_array" (``render`` returns an image) or "human" (a window shows
            every step; needs pygame).
    """

    metadata: dict[str, Any] = METADATA

    def __init__(
        self, id: str, *, obs_mode: ObsMode = "state", **options: Unpack[EnvOptions]
    ) -> None:
        check_single(type(self).__name__, options)
        self._arguments = {"id": option_args.task_id(id), "obs_mode": obs_mode, **options}
        self._window = None
        self.metadata = deepcopy(METADATA)
        allowed = self.metadata["render_modes"]
        self.render_mode = option_args.render_mode(options.get("render_mode"), allowed)
        given: Any = {"threads": 1, **options, "render_mode": self.render_mode and "rgb_array"}
        self.batch: VectorEnv[ObsT] = VectorEnv(
            id, 1, obs_mode=obs_mode, autoreset_mode="DISABLED", **given
        )
        self.seed: int = self.batch.seed
        self._observe = Copier()(_first(self.batch._observation))
        self._info = self.batch._infos.row_reader(0)
        views = self.batch._views
        self._reward, self._terminated, self._truncated = (
            views[name].item for name in ("reward", "terminated", "truncated")
        )
        self.observation_space = self.batch.single_observation_space
        self.action_space: Any = self.batch.single_action_space
        self._action_shape = self.batch._action_shape[1:]
        self.spec = spec_of(self._arguments, {"obs_mode": "state"})
        if self.render_mode == "human":
            self._window = Window(str(self), self.batch._render[1:], self.metadata["render_fps"])

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[ObsT, dict[str, Any]]:
        """Starts a new episode; ``options``: "pins" and "constants". See ``VectorEnv.reset``."""
        super().reset(seed=seed)
        self.batch.reset(seed=seed, options=options)
        return self._outputs()

    def step(self, action: Any) -> tuple[ObsT, float, bool, bool, dict[str, Any]]:
        """One control step (0.05 s). action: (action_dim,). See ``VectorEnv.step``."""
        array = checked_actions(action, self._action_shape)
        try:
            self.batch._batch.step(array[np.newaxis])
        except BadStateError as error:
            if not ENDED.search(str(error)):
                raise
            raise BadStateError(
                "the episode has ended; reset first, or make the environment with "
                'after_end="continue"'
            ) from None
        observation, info = self._outputs()
        return observation, self._reward(), self._terminated(), self._truncated(), info

    def act(self, policy: Policy = "oracle") -> np.ndarray:
        """An action for the next step, (action_dim,). See ``VectorEnv.act``."""
        return self.batch.act(policy)[0]

    # begin generated: queries (tools/surface, from api/surface.toml)
    def words(self) -> dict[str, Any]:
        """The episode in words: plan, subtask, memory, ... See ``VectorEnv.words``."""
        return self.batch.words()[0]

    def robot_state(self) -> dict[str, np.ndarray]:
        """The robot: qpos (9,), qvel (9,) and tcp_pose (7,). See ``VectorEnv.robot_state``."""
        return _first(self.batch.robot_state())

    # end generated

    def camera_params(
        self, size: int | tuple[int, int] | None = None
    ) -> dict[str, dict[str, np.ndarray]]:
        """Matrices by camera, such as extrinsic_cv (3, 4). See ``VectorEnv.camera_params``."""
        return {name: _first(camera) for name, camera in self.batch.camera_params(size).items()}

    def drawn(self) -> dict[str, Any]:
        """Values drawn for the episode, numbers or arrays by name. See ``VectorEnv.drawn``."""
        return _first(self.batch.drawn())

    def mujoco(self) -> MujocoState:
        """MuJoCo's state as it is now, for code written for it. See ``VectorEnv.mujoco``."""
        return self.batch.mujoco()

    def render(self) -> Any:
        """An image, uint8 (height, width, 3), in mode "rgb_array"; None otherwise."""
        return self.batch.frame(0) if self.render_mode == "rgb_array" else None

    def save(self) -> bytes:
        """The environment, bit-exactly."""
        return self.batch.save(0)

    def restore(self, data: bytes) -> tuple[ObsT, dict[str, Any]]:
        """Restores what ``save`` returned; returns the observation and infos at that point."""
        self.batch.restore(data, 0)
        return self._outputs()

    @property
    def language_instruction(self) -> str:
        """The instruction of the running episode."""
        return self.batch.instructions[0]

    task_description = language_instruction  # LeRobot's name for it

    @property
    def task(self) -> str:
        """Id of the task."""
        return self.batch.task_id

    @property
    def _max_episode_steps(self) -> int:
        return self.batch.envs[0].max_episode_steps

    def close(self) -> None:
        """Ends the environment."""
        if self._window is not None:
            self._window.close()
        self.batch.close()

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickling keeps the specification: the copy is new, not yet reset."""
        return _remake, (deepcopy(self._arguments),), {"spec": deepcopy(self.spec)}

    def __deepcopy__(self, memo: dict[int, Any]) -> Env[ObsT]:
        copy = _remake(deepcopy(self._arguments))
        copy.spec = deepcopy(self.spec)
        return copy

    def __repr__(self) -> str:
        return f"<engram.Env {self.batch._summary()}>"

    __str__ = __repr__

    def _outputs(self) -> tuple[ObsT, dict[str, Any]]:
        """Observation and infos; shows an image in the window, if there is one."""
        if self._window is not None:
            self._window.show(self.batch.frame(0))
        return self._observe(), self._info()


def _first(value: Any) -> Any:
    """The only row of an array, or of nested dicts of arrays."""
    if isinstance(value, dict):
        return {name: _first(part) for name, part in value.items()}
    return value[0]


def _remake(arguments: dict[str, Any]) -> Env[Any]:
    return Env(**arguments)
