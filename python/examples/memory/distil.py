"""Distils engram's oracle into a policy with memory (DAgger), from objects or from images.

The student acts; the oracle, which uses privileged state, labels every visited state with its own
action. The memory's loss uses the student's own observations. Privileged, in training only: the
oracle's actions; with images, the positions of visible objects as well.

    python distil.py --id RememberColor9-VLA-v0 --out runs/color9
    python distil.py --id RememberColor3-VLA-v0 --obs rgb --out runs/pictures
    python distil.py --id ten --out runs/ten

Several ids make one policy of several tasks, which gets the task as an input. "ten" are those of
several_tasks.py.
"""

import argparse
import math
from pathlib import Path

import numpy as np
import torch
from memory_loss import MemoryLoss
from policy import N_APPEARANCES, Policy, groups
from rgb_env import RgbEnv
from several_tasks import TEN
from torch import nn
from training import (
    EVALUATION_SEED,
    Clock,
    Log,
    ObjectsEnv,
    evaluate,
    finish,
    load_policy,
    perturbation,
    save_policy,
    scale_lr,
)

import engram

RESTING = 0.1  # greatest part of an action that is no motion


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    add = parser.add_argument
    add("--id", nargs="+", default=["RememberColor3-VLA-v0"], help="a task, or several; or: ten")
    add("--tasks", type=Path, help="file of tasks of your own, for its ids (docs/own_tasks.md)")
    add("--obs", default="objects", choices=["objects", "rgb"])
    add(
        "--perturb",
        nargs="+",
        default=[],
        type=perturbation,
        metavar="AXIS=LEVEL",
        help="of training and test: docs/perturbations.md",
    )
    add("--seed", type=int, default=1)
    add("--out", type=Path, help="folder for log.csv, curve.png, agent.pt, result.json")
    add("--resume", action="store_true", help="continue with the agent.pt of --out")
    add("--no-memory", action="store_true")
    add("--appearances", type=int, default=N_APPEARANCES, help="that the memory distinguishes")
    add("--envs", type=int, default=128, help="episodes per iteration")
    add("--most-steps", type=int, default=120, help="of a training episode")
    add("--iterations", type=int, default=14)
    add("--updates", type=int, default=64, help="per iteration")
    add("--detector-updates", type=int, default=80, help="per iteration, from images")
    add("--keep", type=int, default=20, help="iterations whose episodes are trained on")
    add("--batch", type=int, default=1600, help="steps per update")
    add("--lr", type=float, default=3e-3)
    add("--memory-lr", type=float, default=1e-2)
    add("--perception-lr", type=float, default=3e-3, help="of encoder and attention")
    add("--recall", type=float, default=1.0, help="weight of the memory's loss")
    add("--evaluate-every", type=int, default=4, help="iterations")
    args = parser.parse_args()
    if args.tasks is not None:
        engram.load_tasks(args.tasks)
    args.id = list(TEN) if args.id == ["ten"] else args.id
    if len(args.id) > 1 and args.obs == "rgb":
        parser.error("--obs rgb: one --id needed; several learn from objects")
    if len(set(args.id)) < len(args.id):
        parser.error("--id: an id is given twice")
    args.id = args.id if len(args.id) > 1 else args.id[0]
    args.perturb = dict(args.perturb)
    return args


@torch.no_grad()
def collect(policy, scenes, first):
    """An iteration's episodes: rows (T, N, D) and the oracle's actions; NaN after an early end.

    The oracle's actions are used in the first iteration, and in half of the later episodes up to a
    random step: so training covers late states even if the student fails early.
    """
    rows, labels, state = [], [], None
    row = scenes.reset()
    guided, until = torch.rand(2, scenes.num_envs, 1)
    until = scenes.horizons * (torch.ones_like(until) if first else until * (guided < 0.5))
    for t in range(scenes.horizon):
        label = scenes.oracle()
        choice, _, state, _ = policy(row[None], state)
        rows.append(scenes.truth)
        scenes.store()
        row, _ = scenes.step(torch.where(t < until, label, choice.best()[0]))
        ended = torch.from_numpy(np.array(scenes.infos["elapsed_steps"])) <= t
        labels.append(label.masked_fill(ended[:, None], math.nan))
    return torch.stack(rows), torch.stack(labels)


def limited(actions):
    """Parts of actions that stand for larger ones: all are limited to 1, a rotation by its norm."""
    result = actions.abs() >= 1
    unit = (actions[..., 3:6].norm(dim=-1, keepdim=True) - 1).abs() < 1e-3
    result[..., 3:6] |= unit
    return result


def imitation(choice, actions, doubt=0.1):
    """Distance (T, N) of the action from the oracle's.

    A soft minimum over objects: attention learns the oracle's object, and actions are not averaged
    over objects. It may exceed an action that the oracle has limited. Steps without a label (NaN)
    have no distance.
    """
    labelled = actions.isfinite().all(-1)
    actions = actions.nan_to_num()[..., None, :].expand_as(choice.mean)
    exceeds = limited(actions) & (choice.mean * actions.sign() > actions.abs())
    mean = torch.where(exceeds, actions, choice.mean)
    error = nn.functional.smooth_l1_loss(mean, actions, reduction="none", beta=0.3).sum(-1)
    return -doubt * torch.logsumexp(choice.weights - error / doubt, -1) * labelled


def by_length(policy, scenes, rows, actions):
    """An iteration's episodes, whole: by length, rows, actions and the memory's labels."""
    result = []
    for horizon, envs in scenes.by_length():
        own = rows[:horizon, envs]
        result.append((own, actions[:horizon, envs], *MemoryLoss.labels(policy, own)))
    return result


def learn(policy, optimiser, episodes, args):
    """episodes: by iteration, what `by_length` returns."""
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
            action, memory = losses_of(policy, *picked)
            sums["action"] += share * action.item() / args.updates
            sums["memory"] += share * memory.item() / args.updates
            total = total + share * (action + args.recall * memory)
        optimiser.zero_grad()
        total.backward()
        nn.utils.clip_grad_norm_(policy.parameters(), 1.0)
        optimiser.step()
    return {name: round(value, 4) for name, value in sums.items()}


def losses_of(policy, rows, actions, *labels):
    """Losses of actions and memory in whole episodes of one length."""
    choice, recalled, _, _ = policy(rows)
    # Steps in which neither moves have less weight: they are frequent and easy.
    moves = choice.best()[..., :-1].detach().abs().amax(-1) > RESTING
    moves |= actions[..., :-1].abs().amax(-1) > 0
    weight = torch.where(moves & actions.isfinite().all(-1), 1.0, 0.1)
    action = (imitation(choice, actions) * (weight / weight.sum())).sum()
    memory = MemoryLoss.loss(policy, rows, recalled, labels) if policy.memory else torch.zeros(())
    return action, memory


def main():
    args = arguments()
    torch.manual_seed(args.seed)
    torch.set_num_threads(1)
    clock, path = Clock(), args.out and args.out / "agent.pt"
    resumed = args.resume and path.exists()
    policy, detector, _ = load_policy(path) if resumed else (None, None, None)
    if args.obs == "rgb":
        scenes = RgbEnv(args.id, args.envs, args.seed, args.most_steps, args.perturb, detector)
        test = RgbEnv(args.id, 200, perturb=args.perturb, detector=scenes.detector)
    else:
        scenes = ObjectsEnv(args.id, args.envs, args.seed, args.most_steps, args.perturb)
        test = ObjectsEnv(args.id, 200 * max(1, len(scenes.parts)), perturb=args.perturb)
    policy = policy or Policy(scenes.layout, not args.no_memory, args.appearances)
    optimiser = torch.optim.Adam(groups(policy, args.lr, args.memory_lr, args.perception_lr))
    log, episodes = Log(args.out), []
    scenes.reset(seed=args.seed)
    for iteration in range(args.iterations):
        rows, actions = collect(policy, scenes, first=iteration == 0 and not resumed)
        if iteration == 0 and not resumed:
            seen = [rows[:horizon, envs].flatten(0, 1) for horizon, envs in scenes.by_length()]
            policy.fit(torch.cat(seen))
        episodes.append(by_length(policy, scenes, rows, actions))
        del episodes[: -args.keep]
        scale = min(1, 2 - 2 * iteration / args.iterations)
        scale_lr(optimiser, scale)
        losses = learn(policy, optimiser, episodes, args)
        if scenes.detector:
            losses["detector"] = round(scenes.learn(args.detector_updates, scale), 4)
        if (iteration + 1) % args.evaluate_every and iteration + 1 < args.iterations:
            continue
        scores = clock.exclude(evaluate, policy, test, EVALUATION_SEED)
        steps = (iteration + 1) * int(scenes.horizons.sum())
        log.add(env_steps=steps, cpu_s=round(clock(), 1), **scores, **losses)
        if path:
            save_policy(policy, path, args.id, scenes.detector)
    finish(policy, test, args, log, clock(), f"distilled from {args.obs}")


if __name__ == "__main__":
    main()
