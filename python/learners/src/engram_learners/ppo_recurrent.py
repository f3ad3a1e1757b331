"""Recurrent PPO from objects: whole episodes in lockstep, the gradient through all their steps.

The policy observes objects (``obs_mode="objects"``) and learns from the reward. The memory's loss
uses the policy's own observations. Nothing but the reward is privileged.

    python -m engram_learners.ppo_recurrent --id ShellGameTouch-VLA-v0 --out runs/shell
    python -m engram_learners.ppo_recurrent --id ShellGameTouch-VLA-v0 --no-memory
    torchrun --nproc-per-node 2 -m engram_learners.ppo_recurrent --id ShellGameTouch-VLA-v0
"""

import argparse
import time
from pathlib import Path
from typing import Any, NamedTuple

import torch
from torch import nn

from engram_learners import data_parallel, env_options
from engram_learners.checkpoints import load_policy, save_policy
from engram_learners.memory_loss import MemoryLoss
from engram_learners.policy import Policy, Recalled, can_act, groups
from engram_learners.run_log import Clock, Log
from engram_learners.training import EVALUATION_SEED, ObjectsEnv, evaluate, finish, scale_lr


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    add = parser.add_argument
    add("--id", default="RememberColor3-VLA-v0")
    add("--seed", type=int, default=1)
    env_options.add_to(parser)
    add("--out", type=Path, help="folder for log.csv, curve.png, agent.pt, result.json")
    add("--resume", action="store_true", help="continue with the agent.pt of --out")
    add("--no-memory", action="store_true", help="the control: the same policy without its GRUs")
    add("--memory-lr", type=float, default=1e-2)
    add("--perception-lr", type=float, default=1e-3, help="of encoder and attention")
    add("--recall", type=float, default=0.5, help="weight of the memory's loss")
    add_to(parser)
    args = parser.parse_args()
    args.option = dict(args.option)
    return args


def add_to(parser, **defaults):
    """Adds PPO's own options to a learner's arguments."""
    add = parser.add_argument
    add("--envs", type=int, default=64, help="episodes per iteration, of all processes")
    add("--steps", type=int, default=200_000, help="environment steps in all")
    add("--update-epochs", type=int, default=2, help="passes over an iteration's episodes")
    add("--minibatches", type=int, default=2, help="per pass")
    add("--lr", type=float, default=1e-3)
    add("--gamma", type=float, default=0.9)
    add("--gae", type=float, default=0.9)
    add("--clip", type=float, default=0.2)
    add("--entropy", type=float, default=0.0)
    add("--evaluate-every", type=int, default=40, help="iterations")
    parser.set_defaults(**defaults)


class AgentOutput(NamedTuple):
    """Distribution of the action, value (T, N), what the memory predicts, and its state."""

    distribution: Any
    value: torch.Tensor
    recalled: Recalled | None
    state: Any


class Agent(nn.Module):
    """Actor and critic."""

    def __init__(self, policy):
        super().__init__()
        self.policy = policy
        self.critic = nn.Sequential(nn.LazyLinear(64), nn.Tanh(), nn.Linear(64, 1))

    def forward(self, rows, state=None):
        output = self.policy(rows, state)
        mean, log_std = output.choice.mixed()
        mean = mean.clamp(-1.5, 1.5)  # a servo's can be far beyond what acts
        distribution = torch.distributions.Normal(mean, log_std.exp())
        value = self.critic(output.context)[..., 0]
        return AgentOutput(distribution, value, output.recalled, output.state)


class Rollout(NamedTuple):
    """An iteration's episodes, all (T, N, ...)."""

    rows: torch.Tensor
    actions: torch.Tensor
    log_probs: torch.Tensor
    values: torch.Tensor
    rewards: torch.Tensor


@torch.no_grad()
def collect(agent, env):
    """-> Rollout."""
    steps, state = [], None
    row = env.reset()
    for _ in range(env.horizon):
        output = agent(row[None], state)
        state = output.state
        action = output.distribution.sample()
        log_prob = output.distribution.log_prob(action).sum(-1)
        next_row, reward = env.step(action[0, :, : env.layout.actions].clamp(-1, 1))
        steps.append((row, action[0], log_prob[0], output.value[0], reward))
        row = next_row
    return Rollout(*(torch.stack(column) for column in zip(*steps)))


def estimate_advantages(rewards, values, args):
    """Generalised advantages (T, N) of episodes that end with their last step."""
    advantages, last_advantage, next_value = torch.zeros_like(rewards), 0.0, 0.0
    for t in reversed(range(len(rewards))):
        delta = rewards[t] + args.gamma * next_value - values[t]
        advantages[t] = last_advantage = delta + args.gamma * args.gae * last_advantage
        next_value = values[t]
    return advantages


class RewardScale:
    """Standard deviation of the discounted return, over all episodes so far."""

    def __init__(self, gamma):
        self.gamma, self.count, self.sum, self.squares = gamma, 0, 0.0, 0.0

    def __call__(self, rewards):
        following, returns = 0.0, []
        for reward in rewards.flip(0):
            following = reward + self.gamma * following
            returns.append(following)
        stacked = torch.stack(returns)
        self.count += stacked.numel()
        self.sum += stacked.sum().item()
        self.squares += stacked.square().sum().item()
        mean = self.sum / self.count
        return max(self.squares / self.count - mean**2, 1e-8) ** 0.5


def clipped_surrogate(log_prob, old_log_prob, advantage, clip):
    """PPO's objective, from the log probabilities of actions now and when they were played."""
    ratio = (log_prob - old_log_prob).exp()
    return torch.minimum(ratio * advantage, ratio.clamp(1 - clip, 1 + clip) * advantage)


def learn(agent, optimiser, rollout, scale, args):
    rows, actions, old_log_probs, values, rewards = rollout
    policy = agent.policy
    counts = can_act(policy.layout, rows).float()
    advantages = estimate_advantages(rewards / scale(rewards), values, args)
    returns = advantages + values
    used = advantages[counts > 0]
    advantages = (advantages - used.mean()) / (used.std() + 1e-8)
    labels = MemoryLoss.labels(policy, rows) if policy.predicts else ()
    for _ in range(args.update_epochs):
        for pick in torch.randperm(rows.shape[1]).chunk(args.minibatches):
            output = agent(rows[:, pick])
            weight = counts[:, pick] / counts[:, pick].sum()
            log_prob = output.distribution.log_prob(actions[:, pick]).sum(-1)
            before, advantage = old_log_probs[:, pick], advantages[:, pick]
            surrogate = clipped_surrogate(log_prob, before, advantage, args.clip)
            value_loss = 0.5 * (output.value - returns[:, pick]).square()
            entropy = output.distribution.entropy().sum(-1)
            loss = ((value_loss - surrogate - args.entropy * entropy) * weight).sum()
            if policy.predicts:
                picked = [label[:, pick] for label in labels]
                recall_loss = MemoryLoss.loss(policy, rows[:, pick], output.recalled, picked)
                loss = loss + args.recall * recall_loss
            optimiser.zero_grad()
            loss.backward()
            data_parallel.average(agent)
            nn.utils.clip_grad_norm_(agent.parameters(), 0.5)
            optimiser.step()


def main():
    args = arguments()
    rank, processes = data_parallel.start()
    torch.manual_seed(args.seed + 1000 * rank)
    torch.set_num_threads(1)
    clock, path = Clock(), args.out and args.out / "agent.pt"
    given = {"options": args.option}
    env = ObjectsEnv(args.id, args.envs // processes, args.seed + 1000 * rank, **given)
    test = ObjectsEnv(args.id, 200, **given) if rank == 0 else None  # the first process evaluates
    agent = Agent(Policy(env.layout, memory=not args.no_memory))
    agent(env.reset(seed=args.seed + 1000 * rank)[None])  # the critic takes its size from this
    if args.resume and path.exists():
        agent.policy = load_policy(path).policy
    else:
        agent.policy.fit(collect(agent, env).rows)
    data_parallel.broadcast(agent)
    critic = {"params": agent.critic.parameters(), "lr": args.lr}
    optimiser = torch.optim.Adam(
        [*groups(agent.policy, args.lr, args.memory_lr, args.perception_lr), critic]
    )
    log, scale, begun = (
        Log(args.out if rank == 0 else None),
        RewardScale(args.gamma),
        time.monotonic(),
    )
    per_iteration = args.envs * env.horizon
    iterations = max(1, args.steps // per_iteration)
    for iteration in range(iterations):
        scale_lr(optimiser, 1 - iteration / iterations)
        learn(agent, optimiser, collect(agent, env), scale, args)
        if rank > 0 or ((iteration + 1) % args.evaluate_every and iteration + 1 < iterations):
            continue
        scores = clock.exclude(evaluate, agent.policy, test, EVALUATION_SEED)
        steps = (iteration + 1) * per_iteration
        rate = round(steps / (time.monotonic() - begun))
        log.add(env_steps=steps, steps_per_s=rate, cpu_s=round(clock(), 1), **scores)
        if path:
            save_policy(agent.policy, path, args.id, options=args.option)
    if rank == 0:
        learner = "PPO without memory" if args.no_memory else "recurrent PPO"
        finish(agent.policy, test, args, log, clock(), learner)
    data_parallel.end()


if __name__ == "__main__":
    main()
