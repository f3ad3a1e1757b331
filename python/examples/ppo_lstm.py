"""PPO with an LSTM in one file: learns an engram task whose cue has to be remembered.

    python ppo_lstm.py --id RememberColor3-VLA-v0 --seed 1 --out runs/lstm

Observations are objects (docs/observations.md): the robot, and a token for every object that the
cameras show. They do not contain what the cue showed, so a policy without memory guesses. The only
signal from outside is the reward. Needs torch beside engram; one core is enough. The folder `--out`
receives log.csv and agent.pt. docs/learning.md has results.
"""

from __future__ import annotations

import argparse
import csv
import math
import time
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import torch
from torch import Tensor, nn
from torch.distributions import Categorical, Normal

import engram

# Seeds of the episodes that measure progress, and of those behind the final figure.
PROGRESS_SEED = 1_000_000
FINAL_SEED = 2_000_000


def parse_arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description="Learns an engram task from objects with PPO and an LSTM.",
        formatter_class=argparse.ArgumentDefaultsHelpFormatter,
    )
    add = parser.add_argument
    add("--id", default="RememberColor3-VLA-v0", help="task")
    add("--seed", type=int, default=1, help="of episodes, networks and exploration")
    add("--total-timesteps", type=int, default=200_000, help="environment steps to learn from")
    add("--num-envs", type=int, default=64, help="environments stepped together")
    add("--out", type=Path, default=Path("ppo_lstm_run"), help="folder of log.csv and agent.pt")
    add("--eval-every", type=int, default=25, help="iterations between evaluations")
    add("--eval-episodes", type=int, default=200, help="episodes of an evaluation")
    add("--update-epochs", type=int, default=4, help="passes over the episodes of an iteration")
    add("--num-minibatches", type=int, default=2, help="gradient steps per pass")
    add("--learning-rate", type=float, default=1e-3, help="of Adam at the start; falls to zero")
    add("--memory-learning-rate", type=float, default=1e-2, help="of the LSTM, likewise")
    add("--gamma", type=float, default=0.9, help="discount per step")
    add("--gae-lambda", type=float, default=0.9, help="of generalised advantage estimation")
    add("--clip-coef", type=float, default=0.2, help="largest useful change of a probability ratio")
    add("--ent-coef", type=float, default=0.0, help="weight of the entropy")
    add("--vf-coef", type=float, default=0.5, help="weight of the value loss")
    add("--recall-coef", type=float, default=0.5, help="weight of the memory's own loss")
    add("--max-grad-norm", type=float, default=0.5, help="largest norm of a gradient")
    add("--width", type=int, default=64, help="of the LSTM and of the hidden layers")
    return parser.parse_args()


class Observation(NamedTuple):
    """The robot (..., R), and tokens of objects (..., K, W), which are zeros where none is seen."""

    robot: Tensor
    tokens: Tensor


class Layout:
    """Columns of robot and tokens, by the names of `obs_mode="objects_dict"`."""

    def __init__(self, env: engram.VectorEnv) -> None:
        space: Any = env.single_observation_space
        self.robot = columns(space["agent"])
        self.token = columns(space["objects"])
        self.robot_width = max(part.stop for part in self.robot.values())
        self.token_width = max(part.stop for part in self.token.values())
        self.appearance = self.token["color"].stop - self.token["color"].start
        self.appearance += self.token["shape"].stop - self.token["shape"].start

    def appearances(self, tokens: Tensor) -> Tensor:
        return torch.cat([tokens[..., self.token["color"]], tokens[..., self.token["shape"]]], -1)

    def to_top(self, observation: Observation) -> Tensor:
        """Vectors (..., K, 3) from the tool to the tops of the objects; zeros if not seen."""
        tokens = observation.tokens
        top = tokens[..., self.token["position"]].clone()
        top[..., 2] += 0.1 * tokens[..., self.token["size"]][..., 2]  # units of 0.05 m and 0.5 m
        tool = observation.robot[..., None, self.robot["tcp_pose"]][..., :3]
        return (top - tool) * tokens[..., self.token["seen"]]


def columns(space: Any) -> dict[str, slice]:
    result, begin = {}, 0
    for name, part in space.spaces.items():
        result[name] = slice(begin, begin + part.shape[-1])
        begin += part.shape[-1]
    return result


def to_tensors(observation: Any) -> Observation:
    """Copies: the arrays are views of engram's memory that the next step overwrites."""
    parts = (np.concatenate(list(observation[name].values()), -1) for name in ("agent", "objects"))
    return Observation(*map(torch.from_numpy, parts))


class ObjectThenAction:
    """Draws an object, then an action for it, (..., A + 1): the index of the object is last."""

    def __init__(self, logits: Tensor, mean: Tensor, log_std: Tensor) -> None:
        self.objects = Categorical(logits=logits, validate_args=False)
        self.mean, self.std = mean, log_std.exp()

    def action_for(self, index: Tensor) -> Normal:
        which = index[..., None, None]
        mean = self.mean.take_along_dim(which, -2).squeeze(-2)
        return Normal(mean, self.std.take_along_dim(which, -2).squeeze(-2), validate_args=False)

    def sample(self) -> Tensor:
        index = self.objects.sample()
        return torch.cat([self.action_for(index).sample(), index[..., None]], -1)

    def log_prob(self, sample: Tensor) -> Tensor:
        index = sample[..., -1].long()
        action = self.action_for(index).log_prob(sample[..., :-1]).sum(-1)
        return action + self.objects.log_prob(index)

    def entropy(self) -> Tensor:
        action = Normal(self.mean, self.std, validate_args=False).entropy().sum(-1)
        return self.objects.entropy() + (self.objects.probs * action).sum(-1)

    def best(self) -> Tensor:
        """The mean action for the most probable object."""
        return self.action_for(self.objects.probs.argmax(-1)).mean


State = tuple[Tensor, Tensor]


class Output(NamedTuple):
    """What the agent makes of a sequence, (T, N, ...), and the LSTM's state after it."""

    policy: ObjectThenAction
    value: Tensor
    cue: Tensor  # logits: which appearances the episode's first observation had
    lstm_state: State


class Agent(nn.Module):
    """Encodes objects as a set, remembers with an LSTM, attends to an object and acts on it."""

    def __init__(self, layout: Layout, action_dim: int, width: int) -> None:
        super().__init__()
        self.layout = layout
        self.encode = mlp(layout.token_width + 3, width, width)
        self.lstm = nn.LSTM(width + layout.appearance, width)
        self.cue = linear(width, layout.appearance)
        self.query = linear(2 * width + layout.appearance, width)
        self.key = linear(width, width)
        context = 2 * width + layout.robot_width
        self.actor = mlp(context + 6, width, 2 * action_dim, last_gain=0.01)
        self.critic = mlp(context + width + 7, width, 1)
        self.match = nn.Parameter(torch.tensor(2.0))
        self.action_dim = action_dim

    def forward(self, observation: Observation, lstm_state: State | None = None) -> Output:
        """Continues sequences (T, N, ...) from a state; None begins episodes."""
        robot, tokens = observation
        seen = tokens[..., self.layout.token["seen"]]
        to_top = self.layout.to_top(observation)
        encoded = self.encode(torch.cat([tokens, 5 * to_top], -1)) * seen
        appearances = self.layout.appearances(tokens)
        # Raw inputs beside encoded ones: the memory learns faster to store them.
        memory_input = torch.cat([encoded.sum(-2), 3.0 * appearances.sum(-2)], -1)
        remembered, lstm_state = self.lstm(memory_input, lstm_state)
        cue = self.cue(remembered)

        # Attention to objects. At the start an object that looks like the cue counts more.
        context = torch.cat([remembered, encoded.sum(-2)], -1)
        query = self.query(torch.cat([context, cue.detach().sigmoid()], -1))
        scores = (self.key(encoded) * query[..., None, :]).sum(-1) / math.sqrt(query.shape[-1])
        likeness = (appearances * cue.detach().sigmoid()[..., None, :]).sum(-1, keepdim=True)
        scores = scores + self.match * likeness.squeeze(-1)
        logits = scores.masked_fill(seen.squeeze(-1) == 0, -1e4)

        # An action for each object. At the start it leads to the object's top.
        context = torch.cat([context, robot], -1)
        by_object = torch.cat([to_top, (20 * to_top).tanh()], -1)
        spread = context[..., None, :].expand(*by_object.shape[:-1], -1)
        mean, log_std = self.actor(torch.cat([spread, by_object], -1)).chunk(2, -1)
        towards = (5 * to_top).clamp(-1.0, 1.0)
        mean = mean + nn.functional.pad(towards, (0, self.action_dim - 3))
        policy = ObjectThenAction(logits, mean, (log_std - 1.0).clamp(-5.0, 0.0))

        attended = torch.cat([encoded, by_object, likeness], -1)
        attended = (logits.softmax(-1)[..., None] * attended).sum(-2)
        value = self.critic(torch.cat([context, attended], -1)).squeeze(-1)
        return Output(policy, value, cue, lstm_state)


def linear(inputs: int, outputs: int, gain: float = 1.0) -> nn.Linear:
    layer = nn.Linear(inputs, outputs)
    nn.init.orthogonal_(layer.weight, gain)
    nn.init.zeros_(layer.bias)
    return layer


def mlp(inputs: int, width: int, outputs: int, last_gain: float = 1.0) -> nn.Sequential:
    return nn.Sequential(
        linear(inputs, width, math.sqrt(2.0)), nn.Tanh(), linear(width, outputs, last_gain)
    )


class Rollout(NamedTuple):
    """An episode of each environment: tensors are (steps, environments, ...)."""

    observations: Observation
    actions: Tensor
    log_probs: Tensor
    values: Tensor
    rewards: Tensor
    success: float


@torch.no_grad()
def collect(agent: Agent, env: engram.VectorEnv, num_steps: int) -> Rollout:
    steps, lstm_state = [], None
    observation = to_tensors(env.reset()[0])
    for _ in range(num_steps):
        sequence = Observation(*(part[None] for part in observation))
        output = agent(sequence, lstm_state)
        lstm_state = output.lstm_state
        sample = output.policy.sample()
        log_prob = output.policy.log_prob(sample)
        actions = sample[0, :, :-1].clamp(-1.0, 1.0).numpy()
        next_observation, reward, _, _, info = env.step(actions)
        reward = torch.tensor(reward)
        steps.append((*observation, sample[0], log_prob[0], output.value[0], reward))
        observation = to_tensors(next_observation)
    robot, tokens, *others = (torch.stack(column) for column in zip(*steps))
    success = float(info["success_once"].mean())
    return Rollout(Observation(robot, tokens), *others, success=success)


class RewardScale:
    """Divides rewards by the running standard deviation of the discounted return."""

    def __init__(self, gamma: float) -> None:
        self.gamma, self.count, self.sum, self.squares = gamma, 0, 0.0, 0.0

    def __call__(self, rewards: Tensor) -> Tensor:
        following = torch.zeros_like(rewards[0])
        for reward in rewards.flip(0):
            following = reward + self.gamma * following
            self.count += following.numel()
            self.sum += following.sum().item()
            self.squares += following.square().sum().item()
        variance = self.squares / self.count - (self.sum / self.count) ** 2
        return rewards / max(variance, 1e-8) ** 0.5


def estimate_advantages(rewards: Tensor, values: Tensor, gamma: float, gae_lambda: float) -> Tensor:
    """Generalised advantage estimation (Schulman et al., 2016) of episodes that end together."""
    advantages = torch.zeros_like(rewards)
    next_value = last_advantage = torch.zeros_like(rewards[0])
    for t in reversed(range(len(rewards))):
        delta = rewards[t] + gamma * next_value - values[t]
        advantages[t] = last_advantage = delta + gamma * gae_lambda * last_advantage
        next_value = values[t]
    return advantages


def update(
    agent: Agent,
    optimizer: torch.optim.Optimizer,
    rollout: Rollout,
    rewards: Tensor,
    args: argparse.Namespace,
) -> dict[str, float]:
    """One iteration's gradient steps (Schulman et al., 2017); returns what the log shows.

    Minibatches are whole episodes, so that the gradient goes through all steps of the LSTM.
    """
    advantages = estimate_advantages(rewards, rollout.values, args.gamma, args.gae_lambda)
    returns = advantages + rollout.values
    # The memory's own loss: what did the first observation show? It needs no label from outside.
    cue = agent.layout.appearances(rollout.observations.tokens[:1]).amax(-2)
    figures = []
    for _ in range(args.update_epochs):
        for envs in torch.randperm(rewards.shape[1]).chunk(args.num_minibatches):
            output = agent(Observation(*(part[:, envs] for part in rollout.observations)))
            log_ratio = output.policy.log_prob(rollout.actions[:, envs])
            log_ratio = log_ratio - rollout.log_probs[:, envs]
            ratio = log_ratio.exp()
            advantage = advantages[:, envs]
            advantage = (advantage - advantage.mean()) / (advantage.std() + 1e-8)
            clipped = ratio.clamp(1.0 - args.clip_coef, 1.0 + args.clip_coef)
            policy_loss = -torch.minimum(ratio * advantage, clipped * advantage).mean()
            value_loss = 0.5 * (output.value - returns[:, envs]).square().mean()
            entropy = output.policy.entropy().mean()
            recall_loss = nn.functional.binary_cross_entropy_with_logits(
                output.cue, cue[:, envs].expand_as(output.cue), reduction="none"
            )
            recall_loss = recall_loss.sum(-1).mean()
            loss = policy_loss + args.vf_coef * value_loss - args.ent_coef * entropy
            optimizer.zero_grad()
            (loss + args.recall_coef * recall_loss).backward()
            nn.utils.clip_grad_norm_(agent.parameters(), args.max_grad_norm)
            optimizer.step()
            approx_kl = (ratio - 1.0 - log_ratio).mean()
            losses = policy_loss, value_loss, recall_loss, entropy, approx_kl
            figures.append(torch.stack(losses).detach())
    names = ("policy_loss", "value_loss", "recall_loss", "entropy", "approx_kl")
    return dict(zip(names, torch.stack(figures).mean(0).tolist()))


@torch.no_grad()
def evaluate(
    agent: Agent, env: engram.VectorEnv, num_steps: int, seed: int, forget: bool = False
) -> float:
    """Share of successful episodes, one per environment, of the policy's best action.

    forget: the LSTM begins anew with every step, as a control: what is left is a guess.
    """
    lstm_state = None
    observation = to_tensors(env.reset(seed=seed)[0])
    for _ in range(num_steps):
        sequence = Observation(*(part[None] for part in observation))
        output = agent(sequence, None if forget else lstm_state)
        lstm_state = output.lstm_state
        actions = output.policy.best()[0].clamp(-1.0, 1.0).numpy()
        next_observation, _, _, _, info = env.step(actions)
        observation = to_tensors(next_observation)
    return float(info["success_once"].mean())


def make_env(args: argparse.Namespace, num_envs: int) -> engram.VectorEnv:
    """Environments whose episodes all run to the horizon, and are reset together."""
    return engram.make_vec(
        args.id,
        num_envs=num_envs,
        seed=args.seed,
        threads=1,
        obs_mode="objects_dict",
        reward_mode="normalized_dense",
        autoreset_mode="DISABLED",
        after_end="hold",
        terminate_on_success=False,
    )


def train(args: argparse.Namespace) -> list[dict[str, float]]:
    """Learns, and writes all files; returns the rows of the log."""
    torch.manual_seed(args.seed)
    torch.set_num_threads(1)  # the networks are too small for several
    env, eval_env = make_env(args, args.num_envs), make_env(args, args.eval_episodes)
    num_steps = env.description["horizon"]
    agent = Agent(Layout(env), env.description["action_dim"], args.width)
    memory = [*agent.lstm.parameters(), *agent.cue.parameters()]
    others = [p for p in agent.parameters() if all(p is not one for one in memory)]
    rates = (args.memory_learning_rate, args.learning_rate)
    groups = [{"params": part, "lr": rate} for part, rate in zip((memory, others), rates)]
    optimizer = torch.optim.Adam(groups, eps=1e-5)
    scale = RewardScale(args.gamma)
    env.reset(seed=engram.worker_seed(args.seed, 0))

    per_iteration = num_steps * args.num_envs
    num_iterations = max(1, args.total_timesteps // per_iteration)
    log: list[dict[str, float]] = []
    for iteration in range(1, num_iterations + 1):
        fraction = 1.0 - (iteration - 1) / num_iterations
        for group, rate in zip(optimizer.param_groups, rates):
            group["lr"] = rate * fraction
        rollout = collect(agent, env, num_steps)
        figures = update(agent, optimizer, rollout, scale(rollout.rewards), args)
        row = {
            "iteration": iteration,
            "steps": iteration * per_iteration,
            "cpu_seconds": time.process_time(),
            "success_once": rollout.success,
            "eval_success_once": math.nan,
            **figures,
        }
        if iteration % args.eval_every == 0:
            row["eval_success_once"] = evaluate(agent, eval_env, num_steps, PROGRESS_SEED)
            print(
                f"{row['steps']:>9,} steps {row['cpu_seconds']:6.1f} s  success_once: exploring "
                f"{rollout.success:.3f}, evaluated {row['eval_success_once']:.3f}",
                flush=True,
            )
        log.append(row)
    write_log(log, args.out / "log.csv")
    torch.save(agent.state_dict(), args.out / "agent.pt")
    success = evaluate(agent, eval_env, num_steps, FINAL_SEED)
    without = evaluate(agent, eval_env, num_steps, FINAL_SEED, forget=True)
    print(
        f"{args.id}, seed {args.seed}: success_once {success:.3f}, without memory {without:.3f}, "
        f"of {args.eval_episodes} fresh episodes; {time.process_time():.1f} s of processor time"
    )
    return log


def write_log(log: list[dict[str, float]], path: Path) -> None:
    with path.open("w", newline="") as file:
        writer = csv.DictWriter(file, log[0].keys())
        writer.writeheader()
        writer.writerows(log)


def main() -> None:
    args = parse_arguments()
    args.out.mkdir(parents=True, exist_ok=True)
    train(args)


if __name__ == "__main__":
    main()
