"""Speed of engram beside MuJoCo's newest batch interfaces, on the same scenes and motions.

    python peers.py [--rounds R] [--num-envs N ...] [--seconds S]

Each row is a task under a policy: all environments play one episode. MuJoCo steps the scene that
`engram info ID --mjcf` writes of it, five substeps per control step, with the joint angles that
engram's arm went through as targets of its drives. Contestants take turns, on one thread, from the
start of the episode to its end, resets left out; a cell is the median of its rounds. MuJoCo comes
from an environment of its own, which is made in build/python-env-peers.
"""

from __future__ import annotations

import argparse
import json
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time
import venv
from typing import Any

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
PEERS = ROOT / "build/python-env-peers"
SUBSTEPS = 5
ROWS = (  # what happens, id, policy
    ("free", "RememberColor9-VLA-v0", "random"),
    ("touches a cup", "ShellGameTouch-VLA-v0", "oracle"),
    ("turns a peg", "RotateStrictPos-VLA-v0", "oracle"),
    ("carries a cube", "GatherAndRecall1-VLA-v0", "oracle"),
    ("pushes a cube", "TimedTransferEasy-VLA-v0", "oracle"),
)
SEED = 0
NEVER_ENDS: dict[str, Any] = {"terminate_on_success": False, "terminate_on_failure": False}
FINGER_TARGETS = (-0.01, 0.04)  # m, of the actions -1 and 1
PEER_NAMES = ("batch", "batch, sleep", "rollout")


class Mujoco:
    """MuJoCo's side, in its own process: answers a line with a contestant's name by its rate."""

    def __init__(self, scene: str, targets: np.ndarray, num_envs: int) -> None:
        import mujoco
        import mujoco.batch
        import mujoco.rollout

        text = pathlib.Path(scene).read_text()
        self.mujoco = mujoco
        self.num_envs = num_envs
        self.targets = targets  # (T, 9)
        self.model = mujoco.MjModel.from_xml_string(text)
        self.batch = mujoco.batch.Batch(self.model, num_envs, 1)
        sleeping = mujoco.MjModel.from_xml_string(text)
        sleeping.opt.enableflags |= mujoco.mjtEnableBit.mjENBL_SLEEP
        self.sleeping = mujoco.batch.Batch(sleeping, num_envs, 1, persistent=True)
        self.data = mujoco.MjData(self.model)
        mujoco.mj_resetDataKeyframe(self.model, self.data, 0)
        full = mujoco.mjtState.mjSTATE_FULLPHYSICS
        size = mujoco.mj_stateSize(self.model, full)
        self.state = np.zeros(size)
        mujoco.mj_getState(self.model, self.data, self.state, full)
        controls = np.zeros((len(targets) * SUBSTEPS, self.model.nu))
        controls[:, : targets.shape[1]] = np.repeat(targets, SUBSTEPS, axis=0)
        self.controls = np.tile(controls, (num_envs, 1, 1))
        self.runs = {
            "batch": lambda: self._step(self.batch),
            "batch, sleep": lambda: self._step(self.sleeping),
            "rollout": self._roll,
        }

    def rate(self, name: str, seconds: float) -> float:
        """Environment steps per second."""
        runs, begin = 0, time.perf_counter()
        while (spent := time.perf_counter() - begin) < seconds:
            self.runs[name]()
            runs += 1
        return runs * len(self.targets) * self.num_envs / spent

    def _step(self, batch: Any) -> None:
        batch.reset(keyframe=0)
        control = batch.bind("ctrl")
        for target in self.targets:
            control[:, : len(target)] = target
            batch.step(nstep=SUBSTEPS)

    def _roll(self) -> None:
        states = np.tile(self.state, (self.num_envs, 1))
        self.mujoco.rollout.rollout(self.model, [self.data], states, self.controls)


def serve(scene: str, targets: str, num_envs: str, seconds: str) -> None:
    """Main function of MuJoCo's side."""
    side = Mujoco(scene, np.load(targets), int(num_envs))
    print(json.dumps(side.mujoco.__version__), flush=True)
    for line in sys.stdin:
        print(json.dumps(side.rate(line.strip(), float(seconds))), flush=True)


def record(task: str, policy: str) -> tuple[np.ndarray, np.ndarray]:
    """Actions of an episode (T, 7), and the joints that they lead to as MuJoCo's targets (T, 9)."""
    import engram

    actions, targets = [], []
    env = engram.VectorEnv(task, joint_proprio=True, **NEVER_ENDS)
    env.reset(seed=SEED)
    for _ in range(engram.describe(task)["horizon"] - 1):
        actions.append(env.act(policy)[0].copy())
        info = env.step(actions[-1][None])[-1]
        finger = np.interp(actions[-1][-1], (-1, 1), FINGER_TARGETS)
        targets.append([*info["proprio"][0, :7], finger, finger])
    return np.array(actions), np.array(targets)


class Engram:
    """engram's side: that episode in all environments."""

    def __init__(self, task: str, actions: np.ndarray, num_envs: int, obs_mode: str) -> None:
        import engram

        self.env = engram.VectorEnv(
            task, num_envs, threads=1, copy=False, obs_mode=obs_mode, **NEVER_ENDS
        )
        self.actions = [np.tile(action, (num_envs, 1)) for action in actions]

    def rate(self, seconds: float) -> float:
        steps, spent = 0, 0.0
        while spent < seconds:
            self.env.reset(seed=[SEED] * self.env.num_envs)
            begin = time.perf_counter()
            for action in self.actions:
                self.env.step(action)
            spent += time.perf_counter() - begin
            steps += len(self.actions) * self.env.num_envs
        return steps / spent


def peers_python() -> pathlib.Path:
    """Python of the environment that has MuJoCo."""
    python = PEERS / "bin/python"
    if not python.exists():
        venv.create(PEERS, with_pip=True)
        subprocess.run([python, "-m", "pip", "install", "-q", "mujoco", "numpy"], check=True)
    return python


def measure(
    row: tuple[str, str, str], num_envs: int, args: argparse.Namespace
) -> tuple[str, dict[str, float]]:
    """MuJoCo's version, and the median rate of each contestant."""
    _, task, policy = row
    actions, controls = record(task, policy)
    state = Engram(task, actions, num_envs, "state")
    rgb = Engram(task, actions, num_envs, "rgb")
    with tempfile.TemporaryDirectory() as folder:
        scene, targets = f"{folder}/scene.xml", f"{folder}/targets.npy"
        np.save(targets, controls)
        command = [
            sys.executable,
            "-m",
            "engram",
            "info",
            task,
            "--mjcf",
            scene,
            "--seed",
            str(SEED),
        ]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        command = [peers_python(), __file__, "--serve", scene, targets, num_envs, args.seconds]
        with subprocess.Popen(
            [str(word) for word in command],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        ) as peer:
            assert peer.stdin is not None
            assert peer.stdout is not None
            version = json.loads(peer.stdout.readline())
            rates: dict[str, list[float]] = {}
            for _ in range(args.rounds):
                rates.setdefault("state", []).append(state.rate(args.seconds))
                rates.setdefault("rgb", []).append(rgb.rate(args.seconds))
                for name in PEER_NAMES:
                    print(name, file=peer.stdin, flush=True)
                    rates.setdefault(name, []).append(json.loads(peer.stdout.readline()))
            peer.stdin.close()
    return version, {name: statistics.median(of) for name, of in rates.items()}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--num-envs", type=int, nargs="+", default=[256, 1])
    parser.add_argument("--seconds", type=float, default=1.0, help="of a contestant in a round")
    args = parser.parse_args()
    lines = []
    for num_envs in args.num_envs:
        for row in ROWS:
            version, rates = measure(row, num_envs, args)
            best = max(rates[name] for name in PEER_NAMES)
            cells = [f"{rates[name]:,.0f}" for name in ("state", "rgb", *PEER_NAMES)]
            lines.append([row[0], row[1], str(num_envs), *cells, f"{rates['state'] / best:.1f}"])
            print(" ".join(lines[-1]), file=sys.stderr)
    titles = ["motion", "task", "environments", "engram", "engram, rgb"]
    titles += [f"MuJoCo {version} {name}" for name in PEER_NAMES] + ["ratio"]
    for line in (titles, ["---"] * 3 + ["---:"] * (len(titles) - 3), *lines):
        print(f"| {' | '.join(line)} |")


if __name__ == "__main__":
    if sys.argv[1:2] == ["--serve"]:
        serve(*sys.argv[2:])
    else:
        main()
