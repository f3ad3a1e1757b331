"""Playing, watching and keeping, by a tab without a browser."""

from __future__ import annotations

import io
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from play_server import SECONDS, Page, Server, serving

import engram
from engram.datasets import DemonstrationFolder
from engram.play.playback import Film, recorded
from engram.play.game import Game
from engram.play.episode_spec import Setting
from engram.play.sources import own_player

TASK = "RememberColor3-VLA-v0"
IDS = [task["id"] for task in engram.list()][:97]  # other tests register more
PIPE_POLICY = Path(__file__).parents[2] / "examples" / "pipe_policy.py"


def play_oracle(page: Page, id: str, seed: int) -> dict:
    """An episode with the oracle's actions, to its end; returns how it ended."""
    page.play(id, seed)
    mirror = Setting(id, seed).batch(terminate_on_success=True)
    mirror.reset(seed=seed)
    ended = False
    while not ended:
        action = np.clip(mirror.act("oracle")[0], -1, 1).astype(np.float64)
        ended = page.step(action)["ended"]
        mirror.step(action.astype(np.float32)[None])
    mirror.close()
    return page.hear("ended")


# --- what is told, and when ---


@pytest.mark.parametrize(
    ("id", "pin", "values"),
    [
        ("RememberColor9-VLA-v0", "target", (0, 5)),
        ("ShellGamePush-VLA-v0", "cup_with_ball_number", (0, 2)),
        ("TakeItBack-VLA-v0", "slot", (-1, 1)),
    ],
)
def test_nothing_but_the_cue_tells_the_answer(server: Server, id, pin, values):
    """Two episodes that hide different things: what is sent is the same, until the end."""
    heard, sent = [], []
    for value in values:
        with server.page() as page:
            page.hear("hello")
            page.play(id, 11, pins={pin: value, **({"cue_steps": 2} if pin != "slot" else {})})
            files = [page.step([0, 0, 0, 0, 0, 0, 1], n) and page.files for n in range(1, 13)]
            # Pictures of the cue differ, and so do their sizes.
            heard.append([{**m, "sizes": None} if "sizes" in m else m for m in page.heard])
            sent.append(files)
    assert heard[0] == heard[1]
    allowed = {"kind", "n", "input", "ended", "sizes"}
    for message in heard[0]:
        if "kind" in message:
            assert set(message) == allowed
    opened = next(m for m in heard[0] if m.get("type") == "opened")
    assert set(opened) == {"type", "id", "instruction", "horizon", "seed", "view", "score"}
    if pin != "slot":  # there, the cube lies where it was
        assert sent[0][5:] == sent[1][5:]  # the pictures too, once the cue is over


def test_the_human_view_shows_what_sensors_may_see():
    """Marks for people would tell where the cube of TakeItBack has to go back to."""
    game = Game(Setting("TakeItBack-VLA-v0", 5))
    for _ in range(3):
        game.step([0, 0, 0, 0, 0, 0, 1])
    with_marks = game._env.frame(0, "render_camera", (640, 480))
    data = game.picture(0)
    size = int.from_bytes(data[:4], "little")
    header = json.loads(data[4 : 4 + size])
    shown = Image.open(io.BytesIO(data[4 + size : 4 + size + header["sizes"][0]]))
    difference = np.abs(np.asarray(shown, int) - with_marks).max(axis=-1)
    assert (difference > 90).sum() > 50  # the mark
    game.close()


def test_a_drawn_seed_is_told_at_the_end_alone(server: Server):
    with server.page() as page:
        opened = page.play(TASK)
        assert opened["seed"] is None
        for n in range(25):
            page.step([0] * 6 + [1], n)
        assert page.hear("ended")["seed"].isdigit()


def test_the_end_tells_success_answer_and_reward(server: Server):
    with server.page() as page:
        ended = play_oracle(page, TASK, 21)
    assert ended["success"]
    assert ended["answered"]
    assert ended["first_answer_correct"]
    assert ended["return"] > 0
    assert ended["counted"]
    score = ended["score"]
    described = engram.describe(TASK)
    assert score["chance"] == described["chance"]
    assert score["sweep"] == described["ceilings"]["sweep"]["success_once"]
    assert score["oracle"] == described["ceilings"]["oracle"]["success_once"]
    with server.page() as page:  # the same seed again was seen before
        assert not play_oracle(page, TASK, 21)["counted"]


def test_what_is_played_is_what_the_library_plays(server: Server):
    """Step by step, and by the clock: pictures are those of the actions that were sent."""
    rng = np.random.default_rng(3)
    actions = rng.uniform(-1, 1, (8, 7)).round(3)
    with server.page() as page:
        page.play(TASK, 4)
        for n, action in enumerate(actions):
            page.step(action, n)
        data = page.files[0]
    game = Game(Setting(TASK, 4))
    for action in actions:
        game.step(action.tolist())
    assert data in game.picture(0)
    game.close()


def test_time_passes_by_the_clock_and_stops(server: Server):
    with server.page() as page:
        page.play("RememberColor3-Long-VLA-v0", 4)
        page.say("run", on=True)
        for _ in range(10):
            page.hear("play")
            page.say("seen", n=0)
        page.say("run", on=False)
        while page.hear("running")["on"]:
            pass
        assert max(m.get("n", 0) for m in page.heard) >= 9
        assert page.step([0] * 6 + [1])["n"] == max(m.get("n", 0) for m in page.heard)


def test_time_may_wait_for_the_player(server: Server):
    with server.page() as page:
        page.play("RememberColor3-Long-VLA-v0", 4)
        page.say("speed", of=1, turns=True)
        page.say("run", on=True)
        page.hear("running")
        with pytest.raises(TimeoutError):
            page.socket.recv(timeout=0.5)
        page.say("act", a=[0.5, 0, 0, 0, 0, 0, 1], n=7, held=True)
        assert page.hear("play")["input"] == 7
        page.say("act", a=[0, 0, 0, 0, 0, 0, 1], n=8, held=False)


def test_a_page_that_does_not_look_gets_fewer_pictures(server: Server):
    with server.page() as page:
        page.play(TASK, 4)
        page.say("run", on=True)
        page.hear("ended")
        shown = [m for m in page.heard if m.get("kind") == "play"]
        assert len(shown) <= 6
        assert shown[-1]["ended"]


# --- keeping ---


def test_played_episodes_are_demonstrations(tmp_path):
    """Kept, read as such, replayed to the same bits, converted."""
    for module in ("pyarrow", "av", "google_crc32c", "pandas"):
        pytest.importorskip(module)
    out = tmp_path / "played"
    ids = (TASK, "ShellGameTouch-VLA-v0")
    with serving(out) as server, server.page() as page:
        for id in ids:
            for seed in (31, 5):
                play_oracle(page, id, seed)
                page.say("save")
                saved = page.hear("saved")
        assert saved["episodes"] == 2
        assert server.get("refused.json") == {}
    for id in ids:
        folder = DemonstrationFolder(out / "data_npz" / id)
        assert [episode.episode_seed for episode in folder] == [31, 5]
        assert folder.metadata["engram"]["player"] == "engram play"
    jobs = [
        ["replay", out],
        ["rlds", out],
        ["lerobot", out, "--images"],
        ["replay", out, "--format", "rlds"],
        ["replay", out, "--format", "lerobot"],
    ]
    # In a process of its own: film libraries of several packages may not end in one.
    words = [[str(word) for word in job] for job in jobs]
    script = f"from engram.datasets.__main__ import main; print([main(job) for job in {words}])"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert done.stdout == "[0, 0, 0, 0, 0]\n", done.stderr


def test_only_successes_of_the_task_as_it_is_are_kept(server: Server):
    with server.page() as page:
        page.play(TASK, 6)
        for n in range(25):
            page.step([0] * 6 + [1], n)
        page.hear("ended")
        page.say("save")
        with pytest.raises(AssertionError, match="did not succeed"):
            page.hear("saved")
        page.play(TASK, 6, pins={"cue_steps": 2})
        for n in range(25):
            page.step([0] * 6 + [1], n)
        assert not page.hear("ended")["counted"]
        page.say("save")
        with pytest.raises(AssertionError, match="pins"):
            page.hear("saved")
    assert not server.out.exists()


def test_folders_of_others_are_left_alone(tmp_path):
    out = tmp_path / "played"
    command = [sys.executable, "-m", "engram", "collect", TASK, "--episodes=1", "--out", out]
    subprocess.run(command, check=True, capture_output=True, timeout=SECONDS)
    before = {file: file.read_bytes() for file in out.rglob("*") if file.is_file()}
    with serving(out) as server, server.page() as page:
        play_oracle(page, TASK, 9)
        page.say("save")
        with pytest.raises(AssertionError, match="were not played here"):
            page.hear("saved")
    assert {file: file.read_bytes() for file in out.rglob("*") if file.is_file()} == before


# --- watching ---


def test_a_film_is_the_episode_of_the_library():
    film = Film(Setting("GatherAndRecall3-VLA-v0", 5), own_player("oracle"))
    told = film.told()
    steps = told["result"]["steps"]
    for name in ("reward", "tcp", "gripper", "phase"):
        assert len(told[name]) == steps + 1 == told["frames"]
    names = [told["phases"][phase] for phase in told["phase"]]
    assert names[0] == "move"
    assert "flash" in names
    assert names[-1] == "press"
    again = Film(film.setting, recorded(film.actions))
    assert again.told() == told
    for frame in (0, 7, 8, 9, steps, 3, steps - 1):
        assert film.picture(frame) == again.picture(frame)
    film.close()
    again.close()


@pytest.mark.parametrize(
    "id", ["RememberShape3-VLA-v0", "SeqOfColors3-VLA-v0", "ShellGameShuffleTouch-VLA-v0"]
)
def test_phases_are_as_long_as_pins_say(id):
    described = engram.describe(id)
    pins = {d["name"]: d["high"] for d in described["draws"] if "_step" in d["name"]}
    film = Film(Setting(id, 5, pins=pins), own_player("oracle"))
    phases = film.told()["phase"]
    assert phases == sorted(phases)
    gap = "empty_steps" if "empty_steps" in pins else "shuffle_steps"
    cue = pins.get("cue_steps", 3 * pins.get("cue_step_duration", 0))  # three colours
    assert [phases.count(0), phases.count(1)] == [cue, pins[gap]]
    assert set(phases) == {0, 1, 2}
    film.close()


@pytest.mark.parametrize("id", IDS)
def test_every_moment_of_every_task_has_a_phase(id):
    film = Film(Setting(id, 3), own_player("oracle"), most_steps=400)
    told = film.told()
    film.close()
    names = [told["phases"][phase] for phase in told["phase"] if phase is not None]
    over = len(told["phase"]) - len(names)  # a window that has passed
    assert over == 0 or "window" in told["phases"]
    assert names[0] == told["phases"][0]


def test_policies_can_be_watched_picture_by_picture(server: Server):
    with server.page() as page:
        for source in ("oracle", "blind", "sweep", "random"):
            page.say("watch", id=TASK, source=source, seed="3")
            told = page.hear("film")
            assert told["frames"] == 26
            for frame in (25, 0, 13):
                page.say("frame", n=frame)
                assert page.hear("film")["n"] == frame
                assert Image.open(io.BytesIO(page.files[0])).size == (640, 480)


def test_the_episode_that_was_played_can_be_looked_at_and_kept_afterwards(server: Server):
    with server.page() as page:
        ended = play_oracle(page, "ShellGameTouch-VLA-v0", 8)
        page.say("review")
        film = page.hear("film")
        assert film["result"]["steps"] == ended["steps"]
        assert film["result"]["return"] == pytest.approx(ended["return"])
        assert film["seed"] == "8"
        page.say("save")
        page.hear("saved")


def test_a_wall_shows_sixteen_at_once(server: Server):
    with server.page() as page:
        page.say("wall", id="ShellGameTouch-VLA-v0", source="oracle", seed="3")
        page.hear("wall")
        page.say("run", on=True)
        header = page.hear("wall")
        while "over" not in header or not all(header["over"]):
            page.say("seen", n=0)
            header = page.hear("wall")
        assert len(header["success"]) == 16
        assert all(header["success"])
        assert Image.open(io.BytesIO(page.files[0])).size == (768, 576)


def test_folders_and_processes_of_the_command_line_can_be_watched(tmp_path):
    engram_command = [sys.executable, "-m", "engram"]
    data, results = tmp_path / "data", tmp_path / "results"
    for arguments in (
        ["collect", TASK, "--episodes=2", "--out", data],
        ["eval", TASK, "--policy=sweep", "--obs=state", "--episodes=2", "--out", results],
    ):
        command = [*engram_command, *map(str, arguments)]
        subprocess.run(command, check=True, capture_output=True, timeout=SECONDS)
    (run,) = (path.parent for path in results.rglob("settings.json"))
    policy = f"{sys.executable} {PIPE_POLICY}"
    arguments = ["--folder", data, "--folder", run, "--policy-command", policy]
    with serving(tmp_path / "out", *arguments) as server, server.page() as page:
        hello = page.hear("hello")
        assert hello["sources"][-1] == "process"
        stored, evaluated = hello["folders"]
        page.say("stored", folder=0, task=0, episode=1)
        film = page.hear("film")
        assert film["result"]["steps"] == stored["tasks"][0]["episodes"][1]["steps"]
        assert film["result"]["success"]
        for number, episode in enumerate(evaluated["tasks"][0]["episodes"]):
            page.say("stored", folder=1, task=0, episode=number)
            film = page.hear("film")
            assert film["seed"] == episode["seed"]
            assert film["result"]["success"] == episode["success"]
        page.say("watch", id=TASK, source="process", seed="4242424242")
        film = page.hear("film")
        page.say("wall", id=TASK, source="process", seed="1")
        page.hear("wall")
        page.say("run", on=True)
        page.hear("running")
        page.hear("wall")
    # The same as `engram eval` plays with it.
    outside = tmp_path / "outside"
    command = [*engram_command, "eval", TASK, "--policy-command", policy, "--episodes=1"]
    subprocess.run([*command, "--out", outside], check=True, capture_output=True, timeout=SECONDS)
    result = json.loads(next(outside.rglob(f"{TASK}.json")).read_text())
    assert film["result"]["return"] == pytest.approx(result["returns"][0])


def test_results_with_other_rules_options_and_constants_play_as_they_did(tmp_path):
    engram_command = [sys.executable, "-m", "engram"]
    variants = tmp_path / "variants.json"
    variant = {
        "id": "RememberColor4-Played-v0",
        "base": "RememberColor9-VLA-v0",
        "constants": {"COLORS": 4},
    }
    variants.write_text(json.dumps({"variants": [variant]}))
    runs = []
    for name, arguments in {
        "rules": [TASK, "--policy=sweep", "--rules=original"],
        "constants": [TASK, "--policy=sweep", "--set", "GOAL_THRESH=0.03"],
        "variant": [variant["id"], "--policy=blind", "--variants", variants],
    }.items():
        command = [*engram_command, "eval", *arguments, "--obs=state", "--episodes=3"]
        command += ["--out", tmp_path / name]
        subprocess.run([*map(str, command)], check=True, capture_output=True, timeout=SECONDS)
        runs.extend(path.parent for path in (tmp_path / name).rglob("settings.json"))
    arguments = [word for run in runs for word in ("--folder", run)]
    with serving(tmp_path / "out", *arguments) as server, server.page() as page:
        for folder, told in enumerate(page.hear("hello")["folders"]):
            (file,) = runs[folder].glob("*-v0.json")
            result = json.loads(file.read_text())
            assert len(told["tasks"][0]["episodes"]) == 3
            for episode in range(3):
                page.say("stored", folder=folder, task=0, episode=episode)
                film = page.hear("film")
                assert film["result"]["success"] == bool(result["successes"][episode])
                assert film["result"]["steps"] == result["episode_lengths"][episode]
                assert film["result"]["return"] == pytest.approx(result["returns"][episode])


def test_a_policy_that_fails_is_told_and_started_again(tmp_path):
    with serving(tmp_path / "out", "--policy-command", "echo no") as server, server.page() as page:
        for _ in range(2):
            page.say("watch", id=TASK, source="process")
            with pytest.raises(AssertionError, match="the policy"):
                page.hear("film")
