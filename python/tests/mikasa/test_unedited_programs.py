"""Released programs, not a letter changed: `python -m engram.mikasa PROGRAM`."""

from __future__ import annotations

import ast
import hashlib
import importlib.metadata
import json
import re

import pytest

pytest.importorskip("torch")

import gymnasium as gym
import numpy as np
import torch
from handmade_agent import write_checkpoint
from policies import Reaching, as_engram
from released import check_collected, run, unpacked

import engram
import engram.mikasa as mikasa
from engram.mikasa._original_names import PACKAGES

VLA = "mikasa_robo_suite/vla"
COLLECTORS = f"{VLA}/dataset_collectors"
RL_COLLECTORS = "mikasa_robo_suite/rl/dataset_collectors"
IDS = ["ShellGameTouch-VLA-v0", "RememberColor3-VLA-v0", "TakeItBack-VLA-v0"]
RL_ID = "RememberColor3-v0"
RUNNER = ("-m", "engram.mikasa")

# --- the original's own ---

BENCHMARK = """
import sys

import benchmarking  # the released file
from policies import Reaching

import mikasa_robo_suite.vla.benchmarking as under_its_name

table, out, *ids = sys.argv[1:]
tasks = benchmarking.select_benchmark_tasks(env_ids=ids, csv_path=table)
for module, name in ((benchmarking, "file"), (under_its_name, "name")):
    config = module.BenchmarkConfig(n_episodes=2)
    module.evaluate_benchmark(tasks, Reaching(), config, output_dir=f"{out}/{name}")
"""


def test_the_released_benchmark(wheel, tmp_path):
    unpacked(wheel, f"{VLA}/benchmarking.py", tmp_path)
    program = tmp_path / "program.py"
    program.write_text(BENCHMARK)
    table = tmp_path / "tasks.csv"
    table.write_text(run("-m", "engram", "list", "--csv", folder=tmp_path).stdout)
    run(*RUNNER, program, table, tmp_path, *IDS, folder=tmp_path)
    own = engram.evaluate(as_engram(Reaching()), IDS, episodes=2, rules="original", name="own")
    for folder in ("file", "name"):
        for theirs in own["tasks"]:
            written = json.loads((tmp_path / folder / f"{theirs['env_id']}.json").read_text())
            common = set(written) & set(theirs) - {"benchmark_commit", "model"}
            assert len(common) == len(written) - 2
            assert {key: written[key] for key in common} == {key: theirs[key] for key in common}
        summary = json.loads((tmp_path / folder / "summary.json").read_text())
        assert {key: own["summary"][key] for key in summary} == summary
    lengths = {result["env_id"]: result["episode_lengths"] for result in own["tasks"]}
    assert len({tuple(value) for value in lengths.values()}) == len(IDS)


def test_the_released_collector_started_by_its_manager(wheel, tmp_path):
    pytest.importorskip("tyro")
    pytest.importorskip("tqdm")
    write_checkpoint(tmp_path)
    unpacked(wheel, f"{COLLECTORS}/get_mikasa_robo_datasets.py", tmp_path)
    manager = unpacked(wheel, f"{COLLECTORS}/parallel_dataset_collection_manager.py", tmp_path)
    done = run(
        *RUNNER, manager, "--env-ids", "RememberColor3-VLA-v0", "--num-train-data", 10,
        "--path-to-save-data", tmp_path / "data", "--ckpt-dir", tmp_path, "--check-interval", 0.5,
        folder=tmp_path,
    )  # fmt: skip
    assert "Completed: 1" in done.stdout
    check_collected(tmp_path / "data")


# Two updates and one evaluation.
TRAINING = ("--num-envs", 4, "--num-eval-envs", 2, "--num-steps", 10, "--num-eval-steps", 60,
            "--total-timesteps", 80, "--num-minibatches", 2, "--no-cuda")  # fmt: skip


@pytest.mark.parametrize(
    ("script", "flags", "inputs"),
    [
        # test_original_scripts.py trains with the state, too.
        pytest.param("ppo_memtasks.py", ["--include-state", "--no-capture-video"],
                     {"actor_mean.0": 35}, marks=pytest.mark.long),
        ("ppo_memtasks.py", ["--include-rgb", "--include-joints"],
         {"feature_net.extractors.proprio.0": 25}),
        ("ppo_memtasks_lstm.py", ["--include-rgb", "--no-capture-video"], {"lstm": 256}),
    ],
    ids=["state", "rgb", "lstm"],
)  # fmt: skip
def test_the_released_trainers(wheel, tmp_path, script, flags, inputs):
    for module in ("tyro", "tqdm", "colorama", "tensorboard", "av"):
        pytest.importorskip(module)
    trainer = unpacked(wheel, f"baselines/ppo/{script}", tmp_path)
    done = run(*RUNNER, trainer, "--env-id", RL_ID, *flags, *TRAINING, folder=tmp_path,
               OMP_NUM_THREADS="1")  # fmt: skip
    assert "success_once" in done.stdout
    (checkpoint,) = (tmp_path / "checkpoints").glob("**/final_ckpt.pt")
    weights = torch.load(checkpoint)
    for layer, width in inputs.items():
        found = {k: v.shape[1] for k, v in weights.items() if k.startswith(f"{layer}.weight")}
        assert width in found.values(), list(weights)
    films = list(tmp_path.glob("checkpoints/**/*.mp4"))
    assert bool(films) == ("--no-capture-video" not in flags)


@pytest.mark.long
def test_the_released_collector_of_the_rl_half(wheel, tmp_path):
    """250 episodes of a policy that has learned nothing: failures are kept."""
    for module in ("tyro", "tqdm"):
        pytest.importorskip(module)
    env = gym.make(RL_ID, num_envs=1, obs_mode="state")
    env = mikasa.StateOnlyTensorToDictWrapper(env)
    env = mikasa.FlattenRGBDObservationWrapper(env, rgb=False, depth=False)
    agent = mikasa.AgentStateOnly(mikasa.ManiSkillVectorEnv(env))
    env.close()
    folder = tmp_path / "oracle_checkpoints" / "ppo_memtasks" / "state" / "normalized_dense"
    (folder / RL_ID).mkdir(parents=True)
    torch.save(agent.state_dict(), folder / RL_ID / "final_success_ckpt.pt")
    collector = unpacked(wheel, f"{RL_COLLECTORS}/get_mikasa_robo_datasets.py", tmp_path)
    run(*RUNNER, collector, "--env-id", RL_ID, "--path-to-save-data", tmp_path, "--ckpt-dir",
        tmp_path, "--num-train-data", 250, folder=tmp_path)  # fmt: skip
    files = sorted((tmp_path / "MIKASA-Robo" / "unbatched" / RL_ID).iterdir())
    assert len(files) == 250
    episode = np.load(files[-1])
    assert {key: episode[key].shape for key in episode} == {
        "rgb": (60, 128, 128, 6), "joints": (60, 25), "action": (60, 8), "reward": (60,),
        "success": (60,), "done": (60,),
    }  # fmt: skip
    assert episode["done"].tolist() == [0] * 59 + [1]


IMPORTS = """
import json, sys

failed = {}
for line in json.load(open(sys.argv[1])):
    try:
        exec(line, {})
    except Exception as error:
        failed[line] = f"{type(error).__name__}: {error}"
print(json.dumps(failed))
"""


def test_every_import_of_the_released_scripts(wheel, tmp_path):
    lines = set()
    names = [f"{VLA}/benchmarking.py", f"{VLA}/utils/apply_wrappers.py"]
    beginnings = (f"{COLLECTORS}/get", f"{RL_COLLECTORS}/get", "baselines")
    names += [one for one in wheel.namelist() if one.startswith(beginnings)]
    for name in names:
        for node in ast.walk(ast.parse(wheel.read(name))):
            line = ast.unparse(node) if isinstance(node, (ast.Import, ast.ImportFrom)) else ""
            if any(re.match(rf"(from|import) {package}\b", line) for package in PACKAGES):
                lines.add(line)
    assert len(lines) > 20
    (tmp_path / "lines.json").write_text(json.dumps(sorted(lines)))
    (tmp_path / "program.py").write_text(IMPORTS)
    done = run(*RUNNER, "program.py", "lines.json", folder=tmp_path)
    assert json.loads(done.stdout) == {}


# --- vla-evaluation-harness ---

HARNESS = """
import hashlib, json, sys

import numpy as np
import vla_eval.api
from vla_eval.model_servers.predict import PredictModelServer


class Server(PredictModelServer):
    def __init__(self):
        super().__init__()
        self.seen = []

    def predict(self, obs, ctx):
        images = {name: np.asarray(picture) for name, picture in obs["images"].items()}
        digest = hashlib.sha256(b"".join(images[name].tobytes() for name in sorted(images)))
        self.seen.append([sorted(images), digest.hexdigest(), obs["task_description"]])
        return {"actions": np.cos(np.arange(8) + len(self.seen)).astype(np.float32)}


server = Server()
(result,) = vla_eval.api.evaluate(
    server,
    {"benchmarks": [{
        "benchmark": "vla_eval.benchmarks.mikasa.benchmark:MIKASABenchmark",
        "episodes_per_task": 2,
        "params": {"tasks": [sys.argv[1]]},
    }]},
    output_dir=sys.argv[2],
    docker=False,
)
with open("seen.json", "w") as file:
    json.dump({"result": result["tasks"], "seen": server.seen}, file)
"""


def test_the_benchmark_class_of_vla_eval(tmp_path):
    pytest.importorskip("vla_eval")
    print("vla-eval", importlib.metadata.version("vla-eval"))
    id = "RememberColor3-VLA-v0"
    program = tmp_path / "program.py"
    program.write_text(HARNESS)
    run(*RUNNER, program, id, tmp_path / "out", folder=tmp_path)
    written = json.loads((tmp_path / "seen.json").read_text())
    (task,) = written["result"]
    assert (task["task"], task["num_episodes"], task["avg_steps"]) == (id, 2, 25)
    assert "num_errors" not in task
    # Equal actions in a loop of our own, which resets without a seed as the class does.
    env = gym.make(id, num_envs=1, obs_mode="rgb", render_mode="cameras")
    env = mikasa.StateOnlyTensorToDictWrapper(env)
    step = 0
    for episode in task["episodes"]:
        observation, _ = env.reset()
        for _ in range(25):
            images = sorted(observation["sensor_data"].items())
            digest = hashlib.sha256(b"".join(one["rgb"].numpy().tobytes() for _, one in images))
            cameras, seen, _ = written["seen"][step]
            assert (cameras, seen) == (["base_camera", "hand_camera"], digest.hexdigest())
            step += 1
            action = np.cos(np.arange(8) + step).astype(np.float32)
            observation, _, _, _, info = env.step(torch.from_numpy(action)[None])
        assert episode["metrics"]["success"] == bool(info["success"])
    assert step == len(written["seen"])
    assert len({digest for _, digest, _ in written["seen"]}) > 25
    env.close()


# --- programs of policies in joint space ---

JOINTS = """
import json, sys

import numpy as np
import torch
from mikasa_robo_suite.vla import benchmarking
from mikasa_robo_suite.vla.benchmarking import (
    BenchmarkConfig, _write_video, make_benchmark_env, run_episode, select_benchmark_tasks,
)
from mikasa_robo_suite.vla.utils.apply_wrappers import apply_mikasa_vla_wrappers
from mikasa_robo_suite.vla.utils.wrappers import ConvertJointsToQposGripperWidthWrapper
import gymnasium as gym

config = BenchmarkConfig(
    start_seed=4242424242, n_episodes=1, sim_backend="auto", save_videos=False,
    control_mode="pd_joint_pos",
)
(task,) = select_benchmark_tasks(env_ids=["RememberColor3-VLA-v0"])


class Holding:
    def __init__(self):
        self.seen = []

    def forward(self, obs):
        proprio = np.asarray(obs["proprio"])
        self.seen.append(proprio[0].tolist())
        return np.append(proprio[0, :7], 1.0).astype(np.float32)


usual = make_benchmark_env(task.env_id, config)
cameras = list(usual.unwrapped.scene.sensors.keys())
policy = Holding()
result, frames = run_episode(usual, policy, config.start_seed, collect_video=False)
usual.close()
env = gym.make(task.env_id, num_envs=1, obs_mode="rgb", render_mode="rgb_array",
               control_mode=config.control_mode)
env = apply_mikasa_vla_wrappers(env, include_overlays=True, joint_proprio=True)
holding = Holding()
joints, frames = run_episode(env, holding, config.start_seed, collect_video=True)
_write_video("film.mp4", [frame for frame in frames], fps=30.0)
qpos = env.unwrapped.agent.robot.get_qpos()[0].tolist()
is_last = isinstance(env, ConvertJointsToQposGripperWidthWrapper)
env.close()
print(json.dumps({
    "cameras": cameras, "widths": [len(policy.seen[0]), len(holding.seen[0])], "qpos": qpos,
    "steps": [result.n_steps, joints.n_steps], "seeds": [result.seed, joints.seed],
    "frames": len(frames), "first": holding.seen[0], "last": holding.seen[-1], "is_last": is_last,
}))
"""


def test_calls_of_programs_in_joint_space(tmp_path):
    av = pytest.importorskip("av")
    (tmp_path / "program.py").write_text(JOINTS)
    found = json.loads(run(*RUNNER, "program.py", folder=tmp_path).stdout)
    assert found["cameras"] == ["base_camera", "hand_camera"]
    assert found["widths"] == [7, 8]
    assert found["steps"] == [25, 25]
    assert found["seeds"] == [4242424242, 4242424242]
    assert found["is_last"]
    # The arm holds its pose, in the cue too, where zeros would have moved it.
    assert np.allclose(found["first"][:7], found["qpos"][:7], atol=5e-3)
    assert np.allclose(found["first"][:7], found["last"][:7], atol=5e-3)
    assert found["last"][7] == pytest.approx(sum(found["qpos"][7:]), abs=1e-3)
    with av.open(str(tmp_path / "film.mp4")) as film:
        assert float(film.streams.video[0].average_rate) == 30
        assert sum(1 for _ in film.decode(video=0)) == found["frames"] == 26
