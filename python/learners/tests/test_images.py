"""engram_learners from pictures: views, the detector, and the poses of long objects."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from programs import learners, torch

LAMP = "ShellGameShuffleColorLampTouch-VLA-v0"
COLOR3 = "RememberColor3-VLA-v0"
ROTATE = "RotateStrictPosNeg-VLA-v0"


def played(
    task: str,
    steps: int,
    note: Callable[[Any], None] = lambda env: None,
) -> Any:
    """Environment with images, after some steps of the oracle; the detector is not asked.

    note: called before every step.
    """
    env = learners.images.rgb_env.RgbEnv(task, 16, seed=5)
    env.detector.update = lambda pictures, proprio, before: before
    env.reset(seed=5)
    for _ in range(steps):
        env.store()
        note(env)
        env.step(env.oracle())
    del env.detector.update
    return env


def test_views_project_positions_as_the_cameras_do() -> None:
    env, views = played(COLOR3, 9), learners.images.views
    pictures, proprio, shown, _ = env.last
    both = (views.base_view(), views.wrist_view(proprio))
    meant = env.detector.codes // 32 // (env.objects.shapes + 1)
    assert meant.tolist() == [0, 1, 2]  # cubes: red, lime, blue
    for i, view in enumerate(both):
        pixels = views.project(shown.place, view)
        inside = ((pixels > 1) & (pixels < 126)).all(-1) & (shown.known >= 0)
        assert inside.float().mean() > 0.3
        color = views.sample(pictures[..., 3 * i : 3 * i + 3], torch.arange(16), pixels)
        right = color.argmax(-1) == meant
        assert right[inside].float().mean() > 0.8  # the arm hides some
    camera = env.camera.camera_params()["hand_camera"]["cam2world_gl"]
    expected = torch.from_numpy(np.array(camera))
    np.testing.assert_allclose(both[1][0], expected[:, :3, 3], atol=1e-4)
    np.testing.assert_allclose(both[1][1][:, :2], expected[:, :3, :2].mT, atol=1e-4)
    points = views.unproject(views.project(shown.place, both[0])[0], shown.place[0, :, 2:])
    np.testing.assert_allclose(points, shown.place[0], atol=1e-5)


def test_the_detector_learns_positions() -> None:
    torch.manual_seed(0)
    env = played(COLOR3, 25)
    env.learn(50)
    env.reset(seed=99)
    for _ in range(12):
        env.step(env.oracle())
    found, true = env.found, env.shown
    assert (true.known >= 0).all()
    assert (found.known == true.known).float().mean() > 0.9
    away = (found.place - true.place).norm(dim=-1)
    assert away.median() < 0.015  # m; the cubes are spread over 0.4 m


def test_labels_have_a_token_for_each_of_like_objects() -> None:
    """Three cups have three tokens, which they keep; a lamp has one, whatever its colour."""
    env = played(LAMP, 40)
    detector, shown = env.detector, env.shown
    of_cup = detector.tokens == detector.tokens.mode().values
    assert of_cup.sum() == 3
    assert len(detector.tokens) == 7 < len(detector.codes)
    assert (shown.known[:, of_cup] >= 0).all()
    cups = shown.place[:, of_cup]
    assert torch.pdist(cups[0]).min() > 0.05
    before = env.last[3].place[:, of_cup]
    assert (cups - before).norm(dim=-1).max() < 0.08


def test_a_detector_of_before_is_refused() -> None:
    with pytest.raises(ValueError, match="another version of the detector"):
        learners.images.detector.ObjectDetector.of_weights({"appearances": torch.zeros(3)})


def test_like_objects_keep_their_tokens() -> None:
    """Whatever the order in which they are proposed."""
    bodies, tokens = torch.tensor([0, 1]), torch.tensor([0, 0, 1])
    extent = torch.tensor([[-0.2, 0.2], [-0.2, 0.2]])
    detector = learners.images.detector.ObjectDetector(
        torch.tensor([3, 5]), torch.zeros(2, 42), bodies, tokens, extent
    )
    places = torch.arange(6.0)[None, :, None].expand(1, 6, 3)
    names = torch.tensor([[-0.1, -3.0], [-0.1, -3.0], [-3.0, -0.1]]).repeat(2, 1)[None]
    tracked = torch.tensor([[True, True, False, False, False, True]])
    result = detector.assign(places, names, names, tracked)
    assert result.known.tolist() == [[0, 0, 1]]
    assert result.place[0, :, 0].tolist() == [0, 1, 5]
    lost = torch.tensor([[False, True, False, True, False, False]])
    lost = detector.assign(places, names, names, lost)
    assert lost.known.tolist() == [[0, 0, -1]]
    assert lost.place[0, :2, 0].tolist() == [3, 1]


# --- turns of long objects ---


@pytest.fixture(scope="module")
def rotated() -> Any:
    """Scenes of a peg that have been played to the end, whose labels have been collected."""
    torch.manual_seed(0)
    turned, engine = [], []

    def note(env: Any) -> None:
        if turned:  # the first step is not among the engine's
            engine.append(torch.from_numpy(np.array(env.infos["relative_angle"])))
        turned.append(env.shown.turn[:, 0])

    env = played(ROTATE, 70, note)
    env.turned, env.engine = turned, engine
    return env


def test_the_robot_of_a_rotate_task_has_the_tool_s_orientation_and_the_asked_turn(
    rotated: Any,
) -> None:
    objects, layout = rotated.objects, rotated.layout
    state = rotated.batch.reset(seed=8)[0]
    seen = rotated.camera.reset(seed=8)[0]
    for _ in range(20):
        action = rotated.oracle().numpy()
        state = rotated.batch.step(action)[0]
        seen = rotated.camera.step(action)[0]
    asked = learners.instructions.turns_of(rotated.batch.instructions)
    row = learners.images.views.robot_features(seen["proprio"], asked)
    assert row.shape[1] == layout.agent
    np.testing.assert_allclose(row[:, layout.tool], state[:, objects.tool], atol=1e-5)
    np.testing.assert_allclose(180 * row[:, layout.turn], 180 * state[:, objects.turn], atol=0.51)
    assert (row[:, layout.turn] < 0).any()
    assert learners.instructions.turns_of(["Touch the cube"]).tolist() == [[0.0]]


def test_labels_follow_a_peg_beyond_where_it_looks_the_same(rotated: Any) -> None:
    turned = torch.stack(rotated.turned)
    assert (turned[0, :, 0] >= 0).all()  # within a quarter of a turn of ahead
    assert (turned[-1, :, 0] < 0).any()
    since = learners.rotations.angle(learners.rotations.relative(turned[0], turned[1:]))
    engine = torch.stack(rotated.engine).reshape(since.shape)
    assert engine[-1].abs().max() > 0.5
    np.testing.assert_allclose(since, engine, atol=1e-3)


def test_a_direction_and_its_opposite_are_one_peg() -> None:
    angles = torch.linspace(-3.1, 3.1, 40)
    direction = learners.rotations.direction_of(angles)
    before = learners.rotations.direction_of(angles + 0.7 * torch.sin(9 * angles))
    np.testing.assert_allclose(learners.rotations.nearer_half(direction, before), direction)
    np.testing.assert_allclose(learners.rotations.nearer_half(-direction, before), direction)


def test_the_detector_learns_turns(rotated: Any) -> None:
    torch.manual_seed(0)
    rotated.learn(60)
    rotated.reset(seed=99)
    for _ in range(30):
        rotated.step(rotated.oracle())
    found, true = rotated.found, rotated.shown
    both = (found.known >= 0) & (true.known >= 0)
    assert both.float().mean() > 0.9
    wrong = learners.rotations.relative(found.turn, true.turn)
    half = learners.rotations.alignments(wrong)[0][both]
    assert half.abs().median() < math.radians(4)
    assert (found.place - true.place).norm(dim=-1)[both].median() < 0.015
    rows = rotated.detector.rows(rotated.last[1], found, rotated.layout, rotated.turns)
    tokens = rotated.layout.split(rows)[1]
    np.testing.assert_allclose(rotated.layout.yaw(tokens)[both], found.turn[both], atol=1e-5)


def test_a_saved_detector_has_the_refiner_only_where_something_is_long(
    rotated: Any, tmp_path: Path
) -> None:
    path = tmp_path / "agent.pt"
    policy = learners.policy.Policy(rotated.layout)
    learners.checkpoints.save_policy(policy, path, ROTATE, rotated.detector)
    loaded, detector, _ = learners.checkpoints.load_policy(path)
    assert loaded.layout.agent == rotated.layout.agent
    pictures, proprio = rotated.last[:2]
    before = detector.initial(16)
    for mine, own in zip(
        detector.update(pictures, proprio, before),
        rotated.detector.update(pictures, proprio, before),
    ):
        torch.testing.assert_close(mine, own)
    cubes = learners.images.rgb_env.RgbEnv(COLOR3, 2).detector.state_dict()
    assert not [name for name in cubes if name.startswith(("turning", "refiner"))]
