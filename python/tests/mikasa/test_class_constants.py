"""Constants of the package's own classes: their forms, and values that users set."""

from __future__ import annotations

import functools
import re

import numpy as np
import pytest

pytest.importorskip("torch")

import torch
from conftest import registered_ids
from helpers import made

import engram
import engram.mikasa as mikasa

COLORS = mikasa.RememberColorVLABaseEnv


@pytest.fixture(autouse=True)
def unchanged():
    """Takes back what a test has set."""
    yield
    for cls in mikasa.classes.CLASSES.values():
        cls._set.clear()


described_once = functools.cache(engram.describe)


def made_with(id: str, *names: str):
    with made(id) as env:
        return tuple(getattr(env.unwrapped, name) for name in names)


def test_a_constant_that_is_set_counts_in_what_is_made_afterwards():
    with made("RememberColor3-VLA-v0") as before:
        mikasa.RememberColor3VLAEnv.COLORS = 5
        assert mikasa.RememberColor3VLAEnv.COLORS == 5
        assert before.unwrapped.COLORS == 3
    with made("RememberColor3-VLA-v0", num_envs=2) as env:
        assert env.unwrapped.COLORS == 5
        assert env.unwrapped.single_observation_space.shape == (18 + 7 + 1 + 5 * 3,)
        assert len(env.unwrapped.color_dict) == 5
    del mikasa.RememberColor3VLAEnv.COLORS
    assert made_with("RememberColor3-VLA-v0", "COLORS") == (3,)
    with pytest.raises(AttributeError, match="COLORS"):
        del mikasa.RememberColor3VLAEnv.COLORS


def test_a_base_class_sets_the_constants_of_its_ids():
    COLORS.GOAL_THRESH = 0.03
    for id in ("RememberColor3-VLA-v0", "RememberColor9-Long-VLA-v0"):
        assert made_with(id, "GOAL_THRESH") == (0.03,)
    assert mikasa.RememberColor5VLAEnv.GOAL_THRESH == 0.03
    assert made_with("FindImposterColor3-VLA-v0", "GOAL_THRESH") == (0.05,)
    mikasa.RememberColor3VLAEnv.GOAL_THRESH = 0.04  # nearer than the base
    assert made_with("RememberColor3-VLA-v0", "GOAL_THRESH") == (0.04,)
    # Batteries of the easy task derive from those of the hard one.
    mikasa.BatteriesCheckerVLABaseEnv.SLOT_RETURN_XY_TOL = 0.03
    assert made_with("BatteriesCheckerEasy-3-VLA-v0", "SLOT_RETURN_XY_TOL") == (0.03,)


def test_ids_keep_the_constants_that_their_classes_set():
    COLORS.COLORS = 7
    COLORS.CUE_PHASE_STEPS = (2, 2)
    assert COLORS.COLORS == 7
    assert mikasa.RememberColor9VLAEnv.COLORS == 9
    assert made_with("RememberColor9-VLA-v0", "COLORS", "CUE_PHASE_STEPS") == (9, [1, 5])

    class Own(mikasa.RememberColorVLABaseEnv):
        EMPTY_PHASE_STEPS = (3, 3)

    env = Own(num_envs=2, threads=1)
    assert (env.COLORS, env.CUE_PHASE_STEPS) == (7, (2, 2))
    env.reset(seed=1)
    assert env.cue_steps_per_env.tolist() == [2, 2]
    assert env.empty_steps_per_env.tolist() == [3, 3]
    env.close()


def test_writing_into_a_list_counts_too():
    mikasa.RememberColor3VLAEnv.CUE_PHASE_STEPS[1] = 1
    with made("RememberColor3-VLA-v0", num_envs=8) as env:
        env.reset(seed=1)
        assert env.unwrapped.cue_steps_per_env.tolist() == [1] * 8
    mikasa.RememberShapeAndColor3x2VLAEnv.COLOR_PALETTE[2] = np.array([0.9, 0.5, 0.1, 1])
    (palette,) = made_with("RememberShapeAndColor3x2-VLA-v0", "COLOR_PALETTE")
    assert palette[2].tolist() == [0.9, 0.5, 0.1, 1]


@pytest.mark.parametrize(
    ("cls", "name", "nearest"),
    [("RememberColor3VLAEnv", "COLOURS", "COLORS"), ("TakeItBackVLABaseEnv", "GOAL", "GOAL_RADIUS"),
     ("InterceptSlowVLAEnv", "SPEED_RANGE", "VELOCITY_RANGE"),
     ("RememberColor3VLAEnv", "LANGUAGE_INSTRUCTIONS", "LANGUAGE_INSTRUCTION"),
     ("RememberColor3VLAEnv", "LANGUAGE_INSTRUCTION_TEMPLATE", "LANGUAGE_INSTRUCTION")],
)  # fmt: skip
def test_unknown_names_are_refused_with_the_nearest(cls, name, nearest):
    with pytest.raises(engram.UnknownIdError, match=f"did you mean {nearest}[?]"):
        setattr(getattr(mikasa, cls), name, 1)
    assert not hasattr(getattr(mikasa, cls), name)


def test_fixed_constants_and_impossible_values_are_refused():
    with pytest.raises(engram.InvalidArgumentError, match="fixed at 30"):
        mikasa.TimedTransferEasyVLAEnv.SUCCESS_BONUS = 1
    mikasa.TimedTransferEasyVLAEnv.SUCCESS_BONUS = 30.0
    mikasa.RememberColor3VLAEnv.COLORS = 12
    with (
        pytest.raises(engram.InvalidArgumentError, match="12 given, a whole number from 2 to 9"),
        made("RememberColor3-VLA-v0"),
    ):
        pass


def test_every_class_has_an_instruction_that_can_be_set():
    with made("RememberColor3-VLA-v0") as env:
        known = env.reset(seed=1)[1]["language_instruction"]
        assert known == mikasa.RememberColor3VLAEnv.LANGUAGE_INSTRUCTION
    COLORS.LANGUAGE_INSTRUCTION = "Touch it."
    with made("RememberColor3-VLA-v0") as env:
        assert env.reset(seed=1)[1]["language_instruction"] == "Touch it."
        assert env.unwrapped.LANGUAGE_INSTRUCTION == "Touch it."
    with pytest.raises(engram.InvalidArgumentError, match="a text needed"):
        COLORS.LANGUAGE_INSTRUCTION = 3


def test_instructions_that_name_a_number():
    assert "step 100 " in mikasa.TimedTransferEasyVLAEnv.LANGUAGE_INSTRUCTION
    mikasa.TimedTransferEasyVLAEnv.DELAY_STEPS = 60
    assert "step 60 " in mikasa.TimedTransferEasyVLAEnv.LANGUAGE_INSTRUCTION
    with made("TimedTransferEasy-VLA-v0") as env:
        assert "step 60 " in env.reset(seed=1)[1]["language_instruction"]
    rotate = mikasa.RotateLenientPosVLAEnv
    assert "{angle_deg}" in rotate.LANGUAGE_INSTRUCTION
    assert rotate.LANGUAGE_INSTRUCTION == rotate.LANGUAGE_INSTRUCTION_TEMPLATE
    with made("RotateLenientPos-VLA-v0", num_envs=2) as env:
        known = env.reset(seed=1)[1]["language_instruction"]
        rotate.LANGUAGE_INSTRUCTION_TEMPLATE = "Turn by {angle_deg}!"
    with made("RotateLenientPos-VLA-v0", num_envs=2) as env:
        own = env.reset(seed=1)[1]["language_instruction"]
    angles = [re.search(r"by (\S+) degrees", one)[1] for one in known]
    assert own == [f"Turn by {angle}!" for angle in angles]


def test_constants_have_the_originals_forms():
    battery = mikasa.BatteriesChecker3VLAEnv
    for name in ("BATTERY_COLOR", "TRAY_COLOR", "LAMP_ON_COLOR", "BUTTON_BASE_HALF_SIZE",
                 "SOCKET_HALF_SIZE"):  # fmt: skip
        value = getattr(battery, name)
        assert isinstance(value, np.ndarray), name
        assert value.dtype == np.float32
    assert battery.BATTERY_COLOR[:3].tolist() == pytest.approx([70 / 255, 190 / 255, 90 / 255])
    gather = mikasa.GatherAndRecall3VLAEnv
    assert [color.dtype for color in gather.FLASH_COLORS] == [np.float32] * 3
    assert gather.CUBE_COLORS[1].tolist() == [0, 1, 0, 1]
    palette = mikasa.RememberShapeAndColor3x2VLAEnv.COLOR_PALETTE
    assert {key: (rgba.dtype, rgba.tolist()) for key, rgba in palette.items()}[1] == (
        np.float64,
        [0, 1, 0, 1],
    )
    lamps = mikasa.ShellGameShuffleColorLampTouchVLAEnv.COLOR_RGBA
    assert lamps.dtype == torch.float32
    assert tuple(lamps.shape) == (3, 4)
    assert mikasa.InterceptSlowVLAEnv.VELOCITY_RANGE == (0.25, 0.5)
    assert mikasa.RememberColor3VLAEnv.CUE_PHASE_STEPS == [1, 5]
    assert mikasa.RememberColor3VLAEnv.COLOR_MAPPING[1] == ("Lime", [0, 255, 0, 255])
    assert mikasa.TraceShapeHardVLAEnv.AVAILABLE_SHAPES == [0, 1, 2]


@pytest.mark.parametrize("id", registered_ids())
def test_constants_can_be_given_back(id):
    described = described_once(id)
    printed = engram.describe(id, constants=described["constants"])
    assert printed == described
    cls = mikasa.registration.REGISTERED[id]
    read = {name: getattr(cls, name) for name in described["constants"]}
    assert engram.describe(id, constants=read) == described
    for name, value in read.items():
        setattr(cls, name, value)
    assert mikasa._variants.changed_constants(cls) == {}


@pytest.mark.parametrize("family", sorted(mikasa._families.LEAF_CONSTANTS))
def test_ids_of_a_family_differ_in_the_constants_that_their_classes_set(family):
    described = [described_once(id) for id in registered_ids()]
    constants = [one["constants"] for one in described if one["family"] == family]
    differing = {
        name for name in constants[0] if any(one[name] != constants[0][name] for one in constants)
    }
    assert differing <= set(mikasa._families.LEAF_CONSTANTS[family])
    assert set(mikasa._families.LEAF_CONSTANTS[family]) <= set(constants[0])


def test_constants_as_arrays_and_names_of_colours():
    for palette in (
        {0: np.array([1.0, 0.5, 0.1, 1]), 1: np.array([0.2, 0.3, 0.4], np.float32)},
        [[1, 0.5, 0.1], torch.tensor([0.2, 0.3, 0.4])],
    ):
        described = engram.describe(
            "RememberShapeAndColor3x2-VLA-v0", constants={"COLOR_PALETTE": palette, "SHAPES": 4}
        )
        assert described["changed"]["COLOR_PALETTE"] == [[1, 0.5, 0.1], [0.2, 0.3, 0.4]]
    described = engram.describe(
        "RememberShapeAndColor3x2-VLA-v0", constants={"COLOR_PALETTE": ["Teal", "red", "Lime"]}
    )
    assert described["changed"]["COLOR_PALETTE"] == ["teal", "red", "green"]
