"""The original's own scripts, from its wheel, with nothing changed but where they import from."""

from __future__ import annotations

import importlib.util
import json
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("torch")

import torch
from handmade_agent import write_checkpoint
from policies import Looking, as_engram
from released import check_collected

import engram

EXAMPLE = Path(__file__).parents[2] / "examples" / "mikasa_ppo.py"
COLLECTOR = "mikasa_robo_suite/vla/dataset_collectors/get_mikasa_robo_datasets.py"
COLLECTED = "RememberColor3-VLA-v0"
# The replacements of docs/mikasa.md.
SED = [
    r"s/mikasa_robo_suite\.vla(\.utils)?\b/engram.mikasa/",
    r"s/mikasa_robo_suite(\.rl)?(\.utils)?\.(memory_envs|wrappers)\b/engram.mikasa.rl.\3/",
    r"s/^from (mani_skill[a-z_.]*|baselines\.ppo\.ppo_memtasks) import/from engram.mikasa import/",
]
# In the order of engram's list, which its evaluation follows.
IDS = ["ShellGameTouch-VLA-v0", "RememberColor3-VLA-v0", "RotateLenientPos-VLA-v0"]


def changed(wheel, path, folder):
    """Writes the script with other imports; returns where it lies."""
    original = wheel.read(path).decode()
    script = folder / path.rsplit("/", 1)[1]
    arguments = [part for rule in SED for part in ("-e", rule)]
    script.write_text(
        subprocess.run(
            ["sed", "-E", *arguments], input=original, capture_output=True, text=True, check=True
        ).stdout
    )
    pairs = zip(original.splitlines(), script.read_text().splitlines())
    different = [before for before, after in pairs if before != after]
    code = [line for line in different if not line.startswith("#")]
    assert code
    assert all(line.strip().startswith(("import ", "from ")) for line in code)
    return script


def loaded(script):
    spec = importlib.util.spec_from_file_location(script.stem, script)
    module = importlib.util.module_from_spec(spec)
    sys.modules[script.stem] = module
    spec.loader.exec_module(module)
    return module


def test_benchmarking(wheel, tmp_path):
    original = loaded(changed(wheel, "mikasa_robo_suite/vla/benchmarking.py", tmp_path))
    tasks = {task["id"]: task for task in engram.list()}
    tasks = [
        original.BenchmarkTask(
            id, tasks[id]["split"], tasks[id]["memory_type"], tasks[id]["horizon"], "", ""
        )
        for id in IDS
    ]
    config = original.BenchmarkConfig(n_episodes=2)
    results, _ = original.evaluate_benchmark(
        tasks, Looking(3), config, output_dir=tmp_path / "out",
        model={"name": "looking", "config": {}},
    )  # fmt: skip
    own = engram.evaluate(
        as_engram(Looking(3)), IDS, episodes=2, rules="original", name="looking",
        output=tmp_path / "own",
    )  # fmt: skip
    for result, theirs in zip(results, own["tasks"]):
        written = json.loads((tmp_path / "out" / f"{result['env_id']}.json").read_text())
        common = set(written) & set(theirs) - {"benchmark_commit", "action_chunk_size"}
        assert len(common) == len(written) - 2
        assert {key: written[key] for key in common} == {key: theirs[key] for key in common}
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert {key: own["summary"][key] for key in summary} == summary


def collect(script, folder):
    """Runs the collector with the checkpoint in the folder; its files are as engram reads them."""
    done = subprocess.run(
        [sys.executable, str(script), "--env-id", COLLECTED, "--path-to-save-data",
         str(folder / "data"), "--ckpt-dir", str(folder), "--num-train-data", "10"],
        capture_output=True, text=True, timeout=1200,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    check_collected(folder / "data")


def test_data_collection(wheel, tmp_path):
    pytest.importorskip("tyro")
    pytest.importorskip("tqdm")
    write_checkpoint(tmp_path)
    collect(changed(wheel, COLLECTOR, tmp_path), tmp_path)


def test_training_of_the_rl_half(wheel, tmp_path):
    for module in ("tyro", "tqdm", "colorama", "tensorboard"):
        pytest.importorskip(module)
    script = changed(wheel, "baselines/ppo/ppo_memtasks.py", tmp_path)
    done = subprocess.run(
        [sys.executable, str(script), "--env-id", "ShellGameTouch-v0", "--include-state",
         "--num-envs", "4", "--num-eval-envs", "2", "--num-steps", "10", "--num-eval-steps", "90",
         "--total-timesteps", "80", "--num-minibatches", "2", "--no-cuda", "--no-capture-video"],
        capture_output=True, text=True, timeout=1200, cwd=tmp_path,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "success_once" in done.stdout
    (checkpoint,) = tmp_path.glob("checkpoints/**/final_ckpt.pt")
    assert torch.load(checkpoint)["actor_mean.0.weight"].shape == (256, 40)


@pytest.mark.long
def test_data_collection_with_a_learnt_checkpoint(wheel, tmp_path):
    pytest.importorskip("tyro")
    pytest.importorskip("tqdm")
    # PPO alone: one and a half minutes of processor time until four of five episodes succeed. The
    # script keeps batches of ten in which all do.
    learnt = subprocess.run(
        [sys.executable, str(EXAMPLE), "--id", COLLECTED, "--out", str(tmp_path)],
        capture_output=True, text=True, timeout=1800,
    )  # fmt: skip
    assert learnt.returncode == 0, learnt.stderr
    print(learnt.stdout)
    collect(changed(wheel, COLLECTOR, tmp_path), tmp_path)
