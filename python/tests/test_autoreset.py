"""The three auto-reset modes against a plain Python reference: Gymnasium's SyncVectorEnv."""

from __future__ import annotations

import gymnasium
import numpy as np
import pytest
from conftest import ENDING_TASK, TASK, assert_same, noisy_oracle

import engram
from engram.envs.compat import GYMNASIUM_1

ALL_INFOS = {"privileged": True, "language_in_info": True}
MODES = ["NEXT_STEP", "SAME_STEP", "DISABLED"]
needs_1 = pytest.mark.skipif(not GYMNASIUM_1, reason="Gymnasium 0.29 knows one mode only")


def reference(id: str, num_envs: int, mode: str, **options):
    options = {**ALL_INFOS, **options}
    makers = [lambda: engram.make(id, **options) for _ in range(num_envs)]
    if not GYMNASIUM_1:
        assert mode == "SAME_STEP"
        return gymnasium.vector.SyncVectorEnv(makers)
    return gymnasium.vector.SyncVectorEnv(
        makers, autoreset_mode=gymnasium.vector.AutoresetMode[mode]
    )


def assert_same_info(ours: dict, theirs: dict) -> None:
    """Equal names, masks, and values where a mask is true."""
    extra = () if GYMNASIUM_1 else ("_final_obs",)  # 0.29's own name is final_observation
    assert {name for name in ours if name.startswith("_") and ours[name].any()}.difference(
        extra
    ) == {name for name in theirs if name.startswith("_")}
    for name in theirs:
        if name.startswith("_"):
            np.testing.assert_array_equal(ours[name], theirs[name], err_msg=name)
            continue
        mask = theirs[f"_{name}"]
        if isinstance(theirs[name], dict):
            assert_same_info(ours[name], theirs[name])
        elif name.startswith("final_"):  # one object per environment
            for i, (our_row, their_row) in enumerate(zip(ours[name], theirs[name])):
                assert (our_row is not None) == mask[i]
                if mask[i]:
                    assert_same(our_row, their_row)
        else:
            expected = theirs[name][mask]
            if expected.dtype == object and mask.any() and name != "language_instruction":
                expected = np.stack(expected)  # 0.29 does not stack arrays
            assert ours[name].dtype == (expected.dtype if mask.any() else ours[name].dtype), name
            np.testing.assert_array_equal(ours[name][mask], expected, err_msg=name)


def compare(env, other, steps: int) -> dict[str, int]:
    """Steps both with the same actions; counts what happened."""
    seen = {"terminated": 0, "truncated": 0, "final": 0}
    obs, info = env.reset(seed=20)
    other_obs, other_info = other.reset(seed=20)
    assert_same(obs, other_obs)
    assert_same_info(info, other_info)
    rng = np.random.default_rng(0)
    for step in range(steps):
        actions = noisy_oracle(env, rng)
        obs, reward, terminated, truncated, info = env.step(actions)
        other_obs, *other_rest, other_info = other.step(actions)
        assert_same(obs, other_obs, f"step {step}")
        for ours, theirs in zip((reward, terminated, truncated), other_rest):
            np.testing.assert_array_equal(ours, theirs, err_msg=f"step {step}")
        assert_same_info(info, other_info)
        seen["terminated"] += int(terminated.sum())
        seen["truncated"] += int(truncated.sum())
        seen["final"] += "final_info" in info
        done = terminated | truncated
        if env.autoreset_mode is engram.AutoresetMode.DISABLED and done.any():
            obs, info = env.reset(options={"reset_mask": done})
            other_obs, other_info = other.reset(options={"reset_mask": done.copy()})
            assert_same(obs, other_obs)
            assert_same_info(info, other_info)
    return seen


@pytest.mark.parametrize("mode", MODES if GYMNASIUM_1 else ["SAME_STEP"])
@pytest.mark.parametrize("id", [TASK, ENDING_TASK])
def test_modes_are_gymnasiums(make, id, mode):
    env = make(id, num_envs=3, autoreset_mode=mode, **ALL_INFOS)
    other = reference(id, 3, mode)
    seen = compare(env, other, 200)
    assert seen["truncated"] + seen["terminated"] >= 6
    assert (seen["final"] > 0) == (mode == "SAME_STEP")
    if id == ENDING_TASK:
        assert seen["terminated"] >= 6
    other.close()


@pytest.mark.parametrize("obs_mode", ["state_dict", "rgb", "objects_dict"])
def test_final_observations_have_the_form_of_the_space(make, obs_mode):
    options = {"obs_mode": obs_mode, **({"image_size": 16} if obs_mode == "rgb" else {})}
    env = make(num_envs=2, autoreset_mode="SAME_STEP", **ALL_INFOS, **options)
    other = reference(TASK, 2, "SAME_STEP", **options)
    assert compare(env, other, 30)["final"] == 1
    other.close()


def test_instructions_of_ended_and_new_episodes(make):
    env = make("RotateLenientPos-VLA-v0", num_envs=2, autoreset_mode="SAME_STEP", **ALL_INFOS)
    other = reference("RotateLenientPos-VLA-v0", 2, "SAME_STEP")
    assert compare(env, other, 200)["final"] > 0
    other.close()


@needs_1
def test_instructions_in_next_step_mode(make):
    env = make("RotateLenientPos-VLA-v0", num_envs=2, autoreset_mode="NEXT_STEP", **ALL_INFOS)
    other = reference("RotateLenientPos-VLA-v0", 2, "NEXT_STEP")
    compare(env, other, 200)
    other.close()


def played_to_the_end(env):
    """Steps to the horizon; what the last step returned."""
    env.reset(seed=0)
    for _ in range(env.description["horizon"]):
        last = env.step(env.act("random"))
    assert last[3].all()
    return last


@pytest.mark.parametrize("step", ["step", "step_async"])
def test_disabled_refuses_to_step_beyond_the_end(make, step):
    env = make(num_envs=3, autoreset_mode="DISABLED")
    played_to_the_end(env)
    saved = env.save()
    env.reset(options={"reset_mask": [True, False, False]})
    with pytest.raises(engram.BadStateError, match="environments 1, 2 have ended: reset"):
        getattr(env, step)(env.act("zero"))
    env.reset(options={"reset_mask": [False, True, True]})
    env.step(env.act("zero"))
    env.restore(saved)
    with pytest.raises(engram.BadStateError, match="environments 0, 1, 2 have ended"):
        getattr(env, step)(env.act("zero"))
    assert env.save() == saved  # the refused step changed nothing
    env.reset()
    env.step(env.act("zero"))


def test_a_restored_environment_may_go_on(make):
    env = make(num_envs=2, autoreset_mode="DISABLED")
    env.reset(seed=0)
    running = env.save()
    played_to_the_end(env)
    env.restore(running)
    env.step(env.act("zero"))


def test_ended_environments_are_held_on_request(make):
    env = make(num_envs=2, autoreset_mode="DISABLED", after_end="hold")
    last = played_to_the_end(env)
    after = env.step(env.act("zero"))
    np.testing.assert_array_equal(after[0], last[0])
    np.testing.assert_array_equal(after[1], [0, 0])
    assert after[3].all()


def test_ended_environments_go_on_on_request(make):
    env = make(num_envs=2, autoreset_mode="DISABLED", after_end="continue")
    horizon = env.description["horizon"]
    played_to_the_end(env)
    for i in range(1, 6):
        _, reward, _, truncated, info = env.step(np.full((2, 7), 0.5, np.float32))
        assert truncated.all()
        assert (info["elapsed_steps"] == horizon + i).all()
        assert (reward != 0).all()
    env.reset()
    assert not env.step(env.act("zero"))[3].any()


def test_a_single_environment_continues_after_the_end_on_request():
    env = engram.make(TASK, after_end="continue", max_episode_steps=3)
    env.reset(seed=1)
    ends = [env.step(env.act("random"))[3] for _ in range(6)]
    assert ends == [False, False, True, True, True, True]
    env.close()


@pytest.mark.parametrize("on", [True, False])
def test_only_the_horizon_ends_an_episode_on_request(on):
    options = {} if on else {"terminate_on_success": False, "terminate_on_failure": False}
    id = "TimedTransferEasy-VLA-v0"
    env = engram.make_vec(id, 1, autoreset_mode="DISABLED", after_end="hold", **options)
    env.reset(seed=0)
    ended = [bool(env.step(env.act("oracle"))[2][0]) for _ in range(env.description["horizon"])]
    assert any(ended) == on
    env.close()


@pytest.mark.parametrize(
    ("given", "mode"),
    [
        ("next-step", "NEXT_STEP"),
        ("NextStep", "NEXT_STEP"),
        ("same-step", "SAME_STEP"),
        ("off", "DISABLED"),
        ("Disabled", "DISABLED"),
        (engram.AutoresetMode.DISABLED, "DISABLED"),
        (None, "NEXT_STEP" if GYMNASIUM_1 else "SAME_STEP"),
    ],
)
def test_spellings_of_modes(make, given, mode):
    env = make(num_envs=1, autoreset_mode=given)
    assert env.metadata["autoreset_mode"] is engram.AutoresetMode[mode]
