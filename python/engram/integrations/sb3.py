"""A batch as a Stable-Baselines3 VecEnv."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.vec_env import VecEnv

from engram._args.keywords import check_single
from engram.envs.compat import AutoresetMode
from engram.errors import InvalidArgumentError
from engram.factory import make_vec
from engram.integrations.periodic import Lockstep, PeriodicEvaluation
from engram.wrappers import WrappedPolicy

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from engram.typing import EnvOptions, ObsMode


class Sb3VecEnv(VecEnv):
    """engram's batch in Stable-Baselines3's conventions.

    All arrays are copies, because its algorithms keep them. Infos are empty
    dicts, except in the step that ends an episode: then they hold "terminal_observation",
    "TimeLimit.truncated", "is_success" (success at any time of the episode), "episode" (return,
    length and seconds, as its Monitor gives them) and the task's own fields. The observation mode
    "state_dict" is not supported (its policies know no nested dicts).

    Its policies for dicts ("MultiInputPolicy", "MultiInputLstmPolicy") take all of an rgb
    observation; those for images ("CnnPolicy", "CnnLstmPolicy") need ``images_only``.

    Args:
        id: Task, such as "RememberColor3-VLA-v0".
        num_envs: Number of environments.
        obs_mode: See ``VectorEnv``.
        images_only: An rgb observation is its images alone, without proprio and task_cue.
        preset: "train": wrapped by ``engram.wrappers.train``; see ``engram.make_vec``.
        **options: Those of ``VectorEnv``, except autoreset_mode and copy.
    """

    def __init__(
        self,
        id: str,
        num_envs: int = 1,
        *,
        obs_mode: ObsMode = "state",
        images_only: bool = False,
        preset: Literal["train"] | None = None,
        **options: Unpack[EnvOptions],
    ) -> None:
        check_single("Sb3VecEnv", options, own=("num_envs", "images_only", "preset"))
        if images_only and obs_mode != "rgb":
            raise InvalidArgumentError(f"images_only: obs_mode={obs_mode!r} given, 'rgb' needed")
        given: dict[str, Any] = {"preset": preset, "obs_mode": obs_mode, **options}
        self.arguments = {"id": id, **given}
        self.batch: Any = make_vec(id, num_envs, autoreset_mode=AutoresetMode.SAME_STEP, **given)
        self._images_only = images_only
        self._start = time.time()
        space: Any = self.batch.single_observation_space
        super().__init__(
            num_envs, space["rgb"] if images_only else space, self.batch.single_action_space
        )

    def __repr__(self) -> str:
        return f"<engram.integrations.sb3.Sb3VecEnv of {self.batch!r}>"

    def reset(self) -> Any:
        """Starts new episodes; ``seed`` and ``set_options`` take effect here."""
        seeds = self._seeds if any(seed is not None for seed in self._seeds) else None
        options = next((options for options in self._options if options), None)
        observation, _ = self.batch.reset(seed=seeds, options=options)
        self._reset_seeds()
        self._reset_options()
        self.reset_infos = [{} for _ in range(self.num_envs)]
        return self._converted(observation)

    def step_async(self, actions: np.ndarray) -> None:
        """Begins a step."""
        self.batch.step_async(actions)

    def step_wait(self) -> tuple[Any, np.ndarray, np.ndarray, list[dict[str, Any]]]:
        """Waits for the step: observations, rewards, dones, infos."""
        observation, reward, terminated, truncated, info = self.batch.step_wait()
        dones = terminated | truncated
        infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        for i in np.flatnonzero(dones):
            infos[i] = self._final_info(info, int(i), bool(truncated[i] and not terminated[i]))
        return self._converted(observation), reward, dones, infos

    def _converted(self, observation: Any) -> Any:
        return observation["rgb"] if self._images_only else observation

    def _final_info(self, info: dict[str, Any], index: int, truncated: bool) -> dict[str, Any]:
        views = self.batch.unwrapped._infos.final_views
        result: dict[str, Any] = {name: view[index].copy() for name, view in views.items()}
        result["terminal_observation"] = self._converted(info["final_obs"][index])
        result["TimeLimit.truncated"] = truncated
        result["is_success"] = bool(views["success_once"][index])
        result["episode"] = {
            "r": float(views["episode_return"][index]),
            "l": int(views["elapsed_steps"][index]),
            "t": round(time.time() - self._start, 6),
        }
        return result

    def close(self) -> None:
        """Ends the batch."""
        self.batch.close()

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """An attribute of the chosen environments; see ``SubEnv``."""
        return [getattr(self.batch.envs[i], attr_name) for i in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        """Sets an attribute of the chosen environments."""
        for i in self._get_indices(indices):
            setattr(self.batch.envs[i], attr_name, value)

    def env_method(
        self, method_name: str, *method_args: Any, indices: Any = None, **method_kwargs: Any
    ) -> list[Any]:
        """Calls a method of the chosen environments."""
        return [
            getattr(self.batch.envs[i], method_name)(*method_args, **method_kwargs)
            for i in self._get_indices(indices)
        ]

    def env_is_wrapped(self, wrapper_class: type, indices: Any = None) -> list[bool]:
        """False: there are no wrappers."""
        return [False for _ in self._get_indices(indices)]

    def get_images(self) -> Sequence[np.ndarray | None]:
        """One image per environment."""
        return self.batch.render() or [None] * self.num_envs


class EvaluationCallback(BaseCallback):
    """Evaluates an agent of Stable-Baselines3 during its training.

    ::

        evaluation = PeriodicEvaluation("RememberColor3-VLA-v0", every=50_000, obs="objects")
        model.learn(1_000_000, callback=EvaluationCallback(evaluation))

    The logger gets ``eval/success``, ``eval/low``, ``eval/high`` and, where the task has answers,
    ``eval/first_answer``. Observations are those of the training: by the ``preset`` of its
    ``Sb3VecEnv``, and by ``VecNormalize`` if there is one. Recurrent policies of sb3-contrib begin
    each episode without memory.

    Args:
        evaluation: When and what; its ``obs`` is the training's obs_mode.
        deterministic: Acts by the mode of the agent's distribution.
        verbose: 1: prints each record.
    """

    def __init__(
        self, evaluation: PeriodicEvaluation, *, deterministic: bool = True, verbose: int = 0
    ) -> None:
        super().__init__(verbose)
        self.evaluation = evaluation
        self._deterministic = deterministic

    def _on_training_start(self) -> None:
        self._on_step()

    def _on_step(self) -> bool:
        if self.evaluation.due(self.num_timesteps):
            record = self.evaluation.run(self.num_timesteps, self._policy())
            for name in ("success", "low", "high", "first_answer"):
                if record[name] is not None:
                    self.logger.record(f"eval/{name}", record[name])
            if self.verbose:
                print({name: value for name, value in record.items() if value is not None})
        return True

    def _policy(self) -> Any:
        """The agent as a policy of engram.evaluate."""
        env: Any = self.training_env
        while hasattr(env, "venv"):
            env = env.venv
        if not isinstance(env, Sb3VecEnv):
            raise InvalidArgumentError(f"EvaluationCallback: {env!r} given, an Sb3VecEnv needed")
        act = _Agent(self.model, self._deterministic)
        if env.arguments["obs_mode"] == "rgb":
            return Lockstep(lambda seen, begins: act(_image_observation(env, seen), begins))
        wrapped = make_vec(num_envs=self.evaluation.num_envs, **env.arguments)
        return WrappedPolicy(wrapped, act)


def _image_observation(env: Sb3VecEnv, seen: dict[str, Any]) -> Any:
    space: Any = env.observation_space
    names = getattr(space, "spaces", None)
    if names is None:
        return seen["rgb"]
    missing = set(names) - seen.keys()
    if missing:
        raise InvalidArgumentError(
            f"EvaluationCallback: the agent observes {', '.join(sorted(missing))}, which "
            "evaluations do not give; rgb and proprio allowed"
        )
    return {name: seen[name] for name in names}


class _Agent:
    """Actions of an agent and its memory, for rows of a fixed number."""

    def __init__(self, model: Any, deterministic: bool) -> None:
        self._model = model
        self._deterministic = deterministic
        self._memory: Any = None

    def __call__(self, observation: Any, begins: np.ndarray) -> np.ndarray:
        normalize = self._model.get_vec_normalize_env()
        if normalize is not None:
            observation = normalize.normalize_obs(observation)
        actions, self._memory = self._model.predict(
            observation,
            self._memory,
            episode_start=begins,
            deterministic=self._deterministic,
        )
        return actions
