"""A batch in the layout of TorchRL's policies with words and images, that of its LiberoEnv."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import torch
from tensordict import NonTensorStack, TensorDict, TensorDictBase
from torchrl.data import Binary, Bounded, Composite, NonTensor, Unbounded
from torchrl.envs import EnvBase

from engram._args.keywords import check_single
from engram.factory import make_vec
from engram.wrappers import EqualStarts

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from engram.typing import EnvOptions

__all__ = ["EngramVlaEnv"]

_CAMERAS = ("image", "wrist_image")


class EngramVlaEnv(EnvBase):  # type: ignore[misc]
    """N environments with ``observation`` and ``language_instruction``.

    Under ``observation`` are ``image`` and ``wrist_image``, uint8 (N, 3, height, width), and
    ``state``, the proprio, float32 (N, 7). ``success``, ``terminated``, ``truncated`` and ``done``
    are bool (N, 1). As in ``LiberoEnv``, an episode ends at success, with a reward of 1; all others
    are 0. ``group_id``, int64 (N, 1), is the same for environments of a group in the same episode,
    and for no others: advantages within a group need it. For the benchmark's own rewards and ends
    take TorchRL's ``GymWrapper``.

    Args:
        id: Task, such as "RememberColor3-VLA-v0".
        num_envs: Number of environments.
        group_size: Environments in a row that play the same episodes; see
            ``engram.wrappers.EqualStarts``.
        **options: Those of ``engram.make_vec``, except obs_mode, autoreset_mode and copy.
    """

    def __init__(
        self, id: str, num_envs: int = 1, *, group_size: int = 1, **options: Unpack[EnvOptions]
    ) -> None:
        check_single("EngramVlaEnv", options, own=("num_envs", "group_size"))
        given: dict[str, Any] = {"obs_mode": "rgb", "autoreset_mode": "DISABLED", **options}
        batch = make_vec(id, num_envs, **given)
        self._batch: Any = EqualStarts(batch, group_size)
        self._episodes = np.full(num_envs, -1)
        self._seed: int | None = None
        super().__init__(batch_size=[num_envs])
        self._make_specs()

    def _make_specs(self) -> None:
        space, size = self._batch.single_observation_space, self.batch_size
        height, width, _ = space["rgb"].shape
        frame = Unbounded((*size, 3, height, width), dtype=torch.uint8)
        state = Unbounded((*size, *space["proprio"].shape), dtype=torch.float32)
        seen = Composite(**dict.fromkeys(_CAMERAS, frame), state=state, shape=size)
        flag = Binary(shape=(*size, 1), dtype=torch.bool)
        self.observation_spec = Composite(
            observation=seen,
            language_instruction=NonTensor(shape=size, example_data=""),
            success=flag,
            group_id=Unbounded((*size, 1), dtype=torch.int64),
            shape=size,
        )
        box = self._batch.action_space
        low, high = torch.from_numpy(box.low), torch.from_numpy(box.high)
        self.action_spec = Bounded(low, high, dtype=torch.float32)
        self.reward_spec = Bounded(0.0, 1.0, shape=(*size, 1), dtype=torch.float32)
        ends = dict.fromkeys(("done", "terminated", "truncated"), flag)
        self.done_spec = Composite(**ends, shape=size)

    def _set_seed(self, seed: int | None) -> None:
        self._seed = seed

    def _reset(self, tensordict: TensorDictBase | None = None, **_: Any) -> TensorDict:
        flags = None if tensordict is None else tensordict.get("_reset", None)
        which = np.ones(len(self._episodes), bool) if flags is None else flags.numpy().reshape(-1)
        if which.all():
            seen, info = self._batch.reset(seed=self._seed)
            self._seed = None
        else:
            seen, info = self._batch.reset(options={"reset_mask": which})
        self._episodes[which] += 1
        return self._outputs(seen, info)

    def _step(self, tensordict: TensorDictBase) -> TensorDict:
        seen, _, terminated, truncated, info = self._batch.step(tensordict["action"].numpy())
        out = self._outputs(seen, info)
        success = out["success"]
        out["reward"] = success.to(torch.float32)
        out["terminated"] = success | _column(terminated)
        out["truncated"] = _column(truncated) & ~out["terminated"]
        out["done"] = out["terminated"] | out["truncated"]
        return out

    def _outputs(self, seen: dict[str, Any], info: dict[str, Any]) -> TensorDict:
        rgb = torch.from_numpy(seen["rgb"]).permute(0, 3, 1, 2)
        images = {name: rgb[:, 3 * i : 3 * i + 3].contiguous() for i, name in enumerate(_CAMERAS)}
        groups = int(self._batch.group[-1]) + 1
        instructions = NonTensorStack(*self._batch.unwrapped.instructions)
        return TensorDict(
            {
                "observation": {**images, "state": torch.tensor(seen["proprio"])},
                "language_instruction": instructions,
                "success": _column(info["success_once"]),
                "group_id": _column(self._episodes * groups + self._batch.group),
            },
            batch_size=self.batch_size,
        )

    def close(self, **_: Any) -> None:
        """Ends the batch."""
        self._batch.close()
        super().close()


def _column(values: np.ndarray) -> torch.Tensor:
    return torch.tensor(values).unsqueeze(-1)
