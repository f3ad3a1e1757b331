"""Observations and infos as nested dicts of torch tensors, made from the buffers of a batch."""

from __future__ import annotations

import enum
from collections import OrderedDict
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from gymnasium import spaces

from engram.envs.copies import Copier
from engram.envs.queries import CAMERA_MATRICES
from engram.envs.spaces import FIRST_EXTRA_FIELD, ImageBox
from engram.envs.vector_env import VectorEnv
from engram.mikasa import _families
from engram.mikasa._torch import torch
from engram.typing import TaskDescription

_AGENT = ("qpos", "qvel")
_FIXED = "base_camera"
_ANGLE = "{angle_deg}"  # stands for the angle of an episode in the instruction of Rotate


# NumPy converts and compares small arrays in a fraction of the time that torch takes.
_NUMPY_TYPES: dict[torch.dtype, Any] = {
    torch.bool: np.bool_,
    torch.uint8: np.uint8,
    torch.int64: np.int64,
    torch.float16: np.float16,
    torch.float32: np.float32,
}


def tensor(view: np.ndarray, dtype: torch.dtype | None = None) -> torch.Tensor:
    """A copy of a buffer of engram's."""
    return torch.from_numpy(view.copy() if dtype is None else view.astype(_NUMPY_TYPES[dtype]))


class Wanted(enum.Enum):
    """Needed part of an observation with images."""

    ALL = 0
    NO_MATRICES = 1
    POLICY = 2  # images of all cameras in one array, and the seven numbers of proprio


class Only:
    """A context in which only a part is wanted; see ``Observations.only``."""

    def __init__(self, observations: Observations, part: Wanted) -> None:
        self._observations = observations
        self._part = part
        self._before = observations.wanted

    def __enter__(self) -> None:
        self._observations.wanted = self._part

    def __exit__(self, *_: object) -> None:
        self._observations.wanted = self._before


class Observations:
    """Makes observations of one mode.

    Args:
        batch: The batch.
        description: Of the batch.
        mode: obs_mode of gym.make.
        textures: Images of the cameras; none in state modes.
        cameras: In channel order.
        size: Of their images.

    Attributes:
        wanted: Part of observations with images that is made.
    """

    def __init__(
        self,
        batch: VectorEnv[Any],
        description: TaskDescription,
        mode: str,
        textures: Sequence[str],
        cameras: Sequence[str],
        size: tuple[int, int],
    ) -> None:
        self._batch = batch
        self.textures = textures
        self._cameras = cameras
        self.wanted = Wanted.ALL
        self._fixed: Any = None  # matrices of the fixed camera
        self._size = size
        self._copied: dict[str, Callable[[], Any]] = {}
        if textures:
            copier = Copier()
            self._copied = {name: copier(batch._observation[name]) for name in textures}
        elif mode != "none":
            self._row = Copier()(batch._views["observation"])
        self._parts = _state_parts(description) if mode == "state_dict" else []
        makers = {"state": self._state, "state_dict": self._state_dict, "none": dict}
        self._make: Callable[[], Any] = makers.get(mode, self._images)

    def __call__(self) -> Any:
        """The present observation, a copy."""
        return self._make()

    def only(self, part: Wanted) -> Only:
        """Context in which only this part is made; of nested ones, the outermost counts."""
        return Only(self, part if self.wanted is Wanted.ALL else self.wanted)

    def _state(self) -> torch.Tensor:
        return torch.from_numpy(self._row())

    def _state_dict(self) -> dict[str, Any]:
        row = self._state()
        result: dict[str, Any] = {"agent": {}, "extra": {}}
        for path, columns, dtype in self._parts:
            part = result
            for key in path[:-1]:
                part = part.setdefault(key, {})
            value = row[:, columns]
            if dtype is torch.uint8:
                value = value.to(torch.int64)  # -1, for nothing, becomes 255
            part[path[-1]] = value if dtype is None else value.to(dtype)
        return result

    def _images(self) -> dict[str, Any]:
        if self.wanted is Wanted.POLICY:
            proprio = tensor(self._batch._views["proprio"])
            return {"proprio": proprio, "rgb": torch.from_numpy(self._copied["rgb"]())}
        state = {k: torch.from_numpy(v) for k, v in self._batch.robot_state().items()}
        images = {name: torch.from_numpy(copy()) for name, copy in self._copied.items()}
        result: dict[str, Any] = {
            "agent": {name: state[name] for name in _AGENT},
            "extra": {FIRST_EXTRA_FIELD: state[FIRST_EXTRA_FIELD]},
        }
        if self.wanted is Wanted.ALL:
            result["sensor_param"] = {camera: self._matrices(camera) for camera in self._cameras}
        result["sensor_data"] = {
            camera: {name: self._of(image, i) for name, image in images.items()}
            for i, camera in enumerate(self._cameras)
        }
        return result

    def _matrices(self, camera: str) -> dict[str, torch.Tensor]:
        """Matrices of one camera; only the wrist's change."""
        values = self._fixed
        if camera != _FIXED or values is None:
            values = self._batch._batch.camera_params(camera, *self._size)
        if camera == _FIXED:
            self._fixed = values
        return {name: tensor(value) for name, value in zip(CAMERA_MATRICES, values)}

    def _of(self, images: torch.Tensor, camera: int) -> torch.Tensor:
        """One camera's channels: a view, from which `joined` gets the whole without a copy."""
        width = images.shape[-1] // len(self._cameras)
        return images[..., camera * width : (camera + 1) * width]


def _state_parts(
    description: TaskDescription,
) -> list[tuple[tuple[str, ...], Any, torch.dtype | None]]:
    """Position of each field of a state row in ``state_dict``: path, columns, type."""
    family = description["family"]
    infos = {output["name"]: output for output in description["outputs"]}
    fields = description["state_fields"]
    first = [field["name"] for field in fields].index(FIRST_EXTRA_FIELD)
    parts = []
    for i, field in enumerate(fields):
        name, begin = field["name"], field["offset"]
        if i >= first:
            path: tuple[str, ...] = ("extra", name)
        else:
            path = ("agent", name) if name in _AGENT else ("agent", "controller", "arm", name)
        dtype = _families.field_type(name, family)
        if dtype is None and name in infos:
            dtype = {"bool": torch.bool, "int32": torch.int64}.get(infos[name]["dtype"])
        flat = field["width"] == 1 and not _families.is_row(name, family)
        columns: Any = begin if flat else slice(begin, begin + field["width"])
        parts.append((path, columns, dtype))
    return parts


def joined(images: Sequence[torch.Tensor]) -> torch.Tensor:
    """Images of several cameras as one, channels one after the other; a view if they are one."""
    first = images[0]
    channels = first.stride(-2)
    begin = first.storage_offset()
    place = first.untyped_storage().data_ptr()
    for image in images:
        if (
            image.dtype != first.dtype
            or image.stride() != first.stride()
            or image.untyped_storage().data_ptr() != place
            or image.storage_offset() != begin
        ):
            return torch.cat(list(images), dim=-1)
        begin += image.shape[-1]
    if begin - first.storage_offset() != channels:
        return torch.cat(list(images), dim=-1)
    return first.as_strided((*first.shape[:-1], channels), first.stride(), first.storage_offset())


class Evaluation:
    """Makes infos: the task's evaluation of the present state.

    Args:
        batch: The batch.
        description: Of the batch.
        instruction: In place of the batch's.
        rl: True: infos are those of the RL half, without an instruction.
    """

    def __init__(
        self,
        batch: VectorEnv[Any],
        description: TaskDescription,
        instruction: str | None,
        rl: bool,
    ) -> None:
        family = description["family"]
        self._instruction = instruction
        views = batch._views
        self._batch = batch
        self._by_episode = family in _families.ROTATE
        self._template = description["instruction"]
        self._terms = [
            (term, _families.reward_type(term, family)) for term in description["reward_terms"]
        ]
        self._oracle = _column(
            views["oracle_info"],
            _families.oracle_type(family),
            keep=_families.is_row("oracle_info", family),
        )
        cue = _families.cue_type(family)
        self._cue = None if cue is None else _column(views["task_cue"], cue)
        self._rl = rl
        self._columns = [
            (key, _column(views[key], _shared_type(views[key])))
            for key in _families.info_keys(description)
        ]
        self._rewards = views["reward_dict"]
        self._texts: Any = None

    def restart(self) -> None:
        """Updates instructions after episodes have begun."""
        if self._rl:
            return
        if self._by_episode:
            self._texts = [self._own_text(text) for text in self._batch.instructions]
        elif self._instruction is not None:
            self._texts = self._instruction
        else:
            self._texts = self._batch._batch.instruction(0)

    def _own_text(self, known: str) -> str:
        """The instruction of an episode with the angle of the batch's."""
        if self._instruction is None:
            return known
        before, _, behind = self._template.partition(_ANGLE)
        angle = known.removeprefix(before).removesuffix(behind)
        return self._instruction.replace(_ANGLE, angle)

    def oracle_info(self) -> torch.Tensor:
        """The answer."""
        return self._oracle()

    def task_cue(self) -> torch.Tensor | None:
        """The cue of the task."""
        return None if self._cue is None else self._cue()

    def reward_dict(self) -> dict[str, torch.Tensor] | None:
        """Terms of the reward of the step before; None where no environment has any.

        Beside environments that have some, an environment without has NaN, False and 0.
        """
        if not self._terms:
            return None
        first = self._rewards.item(0)
        if first != first and np.isnan(self._rewards).all():
            return None
        rows = np.array(self._rewards.T, order="C")
        return {name: _term(row, dtype) for (name, dtype), row in zip(self._terms, rows)}

    def __call__(self) -> dict[str, Any]:
        """The infos but for elapsed_steps."""
        info: dict[str, Any] = {key: column() for key, column in self._columns}
        if not self._rl:
            texts = self._texts
            info["language_instruction"] = list(texts) if isinstance(texts, list) else texts
        info["task_cue"] = self.task_cue()
        info["oracle_info"] = self.oracle_info()
        info["reward_dict"] = self.reward_dict()
        return info


def _term(row: np.ndarray, dtype: torch.dtype) -> torch.Tensor:
    """A reward term as a tensor; ``row`` is its memory where the type is that of the row."""
    if dtype is torch.bool:
        row = row > 0
    elif dtype is torch.int64:
        row = np.nan_to_num(row).astype(np.int64)
    return torch.from_numpy(row)


def _shared_type(view: np.ndarray) -> torch.dtype | None:
    return torch.int64 if view.dtype == np.int32 else None


def _column(
    view: np.ndarray, dtype: torch.dtype | None, keep: bool = False
) -> Callable[[], torch.Tensor]:
    """Makes a function that copies a buffer.

    Args:
        view: The buffer.
        dtype: Type of the copies; None: that of the buffer.
        keep: True: rows of one value keep their dimension.
    """
    if keep and view.ndim == 1:
        view = view[:, np.newaxis]
    return lambda: tensor(view, dtype)


def space_of(sample: Any) -> spaces.Space[Any]:
    """The space of observations like this one, nested dicts of tensors or arrays."""
    if isinstance(sample, Mapping):
        # Sorted, as Gymnasium sorts: networks take parts in this order.
        return spaces.Dict(OrderedDict((key, space_of(sample[key])) for key in sorted(sample)))
    array = sample.cpu().numpy() if isinstance(sample, torch.Tensor) else np.asarray(sample)
    if array.dtype == np.uint8 and array.ndim >= 3:
        return ImageBox(array.shape)
    if array.dtype == np.bool_:
        return spaces.Box(0, 1, array.shape, np.bool_)
    if np.issubdtype(array.dtype, np.integer):
        limits = np.iinfo(array.dtype)
        return spaces.Box(limits.min, limits.max, array.shape, array.dtype.type)
    return spaces.Box(-np.inf, np.inf, array.shape, array.dtype.type)


def single(sample: Any) -> Any:
    """The first environment's part of an observation."""
    if isinstance(sample, Mapping):
        return {key: single(value) for key, value in sample.items()}
    return sample[0]
