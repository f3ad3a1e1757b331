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
from policy import Policy, Sight, can_act, groups, recall_loss, shown_first
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
    add("--updates", type=int, default=32, help="per iteration")
    add("--keep", type=int, default=20, help="iterations whose episodes are learnt from")
    add("--batch", type=int, default=128, help="episodes per update")
    add("--lr", type=float, default=3e-3)
    add("--memory-lr", type=float, default=1e-2)
    add("--recall", type=float, default=0.5, help="weight of the loss that tells the cue")
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
        mean, _, _, state, _ = policy(row[None], state)
        rows.append(row)
        labels.append(label)
        action = torch.where(by_expert, label, mean[0]).clamp(-1, 1)
        row = observed(batch.step(action.numpy())[0])
    return torch.stack(rows), torch.stack(labels)


def learn(policy, optimiser, episodes, args):
    rows = torch.cat([r for r, _ in episodes], 1)
    labels = torch.cat([l for _, l in episodes], 1)
    for _ in range(args.updates):
        pick = torch.randint(rows.shape[1], (args.batch,))
        seen, label = rows[:, pick], labels[:, pick]
        mean, _, cue, _, _ = policy(seen)
        counts = can_act(policy.sight, seen).float()
        error = nn.functional.smooth_l1_loss(mean, label, reduction="none", beta=0.3).sum(-1)
        loss = (error * counts).sum() / counts.sum()
        if cue is not None:
            loss = loss + args.recall * recall_loss(cue, shown_first(policy.sight, seen))
        optimiser.zero_grad()
        loss.backward()
        nn.utils.clip_grad_norm_(policy.parameters(), 1.0)
        optimiser.step()
    return loss.item()


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
        episodes.append(collect(policy, batch, 0.5**iteration))
        del episodes[: -args.keep]
        if iteration == 0 and not args.resume:
            policy.fit(episodes[0][0])
        for group, rate in zip(optimiser.param_groups, rates):
            group["lr"] = rate * (1 - iteration / args.iterations)
        loss = learn(policy, optimiser, episodes, args)
        if (iteration + 1) % args.evaluate_every and iteration + 1 < args.iterations:
            continue
        scores = clock.leave_out(success_of, policy, test, EVALUATION_SEED)
        steps = (iteration + 1) * args.envs * batch.description["horizon"]
        log.add(env_steps=steps, cpu_s=round(clock(), 1), **scores, loss=round(loss, 4))
        if path:
            save_policy(policy, path, args.id, not args.no_memory)
    log.draw(f"{args.id}, distilled, seed {args.seed}")
    final = success_of(policy, test, FINAL_SEED)
    forgetful = success_of(policy, test, FINAL_SEED, forget=True)
    print({"final": final, "memory wiped": forgetful, "cpu_s": round(clock(), 1)})


if __name__ == "__main__":
    main()
