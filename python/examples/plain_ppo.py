"""PPO as most files have it, with CleanRL's default numbers: learns through the preset "train".

    python plain_ppo.py --id ShellGameTouch-VLA-v0 --seed 1
    python plain_ppo.py --id RememberColor3-VLA-v0 RememberShape3-VLA-v0 --file runs.csv
    python plain_ppo.py --id RememberColor3-VLA-v0 --memory lstm --total-timesteps 1200000

Nothing in this file is made for engram: two networks of 64 x 64, a learnt deviation that does not
depend on the state, running normalisation of observations and rewards. With `--memory lstm` both
networks share their first layer, whose inputs are the observation and the output of an LSTM. What a
plain learner needs to learn these tasks is in `engram.make_vec(id, preset="train")`; `--preset
none` and `--without PART...` show what it does. Updates are one compiled function of jax, for CPUs.
docs/learning.md has results.
"""

from __future__ import annotations

import argparse
import csv
import functools
import time
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

import engram
from engram import wrappers

HALF_LOG_2PI = 0.5 * np.log(2 * np.pi)
WIDTH = 64  # of layers and memory
EVAL_ENVS = 50
# Options that are columns of the results, or change none of them.
COLUMNS = (
    "id",
    "preset",
    "without",
    "obs_mode",
    "seed",
    "total_timesteps",
    "threads",
    "eval_episodes",
    "file",
)


# Defaults with a memory: it learns from whole sequences, and from advantages that look less far.
WITH_MEMORY = {
    "obs_mode": "objects",
    "still": 1.0,
    "num_envs": 256,
    "num_minibatches": 16,
    "learning_rate": 1e-3,
    "gamma": 0.95,
    "gae_lambda": 0.7,
    "vf_coef": 2.0,
}


def make_parser(memory: str = "none") -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        description="Learns an engram task with a plain PPO.",
        formatter_class=argparse.ArgumentDefaultsHelpFormatter,
    )
    add = parser.add_argument
    add("--id", nargs="+", default=["ShellGameTouch-VLA-v0"], help="tasks, one run after the other")
    add("--preset", default="train", choices=["train", "none"], help="of engram.make_vec")
    add("--without", nargs="*", default=[], help="parts of the preset to leave out, by keyword")
    add("--obs-mode", default="state", choices=["state", "objects"], help="observations")
    add("--still", type=float, default=0.0, help="of the preset: weight of standing still")
    add(
        "--memory",
        default="none",
        choices=["none", "lstm"],
        help="of actor and critic; with one, WITH_MEMORY of this file has other defaults",
    )
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
    add("--log-std", type=float, default=0.0, help="logarithm of the deviation at the start")
    add(
        "--forget-bias", type=float, default=1.0, help="bias of the LSTM's forget gate at the start"
    )
    add("--threads", type=int, default=1, help="of the simulator")
    add("--eval-episodes", type=int, default=200, help="of the evaluation at the end")
    add("--file", help="CSV file that gets a row for each run")
    parser.set_defaults(**(WITH_MEMORY if memory == "lstm" else {}))
    return parser


def parse_arguments(words: list[str] | None = None) -> argparse.Namespace:
    memory = make_parser().parse_args(words).memory
    return make_parser(memory).parse_args(words)


def other_options(args: argparse.Namespace) -> str:
    """Options that are no columns and have other values than their defaults, as words."""
    default = make_parser(args.memory).get_default
    return "".join(
        f" --{name.replace('_', '-')} {value}"
        for name, value in vars(args).items()
        if name not in COLUMNS and value != default(name)
    )


class Clock:
    """Seconds by what was done in them."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self.last = time.perf_counter()

    def done(self, name: str) -> None:
        now = time.perf_counter()
        self.seconds[name] = self.seconds.get(name, 0.0) + now - self.last
        self.last = now

    def report(self, steps: int) -> None:
        """Prints steps per second, and shares of the time."""
        total = sum(self.seconds.values()) or 1.0  # nothing was measured
        shares = (f"{name} {seconds / total:.2f}" for name, seconds in self.seconds.items())
        print(f"{steps / total:,.0f} steps/s: {', '.join(shares)}", flush=True)


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
State = tuple[Any, Any]  # output and cell of the LSTM, (N, WIDTH) each


def init_params(
    rng: np.random.Generator, args: argparse.Namespace, inputs: int, actions: int
) -> Params:
    def matrix(size_in: int, size_out: int, gain: float) -> np.ndarray:
        shape = max(size_in, size_out), min(size_in, size_out)
        q = np.linalg.qr(rng.normal(size=shape))[0]
        q = q if size_in >= size_out else q.T
        return (gain * q).astype(np.float32)

    def layer(size_in: int, size_out: int, gain: float) -> tuple[np.ndarray, np.ndarray]:
        return matrix(size_in, size_out, gain), np.zeros(size_out, np.float32)

    def mlp(outputs: int, last_gain: float) -> list[Any]:
        sizes = [inputs, WIDTH] if "lstm" not in params else [WIDTH]
        return [*(layer(size, WIDTH, 2**0.5) for size in sizes), layer(WIDTH, outputs, last_gain)]

    params: Params = {"log_std": np.full(actions, args.log_std, np.float32)}
    if args.memory == "lstm":
        # Gates in the order input, forget, cell, output.
        weights = [
            np.concatenate([matrix(size, WIDTH, 1.0) for _ in range(4)], 1)
            for size in (inputs, WIDTH)
        ]
        params["lstm"] = (*weights, np.repeat(np.float32([0, args.forget_bias, 0, 0]), WIDTH))
        params["shared"] = [layer(inputs + WIDTH, WIDTH, 2**0.5)]
    return {**params, "actor": mlp(actions, 0.01), "critic": mlp(1, 1.0)}


def hidden_layers(lib: Any, layers: list[Any], inputs: Any) -> Any:
    """Layers with tanh, by numpy or jax.numpy."""
    for weights, bias in layers:
        inputs = lib.tanh(inputs @ weights + bias)
    return inputs


def forward(lib: Any, layers: list[Any], inputs: Any) -> Any:
    """A network whose last layer is linear."""
    return hidden_layers(lib, layers[:-1], inputs) @ layers[-1][0] + layers[-1][1]


def lstm_step(lib: Any, recurrent: Any, state: State, projected: Any, begins: Any) -> State:
    """One step of the LSTM from projected inputs (N, 4 WIDTH); zeros where an episode begins."""
    hidden, cell = (part * (1 - begins)[:, None] for part in state)
    gates = projected + hidden @ recurrent
    keys = 0.5 + 0.5 * lib.tanh(0.5 * gates)  # sigmoid
    new = lib.tanh(gates[:, 2 * WIDTH : 3 * WIDTH])
    cell = keys[:, WIDTH : 2 * WIDTH] * cell + keys[:, :WIDTH] * new
    return keys[:, 3 * WIDTH :] * lib.tanh(cell), cell


def remember(params: Params, obs: Any, state: State, begins: Any) -> tuple[Any, State]:
    """Inputs (N, ...) of actor and critic in one step, by numpy, and the memory's next state."""
    if "lstm" not in params:
        return obs, state
    weights, recurrent, bias = params["lstm"]
    state = lstm_step(np, recurrent, state, obs @ weights + bias, begins)
    return hidden_layers(np, params["shared"], np.concatenate([obs, state[0]], 1)), state


def remember_all(params: Params, obs: Any, state: State, begins: Any) -> Any:
    """Inputs (T, N, ...) of actor and critic in all steps, by jax."""
    if "lstm" not in params:
        return obs
    weights, recurrent, bias = params["lstm"]

    def step(state: State, inputs: tuple[Any, Any]) -> tuple[State, Any]:
        state = lstm_step(jnp, recurrent, state, *inputs)
        return state, state[0]

    hidden = jax.lax.scan(step, state, (obs @ weights + bias, begins))[1]
    return hidden_layers(jnp, params["shared"], jnp.concatenate([obs, hidden], -1))


def log_prob(lib: Any, actions: Any, mean: Any, log_std: Any) -> Any:
    error = (actions - mean) / lib.exp(log_std)
    return (-0.5 * error**2 - log_std - HALF_LOG_2PI).sum(-1)


def loss(args: argparse.Namespace, params: Params, batch: tuple[Any, ...]) -> Any:
    """PPO's clipped loss of a minibatch of sequences (Schulman et al., 2017)."""
    obs, actions, old_log_probs, advantages, returns, old_values, begins, *state = batch
    features = remember_all(params, obs, (state[0][0], state[1][0]), begins)
    mean = forward(jnp, params["actor"], features)
    ratio = jnp.exp(log_prob(jnp, actions, mean, params["log_std"]) - old_log_probs)
    advantages = (advantages - advantages.mean()) / (advantages.std() + 1e-8)
    clipped = jnp.clip(ratio, 1 - args.clip_coef, 1 + args.clip_coef)
    policy_loss = jnp.maximum(-advantages * ratio, -advantages * clipped).mean()
    values = forward(jnp, params["critic"], features)[..., 0]
    near = old_values + jnp.clip(values - old_values, -args.clip_coef, args.clip_coef)
    value_loss = 0.5 * jnp.maximum((values - returns) ** 2, (near - returns) ** 2).mean()
    return policy_loss + args.vf_coef * value_loss


@functools.partial(jax.jit, static_argnums=0)
def update(
    settings: Settings, adam: tuple[Any, ...], rows: Any, data: tuple[Any, ...], rate: Any
) -> tuple[Any, ...]:
    """All gradient steps of an iteration, by Adam; `rows` has a minibatch's sequences per step."""
    args = settings.args
    each = jax.tree_util.tree_map

    def step(adam: tuple[Any, ...], index: Any) -> tuple[Any, None]:
        params, first, second, count = adam
        grads = jax.grad(functools.partial(loss, args))(
            params, tuple(part[:, index] for part in data)
        )
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

    def __init__(self, num_envs: int, columns: np.ndarray, gamma: float) -> None:
        self.columns = columns
        self.obs, self.returns = RunningMoments(columns.shape), RunningMoments(())
        self.gamma, self.running = gamma, np.zeros(num_envs)

    def observation(self, rows: np.ndarray, learn: bool = True) -> np.ndarray:
        rows = rows[:, self.columns]
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
        threads=args.threads,
        seed=(args.seed, 0),
        **ends,
    )
    if args.preset == "none":
        return env
    left_out = {name: {} if name == "terms" else 0 for name in args.without}
    return wrappers.train(env, gamma=args.gamma, still=args.still, **left_out)


def varying_columns(env: Any, rng: np.random.Generator, steps: int) -> np.ndarray:
    """Inputs that vary under random actions: one-hot columns that a task never uses do not."""
    rows = [env.reset()[0]]
    for _ in range(steps):
        rows.append(env.step(rng.standard_normal(env.action_space.shape))[0])
    every = np.concatenate(rows)
    return np.flatnonzero(every.max(0) > every.min(0))


def train(args: argparse.Namespace) -> tuple[Params, Normaliser]:
    """Learns; prints the success of the episodes that exploration has ended."""
    rng = np.random.default_rng(args.seed)
    env = make_env(args, args.num_envs)
    space = env.single_action_space
    shape = args.num_steps, args.num_envs
    columns = np.arange(env.single_observation_space.shape[0])
    if args.memory != "none":
        columns = varying_columns(env, rng, env.description["horizon"])
    width = len(columns)
    normaliser = Normaliser(args.num_envs, columns, args.gamma)
    params = init_params(rng, args, width, space.shape[0])
    zeros = jax.tree_util.tree_map(np.zeros_like, params)
    adam: tuple[Any, ...] = (params, zeros, zeros, 0)
    settings = Settings(args)
    obs = normaliser.observation(env.reset()[0])
    done = np.ones(args.num_envs, np.float32)
    state: State = (np.zeros((args.num_envs, WIDTH), np.float32),) * 2
    iterations = max(1, args.total_timesteps // (shape[0] * shape[1]))
    successes: list[bool] = []
    clock = Clock()
    for iteration in range(iterations):
        observations = np.zeros((*shape, width), np.float32)
        actions = np.zeros((*shape, space.shape[0]), np.float32)
        log_probs, rewards, dones, values = (np.zeros(shape, np.float32) for _ in range(4))
        first_state = state
        for t in range(args.num_steps):
            observations[t], dones[t] = obs, done
            features, state = remember(params, obs, state, done)
            mean = forward(np, params["actor"], features)
            actions[t] = mean + np.exp(params["log_std"]) * rng.standard_normal(mean.shape)
            log_probs[t] = log_prob(np, actions[t], mean, params["log_std"])
            values[t] = forward(np, params["critic"], features)[:, 0]
            clipped = np.clip(actions[t], space.low, space.high)
            clock.done("act")
            rows, reward, terminated, truncated, info = env.step(clipped)
            clock.done("env.step")
            ended = terminated | truncated
            if ended.any():
                successes += info["final_info"]["success_once"][ended].tolist()
            rewards[t] = normaliser.reward(reward, ended)
            obs, done = normaliser.observation(rows), ended.astype(np.float32)
            clock.done("scale")
        last = forward(np, params["critic"], remember(params, obs, state, done)[0])[:, 0]
        advantages = estimate_advantages(args, rewards, values, dones, last, done)
        data = (observations, actions, log_probs, advantages, advantages + values, values, dones)
        if args.memory == "none":  # Each step is a sequence of its own
            data = tuple(part.reshape(1, -1, *part.shape[2:]) for part in data)
            data = (*data, *(np.zeros((1, data[0].shape[1], 0), np.float32),) * 2)
        else:
            data = (*data, *(part[None] for part in first_state))
        order = [rng.permutation(data[0].shape[1]) for _ in range(args.update_epochs)]
        minibatches = np.concatenate([one.reshape(args.num_minibatches, -1) for one in order])
        rate = np.float32(args.learning_rate * (1 - iteration / iterations))
        adam = update(settings, adam, minibatches, data, rate)
        params = jax.tree_util.tree_map(np.asarray, adam[0])
        clock.done("learn")
        if iteration == 0:  # which compiles
            clock = Clock()
        if (iteration + 1) % 20 == 0:
            share = np.mean(successes) if successes else np.nan
            steps = (iteration + 1) * shape[0] * shape[1]
            print(
                f"{steps:>9,} steps {time.process_time():6.1f} s  exploring {share:.3f}", flush=True
            )
            successes = []
    clock.report((iterations - 1) * shape[0] * shape[1])
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


def evaluate(args: argparse.Namespace, params: Params, normaliser: Normaliser) -> dict[str, Any]:
    """Results of the mean action."""
    env = make_env(argparse.Namespace(**{**vars(args), "threads": 1}), EVAL_ENVS)

    state: State = (np.zeros((EVAL_ENVS, WIDTH), np.float32),) * 2

    def act(rows: np.ndarray, begins: np.ndarray) -> np.ndarray:
        nonlocal state
        obs = normaliser.observation(rows, learn=False)
        features, state = remember(params, obs, state, begins)
        mean = forward(np, params["actor"], features)
        return np.clip(mean, env.single_action_space.low, env.single_action_space.high)

    return score(args, env, act, args.obs_mode)


def run(args: argparse.Namespace) -> dict[str, Any]:
    """Trains and evaluates in one task; returns a row of the results."""
    begin = time.process_time()
    task = evaluate(args, *train(args))
    return as_row(args, "plain_ppo.py" + other_options(args), whole_iterations(args), task, begin)


def whole_iterations(args: argparse.Namespace) -> int:
    """Environment steps of a run."""
    per_iteration: int = args.num_steps * args.num_envs
    return max(1, args.total_timesteps // per_iteration) * per_iteration


def score(args: argparse.Namespace, env: Any, act: Any, obs: str) -> dict[str, Any]:
    """Results of engram's own evaluation; `env` has EVAL_ENVS environments."""
    result = engram.evaluate(
        wrappers.WrappedPolicy(env, act),
        args.id,
        obs=obs,
        episodes=args.eval_episodes,
        num_envs=EVAL_ENVS,
        threads=1,
    )
    task: dict[str, Any] = result["tasks"][0]
    return task


def as_row(
    args: argparse.Namespace, learner: str, env_steps: int, task: dict[str, Any], begin: float
) -> dict[str, Any]:
    """A row of the results, of a run that began at that processor time."""
    first = task["first_answer_correct"]
    return {
        "learner": learner,
        "id": args.id,
        "preset": getattr(args, "preset", "train"),
        "without": " ".join(getattr(args, "without", [])),
        "seed": args.seed,
        "env_steps": env_steps,
        "success_once": f"{task['sr']:.3f}",
        "episodes": args.eval_episodes,
        "cpu_s": f"{time.process_time() - begin:.1f}",
        "first_answer": "" if first is None else f"{first:.3f}",
    }


def append(file: str, row: dict[str, Any]) -> None:
    """Adds a row to a CSV file, below a header if the file is new."""
    with open(file, "a", newline="", encoding="utf-8") as out:
        writer = csv.DictWriter(out, row, lineterminator="\n")
        if out.tell() == 0:
            writer.writeheader()
        writer.writerow(row)


def run_each(args: argparse.Namespace, run: Callable[[argparse.Namespace], dict[str, Any]]) -> None:
    """Runs the tasks of `--id` one after the other; prints and stores a row of each."""
    for task in args.id:
        row = run(argparse.Namespace(**{**vars(args), "id": task}))
        print("  ".join(f"{name} {value}" for name, value in row.items()), flush=True)
        if args.file:
            append(args.file, row)


def main() -> None:
    run_each(parse_arguments(), run)


if __name__ == "__main__":
    main()
