"""PPO in one file, in the manner of CleanRL: tensors that the loop itself fills, step by step.

It knows Gymnasium's interface only, and is what people start from who write their own learners.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import torch
from torch import nn
from torch.distributions import Normal

GAMMA, LAMBDA, CLIP, EPOCHS, MINIBATCHES = 0.9, 0.9, 0.2, 4, 4


class Agent(nn.Module):
    def __init__(self, envs: Any) -> None:
        super().__init__()
        size = int(np.prod(envs.single_observation_space.shape))
        actions = int(np.prod(envs.single_action_space.shape))
        self.critic = nn.Sequential(nn.Linear(size, 64), nn.Tanh(), nn.Linear(64, 1))
        self.mean = nn.Sequential(nn.Linear(size, 64), nn.Tanh(), nn.Linear(64, actions))
        self.logstd = nn.Parameter(torch.full((1, actions), -0.5))

    def act(self, obs: torch.Tensor, action: torch.Tensor | None = None) -> tuple[Any, ...]:
        policy = Normal(self.mean(obs), self.logstd.exp())
        action = policy.sample() if action is None else action
        return action, policy.log_prob(action).sum(1), self.critic(obs).flatten()


def train(envs: Any, steps: int, seed: int) -> dict[str, Any]:
    """Plays and learns once; returns what was stored, returns of episodes, and losses."""
    torch.manual_seed(seed)
    agent = Agent(envs)
    optimizer = torch.optim.Adam(agent.parameters(), lr=1e-3, eps=1e-5)
    count = envs.num_envs
    obs = torch.zeros((steps, count, *envs.single_observation_space.shape))
    actions = torch.zeros((steps, count, *envs.single_action_space.shape))
    logprobs, rewards, dones, values = (torch.zeros((steps, count)) for _ in range(4))
    episodes: list[float] = []

    next_obs, _ = envs.reset(seed=seed)
    next_obs, next_done = torch.Tensor(next_obs), torch.zeros(count)
    for step in range(steps):
        obs[step], dones[step] = next_obs, next_done
        with torch.no_grad():
            actions[step], logprobs[step], values[step] = agent.act(next_obs)
        next_obs, reward, terminated, truncated, infos = envs.step(actions[step].numpy())
        rewards[step] = torch.as_tensor(reward)
        next_done = torch.Tensor(np.logical_or(terminated, truncated))
        next_obs = torch.Tensor(next_obs)
        if "episode" in infos:  # RecordEpisodeStatistics
            episodes += np.asarray(infos["episode"]["r"])[infos["_episode"]].tolist()
    losses = learn(
        agent, optimizer, obs, actions, logprobs, rewards, dones, values, next_obs, next_done
    )
    stored = {"obs": obs, "actions": actions, "rewards": rewards}
    return {**stored, "episodes": episodes, "losses": losses}


def learn(agent, optimizer, obs, actions, logprobs, rewards, dones, values, next_obs, next_done):
    """Generalised advantages, then clipped updates; returns the losses."""
    with torch.no_grad():
        following, last = agent.critic(next_obs).flatten(), torch.zeros_like(next_done)
        advantages = torch.zeros_like(rewards)
        for t in reversed(range(len(rewards))):
            going_on = 1 - (next_done if t + 1 == len(rewards) else dones[t + 1])
            delta = rewards[t] + GAMMA * following * going_on - values[t]
            advantages[t] = last = delta + GAMMA * LAMBDA * going_on * last
            following = values[t]
    returns = (advantages + values).flatten()
    losses = []
    flat = [tensor.flatten(0, 1) for tensor in (obs, actions, logprobs, advantages)]
    for _ in range(EPOCHS):
        for rows in torch.randperm(len(returns)).chunk(MINIBATCHES):
            seen, done, old, advantage = (tensor[rows] for tensor in flat)
            advantage = (advantage - advantage.mean()) / (advantage.std() + 1e-8)
            _, new, value = agent.act(seen, done)
            ratio = (new - old).exp()
            gain = torch.min(ratio * advantage, ratio.clamp(1 - CLIP, 1 + CLIP) * advantage)
            loss = 0.5 * (value - returns[rows]).square().mean() - gain.mean()
            optimizer.zero_grad()
            loss.backward()
            nn.utils.clip_grad_norm_(agent.parameters(), 0.5)
            optimizer.step()
            losses.append(loss.item())
    return losses
