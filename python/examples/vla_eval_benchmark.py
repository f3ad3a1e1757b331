"""engram as a benchmark of vla-evaluation-harness (the package vla-eval).

    # eval.yaml
    benchmarks:
      - benchmark: "vla_eval_benchmark:EngramBenchmark"
        params: {tasks: [RememberColor3-VLA-v0, ShellGameTouch-VLA-v0]}

with this file on PYTHONPATH. The protocol is the benchmark's own: episode i has seed
4242424242 + i, an episode succeeds if it did so in any step, and the policy sees rgb, proprio and
the instruction only.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from vla_eval.benchmarks.base import StepBenchmark, StepResult
from vla_eval.specs import GRIPPER_RAW, IMAGE_RGB, LANGUAGE, POSITION_DELTA, DimSpec

import engram

START_SEED = 4242424242


class EngramBenchmark(StepBenchmark):
    """The tasks of engram in the canonical configuration.

    Args:
        tasks: Ids; default: all of ``split``.
        split: "short", "medium" or "long".
        start_seed: Seed of the first episode.
    """

    render_backends = frozenset({"cpu", "gpu"})  # images are made on the CPU in either

    def __init__(
        self,
        tasks: list[str] | None = None,
        split: str = "short",
        start_seed: int = START_SEED,
    ) -> None:
        super().__init__()
        self._horizons = {task["id"]: task["horizon"] for task in engram.list()}
        self._tasks = tasks or [
            task["id"] for task in engram.list() if task["split"] == split and task["canonical"]
        ]
        self._start_seed = start_seed
        self._env: engram.Env | None = None
        self._instruction = ""

    @classmethod
    def configure_render(cls, mode: str) -> dict[str, str]:
        """Nothing to choose."""
        return {}

    def get_tasks(self) -> list[dict[str, Any]]:
        """One entry per id."""
        return [{"name": task, "max_steps": self._horizons[task]} for task in self._tasks]

    def reset(self, task: dict[str, Any]) -> Any:
        """Starts the episode that ``task["episode_idx"]`` counts."""
        if self._env is None or self._env.task != task["name"]:
            self.cleanup()
            self._env = engram.make(task["name"], obs_mode="rgb")
        obs, _ = self._env.reset(seed=self._start_seed + int(task.get("episode_idx", 0)))
        self._instruction = self._env.language_instruction
        return obs

    def step(self, action: dict[str, Any]) -> StepResult:
        """One action of seven numbers; the controller clips, as upstream's does."""
        assert self._env is not None
        values = np.asarray(action.get("actions", action.get("action")), np.float32).ravel()
        obs, reward, terminated, truncated, info = self._env.step(values)
        result = {"success": info["success_once"]}
        return StepResult(obs=obs, reward=reward, done=terminated or truncated, info=result)

    def make_obs(self, raw_obs: Any, task: dict[str, Any]) -> dict[str, Any]:
        """Both cameras, proprio and the instruction."""
        rgb = raw_obs["rgb"]
        images = {"base_camera": rgb[..., :3].copy(), "hand_camera": rgb[..., 3:].copy()}
        return {
            "images": images,
            "task_description": self._instruction,
            "state": raw_obs["proprio"],
        }

    def get_step_result(self, step_result: StepResult) -> dict[str, Any]:
        """Success at any time of the episode."""
        return {"success": bool(step_result.info.get("success", False))}

    def get_metadata(self) -> dict[str, Any]:
        """The longest horizon; each task's own is in its entry."""
        return {"max_steps": max(self._horizons[task] for task in self._tasks)}

    def get_hold_action(self, last_action: Any) -> dict[str, Any]:
        """Holds the arm; the gripper value 1 keeps it open (0 would half close it)."""
        return {"actions": np.array([0, 0, 0, 0, 0, 0, 1], np.float32)}

    def get_action_spec(self) -> dict[str, DimSpec]:
        """pd_ee_delta_pose: position, rotation (sign as upstream), gripper (1 opens)."""
        return {
            "position": POSITION_DELTA,
            "rotation": DimSpec("rotation", 3, "mikasa_inverted_rotation_vector", (-1, 1)),
            "gripper": GRIPPER_RAW,
        }

    def get_observation_spec(self) -> dict[str, DimSpec]:
        """Observation of ``make_obs``."""
        return {
            "base_camera": IMAGE_RGB,
            "hand_camera": IMAGE_RGB,
            "state": DimSpec("state", 7, "eef_pos3_rpy3_gripper1"),
            "language": LANGUAGE,
        }

    def cleanup(self) -> None:
        """Ends the environment."""
        if self._env is not None:
            self._env.close()
            self._env = None
