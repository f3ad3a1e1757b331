from __future__ import annotations

import pytest
from conftest import registered_ids

import engram


def test_list_names_all_tasks():
    tasks = engram.list()
    ids = [task["id"] for task in tasks]
    assert ids[:97] == registered_ids()  # then variants that other tests have registered
    assert sum(task["canonical"] for task in tasks) == 90
    assert {task["split"] for task in tasks} >= {"short", "medium", "long"}
    tasks[0]["id"] = "changed"
    assert engram.list()[0]["id"] != "changed"


def test_describe_has_horizon_actions_draws_and_fields():
    described = engram.describe("RememberColor3-VLA-v0")
    assert described["horizon"] == 25
    assert described["action_spaces"]["pd_ee_delta_pose"]["dim"] == 7
    assert "target" in [draw["name"] for draw in described["draws"]]
    assert sum(field["width"] for field in described["state_fields"]) == described["state_dim"]


def test_describe_follows_options():
    described = engram.describe("RememberColor3-VLA-v0", control_mode="pd_joint_pos")
    assert described["action_dim"] == 8
    with pytest.raises(engram.UnknownIdError):
        engram.describe("Nothing-VLA-v0")


def test_version():
    assert engram.__version__.count(".") == 2
