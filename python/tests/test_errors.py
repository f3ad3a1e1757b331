"""Misuse becomes an exception that says what was wrong; nothing crashes."""

from __future__ import annotations

import pickle

import gymnasium
import numpy as np
import pytest
from conftest import TASK

import engram
from engram import _core

GOOD = np.zeros((4, 7), np.float32)


def test_classes_derive_from_what_python_users_catch():
    assert issubclass(engram.InvalidArgumentError, (engram.Error, ValueError))
    assert issubclass(engram.InvalidArgumentError, ValueError)
    assert issubclass(engram.UnknownIdError, KeyError)
    assert issubclass(engram.UnavailableError, RuntimeError)
    assert issubclass(engram.BadStateError, RuntimeError)
    assert issubclass(engram.IoError, OSError)
    for name in ("InvalidArgument", "UnknownId", "Unavailable", "BadState", "Io", "Internal"):
        error = getattr(engram, f"{name}Error")("what, given, allowed")
        assert isinstance(error, engram.Error)
        assert str(error) == "what, given, allowed"
        assert str(pickle.loads(pickle.dumps(error))) == str(error)


def test_an_unknown_id_names_the_nearest():
    with pytest.raises(engram.UnknownIdError, match="RememberColor3-VLA-v0") as info:
        engram.make_vec("RememberColour3-VLA-v0")
    assert not str(info.value).startswith(("'", '"'))


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"num_envs": 0}, "num_envs"),
        ({"num_envs": 10**7}, "num_envs"),
        ({"num_envs": 10**30}, "num_envs"),
        ({"num_envs": 2.5}, "integer"),
        ({"num_envs": None}, "integer"),
        ({"obs_mode": "pixels"}, "allowed: none, state, state_dict, rgb, objects"),
        ({"obs_mode": None}, "obs_mode"),
        ({"obs_mode": ["state"]}, "obs_mode"),
        ({"reward_mode": 3}, "reward_mode"),
        ({"control_mode": "pd_nothing"}, "pd_nothing"),
        ({"control_mode": 7}, "string"),
        ({"autoreset_mode": "sometimes"}, "NEXT_STEP, SAME_STEP, DISABLED"),
        ({"autoreset_mode": 1}, "autoreset_mode"),
        ({"autoreset_mode": [1]}, "autoreset_mode"),
        ({"seed": -1}, "seed"),
        ({"seed": 2**64}, "seed"),
        ({"seed": "one"}, "integer"),
        ({"threads": -1}, "threads"),
        ({"pins": {"nothing": 1}}, "nothing"),
        ({"pins": {"target": "red"}}, "target"),
        ({"pins": {"target": [1, 2]}}, "target"),
        ({"pins": {"target": 99}}, "target"),
        ({"pins": {1: 2}}, "string"),
        ({"pins": [1]}, "dict"),
        ({"task_options": {"nothing": 1}}, "nothing"),
        ({"task_options": {"nothing": None}}, "number"),
        ({"rules": "upstream"}, "reference, original"),
        ({"rules": 1}, "reference, original"),
        ({"image_size": 0, "obs_mode": "rgb"}, "image"),
        ({"image_size": "big"}, "integer"),
        ({"image_size": (1, 2, 3)}, "integer"),
        ({"cameras": "base_camera"}, "list"),
        ({"cameras": ["nowhere"], "obs_mode": "rgb"}, "nowhere"),
        ({"renderer": "gpu", "obs_mode": "rgb"}, "gpu"),
        ({"render_mode": "human"}, "rgb_array"),
        ({"render_camera": "nowhere"}, "base_camera, hand_camera, render_camera"),
        ({"render_camera": ["base_camera"]}, "base_camera, hand_camera, render_camera"),
        ({"render_size": 5000}, "1 to 4096"),
        ({"num_envs": 10**9}, "num_envs: 1000000000 given, 1 to 1000000 allowed"),
        ({"pins": {"target": 10**9}}, "1000000000 given"),
        ({"robot_init_qpos_noise": 7}, "noise"),
        ({"rotation_sign": 2}, "rotation_sign"),
        ({"constants": {"max_episode_steps": 7}}, "no time to act"),
        ({"max_episode_steps": 1_000_001}, "max_episode_steps: 1000001 given, 0 .* to 1000000"),
        ({"after_end": "stop"}, "hold, continue, refuse"),
        ({"after_end": "continue", "autoreset_mode": "NEXT_STEP"}, "next-step given, off needed"),
        ({"max_episode_steps": 0}, "max_episode_steps"),
    ],
)
def test_bad_options_are_refused(options, words):
    with pytest.raises(engram.Error, match=words):
        engram.make_vec(TASK, **{"num_envs": 1, **options})


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: engram.make(TASK, num_env=4), "^make\\(\\) .*'num_env'"),
        (lambda: engram.make(TASK, num_envs=4), "num_envs: 4 given to make; engram.make_vec"),
        (lambda: engram.make(TASK, copy=False), "copy: False given to make; engram.make_vec"),
        (lambda: engram.make(TASK, obsmode="rgb"), "Did you mean 'obs_mode'"),
        (lambda: engram.Env(TASK, colour=4), "^Env\\(\\) .*'colour'$"),
        (lambda: engram.make_vec(TASK, num_env=4), "^make_vec\\(\\) .*Did you mean 'num_envs'"),
        (lambda: engram.VectorEnv(TASK, num_env=4), "^VectorEnv.*'num_env'"),
        (lambda: engram.describe(TASK, controlmode="x"), "^describe\\(\\) .*'control_mode'"),
        (lambda: gymnasium.make(f"engram/{TASK}", num_env=4), "^gymnasium.make\\(\\) .*'num_env'"),
        (
            lambda: engram.gym_registration._make_vec(TASK, 4, num_env=4),
            "^gymnasium.make_vec\\(\\) ",
        ),
    ],
)
def test_unknown_keywords_are_refused_with_the_name_of_the_function(call, words):
    with pytest.raises((TypeError, engram.InvalidArgumentError), match=words):
        call()


@pytest.mark.filterwarnings("error")
def test_a_batch_dies_in_silence():
    env = engram.make_vec(TASK)
    env._batch = None  # the state after the interpreter's teardown
    env.__del__()
    engram.VectorEnv.__new__(engram.VectorEnv).__del__()


@pytest.mark.parametrize("id", [None, 3, "", "\0", b"RememberColor3-VLA-v0", "x" * 100_000])
def test_bad_ids_are_refused(id):
    with pytest.raises(engram.Error):
        engram.make_vec(id)


class Unreadable:
    def __array__(self, *args, **kwargs):
        raise TypeError("a tensor on another device")


@pytest.mark.parametrize(
    "actions",
    [
        None,
        "actions",
        b"actions",
        {},
        [],
        [[1, 2], [3]],
        object(),
        Unreadable(),
        np.zeros(28, np.float32),
        np.zeros((4, 7, 1), np.float32),
        np.zeros((7, 4), np.float32),
        np.zeros((3, 7), np.float32),
        np.zeros((0, 7), np.float32),
        np.zeros((4, 7), np.complex64),
        np.zeros((4, 7), np.bool_),
        np.zeros((4, 7), object),
        np.zeros((4, 7), "U1"),
        np.zeros((4, 7), "datetime64[s]"),
        np.full((4, 7), np.nan, np.float32),
        np.full((4, 7), np.inf, np.float32),
        np.full((4, 7), 1e300),
    ],
)
@pytest.mark.parametrize("method", ["step", "step_async"])
def test_bad_actions_are_refused_and_change_nothing(make, actions, method):
    env, twin = make(), make()
    env.reset(seed=0)
    twin.reset(seed=0)
    with pytest.raises(engram.InvalidArgumentError, match=r"action|actions"):
        getattr(env, method)(actions)
    np.testing.assert_array_equal(env.step(GOOD)[0], twin.step(GOOD)[0])


def test_actions_of_any_layout_mean_the_same(make):
    rng = np.random.default_rng(0)
    base = rng.uniform(-1, 1, (4, 7)).astype(np.float32)
    wide = np.zeros((8, 14), np.float32)
    wide[::2, ::2] = base
    shifted = np.zeros(4 * 7 * 4 + 1, np.uint8)[1:].view(np.float32).reshape(4, 7)
    shifted[:] = base
    read_only = base.copy()
    read_only.flags.writeable = False
    variants = [
        base,
        np.asfortranarray(base),
        wide[::2, ::2],
        base[::-1].copy()[::-1],
        base.astype(">f4"),
        base.astype(np.float64),
        shifted,
        read_only,
        base.tolist(),
        np.ma.masked_array(base),
    ]
    expected = None
    for actions in variants:
        env = make(threads=1)
        env.reset(seed=0)
        obs = env.step(actions)[0]
        expected = obs if expected is None else expected
        np.testing.assert_array_equal(obs, expected)


def test_integers_are_numbers_too(make):
    env = make()
    env.reset(seed=0)
    env.step(np.ones((4, 7), np.int64))


@pytest.mark.parametrize(
    ("kwargs", "words"),
    [
        ({"seed": [1, 2]}, "4 needed"),
        ({"seed": -1}, "seed"),
        ({"seed": 1.5}, "integer"),
        ({"seed": [1, 2, 3, "x"]}, "integer"),
        ({"seed": np.zeros((4, 2), np.int64)}, "integer"),
        ({"options": {"mask": 1}}, "did you mean 'reset_mask'"),
        ({"options": {"reset_masks": 1}}, "did you mean 'reset_mask'"),
        ({"options": {"pin": {"target": 1}}}, "did you mean 'pins'"),
        ({"options": {"Constants": {}}}, "did you mean 'constants'"),
        ({"options": {"reset_mask": [True] * 3}}, "needed"),
        ({"options": {"reset_mask": [1, 0, 1, 0]}}, "list of bools"),
        ({"options": {"reset_mask": "all"}}, "list of bools"),
        ({"options": {"reset_mask": np.ones(4)}}, "bool array"),
        ({"options": {"reset_mask": np.ones(3, bool)}}, "needed"),
        ({"options": {"reset_mask": np.ones((4, 1), bool)}}, "needed"),
        ({"options": {"reset_mask": np.zeros(4, bool)}}, "no environment"),
        ({"options": {"pins": {"nothing": 0}}}, "nothing"),
        ({"options": {"pins": 3}}, "dict"),
    ],
)
def test_bad_resets_are_refused(make, kwargs, words):
    env = make()
    env.reset(seed=0)
    with pytest.raises(engram.Error, match=words):
        env.reset(**kwargs)
    env.step(GOOD)


def test_a_strided_mask_is_read_right(make):
    env = make(autoreset_mode="DISABLED")
    env.reset(seed=0)
    env.step(GOOD)
    env.reset(options={"reset_mask": np.array([1, 0, 0, 1, 1, 0, 0, 0], bool)[::2]})
    np.testing.assert_array_equal(env._views["elapsed_steps"], [0, 1, 0, 1])


def test_calls_out_of_order_are_refused(make):
    env = make()
    for call in (
        lambda: env.step(GOOD),
        lambda: env.step_async(GOOD),
        env.step_wait,
        env.frame,
        lambda: env.reset(options={"reset_mask": np.array([True, False, True, True])}),
    ):
        with pytest.raises(engram.BadStateError):
            call()
    env.reset(seed=0)
    env.step_async(GOOD)
    for call in (
        lambda: env.step(GOOD),
        lambda: env.step_async(GOOD),
        env.reset,
        env.act,
        env.save,
        env.frame,
        lambda: env.restore(b""),
    ):
        with pytest.raises(engram.BadStateError):
            call()
    env.step_wait()
    with pytest.raises(engram.BadStateError):
        env.step_wait()


def test_a_closed_batch_refuses_everything(make):
    env = make()
    env.reset(seed=0)
    saved = env.save()
    env.step_async(GOOD)
    env.close()
    env.close()
    assert env.closed
    for call in (
        env.reset,
        lambda: env.step(GOOD),
        lambda: env.step_async(GOOD),
        env.step_wait,
        env.act,
        env.render,
        env.frame,
        env.save,
        lambda: env.restore(saved),
        lambda: env.unstable_count,
        lambda: env.num_threads,
    ):
        with pytest.raises(engram.BadStateError, match="closed"):
            call()
    repr(env)


@pytest.mark.parametrize("data", [b"", b"x", b"\0" * 1000, None, "text", bytearray(8), 3])
def test_bad_snapshots_are_refused(make, data):
    env = make()
    env.reset(seed=0)
    with pytest.raises(engram.InvalidArgumentError):
        env.restore(data)
    with pytest.raises(engram.InvalidArgumentError):
        env.restore(data, index=0)


def test_damaged_and_foreign_snapshots_are_refused(make):
    env = make()
    env.reset(seed=0)
    good = env.save()
    damaged = bytearray(good)
    damaged[len(good) // 2] ^= 1
    other = make("ShellGameTouch-VLA-v0")
    other.reset(seed=0)
    smaller = make(num_envs=2)
    smaller.reset(seed=0)
    for data in (bytes(damaged), good[:-1], good + b"x", other.save(), smaller.save()):
        with pytest.raises(engram.InvalidArgumentError):
            env.restore(data)
    env.restore(good)


@pytest.mark.parametrize("index", [-1, 4, 2**40, 1.5, "0"])
def test_bad_indices_are_refused(make, index):
    env = make()
    env.reset(seed=0)
    for call in (env.save, env.frame, lambda i: env.restore(env.save(0), i)):
        with pytest.raises(engram.InvalidArgumentError):
            call(index)


@pytest.mark.parametrize("size", [0, -1, 5000, (10, 0), 2**40, None, "x"])
def test_bad_picture_sizes_are_refused(make, size):
    env = make(num_envs=1)
    env.reset()
    if size is None:
        assert env.frame(size=None).shape == (512, 512, 3)
        return
    with pytest.raises(engram.InvalidArgumentError):
        env.frame(size=size)


def test_bad_cameras_and_policies_are_refused(make):
    env = make()
    env.reset(seed=0)
    with pytest.raises(engram.Error, match="base_camera"):
        env.frame(camera="nowhere")
    with pytest.raises(engram.InvalidArgumentError, match="zero, random, oracle, blind, sweep"):
        env.act("greedy")
    joint = make(control_mode="pd_ee_pose")
    joint.reset(seed=0)
    with pytest.raises(engram.Error, match="pd_ee_delta_pose"):
        joint.act("oracle")


def test_arrays_to_write_to_must_fit(make):
    env = make()
    env.reset(seed=0)
    read_only = np.zeros((4, 7), np.float32)
    read_only.flags.writeable = False
    for out in (
        np.zeros((4, 7)),
        np.zeros((7, 4), np.float32),
        np.zeros((4, 14), np.float32)[:, ::2],
        np.zeros((7, 4), np.float32).T,
        read_only,
        [[0.0] * 7] * 4,
    ):
        with pytest.raises(engram.InvalidArgumentError, match="out"):
            env.act("zero", out)


def test_views_of_infos_are_read_only(make):
    _, info = make(copy=False, privileged=True).reset(seed=0)
    for name in ("elapsed_steps", "success", "oracle_info", "episode_return"):
        with pytest.raises(ValueError, match="read-only"):
            info[name][:] = 0


def test_the_extension_refuses_wrong_types_and_shapes(make):
    env = make()
    batch = env._batch
    for call in (
        lambda: batch.step(None),
        lambda: batch.step(np.zeros((4, 7))),
        lambda: batch.step(np.zeros(28, np.float32)),
        lambda: batch.step(np.zeros((4, 14), np.float32)[:, ::2]),
        lambda: batch.reset(np.ones(4)),
        lambda: batch.reset(None, np.ones(4)),
        lambda: batch.restore(-1, "x"),
        lambda: batch.output(3),
        lambda: _core.Batch("x", None),
        lambda: _core.Batch(),
    ):
        with pytest.raises(TypeError):
            call()
    for call in (
        lambda: batch.reset(np.ones(3, bool)),
        lambda: batch.reset(None, np.ones(3, np.uint64)),
        lambda: batch.output("nothing"),
        lambda: batch.instruction(9),
    ):
        with pytest.raises(engram.Error):
            call()


@pytest.mark.filterwarnings("ignore:nanobind:RuntimeWarning")
def test_an_extension_object_without_its_constructor_is_harmless():
    for cls in (_core.Batch, _core.Options):
        blank = cls.__new__(cls)
        with pytest.raises((TypeError, RuntimeError)):
            blank.num_envs  # noqa: B018
    with pytest.raises((TypeError, pickle.PicklingError)):
        pickle.dumps(_core.Options())


def test_a_character_0_is_refused_not_cut_off():
    calls = [
        lambda: engram.make_vec("RememberColor3-VLA-v0\0-and-more", num_envs=1),
        lambda: engram.make_vec("RememberColor3-VLA-v0", num_envs=1, pins={"target\0": 1}),
        lambda: engram.make_vec("RememberColor3-VLA-v0", num_envs=1, renderer="cpu\0"),
        lambda: engram.load_variants("/dev/null\0.json"),
        lambda: engram.load_tasks("/dev/null\0.so"),
        lambda: engram.evaluate(lambda o: None, "RememberColor3-VLA-v0", name="mine\0", episodes=1),
        lambda: engram.evaluate(lambda o: None, "RememberColor3-VLA-v0", output="a\0b", episodes=1),
    ]
    for call in calls:
        with pytest.raises(engram.InvalidArgumentError, match="character 0"):
            call()
