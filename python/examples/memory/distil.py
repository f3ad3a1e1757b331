"""Distils engram's oracle into a policy with memory (DAgger), from objects or from images.

The student acts; the oracle, which uses privileged state, labels every visited state with its own
action. The memory's loss uses the student's own observations. Privileged, in training only: the
oracle's actions; with images, the positions of visible objects as well.

    python distil.py --id RememberColor9-VLA-v0 --out runs/color9
    python distil.py --id RememberColor3-VLA-v0 --obs rgb --out runs/pictures
    python distil.py --id ten --out runs/ten
    python distil.py --id short --out runs/short

Several ids make one policy of several tasks, which gets the task as an input: its number, or its
instruction. "ten" are those of several_tasks.py, "short" is the benchmark's short split.
"""

import argparse
from pathlib import Path

import instructions
import torch
from policy import N_APPEARANCES, MemoryLoss, Policy, groups
from rgb_env import RgbEnv
from several_tasks import SETS, TASK_INPUTS, TaskInputs
from torch import nn
from training import (
    EVALUATION_SEED,
    FINAL_SEED,
    Clock,
    Log,
    ObjectsEnv,
    end_progress,
    evaluate,
    finish,
    load_policy,
    load_progress,
    perturbation,
    save_policy,
    save_progress,
    scale_lr,
)

import engram

EPISODES = 200  # of the last evaluation, of each task


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    add = parser.add_argument
    add("--id", nargs="+", default=["RememberColor3-VLA-v0"], help="a task, or several; ten; short")
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
    add("--task-input", choices=TASK_INPUTS, help="of several tasks; default: number; short: words")
    add("--appearances", type=int, help="that the memory distinguishes; default: 20; short: 40")
    add("--hidden", type=int, default=64, help="numbers of the memory of all objects")
    add("--width", type=int, default=64, help="of the action's layers")
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
    add("--episodes", type=int, default=EPISODES, help="of an evaluation before the last, by task")
    args = parser.parse_args()
    if args.tasks is not None:
        engram.load_tasks(args.tasks)
    short = args.id == ["short"]
    args.task_input = args.task_input or ("words" if short else "number")
    args.appearances = args.appearances or (2 if short else 1) * N_APPEARANCES
    if len(args.id) == 1 and args.id[0] in SETS:
        args.id = list(SETS[args.id[0]]())
    if len(args.id) > 1 and args.obs == "rgb":
        parser.error("--obs rgb: one --id needed; several learn from objects")
    if len(set(args.id)) < len(args.id):
        parser.error("--id: an id is given twice")
    args.id = args.id if len(args.id) > 1 else args.id[0]
    args.perturb = dict(args.perturb)
    return args


@torch.no_grad()
def collect(policy, scenes, first):
    """An iteration's episodes: rows (T, N, D) and the oracle's actions.

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
        labels.append(label)
        scenes.store()
        row, _ = scenes.step(torch.where(t < until, label, choice.best()[0]))
    return torch.stack(rows), torch.stack(labels)


def imitation(choice, actions, doubt=0.1):
    """Distance (T, N) of the action from the oracle's.

    A soft minimum over objects: attention learns the oracle's object, and actions are not averaged
    over objects.
    """
    actions = actions[..., None, :].expand_as(choice.mean)
    error = nn.functional.smooth_l1_loss(choice.mean, actions, reduction="none", beta=0.3).sum(-1)
    return -doubt * torch.logsumexp(choice.weights - error / doubt, -1)


def by_length(policy, scenes, rows, actions):
    """An iteration's episodes, whole: by length, rows, actions and the memory's labels."""
    result = []
    for horizon, width, envs in scenes.by_length():
        own = rows[:horizon, envs, :width]
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
    # Steps without motion have less weight: they are frequent and easy.
    weight = torch.where(actions[..., :-1].abs().amax(-1) > 0, 1.0, 0.1)
    choice, recalled, _, _ = policy(rows)
    action = (imitation(choice, actions) * (weight / weight.sum())).sum()
    memory = MemoryLoss.loss(policy, rows, recalled, labels) if policy.memory else torch.zeros(())
    return action, memory


def task_inputs(args, policy):
    """Inputs of a policy of several tasks, those of the policy if there is one; else None."""
    if isinstance(args.id, str):
        return None
    if policy is not None:
        return TaskInputs.like(args.id, policy.layout)
    return TaskInputs.of(args.id, *TASK_INPUTS[args.task_input])


def evaluation_scenes(args, episodes, scenes, wording=instructions.own):
    """Scenes of an evaluation: of several tasks by id, each alone."""
    if args.obs == "rgb":
        return RgbEnv(args.id, episodes, perturb=args.perturb, detector=scenes.detector)
    given = {"perturb": args.perturb, "inputs": scenes.inputs, "wording": wording}
    if isinstance(args.id, str):
        return ObjectsEnv(args.id, episodes, **given)
    return {id: ObjectsEnv(id, episodes, **given) for id in args.id}


def main():
    args = arguments()
    torch.manual_seed(args.seed)
    torch.set_num_threads(1)
    clock, path = Clock(), args.out and args.out / "agent.pt"
    resumed = args.resume and path.exists()
    policy, detector, _ = load_policy(path) if resumed else (None, None, None)
    given = (args.id, args.envs, args.seed, args.most_steps, args.perturb)
    if args.obs == "rgb":
        scenes = RgbEnv(*given, detector)
    else:
        scenes = ObjectsEnv(*given, task_inputs(args, policy), instructions.drawn)
    test = evaluation_scenes(args, args.episodes, scenes)
    sizes = {"appearances": args.appearances, "hidden": args.hidden, "width": args.width}
    policy = policy or Policy(scenes.layout, not args.no_memory, **sizes)
    optimiser = torch.optim.Adam(groups(policy, args.lr, args.memory_lr, args.perception_lr))
    log, episodes = Log(args.out), []
    start = load_progress(args.out, optimiser, log, clock) if resumed else 0
    scenes.reset(seed=args.seed + 1000 * start)
    for iteration in range(start, args.iterations):
        rows, actions = collect(policy, scenes, first=iteration == 0 and not resumed)
        if iteration == 0 and not resumed:
            seen = [rows[:horizon, envs].flatten(0, 1) for horizon, _, envs in scenes.by_length()]
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
            save_progress(args.out, iteration + 1, optimiser, log, clock)
    cpu_s, figures = clock(), {}
    if args.episodes != EPISODES:
        test = evaluation_scenes(args, EPISODES, scenes)
    if scenes.inputs and scenes.inputs.bag.words:
        unseen = evaluation_scenes(args, EPISODES, scenes, instructions.held_out)
        figures["held_out"] = evaluate(policy, unseen, FINAL_SEED)
    finish(policy, test, args, log, cpu_s, f"distilled from {args.obs}", **figures)
    end_progress(args.out)


if __name__ == "__main__":
    main()
