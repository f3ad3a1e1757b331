"""PPO with one of nine memories on tasks of POPGym: what is known of memories, with these.

POPGym's RepeatPrevious and Autoencode ask for nothing but memory: four suits are seen, and four
actions name one. All episodes of a task are equally long, so that they run in lockstep; a return is
between -1 and 1. The policy gets the observation and its last action, as POPGym's own baselines do.

    pip install popgym==1.0.7
    python -m engram_learners.zoo.popgym --memory gru --id RepeatPreviousEasy --out runs/repeat
"""

import argparse
from pathlib import Path

import numpy as np
import popgym.envs
import torch
from gymnasium.spaces import flatdim, flatten
from torch import nn

from engram_learners import memories, ppo_recurrent
from engram_learners.policy import mlp
from engram_learners.ppo_recurrent import (
    RewardScale,
    Rollout,
    clipped_surrogate,
    estimate_advantages,
)
from engram_learners.run_log import Clock, Log, write_result
from engram_learners.training import EVALUATION_SEED, FINAL_SEED, scale_lr

TASKS = {task.__name__: task for task in popgym.envs.ALL}


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    add = parser.add_argument
    add("--memory", default="gru", choices=list(memories.MEMORIES))
    names = [name for name in TASKS if name.startswith(("RepeatPrevious", "Autoencode"))]
    add("--id", default="RepeatPreviousEasy", choices=names)
    add("--seed", type=int, default=1)
    add("--out", type=Path, help="folder for log.csv, result.json")
    add("--parameters", type=int, default=memories.PARAMETERS, help="of the memory")
    own = {"gamma": 0.99, "gae": 0.95, "entropy": 0.01, "evaluate_every": 60}
    ppo_recurrent.add_to(parser, steps=400_000, update_epochs=4, minibatches=4, **own)
    return parser.parse_args()


class Episodes:
    """Environments of one task in lockstep; observations are rows of zeros and ones (N, D)."""

    def __init__(self, task, num_envs):
        self.envs = [TASKS[task]() for _ in range(num_envs)]
        self.space, self.actions = self.envs[0].observation_space, self.envs[0].action_space.n
        self.width = flatdim(self.space) + self.actions

    def rows(self, observations, actions):
        flat = np.stack([flatten(self.space, one) for one in observations])
        last = np.zeros((len(flat), self.actions))
        if actions is not None:
            last[np.arange(len(flat)), actions] = 1
        return torch.from_numpy(np.concatenate([flat, last], 1)).float()

    def reset(self, seed=None):
        """seed: of the first environment; None: each goes on with its own random numbers."""
        seeds = [None if seed is None else seed + i for i in range(len(self.envs))]
        return self.rows([e.reset(seed=own)[0] for e, own in zip(self.envs, seeds)], None)

    def step(self, actions):
        """-> rows (N, D), rewards (N,), whether the episodes have ended."""
        actions = actions.tolist()
        observations, rewards, ends, _, _ = zip(*(e.step(a) for e, a in zip(self.envs, actions)))
        if len(set(ends)) > 1:
            raise RuntimeError("episodes of different lengths; equal lengths needed")
        return self.rows(observations, actions), torch.tensor(rewards).float(), ends[0]


class Agent(nn.Module):
    """Actor and critic: both read the memory's input beside its output."""

    def __init__(self, inputs, actions, kind, size, width=memories.WIDTH):
        super().__init__()
        self.encode = nn.Sequential(nn.Linear(inputs, width), nn.Tanh(), nn.LayerNorm(width))
        self.remember = memories.make(kind, width, size)
        self.norm_remembered = nn.LayerNorm(width)
        self.actor = mlp(2 * width, width, actions, gain=0.01)
        self.critic = mlp(2 * width, width, 1, gain=1.0)

    def forward(self, rows, state=None):
        """Rows (T, N, D) -> distribution of the actions, values (T, N), the memory's state."""
        entry = self.encode(rows)
        remembered, state = self.remember(entry, state)
        known = torch.cat([entry, self.norm_remembered(remembered)], -1)
        actions = torch.distributions.Categorical(logits=self.actor(known))
        return actions, self.critic(known)[..., 0], state


@torch.no_grad()
def play(agent, episodes, seed=None, greedy=False):
    """Whole episodes -> Rollout."""
    steps, state, ended = [], None, False
    row = episodes.reset(seed)
    while not ended:
        distribution, value, state = agent(row[None], state)
        action = distribution.probs.argmax(-1) if greedy else distribution.sample()
        log_prob = distribution.log_prob(action)
        next_row, reward, ended = episodes.step(action[0])
        steps.append((row, action[0], log_prob[0], value[0], reward))
        row = next_row
    return Rollout(*(torch.stack(column) for column in zip(*steps)))


def learn(agent, optimiser, played, scale, args):
    rows, actions, old_log_probs, values, rewards = played
    advantages = estimate_advantages(rewards / scale(rewards), values, args)
    returns = advantages + values
    advantages = (advantages - advantages.mean()) / (advantages.std() + 1e-8)
    for _ in range(args.update_epochs):
        for pick in torch.randperm(rows.shape[1]).chunk(args.minibatches):
            distribution, value, _ = agent(rows[:, pick])
            log_prob = distribution.log_prob(actions[:, pick])
            before, advantage = old_log_probs[:, pick], advantages[:, pick]
            surrogate = clipped_surrogate(log_prob, before, advantage, args.clip).mean()
            value_loss = 0.5 * (value - returns[:, pick]).square().mean()
            loss = value_loss - surrogate - args.entropy * distribution.entropy().mean()
            optimiser.zero_grad()
            loss.backward()
            nn.utils.clip_grad_norm_(agent.parameters(), 0.5)
            optimiser.step()


def mean_return(agent, episodes, seed):
    return play(agent, episodes, seed, greedy=True).rewards.sum(0).mean().item()


def main():
    args = arguments()
    torch.manual_seed(args.seed)
    torch.set_num_threads(1)
    clock = Clock()
    episodes, test = Episodes(args.id, args.envs), Episodes(args.id, 200)
    size = memories.size_for(args.memory, budget=args.parameters)
    agent = Agent(episodes.width, episodes.actions, args.memory, size)
    optimiser = torch.optim.Adam(agent.parameters(), args.lr)
    log, scale, best = Log(args.out), RewardScale(args.gamma), -1.0
    played = play(agent, episodes, seed=args.seed * 10_000)
    per_iteration = played.rows.shape[0] * args.envs
    iterations = max(1, args.steps // per_iteration)
    for iteration in range(iterations):
        scale_lr(optimiser, 1 - iteration / iterations)
        learn(agent, optimiser, played, scale, args)
        steps = (iteration + 1) * per_iteration
        if (iteration + 1) % args.evaluate_every == 0 or iteration + 1 == iterations:
            reached = clock.exclude(mean_return, agent, test, EVALUATION_SEED)
            best = max(best, reached)
            log.add(env_steps=steps, cpu_s=round(clock(), 1), mean_return=round(reached, 4))
        if iteration + 1 < iterations:
            played = play(agent, episodes)
    cpu_s = clock()
    result = {
        "id": args.id,
        "memory": args.memory,
        "seed": args.seed,
        "parameters": memories.parameters(agent.remember),
        "env_steps": steps,
        "cpu_s": round(cpu_s, 1),
        "cpu_s_per_million_steps": round(1e6 * cpu_s / steps),
        "mean_return": mean_return(agent, test, FINAL_SEED),
        "best_mean_return": best,
    }
    write_result(result, args.out)


if __name__ == "__main__":
    main()
