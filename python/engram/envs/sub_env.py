"""One environment of a batch, for code that handles environments individually."""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING, Any, Protocol, cast

from engram._args import methods
from engram.errors import InvalidArgumentError, UnknownIdError

if TYPE_CHECKING:
    import gymnasium
    import numpy as np

    from engram import _core
    from engram.envs.groups import TaskGroup
    from engram.typing import TaskDescription


class Batch(Protocol):
    """Parts of a ``VectorEnv`` that one of its environments uses."""

    _batch: _core.Batch
    _views: dict[str, Any]
    metadata: dict[str, Any]
    render_mode: str | None
    spec: Any

    @property
    def single_observation_space(self) -> gymnasium.Space[Any]: ...
    @property
    def single_action_space(self) -> gymnasium.Space[Any]: ...
    def frame(self, index: int = 0) -> np.ndarray: ...
    def save(self, index: int | None = None) -> bytes: ...
    def restore(self, data: bytes, index: int | None = None) -> Any: ...
    def task_of(self, index: int) -> TaskDescription: ...


class SubEnv:
    """One environment of a ``VectorEnv``, to read from: it cannot be stepped on its own.

    Attributes:
        index: Its place in the batch.
    """

    def __init__(self, batch: Batch, index: int) -> None:
        self._batch = batch
        self.index = index

    def __repr__(self) -> str:
        return f"<environment {self.index} of {self._batch!r}>"

    @property
    def unwrapped(self) -> SubEnv:
        """Itself."""
        return self

    @property
    def observation_space(self) -> gymnasium.Space[Any]:
        """Space of its observation."""
        return self._batch.single_observation_space

    @property
    def action_space(self) -> gymnasium.Space[Any]:
        """Space of its action."""
        return self._batch.single_action_space

    @property
    def metadata(self) -> dict[str, Any]:
        """The batch's."""
        return self._batch.metadata

    @property
    def spec(self) -> Any:
        """The batch's."""
        return self._batch.spec

    @property
    def render_mode(self) -> str | None:
        """The batch's."""
        return self._batch.render_mode

    @property
    def task(self) -> str:
        """Id of the task."""
        return self._batch.task_of(self.index)["id"]

    @property
    def language_instruction(self) -> str:
        """The instruction of the running episode."""
        return self._batch._batch.instruction(self.index)

    @property
    def task_description(self) -> str:
        """Alias under LeRobot's name."""
        return self.language_instruction

    @property
    def max_episode_steps(self) -> int:
        """Control steps of an episode."""
        return int(self._batch.task_of(self.index)["horizon"])

    @property
    def _max_episode_steps(self) -> int:
        return self.max_episode_steps

    def output(self, name: str) -> Any:
        """A copy of one of its outputs: "success", "reward", "tcp_pose", ....

        Raises:
            UnknownIdError: There is no output of that name.
        """
        views = self._batch._views
        if name not in views:
            raise UnknownIdError(f"output {name!r} given; allowed: {', '.join(views)}")
        return views[name][self.index].copy()

    def render(self) -> np.ndarray | None:
        """An image of it, uint8 (height, width, 3); None without a render mode."""
        return None if self.render_mode is None else self._batch.frame(self.index)

    def save(self) -> bytes:
        """A snapshot of it."""
        return self._batch.save(self.index)

    def restore(self, data: bytes) -> None:
        """Restores a snapshot into it."""
        self._batch.restore(data, self.index)

    def get_wrapper_attr(self, name: str) -> Any:
        """The attribute itself: there are no wrappers."""
        return getattr(self, name)

    def has_wrapper_attr(self, name: str) -> bool:
        """True if it has the attribute."""
        return hasattr(self, name)

    def set_wrapper_attr(self, name: str, value: Any) -> None:
        """Sets the attribute."""
        setattr(self, name, value)


class SubEnvMixin:
    """Tasks and environments of ``VectorEnv``, which provides these attributes."""

    _batch: _core.Batch
    _group: TaskGroup
    num_envs: int

    @property
    def task_ids(self) -> tuple[str, ...]:
        """Ids of the tasks; the info "task_index" of several counts in them."""
        return self._group.ids

    def task_of(self, index: int) -> TaskDescription:
        """Description of one environment's task."""
        task: TaskDescription = self._group.of(methods.batch_index(index, self.num_envs))
        return task

    @property
    def instructions(self) -> list[str]:
        """Instructions of the running episodes, in English, one text per environment."""
        return [self._batch.instruction(i) for i in range(self.num_envs)]

    @functools.cached_property
    def envs(self) -> list[SubEnv]:
        """One object per environment, for code that handles environments individually."""
        batch = cast("Batch", self)
        return [SubEnv(batch, i) for i in range(self.num_envs)]

    def call(self, name: str, *args: Any, **kwargs: Any) -> tuple[Any, ...]:
        """Calls a method of, or gets an attribute from, each of ``envs``."""
        values = [getattr(env, name) for env in self.envs]
        return tuple(value(*args, **kwargs) if callable(value) else value for value in values)

    def get_attr(self, name: str) -> tuple[Any, ...]:
        """An attribute of each of ``envs``; ``SubEnv`` lists them."""
        return self.call(name)

    def set_attr(self, name: str, values: Any) -> None:
        """Sets an attribute on each of ``envs``: a list or tuple of N values, or one for all."""
        if not isinstance(values, (list, tuple)):
            values = [values] * self.num_envs
        if len(values) != self.num_envs:
            raise InvalidArgumentError(
                f"values of {name}: {len(values)} given, {self.num_envs} needed"
            )
        for env, value in zip(self.envs, values):
            setattr(env, name, value)
