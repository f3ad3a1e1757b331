"""Several tasks in one batch."""

from __future__ import annotations

import pickle

import gymnasium
import numpy as np
import pytest
from conftest import registered_ids

import engram
from engram.envs.compat import GYMNASIUM_1

COLOR, CUPS, ROTATE = "RememberColor3-VLA-v0", "ShellGameTouch-VLA-v0", "RotateLenientPos-VLA-v0"


def step(env: engram.VectorEnv, policy: str = "random"):
    return env.step(env.act(policy))


def test_environments_are_what_they_are_alone() -> None:
    tasks = {COLOR: 3, CUPS: 2, ROTATE: 1}
    together = engram.make_vec(tasks, obs_mode="rgb", seed=5, threads=2)
    alone = [engram.make_vec(id, n, obs_mode="rgb", seed=5) for id, n in tasks.items()]
    begins = np.cumsum([0, *tasks.values()])
    observed, info = together.reset()
    for one in alone:
        one.reset()
    for _ in range(25):
        observed, reward, terminated, truncated, info = step(together)
        for begin, one in zip(begins, alone):
            obs, own_reward, ended, cut, own = step(one)
            part = slice(begin, begin + one.num_envs)
            assert all((observed[key][part] == obs[key]).all() for key in obs)
            assert (reward[part] == own_reward).all()
            assert (terminated[part] == ended).all()
            assert (truncated[part] == cut).all()
            for name, values in own.items():
                if not name.startswith(("_", "final")) and name in info:
                    width = values.shape[1:]
                    shown = info[name][part]
                    assert (shown[:, : width[0]] if width else shown).tolist() == values.tolist()
                    assert info[f"_{name}"][part].all()
    assert (observed["task_cue"][: begins[2]] == 0).all()  # Rotate's alone


@pytest.mark.skipif(not GYMNASIUM_1, reason="Gymnasium 0.29: make_vec takes no specification")
@pytest.mark.parametrize(
    ("tasks", "options"),
    [
        ([COLOR, CUPS], {"num_envs": 5}),
        ({COLOR: {"num_envs": np.int64(2), "pins": {"target": np.int64(1)}}, CUPS: 1}, {}),
    ],
)
def test_the_specification_makes_the_group_again(tasks, options) -> None:
    env = engram.make_vec(tasks, obs_mode="objects", **options)
    spec = type(env.spec).from_json(env.spec.to_json())
    other = gymnasium.make_vec(spec)
    assert (other.num_envs, other.task_ids) == (env.num_envs, env.task_ids)
    assert (other.reset(seed=1)[0] == env.reset(seed=1)[0]).all()


def test_numbers_of_environments() -> None:
    ids = [COLOR, CUPS, ROTATE]
    assert engram.make_vec(ids).num_envs == 3
    env = engram.make_vec(ids, num_envs=8)
    _, info = env.reset()
    assert info["task_index"].tolist() == [0, 0, 0, 1, 1, 1, 2, 2]
    assert info["task"][6] == ROTATE
    assert env.task_ids == tuple(ids)
    assert env.task_of(3)["id"] == CUPS
    assert env.envs[7].task == ROTATE
    assert env.envs[7].max_episode_steps == engram.describe(ROTATE)["horizon"]
    assert env.instructions[3] == engram.describe(CUPS)["instruction"]
    assert engram.make_vec([COLOR, COLOR], num_envs=4).num_envs == 4


def test_masks_of_infos_follow_the_task() -> None:
    env = engram.make_vec([COLOR, ROTATE], num_envs=4, autoreset_mode="SAME_STEP")
    env.reset()
    ended = False
    for _ in range(120):
        *_, info = step(env)
        assert info["_relative_angle"].tolist() == [False, False, True, True]
        assert info["_success"].all()
        if "final_info" in info:
            ended = True
            for i in np.flatnonzero(info["_final_info"]):
                final = info["final_info"]
                row = {k: v[i] for k, v in final.items()} if GYMNASIUM_1 else final[i]
                assert row["task"] == env.task_of(i)["id"]
                if not GYMNASIUM_1:
                    assert ("relative_angle" in row) == (i > 1)
    assert ended


def test_observations_of_objects_have_one_layout() -> None:
    rows = engram.make_vec([COLOR, CUPS], num_envs=4, obs_mode="objects")
    parts = engram.make_vec([COLOR, CUPS], num_envs=4, obs_mode="objects_dict")
    row, info = rows.reset(seed=1)
    part, _ = parts.reset(seed=1)
    assert rows.observation_space.contains(row)
    assert parts.observation_space.contains(part)
    alone = engram.make_vec(CUPS, 2, obs_mode="objects_dict")
    own, _ = alone.reset(seed=1)
    for name, values in own["objects"].items():
        count = values.shape[1]
        assert (part["objects"][name][2:, :count] == values).all()
        assert (part["objects"][name][:2, 3:] == 0).all()  # three cubes
    mask = part["objects"]["mask"][..., 0]
    assert mask.sum(1).tolist() == [3, 3, 4, 4]
    assert (info["object_mask"] == mask).all()


@pytest.mark.parametrize("obs_mode", ["state", "state_dict", "none", "rgb+depth+segmentation"])
def test_every_observation_mode(obs_mode: str) -> None:
    env = engram.make_vec([COLOR, ROTATE], num_envs=2, obs_mode=obs_mode, image_size=16)
    obs, _ = env.reset()
    assert env.observation_space.contains(obs)
    obs, *_ = step(env)
    assert env.observation_space.contains(obs)


def test_tasks_have_settings_of_their_own() -> None:
    env = engram.make_vec(
        {
            "RememberColor9-VLA-v0": {"num_envs": 2, "constants": {"COLORS": 5}},
            COLOR: {"pins": {"target": 1}},
        },
        privileged=True,
    )
    assert env.num_envs == 3
    assert env.task_of(0)["changed"]["COLORS"] == 5
    assert env.reset()[1]["oracle_info"][2] == 1
    options = {"pins": {"RememberColor9-VLA-v0": {"target": 4}}}
    assert env.reset(options=options)[1]["oracle_info"].tolist() == [4, 4, 1]


def test_seeds_count_anew_for_each_task() -> None:
    env = engram.make_vec({COLOR: 2, CUPS: 2}, obs_mode="objects")
    first, _ = env.reset(seed=9)
    alone = engram.make_vec(COLOR, 2, obs_mode="objects")
    width = alone.single_observation_space.shape[0]
    assert (first[:2, :width] == alone.reset(seed=9)[0]).all()
    again, _ = env.reset(seed=[9, 10, 9, 10])
    assert (first == again).all()
    assert (env.reset(seed=[None, 10, 9, None])[0][1:3] == first[1:3]).all()


def test_refused_resets_change_nothing() -> None:
    env = engram.make_vec({COLOR: 1, CUPS: 1}, obs_mode="objects")
    env.reset(seed=2)
    step(env)
    before = env.save()
    with pytest.raises(engram.Error, match="no_such"):
        env.reset(options={"pins": {COLOR: {"target": 0}, CUPS: {"no_such": 1}}})
    assert env.save() == before
    with pytest.raises(engram.InvalidArgumentError, match="tasks of this batch"):
        env.reset(options={"pins": {ROTATE: {"target": 0}}})
    assert env.save() == before


def test_snapshots() -> None:
    env = engram.make_vec({COLOR: 2, CUPS: 1})
    env.reset()
    step(env)
    whole, one = env.save(), env.save(2)
    step(env)
    other = engram.make_vec({COLOR: 2, CUPS: 1})
    other.restore(whole)
    assert other.save() == whole
    single = engram.make_vec(CUPS)
    single.reset()
    single.restore(one, 0)
    assert single.save(0) == one
    with pytest.raises(engram.InvalidArgumentError, match="snapshot refused"):
        env.restore(one, 0)


def test_pickled_and_async() -> None:
    env = pickle.loads(pickle.dumps(engram.make_vec({COLOR: 2, CUPS: 1}, seed=3)))
    assert env.task_ids == (COLOR, CUPS)
    env.reset()
    env.step_async(env.act("oracle"))
    assert env.step_wait()[1].shape == (3,)
    assert env.spec.id == "engram/Group"


@pytest.mark.parametrize(
    ("tasks", "num_envs", "message"),
    [
        ([], 1, "at least one task"),
        ({}, 1, "at least one task"),
        ([COLOR, CUPS, ROTATE], 2, "2 given for 3 tasks"),
        ({COLOR: 2}, 5, "leave it out"),
        ({COLOR: 0}, 1, "num_envs of RememberColor3-VLA-v0: 0 given"),
        ({COLOR: {"envs": 2}}, 1, "'envs' given"),
        ([COLOR, 3], 2, "id: 3 given"),
        (["RememberColour3-VLA-v0"], 1, "RememberColor3-VLA-v0"),
    ],
)
def test_bad_tasks_are_refused(tasks: object, num_envs: int, message: str) -> None:
    with pytest.raises(engram.Error, match=message):
        engram.make_vec(tasks, num_envs=num_envs)


def test_drawn_values_differ_by_task() -> None:
    env = engram.make_vec([COLOR, CUPS])
    env.reset()
    with pytest.raises(engram.InvalidArgumentError, match="several tasks"):
        env.drawn()
    assert env.robot_state()["qpos"].shape == (2, 9)
    assert env.camera_params()["hand_camera"]["cam2world_gl"].shape == (2, 4, 4)
    assert env.frame(1, size=32).shape == (32, 32, 3)


@pytest.mark.long
def test_all_tasks_in_one_batch() -> None:
    ids = registered_ids()
    env = engram.make_vec(ids, num_envs=2 * len(ids), obs_mode="objects")
    env.reset(seed=0)
    for _ in range(30):
        step(env, "oracle")
    for k in (0, 40, 96):
        alone = engram.make_vec(ids[k], 2, obs_mode="objects")
        alone.reset(seed=0)
        for _ in range(30):
            step(alone, "oracle")
        assert alone.save(1) == env.save(2 * k + 1)
