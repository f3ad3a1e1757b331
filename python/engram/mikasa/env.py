"""A batch of environments behind the original's interface: one gymnasium.Env, torch tensors."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import gymnasium as gym
import numpy as np

from engram.envs.vector_env import VectorEnv
from engram.errors import BadStateError, InvalidArgumentError
from engram.mikasa import (
    _families,
    _forms,
    _keywords,
    _legacy_attributes,
    _observing,
    _rendering,
    _rl_families,
)
from engram.mikasa._torch import CPU, torch
from engram.mikasa._variants import (
    TaskMeta,
    changed_constants,
    own_constants,
    own_instruction,
)
from engram.mikasa.agent import AGENTS
from engram.mikasa.scene import Scene

_NO_LIMIT = 1_000_000  # control steps: the time limit around the environment ends episodes
_FIRST_SEED = 2022
_PHASE_LENGTHS = ("cue_steps_per_env", "empty_steps_per_env")


class BaseEnv(gym.Env[Any, Any], metaclass=TaskMeta):
    """A batch of environments of one task; ``gym.make`` makes it, within a time limit.

    All results are torch tensors on the CPU whose first dimension is the batch, for one environment
    too. They are copies.

    Args:
        num_envs: Number of environments.
        robot_uids: "panda_wristcam" or "panda".
        robot_init_qpos_noise: Standard deviation of the start pose's noise, rad.
        reconfiguration_freq: Full resets from one to the next ``info["reconfigure"]``; None: 0, in
            the shell games 1 for one environment.
        **keywords: Further ones of ``gym.make``; docs/mikasa.md has them all.
    """

    metadata: dict[str, Any] = {  # noqa: RUF012
        "render_modes": list(_keywords.RENDER_MODES),
        "render_fps": 20,
    }
    SUPPORTED_ROBOTS: ClassVar[list[str]] = ["panda", "panda_wristcam"]
    SUPPORTED_REWARD_MODES: ClassVar[tuple[str, ...]] = (
        "normalized_dense",
        "dense",
        "sparse",
        "none",
    )
    sim_freq = 100
    control_freq = 20
    sim_timestep = 0.01
    control_timestep = 0.05
    device = CPU

    _task: ClassVar[str]
    _family: ClassVar[str]
    _rl: ClassVar[bool] = False  # of the RL half

    def __init__(
        self,
        num_envs: int = 1,
        *,
        robot_uids: str = "panda_wristcam",
        robot_init_qpos_noise: float = 0.02,
        reconfiguration_freq: int | None = None,
        **keywords: Any,
    ) -> None:
        cls = type(self)
        if not hasattr(cls, "_task"):
            raise InvalidArgumentError("BaseEnv given; a class of a task is needed")
        constants = changed_constants(cls)
        takes = {
            **dict.fromkeys(_families.ROTATE, ("angle_threshold",)),
            "BlinkCountButtonPress": ("blink_color",),
        }
        steps = _rl_families.KEYWORDS.get(cls._family, {}) if cls._rl else {}
        chosen = _keywords.read(
            {
                **keywords,
                "num_envs": num_envs,
                "robot_uids": robot_uids,
                "robot_init_qpos_noise": robot_init_qpos_noise,
                "reconfiguration_freq": reconfiguration_freq,
            },
            takes=(*takes.get(cls._family, ()), *steps),
            constants=steps,
        )
        self._chosen = chosen
        self.num_envs = chosen.num_envs
        self.obs_mode = self._obs_mode = chosen.obs_mode
        self.control_mode = chosen.control_mode
        self.reward_mode = self._reward_mode = chosen.reward_mode
        self.render_mode = chosen.render_mode
        self.robot_uids = chosen.robot_uids
        self.robot_init_qpos_noise = chosen.options["robot_init_qpos_noise"]
        self.reconfiguration_freq = chosen.reconfiguration_freq
        if cls._family in _families.SHELL_GAMES and reconfiguration_freq is None:
            self.reconfiguration_freq = int(self.num_envs == 1)
        self._resets = 0
        self._drawn: dict[str, np.ndarray] | None = None
        options = dict(chosen.options)
        options["constants"] = {**constants, **options["constants"]}
        if options["constants"]:  # the base has no time limit
            options["constants"]["max_episode_steps"] = _NO_LIMIT
        self._env = self._open(options)
        self.task_id = self._env.task_id
        self._description = self._env.description
        self._constants = _forms.of_task(self._description["constants"], cls._family)
        for name, value in own_constants(cls).items():  # as they were set: a tuple, not a list
            if name in self._constants and _forms.same(value, self._constants[name]):
                self._constants[name] = value
        self.angle_threshold = options["constants"].get("angle_threshold", 0.1)
        self._observations = _observing.Observations(
            self._env,
            self._description,
            self.obs_mode,
            chosen.textures,
            chosen.cameras,
            chosen.image_size,
        )
        self._evaluation = _observing.Evaluation(
            self._env, self._description, own_instruction(cls), cls._rl
        )
        self.agent = AGENTS[self.robot_uids](self)
        self.scene = Scene(self)
        self.single_action_space: Any = self._env.single_action_space
        self.action_space: Any = (
            self.single_action_space if self.num_envs == 1 else self._env.action_space
        )
        observation, _ = self.reset()
        self.update_obs_space(observation)
        self._resets = 0

    def _open(self, options: dict[str, Any]) -> VectorEnv[Any]:
        chosen = self._chosen
        mode: Any = "+".join(chosen.textures) or chosen.obs_mode
        cameras: Any = chosen.cameras
        return VectorEnv(
            self._task,
            self.num_envs,
            obs_mode="state" if mode == "state_dict" else mode,
            seed=_FIRST_SEED,
            reward_mode=chosen.reward_mode,
            control_mode=chosen.control_mode,
            autoreset_mode="DISABLED",
            after_end="continue",
            terminate_on_success=False,
            terminate_on_failure=False,
            max_episode_steps=_NO_LIMIT,
            freeze_cue=False,  # a wrapper does that
            rules=chosen.rules,
            copy=False,
            privileged=True,
            cameras=cameras,
            image_size=chosen.image_size,
            render_size=chosen.render_size,
            **options,
        )

    # --- running ---

    def reset(
        self, *, seed: Any = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Starts new episodes.

        Args:
            seed: An int, a list of one per environment, or None: the next episodes. With an int
                environment i has ``seed + i``; in the RL half all but the first have seeds drawn
                from it, so that batches of following seeds share no episodes.
            options: {"env_idx": indices of those that are to be reset; "reconfigure": copied
                to the info}; others are those of ``engram.VectorEnv.reset``.
        """
        given = dict(options or {})
        indices = given.pop("env_idx", None)
        again = bool(given.pop("reconfigure", False))
        if indices is None:
            if self.reconfiguration_freq and self._resets % self.reconfiguration_freq == 0:
                again = again or self._resets > 0
            self._resets += 1
        else:
            mask = np.zeros(self.num_envs, np.bool_)
            mask[np.asarray(torch.as_tensor(indices).cpu())] = True
            given["reset_mask"] = mask
        self._env.reset(seed=self._seeds(seed), options=given)
        self._begun()
        info = self.get_info()
        observation = self.get_obs(info)
        info["reconfigure"] = again
        return observation, info

    def _seeds(self, seed: Any) -> Any:
        given = _keywords.seeds(seed)
        whole = isinstance(given, (int, np.integer)) and not isinstance(given, bool)
        return _keywords.drawn_seeds(int(given), self.num_envs) if self._rl and whole else given

    def step(  # type: ignore[override, unused-ignore]
        self, action: Any
    ) -> tuple[Any, torch.Tensor, torch.Tensor, torch.Tensor, dict[str, Any]]:
        """One control step (0.05 s) of all environments.

        Args:
            action: (B, D), or (D) for all of them; numbers that are finite. None: no new command;
                the drives keep their targets.
        """
        if action is None:
            self._env._batch.step_no_action()
        else:
            self._env._advance(self._actions(action))
        self._most_steps += 1
        info = self.get_info()
        observation = self.get_obs(info)
        reward = self.get_reward(obs=observation, action=action, info=info)
        return observation, reward, self._terminated(info), self._unstable(), info

    def _actions(self, action: Any) -> np.ndarray:
        if isinstance(action, torch.Tensor):
            action = action.detach().cpu().numpy()
        array = np.asarray(action)
        if array.ndim == 1:
            array = np.broadcast_to(array, (self.num_envs, *array.shape))
        return array

    def _terminated(self, info: Mapping[str, Any]) -> torch.Tensor:
        rule = self._description["termination"]
        if rule == "never":
            return torch.from_numpy(np.zeros(self.num_envs, np.bool_))
        ended = info["success"].numpy().copy()
        if rule != "success":
            ended |= info["submitted" if "submitted" in info else "failed"].numpy()
        return torch.from_numpy(ended)

    def _unstable(self) -> torch.Tensor:
        """Environments whose physics diverged; all other truncation is the wrapper's."""
        return _observing.tensor(self._env._views["unstable"])

    # --- results of a step ---

    def evaluate(self) -> dict[str, Any]:
        """The infos but for elapsed_steps; subclasses may add to them."""
        return self._evaluation()

    def get_info(self) -> dict[str, Any]:
        """Infos of the present state."""
        return {"elapsed_steps": self.elapsed_steps, **self.evaluate()}

    def get_obs(self, info: dict[str, Any] | None = None) -> Any:
        """Observation of the present state."""
        return self._observations()

    def get_reward(self, obs: Any, action: Any, info: dict[str, Any]) -> torch.Tensor:
        """The reward of the last step, in the environment's mode."""
        if self.reward_mode == "none":
            return torch.zeros(self.num_envs)
        compute = getattr(self, f"compute_{self.reward_mode}_reward")
        reward: torch.Tensor = compute(obs=obs, action=action, info=info)
        return reward

    def compute_sparse_reward(self, obs: Any, action: Any, info: dict[str, Any]) -> torch.Tensor:
        """Success, bool (B)."""
        success: torch.Tensor = info["success"]
        return success

    def compute_dense_reward(self, obs: Any, action: Any, info: dict[str, Any]) -> torch.Tensor:
        """The task's reward of the last step; arguments are ignored."""
        reward = self._computed_reward()
        if self.reward_mode == "normalized_dense":
            return reward * self._description["success_reward"]
        return reward

    def compute_normalized_dense_reward(
        self, obs: Any, action: Any, info: dict[str, Any]
    ) -> torch.Tensor:
        """The dense reward, divided by that of success."""
        own = type(self).compute_dense_reward is not BaseEnv.compute_dense_reward
        if own or self.reward_mode == "dense":
            dense = self.compute_dense_reward(obs=obs, action=action, info=info)
            return dense / self._description["success_reward"]
        return self._computed_reward()

    def _computed_reward(self) -> torch.Tensor:
        if self.reward_mode not in ("dense", "normalized_dense"):
            raise BadStateError(
                f"reward_mode {self.reward_mode}: dense rewards are not computed; make the "
                "environment with dense or normalized_dense"
            )
        return _observing.tensor(self._env._views["reward"])

    # --- attributes ---

    @property
    def elapsed_steps(self) -> torch.Tensor:
        """Control steps of the episodes so far, int32 (B)."""
        return _observing.tensor(self._env._views["elapsed_steps"])

    @property
    def task_cue(self) -> torch.Tensor | None:
        """The cue of the task: the angle in rad, the lamp's colour, the shapes."""
        return self._evaluation.task_cue()

    @property
    def oracle_info(self) -> torch.Tensor:
        """The answer."""
        return self._evaluation.oracle_info()

    @property
    def reward_dict(self) -> dict[str, torch.Tensor] | None:
        """Terms of the reward of the step before."""
        return self._evaluation.reward_dict()

    def update_obs_space(self, obs: Any) -> None:
        """Takes the spaces from an observation; wrappers that change observations call it."""
        self._init_raw_obs = obs
        self.observation_space = _observing.space_of(obs)
        self.single_observation_space = _observing.space_of(_observing.single(obs))

    def _view(self, name: str) -> np.ndarray | None:
        """A buffer of the core, or values drawn for the episodes; None: there is none."""
        view = self._env._views.get(name)
        if view is None:
            if self._drawn is None:
                self._drawn = self._env.drawn()
            view = self._drawn.get(name)
        return view

    def _begun(self) -> None:
        """Resets cached values after episodes have begun."""
        self._drawn = None
        self._most_steps = int(self._env._views["elapsed_steps"].max())  # no episode has had more
        self._evaluation.restart()

    def _robot_part(self, name: str) -> torch.Tensor:
        return _observing.tensor(self._env.robot_state()[name])

    def __getattr__(self, name: str) -> Any:
        """Constants, phases and outputs of the task."""
        if name.startswith("_") or "_env" not in self.__dict__:
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
        constants = self._constants
        if name.isupper() or name in constants:
            return constants[name] if name in constants else getattr(type(self), name)
        if self._rl and name in _PHASE_LENGTHS:  # fixed there
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
        if name == "shuffle_steps_per_env" and "Shuffle" in self._family:
            name = "empty_steps_per_env"
        computed = _legacy_attributes.attribute(self, name)
        if computed is not None:
            return computed
        view = self._view(name)
        if view is not None:
            return _observing.tensor(view, torch.int64 if view.dtype == np.int32 else None)
        computed = _legacy_attributes.of_state(self, name)
        if computed is not None:
            return computed
        raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")

    def __setattr__(self, name: str, value: Any) -> None:
        """Refuses constants: episodes have them from the class."""
        if name.isupper() and hasattr(type(self), name):
            raise AttributeError(
                f"{name}: {value!r} set on an environment; engram reads constants when it is made: "
                "set it in a subclass"
            )
        super().__setattr__(name, value)

    # --- rendering, states, end ---

    def render(self) -> torch.Tensor:  # type: ignore[override, unused-ignore]
        """Images, uint8 (B, height, width, 3), as render_mode says."""
        if self.render_mode is None:
            raise RuntimeError(
                "render_mode is None; make the environment with one of "
                f"{', '.join(self.metadata['render_modes'])}"
            )
        return _rendering.images(self._env, self.render_mode, self._chosen)

    render_rgb_array = render

    def get_state(self) -> torch.Tensor:
        """The batch, bit for bit, with the task's variables; bytes, uint8 (n)."""
        return torch.frombuffer(bytearray(self._env.save()), dtype=torch.uint8)

    def set_state(self, state: torch.Tensor, *_: Any) -> None:
        """Restores what ``get_state`` returned."""
        self._env.restore(bytes(state.numpy()))
        self._begun()

    def get_state_dict(self) -> dict[str, Any]:
        """The state of ``get_state`` in a dict."""
        return {"engram": self.get_state()}

    def set_state_dict(self, state: Mapping[str, Any], *_: Any) -> None:
        """Restores what ``get_state_dict`` returned."""
        if "engram" not in state:
            raise InvalidArgumentError(
                f"state: {', '.join(map(str, state))} given; engram restores what its own "
                "get_state_dict returned"
            )
        self.set_state(state["engram"])

    def close(self) -> None:
        """Ends the batch."""
        if "_env" in self.__dict__:
            self._env.close()
