"""A policy of the original's form that solves a short task: shown by the oracle, then PPO."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import torch

import engram.mikasa as mikasa

_ENVS = 64


def _batch(id: str) -> Any:
    env = gym.make(id, num_envs=_ENVS, obs_mode="state", control_mode="pd_ee_delta_pose", threads=2)
    env = mikasa.StateOnlyTensorToDictWrapper(env)
    env = mikasa.CurriculumPhaseNoopActionWrapper(env)
    env = mikasa.FlattenRGBDObservationWrapper(env, rgb=False, depth=False)
    return mikasa.ManiSkillVectorEnv(env, ignore_terminations=True, record_metrics=True)


def trained(id: str) -> mikasa.AgentStateOnly:
    """An agent that succeeds in nearly every episode."""
    torch.manual_seed(0)
    threads = torch.get_num_threads()
    torch.set_num_threads(1)  # the networks are too small to share
    envs = _batch(id)
    agent = mikasa.AgentStateOnly(envs)
    _imitate(envs, agent, id)
    _improve(envs, agent)
    envs.close()
    torch.set_num_threads(threads)
    return agent


def _imitate(envs: Any, agent: Any, id: str, rounds: int = 12) -> None:
    """The oracle says what it would do where the agent goes."""
    optimizer = torch.optim.Adam(agent.parameters(), lr=1e-3)
    oracle: Any = envs.base_env._env
    states, answers = [], []
    for turn in range(rounds):
        obs, _ = envs.reset(seed=turn * _ENVS + 1_000_000)
        for _ in range(envs.max_episode_steps - 1):
            states.append(obs["state"])
            answers.append(torch.from_numpy(oracle.act("oracle")).clamp(-1, 1))
            with torch.no_grad():
                action = agent.get_action(obs, deterministic=True)
            led = (torch.rand(_ENVS, 1) < 1 - turn / 4).float()
            obs, *_ = envs.step(led * answers[-1] + (1 - led) * action)
        seen, said = torch.cat(states), torch.cat(answers)
        for _ in range(150):
            rows = torch.randint(len(seen), (512,))
            loss = (agent.get_action({"state": seen[rows]}, True) - said[rows]).square().mean()
            optimizer.zero_grad()
            loss.backward()
            optimizer.step()


def _improve(envs: Any, agent: Any, iterations: int = 2, steps: int = 25) -> None:
    """A few iterations of PPO with small steps, as the original's baseline computes them."""
    with torch.no_grad():
        agent.actor_logstd.fill_(-3.0)
    optimizer = torch.optim.Adam(agent.parameters(), lr=1e-5)
    obs, _ = envs.reset(seed=7)
    for _ in range(iterations):
        stored: dict[str, list[Any]] = {k: [] for k in ("obs", "action", "logp", "value", "reward")}
        for _ in range(steps):
            with torch.no_grad():
                action, logp, _, value = agent.get_action_and_value(obs)
            stored["obs"].append(obs["state"])
            obs, reward, *_ = envs.step(action)
            for name, one in (
                ("action", action), ("logp", logp), ("value", value[:, 0]), ("reward", reward),
            ):  # fmt: skip
                stored[name].append(one)
        returns, total = [], torch.zeros(_ENVS)
        for reward in reversed(stored["reward"]):  # all episodes end with the rollout
            total = reward + 0.99 * total
            returns.insert(0, total)
        flat = {name: torch.cat(values) for name, values in stored.items()}
        target = torch.cat(returns)
        gain = target - flat["value"]
        gain = (gain - gain.mean()) / (gain.std() + 1e-8)
        for rows in torch.randperm(len(target)).chunk(8):
            batch = {"state": flat["obs"][rows]}
            _, logp, _, value = agent.get_action_and_value(batch, flat["action"][rows])
            ratio = (logp - flat["logp"][rows]).exp()
            gained = torch.min(ratio * gain[rows], ratio.clamp(0.8, 1.2) * gain[rows]).mean()
            loss = 0.5 * (value[:, 0] - target[rows]).square().mean() - gained
            optimizer.zero_grad()
            loss.backward()
            torch.nn.utils.clip_grad_norm_(agent.parameters(), 0.5)
            optimizer.step()
