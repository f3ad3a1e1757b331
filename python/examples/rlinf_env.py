"""An environment in the shape of RLinf 0.3.0.

That package has a list of its environments: add ``ENGRAM = "engram"`` and this class to
``rlinf/envs/__init__.py``.

The configuration has ``seed``, ``group_size`` (episodes that GRPO compares), ``auto_reset``,
``ignore_terminations``, ``use_rel_reward`` and ``init_params``: id and options of engram.make_vec.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import torch

import engram


class EngramEnv:
    """N environments; a chunk of K actions is a tensor (N, K, 7)."""

    def __init__(
        self,
        cfg: Any,
        num_envs: int,
        seed_offset: int,
        total_num_processes: int,
        worker_info: Any,
        record_metrics: bool = True,
    ) -> None:
        options = {"obs_mode": "rgb", "autoreset_mode": "DISABLED", **cfg.init_params}
        # Processes with different offsets play different episodes.
        batch = engram.make_vec(num_envs=num_envs, seed=(cfg.seed, seed_offset), **options)
        self.env = engram.wrappers.EqualStarts(batch, cfg.group_size)
        self.cfg, self.num_envs, self.is_start = cfg, num_envs, True
        self.group_size, self.num_group = cfg.group_size, num_envs // cfg.group_size
        self.device = torch.device("cpu")
        self._record = record_metrics
        self._reward = np.zeros(num_envs, np.float32)
        self._return = np.zeros(num_envs, np.float32)
        self.elapsed_steps = np.zeros(num_envs, np.int64)

    def update_reset_state_ids(self) -> None:
        """Nothing: each reset begins the next episodes of the groups."""

    def reset(self, *, seed: Any = None, options: Any = None) -> tuple[dict[str, Any], dict]:
        """Begins the next episodes; options: {"env_idx": those that begin}."""
        which = np.ones(self.num_envs, bool)
        if options and "env_idx" in options:
            which[:] = False
            which[np.asarray(options["env_idx"])] = True
        mask = None if which.all() else {"reset_mask": which}
        seen, info = self.env.reset(seed=seed, options=mask)
        self._reward[which] = self._return[which] = 0
        self.elapsed_steps[which] = 0
        return self._observation(seen), self._infos(info)

    def step(self, actions: Any = None, auto_reset: bool = True) -> tuple[Any, ...]:
        """Observations, rewards, terminations, truncations (N,), and infos."""
        seen, _, _, truncated, info = self.env.step(np.asarray(actions, np.float32))
        success = info["success_once"]
        reward = success - self._reward if self.cfg.use_rel_reward else success.astype(np.float32)
        self._reward = success.astype(np.float32)
        self._return += reward
        self.elapsed_steps += 1
        ends = np.zeros_like(success) if self.cfg.ignore_terminations else success
        observation, infos = self._observation(seen), self._infos(info)
        ended = ends | truncated
        if auto_reset and self.cfg.auto_reset and ended.any():
            observation, infos = self._begin_again(ended, observation, infos)
        flags = (torch.tensor(ends), torch.tensor(truncated))
        return observation, torch.tensor(reward), *flags, infos

    def chunk_step(self, chunk_actions: Any) -> tuple[Any, ...]:
        """Lists of observations and infos; rewards, terminations and truncations (N, K)."""
        steps = [self.step(actions, auto_reset=False) for actions in np.moveaxis(
            np.asarray(chunk_actions, np.float32), 1, 0)]  # fmt: skip
        seen, rewards, ends, truncations, infos = map(list, zip(*steps))
        past = [torch.stack(flags, 1).any(1) for flags in (ends, truncations)]
        ended = (past[0] | past[1]).numpy()
        if self.cfg.auto_reset and ended.any():
            seen[-1], infos[-1] = self._begin_again(ended, seen[-1], infos[-1])
        flags = [torch.zeros(self.num_envs, len(steps), dtype=torch.bool) for _ in past]
        for flag, whole in zip(flags, past):
            flag[:, -1] = whole
        return seen, torch.stack(rewards, 1), *flags, infos

    def _begin_again(self, ended: np.ndarray, seen: Any, infos: Any) -> tuple[Any, Any]:
        first, begun = self.reset(options={"env_idx": np.flatnonzero(ended)})
        marks = {f"_{key}": torch.tensor(ended) for key in ("final_observation", "final_info")}
        return first, {**begun, "final_observation": seen, "final_info": infos, **marks}

    def _observation(self, seen: dict[str, Any]) -> dict[str, Any]:
        rgb = torch.tensor(seen["rgb"])
        return {
            "main_images": rgb[..., :3],
            "wrist_images": rgb[..., 3:],
            "states": torch.tensor(seen["proprio"]),
            "task_descriptions": list(self.env.unwrapped.instructions),
        }

    def _infos(self, info: dict[str, Any]) -> dict[str, Any]:
        success = torch.tensor(info["success_once"])
        episode = {
            "success_once": success,
            "return": torch.tensor(self._return),
            "episode_len": torch.tensor(self.elapsed_steps),
        }
        return {"success": success, **({"episode": episode} if self._record else {})}
