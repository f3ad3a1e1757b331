"""Session over a WebSocket without a browser: playing, watching, saving."""

from __future__ import annotations

import io
import json
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from play_server import SECONDS, Server, play_oracle, serving

import engram
from engram.datasets import DemonstrationFolder
from engram.play.episode_spec import EpisodeSpec
from engram.play.game import Game
from engram.play.playback import MOST_STEPS, Playback, Policy, recorded_policy
from engram.play.score import EPISODES, Scores
from engram.play.sources import builtin_policy

TASK = "RememberColor3-VLA-v0"
IDS = [task["id"] for task in engram.list()][:97]  # other tests register more
PIPE_POLICY = Path(__file__).parents[2] / "examples" / "pipe_policy.py"


# --- information before and after the end ---


@pytest.mark.parametrize(
    ("id", "pin", "values"),
    [
        ("RememberColor9-VLA-v0", "target", (0, 5)),
        ("ShellGamePush-VLA-v0", "cup_with_ball_number", (0, 2)),
        ("TakeItBack-VLA-v0", "slot", (-1, 1)),
    ],
)
def test_only_the_cue_reveals_the_answer(server: Server, id, pin, values):
    """Two episodes that hide different things: what is sent is the same, until the end."""
    received, sent = [], []
    for value in values:
        with server.page() as page:
            page.receive("hello")
            page.play(id, 11, pins={pin: value, **({"cue_steps": 2} if pin != "slot" else {})})
            files = [page.step([0, 0, 0, 0, 0, 0, 1], n) and page.files for n in range(1, 13)]
            # Pictures of the cue differ, and so do their sizes.
            received.append([{**m, "sizes": None} if "sizes" in m else m for m in page.received])
            sent.append(files)
    assert received[0] == received[1]
    allowed = {"kind", "n", "input", "ended", "sizes"}
    for message in received[0]:
        if "kind" in message:
            assert set(message) == allowed
    opened = next(m for m in received[0] if m.get("type") == "opened")
    assert set(opened) == {"type", "id", "instruction", "horizon", "seed", "view", "score"}
    if pin != "slot":  # there, the cube lies where it was
        assert sent[0][5:] == sent[1][5:]  # the pictures too, once the cue is over


def test_the_human_view_has_no_marks_for_people():
    """Marks for people would reveal the initial position of the cube in TakeItBack."""
    game = Game(EpisodeSpec("TakeItBack-VLA-v0", 5))
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


def test_a_random_seed_is_sent_at_the_end_only(server: Server):
    with server.page() as page:
        opened = page.play(TASK)
        assert opened["seed"] is None
        for n in range(25):
            page.step([0] * 6 + [1], n)
        assert page.receive("ended")["seed"].isdigit()


def test_the_end_reports_success_answer_and_reward(server: Server):
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


def test_pictures_are_those_of_the_library(server: Server):
    """Step by step, and by the clock: pictures are those of the actions that were sent."""
    rng = np.random.default_rng(3)
    actions = rng.uniform(-1, 1, (8, 7)).round(3)
    with server.page() as page:
        page.play(TASK, 4)
        for n, action in enumerate(actions):
            page.step(action, n)
        data = page.files[0]
    game = Game(EpisodeSpec(TASK, 4))
    for action in actions:
        game.step(action.tolist())
    assert data in game.picture(0)
    game.close()


def test_a_refused_request_leaves_the_episode_as_it_was(server: Server):
    wrong = [
        ("play", {"pins": {"target": 99}}),  # of the same batch
        ("play", {"constants": {"COLORS": 99}}),
        ("grid", {"source": "oracle", "constants": {"COLORS": 99}}),
        ("grid", {"source": "nobody"}),
        ("watch", {"source": "oracle", "pins": {"target": 99}}),
        ("stored", {"folder": 0, "task": 0, "episode": 0}),
    ]
    with server.page() as page:
        page.play(TASK, 3)
        for n, (kind, more) in enumerate(wrong, 1):
            assert page.step([0] * 6 + [1])["n"] == n
            page.send(kind, **(more if kind == "stored" else {"id": TASK, "seed": "77", **more}))
            with pytest.raises(AssertionError):
                page.receive("nothing")
        for _ in range(25 - len(wrong)):
            page.step([0] * 6 + [1])
        assert page.receive("ended")["seed"] == "3"


def test_time_passes_by_the_clock_and_stops(server: Server):
    with server.page() as page:
        page.play("RememberColor3-Long-VLA-v0", 4)
        page.send("run", on=True)
        for _ in range(10):
            page.receive("play")
            page.send("seen", n=0)
        page.send("run", on=False)
        while page.receive("running")["on"]:
            pass
        assert max(m.get("n", 0) for m in page.received) >= 9
        assert page.step([0] * 6 + [1])["n"] == max(m.get("n", 0) for m in page.received)


def test_time_can_wait_for_the_player(server: Server):
    with server.page() as page:
        page.play("RememberColor3-Long-VLA-v0", 4)
        page.send("speed", of=1, turns=True)
        page.send("run", on=True)
        page.receive("running")
        with pytest.raises(TimeoutError):
            page.socket.recv(timeout=0.5)
        page.send("act", a=[0.5, 0, 0, 0, 0, 0, 1], n=7, held=True)
        assert page.receive("play")["input"] == 7
        page.send("act", a=[0, 0, 0, 0, 0, 0, 1], n=8, held=False)


def test_a_page_without_acknowledgements_gets_fewer_pictures(server: Server):
    with server.page() as page:
        page.play(TASK, 4)
        page.send("run", on=True)
        page.receive("ended")
        shown = [m for m in page.received if m.get("kind") == "play"]
        assert len(shown) <= 6
        assert shown[-1]["ended"]


def test_a_score_needs_ten_episodes_and_is_between_the_two_policies():
    rates = {"sweep": {"success_once": 0.6}, "oracle": {"success_once": 1.0}}
    described = {"id": TASK, "chance": 0.3, "ceilings": rates}
    scores = Scores()
    for seed in range(EPISODES):
        assert scores.of(described)["memory"] is None
        scores.add(TASK, seed, False, None)
    assert scores.of(described)["memory"] == 0
    for seed in range(EPISODES, EPISODES + 8):
        scores.add(TASK, seed, True, None)
    assert scores.of(described)["memory"] == pytest.approx((0.8 - 0.6) / 0.4)
    assert scores.of({**described, "ceilings": None})["memory"] is None


# --- saving ---


def test_played_episodes_are_demonstrations(tmp_path):
    """Saved, read, replayed to the same bits, converted."""
    for module in ("pyarrow", "av", "google_crc32c", "pandas"):
        pytest.importorskip(module)
    out = tmp_path / "played"
    ids = (TASK, "ShellGameTouch-VLA-v0")
    with serving(out) as server, server.page() as page:
        for id in ids:
            for seed in (31, 5):
                play_oracle(page, id, seed)
                page.send("save")
                saved = page.receive("saved")
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
    # In a process of its own: video libraries of several packages conflict at exit.
    words = [[str(word) for word in job] for job in jobs]
    script = f"from engram.datasets.__main__ import main; print([main(job) for job in {words}])"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert done.stdout == "[0, 0, 0, 0, 0]\n", done.stderr


def test_only_successes_in_unchanged_tasks_are_saved(server: Server):
    with server.page() as page:
        page.play(TASK, 6)
        for n in range(25):
            page.step([0] * 6 + [1], n)
        page.receive("ended")
        page.send("save")
        with pytest.raises(AssertionError, match="did not succeed"):
            page.receive("saved")
        page.play(TASK, 6, pins={"cue_steps": 2})
        for n in range(25):
            page.step([0] * 6 + [1], n)
        assert not page.receive("ended")["counted"]
        page.send("save")
        with pytest.raises(AssertionError, match="pins"):
            page.receive("saved")
    assert not server.out.exists()


def test_folders_with_other_files_are_not_changed(tmp_path):
    out = tmp_path / "played"
    command = [sys.executable, "-m", "engram", "collect", TASK, "--episodes=1", "--out", out]
    subprocess.run(command, check=True, capture_output=True, timeout=SECONDS)
    before = {file: file.read_bytes() for file in out.rglob("*") if file.is_file()}
    with serving(out) as server, server.page() as page:
        play_oracle(page, TASK, 9)
        page.send("save")
        with pytest.raises(AssertionError, match="did not write"):
            page.receive("saved")
    assert {file: file.read_bytes() for file in out.rglob("*") if file.is_file()} == before


# --- watching ---


def played_back(spec: EpisodeSpec, policy: Policy, **more: Any) -> Playback:
    """An episode, played to its end."""
    playback = Playback(spec, policy, **more)
    assert playback.run()
    return playback


def test_a_playback_is_the_episode_of_the_library():
    playback = played_back(EpisodeSpec("GatherAndRecall3-VLA-v0", 5), builtin_policy("oracle"))
    message = playback.message()
    steps = message["result"]["steps"]
    for name in ("reward", "tcp", "gripper", "phase"):
        assert len(message[name]) == steps + 1 == message["frames"]
    names = [message["phases"][phase] for phase in message["phase"]]
    assert names[0] == "move"
    assert "flash" in names
    assert names[-1] == "press"
    again = played_back(playback.spec, recorded_policy(playback.actions))
    assert again.message() == message
    for frame in (0, 7, 8, 9, steps, 3, steps - 1):
        assert playback.picture(frame) == again.picture(frame)
    playback.close()
    again.close()


@pytest.mark.parametrize(
    "id", ["RememberShape3-VLA-v0", "SeqOfColors3-VLA-v0", "ShellGameShuffleTouch-VLA-v0"]
)
def test_phases_have_the_pinned_lengths(id):
    described = engram.describe(id)
    pins = {d["name"]: d["high"] for d in described["draws"] if "_step" in d["name"]}
    playback = played_back(EpisodeSpec(id, 5, pins=pins), builtin_policy("oracle"))
    phases = playback.message()["phase"]
    assert phases == sorted(phases)
    gap = "empty_steps" if "empty_steps" in pins else "shuffle_steps"
    cue = pins.get("cue_steps", 3 * pins.get("cue_step_duration", 0))  # three colours
    assert [phases.count(0), phases.count(1)] == [cue, pins[gap]]
    assert set(phases) == {0, 1, 2}
    playback.close()


@pytest.mark.parametrize("id", IDS)
def test_every_step_of_every_task_has_a_phase(id):
    playback = played_back(EpisodeSpec(id, 3), builtin_policy("oracle"), most_steps=400)
    message = playback.message()
    playback.close()
    names = [message["phases"][phase] for phase in message["phase"] if phase is not None]
    over = len(message["phase"]) - len(names)  # a window that has passed
    assert over == 0 or "window" in message["phases"]
    assert names[0] == message["phases"][0]


def test_policies_can_be_watched_picture_by_picture(server: Server):
    with server.page() as page:
        for source in ("oracle", "blind", "sweep", "random"):
            page.send("watch", id=TASK, source=source, seed="3")
            message = page.receive("playback")
            assert message["frames"] == 26
            for frame in (25, 0, 13):
                page.send("frame", n=frame)
                assert page.receive("playback")["n"] == frame
                assert Image.open(io.BytesIO(page.files[0])).size == (640, 480)


ENDLESS = {"max_episode_steps": 1_000_000}


def test_an_endless_episode_is_shown_in_part(server: Server):
    with server.page() as page:
        page.send("watch", id=TASK, source="zero", seed="3", constants=ENDLESS)
        message = page.receive("playback")
        assert message["frames"] == MOST_STEPS + 1
        assert (message["cut"], message["horizon"]) == (True, 1_000_000)
        built = [m["steps"] for m in page.received if m.get("type") == "building"]
        assert built == sorted(built)
        page.send("frame", n=MOST_STEPS)
        assert page.receive("playback")["n"] == MOST_STEPS
        page.send("watch", id=TASK, source="zero", seed="3")
        assert not page.receive("playback")["cut"]


def test_a_page_that_plays_a_long_episode_stays_awake(server: Server):
    """It is played in the background: everything else goes on at once."""
    with server.page() as page:
        page.play(TASK, 3)
        page.send("watch", id=TASK, source="zero", seed="3", constants=ENDLESS)
        for n in range(3):  # the episode that is open goes on until the other one is there
            start = time.monotonic()
            page.step([0] * 7, n)
            assert time.monotonic() - start < 3
        start = time.monotonic()
        page.play(TASK, 4)  # and this ends it
        assert time.monotonic() - start < 5
        assert page.step([0] * 7)["n"] == 1
        page.send("watch", id=TASK, source="zero", seed="5")
        while page.receive("playback")["seed"] != "5":
            pass
        assert all(
            m["type"] != "playback" or m["seed"] == "5" for m in page.received if "type" in m
        )


def test_the_played_episode_can_be_reviewed_and_saved_afterwards(server: Server):
    with server.page() as page:
        ended = play_oracle(page, "ShellGameTouch-VLA-v0", 8)
        page.send("review")
        playback = page.receive("playback")
        assert playback["result"]["steps"] == ended["steps"]
        assert playback["result"]["return"] == pytest.approx(ended["return"])
        assert playback["seed"] == "8"
        page.send("save")
        page.receive("saved")


def test_a_grid_shows_sixteen_at_once(server: Server):
    with server.page() as page:
        page.send("grid", id="ShellGameTouch-VLA-v0", source="oracle", seed="3")
        page.receive("grid")
        page.send("run", on=True)
        header = page.receive("grid")
        while "ended" not in header or not all(header["ended"]):
            page.send("seen", n=0)
            header = page.receive("grid")
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
        hello = page.receive("hello")
        assert hello["sources"][-1] == "process"
        stored, evaluated = hello["folders"]
        page.send("stored", folder=0, task=0, episode=1)
        playback = page.receive("playback")
        assert playback["result"]["steps"] == stored["tasks"][0]["episodes"][1]["steps"]
        assert playback["result"]["success"]
        for number, episode in enumerate(evaluated["tasks"][0]["episodes"]):
            page.send("stored", folder=1, task=0, episode=number)
            playback = page.receive("playback")
            assert playback["seed"] == episode["seed"]
            assert playback["result"]["success"] == episode["success"]
        page.send("watch", id=TASK, source="process", seed="4242424242")
        playback = page.receive("playback")
        page.send("grid", id=TASK, source="process", seed="1")
        page.receive("grid")
        page.send("run", on=True)
        page.receive("running")
        page.receive("grid")
    # Equal to what `engram eval` plays with it.
    outside = tmp_path / "outside"
    command = [*engram_command, "eval", TASK, "--policy-command", policy, "--episodes=1"]
    subprocess.run([*command, "--out", outside], check=True, capture_output=True, timeout=SECONDS)
    result = json.loads(next(outside.rglob(f"{TASK}.json")).read_text())
    assert playback["result"]["return"] == pytest.approx(result["returns"][0])


def test_results_with_other_rules_options_and_constants_are_reproduced(tmp_path):
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
        for folder, message in enumerate(page.receive("hello")["folders"]):
            (file,) = runs[folder].glob("*-v0.json")
            result = json.loads(file.read_text())
            assert len(message["tasks"][0]["episodes"]) == 3
            for episode in range(3):
                page.send("stored", folder=folder, task=0, episode=episode)
                playback = page.receive("playback")
                assert playback["result"]["success"] == bool(result["successes"][episode])
                assert playback["result"]["steps"] == result["episode_lengths"][episode]
                assert playback["result"]["return"] == pytest.approx(result["returns"][episode])


def test_a_failed_policy_is_reported_and_restarted(tmp_path):
    with serving(tmp_path / "out", "--policy-command", "echo no") as server, server.page() as page:
        for _ in range(2):
            page.send("watch", id=TASK, source="process")
            with pytest.raises(AssertionError, match="the policy"):
                page.receive("playback")
