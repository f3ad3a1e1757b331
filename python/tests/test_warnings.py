"""Constants that a rule set does not use are warned of by name."""

import warnings

import gymnasium
import pytest

import engram

ID = "SeqOfColors3-VLA-v0"
WARNING = r"GOAL_THRESH=0\.08 has no effect on touch_radius, which is 0\.02 with rules=original"


@pytest.mark.parametrize(
    "make",
    [
        lambda **options: engram.make(ID, **options),
        lambda **options: engram.make_vec(ID, 2, **options),
        lambda **options: gymnasium.make(f"engram/{ID}", **options),
    ],
    ids=["make", "make_vec", "gymnasium"],
)
def test_goal_thresh_without_effect_is_warned_of_at_the_callers_line(make):
    with pytest.warns(UserWarning, match=WARNING) as caught:
        make(rules="original", constants={"GOAL_THRESH": 0.08}).close()
    (warning,) = [one for one in caught if "GOAL_THRESH" in str(one.message)]
    assert warning.filename == __file__


@pytest.mark.parametrize(
    "options",
    [
        {"constants": {"GOAL_THRESH": 0.08}},
        {"rules": "original", "constants": {"CUBE_HALFSIZE": 0.018}},
        {
            "rules": "original",
            "constants": {"GOAL_THRESH": 0.08},
            "task_options": {"touch_radius": 0.08},
        },
    ],
)
def test_nothing_is_warned_of_that_has_an_effect(options):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        engram.make(ID, **options).close()
        assert engram.describe(ID, **options)["warnings"] == []


def test_an_evaluation_warns_too():
    with pytest.warns(UserWarning, match=WARNING):
        engram.evaluate(
            lambda observation: [[0.0] * 7] * len(observation["instruction"]),
            ID,
            episodes=1,
            num_envs=1,
            threads=1,
            obs="state",
            rules="original",
            constants={"GOAL_THRESH": 0.08, "max_episode_steps": 60},
        )


def test_an_evaluation_warns_of_values_with_which_the_oracle_fails():
    with pytest.warns(UserWarning, match="GOAL_THRESH=0.005 is below 0.01, where the oracle"):
        engram.evaluate(
            lambda observation: [[0.0] * 7] * len(observation["instruction"]),
            "RememberColor3-VLA-v0",
            episodes=1,
            num_envs=1,
            threads=1,
            obs="state",
            constants={"GOAL_THRESH": 0.005},
        )
