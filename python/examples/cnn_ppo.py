"""PPO from pictures: a small CNN acts, a critic sees the state, through the preset "train".

    python cnn_ppo.py --id TakeItBack-VLA-v0 --total-timesteps 1000000
    python cnn_ppo.py --id InterceptSlow-VLA-v0 --critic rgb

The actor gets the pictures of both cameras, that of the base camera one step before, all at half
their size, and the proprio. The critic is for training alone, so it may see what is hidden (Pinto
et al., 2018): `obs_mode="rgb+state"` has both. `--critic rgb` gives it the actor's features
instead. For the same reason the CNN's features may be taught to predict the state's rows
(`--predict-state 0` leaves that out). No memory beyond two frames. A line says where the time went.

glibc gives large arrays back to the system and gets them anew; where that is forbidden
(MALLOC_MMAP_THRESHOLD_=2000000000 MALLOC_TRIM_THRESHOLD_=2000000000 in the environment), torch
learns up to twice as fast. docs/learning.md has results.
"""

from __future__ import annotations

import argparse
import time
from typing import Any

import numpy as np
import torch
from plain_ppo import (
    EVAL_ENVS,
    Clock,
    Normaliser,
    as_row,
    estimate_advantages,
    run_each,
    score,
    whole_iterations,
)
from torch import Tensor, nn
from torch.distributions import Normal

import engram

FEATURES = 128


def parse_arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description="Learns an engram task from pictures with PPO.",
        formatter_class=argparse.ArgumentDefaultsHelpFormatter,
    )
    add = parser.add_argument
    add("--id", nargs="+", default=["TakeItBack-VLA-v0"], help="tasks, one run after the other")
    add("--critic", default="state", choices=["state", "rgb"], help="what the critic sees")
    add("--predict-state", type=float, default=1.0, help="weight of that loss; 0: none")
    add("--seed", type=int, default=1, help="of episodes, networks and exploration")
    add("--total-timesteps", type=int, default=1_000_000, help="environment steps to learn from")
    add("--num-envs", type=int, default=128, help="environments stepped together")
    add("--num-steps", type=int, default=32, help="steps of each environment per iteration")
    add("--minibatch", type=int, default=256, help="steps of a gradient step")
    add("--update-epochs", type=int, default=3, help="passes over the steps of an iteration")
    add("--learning-rate", type=float, default=1e-3, help="of Adam at the start; falls to zero")
    add("--gamma", type=float, default=0.95, help="discount per step")
    add("--gae-lambda", type=float, default=0.7, help="of generalised advantage estimation")
    add("--clip-coef", type=float, default=0.2, help="largest useful change of a probability ratio")
    add("--threads", type=int, default=1, help="of the simulator and of torch")
    add("--eval-episodes", type=int, default=200, help="of the evaluation at the end")
    add("--file", help="CSV file that gets a row for the run")
    return parser.parse_args()


def mlp(sizes: list[int], gain: float) -> nn.Sequential:
    layers: list[nn.Module] = []
    for size, following in zip(sizes, sizes[1:]):
        layers += [nn.Linear(size, following), nn.Tanh()]
        nn.init.orthogonal_(layers[-2].weight, 2**0.5)  # type: ignore[arg-type]
    nn.init.orthogonal_(layers[-2].weight, gain)  # type: ignore[arg-type]
    return nn.Sequential(*layers[:-1])


class Agent(nn.Module):
    """Actor of pictures and proprio, and critic of the state's rows or of the actor's features."""

    def __init__(self, proprio: int, state: int, actions: int, sees_state: bool) -> None:
        super().__init__()
        convolutions = [nn.Conv2d(9, 16, 8, 4), nn.Conv2d(16, 32, 4, 2), nn.Conv2d(32, 32, 3)]
        layers = [part for one in convolutions for part in (one, nn.ReLU())]
        self.cnn = nn.Sequential(*layers, nn.Flatten(), nn.Linear(512, FEATURES), nn.ReLU())
        self.actor = mlp([FEATURES + proprio, 64, actions], 0.01)
        self.critic = mlp([state if sees_state else FEATURES + proprio, 128, 128, 1], 1.0)
        self.predict = nn.Linear(FEATURES + proprio, state)
        self.sees_state = sees_state
        self.log_std = nn.Parameter(torch.zeros(actions))

    def features(self, frames: Tensor, proprio: Tensor) -> Tensor:
        """What the actor sees, of frames (N, 64, 64, 9) in bytes."""
        return torch.cat([self.cnn(frames.permute(0, 3, 1, 2).float() / 255), proprio], 1)

    def forward(
        self, frames: Tensor, proprio: Tensor, state: Tensor
    ) -> tuple[Normal, Tensor, Tensor]:
        """Distribution of actions, value, and mean square error of the predicted state."""
        features = self.features(frames, proprio)
        value = self.critic(state if self.sees_state else features)[:, 0]
        error = (self.predict(features) - state).square().mean()
        return Normal(self.actor(features), self.log_std.exp()), value, error


def halved(frames: np.ndarray) -> np.ndarray:
    """Means of 2 x 2 pixels."""
    rows = frames[:, ::2].astype(np.uint16) + frames[:, 1::2]
    return ((rows[:, :, ::2] + rows[:, :, 1::2]) >> 2).astype(np.uint8)


class Stack:
    """Frames of this step, and the base camera's before; the same where an episode begins."""

    def __init__(self) -> None:
        self.last: np.ndarray | None = None

    def __call__(self, rgb: np.ndarray, begins: np.ndarray) -> np.ndarray:
        frames = halved(rgb)
        before = frames if self.last is None else self.last
        before = np.where(begins.astype(bool)[:, None, None, None], frames, before)
        self.last = frames
        return np.concatenate([frames, before[..., :3]], -1)


def train(args: argparse.Namespace) -> tuple[Agent, Normaliser]:
    """Learns; prints the success of the episodes that exploration has ended, and a profile."""
    env = engram.make_vec(
        args.id,
        args.num_envs,
        obs_mode="rgb+state",
        preset="train",
        autoreset_mode="SAME_STEP",
        threads=args.threads,
        seed=(args.seed, 0),
        copy=False,
    )
    spaces, space = env.single_observation_space.spaces, env.single_action_space
    width = {name: spaces[name].shape[0] for name in ("proprio", "state")}
    agent = Agent(width["proprio"], width["state"], space.shape[0], args.critic == "state")
    adam = torch.optim.Adam(agent.parameters(), args.learning_rate, eps=1e-5)
    scale = {
        name: Normaliser(args.num_envs, np.arange(size), args.gamma) for name, size in width.items()
    }
    shape = args.num_steps, args.num_envs
    iterations = max(1, args.total_timesteps // (shape[0] * shape[1]))
    seen, _ = env.reset()
    stack, done = Stack(), np.ones(args.num_envs, np.float32)
    clock, successes = Clock(), []

    def look() -> tuple[Tensor, ...]:
        rows = (one.observation(seen[name]) for name, one in scale.items())
        return tuple(map(torch.from_numpy, (stack(seen["rgb"], done), *rows)))

    inputs = look()
    for iteration in range(iterations):
        adam.param_groups[0]["lr"] = args.learning_rate * (1 - iteration / iterations)
        columns: list[tuple[Tensor, ...]] = []
        rewards, dones, values = (np.zeros(shape, np.float32) for _ in range(3))
        for t in range(args.num_steps):
            dones[t] = done
            with torch.no_grad():
                policy, value, _ = agent(*inputs)
                action = policy.sample()
            columns.append((*inputs, action, policy.log_prob(action).sum(1)))
            values[t] = value
            clock.done("act")
            seen, reward, terminated, truncated, info = env.step(action.numpy())
            clock.done("env.step")
            ended = terminated | truncated
            if ended.any():
                successes += info["final_info"]["success_once"][ended].tolist()
            rewards[t] = scale["state"].reward(reward, ended)
            done = ended.astype(np.float32)
            inputs = look()
            clock.done("scale")
        with torch.no_grad():
            last = agent(*inputs)[1].numpy()
        advantages = estimate_advantages(args, rewards, values, dones, last, done)
        flat = [torch.cat(part) for part in zip(*columns)]
        targets = [torch.from_numpy(part.reshape(-1)) for part in (advantages, advantages + values)]
        learn_from(args, agent, adam, [*flat, *targets])
        clock.done("learn")
        if (iteration + 1) % 20 == 0:
            share = np.mean(successes) if successes else np.nan
            steps = (iteration + 1) * shape[0] * shape[1]
            seconds = time.process_time()
            print(f"{steps:>9,} steps {seconds:6.1f} s  exploring {share:.3f}", flush=True)
            successes = []
    clock.report(iterations * shape[0] * shape[1])
    return agent, scale["proprio"]


def learn_from(
    args: argparse.Namespace, agent: Agent, adam: torch.optim.Optimizer, data: list[Tensor]
) -> None:
    """Gradient steps of an iteration: PPO's clipped loss (Schulman et al., 2017)."""
    for _ in range(args.update_epochs):
        for rows in torch.randperm(len(data[0])).split(args.minibatch):
            *inputs, actions, old, advantages, returns = (part[rows] for part in data)
            policy, values, error = agent(*inputs)
            ratio = (policy.log_prob(actions).sum(1) - old).exp()
            advantages = (advantages - advantages.mean()) / (advantages.std() + 1e-8)
            clipped = ratio.clamp(1 - args.clip_coef, 1 + args.clip_coef)
            loss = -torch.minimum(advantages * ratio, advantages * clipped).mean()
            loss = loss + (values - returns).square().mean() + args.predict_state * error
            adam.zero_grad()
            loss.backward()  # type: ignore[no-untyped-call]
            nn.utils.clip_grad_norm_(agent.parameters(), 0.5)
            adam.step()


def evaluate(args: argparse.Namespace, agent: Agent, scale: Normaliser) -> dict[str, Any]:
    """Success of the mean action, from pictures and proprio alone, in engram's own evaluation."""
    env = engram.make_vec(args.id, EVAL_ENVS, obs_mode="rgb", preset="train", threads=1)
    stack = Stack()

    def act(seen: Any, begins: np.ndarray) -> np.ndarray:
        with torch.no_grad():
            frames = torch.from_numpy(stack(seen["rgb"], begins))
            proprio = torch.from_numpy(scale.observation(seen["proprio"], learn=False))
            features = agent.features(frames, proprio)
            result: np.ndarray = agent.actor(features).numpy()
        return result

    return score(args, env, act, "rgb")


def run(args: argparse.Namespace) -> dict[str, Any]:
    """Trains and evaluates in one task; returns a row of the results."""
    torch.manual_seed(args.seed)
    begin = time.process_time()
    learner = f"cnn_ppo.py --critic {args.critic} --predict-state {args.predict_state:g}"
    return as_row(args, learner, whole_iterations(args), evaluate(args, *train(args)), begin)


def main() -> None:
    args = parse_arguments()
    torch.set_num_threads(args.threads)
    run_each(args, run)


if __name__ == "__main__":
    main()
