r"""Distils engram's oracle into a policy with memory (DAgger), from objects or from images.

The student acts; the oracle, which uses privileged state, labels every visited state with its own
action. The memory's loss uses the student's own observations. Privileged, in training only: the
oracle's actions; with images, the positions of visible objects as well.

    python -m engram_learners.distil --id RememberColor9-VLA-v0 --out runs/color9
    python -m engram_learners.distil --id RememberColor3-VLA-v0 --obs rgb --out runs/images
    python -m engram_learners.distil --id ten --out runs/ten
    python -m engram_learners.distil --id ten --obs rgb --out runs/ten_images
    python -m engram_learners.distil --id short --out runs/short

Several ids make one policy of several tasks, which gets the task as an input: its number, or its
instruction. "ten" are those of several_tasks.py, "short" is the benchmark's short split.

Episodes of more than 400 steps are cut into chunks, with a curriculum over delays
(long_episodes.py):

    python -m engram_learners.distil --id RememberColor9-Long-VLA-v0 --out runs/long
    python -m engram_learners.distil --id SeqOfColors5-Long-VLA-v0 \
        --init runs/seq3/agent.pt --out runs/seq5
"""

import argparse
import math
from pathlib import Path

import numpy as np
import torch
from torch import nn

import engram
from engram_learners import env_options, instructions
from engram_learners.checkpoints import (
    end_progress,
    load_policy,
    load_progress,
    save_policy,
    save_progress,
)
from engram_learners.disturbance import Disturbance
from engram_learners.images.rgb_env import RgbEnv
from engram_learners.long_episodes import Chunks, Delays, share_of_delays, unpack
from engram_learners.memory_loss import MemoryLoss
from engram_learners.policy import N_APPEARANCES, N_COUNTS, Policy, groups
from engram_learners.run_log import Clock, Log
from engram_learners.several_tasks import SETS, TASK_INPUTS, TaskInputs
from engram_learners.training import (
    EVALUATION_SEED,
    FINAL_SEED,
    ObjectsEnv,
    evaluate,
    finish,
    perturbation,
    scale_lr,
)

RESTING = 0.1  # greatest part of an action that is no motion
HUBER = 0.3  # error of a part of an action from which its loss is linear
LONG = 400  # steps; longer episodes are cut into chunks
WHOLE = {
    "envs": 128,
    "iterations": 14,
    "updates": 64,
    "keep": 20,
    "evaluate_every": 4,
}
CUT = {
    "chunk": 30,
    "envs": 64,
    "iterations": 16,
    "updates": 24,
    "keep": 4,
    "evaluate_every": 0,
}
SIZES = ("appearances", "counts", "hidden", "width", "path_points")
EPISODES = 200  # of the last evaluation, of each task


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    add = parser.add_argument
    add("--id", nargs="+", default=["RememberColor3-VLA-v0"], help="a task, or several; ten; short")
    add("--tasks", type=Path, help="file of tasks of your own, for its ids (docs/custom_tasks.md)")
    add("--obs", default="objects", choices=["objects", "rgb"])
    add(
        "--perturb",
        nargs="+",
        default=[],
        type=perturbation,
        metavar="AXIS=LEVEL",
        help="of training and test: docs/variants.md",
    )
    env_options.add_to(parser)
    add("--disturb", type=float, default=0, metavar="SHARE", help="of the training episodes")
    add("--seed", type=int, default=1)
    add("--out", type=Path, help="folder for log.csv, curve.png, agent.pt, result.json")
    add("--init", type=Path, help="agent.pt of a like task, to begin with")
    add("--resume", action="store_true", help="continue with the agent.pt of --out")
    add("--no-memory", action="store_true")
    add("--task-input", choices=TASK_INPUTS, help="of several tasks; default: number; short: words")
    add("--appearances", type=int, help="that the memory distinguishes; default: 20; short: 40")
    add("--counts", type=int, default=N_COUNTS, help="of a lamp or a button, to tell apart")
    add("--hidden", type=int, default=64, help="numbers of the memory of all objects")
    add("--width", type=int, default=64, help="of the action's layers")
    add("--path-points", type=int, default=0, help="kept of what moves by itself; 0: none")
    by_horizon = "default: by the task's horizon"
    add("--envs", type=int, help=f"episodes per iteration; {by_horizon}")
    add("--chunk", type=int, help=f"steps; 0: episodes are whole; {by_horizon}")
    add("--most-steps", type=int, default=120, help="of a training episode that is not cut")
    add("--iterations", type=int, help=by_horizon)
    add("--updates", type=int, help=f"per iteration; {by_horizon}")
    add("--detector-updates", type=int, default=80, help="per iteration, from images")
    add("--keep", type=int, help=f"iterations whose episodes are trained on; {by_horizon}")
    add("--batch", type=int, default=1600, help="steps per update")
    add("--lr", type=float, default=3e-3)
    add("--memory-lr", type=float, default=1e-2)
    add("--perception-lr", type=float, default=3e-3, help="of encoder and attention")
    add("--recall", type=float, default=1.0, help="weight of the memory's loss")
    add("--huber", type=float, default=HUBER, help="error of actions from which the loss is linear")
    add("--evaluate-every", type=int, help=f"iterations; 0: at the end; {by_horizon}")
    add("--episodes", type=int, default=EPISODES, help="of an evaluation before the last, by task")
    args = parser.parse_args()
    complete(args, parser)
    return args


def complete(args, parser):
    """Sets what follows from the given arguments; refuses those that do not fit."""
    if args.tasks is not None:
        engram.load_tasks(args.tasks)
    short = args.id == ["short"]
    args.task_input = args.task_input or ("words" if short else "number")
    args.appearances = args.appearances or (2 if short else 1) * N_APPEARANCES
    if len(args.id) == 1 and args.id[0] in SETS:
        args.id = list(SETS[args.id[0]]())
    if len(set(args.id)) < len(args.id):
        parser.error("--id: an id is given twice")
    args.id = args.id if len(args.id) > 1 else args.id[0]
    if not 0 <= args.disturb <= 1:
        parser.error(f"--disturb: {args.disturb} given, 0 to 1 allowed")
    if args.huber <= 0:
        parser.error(f"--huber: {args.huber} given, more than 0 allowed")
    if args.path_points < 0 or (args.path_points and args.no_memory):
        parser.error(f"--path-points: {args.path_points} given; 0 or more, and a memory, needed")
    args.perturb, args.option = dict(args.perturb), dict(args.option)
    if args.obs == "rgb" and args.option.get(env_options.TIME):
        parser.error(f"--option {env_options.TIME}: --obs objects needed")
    if args.chunk is None:
        long = isinstance(args.id, str) and args.obs == "objects" and horizon_of(args) > LONG
        args.chunk = CUT["chunk"] if long else 0
    for name, value in (CUT if args.chunk else WHOLE).items():
        if getattr(args, name, None) is None:
            setattr(args, name, value)
    if args.chunk and (not isinstance(args.id, str) or args.obs == "rgb"):
        parser.error("--chunk: one --id needed, and --obs objects")
    if args.chunk:
        args.chunk = min(args.chunk, horizon_of(args))


def horizon_of(args):
    return engram.describe(args.id, obs_mode="objects", **args.option)["horizon"]


@torch.no_grad()
def collect(policy, env, first, chunks=None, disturb=0):
    """An iteration's episodes: rows (T, N, D) and the oracle's actions; NaN after an early end.

    The oracle's actions are used in the first iteration, and in half of the later episodes up to a
    random step: so training covers late states even if the student fails early.
    chunks: get the memory's states; episodes are only played until they are decided.
    disturb: share of disturbed episodes.
    """
    rows, labels, state = [], [], None
    row = env.reset()
    guided, until = torch.rand(2, env.num_envs, 1)
    until = env.horizons * (torch.ones_like(until) if first else until * (guided < 0.5))
    played = torch.arange(env.num_envs)
    disturbance = Disturbance(disturb, env.horizons, policy.layout.actions) if disturb else None
    for t in range(env.horizon):
        if chunks and t % chunks.length == 0:
            played, state = chunks.begin(env, played, state)
            if not len(played):
                break
        label = env.oracle()
        choice, _, state, _ = policy(row[None, played], state)
        rows.append(env.truth)
        env.store()
        action = label.index_copy(0, played, choice.best()[0])
        action = torch.where(t < until, label, action)
        row, _ = env.step(disturbance(t, action) if disturbance else action)
        ended = torch.from_numpy(np.array(env.infos["elapsed_steps"])) <= t
        labels.append(label.masked_fill(ended[:, None], math.nan))
    return torch.stack(rows), torch.stack(labels)


def limited(actions):
    """Parts of actions that stand for larger ones: all are limited to 1, a rotation by its norm."""
    result = actions.abs() >= 1
    unit = (actions[..., 3:6].norm(dim=-1, keepdim=True) - 1).abs() < 1e-3
    result[..., 3:6] |= unit
    return result


def imitation(choice, actions, doubt=0.1, huber=HUBER):
    """Distance (T, N) of the action from the oracle's.

    A soft minimum over objects: attention learns the oracle's object, and actions are not averaged
    over objects. It may exceed an action that the oracle has limited. Steps without a label (NaN)
    have no distance.
    """
    labelled = actions.isfinite().all(-1)
    actions = actions.nan_to_num()[..., None, :].expand_as(choice.mean)
    exceeds = limited(actions) & (choice.mean * actions.sign() > actions.abs())
    mean = torch.where(exceeds, actions, choice.mean)
    error = nn.functional.smooth_l1_loss(mean, actions, reduction="none", beta=huber).sum(-1)
    return -doubt * torch.logsumexp(choice.weights - error / doubt, -1) * labelled


def by_length(policy, env, rows, actions):
    """An iteration's episodes, whole: by length, rows, actions and the memory's labels."""
    result = []
    for horizon, columns, envs in env.by_length():
        own = rows[:horizon, envs].gather(-1, columns.expand(horizon, -1, -1))
        result.append((own, actions[:horizon, envs], *MemoryLoss.labels(policy, own)))
    return result


def learn(policy, optimiser, episodes, args):
    """episodes: by iteration, what `by_length` or `Chunks.cut` returns, the latter in a list."""
    lengths = [[torch.cat(parts, 1) for parts in zip(*group)] for group in zip(*episodes)]
    counts = [rows.shape[1] for rows, *_ in lengths]
    shares = [count / sum(counts) for count in counts]  # so tasks have equal weight
    sums = {"action": 0.0, "memory": 0.0}
    for _ in range(args.updates):
        total = 0.0
        for share, (rows, actions, *labels) in zip(shares, lengths):
            steps = int(share * args.batch)
            pick = torch.randint(rows.shape[1], (max(1, steps // len(rows)),))
            picked = [part[:, pick] for part in (rows, actions, *labels)]
            action, memory = losses_of(policy, *picked, huber=args.huber)
            sums["action"] += share * action.item() / args.updates
            sums["memory"] += share * memory.item() / args.updates
            total = total + share * (action + args.recall * memory)
        optimiser.zero_grad()
        total.backward()
        nn.utils.clip_grad_norm_(policy.parameters(), 1.0)
        optimiser.step()
    return {name: round(value, 4) for name, value in sums.items()}


def losses_of(policy, rows, actions, *labels, huber=HUBER):
    """Losses of actions and memory in whole episodes of one length, or in chunks.

    labels: of the memory; of chunks also what else `Chunks.cut` returns.
    """
    ever, *begin = labels[3:] or (None,)
    choice, recalled, _, _ = policy(rows, unpack(*begin) if begin else None)
    # Steps in which neither moves have less weight: they are frequent and easy.
    moves = choice.best()[..., :-1].detach().abs().amax(-1) > RESTING
    moves |= actions[..., :-1].abs().amax(-1) > 0
    weight = torch.where(moves & actions.isfinite().all(-1), 1.0, 0.1)
    action = (imitation(choice, actions, huber=huber) * (weight / weight.sum())).sum()
    if not policy.memory:
        return action, torch.zeros(())
    return action, MemoryLoss.loss(policy, rows, recalled, labels[:3], ever)


class Collector:
    """Collects an iteration's episodes, and makes what `learn` gets of them."""

    def __init__(self, policy, env, args, delays=None, steps=0):
        """delays: of the curriculum, if episodes are cut. steps: those before this run."""
        self.policy, self.env, self.args = policy, env, args
        self.delays, self.steps = delays, steps
        self.chunks = Chunks(policy, args.chunk) if args.chunk else None

    def __call__(self, iteration, trained):
        """trained: the policy is not a new one."""
        policy, env, first = self.policy, self.env, iteration == 0 and not trained
        if self.chunks:
            return [self.collect_chunks(iteration, first)]
        rows, actions = collect(policy, env, first, disturb=self.args.disturb)
        if iteration == 0:
            seen = [rows[:horizon, envs].flatten(0, 1) for horizon, _, envs in env.by_length()]
            self.learn_appearances(torch.cat(seen), first)
        self.steps += int(env.horizons.sum())
        return by_length(policy, env, rows, actions)

    def learn_appearances(self, seen, first):
        (self.policy.fit if first else self.policy.replace_appearances)(seen)

    def collect_chunks(self, iteration, first):
        share = share_of_delays(iteration / max(1, self.args.iterations - 1))
        seen = self.delays.narrow(self.env, share, self.args.chunk)
        if iteration == 0:
            self.learn_appearances(seen, first)
        rows, actions = collect(self.policy, self.env, first, self.chunks, self.args.disturb)
        self.steps += len(seen) * seen.shape[1] + rows.shape[0] * rows.shape[1]
        return self.chunks.cut(rows, actions)


def task_inputs(args, policy):
    """Inputs of a policy of several tasks, those of the policy if there is one; else None."""
    if isinstance(args.id, str):
        return None
    if policy is not None:
        return TaskInputs.like(args.id, policy.layout, args.option)
    return TaskInputs.of(args.id, *TASK_INPUTS[args.task_input], args.option)


def training_env(args, policy, detector, delays):
    given = (args.id, args.envs, args.seed, None if args.chunk else args.most_steps, args.perturb)
    named = {"inputs": task_inputs(args, policy), "wording": instructions.drawn}
    named["options"] = args.option
    if args.obs == "rgb":
        return RgbEnv(*given, detector=detector, **named)
    return ObjectsEnv(*given, delays.widest() if delays else None, **named)


def evaluation_env(args, episodes, env, wording=instructions.own):
    """Scenes of an evaluation: of several tasks by id, each alone."""
    given = {"perturb": args.perturb, "options": args.option}
    given |= {"inputs": env.inputs, "wording": wording}
    if args.obs == "rgb":
        given["detector"] = env.detector
    kind = RgbEnv if args.obs == "rgb" else ObjectsEnv
    if isinstance(args.id, str):
        return kind(args.id, episodes, **given)
    return {id: kind(id, episodes, **given) for id in args.id}


def keep_paths(policy, points):
    """Gives a policy that keeps paths room for other numbers of points."""
    if policy.path_points == 0:
        raise SystemExit(f"--path-points: {points} given; the policy to begin with keeps no paths")
    policy.keep_paths(points)


def main():
    args = arguments()
    torch.manual_seed(args.seed)
    torch.set_num_threads(1)
    clock, path = Clock(), args.out and args.out / "agent.pt"
    resumed = args.resume and path.exists()
    begin = path if resumed else args.init
    given = args.id, args.option
    policy, detector, init = load_policy(begin, *given) if begin else (None, None, None)
    delays = Delays(*given) if args.chunk else None
    env = training_env(args, policy, detector, delays)
    test = evaluation_env(args, args.episodes, env)
    sizes = {name: getattr(args, name) for name in SIZES}
    if policy and args.path_points:
        keep_paths(policy, args.path_points)
    policy = policy or Policy(env.layout, not args.no_memory, **sizes)
    optimiser = torch.optim.Adam(groups(policy, args.lr, args.memory_lr, args.perception_lr))
    log, episodes = Log(args.out), []
    start = load_progress(args.out, optimiser, log, clock) if resumed else 0
    steps = log.rows[-1]["env_steps"] if log.rows else 0
    collector = Collector(policy, env, args, delays, steps)
    env.reset(seed=args.seed + 1000 * start)
    for iteration in range(start, args.iterations):
        episodes.append(collector(iteration, begin is not None))
        del episodes[: -args.keep]
        scale = min(1, 2 - 2 * iteration / args.iterations)
        scale_lr(optimiser, scale)
        losses = learn(policy, optimiser, episodes, args)
        if env.detector:
            losses["detector"] = round(env.learn(args.detector_updates, scale), 4)
        every = args.evaluate_every
        if every and (iteration + 1) % every and iteration + 1 < args.iterations:
            continue
        scores = clock.exclude(evaluate, policy, test, EVALUATION_SEED) if every else {}
        log.add(env_steps=collector.steps, cpu_s=round(clock(), 1), **scores, **losses)
        if path:
            save_policy(policy, path, args.id, env.detector, args.option)
            save_progress(args.out, iteration + 1, optimiser, log, clock)
    cpu_s, figures = clock(), {"init": init} if args.init else {}
    if args.disturb:
        figures["disturb"] = args.disturb
    if args.episodes != EPISODES:
        test = evaluation_env(args, EPISODES, env)
    if env.inputs and env.inputs.bag_of_words.words:
        unseen = evaluation_env(args, EPISODES, env, instructions.held_out)
        figures["held_out"] = evaluate(policy, unseen, FINAL_SEED)
    finish(policy, test, args, log, cpu_s, f"distilled from {args.obs}", **figures)
    end_progress(args.out)


if __name__ == "__main__":
    main()
