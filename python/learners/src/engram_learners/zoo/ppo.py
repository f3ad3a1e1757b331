"""PPO with one of nine memories, from objects: whole episodes in lockstep.

The policy learns from the reward alone. Whatever the memory, encoder, action head, steps, passes
and learning rate are the same, and the memories have equally many parameters. The algorithm is that
of ppo_recurrent.py, without its auxiliary loss. A step's action has two parts, an object and then
the hand's action for it: what is explored is which object is meant.

    python -m engram_learners.zoo.ppo --memory gru --out runs/gru
    python -m engram_learners.zoo.ppo --memory lru --test RememberColor3-Long-VLA-v0 --out runs/lru
"""

import torch
from torch.distributions import Categorical, Normal

from engram_learners import memories, ppo_recurrent
from engram_learners.checkpoints import load_policy, save_policy
from engram_learners.ppo_recurrent import Agent, AgentOutput, RewardScale, collect, learn
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
    ppo_recurrent.add_to(
        parser, steps=400_000, update_epochs=4, minibatches=4, gamma=0.97, entropy=0.01
    )
    return parser.parse_args()


class ObjectThenAction:
    """Distribution of an object and of the action for it, (..., actions + 1): the object is last.

    Log probabilities and entropies have the same shape.
    """

    def __init__(self, choice):
        self.objects = Categorical(logits=choice.weights)
        self.mean = choice.mean.clamp(-1.5, 1.5)  # a servo's can be far beyond what acts
        self.std = choice.log_std.exp()

    def action_for(self, which):
        own = which[..., None, None]
        mean, std = (part.take_along_dim(own, -2)[..., 0, :] for part in (self.mean, self.std))
        return Normal(mean, std)

    def sample(self):
        which = self.objects.sample()
        return torch.cat([self.action_for(which).sample(), which[..., None]], -1)

    def log_prob(self, sample):
        which = sample[..., -1].long()
        action = self.action_for(which).log_prob(sample[..., :-1])
        return torch.cat([action, self.objects.log_prob(which)[..., None]], -1)

    def entropy(self):
        share = self.objects.probs[..., None]
        action = (share * Normal(self.mean, self.std).entropy()).sum(-2)
        return torch.cat([action, self.objects.entropy()[..., None]], -1)


class ZooAgent(Agent):
    def forward(self, rows, state=None):
        output = self.policy(rows, state)
        value = self.critic(output.context)[..., 0]
        return AgentOutput(ObjectThenAction(output.choice), value, output.recalled, output.state)


def main():
    args = arguments()
    torch.manual_seed(args.seed)
    torch.set_num_threads(1)
    clock, path = Clock(), args.out and args.out / "agent.pt"
    env, test = ObjectsEnv(args.id, args.envs, args.seed), ObjectsEnv(args.id, 200)
    if args.resume and path.exists():
        agent = ZooAgent(load_policy(path).policy)
    else:
        size = memories.size_for(args.memory, budget=args.parameters)
        agent = ZooAgent(ZooPolicy(env.layout, args.memory, size))
    agent(env.reset(seed=args.seed)[None])  # the critic takes its size from this
    if not (args.resume and path.exists()):
        agent.policy.fit(collect(agent, env).rows)
    optimiser = torch.optim.Adam(agent.parameters(), args.lr)
    log, scale, policy = Log(args.out), RewardScale(args.gamma), agent.policy
    per_iteration = args.envs * env.horizon
    iterations = max(1, args.steps // per_iteration)
    for iteration in range(iterations):
        scale_lr(optimiser, 1 - iteration / iterations)
        learn(agent, optimiser, collect(agent, env), scale, args)
        if (iteration + 1) % args.evaluate_every and iteration + 1 < iterations:
            continue
        scores = clock.exclude(evaluate, policy, test, EVALUATION_SEED)
        steps = (iteration + 1) * per_iteration
        log.add(env_steps=steps, cpu_s=round(clock(), 1), **scores)
        if path:
            save_policy(policy, path, args.id)
    cpu_s = clock()
    figures = {**policy.figures(cpu_s, steps), "transfer": transfer(policy, args.test)}
    finish(policy, test, args, log, cpu_s, f"PPO, {policy.kind}", **figures)


if __name__ == "__main__":
    main()
