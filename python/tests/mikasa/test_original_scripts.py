"""The original's own scripts, from its wheel, with nothing changed but where they import from."""

from __future__ import annotations

import importlib.util
import json
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

pytest.importorskip("torch")

from policies import Looking, as_engram

import engram
import engram.mikasa
from engram.datasets.episodes import DemonstrationFolder

EXAMPLE = Path(__file__).parents[2] / "examples" / "mikasa_ppo.py"
WHEEL = "mikasa-robo-suite==1.0.0"
# The replacements of docs/mikasa.md.
SED = [
    r"s/mikasa_robo_suite\.vla(\.utils)?\b/engram.mikasa/",
    r"s/^from (mani_skill[a-z_.]*|baselines\.ppo\.ppo_memtasks) import/from engram.mikasa import/",
]
# In the order of engram's list, which its evaluation follows.
IDS = ["ShellGameTouch-VLA-v0", "RememberColor3-VLA-v0", "RotateLenientPos-VLA-v0"]


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    folder = tmp_path_factory.mktemp("original")
    command = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", "-d", str(folder)]
    done = subprocess.run([*command, WHEEL], capture_output=True, text=True, timeout=300)
    if done.returncode != 0:
        pytest.skip(f"no network: {done.stderr.strip().splitlines()[-1]}")
    return zipfile.ZipFile(next(folder.glob("*.whl")))


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
    assert all(line.startswith(("import ", "from ")) for line in code)
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


def test_data_collection(wheel, tmp_path):
    pytest.importorskip("tyro")
    pytest.importorskip("tqdm")
    id = "RememberColor3-VLA-v0"
    path = "mikasa_robo_suite/vla/dataset_collectors/get_mikasa_robo_datasets.py"
    script = changed(wheel, path, tmp_path)
    # PPO alone: one and a half minutes of processor time until four of five episodes succeed. The
    # script keeps batches of ten in which all do.
    learnt = subprocess.run(
        [sys.executable, str(EXAMPLE), "--id", id, "--out", str(tmp_path)],
        capture_output=True, text=True, timeout=1800,
    )  # fmt: skip
    assert learnt.returncode == 0, learnt.stderr
    print(learnt.stdout)
    done = subprocess.run(
        [sys.executable, str(script), "--env-id", id, "--path-to-save-data", str(tmp_path / "data"),
         "--ckpt-dir", str(tmp_path), "--num-train-data", "10"],
        capture_output=True, text=True, timeout=1200,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    folder = tmp_path / "data" / "data_npz" / engram.mikasa.env_id_to_dataset_name(id)
    metadata = json.loads((folder / "metadata.json").read_text())
    assert metadata["num_episodes"] >= 10
    episodes = DemonstrationFolder(folder)  # engram's reader
    assert len(episodes) == metadata["num_episodes"]
    for episode in episodes:
        steps = len(episode)
        assert episode.rgb.shape == (steps, 128, 128, 6)
        assert episode.proprio.shape == episode.action.shape == (steps, 7)
        assert episode.success[-1]
        assert episode.language_instruction == engram.describe(id)["instruction"]
