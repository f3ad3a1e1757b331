"""Playback of an episode, forwards and backwards: its curves, and a picture of every step."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from engram.datasets.checks import MAX_STEPS
from engram.play import pictures
from engram.play.episode_spec import EpisodeSpec
from engram.play.phases import PhaseTrack

Actions = npt.NDArray[np.float32]
# Called with a batch and a flag, true in the first step; returns the actions of the next step.
Policy = Callable[[Any, bool], Actions]

MOST_STEPS = MAX_STEPS  # of an episode that is shown, however long it is
_SNAPSHOT_INTERVAL = 8  # steps; those between snapshots are simulated again
_VIEW = (640, 480)
_SENSOR = (128, 128)


def recorded_policy(actions: Sequence[Actions]) -> Policy:
    """A policy that repeats these actions."""
    rest = iter(actions)
    return lambda _env, _first: next(rest)[None]


class Playback:
    """Runs an episode by and by, and shows any step of it afterwards."""

    def __init__(
        self,
        spec: EpisodeSpec,
        policy: Policy,
        *,
        ends_at_success: bool | None = None,
        most_steps: int | None = None,
        obs_mode: Any = "state",
        recorded: tuple[bool, int] | None = None,
    ) -> None:
        """recorded: success and steps of the same episode, played before."""
        self.spec = spec
        self._policy = policy
        self._recorded = recorded
        self._batch = spec.make_batch(
            obs_mode=obs_mode, terminate_on_success=ends_at_success, privileged=True
        )
        try:
            self._begin(most_steps)
        except BaseException:
            self._batch.close()
            raise

    def _begin(self, most_steps: int | None) -> None:
        env = self._batch
        description: Any = env.description
        _, self._info = self.spec.reset(env)
        self.description = description
        self.instruction = env.instructions[0]
        self.steps = min(description["horizon"], most_steps or MOST_STEPS, MOST_STEPS)
        self.actions: list[Actions] = []
        self._snapshots: list[bytes] = []
        self._rewards: list[float | None] = [None]
        self._successes = [False]
        self._answered: int | None = None
        self._proprio = [info_row(env, "proprio")]
        self._phases = PhaseTrack(env, self._info)
        self._ended = False

    def run(self, seconds: float = math.inf) -> bool:
        """Goes on for that time; True at the end of the episode, or of what is shown of it."""
        until = time.monotonic() + seconds
        while not self.complete and time.monotonic() < until:
            self._step()
        return self.complete

    @property
    def complete(self) -> bool:
        """True if all steps have been played."""
        return self._ended or len(self.actions) >= self.steps

    def _step(self) -> None:
        env = self._batch
        if len(self.actions) % _SNAPSHOT_INTERVAL == 0:
            self._snapshots.append(env.save(0))
        action = np.asarray(self._policy(env, not self.actions), np.float32).copy()
        _, reward, terminated, truncated, info = env.step(action)
        self.actions.append(action[0])
        self._rewards.append(float(reward[0]))
        self._successes.append(bool(info["success"][0]))
        self._proprio.append(info_row(env, "proprio"))
        self._phases.add(info)
        if self._answered is None and "answered" in info and info["answered"][0]:
            self._answered = len(self.actions)
        self._ended = bool(terminated[0] or truncated[0])
        self._info = info

    def __len__(self) -> int:
        """Number of pictures: one before each step, and one at the end."""
        return len(self.actions) + 1

    def message(self) -> dict[str, Any]:
        """Curves and marks for the page, one value per picture."""
        info = self._info
        answered = "answered" in info and bool(info["answered"][0])
        proprio = np.array(self._proprio)
        success, steps = bool(info["success_once"][0]), len(self.actions)
        return {
            "type": "playback",
            "id": self.spec.id,
            "seed": str(self.spec.seed),
            "instruction": self.instruction,
            "frames": len(self),
            "reward": _rounded(self._rewards),
            "tcp": [_rounded(row) for row in proprio[:, :3].tolist()],
            "gripper": _rounded(proprio[:, 6].tolist()),
            "command": _rounded([float(action[6]) for action in self.actions]),
            "success": [i for i, success in enumerate(self._successes) if success][:1],
            "answered": self._answered,
            "phases": [phase["name"] for phase in self.description["phases"]],
            "phase": self._phases.track,
            "horizon": self.description["horizon"],
            "cut": not self._ended and steps >= MOST_STEPS,
            # Another result than that of the folder: another policy, or it is not deterministic.
            "differs": self._recorded is not None and self._recorded != (success, steps),
            "result": {
                "success": success,
                "first_answer_correct": (
                    bool(info["first_answer_correct"][0]) if answered else None
                ),
                "return": float(info["episode_return"][0]),
                "steps": steps,
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


def info_row(env: Any, name: str) -> npt.NDArray[np.float32]:
    """A copy of the first environment's output of that name."""
    row: npt.NDArray[np.float32] = env._views[name][0].copy()
    return row


def _rounded(values: Sequence[float | None]) -> list[float | None]:
    return [None if value is None else round(value, 4) for value in values]
