"""Learners of libraries with their default numbers, with and without the preset "train".

    python library_learners.py --id ShellGameTouch-VLA-v0 --total-timesteps 200000
    python library_learners.py --learner skrl-ppo --id RememberColor3-VLA-v0 --preset none
    python library_learners.py --learner sb3-recurrent-ppo --obs-mode objects

All have 64 environments of 32 steps; what a library leaves open is said at its function.
docs/learning.md has results.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Callable
from typing import Any

import numpy as np
import torch
from plain_ppo import EVAL_ENVS, as_row, run_each, score
from sb3_contrib import RecurrentPPO
from stable_baselines3 import PPO, SAC

import engram
from engram.integrations.sb3 import Sb3VecEnv

Act = Callable[[np.ndarray, np.ndarray], np.ndarray]  # of rows, and where an episode begins
Options = dict[str, Any]


def parse_arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description="Learns engram tasks with the learners of libraries.",
        formatter_class=argparse.ArgumentDefaultsHelpFormatter,
    )
    add = parser.add_argument
    add("--learner", default="sb3-ppo", choices=list(LEARNERS), help="which one")
    add("--id", nargs="+", default=["ShellGameTouch-VLA-v0"], help="tasks, one run after the other")
    add("--preset", default="train", choices=["train", "none"], help="of engram.make_vec")
    add("--obs-mode", default="state", choices=["state", "objects"], help="observations")
    add("--seed", type=int, default=1, help="of episodes, networks and exploration")
    add("--total-timesteps", type=int, default=200_000, help="environment steps to learn from")
    add("--num-envs", type=int, default=64, help="environments stepped together")
    add("--num-steps", type=int, default=32, help="steps of each environment per iteration")
    add("--eval-episodes", type=int, default=200, help="of the evaluation at the end")
    add("--option", nargs="*", default=[], help="numbers of the learner, such as gamma=0.95")
    add("--file", help="CSV file that gets a row for each run")
    return parser.parse_args()


def env_options(args: argparse.Namespace) -> Options:
    return {
        "obs_mode": args.obs_mode,
        "preset": None if args.preset == "none" else args.preset,
        "threads": 1,
        "seed": (args.seed, 0),
    }


def with_sb3(learner: type, policy: str, args: argparse.Namespace, options: Options) -> Act:
    """Stable-Baselines3 or sb3-contrib."""
    env = Sb3VecEnv(args.id, args.num_envs, **env_options(args))
    if learner is not SAC:
        options = {"n_steps": args.num_steps, **options}
    model = learner(policy, env, seed=args.seed, device="cpu", **options)
    model.learn(args.total_timesteps)
    state: Any = None

    def act(rows: np.ndarray, begins: np.ndarray) -> np.ndarray:
        nonlocal state
        actions, state = model.predict(rows, state, begins, deterministic=True)
        return actions  # type: ignore[no-any-return]

    return act


def with_skrl(args: argparse.Namespace, options: Options) -> Act:
    """PPO of skrl; layers of 64 and 64 with tanh."""
    from skrl.agents.torch import ppo
    from skrl.envs.wrappers.torch import wrap_env
    from skrl.memories.torch import RandomMemory
    from skrl.trainers.torch import SequentialTrainer
    from skrl.utils.model_instantiators.torch import deterministic_model, gaussian_model

    env = wrap_env(
        engram.make_vec(
            args.id, args.num_envs, autoreset_mode="SAME_STEP", copy=True, **env_options(args)
        ),
        verbose=False,
    )
    spaces = {"observation_space": env.observation_space, "action_space": env.action_space}
    net = [{"name": "net", "input": "OBSERVATIONS", "layers": [64, 64], "activations": "tanh"}]
    models = {
        "policy": gaussian_model(
            **spaces, network=net, output="ACTIONS", clip_actions=True, device="cpu"
        ),
        "value": deterministic_model(**spaces, network=net, output="ONE", device="cpu"),
    }
    settings = ppo.PPO_CFG(rollouts=args.num_steps, **options)
    with tempfile.TemporaryDirectory() as folder:
        settings.experiment.directory = folder
        settings.experiment.write_interval = settings.experiment.checkpoint_interval = 0
        memory = RandomMemory(memory_size=args.num_steps, num_envs=args.num_envs, device="cpu")
        agent = ppo.PPO(models=models, memory=memory, cfg=settings, **spaces, device="cpu")
        steps = args.total_timesteps // args.num_envs
        cfg = {"timesteps": steps, "headless": True, "disable_progressbar": True}
        cfg["close_environment_at_exit"] = False
        SequentialTrainer(env=env, agents=agent, cfg=cfg).train()

    def act(rows: np.ndarray, begins: np.ndarray) -> np.ndarray:
        with torch.no_grad():
            inputs = {"observations": torch.as_tensor(rows)}
            return models["policy"].act(inputs, role="policy")[1]["mean_actions"].numpy()  # type: ignore[no-any-return]

    return act


def with_torchrl(args: argparse.Namespace, options: Options) -> Act:
    """TorchRL's parts with the numbers of its tutorial; layers of 64 and 64 with tanh.

    Actions are normal; the tutorial's TanhNormal (squashed=1) spans their whole space.
    """
    from tensordict.nn import NormalParamExtractor, TensorDictModule
    from torchrl.collectors import Collector
    from torchrl.envs import GymWrapper
    from torchrl.modules import (
        MLP,
        IndependentNormal,
        ProbabilisticActor,
        TanhNormal,
        ValueOperator,
    )
    from torchrl.objectives import ClipPPOLoss
    from torchrl.objectives.value import GAE

    given = {
        "gamma": 0.99,
        "lmbda": 0.95,
        "lr": 3e-4,
        "epochs": 10,
        "minibatch": 256,
        "squashed": 0,
    }
    given |= options
    env = GymWrapper(
        engram.make_vec(args.id, args.num_envs, autoreset_mode="SAME_STEP", **env_options(args))
    )
    layers = {"num_cells": [64, 64], "activation_class": torch.nn.Tanh}
    space = env.action_spec_unbatched.space
    inputs, outputs = env.observation_spec["observation"].shape[-1], space.low.shape[-1]
    bounds = {"low": space.low, "high": space.high} if given["squashed"] else {}
    distribution = TanhNormal if given["squashed"] else IndependentNormal
    network = torch.nn.Sequential(MLP(inputs, 2 * outputs, **layers), NormalParamExtractor())
    policy = ProbabilisticActor(
        TensorDictModule(network, in_keys=["observation"], out_keys=["loc", "scale"]),
        in_keys=["loc", "scale"],
        distribution_class=distribution,
        distribution_kwargs=bounds,
        return_log_prob=True,
    )
    value = ValueOperator(MLP(inputs, 1, **layers), in_keys=["observation"])
    advantages = GAE(
        gamma=given["gamma"], lmbda=given["lmbda"], value_network=value, average_gae=True
    )
    loss = ClipPPOLoss(policy, value, clip_epsilon=0.2, entropy_coeff=1e-4, critic_coeff=1.0)
    adam = torch.optim.Adam(loss.parameters(), given["lr"])
    frames = args.num_steps * args.num_envs
    total = args.total_timesteps // frames * frames
    collector = Collector(
        env,
        policy,
        frames_per_batch=frames,
        total_frames=total,
        auto_register_policy_transforms=False,
    )
    for data in collector:
        for _ in range(given["epochs"]):
            advantages(data)
            flat = data.reshape(-1)
            for rows in torch.randperm(frames).split(given["minibatch"]):
                parts = loss(flat[rows])
                sum(parts["loss_" + of] for of in ("objective", "critic", "entropy")).backward()
                torch.nn.utils.clip_grad_norm_(loss.parameters(), 1.0)
                adam.step()
                adam.zero_grad()

    def act(rows: np.ndarray, begins: np.ndarray) -> np.ndarray:
        with torch.no_grad():
            choice = distribution(*network(torch.as_tensor(rows)), **bounds)
        return choice.deterministic_sample.numpy()  # type: ignore[no-any-return]

    return act


LEARNERS: dict[str, Callable[[argparse.Namespace, Options], Act]] = {
    "sb3-ppo": lambda args, options: with_sb3(PPO, "MlpPolicy", args, options),
    "sb3-recurrent-ppo": lambda args, options: with_sb3(
        RecurrentPPO, "MlpLstmPolicy", args, options
    ),
    "sb3-sac": lambda args, options: with_sb3(SAC, "MlpPolicy", args, options),
    "skrl-ppo": with_skrl,
    "torchrl-ppo": with_torchrl,
}


def run(args: argparse.Namespace) -> dict[str, Any]:
    """Trains and evaluates in one task; returns a row of the results."""
    begin = time.process_time()
    torch.manual_seed(args.seed)
    words = (word.split("=") for word in args.option)
    options = {name: int(value) if value.isdigit() else float(value) for name, value in words}
    act = LEARNERS[args.learner](args, options)
    env = engram.make_vec(args.id, EVAL_ENVS, **env_options(args))
    task = score(args, env, act, args.obs_mode)  # of the mean action
    return as_row(args, " ".join([args.learner, *args.option]), args.total_timesteps, task, begin)


def main() -> None:
    torch.set_num_threads(1)  # layers are small
    run_each(parse_arguments(), run)


if __name__ == "__main__":
    main()
