"""Playback of an episode, forwards and backwards: its curves, and a picture of every step."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from engram.play import pictures
from engram.play.episode_spec import EpisodeSpec
from engram.play.phases import PhaseTrack

Actions = npt.NDArray[np.float32]
# Called with a batch and a flag, true in the first step; returns the actions of the next step.
Policy = Callable[[Any, bool], Actions]

_SNAPSHOT_INTERVAL = 8  # steps; those between snapshots are simulated again
_VIEW = (640, 480)
_SENSOR = (128, 128)


def recorded_policy(actions: Sequence[Actions]) -> Policy:
    """A policy that repeats these actions."""
    rest = iter(actions)
    return lambda _env, _first: next(rest)[None]


class Playback:
    """Runs an episode to its end, and shows any step of it afterwards."""

    def __init__(
        self,
        spec: EpisodeSpec,
        policy: Policy,
        *,
        ends_at_success: bool | None = None,
        most_steps: int | None = None,
        obs_mode: Any = "state",
    ) -> None:
        self.spec = spec
        self._batch = spec.make_batch(
            obs_mode=obs_mode, terminate_on_success=ends_at_success, privileged=True
        )
        try:
            self._run(policy, most_steps)
        except BaseException:
            self._batch.close()
            raise

    def _run(self, policy: Policy, most_steps: int | None) -> None:
        env = self._batch
        description: Any = env.description
        _, info = self.spec.reset(env)
        self.description = description
        self.instruction = env.instructions[0]
        self.actions: list[Actions] = []
        self._snapshots: list[bytes] = []
        self._rewards: list[float | None] = [None]
        self._successes = [False]
        self._answered: int | None = None
        proprio = [info_row(env, "proprio")]
        phases = PhaseTrack(env, info)
        ended = False
        while not ended and (most_steps is None or len(self.actions) < most_steps):
            if len(self.actions) % _SNAPSHOT_INTERVAL == 0:
                self._snapshots.append(env.save(0))
            action = np.asarray(policy(env, not self.actions), np.float32).copy()
            _, reward, terminated, truncated, info = env.step(action)
            self.actions.append(action[0])
            self._rewards.append(float(reward[0]))
            self._successes.append(bool(info["success"][0]))
            proprio.append(info_row(env, "proprio"))
            phases.add(info)
            if self._answered is None and "answered" in info and info["answered"][0]:
                self._answered = len(self.actions)
            ended = bool(terminated[0] or truncated[0])
        self._phases = phases.track
        self._proprio = np.array(proprio)
        self._last = {name: info[name][0] for name in _RESULT_FIELDS if name in info}

    def __len__(self) -> int:
        """Number of pictures: one before each step, and one at the end."""
        return len(self.actions) + 1

    def message(self) -> dict[str, Any]:
        """Curves and marks for the page, one value per picture."""
        last = self._last
        answered = bool(last.get("answered", False))
        return {
            "type": "playback",
            "id": self.spec.id,
            "seed": str(self.spec.seed),
            "instruction": self.instruction,
            "frames": len(self),
            "reward": _rounded(self._rewards),
            "tcp": [_rounded(row) for row in self._proprio[:, :3].tolist()],
            "gripper": _rounded(self._proprio[:, 6].tolist()),
            "command": _rounded([float(action[6]) for action in self.actions]),
            "success": [i for i, success in enumerate(self._successes) if success][:1],
            "answered": self._answered,
            "phases": [phase["name"] for phase in self.description["phases"]],
            "phase": self._phases,
            "result": {
                "success": bool(last["success_once"]),
                "first_answer_correct": bool(last["first_answer_correct"]) if answered else None,
                "return": float(last["episode_return"]),
                "steps": len(self.actions),
            },
        }

    def picture(self, frame: int) -> bytes:
        """The message that shows one step."""
        env = self._batch
        # The last picture is one step after the last action.
        snapshot = min(frame // _SNAPSHOT_INTERVAL, len(self._snapshots) - 1)
        env.restore(self._snapshots[snapshot], 0)
        for action in self.actions[snapshot * _SNAPSHOT_INTERVAL : frame]:
            env.step(action[None])
        sensors = np.concatenate(
            [env.frame(0, name, _SENSOR) for name in ("base_camera", "hand_camera")], axis=-1
        )
        return pictures.packed(
            {"kind": "playback", "n": frame},
            pictures.jpeg(env.frame(0, "render_camera", _VIEW)),
            pictures.sensors(sensors),
        )

    def close(self) -> None:
        self._batch.close()


_RESULT_FIELDS = ("success_once", "first_answer_correct", "answered", "episode_return")


def info_row(env: Any, name: str) -> npt.NDArray[np.float32]:
    """A copy of the first environment's output of that name."""
    row: npt.NDArray[np.float32] = env._views[name][0].copy()
    return row


def _rounded(values: Sequence[float | None]) -> list[float | None]:
    return [None if value is None else round(value, 4) for value in values]
