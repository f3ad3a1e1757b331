"""Sets of wrappers with which plain learners with default hyperparameters learn."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from engram.errors import InvalidArgumentError
from engram.wrappers.actions import ScaleActions, SmoothActions
from engram.wrappers.base import Wrapper
from engram.wrappers.numbers import OTHER_SCALE, POSE_SCALE, SINCE, STILL, TERMS, THERE, UNTIL
from engram.wrappers.observations import ObjectRows, ScaleState, TimeLeft, has_rows
from engram.wrappers.rewards import HeldReward, PotentialReward


def train(
    env: Any,
    *,
    # begin generated: options (tools/surface, and the arguments below)
    gamma: float = 0.99,
    scale_actions: bool = True,
    smoothing: float = 0.0,
    scale_observations: bool = True,
    time_left: bool = True,
    potential: float = 1.0,
    still: float = 0.0,
    bonus: float = 0.1,
    # end generated
    terms: Mapping[str, float] | None = None,
) -> Any:
    """The batch in the wrappers of the preset "train", in the order of the arguments.

    Args:
        env: A batch whose episodes end at success (``terminate_on_success=True``).
        gamma: Discount of the learner.
        scale_actions: ``ScaleActions``: an action of 1 is 0.3 of the arm's largest motion, 0.1 of
            its largest rotation, 0.5 of the gripper's.
        smoothing: Of ``SmoothActions``; 0: none.
        scale_observations: ``ScaleState`` or ``ObjectRows``, where observations are rows.
        time_left: ``TimeLeft``, where observations are rows.
        potential: Weight of the dense reward in ``PotentialReward``; 0: no potential.
        still: Weight of standing still in the potential (``static_reward``), which counts where the
            arm has to (``THERE``) and nothing before; 0: none. Rewards that have no such term, or
            differ in it within the batch, stay without.
        bonus: Of ``HeldReward``; 0: none.
        terms: Of the potential; None: those of ``TERMS`` that the task's reward has. Stages are
            those of ``UNTIL`` and ``SINCE``.
    """
    if scale_actions:
        pose = env.description["control_mode"] == "pd_ee_delta_pose"
        env = ScaleActions(env, POSE_SCALE if pose else OTHER_SCALE)
    if smoothing:
        env = SmoothActions(env, smoothing)
    if has_rows(env):
        names = [field["name"] for field in env.description["state_fields"]]
        if scale_observations:
            env = ObjectRows(env) if "object_0_seen" in names else ScaleState(env)
        if time_left:
            env = TimeLeft(env)
    if potential:
        theirs = {name for i in range(env.num_envs) for name in env.task_of(i)["reward_terms"]}
        known = {name: weight for name, weight in TERMS.items() if name in theirs}
        terms = known if terms is None else terms
        until, since = (
            {name: done for name, done in stage.items() if name in terms and done in theirs}
            for stage in (UNTIL, SINCE)
        )
        place = _where_to_stand_still(env) if still else None
        if place:
            terms, since = {**terms, STILL: still}, {**since, STILL: place}
        env = PotentialReward(env, gamma, potential, terms, until, since)
    return HeldReward(env, gamma, bonus) if bonus else env


def _where_to_stand_still(env: Any) -> str | None:
    """The term of ``THERE`` that all rewards have which pay standing still."""
    tasks = [env.task_of(i)["reward_terms"] for i in range(env.num_envs)]
    tasks = [names for names in tasks if STILL in names]
    common = (name for name in THERE if tasks and all(name in names for names in tasks))
    return next(common, None)


# Wrappers and the options of the batch inside, by the preset's name.
PRESETS: dict[str, tuple[Callable[[Any], Any], dict[str, Any]]] = {
    "train": (train, {"terminate_on_success": True}),
}


def wrapped(preset: str, make: Callable[[Mapping[str, Any]], Any]) -> Wrapper:
    """Makes a batch, with the options that the preset has by default, and wraps it."""
    if preset not in PRESETS:
        raise InvalidArgumentError(f"preset: {preset!r} given; allowed: {', '.join(PRESETS)}")
    wrap, defaults = PRESETS[preset]
    result: Wrapper = wrap(make(defaults))
    return result
