"""The batch as a gymnasium.vector.VectorEnv."""

from __future__ import annotations

import atexit
import contextlib
import json
import weakref
from collections.abc import Callable, Mapping, Sequence
from copy import deepcopy
from typing import TYPE_CHECKING, Any, Generic

import numpy as np

from engram import _core
from engram._args import methods
from engram._args import options as option_args
from engram._args.option_list import POLICY
from engram._args.values import one_of
from engram._args.warn import warn
from engram.envs.compat import (
    AUTORESET_NAMES,
    GYMNASIUM_1,
    AutoresetMode,
    ObsT,
    VectorBase,
    autoreset,
)
from engram.envs.copies import Copier, same
from engram.envs.ended import raise_if_ended
from engram.envs.groups import TaskGroup, joined, shares_of
from engram.envs.infos import Infos
from engram.envs.output_arrays import OutputArrays
from engram.envs.queries import QueryMixin
from engram.envs.resetter import Resetter
from engram.envs.spaces import Layout, action_spaces
from engram.envs.spec import spec_of
from engram.envs.sub_env import SubEnvMixin
from engram.errors import BadStateError, InvalidArgumentError

if TYPE_CHECKING:
    from engram.typing import (
        AfterEnd,
        AutoresetName,
        Camera,
        ControlMode,
        ObsMode,
        Physics,
        Policy,
        Renderer,
        RenderMode,
        RewardMode,
        Rules,
        TaskDescription,
    )

_open_batches: weakref.WeakSet[VectorEnv[Any]] = weakref.WeakSet()


@atexit.register
def _close_all() -> None:
    _core.end_calls()  # before daemon threads find their batches closed and print errors
    for env in list(_open_batches):
        env.close()


class VectorEnv(QueryMixin, SubEnvMixin, VectorBase[ObsT], Generic[ObsT]):
    """A batch of environments, stepped in lockstep on all cores, of one task or several.

    N stands for the number of environments. ``reset`` and ``step`` return copies. With
    ``copy=False`` they return views of engram's own buffers: such an array keeps its address,
    changes with the next call, and stays readable even after ``close``; copy it to keep its values.
    Views of observations, rewards and endings are writable, so that ``torch.from_dlpack`` and
    similar functions accept them; those in ``info`` are read-only.

    Environment ``i`` of a batch equals, bit for bit, the single environment of its seed, whatever
    the number of environments and threads.

    Of several tasks, the environments of the first come first, and environment i of each task has
    ``seed + i``. Observations have one space: fields of rows have one place in the rows of all
    tasks, those that a task lacks are zero, and so are objects beyond its own (the info, or part
    of objects_dict, "object_mask" is True for those that it has). Masks of infos are True where the
    environment's task has the info; "task_index" and "task" name it.

    Args:
        id: Task, such as "RememberColor9-VLA-v0" (``engram.list()`` names all; a leading
            "engram/" is allowed). Several: a list, which shares num_envs evenly, or a dict from ids
            to numbers of environments, or to dicts with "num_envs" and what else is the task's own:
            "constants", "pins", "task_options".
        num_envs: Number of environments. 1 to 1,000,000.
        obs_mode: "state": one float32 row (N, state_dim) that includes privileged fields;
            "state_dict": the same row by name, {"agent": ..., "extra": ...}; "rgb": {"rgb": uint8
            (N, height, width, 3 per camera), "proprio": float32 (N, 7)} and, for the Rotate
            families, "task_cue"; "rgb+depth", "rgb+segmentation" and "rgb+depth+segmentation": the
            same, and "depth" (mm) or "segmentation", int16 (N, height, width, cameras); "objects":
            one float32 row of what cameras can show; "objects_dict": the same by name, {"agent":
            ..., "objects": (N, tokens, values)}; modes with images, and "+state" or "+objects":
            {"rgb": ..., "state": the row}; "none".
        seed: Environment i has ``seed + i``; unsigned 64 bit. None: drawn from the system; the
            attribute ``seed`` has it. A pair (base, worker): ``engram.worker_seed(base, worker)``.
        threads: Threads that work on a step, the caller's included; results do not depend on it. 0
            (one per core) to 1024.
        reward_mode: The reward of a step. "none", "sparse", "dense" or "normalized_dense".
        control_mode: One of ``engram.describe(id)["action_spaces"]``; None: the task's own,
            pd_ee_delta_pose, or pd_joint_delta_pos of the RL ids.
        autoreset_mode: An ``AutoresetMode`` or its name. Default: what vector environments of the
            installed Gymnasium do, NEXT_STEP for 1.x and SAME_STEP for 0.29.
        pins: Sampled quantities of every episode that are fixed, by name: {"target": 2}.
            ``engram.describe(id)["draws"]`` names them.
        task_options: Options of the task's own, by name; ``engram.describe(id)["options"]``.
        constants: Constants of the task that differ from its own, by name; numbers, [least,
            greatest], names, colours, or lists of them; ``engram.describe(id)["changeable"]``. Any
            constant as the description has it under "constants".
        copy: False: what ``reset`` and ``step`` return are views of engram's own buffers, which
            change with the next call. For loops that are done with an observation before they step
            again; they save one copy.
        render_mode: "rgb_array" (or None) makes ``render`` return images; "human" is for single
            environments.
        render_size: Side of ``render``'s images in pixels, or (width, height).
        render_camera: Camera of ``render``; docs/robot.md says what each of them sees.
        image_size: Side of rgb observations in pixels, or (width, height).
        cameras: Of rgb observations, in channel order. Default: base_camera, hand_camera.
        renderer: Renderer of rgb observations. "cpu" or "egl".
        shadows: Shadows in rgb observations.
        antialias: 2 x 2 samples per pixel in rgb observations.
        terminate_on_success: End of episodes at success, whatever the task's own rule.
        rotation_sign: Sign of rotation actions; -1 as the original benchmark has it. -1 or 1.
        freeze_cue: Actions are replaced by zeros during cue and empty phase, where the canonical
            wrapper chain does so.
        robot_init_qpos_noise: Standard deviation of the arm joints' noise in the start pose. 0 to 1
            rad.
        substeps: Physics steps of 0.01 s per control step; 0 measures everything but physics. 0 to
            1000.
        sleep: Shortcuts of the physics; off: none of them, for comparison.
        chunk: Most environments that a thread claims at a time. 0 (chosen) or more.
        lanes: Environments whose robots move side by side in vector registers: 1, 4, 8 or 16;
            results are the same. 0, 1, 4, 8 or 16.
        language_in_info: Infos with "language_instruction"; ``instructions`` always has it.
        max_episode_steps: Control steps of an episode, shorter or longer than the task's own; None:
            the task's horizon, or what constants say.
        observe_time: Objects modes: elapsed time in observations, as a share of the horizon.
        rules: Rule set of the task: the default of every task option; task_options win. "reference"
            or "original".
        render_shadows: Soft shadows in images of render_camera; the original benchmark has none.
        joint_proprio: Proprio has the arm's seven joint angles and the gripper's opening, instead
            of the TCP's pose and the opening.
        terminate_on_failure: End of episodes at failure, where the task's rule has it; off, with
            terminate_on_success off as well: at the horizon only.
        after_end: Mode DISABLED and single environments: effect of a step on an environment whose
            episode has ended. "refuse": raises BadStateError; "hold": it stands still, with reward
            0, until it is reset; "continue": it is simulated on, and reports success, reward and
            endings as in any step.
        perturb: Departures from the task's usual scene, robot and words, by axis, from 0 (none) to
            1: {"camera": 0.5, "light": 1}; docs/variants.md has the axes.
        physics: "engram": its own; "mujoco": MuJoCo's, by ``mj_step``. Snapshots of one do not fit
            the other.
        out: Arrays or torch tensors (pinned ones too) by output: {"rgb": ..., "proprio": ...,
            "reward": ...}. engram writes there, and ``reset`` and ``step`` return them instead of
            copies. Each needs the dtype and shape of the output. A list of such dicts, or arrays
            with a leading axis of T turns, take turns: ``reset`` writes to the first, each step to
            the next, after the last one to the first again. With two, one can be read while
            ``step_async`` works on the other; T + 1 hold a rollout of T steps in place.
        privileged: Infos with what reveals the hidden quantity, or how near the robot is to it:
            oracle_info, reward_dict and others; ``engram.describe(id)["outputs"]`` marks them. For
            analysis, not for policies.

    Raises:
        UnknownIdError: No task of that id; the message names the nearest one.
        InvalidArgumentError: An option is out of range or of the wrong type.
        UnavailableError: The machine lacks memory, threads or the renderer.
    """

    def __init__(
        self,
        id: str | Sequence[str] | Mapping[str, Any],
        num_envs: int = 1,
        *,
        # begin generated: signature (tools/surface writes it, and "Args" above)
        obs_mode: ObsMode = "state",
        seed: int | tuple[int, int] | None = None,
        threads: int = 0,
        reward_mode: RewardMode = "normalized_dense",
        control_mode: ControlMode | None = None,
        autoreset_mode: AutoresetMode | AutoresetName | None = None,
        pins: Mapping[str, float | Sequence[float]] | None = None,
        task_options: Mapping[str, float] | None = None,
        constants: Mapping[str, Any] | None = None,
        copy: bool = True,
        render_mode: RenderMode | None = "rgb_array",
        render_size: int | tuple[int, int] = 512,
        render_camera: Camera = "render_camera",
        image_size: int | tuple[int, int] = 128,
        cameras: Sequence[Camera] | None = None,
        renderer: Renderer = "cpu",
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
        language_in_info: bool = False,
        max_episode_steps: int | None = None,
        observe_time: bool = False,
        rules: Rules = "reference",
        render_shadows: bool = False,
        joint_proprio: bool = False,
        terminate_on_failure: bool = True,
        after_end: AfterEnd = "refuse",
        perturb: Mapping[str, float] | None = None,
        physics: Physics = "engram",
        out: Mapping[str, Any] | Sequence[Mapping[str, Any]] | None = None,
        privileged: bool = False,
        # end generated
    ) -> None:
        arguments = {k: v for k, v in locals().items() if k not in ("self", "__class__")}
        self.closed = True  # until the batch exists
        shares = shares_of(id, num_envs)
        self.task_id = option_args.task_id(id) if shares is None else joined(shares)
        self._arguments: dict[str, Any] = {
            **arguments,
            "id": self.task_id if shares is None else id,
        }
        self.render_mode: str | None = option_args.render_mode(render_mode, ["rgb_array"])
        self._render = option_args.view(render_camera, render_size)
        self.autoreset_mode = autoreset(autoreset_mode)
        self.metadata = {
            "render_modes": ["rgb_array"],
            "render_fps": 20,
            "autoreset_mode": self.autoreset_mode,
        }
        options = option_args.make_options(arguments, AUTORESET_NAMES[self.autoreset_mode])
        self._batch = _core.Batch(self.task_id if shares is None else shares, options)
        self._out = OutputArrays(self._batch, {} if out is None else out)
        self._same_step = self.autoreset_mode is AutoresetMode.SAME_STEP
        exported = Copier() if copy else same
        self._open(obs_mode, exported, bool(privileged), bool(language_in_info))
        self.seed: int = options.seed
        self._resetter = Resetter(self._batch, self._group, self.seed, self._ones)
        for text in self.description["warnings"]:
            warn(text)
        defaults: Any = VectorEnv.__init__.__kwdefaults__
        self.spec = spec_of(self._arguments, {"num_envs": 1, **defaults})
        if GYMNASIUM_1:
            self.spec.kwargs["vectorization_mode"] = "vector_entry_point"

    def _open(
        self,
        obs_mode: str,
        exported: Callable[[Any], Callable[[], Any]],
        privileged: bool,
        language: bool,
    ) -> None:
        """Sets up the description, spaces and views of an open batch."""
        batch = self._batch
        self.closed = False
        _open_batches.add(self)
        self.num_envs = batch.num_envs
        self.description: TaskDescription = json.loads(batch.description)
        self._group = TaskGroup(self.description, self.num_envs)
        self._views: dict[str, Any] = {name: batch.output(name) for name in batch.output_names}
        self._layout = Layout(obs_mode, self.description, self._views)
        self.single_observation_space = self._layout.single
        self.observation_space = self._layout.batched
        self.single_action_space, self.action_space = action_spaces(
            *batch.action_bounds, self.num_envs
        )
        self._action_shape = (self.num_envs, batch.action_dim)
        self._observation = self._layout.views(self._views)
        self._observe = self._out.observation(self._layout, self._observation, exported)
        self._reward, self._terminated, self._truncated = (
            self._out.getter(name) if name in self._out else exported(self._views[name])
            for name in ("reward", "terminated", "truncated")
        )
        self._ones = np.ones(self.num_envs, np.bool_)
        self._ones.flags.writeable = False
        outputs = self.description["outputs"]
        self._infos = Infos(
            batch,
            self._views,
            self._layout,
            all_envs=self._ones,
            without=() if privileged else [o["name"] for o in outputs if o["privileged"]],
            same_step=self._same_step,
            exported=exported,
            language=language,
            group=self._group,
        )
        # Gymnasium 0.29 reads these.
        self.is_vector_env = True
        self.viewer = None

    # --- running ---

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[ObsT, dict[str, Any]]:
        """Starts new episodes.

        Args:
            seed: An int (environment i of each task gets ``seed + i``), one per environment (None
                in it: as without a seed), or None: the first reset uses the seed given to the
                constructor, later ones begin the next episode of each environment.
            options: {"reset_mask": N bools, True where an environment is to be reset; "pins": dict
                that replaces the pins of the environments that are reset; "constants": dict that
                replaces their narrower ranges, such as {"EMPTY_PHASE_STEPS": (1, 3)}, each within
                that of the batch; pins still win}. Of several tasks, pins and constants may be
                dicts by id: {"RememberColor3-VLA-v0": {"target": 2}}. Others, which wrappers add,
                are ignored.

        Returns:
            Observations and infos. With a mask, rows of environments that were not reset are
            those of the last step, and the masks in the infos are False for them.

        Raises:
            InvalidArgumentError: A mask, seed or pin is of the wrong shape, type or range.
            UnknownIdError: No pin of that name, or an option that is nearly one of those above.
            BadStateError: The first reset leaves environments out, or a step is under way.
        """
        which = self._resetter.reset(seed, options)
        self._infos.refresh_instructions(np.flatnonzero(which))
        return self._outputs(which)

    def step(self, actions: Any) -> tuple[ObsT, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """One control step (0.05 s) of all environments.

        Args:
            actions: (N, action_dim), any real dtype; float32 without gaps is taken as it is.

        Returns:
            Observations; rewards, float32 (N,); terminated and truncated, bool (N,); infos. In the
            mode SAME_STEP, infos hold "final_obs" and "final_info" when episodes have ended.

        Raises:
            InvalidArgumentError: Wrong shape or type, or a value that is not finite.
            BadStateError: Nothing was reset, a step is under way, the batch is closed, or, in the
                mode DISABLED, an episode has ended that was not reset (see ``after_end``).
        """
        self._advance(actions)
        return self._results()

    def step_async(self, actions: Any) -> None:
        """Begins a step and returns; engram's threads work on it.

        Actions are copied. Until ``step_wait`` returns, views change and must not be read, and
        other calls are refused with BadStateError.
        """
        try:
            self._batch.step_async(methods.checked_actions(actions, self._action_shape))
        except BadStateError as error:
            raise_if_ended(error, self._views)
            raise

    def step_wait(
        self, **_: Any
    ) -> tuple[ObsT, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """Waits for the step that ``step_async`` began; returns what ``step`` returns.

        Ctrl-C ends a method of a task in Python that does not return, in all batches that step in
        the background.

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

    def act(self, policy: Policy = "oracle", out: np.ndarray | None = None) -> np.ndarray:
        """Actions for the next step.

        Args:
            policy: "oracle" solves the task with privileged state, "blind" is the oracle that must
                guess what the cue showed, "sweep" does the best that can be done without memory
                (all three in pd_ee_delta_pose, pd_joint_pos and pd_joint_delta_pos), "random" is
                uniform over the action space, "zero".
            out: float32 (N, action_dim) to write to, instead of a new array.
        """
        number = one_of("policy", policy, POLICY)
        if out is None:
            out = np.empty(self._action_shape, np.float32)
        else:
            methods.check_actions_out(out, self._action_shape)
        self._batch.act(number, out)
        return out

    # --- rendering, snapshots ---

    def render(self) -> tuple[np.ndarray, ...] | None:
        """One image per environment, uint8 (height, width, 3); None without a render mode."""
        if self.render_mode is None:
            return None
        return tuple(self.frame(i) for i in range(self.num_envs))

    def save(self, index: int | None = None) -> bytes:
        """One environment, or the whole batch, bit-exactly: physics, task and random stream."""
        return self._batch.save(methods.batch_index(index, self.num_envs))

    def restore(self, data: bytes, index: int | None = None) -> tuple[Any, dict[str, Any]]:
        """Restores what ``save`` returned; returns the observation and infos at that point.

        A saved environment can be restored at any index of any batch of the same task, control mode
        and task options, a saved batch into such a batch of the same size. The other options, such
        as the observation mode, are those of the batch it is restored into.

        Raises:
            InvalidArgumentError: The bytes are damaged, or of another task, version or size.
        """
        if not isinstance(data, bytes):
            raise InvalidArgumentError(f"data: {methods.kind_of(data)} given, bytes needed")
        self._batch.restore(methods.batch_index(index, self.num_envs), data)
        self._resetter.started = True
        self._infos.refresh_instructions(range(self.num_envs))
        return self._outputs(self._ones)

    # --- state, end ---

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
        # Exceptions of finalizers cannot be caught: the interpreter only prints them.
        with contextlib.suppress(Exception):
            self.close()

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickling keeps the specification: the copy is a new batch, not yet reset."""
        return _remake, (deepcopy(self._arguments),)

    def __deepcopy__(self, memo: dict[int, Any]) -> VectorEnv[ObsT]:
        return _remake(deepcopy(self._arguments))

    def __len__(self) -> int:
        return self.num_envs

    def __repr__(self) -> str:
        mode = self.autoreset_mode.name
        return f"<engram.VectorEnv {self._summary(num_envs=self.num_envs, autoreset_mode=mode)}>"

    __str__ = __repr__

    def _summary(self, **more: Any) -> str:
        """The task and its modes, for ``repr``."""
        given = self._arguments
        modes = {name: given[name] for name in ("obs_mode", "reward_mode")}
        modes["control_mode"] = self.description["control_mode"]
        words = [f"{name}={value}" for name, value in {**modes, **more}.items()]
        return ", ".join([self.task_id, *words, *(["closed"] if self.closed else [])])

    # --- internals ---

    def _advance(self, actions: Any) -> None:
        """A step without results: views have them."""
        try:
            self._batch.step(methods.checked_actions(actions, self._action_shape))
        except BadStateError as error:
            raise_if_ended(error, self._views)
            raise

    def _outputs(self, which: np.ndarray) -> tuple[ObsT, dict[str, Any]]:
        """Observations and infos."""
        return self._observe(), self._infos.columns(which)

    def _results(self) -> tuple[ObsT, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        infos = self._infos
        finals = infos.finals() if self._same_step else None
        if finals is None and infos.language:
            infos.refresh_instructions(np.flatnonzero(self._views["elapsed_steps"] == 0))
        observation, info = self._observe(), infos.columns(self._ones)
        if finals is not None:
            info.update(finals)
        return observation, self._reward(), self._terminated(), self._truncated(), info


def _remake(arguments: dict[str, Any]) -> VectorEnv[Any]:
    return VectorEnv(**arguments)
