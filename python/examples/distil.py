"""Distils engram's oracle into a GRU in one file: imitation of an expert that needs no memory.

    python distil.py --id RememberColor9-VLA-v0 --seed 1 --out runs/color9

The student observes objects (docs/observations.md), which do not contain what the cue showed. It
acts itself, and the oracle, which uses privileged state, labels every state that it visits with its
own action (DAgger, Ross et al., 2011). Nothing but those labels is privileged. Needs torch beside
engram; one core is enough. The folder `--out` receives log.csv and agent.pt. docs/learning.md has
results.
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

import engram

# Seeds of the episodes that measure progress, and of those behind the final figure.
PROGRESS_SEED = 1_000_000
FINAL_SEED = 2_000_000


def parse_arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description="Distils engram's oracle into a policy with a GRU, from objects.",
        formatter_class=argparse.ArgumentDefaultsHelpFormatter,
    )
    add = parser.add_argument
    add("--id", default="RememberColor3-VLA-v0", help="task")
    add("--seed", type=int, default=1, help="of episodes, networks and batches")
    add("--num-iterations", type=int, default=8, help="collections of new episodes")
    add("--num-envs", type=int, default=128, help="episodes of an iteration")
    add("--out", type=Path, default=Path("distil_run"), help="folder of log.csv and agent.pt")
    add("--eval-every", type=int, default=2, help="iterations between evaluations")
    add("--eval-episodes", type=int, default=200, help="episodes of an evaluation")
    add("--num-updates", type=int, default=64, help="gradient steps of an iteration")
    add("--minibatch-size", type=int, default=1200, help="environment steps of a gradient step")
    add("--learning-rate", type=float, default=3e-3, help="of Adam; falls to zero in the end")
    add("--memory-learning-rate", type=float, default=1e-2, help="of the GRU, likewise")
    add("--recall-coef", type=float, default=1.0, help="weight of the memory's own loss")
    add("--max-grad-norm", type=float, default=1.0, help="largest norm of a gradient")
    add("--width", type=int, default=64, help="of the GRU and of the hidden layers")
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
        self.appearance = sum(space["objects"][name].shape[-1] for name in ("color", "shape"))

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
    parts = [np.concatenate(list(observation[name].values()), -1) for name in ("agent", "objects")]
    return Observation(*map(torch.from_numpy, parts))


class Output(NamedTuple):
    """What the agent makes of a sequence (T, N, ...), and the GRU's state after it."""

    log_weights: Tensor  # of the objects
    actions: Tensor  # for each object
    cue: Tensor  # logits: which appearances the episode's first observation had
    gru_state: Tensor

    def best(self) -> Tensor:
        """The action for the object of most weight."""
        which = self.log_weights.argmax(-1)[..., None, None]
        return self.actions.take_along_dim(which, -2).squeeze(-2).clamp(-1.0, 1.0)


class Agent(nn.Module):
    """Encodes objects as a set, remembers with a GRU, attends to an object and acts on it."""

    mean: Tensor
    std: Tensor

    def __init__(self, layout: Layout, action_dim: int, width: int) -> None:
        super().__init__()
        self.layout, self.action_dim = layout, action_dim
        self.register_buffer("mean", torch.zeros(layout.robot_width))
        self.register_buffer("std", torch.ones(layout.robot_width))
        self.encode = mlp(layout.token_width + 3, width, width)
        self.gru = nn.GRU(width + layout.appearance, width)
        self.cue = nn.Linear(width, layout.appearance)
        self.query = nn.Linear(2 * width + layout.appearance, width)
        self.key = nn.Linear(width, width)
        action_inputs = 2 * width + layout.robot_width + 6 + layout.token_width
        self.actor = mlp(action_inputs, width, action_dim, last_gain=0.01)
        self.match = nn.Parameter(torch.tensor(2.0))

    def forward(self, observation: Observation, gru_state: Tensor | None = None) -> Output:
        """Continues sequences (T, N, ...) from a state; None begins episodes."""
        robot, tokens = observation
        seen = tokens[..., self.layout.token["seen"]]
        to_top = self.layout.to_top(observation)
        encoded = self.encode(torch.cat([tokens, 5 * to_top], -1)) * seen
        appearances = self.layout.appearances(tokens)
        # Raw inputs beside encoded ones: the memory learns faster to store them.
        memory_input = torch.cat([encoded.sum(-2), 3.0 * appearances.sum(-2)], -1)
        remembered, gru_state = self.gru(memory_input, gru_state)
        cue = self.cue(remembered)

        # Attention to objects. At the start an object that looks like the cue counts more.
        shown = cue.detach().sigmoid()
        context = torch.cat([remembered, encoded.sum(-2)], -1)
        query = self.query(torch.cat([context, shown], -1))
        scores = (self.key(encoded) * query[..., None, :]).sum(-1) / math.sqrt(query.shape[-1])
        scores = scores + self.match * (appearances * shown[..., None, :]).sum(-1)
        log_weights = scores.masked_fill(seen.squeeze(-1) == 0, -1e4).log_softmax(-1)

        # The action for an object depends on where it is, not on how it looks: one function serves
        # all. At the start it leads to the object's top.
        body = tokens.clone()
        body[..., self.layout.token["color"]] = 0.0
        body[..., self.layout.token["shape"]] = 0.0
        robot = ((robot - self.mean) / self.std).clamp(-5.0, 5.0)
        context = torch.cat([context, robot], -1)[..., None, :]
        context = context.expand(*tokens.shape[:-1], -1)
        inputs = torch.cat([context, 5 * to_top, (20 * to_top).tanh(), body], -1)
        towards = (5 * to_top).clamp(-1.0, 1.0)
        actions = self.actor(inputs) + nn.functional.pad(towards, (0, self.action_dim - 3))
        return Output(log_weights, actions, cue, gru_state)

    def normalise(self, robot: Tensor) -> None:
        """Sets the normalisation of the robot's numbers from these (T, N, R)."""
        self.mean.copy_(robot.mean((0, 1)))
        self.std.copy_(robot.std((0, 1)) + 1e-2)


def mlp(inputs: int, width: int, outputs: int, last_gain: float = 1.0) -> nn.Sequential:
    def linear(size_in: int, size_out: int, gain: float) -> nn.Linear:
        layer = nn.Linear(size_in, size_out)
        nn.init.orthogonal_(layer.weight, gain)
        nn.init.zeros_(layer.bias)
        return layer

    first = linear(inputs, width, math.sqrt(2.0))
    return nn.Sequential(first, nn.Tanh(), linear(width, outputs, last_gain))


class Episodes(NamedTuple):
    """Observations of whole episodes, and the oracle's actions: (steps, episodes, ...)."""

    robot: Tensor
    tokens: Tensor
    labels: Tensor


@torch.no_grad()
def collect(agent: Agent, env: engram.VectorEnv, num_steps: int, first: bool) -> Episodes:
    """An episode of each environment. In the first iteration the oracle acts.

    Later it acts in half of the episodes up to a random step: so there are late states to learn
    from, even while the student fails early.
    """
    guided, until = torch.rand(2, env.num_envs)
    until = torch.full_like(until, num_steps) if first else num_steps * until * (guided < 0.5)
    observation, gru_state, steps = to_tensors(env.reset()[0]), None, []
    for t in range(num_steps):
        output = agent(Observation(*(part[None] for part in observation)), gru_state)
        gru_state = output.gru_state
        labels = torch.tensor(env.act("oracle")).clamp(-1.0, 1.0)
        steps.append((*observation, labels))
        actions = torch.where(t < until[:, None], labels, output.best()[0])
        observation = to_tensors(env.step(actions.numpy())[0])
    return Episodes(*(torch.stack(column) for column in zip(*steps)))


def imitation_loss(output: Output, labels: Tensor, doubt: float = 0.1) -> Tensor:
    """Distance (T, N) of the actions from the oracle's: a soft minimum over objects.

    The attention learns which object the oracle means, and actions are not averaged over objects.
    """
    labels = labels[..., None, :].expand_as(output.actions)
    # The oracle's actions are limited: where one is at its limit, a larger one is as good.
    limited = (labels.abs() >= 1.0) & (output.actions * labels.sign() > 1.0)
    actions = torch.where(limited, labels, output.actions)
    error = nn.functional.smooth_l1_loss(actions, labels, reduction="none", beta=0.3).sum(-1)
    return -doubt * torch.logsumexp(output.log_weights - error / doubt, -1)


def update(
    agent: Agent, optimizer: torch.optim.Optimizer, data: Episodes, args: argparse.Namespace
) -> float:
    """One iteration's gradient steps, on episodes of all iterations; returns the mean loss."""
    num_steps, num_episodes = data.labels.shape[:2]
    # Steps without motion have less weight: they are frequent and easy.
    weights = torch.where(data.labels[..., :-1].abs().amax(-1) > 0.0, 1.0, 0.1)
    losses = []
    for _ in range(args.num_updates):
        pick = torch.randint(num_episodes, (max(1, args.minibatch_size // num_steps),))
        output = agent(Observation(data.robot[:, pick], data.tokens[:, pick]))
        loss = imitation_loss(output, data.labels[:, pick])
        loss = (loss * weights[:, pick]).sum() / weights[:, pick].sum()
        # The memory's own loss: what did the first observation show? It needs no other label.
        cue = agent.layout.appearances(data.tokens[:1, pick]).amax(-2).expand_as(output.cue)
        recall_loss = nn.functional.binary_cross_entropy_with_logits(
            output.cue, cue, reduction="none"
        )
        optimizer.zero_grad()
        (loss + args.recall_coef * recall_loss.sum(-1).mean()).backward()
        nn.utils.clip_grad_norm_(agent.parameters(), args.max_grad_norm)
        optimizer.step()
        losses.append(loss.item())
    return sum(losses) / len(losses)


@torch.no_grad()
def evaluate(
    agent: Agent, env: engram.VectorEnv, num_steps: int, seed: int, forget: bool = False
) -> float:
    """Share of successful episodes, one per environment.

    forget: the GRU begins anew with every step, as a control: what is left is a guess.
    """
    observation, gru_state = to_tensors(env.reset(seed=seed)[0]), None
    for _ in range(num_steps):
        sequence = Observation(*(part[None] for part in observation))
        output = agent(sequence, None if forget else gru_state)
        gru_state = output.gru_state
        next_observation, _, _, _, info = env.step(output.best()[0].numpy())
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
    memory = [*agent.gru.parameters(), *agent.cue.parameters()]
    others = [p for p in agent.parameters() if all(p is not one for one in memory)]
    rates = (args.memory_learning_rate, args.learning_rate)
    groups = [{"params": part, "lr": rate} for part, rate in zip((memory, others), rates)]
    optimizer = torch.optim.Adam(groups)
    env.reset(seed=engram.worker_seed(args.seed, 0))

    episodes: list[Episodes] = []
    log: list[dict[str, float]] = []
    for iteration in range(1, args.num_iterations + 1):
        episodes.append(collect(agent, env, num_steps, first=iteration == 1))
        if iteration == 1:
            agent.normalise(episodes[0].robot)
        data = Episodes(*(torch.cat(parts, 1) for parts in zip(*episodes)))
        fraction = 2.0 - 2.0 * (iteration - 1) / args.num_iterations
        for group, rate in zip(optimizer.param_groups, rates):
            group["lr"] = rate * min(1.0, fraction)
        row = {
            "iteration": iteration,
            "steps": iteration * args.num_envs * num_steps,
            "loss": update(agent, optimizer, data, args),
            "cpu_seconds": time.process_time(),
            "eval_success_once": math.nan,
        }
        if iteration % args.eval_every == 0:
            row["eval_success_once"] = evaluate(agent, eval_env, num_steps, PROGRESS_SEED)
            print(
                f"{row['steps']:>9,} steps {row['cpu_seconds']:6.1f} s  loss {row['loss']:.3f}, "
                f"success_once evaluated {row['eval_success_once']:.3f}",
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
