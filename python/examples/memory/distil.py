"""Distils engram's oracle into a policy that remembers (DAgger).

The student sees objects (``obs_mode="objects"``) and acts; the oracle, which knows what is hidden,
says what it would do in every state that the student gets to. The memory is trained to tell the cue,
which the student has seen itself. Privileged: the oracle's actions, in training only.

    python distil.py --id RememberColor9-VLA-v0 --out runs/color9
"""

import argparse
from pathlib import Path

import torch
from play import Clock, Log, load_policy, make_batch, observed, save_policy, success_of
from policy import Policy, Recollection, Sight, groups
from torch import nn

EVALUATION_SEED = 1_000_000
FINAL_SEED = 2_000_000


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    add = parser.add_argument
    add("--id", default="RememberColor3-VLA-v0")
    add("--seed", type=int, default=1)
    add("--out", type=Path, help="folder for log.csv, curve.png, agent.pt")
    add("--resume", action="store_true", help="go on with the agent.pt of --out")
    add("--no-memory", action="store_true")
    add("--envs", type=int, default=128, help="episodes per iteration")
    add("--iterations", type=int, default=10)
    add("--updates", type=int, default=64, help="per iteration")
    add("--keep", type=int, default=20, help="iterations whose episodes are learnt from")
    add("--batch", type=int, default=1600, help="steps per update")
    add("--lr", type=float, default=3e-3)
    add("--memory-lr", type=float, default=1e-2)
    add("--recall", type=float, default=1.0, help="weight of the loss that tells the cue")
    add("--evaluate-every", type=int, default=2)
    return parser.parse_args()


@torch.no_grad()
def collect(policy, batch, expert_share):
    """An iteration's episodes: rows (T, N, D) and the oracle's actions."""
    rows, labels, state = [], [], None
    row = observed(batch.reset()[0])
    by_expert = torch.rand(batch.num_envs, 1) < expert_share
    for _ in range(batch.description["horizon"]):
        label = torch.from_numpy(batch.act("oracle")).clamp(-1, 1)
        choice, _, state, _ = policy(row[None], state)
        rows.append(row)
        labels.append(label)
        action = torch.where(by_expert, label, choice.best()[0])
        row = observed(batch.step(action.numpy())[0])
    return torch.stack(rows), torch.stack(labels)


def imitation(choice, actions, doubt=0.1):
    """How far (T, N) the action is from the oracle's. The object for which it fits best counts
    most: so attention learns which one the oracle means, and no action is a mean of several."""
    actions = actions[..., None, :].expand_as(choice.mean)
    error = nn.functional.smooth_l1_loss(choice.mean, actions, reduction="none", beta=0.3).sum(-1)
    return -doubt * torch.logsumexp(choice.weights - error / doubt, -1)


def learn(policy, optimiser, episodes, args):
    rows, actions, *labels = (torch.cat(parts, 1) for parts in zip(*episodes))
    # Before its first move the oracle waits, often because the robot is held: that is soon learnt.
    moved = (actions[..., :-1].abs().amax(-1) > 0).cummax(0).values
    weights = torch.where(moved, 1.0, 0.1)
    sums = {"hand": 0.0, "memory": 0.0}
    for _ in range(args.updates):
        pick = torch.randint(rows.shape[1], (max(1, args.batch // len(rows)),))
        seen = rows[:, pick]
        choice, recalled, _, _ = policy(seen)
        counts = weights[:, pick]
        loss = (imitation(choice, actions[:, pick]) * counts).sum() / counts.sum()
        sums["hand"] += loss.item() / args.updates
        if policy.memory:
            recall = Recollection.loss(policy, seen, recalled, [x[:, pick] for x in labels])
            sums["memory"] += recall.item() / args.updates
            loss = loss + args.recall * recall
        optimiser.zero_grad()
        loss.backward()
        nn.utils.clip_grad_norm_(policy.parameters(), 1.0)
        optimiser.step()
    return {name: round(value, 4) for name, value in sums.items()}


def main():
    args = arguments()
    torch.manual_seed(args.seed)
    torch.set_num_threads(1)
    batch = make_batch(args.id, args.envs, seed=args.seed)
    test = make_batch(args.id, 200)
    path = args.out and args.out / "agent.pt"
    if args.resume and path.exists():
        policy, _ = load_policy(path)
    else:
        policy = Policy(Sight(batch.description), memory=not args.no_memory)
    optimiser = torch.optim.Adam(groups(policy, args.lr, args.memory_lr))
    rates = [group["lr"] for group in optimiser.param_groups]
    log, clock, episodes = Log(args.out), Clock(), []
    batch.reset(seed=args.seed)
    for iteration in range(args.iterations):
        rows, actions = collect(policy, batch, 0.5**iteration)
        if iteration == 0 and not args.resume:
            policy.fit(rows)
        episodes.append((rows, actions, *Recollection.labels(policy, rows)))
        del episodes[: -args.keep]
        for group, rate in zip(optimiser.param_groups, rates):
            group["lr"] = rate * min(1, 2 - 2 * iteration / args.iterations)
        losses = learn(policy, optimiser, episodes, args)
        if (iteration + 1) % args.evaluate_every and iteration + 1 < args.iterations:
            continue
        scores = clock.leave_out(success_of, policy, test, EVALUATION_SEED)
        steps = (iteration + 1) * args.envs * batch.description["horizon"]
        log.add(env_steps=steps, cpu_s=round(clock(), 1), **scores, **losses)
        if path:
            save_policy(policy, path, args.id, not args.no_memory)
    log.draw(f"{args.id}, distilled, seed {args.seed}")
    final = success_of(policy, test, FINAL_SEED)
    forgetful = success_of(policy, test, FINAL_SEED, forget=True)
    print({"final": final, "memory wiped": forgetful, "cpu_s": round(clock(), 1)})


if __name__ == "__main__":
    main()
