from __future__ import annotations

import copy
import pickle

import gymnasium
import numpy as np
import pytest
from conftest import TASK, assert_same

import engram
from engram._args.option_list import OBS_MODE
from engram.envs.compat import GYMNASIUM_1
from engram.envs.spaces import take


@pytest.mark.parametrize("obs_mode", OBS_MODE)
def test_observations_lie_in_their_space(make, obs_mode):
    env = make(obs_mode=obs_mode, num_envs=3)
    obs, _ = env.reset(seed=1)
    for _ in range(3):
        assert env.observation_space.contains(obs)
        single = env.single_observation_space
        assert single.contains(take(obs, 1))
        obs, *_ = env.step(env.act("random"))


def test_state_dict_names_the_parts_of_state(make):
    rows, _ = make(obs_mode="state").reset(seed=3)
    parts, _ = make(obs_mode="state_dict").reset(seed=3)
    assert list(parts) == ["agent", "extra"]
    assert list(parts["agent"]) == ["qpos", "qvel"]
    assert parts["agent"]["qpos"].shape == (4, 9)
    flat = np.concatenate([a for part in parts.values() for a in part.values()], axis=1)
    np.testing.assert_array_equal(flat, rows)


def test_rgb_observation_is_the_canonical_one(make):
    obs, _ = make(obs_mode="rgb", num_envs=2).reset(seed=0)
    assert list(obs) == ["rgb", "proprio"]
    assert obs["rgb"].shape == (2, 128, 128, 6)
    assert obs["rgb"].dtype == np.uint8
    assert obs["rgb"].std() > 10
    assert obs["proprio"].shape == (2, 7)
    assert obs["proprio"][0, 2] == pytest.approx(0.318, abs=0.05)
    assert "task_cue" not in obs
    assert "oracle_info" not in obs


def test_only_rotate_tasks_observe_their_cue(make):
    env = make("RotateStrictPos-VLA-v0", obs_mode="rgb", num_envs=2)
    obs, info = env.reset(seed=5)
    assert obs["task_cue"].shape == (2, 1)
    assert obs["task_cue"].dtype == np.float32
    assert "task_cue" not in info


def test_instructions_are_those_of_the_running_episodes(make):
    env = make("RotateStrictPos-VLA-v0", num_envs=2, language_in_info=True)
    _, info = env.reset(seed=5)
    assert all(isinstance(text, str) and text for text in env.instructions)
    assert env.instructions[0] != env.instructions[1]
    assert env.instructions == list(info["language_instruction"])
    before = env.instructions
    _, info = env.reset()
    assert before != env.instructions == list(info["language_instruction"])


@pytest.mark.parametrize("id", ["RememberColor3-VLA-v0", "TraceShapeSeqEasy-VLA-v0"])
def test_privileged_infos_are_opt_in(make, id):
    privileged = {o["name"] for o in engram.describe(id)["outputs"] if o["privileged"]}
    assert privileged >= {"observation", "oracle_info", "obj_to_goal_pos", "reward_dict"}
    plain = make(id, autoreset_mode="SAME_STEP", max_episode_steps=None)
    _, info = plain.reset(seed=0)
    assert not privileged & set(info)
    assert "success" in info
    assert "language_instruction" not in info
    _, everything = make(id, privileged=True).reset(seed=0)
    assert set(everything) - set(info) == {
        name for n in privileged - {"observation"} for name in (n, f"_{n}")
    }
    np.testing.assert_array_equal(
        everything["oracle_info"], np.stack(plain.call("output", "oracle_info"))
    )


@pytest.mark.parametrize("copies", [True, False])
def test_a_changed_info_changes_no_later_one(make, copies):
    env = make(copy=copies, num_envs=2)
    env.reset(seed=0)
    info = env.step(env.act("zero"))[-1]
    names = list(info)
    info["elapsed_steps"] = "mine"
    del info["success"]
    later = env.step(env.act("zero"))[-1]
    assert list(later) == names
    np.testing.assert_array_equal(later["elapsed_steps"], [2, 2])
    assert later["_elapsed_steps"].all()
    assert (later["elapsed_steps"] is env.step(env.act("zero"))[-1]["elapsed_steps"]) != copies


def test_final_infos_do_not_reveal_the_answer(make):
    env = make(num_envs=2, autoreset_mode="SAME_STEP")
    env.reset(seed=0)
    for _ in range(25):
        info = env.step(env.act("zero"))[4]
    final = info["final_info"] if GYMNASIUM_1 else info["final_info"][0]
    assert "success_once" in final
    assert "oracle_info" not in final
    assert "reward_dict" not in final


def test_image_size_and_cameras_shape_the_observation(make):
    env = make(obs_mode="rgb", image_size=(48, 32), cameras=["base_camera"], num_envs=1)
    assert env.observation_space["rgb"].shape == (1, 32, 48, 3)
    assert env.reset()[0]["rgb"].shape == (1, 32, 48, 3)


def test_environment_i_has_seed_plus_i(make):
    batch, _ = make(num_envs=3).reset(seed=4242424242)
    for i in range(3):
        single, _ = make(num_envs=1).reset(seed=4242424242 + i)
        np.testing.assert_array_equal(batch[i], single[0])


def test_the_constructor_seed_serves_the_first_reset(make):
    first, _ = make(seed=11).reset()
    again, _ = make().reset(seed=11)
    np.testing.assert_array_equal(first, again)


def test_without_a_seed_environments_go_on_to_the_next_episode(make):
    env = make()
    first, _ = env.reset(seed=11)
    second, _ = env.reset()
    assert not np.array_equal(first, second)
    env.reset(seed=11)
    np.testing.assert_array_equal(env.reset()[0], second)


def test_seeds_may_be_a_list_with_gaps(make):
    env = make(seed=50)
    first, _ = env.reset(seed=[7, None, 9, None])
    expected, _ = make().reset(seed=[7, 51, 9, 53])
    np.testing.assert_array_equal(first, expected)
    second, _ = env.reset(seed=[7, None, None, 9])
    np.testing.assert_array_equal(second[0], first[0])
    np.testing.assert_array_equal(second[3], make(num_envs=1).reset(seed=9)[0][0])
    assert not np.array_equal(second[1], first[1])


def test_seed_none_is_drawn_from_the_system(make):
    assert not np.array_equal(make(seed=None).reset()[0], make(seed=None).reset()[0])


def test_reset_mask_does_not_change_other_environments(make):
    env = make(autoreset_mode="DISABLED")
    env.reset(seed=0)
    obs, *_ = env.step(env.act("random"))
    mask = np.array([True, False, False, True])
    after, info = env.reset(options={"reset_mask": mask})
    np.testing.assert_array_equal(info["_elapsed_steps"], mask)
    np.testing.assert_array_equal(info["elapsed_steps"], [0, 1, 1, 0])
    np.testing.assert_array_equal(after[~mask], obs[~mask])
    assert not np.array_equal(after[mask], obs[mask])


@pytest.mark.parametrize("mask", [[True, False, False, True], (True, False, False, True)])
def test_a_reset_mask_may_be_a_list(make, mask):
    env = make(autoreset_mode="DISABLED")
    env.reset(seed=0)
    env.step(env.act("random"))
    _, info = env.reset(options={"reset_mask": mask})
    np.testing.assert_array_equal(info["elapsed_steps"], [0, 1, 1, 0])


def test_options_that_wrappers_add_are_ignored(make):
    env, plain = make(), make()
    obs, _ = env.reset(seed=0, options={"lerobot_new_rollout": True, "episode": 3, 7: None})
    np.testing.assert_array_equal(obs, plain.reset(seed=0)[0])


def test_a_batch_has_a_length(make):
    assert len(make(num_envs=3)) == 3


def test_pins_fix_random_variables(make):
    env = make(num_envs=8, pins={"target": 2}, privileged=True)
    info = env.reset(seed=0)[1]
    np.testing.assert_array_equal(info["oracle_info"].ravel(), np.full(8, 2))
    info = env.reset(options={"pins": {"target": [1]}})[1]
    np.testing.assert_array_equal(info["oracle_info"].ravel(), np.full(8, 1))
    env.reset(options={"pins": {}})
    seen = {int(v) for _ in range(4) for v in env.reset()[1]["oracle_info"].ravel()}
    assert len(seen) > 1


def test_task_options_reach_the_task(make):
    described = engram.describe("BunchOfColors3-VLA-v0")["options"]
    assert "touch_radius" in [option["name"] for option in described]
    make("BunchOfColors3-VLA-v0", task_options={"touch_radius": 0.02})
    with pytest.raises(engram.Error, match="touch_radius"):
        make("BunchOfColors3-VLA-v0", task_options={"touch_radius": -1})


def test_rules_set_the_task_options():
    def values(**options):
        described = engram.describe("SeqOfColors3-VLA-v0", **options)
        return described["rules"], {o["name"]: o["value"] for o in described["options"]}

    assert values() == ("reference", {"touch_radius": 0.05, "strict_order": 0, "strict": 0})
    assert values(rules="original") == (
        "original",
        {"touch_radius": 0.02, "strict_order": 1, "strict": 0},
    )
    assert values(rules="original", task_options={"touch_radius": 0.05}) == (
        "original",
        {"touch_radius": 0.05, "strict_order": 1, "strict": 0},
    )


def test_a_wrong_first_answer_fails_a_strict_episode():
    batch = engram.make_vec(
        "RememberColor9-Long-VLA-v0",
        num_envs=32,
        task_options={"strict": 1},
        autoreset_mode="DISABLED",
        privileged=True,
    )
    batch.reset(seed=0)
    for _ in range(batch.description["horizon"]):
        infos = batch.step(batch.act("sweep"))[4]
    assert infos["answered"].all()
    np.testing.assert_array_equal(infos["success_once"], infos["first_answer_correct"])
    assert 0 < infos["first_answer_correct"].sum() < 16
    right = infos["first_answer"] == infos["oracle_info"].reshape(32)
    np.testing.assert_array_equal(right, infos["first_answer_correct"])


def test_snapshots_of_other_rules_are_refused(make):
    batch, other = make(), make(rules="original")
    batch.reset()
    other.reset()
    with pytest.raises(engram.Error, match=r"rules=reference.*rules=original"):
        other.restore(batch.save())


def test_types_of_results(make):
    env = make()
    env.reset(seed=0)
    _, reward, terminated, truncated, _ = env.step(env.act("random"))
    assert reward.dtype == np.float32
    assert terminated.dtype == truncated.dtype == np.bool_
    assert reward.shape == terminated.shape == truncated.shape == (4,)


def test_the_oracle_solves_and_infos_report_success(make):
    env = make(num_envs=8, autoreset_mode="SAME_STEP")
    env.reset(seed=0)
    for _ in range(env.description["horizon"]):
        _, _, _, truncated, info = env.step(env.act("oracle"))
    assert truncated.all()
    env.step(env.act("zero"))
    assert info["_final_info"].all()  # the next step did not change it
    final = info["final_info"]
    if GYMNASIUM_1:
        assert final["success_once"].all()
    else:
        assert all(one["success_once"] for one in final)


@pytest.mark.parametrize("policy", ["zero", "random", "oracle", "blind", "sweep"])
def test_policies_write_into_a_given_array(make, policy):
    env = make()
    env.reset(seed=0)
    out = np.full((4, 7), 9, np.float32)
    assert env.act(policy, out) is out
    assert (np.abs(out) <= 1).all()


def test_step_in_two_halves_is_step(make):
    whole, halves = make(), make()
    whole.reset(seed=0)
    halves.reset(seed=0)
    rng = np.random.default_rng(0)
    for _ in range(30):  # beyond the end of an episode
        actions = rng.uniform(-1, 1, (4, 7)).astype(np.float32)
        expected = whole.step(actions)
        halves.step_async(actions)
        actions[:] = np.nan  # they were copied
        results = halves.step_wait()
        for ours, theirs in zip(results[:4], expected[:4]):
            assert_same(ours, theirs)


def test_two_half_batches_equal_one_batch(make):
    whole, halves = make(), [make(num_envs=2) for _ in range(2)]
    whole.reset(seed=0)
    for i, half in enumerate(halves):
        half.reset(seed=2 * i)
    for _ in range(5):
        actions = whole.act("random")
        for i, half in enumerate(halves):
            half.step_async(actions[2 * i : 2 * i + 2])
        expected = whole.step(actions)[0]
        parts = [half.step_wait()[0] for half in halves]
        np.testing.assert_array_equal(np.concatenate(parts), expected)


def test_results_do_not_depend_on_threads(make):
    batches = [make(num_envs=6, threads=threads) for threads in (1, 3)]
    for env in batches:
        env.reset(seed=0)
    for _ in range(20):
        actions = batches[0].act("oracle")
        first, second = (env.step(actions)[0] for env in batches)
        np.testing.assert_array_equal(first, second)


def test_snapshots_bring_back_the_bits(make):
    env, other = make(), make()
    env.reset(seed=0)
    for _ in range(10):
        env.step(env.act("oracle"))
    everything, one = env.save(), env.save(2)
    expected = [env.step(env.act("oracle"))[0] for _ in range(5)]
    _, info = env.restore(everything)
    np.testing.assert_array_equal(info["elapsed_steps"], np.full(4, 10))
    for step in expected:
        np.testing.assert_array_equal(env.step(env.act("oracle"))[0], step)
    other.reset(seed=100)
    other.restore(one, index=0)
    for step in expected:
        np.testing.assert_array_equal(other.step(other.act("oracle"))[0][0], step[2])


def test_render_draws_every_environment(make):
    env = make(num_envs=2, render_size=(64, 48))
    env.reset(seed=0)
    frames = env.render()
    assert isinstance(frames, tuple)
    assert [frame.shape for frame in frames] == [(48, 64, 3)] * 2
    assert not np.array_equal(*frames)
    assert env.frame(1, "hand_camera", 16).shape == (16, 16, 3)
    assert make(render_mode=None).render() is None


def test_rgb_observation_equals_render(make):
    env = make(obs_mode="rgb", num_envs=2)
    obs, _ = env.reset(seed=0)
    np.testing.assert_array_equal(obs["rgb"][1, :, :, :3], env.frame(1, "base_camera", 128))


def test_sub_environments(make):
    env = make("RotateLenientPos-VLA-v0", render_size=16)
    env.reset(seed=0)
    assert env.get_attr("language_instruction") == tuple(env.instructions)
    assert env.call("task_description") == tuple(env.instructions)
    assert env.call("_max_episode_steps") == (env.description["horizon"],) * 4
    assert env.call("output", "elapsed_steps") == (0, 0, 0, 0)
    assert len(env.call("render")) == 4
    env.set_attr("note", [1, 2, 3, 4])
    assert env.get_attr("note") == (1, 2, 3, 4)
    env.set_attr("note", 5)
    assert env.get_attr("note") == (5,) * 4
    with pytest.raises(engram.InvalidArgumentError):
        env.set_attr("note", [1])
    with pytest.raises(AttributeError):
        env.get_attr("nothing")
    with pytest.raises(AttributeError):
        env.set_attr("task", "other")
    with pytest.raises(engram.UnknownIdError, match="success"):
        env.call("output", "nothing")


@pytest.mark.parametrize("duplicate", [copy.deepcopy, lambda env: pickle.loads(pickle.dumps(env))])
def test_a_pickled_batch_is_made_anew(make, duplicate):
    env = make(obs_mode="state_dict", seed=3, pins={"target": 1}, autoreset_mode="SAME_STEP")
    env.reset()
    other = duplicate(env)
    assert other.observation_space == env.observation_space
    assert other.metadata == env.metadata
    assert_same(other.reset()[0], env.reset(seed=3)[0])
    other.close()


def test_the_specification_makes_the_same_batch(make):
    env = make(reward_mode="sparse", autoreset_mode=engram.AutoresetMode.SAME_STEP)
    spec = pickle.loads(pickle.dumps(env.spec))
    assert spec.id == f"engram/{TASK}"
    spec.to_json()
    if GYMNASIUM_1:
        other = gymnasium.make_vec(spec)
        assert other.num_envs == 4
        assert other.autoreset_mode is engram.AutoresetMode.SAME_STEP
        np.testing.assert_array_equal(other.reset(seed=1)[0], env.reset(seed=1)[0])
        other.close()


def test_a_specification_has_plain_numbers_alone():
    out = {"reward": np.zeros(2, np.float32)}
    pins = {"target": np.int64(1), "robot_noise": np.zeros(7, np.float32)}
    env = engram.make_vec(TASK, 2, pins=pins, seed=np.int64(3), out=out)
    again = type(env.spec).from_json(env.spec.to_json())
    assert again.kwargs["pins"] == {"target": 1, "robot_noise": [0.0] * 7}
    assert again.kwargs["seed"] == 3
    assert "out" not in again.kwargs
    single = engram.make(TASK, pins=pins)
    assert '"target": 1' in single.spec.to_json()


def test_views_outlive_the_batch(make):
    env = make(copy=False)
    obs, info = env.reset(seed=0)
    env.close()
    assert np.isfinite(obs).all()
    assert (info["elapsed_steps"] == 0).all()
    obs[:] = 0  # and may still be written to
    del env
    assert obs.sum() == 0
