"""Classes with constants, subclasses of them, and register_env."""

from __future__ import annotations

import inspect
import warnings
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("torch")

import torch
from conftest import registered_ids
from helpers import made

import engram
import engram.mikasa as mikasa
from engram.mikasa import memory_envs, register_env


def test_names():
    names = vars(memory_envs)
    bases = [name for name in names if name.endswith("VLABaseEnv")]
    leaves = [name for name in names if name.endswith("VLAEnv")]
    assert len(bases) == 27
    assert len(leaves) == 97
    assert set(bases + leaves) <= set(memory_envs.__all__)
    for name, base in (
        ("RememberColor3LongVLAEnv", "RememberColorVLABaseEnv"),
        ("BatteriesChecker3VLAEnv", "BatteriesCheckerVLABaseEnv"),
        ("BatteriesCheckerEasy15VLAEnv", "BatteriesCheckerEasyVLABaseEnv"),
        ("RememberShapeAndColor5x3VLAEnv", "RememberShapeAndColorVLABaseEnv"),
        ("TakeItBackVLAEnv", "TakeItBackVLABaseEnv"),
    ):
        assert names[name].__bases__ == (names[base],)
        assert issubclass(names[name], mikasa.BaseEnv)
    assert issubclass(names["BatteriesCheckerEasyVLABaseEnv"], names["BatteriesCheckerVLABaseEnv"])


def listed(value):
    if isinstance(value, dict):
        return {str(key): listed(one) for key, one in value.items()}
    if isinstance(value, np.ndarray) and value.dtype == np.float32:
        return [listed(one) for one in value]
    if isinstance(value, np.float32):
        return float(str(value))
    if isinstance(value, (list, tuple)):
        return [listed(one) for one in value]
    return value.tolist() if hasattr(value, "tolist") else value


@pytest.mark.parametrize("id", registered_ids())
def test_constants_are_class_attributes(id):
    described = engram.describe(id)
    cls = mikasa.registration.REGISTERED[id]
    assert described["constants"]
    for name, value in described["constants"].items():
        assert listed(getattr(cls, name)) == value
    assert "LANGUAGE_INSTRUCTION" in dir(cls)
    assert described["instruction"] == cls.LANGUAGE_INSTRUCTION
    rotates = described["family"] in ("RotateLenient", "RotateStrict")
    assert hasattr(cls, "LANGUAGE_INSTRUCTION_TEMPLATE") == rotates


def test_constants_of_bases():
    assert mikasa.BunchOfColorsVLABaseEnv.SEQUENCE_LENGTH == 5
    assert mikasa.BunchOfColors3VLAEnv.SEQUENCE_LENGTH == 3
    assert mikasa.RememberColorVLABaseEnv.CUE_PHASE_STEPS == [1, 5]
    assert mikasa.RememberShapeVLABaseEnv.SHAPE_MAPPING[3] == "cross"
    assert mikasa.RotateLenientVLABaseEnv.MODE == "pos_angle"
    with pytest.raises(AttributeError, match="NO_CONSTANT"):
        _ = mikasa.RememberColor3VLAEnv.NO_CONSTANT
    with made("RememberColor3-VLA-v0") as env:
        assert env.unwrapped.GOAL_THRESH == 0.05
        with pytest.raises(AttributeError, match="subclass"):
            env.unwrapped.GOAL_THRESH = 0.1


@pytest.mark.parametrize("cls", [mikasa.InterceptVLABaseEnv, mikasa.InterceptGrabVLABaseEnv])
def test_the_ball_of_bases_rests(cls):
    assert list(cls.VELOCITY_RANGE) == [0.0, 0.0]
    env = cls(num_envs=4, obs_mode="state")
    try:
        env.reset(seed=1)
        assert env.oracle_info.shape == (4, 3)
        assert (env.oracle_info == 0).all()
    finally:
        env.close()


def test_other_cue_and_delay():
    @register_env("RememberColor5-Variant-VLA-v0", max_episode_steps=100)
    class Medium(mikasa.RememberColorVLABaseEnv):
        COLORS = 5
        CUE_PHASE_STEPS = [30, 50]  # noqa: RUF012
        EMPTY_PHASE_STEPS = (30, 35)
        LANGUAGE_INSTRUCTION = "Touch it again."
        MY_OWN = 3

    with made("RememberColor5-Variant-VLA-v0", num_envs=8) as env:
        assert env.spec.max_episode_steps == 100
        _, info = env.reset(seed=1)
        base = env.unwrapped
        assert isinstance(base, Medium)
        assert base.MY_OWN == 3
        assert ((base.cue_steps_per_env >= 30) & (base.cue_steps_per_env <= 50)).all()
        assert ((base.empty_steps_per_env >= 30) & (base.empty_steps_per_env <= 35)).all()
        assert info["language_instruction"] == "Touch it again."
        assert base.single_observation_space.shape == (41,)
    known = engram.describe("RememberColor5-Variant-VLA-v0")  # in engram's own interface, too
    assert known["horizon"] == 100
    assert known["changed"]["CUE_PHASE_STEPS"] == [30, 50]
    assert known["instruction"] == "Touch it again."


def test_other_shapes_colors_and_contours():
    @register_env("RememberShapeAndColor2x2-Variant-VLA-v0", max_episode_steps=25)
    class Combined(mikasa.RememberShapeAndColor3x2VLAEnv):
        SHAPES = 4
        BASE_SHAPES = {0: "star", 1: "cross"}  # noqa: RUF012
        COLOR_PALETTE = {0: np.array([0, 0, 1.0, 1]), 1: np.array([1.0, 1, 0, 1])}  # noqa: RUF012

    @register_env("TraceShapeSquare-Variant-VLA-v0", max_episode_steps=300)
    class Squares(mikasa.TraceShapeVLABaseEnv):
        AVAILABLE_SHAPES = [mikasa.TraceShapeVLABaseEnv.SHAPE_SQUARE]  # noqa: RUF012

    described = engram.describe("RememberShapeAndColor2x2-Variant-VLA-v0")["changed"]
    assert {name: described[name] for name in ("SHAPES", "BASE_SHAPES", "COLOR_PALETTE")} == {
        "SHAPES": 4, "BASE_SHAPES": ["star", "cross"], "COLOR_PALETTE": ["blue", "yellow"],
    }  # fmt: skip
    with made("TraceShapeSquare-Variant-VLA-v0", num_envs=4) as env:
        _, info = env.reset(seed=1)
        assert (info["oracle_info"] == 1).all()


def test_rewards_evaluation_and_step_of_subclasses():
    steps = []

    @register_env("RememberColor3-Own-VLA-v0", max_episode_steps=25, reward_mode="dense")
    class Own(mikasa.RememberColor3VLAEnv):
        def step(self, action):
            steps.append(1)
            return super().step(action)

        def evaluate(self):
            info = super().evaluate()
            near = info["obj_to_goal_pos"].norm(dim=1) < 10
            return {**info, "near": near, "success": near}

        def compute_dense_reward(self, obs, action, info):
            return info["near"].float() * 2 + obs[:, 0] * 0

    with made("RememberColor3-Own-VLA-v0", num_envs=2) as env:
        assert env.unwrapped.reward_mode == "dense"
        env.reset(seed=1)
        _, reward, _, _, info = env.step(torch.zeros(2, 7))
        assert reward.tolist() == [2, 2]
        assert info["near"].all()
        assert len(steps) == 1
    with made("RememberColor3-Own-VLA-v0", num_envs=2, reward_mode="normalized_dense") as env:
        env.reset(seed=1)
        assert env.step(torch.zeros(2, 7))[1].tolist() == pytest.approx([2 / 3, 2 / 3])


@pytest.mark.parametrize(
    "method",
    ["_load_scene", "_initialize_episode", "_load_agent", "_after_reconfigure", "_get_obs_extra",
     "_before_simulation_step", "_default_sensor_configs", "_default_sim_config"],
)  # fmt: skip
def test_methods_that_build_or_move_bodies_are_refused(method):
    cls = type(mikasa.RememberColor3VLAEnv)(
        "Moved", (mikasa.RememberColor3VLAEnv,), {method: lambda self: None}
    )
    with pytest.raises(engram.InvalidArgumentError, match=method):
        register_env("Moved-VLA-v0", max_episode_steps=25)(cls)
    assert "Moved-VLA-v0" not in mikasa.registration.REGISTERED


@pytest.mark.parametrize(
    ("constants", "message"),
    [({"SUCCESS_BONUS": 1.0}, "fixed at 30"), ({"DELAY_STEP": 30}, "did you mean DELAY_STEPS"),
     ({"DELAY_STEPS": "long"}, "DELAY_STEPS")],
)  # fmt: skip
def test_impossible_constants_are_refused(constants, message):
    cls = type(mikasa.TimedTransferVLABaseEnv)(
        "Wrong", (mikasa.TimedTransferVLABaseEnv,), dict(constants)
    )
    with pytest.raises(engram.Error, match=message):
        register_env("Wrong-VLA-v0", max_episode_steps=200)(cls)


def test_ids_that_are_taken():
    with pytest.warns(UserWarning, match="registered already"):
        register_env("RememberColor3-VLA-v0")(mikasa.RememberColor5VLAEnv)
    with made("RememberColor3-VLA-v0") as env:
        assert env.unwrapped.COLORS == 3

    def two(colors):
        return type(mikasa.RememberColor3VLAEnv)(
            "Two", (mikasa.RememberColor3VLAEnv,), {"COLORS": colors}
        )

    register_env("RememberColor2-Variant-VLA-v0", max_episode_steps=25)(two(2))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        register_env("RememberColor2-Variant-VLA-v0", max_episode_steps=25, override=True)(two(4))
    with made("RememberColor2-Variant-VLA-v0") as env:
        assert env.unwrapped.COLORS == 4
        assert env.reset(seed=1)[0].shape == (1, 18 + 7 + 1 + 4 * 3)


def test_classes_without_a_task_are_refused():
    with pytest.raises(engram.InvalidArgumentError, match="BaseEnv"):
        register_env("Nothing-VLA-v0")(dict)
    bare = type(mikasa.BaseEnv)("Bare", (mikasa.BaseEnv,), {})
    with pytest.raises(engram.InvalidArgumentError, match="derive from the class"):
        register_env("Nothing-VLA-v0")(bare)
    with pytest.raises(engram.InvalidArgumentError, match="JSON"):
        register_env("Nothing-VLA-v0", obs_mode=object())


def test_signatures_and_docstrings_say_what_a_class_takes_and_does():
    classes = {**mikasa.classes.CLASSES, **mikasa.classes.RL_CLASSES}
    for name, cls in classes.items():
        shown = inspect.signature(cls).parameters
        for keyword, default in (
            ("num_envs", 1),
            ("robot_uids", "panda_wristcam"),
            ("robot_init_qpos_noise", 0.02),
            ("reconfiguration_freq", None),
        ):
            assert shown[keyword].default == default, name
        assert ("angle_threshold" in shown) == ("Rotate" in name), name
        assert all(part in cls.__doc__ for part in ("Flow: ", "Success: ", "Customisation: ")), name
        assert max(map(len, cls.__doc__.splitlines()[1:])) <= 100, name
    assert "COLORS" in mikasa.RememberColor3VLAEnv.__doc__
    assert "cue_steps_per_env" in mikasa.RememberColor3VLAEnv.__doc__


def test_whole_constants_are_ints_as_in_the_original():
    assert type(mikasa.RememberColor3VLAEnv.MANIP_WIDTH_SCALE) is int
    assert type(mikasa.ShellGameTouchVLAEnv.HEIGHT_OFFSET) is int
    assert type(mikasa.ShellGameColorLampTouchVLAEnv.HEIGHT_OFFSET) is float
    with made("ShellGameTouch-VLA-v0") as env:
        assert type(env.unwrapped.HEIGHT_OFFSET) is int


def test_it_is_documented():
    page = (Path(__file__).parents[3] / "docs" / "mikasa.md").read_text()
    for name in (
        *mikasa._keywords._IGNORED,
        *mikasa._keywords._REFUSED,
        *mikasa._variants._REFUSED_METHODS,
    ):
        assert f"`{name}`" in page, name
