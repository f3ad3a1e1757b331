"""Refused arguments of similar types, and infos that are read-only."""

from __future__ import annotations

import fuzz_options
import numpy as np
import pytest
from conftest import TASK

import engram


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("cameras", []),
        ("cameras", ()),
        ("freeze_cue", "no"),
        ("freeze_cue", 0),
        ("sleep", []),
        ("sleep", None),
        ("shadows", "off"),
        ("terminate_on_success", 1),
        ("observe_time", "false"),
        ("copy", "no"),
        ("language_in_info", 0),
        ("num_envs", True),
        ("num_envs", np.bool_(True)),
        ("num_envs", "2"),
        ("num_envs", 2.0),
        ("threads", True),
        ("seed", False),
        ("robot_init_qpos_noise", "0.02"),
        ("robot_init_qpos_noise", True),
        ("robot_init_qpos_noise", 10**400),
        ("pins", {"target": "2"}),
        ("pins", {"target": None}),
        ("pins", {"target": True}),
        ("pins", {"target": [[1]]}),
        ("task_options", {"strict": "1"}),
        ("task_options", []),
        ("perturb", {"light": "1"}),
        ("perturb", ["light"]),
        ("image_size", True),
        ("renderer", "cpu\0egl"),
        ("control_mode", "\ud800"),
        ("render_mode", np.array([])),
        ("max_episode_steps", True),
    ],
)
def test_truthy_values_are_refused(name, value):
    options = {"num_envs": 2, name: value}
    with pytest.raises(engram.InvalidArgumentError, match=name) as refused:
        engram.make_vec(TASK, **options)
    assert str(refused.value).isprintable()


@pytest.mark.parametrize(
    "id", [f"{TASK}\0", f"\0{TASK}", "\ud800", 3, None, b"RememberColor3-VLA-v0"]
)
def test_a_registered_id_is_replaced_completely(id):
    with pytest.raises(engram.InvalidArgumentError, match="id: "):
        engram.make_vec(id)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("policy", None),
        ("ids", 3),
        ("ids", [3]),
        ("ids", f"{TASK}\0"),
        ("episodes", True),
        ("episodes", 2.5),
        ("seed", -1),
        ("num_envs", "8"),
        ("name", "a\0b"),
        ("config", [1]),
        ("config", {"a": float("nan")}),
        ("config", {"a": object()}),
        ("output", ""),
        ("output", 3),
        ("resume", "a\0b"),
        ("progress", 3),
        ("obs", ["rgb"]),
        ("task_options", {"strict": "1"}),
    ],
)
def test_arguments_of_evaluate_are_checked(name, value):
    options = {"policy": fuzz_options.no_policy, "ids": TASK, "episodes": 1, name: value}
    with pytest.raises(engram.InvalidArgumentError, match=name):
        engram.evaluate(options.pop("policy"), options.pop("ids"), **options)


@pytest.mark.parametrize("answer", [None, 3, "none", object()])
def test_an_answer_that_holds_no_rows_is_refused(answer):
    with pytest.raises(engram.InvalidArgumentError, match="policy: "):
        engram.evaluate(lambda _: answer, TASK, episodes=1, obs="state", threads=1)


@pytest.mark.parametrize("mode", ["DISABLED", "SAME_STEP"])
def test_views_in_infos_are_read_only(make, mode):
    env = make(copy=False, autoreset_mode=mode, language_in_info=True)
    _, info = env.reset()
    *_, later = env.step(env.act("zero"))
    for name, array in (*info.items(), *later.items()):
        if not name.startswith("_"):  # masks are made anew each time
            assert not array.flags.writeable, name
    for infos in (info, later):
        with pytest.raises(ValueError, match="read-only"):
            infos["language_instruction"][0] = "changed"


def test_messages_are_lines_that_terminals_can_show():
    assert str(engram.InvalidArgumentError("a\nb\x1b[2J\u202e")) == "a b\\x1b[2J\\u202e"
    assert len(str(engram.IoError("x" * 10**6))) < 3000


def test_a_slice_of_the_fuzzing_finds_nothing():
    counts, findings = fuzz_options.play(0, 300)
    assert not findings
    assert counts["refused"] > 200
    assert counts["accepted"] > 5
