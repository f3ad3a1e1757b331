"""python/examples/memory/paths.py: what a policy keeps of objects that moved by themselves."""

from __future__ import annotations

from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from learners import modules

torch = pytest.importorskip("torch")
pytest.importorskip("matplotlib")

TASK = "TraceShapeHard-VLA-v0"
POINTS = 70
DEMO = 64  # steps, of NUM_WAYPOINTS


@pytest.fixture(scope="module")
def learners() -> Iterator[SimpleNamespace]:
    with modules("distil", "long_episodes", "paths", "policy", "training") as found:
        yield found


@pytest.fixture(scope="module")
def episodes(learners: SimpleNamespace) -> SimpleNamespace:
    """Oracle's episodes: layout, rows (T, N, D), when each has succeeded first (N)."""
    scenes = learners.training.ObjectsEnv(TASK, 16, 3)
    rows, won = [scenes.reset(seed=3)], []
    for _ in range(180):
        rows.append(scenes.step(scenes.oracle())[0])
        won.append(torch.from_numpy(np.array(scenes.infos["success_once"])))
    success = torch.stack(won)
    assert success[-1].all()
    return SimpleNamespace(
        scenes=scenes,
        layout=scenes.layout,
        rows=torch.stack(rows),
        won=success.int().argmax(0) + 1,
    )


def of_red_cube(layout: Any, rows: Any) -> tuple[Any, Any]:
    """Where the red cube's token is (N, tokens), and where the cube is (T, N, 2)."""
    tokens = layout.split(rows)[1]
    red = tokens[0, ..., layout.part["color"].start] > 0
    assert (red.sum(-1) == 1).all()
    return red, tokens[:, red][..., layout.place][..., :2]


def parts_of(kept: Any, points: int) -> tuple[Any, Any, Any]:
    path, passed, count, _ = kept.split([2 * points, points, 1, 4], -1)
    return path.unflatten(-1, (points, 2)), passed, count[..., 0]


def test_a_path_is_where_the_red_cube_has_been(
    learners: SimpleNamespace, episodes: SimpleNamespace
) -> None:
    _, kept = learners.paths.paths(episodes.layout, episodes.rows, None, POINTS)
    path, _, count = parts_of(kept, POINTS)
    red, place = of_red_cube(episodes.layout, episodes.rows)
    # One point less than waypoints: it stands at the first.
    assert (count[red] == DEMO - 1).all()
    assert (count[~red] == 0).all()  # the green one was carried
    for env, points in enumerate(path[red][:, : DEMO - 1]):
        shown = place[:, env][(place[:, env] != 0).any(-1)]
        distance = (points[:, None] - shown).norm(dim=-1).amin(1)
        assert distance.max() == 0
        assert len(points.unique(dim=0)) == DEMO - 1


def test_points_are_passed_by_what_the_tool_leads(
    learners: SimpleNamespace, episodes: SimpleNamespace
) -> None:
    features, _ = learners.paths.paths(episodes.layout, episodes.rows, None, POINTS)
    left = (64 * features[..., -1]).amax(-1)  # of objects in sight
    assert left[5].max() <= 3  # the red cube has hardly begun
    for env, won in enumerate(episodes.won):
        at_question = left[: won - 20, env].max()
        assert at_question == DEMO - 1
        assert left[won, env] <= 6  # the oracle cuts corners within 35 mm


def test_ways_lead_to_what_is_left(learners: SimpleNamespace, episodes: SimpleNamespace) -> None:
    """Where nothing has been passed, to the first point: from every object in sight."""
    layout, rows = episodes.layout, episodes.rows[: DEMO + 12]
    features, kept = learners.paths.paths(layout, rows, None, POINTS)
    path, passed, _ = parts_of(kept, POINTS)
    assert (passed == 0).all()
    red, _ = of_red_cube(layout, rows)
    tokens = layout.split(rows[-1])[1]
    way = path[red][:, None, 0] - tokens[..., layout.place][..., :2]
    expected = 5 * way * tokens[..., :1]
    np.testing.assert_allclose(features[-1, ..., :2], expected, atol=1e-6)
    assert expected.abs().max() > 0.5


def test_full_paths_keep_their_first_points(
    learners: SimpleNamespace, episodes: SimpleNamespace
) -> None:
    few = 20
    _, kept = learners.paths.paths(episodes.layout, episodes.rows, None, few)
    _, all_kept = learners.paths.paths(episodes.layout, episodes.rows, None, POINTS)
    path, _, count = parts_of(kept, few)
    red, _ = of_red_cube(episodes.layout, episodes.rows)
    assert (count[red] == few).all()
    assert torch.equal(path[red], parts_of(all_kept, POINTS)[0][red][:, :few])


def test_paths_go_on_from_what_is_kept(
    learners: SimpleNamespace, episodes: SimpleNamespace
) -> None:
    features, kept = learners.paths.paths(episodes.layout, episodes.rows, None, POINTS)
    state, found = None, []
    for rows in episodes.rows.split(13):
        part, state = learners.paths.paths(episodes.layout, rows, state, POINTS)
        found.append(part)
    assert torch.equal(torch.cat(found), features)
    assert torch.equal(state, kept)


def test_a_policy_keeps_paths_until_they_are_wiped(
    learners: SimpleNamespace, episodes: SimpleNamespace
) -> None:
    torch.manual_seed(0)
    policy = learners.policy.Policy(episodes.layout, path_points=POINTS)
    policy.fit(episodes.rows[0])
    with torch.no_grad():
        *_, state, _ = policy(episodes.rows[: DEMO + 12])
        which = torch.arange(16) % 2 == 1
        wiped = policy.wipe(state, which)
    red, _ = of_red_cube(episodes.layout, episodes.rows)
    kept = wiped[3][..., -learners.paths.path_size(POINTS) :]
    count = parts_of(kept, POINTS)[2][red]
    assert count.tolist() == [0 if i % 2 else DEMO - 1 for i in range(16)]
    packed = learners.long_episodes.pack(policy, None, 16)
    first = learners.long_episodes.unpack(*packed)
    assert [part.shape[1:] for part in first] == [part.shape[1:] for part in state]


def test_a_trained_policy_gets_room_for_longer_paths(
    learners: SimpleNamespace, episodes: SimpleNamespace
) -> None:
    torch.manual_seed(0)
    policy = learners.policy.Policy(episodes.layout, path_points=20)
    policy.fit(episodes.rows[0])
    rows = episodes.rows[:10]  # less than 20 points
    with torch.no_grad():
        before = policy(rows)[0]
        learners.distil.keep_paths(policy, POINTS)
        after = policy(rows)[0]
    assert torch.equal(before.mean, after.mean)
    assert policy.sizes["path_points"] == POINTS
    without = learners.policy.Policy(episodes.layout)
    with pytest.raises(SystemExit, match="70 given; the policy to begin with keeps no paths"):
        learners.distil.keep_paths(without, POINTS)


@pytest.mark.parametrize("given", [["--path-points", "-1"], ["--path-points", "70", "--no-memory"]])
def test_paths_need_a_memory(
    learners: SimpleNamespace,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    given: list[str],
) -> None:
    monkeypatch.setattr("sys.argv", ["distil.py", *given])
    with pytest.raises(SystemExit):
        learners.distil.arguments()
    error = capsys.readouterr().err
    assert f"--path-points: {given[1]} given; 0 or more, and a memory, needed" in error
