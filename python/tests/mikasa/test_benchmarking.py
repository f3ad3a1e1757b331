"""engram.mikasa.benchmarking: its results are those of ``engram eval --rules original``."""

from __future__ import annotations

import csv
import dataclasses
import json
import os
import subprocess
import sys

import numpy as np
import pytest

pytest.importorskip("torch")

import torch
from policies import Looking, as_engram

import engram
from engram.mikasa import benchmarking

# In the order of engram's list, which its evaluation follows.
IDS = ["ShellGameTouch-VLA-v0", "RememberColor3-VLA-v0", "RotateLenientPos-VLA-v0"]
CONFIG = benchmarking.BenchmarkConfig(n_episodes=2, sim_backend="auto")
# Keys that differ from the original's, or exist in engram only.
OTHERS = ("benchmark_commit", "action_chunk_size")


def test_results_are_those_of_engram_eval(tmp_path):
    tasks = benchmarking.select_benchmark_tasks(env_ids=IDS)
    calls = []
    results, summary = benchmarking.evaluate_benchmark(
        tasks, Looking(3), CONFIG, output_dir=tmp_path, model={"name": "looking", "config": {}},
        progress=calls.append, task_start_callback=lambda i, task: calls.append(task.env_id),
        episode_callback=lambda i, result: calls.append(result.seed),
        task_done_callback=lambda i, result: calls.append(result["sr"]),
    )  # fmt: skip
    own = engram.evaluate(
        as_engram(Looking(3)), IDS, episodes=2, rules="original", name="looking", num_envs=2
    )
    for mine, theirs in zip(results, own["tasks"]):
        common = [key for key in mine if key in theirs and key not in OTHERS]
        assert len(common) == len(mine) - len(OTHERS)
        assert {key: mine[key] for key in common} == {key: theirs[key] for key in common}
        assert mine["action_chunk_size"] == 3
    assert {key: summary[key] for key in summary} == {key: own["summary"][key] for key in summary}
    assert len(calls) == 3 * (1 + 1 + 2 + 1)
    for result in results:
        assert json.loads((tmp_path / f"{result['env_id']}.json").read_text()) == result
    assert json.loads((tmp_path / "summary.json").read_text()) == summary


def test_tasks(tmp_path):
    counts = {
        split: len(benchmarking.select_benchmark_tasks(split=split))
        for split in benchmarking.SUPPORTED_SPLITS
    }
    assert counts == {"short": 38, "medium": 30, "long": 22, "all": 90}
    (task,) = benchmarking.select_benchmark_tasks(env_ids=["Mine-v0"])
    assert (task.split, task.memory_type, task.max_episode_steps) == ("custom", "Unknown", 0)
    with pytest.raises(engram.InvalidArgumentError, match="one of them"):
        benchmarking.select_benchmark_tasks()
    with pytest.raises(engram.InvalidArgumentError, match="split"):
        benchmarking.select_benchmark_tasks(split="tiny")
    table = tmp_path / "tasks.csv"
    table.write_text(
        "id;Name;Max Length;Memory Type;Horizon Split;Data Source;language_instruction\n"
        "1;RememberColor3-VLA-v0;25;Object;Short;PPO;Touch it.\n"
    )
    (task,) = benchmarking.load_benchmark_tasks(table)
    assert task == benchmarking.BenchmarkTask(
        "RememberColor3-VLA-v0", "short", "Object", 25, "Touch it.", "PPO"
    )


def test_the_commands_table_is_that_of_the_original(tmp_path):
    table = tmp_path / "mikasa_robo_vla_envs.csv"
    words = [sys.executable, "-m", "engram", "list", "--csv"]
    table.write_bytes(subprocess.run(words, capture_output=True, check=True).stdout)
    tasks = benchmarking.load_benchmark_tasks(table)
    assert {task.data_source for task in tasks} == {"PPO", "Motion Planning"}
    assert [dataclasses.replace(task, data_source="") for task in tasks] == (
        benchmarking.load_benchmark_tasks()
    )
    with table.open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file, delimiter=";"))
    assert [row["id"] for row in rows] == [str(i + 1) for i in range(90)]
    assert sum(row["Horizon Split"] == "Short" for row in rows) == 38


def test_settings():
    assert benchmarking.START_SEED == 4242424242
    assert benchmarking.BenchmarkConfig().sim_backend == "gpu"
    for wrong in ({"n_episodes": 0}, {"start_seed": -1}):
        with pytest.raises(ValueError, match="given"):
            benchmarking.BenchmarkConfig(**wrong)
    with pytest.raises(engram.InvalidArgumentError, match="none given"):
        benchmarking.summarize_task_results([])


@pytest.mark.parametrize("shape", [(7,), (4, 7), (1, 4, 7), (0, 7), (3,), (2, 2, 7)])
def test_answers(shape):
    class Policy:
        def forward(self, obs):
            return np.zeros(shape, np.float32)

    config = benchmarking.BenchmarkConfig(n_episodes=1, obs_mode="rgb")
    env = benchmarking.make_benchmark_env(IDS[1], config)
    if shape in [(7,), (4, 7), (1, 4, 7)]:
        result, frames = benchmarking.run_episode(env, Policy(), 1)
        assert result.n_steps == 25
        assert frames is None
    else:
        with pytest.raises(engram.InvalidArgumentError, match="forward returned shape"):
            benchmarking.run_episode(env, Policy(), 1)
    env.close()


@pytest.mark.parametrize(
    "answer",
    [
        np.full(7, 1j),
        torch.full((7,), 1j),
        torch.ones(7, dtype=torch.bool),
        np.ma.masked_greater(np.ones(7), 0),
    ],
)
def test_answers_that_are_no_real_numbers(answer):
    class Policy:
        def forward(self, obs):
            return answer

    env = benchmarking.make_benchmark_env(IDS[1], CONFIG)
    with pytest.raises(engram.InvalidArgumentError, match=r"real numbers needed|masked values"):
        benchmarking.run_episode(env, Policy(), 1)
    env.close()


# --- what others wrote ---


@pytest.mark.parametrize(
    "id", ["evilmod:RememberColor3-VLA-v0", "../../x-v0", "/tmp/x-v0", "", "x"]
)
def test_tables_name_no_modules_and_no_paths(tmp_path, monkeypatch, id):
    (tmp_path / "evilmod.py").write_text(f"open({str(tmp_path / 'ran')!r}, 'w')")
    monkeypatch.syspath_prepend(tmp_path)
    table = tmp_path / "tasks.csv"
    table.write_text(
        "id;Name;Max Length;Memory Type;Horizon Split;Data Source;language_instruction\n"
        f"1;{id};25;Object;Short;PPO;Touch it.\n"
    )
    with pytest.raises(engram.InvalidArgumentError, match=r"env_id: .* given; letters, digits"):
        benchmarking.load_benchmark_tasks(table)
    task = benchmarking.BenchmarkTask(id, "short", "Object", 25, "", "")
    with pytest.raises(engram.InvalidArgumentError, match="env_id"):
        benchmarking.evaluate_benchmark([task], Looking(25), CONFIG, output_dir=tmp_path / "out")
    with pytest.raises(engram.InvalidArgumentError, match="env_id"):
        benchmarking.make_benchmark_env(id, CONFIG)
    with pytest.raises(engram.InvalidArgumentError, match="env_id"):
        benchmarking.write_benchmark_results(tmp_path / "out", [{"env_id": id}], {})
    assert not (tmp_path / "ran").exists()
    assert not (tmp_path / "out").exists() or not list((tmp_path / "out").iterdir())


def test_results_stay_in_their_folder(tmp_path, monkeypatch):
    outside, out = tmp_path / "outside", tmp_path / "out"
    outside.mkdir()
    out.mkdir()
    (outside / "thesis.txt").write_text("the only copy")
    for name in (f"{IDS[0]}.json", "summary.json"):
        (out / name).symlink_to(outside / "thesis.txt")
    result = {"env_id": IDS[0]}
    benchmarking.write_benchmark_results(out, [result], {"sr_split": 1})
    assert (outside / "thesis.txt").read_text() == "the only copy"
    assert json.loads((out / f"{IDS[0]}.json").read_text()) == result
    # What cannot be written leaves what was there.
    monkeypatch.setattr(os, "fsync", lambda _: (_ for _ in ()).throw(OSError(28, "No space left")))
    with pytest.raises(OSError, match="No space left"):
        benchmarking.write_benchmark_results(out, [{"env_id": IDS[0], "sr": 1}], {})
    assert json.loads((out / f"{IDS[0]}.json").read_text()) == result
    assert sorted(path.name for path in out.iterdir()) == [f"{IDS[0]}.json", "summary.json"]


def test_videos_are_not_written_through_links(tmp_path):
    pytest.importorskip("av")
    outside, out = tmp_path / "outside", tmp_path / "out"
    outside.mkdir()
    out.mkdir()
    (out / "videos").symlink_to(outside)
    config = benchmarking.BenchmarkConfig(n_episodes=1, save_videos=True)
    tasks = benchmarking.select_benchmark_tasks(env_ids=IDS[1:2])
    with pytest.raises(OSError, match="is a link"):
        benchmarking.evaluate_benchmark(tasks, Looking(25), config, output_dir=out)
    assert not list(outside.iterdir())


def test_two_runs_do_not_share_a_folder(tmp_path):
    tasks = benchmarking.select_benchmark_tasks(env_ids=IDS[1:2])
    config = benchmarking.BenchmarkConfig(n_episodes=1)
    refused = []

    def during(_, __):
        with pytest.raises(OSError, match="another process writes to"):
            benchmarking.evaluate_benchmark(tasks, Looking(25), config, output_dir=tmp_path)
        refused.append(True)

    benchmarking.evaluate_benchmark(
        tasks, Looking(25), config, output_dir=tmp_path, task_start_callback=during
    )
    assert refused == [True]
    folders = [benchmarking.make_run_dir(tmp_path / "runs") for _ in range(2)]
    assert folders[0] != folders[1]


def test_videos(tmp_path):
    pytest.importorskip("av")
    config = benchmarking.BenchmarkConfig(n_episodes=1, save_videos=True)
    tasks = benchmarking.select_benchmark_tasks(env_ids=IDS[1:2])
    benchmarking.evaluate_benchmark(tasks, Looking(25), config, output_dir=tmp_path)
    assert (tmp_path / "videos" / IDS[1] / "episode_0000.mp4").stat().st_size > 1000
    env = benchmarking.make_benchmark_env(IDS[1], config)
    _, frames = benchmarking.run_episode(env, Looking(25), 1, collect_video=True)
    assert len(frames) == 26
    assert frames[0].shape == (512, 768, 3)
    env.close()


def test_a_table_in_the_terminal():
    pytest.importorskip("rich")
    tasks = benchmarking.select_benchmark_tasks(env_ids=IDS[1:2])
    with benchmarking.RichBenchmarkUI(tasks, 1) as ui:
        benchmarking.evaluate_benchmark(
            tasks, Looking(5), benchmarking.BenchmarkConfig(n_episodes=1),
            task_start_callback=ui.on_task_start, episode_callback=ui.on_episode_done,
            task_done_callback=ui.on_task_done,
        )  # fmt: skip
    assert len(ui._done) == 1
