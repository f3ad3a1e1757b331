"""Proximal policy optimisation in one file: learns an engram task from its state observation.

    python ppo.py --id RememberColor3-VLA-v0 --seed 1 --out runs/color3

Needs torch and matplotlib beside engram, and no accelerator: small networks on one core, the
simulator on all of them, taking turns. The folder `--out` receives log.csv (a row per iteration),
curve.png and agent.pt. docs/learning.md has results, and reasons for the numbers.
"""

from __future__ import annotations

import argparse
import csv
import math
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch
from gymnasium.spaces import flatdim
from torch import Tensor, nn
from torch.distributions import Normal

import engram

# Seeds of the episodes that measure progress, and of those behind the final figure.
PROGRESS_SEED = 1_000_000
FINAL_SEED = 2_000_000


def parse_arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description="Learns an engram task with PPO.",
        formatter_class=argparse.ArgumentDefaultsHelpFormatter,
    )
    add = parser.add_argument
    add("--id", default="RememberColor3-VLA-v0", help="task")
    add("--control-mode", default=None, help="meaning of actions; None: the task's own")
    add("--seed", type=int, default=1, help="of episodes, networks and exploration")
    add("--steps", type=int, default=600_000, help="environment steps to learn from")
    add("--minutes", type=float, default=9.0, help="stop earlier after this wall-clock time")
    add("--num-envs", type=int, default=128, help="environments stepped together")
    add("--threads", type=int, default=0, help="of the simulator; 0: one per core")
    add("--torch-threads", type=int, default=1, help="of torch; 0: one per core")
    add("--out", type=Path, default=Path("ppo_run"), help="folder of log.csv, curve.png, agent.pt")
    add("--eval-every", type=int, default=10, help="iterations between evaluations")
    add("--eval-episodes", type=int, default=200, help="episodes of an evaluation")
    add("--num-steps", type=int, default=25, help="steps of each environment per iteration")
    add("--update-epochs", type=int, default=4, help="passes over the steps of an iteration")
    add("--num-minibatches", type=int, default=8, help="gradient steps per pass")
    add("--learning-rate", type=float, default=1e-3, help="of Adam at the start; falls to zero")
    add("--gamma", type=float, default=0.9, help="discount per step")
    add("--gae-lambda", type=float, default=0.9, help="of generalised advantage estimation")
    add("--clip-coef", type=float, default=0.2, help="largest useful change of a probability ratio")
    add("--log-std", type=float, default=-1.0, help="of the exploration at the start")
    add("--width", type=int, default=64, help="of the two hidden layers")
    return parser.parse_args()


class Moments(nn.Module):
    """Running mean and variance of each column, over everything seen so far."""

    mean: Tensor
    var: Tensor
    count: Tensor

    def __init__(self, width: int) -> None:
        super().__init__()
        self.register_buffer("mean", torch.zeros(width, dtype=torch.float64))
        self.register_buffer("var", torch.zeros(width, dtype=torch.float64))
        self.register_buffer("count", torch.zeros((), dtype=torch.float64))

    def update(self, rows: Tensor) -> None:
        """Merges a batch of rows in (Chan et al., 1979)."""
        rows = rows.double()
        total = self.count + len(rows)
        delta = rows.mean(0) - self.mean
        between = delta.square() * self.count * len(rows) / total
        inside = self.count * self.var + len(rows) * rows.var(0, unbiased=False)
        self.mean = self.mean + delta * len(rows) / total
        self.var = (inside + between) / total
        self.count = total


class Agent(nn.Module):
    """A Gaussian policy and a value function over normalised observations."""

    def __init__(self, env: engram.VectorEnv, args: argparse.Namespace) -> None:
        super().__init__()
        inputs = flatdim(env.single_observation_space)
        actions = flatdim(env.single_action_space)
        self.moments = Moments(inputs)
        # Spread depends on the state: wide strokes on the way, a steady hand at the target.
        self.actor = mlp(inputs, args.width, 2 * actions, last_gain=0.01)
        self.critic = mlp(inputs, args.width, 1, last_gain=1.0)
        self.log_std = args.log_std

    def normalise(self, observations: Tensor) -> Tensor:
        scaled = (observations - self.moments.mean) / torch.sqrt(self.moments.var + 1e-8)
        return scaled.clamp(-10.0, 10.0).float()

    def policy(self, inputs: Tensor) -> Normal:
        mean, log_std = self.actor(inputs).chunk(2, -1)
        std = (log_std + self.log_std).clamp(-5.0, 0.0).exp()
        return Normal(mean, std, validate_args=False)

    def value(self, inputs: Tensor) -> Tensor:
        values: Tensor = self.critic(inputs).squeeze(-1)
        return values


def mlp(inputs: int, width: int, outputs: int, last_gain: float) -> nn.Sequential:
    def linear(size_in: int, size_out: int, gain: float) -> nn.Linear:
        layer = nn.Linear(size_in, size_out)
        nn.init.orthogonal_(layer.weight, gain)
        nn.init.zeros_(layer.bias)
        return layer

    root2 = math.sqrt(2.0)
    hidden = linear(inputs, width, root2), nn.Tanh(), linear(width, width, root2), nn.Tanh()
    return nn.Sequential(*hidden, linear(width, outputs, last_gain))


@dataclass
class Rollout:
    """Consecutive steps of a batch of environments: each tensor is (steps, environments, ...)."""

    observations: Tensor
    actions: Tensor
    log_probs: Tensor
    rewards: Tensor
    next_observations: Tensor  # the observation before an automatic reset
    terminated: Tensor
    ended: Tensor  # terminated or truncated


class Collector:
    """Steps the environments, and remembers where they are from one rollout to the next.

    The environments reset in the same step: what an episode's last step returns is already the
    next episode's first observation, and info["final_obs"] has the episode's own last one. No
    transition is wasted, and a truncated episode is bootstrapped with the value of that last
    observation. Arrays are views of engram's memory that the next step
    overwrites, hence torch.tensor, which copies.
    """

    def __init__(self, env: engram.VectorEnv, seed: int) -> None:
        self.env = env
        self.observations = torch.tensor(env.reset(seed=seed)[0])
        self.successes: list[bool] = []  # success_once of the episodes that have ended
        self.returns: list[float] = []

    @torch.no_grad()
    def collect(self, agent: Agent, steps: int) -> Rollout:
        rows: list[tuple[Tensor, ...]] = []
        for _ in range(steps):
            policy = agent.policy(agent.normalise(self.observations))
            actions = policy.sample()
            log_probs = policy.log_prob(actions).sum(-1)
            observations, rewards, terminated, truncated, info = self.env.step(bounded(actions))
            before, self.observations = self.observations, torch.tensor(observations)
            reached = self.observations
            ended = terminated | truncated
            if ended.any():
                reached = reached.clone()
                last = np.stack(info["final_obs"][ended])  # Gymnasium's are rows, or None
                reached[torch.tensor(ended)] = torch.tensor(last)
                self.successes += info["final_info"]["success_once"][ended].tolist()
                self.returns += info["final_info"]["episode_return"][ended].tolist()
            flags = torch.tensor(terminated), torch.tensor(ended)
            rows.append((before, actions, log_probs, torch.tensor(rewards), reached, *flags))
        return Rollout(*(torch.stack(column) for column in zip(*rows)))

    def take_episodes(self) -> tuple[float, float]:
        """Mean success_once and return of the episodes that ended since the last call."""
        count = len(self.returns) or math.nan
        means = sum(self.successes) / count, sum(self.returns) / count
        self.successes, self.returns = [], []
        return means


def bounded(actions: Tensor) -> np.ndarray:
    array: np.ndarray = actions.clamp(-1.0, 1.0).numpy()
    return array


class RewardScale:
    """Divides rewards by the running standard deviation of the discounted return."""

    def __init__(self, num_envs: int, gamma: float) -> None:
        self.gamma = gamma
        self.running = torch.zeros(num_envs)
        self.moments = Moments(1)

    def __call__(self, rewards: Tensor, ended: Tensor) -> Tensor:
        returns = []
        for reward, end in zip(rewards, ended):
            self.running = self.gamma * self.running + reward
            returns.append(self.running)
            self.running = self.running * ~end
        self.moments.update(torch.cat(returns)[:, None])
        return rewards / (self.moments.var.sqrt().float() + 1e-8)


def estimate_advantages(errors: Tensor, ended: Tensor, decay: float) -> Tensor:
    """Generalised advantage estimation (Schulman et al., 2016) from one-step errors."""
    advantages = torch.zeros_like(errors)
    following = torch.zeros_like(errors[0])
    for t in reversed(range(len(errors))):
        following = errors[t] + decay * ~ended[t] * following
        advantages[t] = following
    return advantages


def update(
    agent: Agent,
    optimiser: torch.optim.Optimizer,
    rollout: Rollout,
    rewards: Tensor,
    args: argparse.Namespace,
) -> dict[str, float]:
    """One iteration's gradient steps (Schulman et al., 2017); returns what the log shows."""
    inputs = agent.normalise(rollout.observations)
    with torch.no_grad():
        values = agent.value(inputs)
        next_values = agent.value(agent.normalise(rollout.next_observations))
        errors = rewards + args.gamma * ~rollout.terminated * next_values - values
        advantages = estimate_advantages(errors, rollout.ended, args.gamma * args.gae_lambda)
    # Steps and environments become one dimension.
    inputs, actions = inputs.flatten(0, 1), rollout.actions.flatten(0, 1)
    old_log_probs, targets = rollout.log_probs.flatten(), (advantages + values).flatten()
    advantages = advantages.flatten()

    figures = []
    for _ in range(args.update_epochs):
        for rows in torch.randperm(len(inputs)).chunk(args.num_minibatches):
            policy = agent.policy(inputs[rows])
            log_ratio = policy.log_prob(actions[rows]).sum(-1) - old_log_probs[rows]
            ratio = log_ratio.exp()
            clipped = ratio.clamp(1.0 - args.clip_coef, 1.0 + args.clip_coef)
            advantage = advantages[rows]
            advantage = (advantage - advantage.mean()) / (advantage.std() + 1e-8)
            policy_loss = -torch.minimum(ratio * advantage, clipped * advantage).mean()
            value_loss = 0.5 * (agent.value(inputs[rows]) - targets[rows]).square().mean()
            optimiser.zero_grad()
            (policy_loss + 0.5 * value_loss).backward()
            nn.utils.clip_grad_norm_(agent.parameters(), 0.5)
            optimiser.step()
            kl = (ratio - 1.0 - log_ratio).mean()
            figures.append(torch.stack([policy_loss, value_loss, kl]).detach())
    means = torch.stack(figures).mean(0).tolist()
    return dict(zip(("policy_loss", "value_loss", "kl"), means))


@torch.no_grad()
def evaluate(agent: Agent, env: engram.VectorEnv, seed: int) -> tuple[float, float]:
    """Means of success_once and return of one episode per environment, without exploration."""
    observations, _ = env.reset(seed=seed)
    success, returns = np.zeros(env.num_envs, bool), np.zeros(env.num_envs)
    running = np.ones(env.num_envs, bool)
    while running.any():
        policy = agent.policy(agent.normalise(torch.tensor(observations)))
        observations, _, terminated, truncated, info = env.step(bounded(policy.mean))
        over = running & (terminated | truncated)
        if over.any():
            success[over] = info["final_info"]["success_once"][over]
            returns[over] = info["final_info"]["episode_return"][over]
        running &= ~over
    return float(success.mean()), float(returns.mean())


def train(args: argparse.Namespace) -> list[dict[str, float]]:
    """Learns, and writes all files; returns the rows of the log."""
    start = time.perf_counter()
    torch.manual_seed(args.seed)
    if args.torch_threads > 0:
        torch.set_num_threads(args.torch_threads)

    def make_env(num_envs: int, terminate_on_success: bool | None) -> engram.VectorEnv:
        return engram.make_vec(
            args.id,
            num_envs=num_envs,
            threads=args.threads,
            obs_mode="state",
            control_mode=args.control_mode,
            reward_mode="normalized_dense",
            autoreset_mode="SAME_STEP",
            copy=False,  # torch.tensor copies
            terminate_on_success=terminate_on_success,
        )

    # Rewards are positive all the way: where success ends an episode, the best-paid policy hovers
    # just short of it. So training runs to the horizon; evaluation uses the task's rule.
    env = make_env(args.num_envs, terminate_on_success=False)
    eval_env = make_env(args.eval_episodes, terminate_on_success=None)
    agent = Agent(env, args)
    optimiser = torch.optim.Adam(agent.parameters(), lr=args.learning_rate, eps=1e-5)
    scale = RewardScale(args.num_envs, args.gamma)
    collector = Collector(env, engram.worker_seed(args.seed, 0))

    # The first rollout sets the sizes of observations. Later, moments change between iterations
    # alone, so that a rollout and its updates see the same policy.
    rollout = collector.collect(agent, args.num_steps)
    agent.moments.update(rollout.observations.flatten(0, 1))
    scale(rollout.rewards, rollout.ended)
    collector.take_episodes()

    per_iteration = args.num_steps * args.num_envs
    iterations = max(1, args.steps // per_iteration)
    log: list[dict[str, float]] = []
    for iteration in range(1, iterations + 1):
        if log and time.perf_counter() - start > 60.0 * args.minutes:
            break
        optimiser.param_groups[0]["lr"] = args.learning_rate * (1.0 - (iteration - 1) / iterations)
        rollout = collector.collect(agent, args.num_steps)
        rewards = scale(rollout.rewards, rollout.ended)
        figures = update(agent, optimiser, rollout, rewards, args)
        agent.moments.update(rollout.observations.flatten(0, 1))

        success, episode_return = collector.take_episodes()
        row = {
            "iteration": iteration,
            "steps": iteration * per_iteration,
            "seconds": time.perf_counter() - start,
            "cpu_seconds": time.process_time(),
            "success_once": success,
            "return": episode_return,
            "eval_success_once": math.nan,
            **figures,
        }
        if iteration % args.eval_every == 0:
            row["eval_success_once"], _ = evaluate(agent, eval_env, PROGRESS_SEED)
            print(
                f"{row['steps']:>9,} steps {row['seconds']:6.1f} s  success_once: exploring "
                f"{success:.3f}, evaluated {row['eval_success_once']:.3f}",
                flush=True,
            )
        log.append(row)
    write_log(log, args.out / "log.csv")
    success, episode_return = evaluate(agent, eval_env, FINAL_SEED)
    print(
        f"{args.id}, seed {args.seed}: success_once {success:.3f}, return {episode_return:.2f}, "
        f"means of {args.eval_episodes} fresh episodes of the policy's mean action; "
        f"{time.perf_counter() - start:.1f} s, {time.process_time():.1f} s of processor time"
    )
    torch.save(agent.state_dict(), args.out / "agent.pt")
    plot(log, f"{args.id}, seed {args.seed}", args.out / "curve.png")
    return log


def write_log(log: list[dict[str, float]], path: Path) -> None:
    with path.open("w", newline="") as file:
        writer = csv.DictWriter(file, log[0].keys())
        writer.writeheader()
        writer.writerows(log)


def plot(log: list[dict[str, float]], title: str, path: Path) -> None:
    import matplotlib  # here, because it takes a while to load

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    from matplotlib.axes import Axes
    from matplotlib.ticker import EngFormatter

    def curve(axes: Axes, name: str, **style: Any) -> None:
        points = [(row["steps"], row[name]) for row in log if not math.isnan(row[name])]
        axes.plot(*zip(*points), **style)
        axes.xaxis.set_major_formatter(EngFormatter(sep=""))

    figure, (left, right) = plt.subplots(1, 2, figsize=(8.0, 3.0), layout="constrained")
    left.axhline(0.9, color="0.8", linewidth=0.8)
    curve(left, "success_once", label="while exploring", color="tab:orange")
    curve(left, "eval_success_once", label="mean action, unseen episodes", marker=".")
    left.set(xlabel="environment steps", ylabel="success_once", ylim=(-0.02, 1.02))
    left.legend(fontsize="small", loc="lower right")
    curve(right, "return", color="tab:orange")
    right.set(xlabel="environment steps", ylabel="episode return while exploring")
    minutes = log[-1]["seconds"] / 60.0
    figure.suptitle(f"{title}: {minutes:.1f} minutes", fontsize="medium")
    figure.savefig(path, dpi=90)
    plt.close(figure)


def main() -> None:
    args = parse_arguments()
    args.out.mkdir(parents=True, exist_ok=True)
    train(args)


if __name__ == "__main__":
    main()
