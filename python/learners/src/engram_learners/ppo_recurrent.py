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

import torch
from torch import nn

from engram_learners import data_parallel, env_options
from engram_learners.memory_loss import MemoryLoss
from engram_learners.policy import Policy, can_act, groups
from engram_learners.training import (
    EVALUATION_SEED,
    Clock,
    Log,
    ObjectsEnv,
    evaluate,
    finish,
    load_policy,
    save_policy,
    scale_lr,
)


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
    add("--passes", type=int, default=2, help="over an iteration's episodes")
    add("--minibatches", type=int, default=2, help="per pass")
    add("--lr", type=float, default=1e-3)
    add("--gamma", type=float, default=0.9)
    add("--gae", type=float, default=0.9)
    add("--clip", type=float, default=0.2)
    add("--entropy", type=float, default=0.0)
    add("--evaluate-every", type=int, default=40, help="iterations")
    parser.set_defaults(**defaults)


class Agent(nn.Module):
    """Actor and critic."""

    def __init__(self, policy):
        super().__init__()
        self.policy = policy
        self.critic = nn.Sequential(nn.LazyLinear(64), nn.Tanh(), nn.Linear(64, 1))

    def forward(self, rows, state=None):
        """-> distribution of the action, value (T, N), predictions of the memory, its state."""
        choice, recalled, state, context = self.policy(rows, state)
        mean, deviation = choice.mixed()
        mean = mean.clamp(-1.5, 1.5)  # a servo's can be far beyond what acts
        value = self.critic(context)[..., 0]
        return torch.distributions.Normal(mean, deviation.exp()), value, recalled, state


@torch.no_grad()
def collect(agent, scenes):
    """An iteration's rows, actions, their log density, values and rewards, all (T, N, ...)."""
    parts, state = [], None
    row = scenes.reset()
    for _ in range(scenes.horizon):
        distribution, value, _, state = agent(row[None], state)
        action = distribution.sample()
        log_density = distribution.log_prob(action).sum(-1)
        after, reward = scenes.step(action[0, :, : scenes.layout.actions].clamp(-1, 1))
        parts.append((row, action[0], log_density[0], value[0], reward))
        row = after
    return [torch.stack(part) for part in zip(*parts)]


def advantages(rewards, values, args):
    """Generalised advantages (T, N) of episodes that end with their last step."""
    result, ahead, after = torch.zeros_like(rewards), 0.0, 0.0
    for t in reversed(range(len(rewards))):
        error = rewards[t] + args.gamma * after - values[t]
        result[t] = ahead = error + args.gamma * args.gae * ahead
        after = values[t]
    return result


class Scale:
    """Standard deviation of the discounted return, over all episodes so far."""

    def __init__(self, gamma):
        self.gamma, self.count, self.sum, self.squares = gamma, 0, 0.0, 0.0

    def __call__(self, rewards):
        ahead, returns = 0.0, []
        for reward in rewards.flip(0):
            ahead = reward + self.gamma * ahead
            returns.append(ahead)
        returns = torch.stack(returns)
        self.count += returns.numel()
        self.sum += returns.sum().item()
        self.squares += returns.square().sum().item()
        mean = self.sum / self.count
        return max(self.squares / self.count - mean**2, 1e-8) ** 0.5


def clipped_gain(density, before, gain, clip):
    """PPO's objective, from the log densities of actions now and when they were played."""
    ratio = (density - before).exp()
    return torch.minimum(ratio * gain, ratio.clamp(1 - clip, 1 + clip) * gain)


def learn(agent, optimiser, episodes, scale, args):
    rows, actions, before, values, rewards = episodes
    policy = agent.policy
    counts = can_act(policy.layout, rows).float()
    gain = advantages(rewards / scale(rewards), values, args)
    target = gain + values
    used = gain[counts > 0]
    gain = (gain - used.mean()) / (used.std() + 1e-8)
    labels = MemoryLoss.labels(policy, rows) if policy.predicts else ()
    for _ in range(args.passes):
        for pick in torch.randperm(rows.shape[1]).chunk(args.minibatches):
            distribution, value, recalled, _ = agent(rows[:, pick])
            weight = counts[:, pick] / counts[:, pick].sum()
            density = distribution.log_prob(actions[:, pick]).sum(-1)
            better = clipped_gain(density, before[:, pick], gain[:, pick], args.clip)
            error = 0.5 * (value - target[:, pick]).square()
            entropy = distribution.entropy().sum(-1)
            loss = ((error - better - args.entropy * entropy) * weight).sum()
            if policy.predicts:
                picked = [label[:, pick] for label in labels]
                loss = loss + args.recall * MemoryLoss.loss(policy, rows[:, pick], recalled, picked)
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
    scenes = ObjectsEnv(args.id, args.envs // processes, args.seed + 1000 * rank, **given)
    test = ObjectsEnv(args.id, 200, **given) if rank == 0 else None  # the first process evaluates
    agent = Agent(Policy(scenes.layout, memory=not args.no_memory))
    agent(scenes.reset(seed=args.seed + 1000 * rank)[None])  # the critic takes its size from this
    if args.resume and path.exists():
        agent.policy = load_policy(path)[0]
    else:
        agent.policy.fit(collect(agent, scenes)[0])
    data_parallel.broadcast(agent)
    critic = {"params": agent.critic.parameters(), "lr": args.lr}
    optimiser = torch.optim.Adam(
        [*groups(agent.policy, args.lr, args.memory_lr, args.perception_lr), critic]
    )
    log, scale, begun = Log(args.out if rank == 0 else None), Scale(args.gamma), time.monotonic()
    per_iteration = args.envs * scenes.horizon
    iterations = max(1, args.steps // per_iteration)
    for iteration in range(iterations):
        scale_lr(optimiser, 1 - iteration / iterations)
        learn(agent, optimiser, collect(agent, scenes), scale, args)
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
