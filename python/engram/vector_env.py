"""The batch as a gymnasium.vector.VectorEnv."""

from __future__ import annotations

import atexit
import functools
import inspect
import json
import weakref
from collections.abc import Mapping, Sequence
from typing import Any

import gymnasium
import numpy as np

from engram import _arguments, _core, _options, _values
from engram._compat import AutoresetMode
from engram._infos import Infos
from engram._option_list import POLICY
from engram._spaces import Layout, action_spaces, copy_tree
from engram._spec import spec_of
from engram.errors import InvalidArgumentError
from engram.registry import NAMESPACE
from engram.sub_env import SubEnv

_open_batches: weakref.WeakSet[VectorEnv] = weakref.WeakSet()


@atexit.register
def _close_all() -> None:
    for env in list(_open_batches):
        env.close()


class VectorEnv(gymnasium.vector.VectorEnv):
    """A batch of environments of one task, stepped in lockstep on all cores.

    N stands for the number of environments. Unless ``copy`` is set, every array that ``reset`` and
    ``step`` return is a view of engram's own buffers: it stays where it is, changes with the next
    call, and keeps its memory alive even after ``close``. Whoever keeps arrays for later copies
    them. Observations, rewards and endings are writable, so that ``torch.from_dlpack`` and its kin
    take them over; arrays in ``info`` are read-only.

    Environment ``i`` of a batch equals, bit for bit, the single environment of its seed, whatever
    the number of environments and threads.

    Args:
        id: Task, such as "RememberColor9-VLA-v0" (``engram.list()`` names all; a leading
            "engram/" is allowed).
        num_envs: Number of environments. 1 to 1,000,000.
        obs_mode: "state": one float32 row (N, state_dim) that includes privileged fields;
            "state_dict": the same row by name, {"agent": ..., "extra": ...}; "rgb": {"rgb": uint8
            (N, height, width, 3 per camera), "proprio": float32 (N, 7)} and, for the Rotate
            families, "task_cue"; "objects": one float32 row of what cameras could tell;
            "objects_dict": the same by name, {"agent": ..., "objects": (N, tokens, values)};
            "none".
        seed: Environment i has ``seed + i``; unsigned 64 bit. None: drawn from the system.
        threads: Threads that work on a step, the caller's included; results do not depend on it. 0
            (one per core) to 1024.
        reward_mode: The reward of a step. "none", "sparse", "dense" or "normalized_dense".
        control_mode: One of ``engram.describe(id)["action_spaces"]``.
        autoreset_mode: An ``AutoresetMode`` or its name. Default: what vector environments of the
            installed Gymnasium do, NEXT_STEP for 1.x and SAME_STEP for 0.29.
        pins: Sampled quantities of every episode that are fixed, by name: {"target": 2}.
            ``engram.describe(id)["draws"]`` names them.
        task_options: Options of the task's own, by name; ``engram.describe(id)["options"]``.
        constants: Constants of the task that differ from its own, by name; numbers, [least,
            greatest], names or lists of names; ``engram.describe(id)["changeable"]``.
        copy: Return copies instead of views.
        render_mode: "rgb_array" (or None) makes ``render`` return pictures.
        render_size: Side of ``render``'s pictures in pixels, or (width, height).
        render_camera: Camera of ``render``; docs/cameras.md says which there are.
        image_size: Side of rgb observations in pixels, or (width, height).
        cameras: Of rgb observations, in channel order. Default: base_camera, hand_camera.
        renderer: Who draws rgb observations. "cpu" or "egl".
        shadows: Shadows in rgb observations.
        antialias: 2 x 2 samples per pixel in rgb observations.
        terminate_on_success: Whether episodes end at success, whatever the task's own rule.
        rotation_sign: Sign of rotation actions; -1 as the original benchmark has it. -1 or 1.
        freeze_cue: Actions are replaced by zeros during cue and empty phase, where the canonical
            wrapper chain does so.
        robot_init_qpos_noise: Standard deviation of the arm joints' noise in the start pose. 0 to 1
            rad.
        substeps: Physics steps of 0.01 s per control step; 0 measures everything but physics. 0 to
            1000.
        sleep: Shortcuts of the physics; off: none of them, for comparison.
        chunk: Most environments that a thread claims at a time. 0 (chosen) or more.
        lanes: Environments whose robots move side by side in vector registers: 1, 2, 4 or 8;
            results are the same. 0, 1, 2, 4 or 8.
        language_in_info: False leaves "language_instruction" out of infos, for wrappers that know
            no strings (Gymnasium's NumpyToTorch); ``get_attr`` still tells it.
        max_episode_steps: Control steps of an episode; None: the task's own horizon, or what
            constants say.
        observe_time: Objects modes: whether observations tell the time, as a share of the horizon.
        rules: Whose rules the task follows: the default of every task option; task_options win.
            "reference" or "original".
        render_shadows: Soft shadows in pictures of render_camera; the original benchmark has none.

    Raises:
        UnknownIdError: No task of that id; the message names the nearest one.
        InvalidArgumentError: An option is out of range or of the wrong type.
        UnavailableError: The machine lacks memory, threads or the renderer.
    """

    def __init__(
        self,
        id: str,
        num_envs: int = 1,
        *,
        # begin options: signature (scripts/options.py writes it, and "Args" above)
        obs_mode: str = "state",
        seed: int | None = 0,
        threads: int = 0,
        reward_mode: str = "normalized_dense",
        control_mode: str = "pd_ee_delta_pose",
        autoreset_mode: AutoresetMode | str | None = None,
        pins: Mapping[str, float | Sequence[float]] | None = None,
        task_options: Mapping[str, float] | None = None,
        constants: Mapping[str, Any] | None = None,
        copy: bool = False,
        render_mode: str | None = "rgb_array",
        render_size: int | tuple[int, int] = 512,
        render_camera: str = "render_camera",
        image_size: int | tuple[int, int] = 128,
        cameras: Sequence[str] | None = None,
        renderer: str = "cpu",
        shadows: bool = False,
        antialias: bool = False,
        terminate_on_success: bool | None = None,
        rotation_sign: int = -1,
        freeze_cue: bool = True,
        robot_init_qpos_noise: float = 0.02,
        substeps: int = 5,
        sleep: bool = True,
        chunk: int = 0,
        lanes: int = 0,
        language_in_info: bool = True,
        max_episode_steps: int | None = None,
        observe_time: bool = False,
        rules: str = "reference",
        render_shadows: bool = False,
        # end options
    ) -> None:
        arguments = {k: v for k, v in locals().items() if k not in ("self", "__class__")}
        self.closed = True  # until the batch exists
        if not isinstance(id, str):
            raise InvalidArgumentError(f"id: {id!r} given, a string needed")
        self.task_id = id[len(NAMESPACE) :] if id.startswith(NAMESPACE) else id
        self._arguments = {**arguments, "id": self.task_id}
        if render_mode not in (None, "rgb_array"):
            raise InvalidArgumentError(
                f"render_mode: {render_mode!r} given; allowed: rgb_array, None"
            )
        self.render_mode = render_mode
        self._render = (render_camera, *_options.size_pair(render_size))
        self.autoreset_mode = _options.autoreset(autoreset_mode)
        self.metadata = {
            "render_modes": ["rgb_array"],
            "render_fps": 20,
            "autoreset_mode": self.autoreset_mode,
        }
        arguments["constants"] = self._with_horizon(constants, max_episode_steps)
        options = _options.make_options(arguments, self.autoreset_mode)
        self._batch = _core.Batch(self.task_id, options)
        self._seed = options.seed
        self._copy = bool(copy)
        self._started = False
        self._open(obs_mode, bool(language_in_info))
        self.spec = spec_of(self._arguments, _defaults())

    def _with_horizon(
        self, constants: Mapping[str, Any] | None, steps: int | None
    ) -> Mapping[str, Any] | None:
        """The constants, with the horizon among them where it is not the registered one."""
        if steps is None:
            return constants
        registered = gymnasium.registry.get(NAMESPACE + self.task_id)
        steps = _values.integer("max_episode_steps", steps)
        if registered is not None and steps == registered.max_episode_steps:
            return constants
        return {**(constants or {}), "max_episode_steps": steps}

    def _open(self, obs_mode: str, language_in_info: bool) -> None:
        """Everything that follows from an open batch: its description, spaces and views."""
        batch = self._batch
        self.closed = False
        _open_batches.add(self)
        self.num_envs = batch.num_envs
        self.description = json.loads(batch.description)
        self._views: dict[str, Any] = {name: batch.output(name) for name in batch.output_names}
        self._layout = Layout(obs_mode, self.description, self._views)
        self.single_observation_space = self._layout.single
        self.observation_space = self._layout.batched
        self.single_action_space, self.action_space = action_spaces(
            *batch.action_bounds, self.num_envs
        )
        self._action_shape = (self.num_envs, batch.action_dim)
        self._observation = self._layout.views(self._views)
        self._ones = np.ones(self.num_envs, np.bool_)
        self._ones.flags.writeable = False
        self._infos = Infos(
            batch,
            self._views,
            self._layout,
            same_step=self.autoreset_mode is AutoresetMode.SAME_STEP,
            copy=self._copy,
            language=language_in_info,
        )
        # 0.29 looks for these.
        self.is_vector_env = True
        self.viewer = None

    # --- running ---

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[Any, dict[str, Any]]:
        """Starts new episodes.

        Args:
            seed: An int (environment i gets ``seed + i``), one per environment (None in it: as
                without a seed), or None: the first reset uses the seed given to the constructor,
                later ones go on to the next episode of each environment.
            options: {"reset_mask": bool array (N,), True where an environment is to be reset;
                "pins": dict that replaces the pins of the environments that are reset;
                "constants": dict that replaces their narrower ranges, such as
                {"EMPTY_PHASE_STEPS": (1, 3)}, each within that of the batch; pins still win}.

        Returns:
            Observations and infos. With a mask, rows of environments that were not reset are
            those of the last step, and the masks in the infos are False for them.

        Raises:
            InvalidArgumentError: A mask, seed or pin is of the wrong shape, type or range.
            UnknownIdError: No option or pin of that name.
            BadStateError: The first reset leaves environments out, or a step is under way.
        """
        mask, *fixed = _arguments.reset_options(options, self.num_envs)
        seeds = _arguments.seed_list(seed, self.num_envs)
        if isinstance(seeds, list):  # some are None
            given = np.array([value is not None for value in seeds])
            filled = [self._seed + i if value is None else value for i, value in enumerate(seeds)]
            array = np.array([value % 2**64 for value in filled], np.uint64)
            if not self._started:
                self._batch.reset(mask, array, *fixed)
            else:
                chosen = self._ones if mask is None else mask
                for part, part_seeds in ((chosen & given, array), (chosen & ~given, None)):
                    if part.any():
                        self._batch.reset(part, part_seeds, *fixed)
        else:
            self._batch.reset(mask, seeds, *fixed)
        self._started = True
        which = self._ones if mask is None else mask
        self._infos.refresh_instructions(np.flatnonzero(which))
        return self._hand_out(self._observation), self._infos.columns(which)

    def step(self, actions: Any) -> tuple[Any, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """One control step (0.05 s) of all environments.

        Args:
            actions: (N, action_dim), any real dtype; float32 without gaps is taken as it is.

        Returns:
            Observations; rewards, float32 (N,); terminated and truncated, bool (N,); infos. In the
            mode SAME_STEP, infos hold "final_obs" and "final_info" when episodes have ended.

        Raises:
            InvalidArgumentError: Wrong shape or type, or a value that is not finite.
            BadStateError: Nothing was reset, a step is under way, or the batch is closed.
        """
        self._batch.step(self._checked(actions))
        return self._results()

    def step_async(self, actions: Any) -> None:
        """Begins a step and returns; engram's threads work on it.

        Actions are copied. Until ``step_wait`` returns, views change and must not be read, and
        other calls are refused with BadStateError.
        """
        self._batch.step_async(self._checked(actions))

    def step_wait(self, **_: Any) -> tuple[Any, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """Waits for the step that ``step_async`` began; returns what ``step`` returns.

        Raises:
            BadStateError: No step is under way.
        """
        self._batch.step_wait()
        return self._results()

    def reset_async(self, **_: Any) -> None:
        """For callers of Gymnasium 0.29: resets happen in ``reset_wait``."""

    def reset_wait(self, **kwargs: Any) -> tuple[Any, dict[str, Any]]:
        """For callers of Gymnasium 0.29: the same as ``reset``."""
        return self.reset(**kwargs)

    def act(self, policy: str = "oracle", out: np.ndarray | None = None) -> np.ndarray:
        """Actions for the next step.

        Args:
            policy: "oracle" solves the task with privileged state, "blind" is the oracle that must
                guess what the cue showed, "sweep" does the best that can be done without memory
                (all three in pd_ee_delta_pose only), "random" is uniform over the action space,
                "zero".
            out: float32 (N, action_dim) to write to, instead of a new array.
        """
        number = _values.one_of("policy", policy, POLICY)
        if out is None:
            out = np.empty(self._action_shape, np.float32)
        elif not (
            isinstance(out, np.ndarray)
            and out.dtype == np.float32
            and out.shape == self._action_shape
            and out.flags.carray
        ):
            raise InvalidArgumentError(
                f"out: {_arguments.kind_of(out)} given; a writable float32 array of shape "
                f"{self._action_shape} without gaps is needed"
            )
        self._batch.act(number, out)
        return out

    # --- pictures, snapshots ---

    def render(self) -> tuple[np.ndarray, ...] | None:
        """One picture per environment, uint8 (height, width, 3); None without a render mode."""
        if self.render_mode is None:
            return None
        return tuple(self.frame(i) for i in range(self.num_envs))

    def frame(
        self,
        index: int = 0,
        camera: str | None = None,
        size: int | tuple[int, int] | None = None,
    ) -> np.ndarray:
        """One environment as it is now, uint8 (height, width, 3), row 0 on top.

        Args:
            index: Which environment.
            camera: One of those in docs/cameras.md; default: ``render_camera`` of the constructor.
            size: Side in pixels or (width, height), 1 to 4096; default: ``render_size``.
        """
        name, width, height = self._render
        if size is not None:
            width, height = _options.size_pair(size)
        picture: Any = self._batch.render(
            _values.integer("index", index), camera or name, width, height
        )
        return picture

    def save(self, index: int | None = None) -> bytes:
        """One environment, or the whole batch, bit-exactly: physics, task and random stream."""
        return self._batch.save(_arguments.place(index, self.num_envs))

    def restore(self, data: bytes, index: int | None = None) -> tuple[Any, dict[str, Any]]:
        """Restores what ``save`` returned; returns the observation and infos at that point.

        A saved environment may go into any place of any batch of the same task, control mode and
        task options, a saved batch into such a batch of the same size. How it goes on and what is
        observed is up to the other options of the batch it goes into.

        Raises:
            InvalidArgumentError: The bytes are damaged, or of another task, version or size.
        """
        if not isinstance(data, bytes):
            raise InvalidArgumentError(f"data: {_arguments.kind_of(data)} given, bytes needed")
        self._batch.restore(_arguments.place(index, self.num_envs), data)
        self._started = True
        self._infos.refresh_instructions(range(self.num_envs))
        return self._hand_out(self._observation), self._infos.columns(self._ones)

    # --- the batch as Gymnasium's sub-environments ---

    @functools.cached_property
    def envs(self) -> list[SubEnv]:
        """One object per environment, for code that looks at environments one by one."""
        return [SubEnv(self, i) for i in range(self.num_envs)]

    def call(self, name: str, *args: Any, **kwargs: Any) -> tuple[Any, ...]:
        """Calls a method of, or gets an attribute from, each of ``envs``."""
        values = [getattr(env, name) for env in self.envs]
        return tuple(value(*args, **kwargs) if callable(value) else value for value in values)

    def get_attr(self, name: str) -> tuple[Any, ...]:
        """An attribute of each of ``envs``; ``SubEnv`` says which there are."""
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

    # --- life ---

    @property
    def unstable_count(self) -> int:
        """Environment steps in which physics diverged, since the batch was made."""
        return self._batch.unstable_count

    @property
    def num_threads(self) -> int:
        """Threads that work on a step."""
        return self._batch.num_threads

    def close(self, **_: Any) -> None:
        """Ends the batch; a step under way is waited for. Views stay readable."""
        if self.closed:
            return
        self.closed = True
        _open_batches.discard(self)
        self._batch.close()

    def __del__(self) -> None:
        if not getattr(self, "closed", True):
            self.close()

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickling keeps the specification: the copy is a new batch, not yet reset."""
        return _remake, (self._arguments,)

    def __deepcopy__(self, memo: dict[int, Any]) -> VectorEnv:
        return _remake(self._arguments)

    def __repr__(self) -> str:
        return f"engram.VectorEnv({self.task_id}, num_envs={self.num_envs})"

    # --- inside ---

    def _checked(self, actions: Any) -> np.ndarray:
        """Actions as the extension takes them."""
        if (
            type(actions) is np.ndarray
            and actions.dtype == np.float32
            and actions.shape == self._action_shape
            and actions.flags.c_contiguous
            and actions.flags.aligned
        ):
            return actions
        return _arguments.checked_actions(actions, self._action_shape)

    def _hand_out(self, value: Any) -> Any:
        return copy_tree(value) if self._copy else value

    def _results(self) -> tuple[Any, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        finals = self._infos.finals() if self.autoreset_mode is AutoresetMode.SAME_STEP else None
        if finals is None:
            began = np.flatnonzero(self._views["elapsed_steps"] == 0)
            if began.size:
                self._infos.refresh_instructions(began)
        info = self._infos.columns(self._ones)
        if finals is not None:
            info.update(finals)
        views = self._views
        return (
            self._hand_out(self._observation),
            self._hand_out(views["reward"]),
            self._hand_out(views["terminated"]),
            self._hand_out(views["truncated"]),
            info,
        )


def _remake(arguments: dict[str, Any]) -> VectorEnv:
    return VectorEnv(**arguments)


@functools.cache
def _defaults() -> dict[str, Any]:
    parameters = inspect.signature(VectorEnv.__init__).parameters
    return {name: parameter.default for name, parameter in parameters.items()}
