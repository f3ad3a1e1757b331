"""A batch as a native environment of PufferLib."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import gymnasium
import numpy as np
import pufferlib

from engram._args.keywords import check_single
from engram.envs.compat import AutoresetMode
from engram.envs.vector_env import VectorEnv
from engram.errors import InvalidArgumentError

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from engram.typing import EnvOptions, ObsMode


class PufferVecEnv(pufferlib.PufferEnv):  # type: ignore[misc]  # it has no types
    """engram's batch in PufferLib's conventions: its environments are the agents.

    Observations, rewards and endings are written to PufferLib's own buffers. An environment whose
    episode ends starts the next one in the same step. That step's infos hold one dict with the
    means over the episodes that ended: "episode_return", "episode_length" and "success_once".

    Environment i has the seed ``seed * num_envs + i``, so that the workers of
    ``pufferlib.vector.Multiprocessing``, which have consecutive seeds, play different episodes.

    Args:
        id: Task, such as "RememberColor3-VLA-v0".
        num_envs: Number of environments.
        obs_mode: One whose observations are one array: "state", "objects" or "none". PufferLib's
            emulation takes single environments of the others.
        buf: PufferLib's buffers, from its vectorization.
        **options: Those of ``VectorEnv``, except autoreset_mode and copy.
    """

    def __init__(
        self,
        id: str,
        num_envs: int = 1,
        *,
        obs_mode: ObsMode = "state",
        buf: Any = None,
        **options: Unpack[EnvOptions],
    ) -> None:
        check_single("PufferVecEnv", options, own=("num_envs", "buf"))
        seed = options.get("seed")
        if not isinstance(seed, (tuple, list)):
            options["seed"] = self._first_seed(seed, num_envs)
        mode: Any = AutoresetMode.SAME_STEP
        self.batch: VectorEnv[Any] = VectorEnv(
            id, num_envs, obs_mode=obs_mode, autoreset_mode=mode, copy=False, **options
        )
        if not isinstance(self.batch.single_observation_space, gymnasium.spaces.Box):
            self.batch.close()
            raise InvalidArgumentError(
                f"obs_mode: {obs_mode!r} given; 'state', 'objects' or 'none' needed, whose "
                "observations are one array"
            )
        self.single_observation_space = self.batch.single_observation_space
        self.single_action_space = self.batch.single_action_space
        self.num_agents = self.agents_per_batch = num_envs  # the latter for recurrent policies
        super().__init__(buf)

    def __repr__(self) -> str:
        return f"<engram.integrations.pufferlib.PufferVecEnv of {self.batch!r}>"

    def reset(self, seed: int | None = None) -> tuple[np.ndarray, list[dict[str, float]]]:
        """Starts new episodes: observations and infos."""
        first = self._first_seed(seed, self.num_agents)
        self.observations[:], _ = self.batch.reset(seed=first)
        self.rewards[:] = 0
        self.terminals[:] = self.truncations[:] = False
        return self.observations, []

    def step(self, actions: Any) -> tuple[Any, Any, Any, Any, list[dict[str, float]]]:
        """Steps all environments: observations, rewards, terminals, truncations, infos."""
        observation, reward, terminated, truncated, info = self.batch.step(actions)
        self.observations[:], self.rewards[:] = observation, reward
        self.terminals[:], self.truncations[:] = terminated, truncated
        buffers = self.observations, self.rewards, self.terminals, self.truncations
        return *buffers, self._episodes(terminated | truncated) if "final_info" in info else []

    @staticmethod
    def _first_seed(seed: int | None, num_envs: int) -> int | None:
        return None if seed is None else seed * num_envs

    def _episodes(self, ended: np.ndarray) -> list[dict[str, float]]:
        views = self.batch._infos.final_views
        names = {"episode_length": "elapsed_steps"}
        wanted = ("episode_return", "episode_length", "success_once")
        return [{name: float(views[names.get(name, name)][ended].mean()) for name in wanted}]

    def close(self) -> None:
        """Ends the batch."""
        self.batch.close()
