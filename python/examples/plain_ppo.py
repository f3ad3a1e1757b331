"""PPO as most files have it, with CleanRL's default numbers: learns through the preset "train".

    python plain_ppo.py --id ShellGameTouch-VLA-v0 --seed 1
    python plain_ppo.py --id RememberColor3-VLA-v0 RememberShape3-VLA-v0 --file runs.csv

Nothing in this file is made for engram: two networks of 64 x 64, a learnt deviation that does not
depend on the state, running normalisation of observations and rewards. What a plain learner needs
to learn these tasks is in `engram.make_vec(id, preset="train")`; `--preset none` and `--without
PART...` show what it does. Updates are one compiled function of jax, for CPUs. docs/learning.md has
results.
"""

from __future__ import annotations

import argparse
import csv
import functools
import time
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

import engram
from engram import wrappers

HALF_LOG_2PI = 0.5 * np.log(2 * np.pi)
EVAL_ENVS = 50


def parse_arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description="Learns an engram task with a plain PPO.",
        formatter_class=argparse.ArgumentDefaultsHelpFormatter,
    )
    add = parser.add_argument
    add("--id", nargs="+", default=["ShellGameTouch-VLA-v0"], help="tasks, one run after the other")
    add("--preset", default="train", choices=["train", "none"], help="of engram.make_vec")
    add("--without", nargs="*", default=[], help="parts of the preset to leave out, by keyword")
    add("--obs-mode", default="state", choices=["state", "objects"], help="observations")
    add("--seed", type=int, default=1, help="of episodes, networks and exploration")
    add("--total-timesteps", type=int, default=500_000, help="environment steps to learn from")
    add("--num-envs", type=int, default=64, help="environments stepped together")
    add("--num-steps", type=int, default=32, help="steps of each environment per iteration")
    add("--learning-rate", type=float, default=3e-4, help="of Adam at the start; falls to zero")
    add("--gamma", type=float, default=0.99, help="discount per step")
    add("--gae-lambda", type=float, default=0.95, help="of generalised advantage estimation")
    add("--num-minibatches", type=int, default=32, help="gradient steps per pass")
    add("--update-epochs", type=int, default=10, help="passes over the steps of an iteration")
    add("--clip-coef", type=float, default=0.2, help="largest useful change of a probability ratio")
    add("--vf-coef", type=float, default=0.5, help="weight of the value loss")
    add("--max-grad-norm", type=float, default=0.5, help="largest norm of a gradient")
    add("--eval-episodes", type=int, default=200, help="of the evaluation at the end")
    add("--file", help="CSV file that gets a row for each run")
    return parser.parse_args()


class RunningMoments:
    """Mean and variance of everything seen so far (Chan et al., 1979)."""

    def __init__(self, shape: tuple[int, ...]) -> None:
        self.mean, self.var, self.count = np.zeros(shape), np.ones(shape), 1e-4

    def update(self, rows: np.ndarray) -> None:
        total = self.count + len(rows)
        delta = rows.mean(0) - self.mean
        between = delta**2 * self.count * len(rows) / total
        self.var = (self.var * self.count + rows.var(0) * len(rows) + between) / total
        self.mean = self.mean + delta * len(rows) / total
        self.count = total


Params = dict[str, Any]


def init_params(rng: np.random.Generator, inputs: int, actions: int, width: int = 64) -> Params:
    def layer(size_in: int, size_out: int, gain: float) -> tuple[np.ndarray, np.ndarray]:
        shape = max(size_in, size_out), min(size_in, size_out)
        q = np.linalg.qr(rng.normal(size=shape))[0]
        q = q if size_in >= size_out else q.T
        return (gain * q).astype(np.float32), np.zeros(size_out, np.float32)

    def mlp(outputs: int, last_gain: float) -> list[Any]:
        root2 = 2**0.5
        return [
            layer(inputs, width, root2),
            layer(width, width, root2),
            layer(width, outputs, last_gain),
        ]

    log_std = np.zeros(actions, np.float32)
    return {"actor": mlp(actions, 0.01), "critic": mlp(1, 1.0), "log_std": log_std}


def forward(lib: Any, layers: list[Any], inputs: Any) -> Any:
    """A network with two hidden layers, by numpy or jax.numpy."""
    hidden = lib.tanh(inputs @ layers[0][0] + layers[0][1])
    hidden = lib.tanh(hidden @ layers[1][0] + layers[1][1])
    return hidden @ layers[2][0] + layers[2][1]


def log_prob(lib: Any, actions: Any, mean: Any, log_std: Any) -> Any:
    error = (actions - mean) / lib.exp(log_std)
    return (-0.5 * error**2 - log_std - HALF_LOG_2PI).sum(-1)


def loss(args: argparse.Namespace, params: Params, batch: tuple[Any, ...]) -> Any:
    """PPO's clipped loss of a minibatch (Schulman et al., 2017)."""
    obs, actions, old_log_probs, advantages, returns, old_values = batch
    mean = forward(jnp, params["actor"], obs)
    ratio = jnp.exp(log_prob(jnp, actions, mean, params["log_std"]) - old_log_probs)
    advantages = (advantages - advantages.mean()) / (advantages.std() + 1e-8)
    clipped = jnp.clip(ratio, 1 - args.clip_coef, 1 + args.clip_coef)
    policy_loss = jnp.maximum(-advantages * ratio, -advantages * clipped).mean()
    values = forward(jnp, params["critic"], obs)[:, 0]
    near = old_values + jnp.clip(values - old_values, -args.clip_coef, args.clip_coef)
    value_loss = 0.5 * jnp.maximum((values - returns) ** 2, (near - returns) ** 2).mean()
    return policy_loss + args.vf_coef * value_loss


@functools.partial(jax.jit, static_argnums=0)
def update(
    settings: Settings, adam: tuple[Any, ...], rows: Any, data: tuple[Any, ...], rate: Any
) -> tuple[Any, ...]:
    """All gradient steps of an iteration, by Adam; `rows` has a minibatch's indices per step."""
    args = settings.args
    each = jax.tree_util.tree_map

    def step(adam: tuple[Any, ...], index: Any) -> tuple[Any, None]:
        params, first, second, count = adam
        grads = jax.grad(functools.partial(loss, args))(params, tuple(part[index] for part in data))
        norm = jnp.sqrt(sum((leaf**2).sum() for leaf in jax.tree_util.tree_leaves(grads)))
        grads = each(lambda g: g * jnp.minimum(1.0, args.max_grad_norm / (norm + 1e-6)), grads)
        count = count + 1
        first = each(lambda m, g: 0.9 * m + 0.1 * g, first, grads)
        second = each(lambda v, g: 0.999 * v + 0.001 * g * g, second, grads)

        def moved(param: Any, m: Any, v: Any) -> Any:
            return param - rate * (m / (1 - 0.9**count)) / (jnp.sqrt(v / (1 - 0.999**count)) + 1e-5)

        return (each(moved, params, first, second), first, second, count), None

    result: tuple[Any, ...] = jax.lax.scan(step, adam, rows)[0]
    return result


class Settings:
    """Arguments that a compiled function is made for."""

    def __init__(self, args: argparse.Namespace) -> None:
        self.args = args


class Normaliser:
    """Observations and rewards by running moments, clipped at 10, as Gymnasium's wrappers do."""

    def __init__(self, num_envs: int, width: int, gamma: float) -> None:
        self.obs, self.returns = RunningMoments((width,)), RunningMoments(())
        self.gamma, self.running = gamma, np.zeros(num_envs)

    def observation(self, rows: np.ndarray, learn: bool = True) -> np.ndarray:
        if learn:
            self.obs.update(rows)
        scaled = (rows - self.obs.mean) / np.sqrt(self.obs.var + 1e-8)
        return np.clip(scaled, -10, 10).astype(np.float32)

    def reward(self, reward: np.ndarray, ended: np.ndarray) -> np.ndarray:
        self.running = self.gamma * self.running + reward
        self.returns.update(self.running)
        self.running = self.running * ~ended
        return np.clip(reward / np.sqrt(self.returns.var + 1e-8), -10, 10)


def make_env(args: argparse.Namespace, num_envs: int) -> Any:
    """The batch, in what `engram.make_vec(..., preset="train")` has by default."""
    ends = {} if args.preset == "none" else {"terminate_on_success": True}
    env = engram.make_vec(
        args.id,
        num_envs,
        obs_mode=args.obs_mode,
        autoreset_mode="SAME_STEP",
        threads=1,
        seed=(args.seed, 0),
        **ends,
    )
    if args.preset == "none":
        return env
    left_out = {name: {} if name == "terms" else 0 for name in args.without}
    return wrappers.train(env, gamma=args.gamma, **left_out)


def train(args: argparse.Namespace) -> tuple[Params, Normaliser]:
    """Learns; prints the success of the episodes that exploration has ended."""
    rng = np.random.default_rng(args.seed)
    env = make_env(args, args.num_envs)
    space = env.single_action_space
    shape = args.num_steps, args.num_envs
    width = env.single_observation_space.shape[0]
    normaliser = Normaliser(args.num_envs, width, args.gamma)
    params = init_params(rng, width, space.shape[0])
    zeros = jax.tree_util.tree_map(np.zeros_like, params)
    adam: tuple[Any, ...] = (params, zeros, zeros, 0)
    settings = Settings(args)
    obs = normaliser.observation(env.reset()[0])
    done = np.zeros(args.num_envs, np.float32)
    iterations = max(1, args.total_timesteps // (shape[0] * shape[1]))
    successes: list[bool] = []
    for iteration in range(iterations):
        observations = np.zeros((*shape, width), np.float32)
        actions = np.zeros((*shape, space.shape[0]), np.float32)
        log_probs, rewards, dones, values = (np.zeros(shape, np.float32) for _ in range(4))
        for t in range(args.num_steps):
            observations[t], dones[t] = obs, done
            mean = forward(np, params["actor"], obs)
            actions[t] = mean + np.exp(params["log_std"]) * rng.standard_normal(mean.shape)
            log_probs[t] = log_prob(np, actions[t], mean, params["log_std"])
            values[t] = forward(np, params["critic"], obs)[:, 0]
            rows, reward, terminated, truncated, info = env.step(
                np.clip(actions[t], space.low, space.high)
            )
            ended = terminated | truncated
            if ended.any():
                successes += info["final_info"]["success_once"][ended].tolist()
            rewards[t] = normaliser.reward(reward, ended)
            obs, done = normaliser.observation(rows), ended.astype(np.float32)
        last = forward(np, params["critic"], obs)[:, 0]
        advantages = estimate_advantages(args, rewards, values, dones, last, done)
        data = (observations, actions, log_probs, advantages, advantages + values, values)
        data = tuple(part.reshape(-1, *part.shape[2:]) for part in data)
        order = [rng.permutation(shape[0] * shape[1]) for _ in range(args.update_epochs)]
        minibatches = np.concatenate([one.reshape(args.num_minibatches, -1) for one in order])
        rate = np.float32(args.learning_rate * (1 - iteration / iterations))
        adam = update(settings, adam, minibatches, data, rate)
        params = jax.tree_util.tree_map(np.asarray, adam[0])
        if (iteration + 1) % 20 == 0:
            share = np.mean(successes) if successes else np.nan
            steps = (iteration + 1) * shape[0] * shape[1]
            print(
                f"{steps:>9,} steps {time.process_time():6.1f} s  exploring {share:.3f}", flush=True
            )
            successes = []
    return params, normaliser


def estimate_advantages(
    args: argparse.Namespace,
    rewards: np.ndarray,
    values: np.ndarray,
    dones: np.ndarray,
    last_value: np.ndarray,
    last_done: np.ndarray,
) -> np.ndarray:
    """Generalised advantage estimation (Schulman et al., 2016)."""
    advantages = np.zeros_like(rewards)
    following = np.zeros_like(last_value)
    for t in reversed(range(len(rewards))):
        final = t == len(rewards) - 1
        alive = 1 - (last_done if final else dones[t + 1])
        next_value = last_value if final else values[t + 1]
        delta = rewards[t] + args.gamma * next_value * alive - values[t]
        following = delta + args.gamma * args.gae_lambda * alive * following
        advantages[t] = following
    return advantages


def evaluate(args: argparse.Namespace, params: Params, normaliser: Normaliser) -> float:
    """Success of the mean action in engram's own evaluation, with its seeds."""
    env = make_env(args, EVAL_ENVS)

    def act(rows: np.ndarray, begins: np.ndarray) -> np.ndarray:
        mean = forward(np, params["actor"], normaliser.observation(rows, learn=False))
        return np.clip(mean, env.single_action_space.low, env.single_action_space.high)

    result = engram.evaluate(
        wrappers.WrappedPolicy(env, act),
        args.id,
        obs=args.obs_mode,
        episodes=args.eval_episodes,
        num_envs=EVAL_ENVS,
        threads=1,
    )
    return float(result["tasks"][0]["sr"])


def run(args: argparse.Namespace) -> dict[str, Any]:
    """Trains and evaluates in one task; returns a row of the results."""
    begin = time.process_time()
    params, normaliser = train(args)
    success = evaluate(args, params, normaliser)
    per_iteration = args.num_steps * args.num_envs
    return {
        "learner": "plain_ppo.py",
        "id": args.id,
        "preset": args.preset,
        "without": " ".join(args.without),
        "seed": args.seed,
        "env_steps": max(1, args.total_timesteps // per_iteration) * per_iteration,
        "success_once": f"{success:.3f}",
        "episodes": args.eval_episodes,
        "cpu_s": f"{time.process_time() - begin:.1f}",
    }


def append(file: str, row: dict[str, Any]) -> None:
    """Adds a row to a CSV file, below a header if the file is new."""
    with open(file, "a", newline="", encoding="utf-8") as out:
        writer = csv.DictWriter(out, row, lineterminator="\n")
        if out.tell() == 0:
            writer.writeheader()
        writer.writerow(row)


def main() -> None:
    args = parse_arguments()
    for task in args.id:
        row = run(argparse.Namespace(**{**vars(args), "id": task}))
        print("  ".join(f"{name} {value}" for name, value in row.items()), flush=True)
        if args.file:
            append(args.file, row)


if __name__ == "__main__":
    main()
