"""Learns a task with PPO behind the original's interface, and writes a checkpoint of its form.

    python mikasa_ppo.py --id RememberColor3-VLA-v0 --out checkpoints

The folder receives oracle_checkpoints/ID/ppo/final_success_ckpt.pt, from which the original's
get_mikasa_robo_datasets.py collects demonstrations (`--ckpt-dir checkpoints`): docs/mikasa.md. The
policy is AgentStateOnly, as the original's; here it learns from observations with mean 0 and spread
1, and in the end this is folded into its first layers.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path
from typing import Any

import gymnasium as gym
import torch
from torch import Tensor

import engram.mikasa as mikasa


def parse_arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description="Learns a task with PPO behind the original's interface.",
        formatter_class=argparse.ArgumentDefaultsHelpFormatter,
    )
    add = parser.add_argument
    add("--id", default="RememberColor3-VLA-v0", help="task")
    add("--out", type=Path, default=Path(), help="folder of oracle_checkpoints")
    add("--seed", type=int, default=1, help="of episodes, networks and exploration")
    add("--num-envs", type=int, default=128, help="environments stepped together")
    add("--iterations", type=int, default=300, help="at most; each is an episode of all of them")
    add("--success", type=float, default=0.8, help="of mean actions, to stop at")
    add("--epochs", type=int, default=4, help="passes over the steps of an iteration")
    add("--minibatches", type=int, default=8, help="gradient steps per pass")
    add("--learning-rate", type=float, default=1e-3, help="of Adam at the start; falls to a fifth")
    add("--gamma", type=float, default=0.9, help="discount per step")
    add("--gae-lambda", type=float, default=0.9, help="of generalised advantage estimation")
    add("--log-std", type=float, default=-1.0, help="of the exploration at the start")
    return parser.parse_args()


def make_envs(id: str, num_envs: int) -> mikasa.ManiSkillVectorEnv:
    """Environments of the original's collector: states as dicts, frozen while the cue is shown."""
    env: Any = gym.make(id, num_envs=num_envs, obs_mode="state", control_mode="pd_ee_delta_pose")
    env = mikasa.StateOnlyTensorToDictWrapper(env)
    env = mikasa.CurriculumPhaseNoopActionWrapper(env)
    env = mikasa.FlattenRGBDObservationWrapper(env, rgb=False, depth=False)
    return mikasa.ManiSkillVectorEnv(env, ignore_terminations=True, record_metrics=True)


class Scale:
    """Mean and spread of what has been seen so far."""

    def __init__(self, width: int) -> None:
        self.count = 0.0
        self.mean = torch.zeros(width, dtype=torch.float64)
        self.square = torch.zeros(width, dtype=torch.float64)

    def update(self, rows: Tensor) -> None:
        """Takes rows in."""
        self.count += len(rows)
        share = len(rows) / self.count
        self.mean += share * (rows.double().mean(0) - self.mean)
        self.square += share * (rows.double().square().mean(0) - self.square)

    def spread(self) -> Tensor:
        """Standard deviations; 1 of what does not change."""
        spread = (self.square - self.mean.square()).clamp_min(0).sqrt()
        return torch.where(spread < 1e-4, 1.0, spread)

    def __call__(self, values: Tensor) -> Tensor:
        """Values with mean 0 and spread 1."""
        return ((values - self.mean) / self.spread()).float()

    @torch.no_grad()
    def fold_into(self, agent: mikasa.AgentStateOnly) -> None:
        """Makes of a policy of scaled observations one of observations as they are."""
        for body in (agent.actor_mean, agent.critic):
            first = body[0]
            weight = first.weight.double() / self.spread()
            first.bias -= (weight @ self.mean).float()
            first.weight.copy_(weight)


def play(envs: Any, agent: Any, scale: Scale, gamma: float, decay: float) -> tuple[Any, ...]:
    """An episode of all environments: inputs, actions, log probabilities, advantages, returns.

    Steps in which actions are frozen teach nothing of actions, and are left out.
    """
    obs, _ = envs.reset()
    base = envs.base_env
    until = base.cue_steps_per_env + base.empty_steps_per_env
    rows: list[tuple[Tensor, ...]] = []
    raw = []
    with torch.no_grad():
        for step in range(envs.max_episode_steps):
            inputs = scale(obs["state"])
            action, logp, _, value = agent.get_action_and_value({"state": inputs})
            raw.append(obs["state"])
            obs, reward, _, _, info = envs.step(action.clamp(-1, 1))
            rows.append((inputs, action, logp, value[:, 0], reward, step >= until))
        following = agent.get_value({"state": scale(info["final_observation"]["state"])})[:, 0]
    inputs, actions, logps, values, rewards, free = map(torch.stack, zip(*rows))
    advantages = torch.zeros_like(rewards)
    advantage = torch.zeros_like(following)
    for t in reversed(range(len(rewards))):
        error = rewards[t] + gamma * following - values[t]
        advantages[t] = advantage = error + gamma * decay * advantage
        following = values[t]
    scale.update(torch.cat(raw))
    success = info["final_info"]["episode"]["success_once"].float().mean()
    kept = (x[free] for x in (inputs, actions, logps, advantages, advantages + values))
    return float(success), *kept


@torch.no_grad()
def evaluate(envs: Any, agent: Any, scale: Scale) -> float:
    """The share of episodes in which mean actions succeed."""
    obs, _ = envs.reset()
    info: dict[str, Any] = {}
    for _ in range(envs.max_episode_steps):
        action = agent.get_action({"state": scale(obs["state"])}, deterministic=True)
        obs, _, _, _, info = envs.step(action.clamp(-1, 1))
    return float(info["final_info"]["episode"]["success_once"].float().mean())


def improve(agent: Any, optimiser: Any, batch: Any, args: argparse.Namespace) -> None:
    """One iteration's gradient steps (Schulman et al., 2017)."""
    inputs, actions, logps, advantages, returns = batch
    for _ in range(args.epochs):
        for rows in torch.randperm(len(inputs)).chunk(args.minibatches):
            _, logp, _, value = agent.get_action_and_value({"state": inputs[rows]}, actions[rows])
            ratio = (logp - logps[rows]).exp()
            gain = advantages[rows]
            gain = (gain - gain.mean()) / (gain.std() + 1e-8)
            gained = torch.min(ratio * gain, ratio.clamp(0.8, 1.2) * gain).mean()
            loss = 0.5 * (value[:, 0] - returns[rows]).square().mean() - gained
            optimiser.zero_grad()
            loss.backward()
            torch.nn.utils.clip_grad_norm_(agent.parameters(), 0.5)
            optimiser.step()


def train(args: argparse.Namespace) -> mikasa.AgentStateOnly:
    """A policy that has learned the task; prints its progress."""
    torch.manual_seed(args.seed)
    torch.set_num_threads(1)  # the networks are too small to share
    envs = make_envs(args.id, args.num_envs)
    agent = mikasa.AgentStateOnly(envs)
    with torch.no_grad():
        agent.actor_logstd.fill_(args.log_std)
    optimiser = torch.optim.Adam(agent.parameters(), lr=args.learning_rate, eps=1e-5)
    obs, _ = envs.reset(seed=args.seed)
    scale = Scale(obs["state"].shape[1])
    scale.update(obs["state"])
    play(envs, agent, scale, args.gamma, args.gae_lambda)  # sets the sizes of observations
    for iteration in range(1, args.iterations + 1):
        rate = max(0.2, 1 - iteration / 180)
        optimiser.param_groups[0]["lr"] = args.learning_rate * rate
        explored, *batch = play(envs, agent, scale, args.gamma, args.gae_lambda)
        improve(agent, optimiser, batch, args)
        if iteration % 10 == 0:
            success = evaluate(envs, agent, scale)
            print(
                f"{iteration:4} iterations, {time.process_time():5.0f} s of processor time: "
                f"success_once while exploring {explored:.2f}, of mean actions {success:.2f}",
                flush=True,
            )
            if success >= args.success:
                break
    scale.fold_into(agent)
    envs.close()
    return agent


def main() -> None:
    args = parse_arguments()
    agent = train(args)
    path = args.out / "oracle_checkpoints" / args.id / "ppo" / "final_success_ckpt.pt"
    path.parent.mkdir(parents=True, exist_ok=True)
    torch.save(agent.state_dict(), path)
    print(path)


if __name__ == "__main__":
    main()
