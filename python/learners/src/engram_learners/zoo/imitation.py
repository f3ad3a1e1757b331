"""Imitation of engram's oracle (DAgger) with one of nine memories, from objects.

The policy acts; the oracle, which uses privileged state, labels every visited state with its own
action. Nothing else is learnt from. Whatever the memory, encoder, action head, steps, updates and
learning rate are the same, and the memories have equally many parameters.

    python -m engram_learners.zoo.imitation --memory gru --out runs/gru
    python -m engram_learners.zoo.imitation --memory mamba --test RememberColor3-Long-VLA-v0
"""

import torch
from torch import nn

from engram_learners import memories
from engram_learners.checkpoints import load_policy, save_policy
from engram_learners.distil import collect, imitation
from engram_learners.run_log import Clock, Log
from engram_learners.training import (
    EVALUATION_SEED,
    ObjectsEnv,
    evaluate,
    finish,
    scale_lr,
    transfer,
)
from engram_learners.zoo.policy import ZooPolicy, zoo_parser


def arguments():
    parser = zoo_parser(__doc__)
    add = parser.add_argument
    add("--envs", type=int, default=128, help="episodes per iteration")
    add("--most-steps", type=int, default=120, help="of a training episode")
    add("--iterations", type=int, default=16)
    add("--updates", type=int, default=64, help="per iteration")
    add("--batch", type=int, default=1200, help="steps per update")
    add("--lr", type=float, default=3e-3)
    add("--evaluate-every", type=int, default=5, help="iterations")
    return parser.parse_args()


def learn(policy, optimiser, rows, actions, args):
    """Updates with whole episodes, rows (T, N, D) and the oracle's actions. -> mean loss."""
    # Steps without motion have less weight: they are frequent and easy.
    weight = torch.where(actions[..., :-1].abs().amax(-1) > 0, 1.0, 0.1)
    mean = 0.0
    for _ in range(args.updates):
        pick = torch.randint(rows.shape[1], (max(1, args.batch // len(rows)),))
        error = imitation(policy(rows[:, pick])[0], actions[:, pick])
        loss = (error * weight[:, pick]).sum() / weight[:, pick].sum()
        optimiser.zero_grad()
        loss.backward()
        nn.utils.clip_grad_norm_(policy.parameters(), 1.0)
        optimiser.step()
        mean += loss.item() / args.updates
    return mean


def main():
    args = arguments()
    torch.manual_seed(args.seed)
    torch.set_num_threads(1)
    clock, path = Clock(), args.out and args.out / "agent.pt"
    resumed = args.resume and path.exists()
    env = ObjectsEnv(args.id, args.envs, args.seed, args.most_steps)
    test = ObjectsEnv(args.id, 200)
    if resumed:
        policy = load_policy(path).policy
    else:
        size = memories.size_for(args.memory, budget=args.parameters)
        policy = ZooPolicy(env.layout, args.memory, size)
    optimiser = torch.optim.Adam(policy.parameters(), args.lr)
    log, episodes = Log(args.out), []
    env.reset(seed=args.seed)
    for iteration in range(args.iterations):
        episodes.append(collect(policy, env, first=iteration == 0 and not resumed))
        if iteration == 0 and not resumed:
            policy.fit(episodes[0][0])
        rows, actions = (torch.cat(parts, 1) for parts in zip(*episodes))
        scale_lr(optimiser, min(1, 2 - 2 * iteration / args.iterations))
        loss = learn(policy, optimiser, rows, actions, args)
        if (iteration + 1) % args.evaluate_every and iteration + 1 < args.iterations:
            continue
        scores = clock.exclude(evaluate, policy, test, EVALUATION_SEED)
        steps = (iteration + 1) * args.envs * env.horizon
        log.add(env_steps=steps, cpu_s=round(clock(), 1), **scores, loss=round(loss, 4))
        if path:
            save_policy(policy, path, args.id)
    cpu_s = clock()
    figures = {**policy.figures(cpu_s, steps), "transfer": transfer(policy, args.test)}
    finish(policy, test, args, log, cpu_s, f"imitation, {policy.kind}", **figures)


if __name__ == "__main__":
    main()
