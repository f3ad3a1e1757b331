"""Sets of wrappers with which plain learners with default hyperparameters learn."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from engram.errors import InvalidArgumentError
from engram.wrappers.actions import ScaleActions, SmoothActions
from engram.wrappers.base import Wrapper
from engram.wrappers.observations import ObjectRows, ScaleState, TimeLeft, has_rows
from engram.wrappers.rewards import HeldReward, PotentialReward

# Shares of the largest motions that an action of 1 is: translation, rotation and gripper of
# pd_ee_delta_pose, and any component of another mode.
POSE_SCALE = (0.3, 0.3, 0.3, 0.1, 0.1, 0.1, 0.5)
OTHER_SCALE = 0.3

# Terms of the task's reward in the potential, with their weights: the distances and poses that lead
# to success, one after the other. A task has those that its reward has. What an object is to do
# weighs more than the hand's way to it, because the hand leaves its best place to do it.
TERMS = {
    "tcp_to_obj_dist": 1.0,
    "tcp_to_hit_pose_dist": 1.0,
    "tcp_to_cube_dist": 1.0,
    "tcp_to_button_dist": 1.0,
    "tcp_push_dist": 1.0,
    "tcp_pull_dist": 1.0,
    "to_grip_dist": 1.0,
    "obj_to_goal_dist": 1.0,
    "place_in_goal_reward": 1.0,
    "place_back_reward": 3.0,
    "place_reward": 5.0,
    "keep_contact_reward": 1.0,
    "y_angle_reward": 5.0,
}
# Terms of a first stage, which count as reached, and of a second one, which count nothing, by the
# term that tells whether the first stage is over: the ball is within reach, or the cube has been on
# the target.
UNTIL = {
    "tcp_to_hit_pose_dist": "reached_status",
    "tcp_push_dist": "goal_reached_status",
    "place_in_goal_reward": "goal_reached_status",
}
SINCE = {
    "tcp_pull_dist": "goal_reached_status",
    "place_back_reward": "goal_reached_status",
    "keep_contact_reward": "goal_reached_status",
}
# Terms that tell that the hand or the object is where the arm has to stand still; the first that a
# task has counts.
STILL = "static_reward"
THERE = ("reached", "is_obj_placed", 'info["is_obj_placed"]')


def train(
    env: Any,
    *,
    gamma: float = 0.99,
    scale_actions: bool = True,
    smoothing: float = 0.0,
    scale_observations: bool = True,
    time_left: bool = True,
    potential: float = 1.0,
    terms: Mapping[str, float] | None = None,
    still: float = 0.0,
    bonus: float = 0.1,
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
        terms: Of the potential; None: those of ``TERMS`` that the task's reward has. Stages are
            those of ``UNTIL`` and ``SINCE``.
        still: Weight of standing still in the potential (``static_reward``), which counts where the
            arm has to (``THERE``) and nothing before; 0: none. Rewards that have no such term, or
            differ in it within the batch, stay without.
        bonus: Of ``HeldReward``; 0: none.
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
