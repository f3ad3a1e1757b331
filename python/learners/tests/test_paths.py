"""engram_learners/paths.py: what a policy keeps of objects that moved by themselves."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from programs import learners, torch

pytest.importorskip("matplotlib")

TASK = "TraceShapeHard-VLA-v0"
POINTS = 70
DEMO = 64  # steps, of NUM_WAYPOINTS


@pytest.fixture(scope="module")
def episodes() -> SimpleNamespace:
    """Oracle's episodes: layout, rows (T, N, D), when each has succeeded first (N)."""
    env = learners.training.ObjectsEnv(TASK, 16, 3)
    rows, won = [env.reset(seed=3)], []
    for _ in range(180):
        rows.append(env.step(env.oracle())[0])
        won.append(torch.from_numpy(np.array(env.infos["success_once"])))
    success = torch.stack(won)
    assert success[-1].all()
    return SimpleNamespace(
        env=env,
        layout=env.layout,
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


def test_a_path_is_where_the_red_cube_has_been(episodes: SimpleNamespace) -> None:
    *_, kept = learners.paths.paths(episodes.layout, episodes.rows, None, POINTS)
    path, _, count = parts_of(kept, POINTS)
    red, place = of_red_cube(episodes.layout, episodes.rows)
    assert (count[red] == DEMO).all()
    assert (count[~red] == 0).all()  # the green one was carried
    for env, points in enumerate(path[red][:, :DEMO]):
        assert torch.equal(points[0], place[0, env])  # where it stands at first
        shown = place[:, env][(place[:, env] != 0).any(-1)]
        distance = (points[:, None] - shown).norm(dim=-1).amin(1)
        assert distance.max() == 0
        assert len(points.unique(dim=0)) == DEMO


def test_points_are_passed_by_what_the_tool_leads(episodes: SimpleNamespace) -> None:
    left = left_of(episodes.layout, episodes.rows, POINTS)
    assert left[5].max() <= 3  # the red cube has hardly begun
    for env, won in enumerate(episodes.won):
        assert left[: won - 20, env].max() == DEMO
        assert left[won, env] == 0


def left_of(layout: Any, rows: Any, points: int) -> Any:
    """Points that are left after every step (T, N)."""
    _, left, _ = learners.paths.paths(layout, rows, None, points)
    assert torch.equal(left[..., 1], (left[..., 2] > 0).float())
    return (learners.paths.MANY * left[..., 2]).round()


def test_a_sequence_is_passed_line_by_line() -> None:
    points = 330
    env = learners.training.ObjectsEnv("TraceShapeSeqHard-VLA-v0", 8, 3)
    rows, closed, won = [env.reset(seed=3)], [], []
    for _ in range(620):
        rows.append(env.step(env.oracle())[0])
        closed.append(np.array(env.infos["all_shapes_closed"]))
        won.append(np.array(env.infos["success_once"]))
    assert won[-1].all()
    left = left_of(env.layout, torch.stack(rows), points)
    lengths = set()
    for env, (ends, end) in enumerate(zip(np.argmax(closed, 0) + 1, np.argmax(won, 0) + 1)):
        shown = left[:end, env].max()
        lengths.add(int(shown))
        assert shown % DEMO == 0
        # The oracle closes the last shape up to 35 mm before its end, and goes to the button.
        assert left[ends - 5, env] < DEMO
        assert left[end, env] == 0
    assert len(lengths) > 2


def circle(turn: float = 0.0) -> Any:
    """64 points of a circle with a radius of 100 mm, in units of 0.5 m. turn: rad."""
    angle = turn + torch.arange(64) * 2 * np.pi / 64
    return 0.2 * torch.stack([angle.cos(), angle.sin()], -1)


def follow(path: Any, led: Any) -> Any:
    """Passed points (T, points) of a cube that is led along these places (T, 2)."""
    counts = torch.full((len(led), 1, 1), len(path))
    none = torch.zeros(1, 1, len(path), dtype=torch.bool)
    leads = torch.ones(len(led), 1, dtype=torch.bool)
    path = path[None, None]
    lines = learners.paths.lines_of(path, counts[-1])
    passed = learners.paths.follow(lines, counts, none, led[:, None], leads)
    return passed[:, 0, 0]


def test_the_end_of_a_line_is_passed_last() -> None:
    """At its begin, a closed line's end is near, and is not passed."""
    passed = follow(circle(), circle())
    assert not passed[:-4, -1].any()
    assert passed[-1].all()


@pytest.mark.parametrize("turn", [0.0, 0.2, 1.0, np.pi])
def test_another_line_begins_when_one_closes(turn: float) -> None:
    """Although the second one lies where the first one does, whether or not the object jumps."""
    path = torch.cat([circle(), circle(turn)])
    lines = learners.paths.lines_of(path[None, None], torch.tensor([[128]]))
    assert lines.ends[0, 0].nonzero()[:, 0].tolist() == [63, 127]
    assert torch.equal(lines.place[0, 0, [63, 127]], path[[0, 64]])
    passed = follow(path, path)
    assert not passed[:58, 64:].any()
    assert passed[70:, :64].all()
    assert passed[-1].all()
    # With one circle traced, the other has hardly begun.
    assert follow(path, path[:64])[-1, 64:].sum() < 10


def test_an_open_line_ends_where_the_object_jumps() -> None:
    arc = circle()[:20]
    path = torch.cat([arc, arc.flip(0) + 0.5])
    lines = learners.paths.lines_of(path[None, None], torch.tensor([[40]]))
    assert lines.ends[0, 0].nonzero()[:, 0].tolist() == [19, 39]
    assert torch.equal(lines.place[0, 0], path)


@pytest.mark.parametrize(
    ("begin", "end", "left"),
    [(20, 31, 0), (20, 33, 6), (47, 59, 0), (40, 59, 12)],
    ids=["few", "many", "few_before_the_end", "many_before_the_end"],
)
def test_few_points_may_be_left_out(begin: int, end: int, left: int) -> None:
    """Four in a row, five near the end. To more of them the tool has to come back."""
    line = torch.stack([0.02 * torch.arange(60), torch.zeros(60)], -1)
    led = line.clone()
    led[begin + 1 : end, 1] = 0.12  # 60 mm beside the line: too far
    passed = follow(line, torch.cat([led, line[begin:]]))
    missed = ~passed[: len(led)][-1]
    assert missed[:-1].sum() == left
    assert missed[-1] == (left > 0)
    assert passed[-1].all()


def test_ways_lead_to_what_is_left(episodes: SimpleNamespace) -> None:
    """Where nothing has been passed, to the first point: from every object in sight."""
    layout, rows = episodes.layout, episodes.rows[: DEMO + 12]
    ways, _, kept = learners.paths.paths(layout, rows, None, POINTS)
    path, passed, _ = parts_of(kept, POINTS)
    assert (passed == 0).all()
    red, _ = of_red_cube(layout, rows)
    tokens = layout.split(rows[-1])[1]
    way = path[red][:, None, 0] - tokens[..., layout.place][..., :2]
    expected = 5 * way * tokens[..., :1]
    np.testing.assert_allclose(ways[-1, ..., :2], expected, atol=1e-6)
    assert expected.abs().max() > 0.5


def test_full_paths_keep_their_first_points(episodes: SimpleNamespace) -> None:
    few = 20
    *_, kept = learners.paths.paths(episodes.layout, episodes.rows, None, few)
    *_, all_kept = learners.paths.paths(episodes.layout, episodes.rows, None, POINTS)
    path, _, count = parts_of(kept, few)
    red, _ = of_red_cube(episodes.layout, episodes.rows)
    assert (count[red] == few).all()
    assert torch.equal(path[red], parts_of(all_kept, POINTS)[0][red][:, :few])


def test_paths_go_on_from_what_is_kept(episodes: SimpleNamespace) -> None:
    whole = learners.paths.paths(episodes.layout, episodes.rows, None, POINTS)
    state, found = None, []
    for rows in episodes.rows.split(13):
        *part, state = learners.paths.paths(episodes.layout, rows, state, POINTS)
        found.append(part)
    for parts, expected in zip([*zip(*found), [state]], whole):
        assert torch.equal(torch.cat(parts), expected)


def test_a_policy_keeps_paths_until_they_are_wiped(episodes: SimpleNamespace) -> None:
    torch.manual_seed(0)
    policy = learners.policy.Policy(episodes.layout, path_points=POINTS)
    policy.fit(episodes.rows[0])
    with torch.no_grad():
        *_, state, _ = policy(episodes.rows[: DEMO + 12])
        which = torch.arange(16) % 2 == 1
        wiped = policy.reset_state(state, which)
    red, _ = of_red_cube(episodes.layout, episodes.rows)
    kept = wiped[3][..., -learners.paths.path_size(POINTS) :]
    count = parts_of(kept, POINTS)[2][red]
    assert count.tolist() == [0 if i % 2 else DEMO for i in range(16)]
    packed = learners.long_episodes.pack(policy, None, 16)
    first = learners.long_episodes.unpack(*packed)
    assert [part.shape[1:] for part in first] == [part.shape[1:] for part in state]


def test_a_trained_policy_gets_room_for_longer_paths(episodes: SimpleNamespace) -> None:
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
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    given: list[str],
) -> None:
    monkeypatch.setattr("sys.argv", ["distil", *given])
    with pytest.raises(SystemExit):
        learners.distil.arguments()
    error = capsys.readouterr().err
    assert f"--path-points: {given[1]} given; 0 or more, and a memory, needed" in error
