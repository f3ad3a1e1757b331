"""PPO of Stable-Baselines3 with its default numbers, through the preset "train".

    python sb3_ppo.py --id ShellGameTouch-VLA-v0 --total-timesteps 200000
    python sb3_ppo.py --id RememberColor3-VLA-v0 --recurrent --obs-mode objects

64 environments of 32 steps instead of one of 2048; everything else is the library's default. With
`--recurrent` the learner is RecurrentPPO of sb3-contrib. docs/learning.md has results.
"""

from __future__ import annotations

import argparse
import csv
import time
from typing import Any

import torch
from sb3_contrib import RecurrentPPO
from stable_baselines3 import PPO

import engram
from engram.integrations.sb3 import Sb3VecEnv
from engram.wrappers import WrappedPolicy

EVAL_ENVS = 50


def parse_arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description="Learns engram tasks with the PPO of Stable-Baselines3.",
        formatter_class=argparse.ArgumentDefaultsHelpFormatter,
    )
    add = parser.add_argument
    add("--id", nargs="+", default=["ShellGameTouch-VLA-v0"], help="tasks, one run after the other")
    add("--obs-mode", default="state", choices=["state", "objects"], help="observations")
    add("--recurrent", action="store_true", help="RecurrentPPO of sb3-contrib")
    add("--seed", type=int, default=1, help="of episodes, networks and exploration")
    add("--total-timesteps", type=int, default=200_000, help="environment steps to learn from")
    add("--num-envs", type=int, default=64, help="environments stepped together")
    add("--num-steps", type=int, default=32, help="steps of each environment per iteration")
    add("--eval-episodes", type=int, default=200, help="of the evaluation at the end")
    add("--option", nargs="*", default=[], help="numbers of the learner, such as gamma=0.95")
    add("--file", help="CSV file that gets a row for each run")
    return parser.parse_args()


def train(args: argparse.Namespace, env: Sb3VecEnv) -> Any:
    learner, policy = (RecurrentPPO, "MlpLstmPolicy") if args.recurrent else (PPO, "MlpPolicy")
    words = (word.split("=") for word in args.option)
    options: dict[str, Any] = {name: type_of(value)(value) for name, value in words}
    model = learner(policy, env, n_steps=args.num_steps, seed=args.seed, device="cpu", **options)
    return model.learn(args.total_timesteps)


def type_of(value: str) -> type:
    return int if value.isdigit() else float


def evaluate(args: argparse.Namespace, model: Any) -> tuple[float, float | None]:
    """Success and right first answers of the mean action, in engram's own evaluation."""
    env = engram.make_vec(args.id, EVAL_ENVS, obs_mode=args.obs_mode, preset="train", threads=1)
    state: Any = None

    def act(rows: Any, begins: Any) -> Any:
        nonlocal state
        actions, state = model.predict(rows, state, begins, deterministic=True)
        return actions

    result = engram.evaluate(
        WrappedPolicy(env, act),
        args.id,
        obs=args.obs_mode,
        episodes=args.eval_episodes,
        num_envs=EVAL_ENVS,
        threads=1,
    )
    task = result["tasks"][0]
    return task["sr"], task["first_answer_correct"]


def run(args: argparse.Namespace) -> dict[str, Any]:
    """Trains and evaluates in one task; returns a row of the results."""
    begin = time.process_time()
    env = Sb3VecEnv(
        args.id,
        args.num_envs,
        obs_mode=args.obs_mode,
        preset="train",
        threads=1,
        seed=(args.seed, 0),
    )
    model = train(args, env)
    success, first = evaluate(args, model)
    learner = "RecurrentPPO of sb3-contrib" if args.recurrent else "PPO of Stable-Baselines3"
    return {
        "learner": " ".join([learner, *args.option]),
        "id": args.id,
        "preset": "train",
        "without": "",
        "seed": args.seed,
        "env_steps": model.num_timesteps,
        "success_once": f"{success:.3f}",
        "episodes": args.eval_episodes,
        "cpu_s": f"{time.process_time() - begin:.1f}",
        "first_answer": "" if first is None else f"{first:.3f}",
    }


def main() -> None:
    args = parse_arguments()
    torch.set_num_threads(1)  # layers are small
    for task in args.id:
        row = run(argparse.Namespace(**{**vars(args), "id": task}))
        print("  ".join(f"{name} {value}" for name, value in row.items()), flush=True)
        if args.file:
            with open(args.file, "a", newline="", encoding="utf-8") as out:
                writer = csv.DictWriter(out, row, lineterminator="\n")
                if out.tell() == 0:
                    writer.writeheader()
                writer.writerow(row)


if __name__ == "__main__":
    main()
