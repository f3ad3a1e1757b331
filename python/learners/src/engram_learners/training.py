"""Shared parts of the learners: environments in lockstep, and evaluation."""

import argparse
from functools import partial

import numpy as np
import torch

import engram
from engram_learners import instructions
from engram_learners.keyframes import arrivals
from engram_learners.layout import ObservationLayout, tokens_of
from engram_learners.run_log import write_result
from engram_learners.several_tasks import TaskInputs

EVALUATION_SEED = 1_000_000
FINAL_SEED = 2_000_000


def perturbation(text):
    """An axis and its level, of "camera=0.5"."""
    axis, _, level = text.partition("=")
    try:
        return axis, float(level)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} given; AXIS=LEVEL needed") from None


def make_batch(task, num_envs, seed, obs_mode, perturb=None, constants=None, options=None):
    """A batch without early ends: all episodes run to the horizon.

    task: an id, or a list of several. Shorter episodes stand still after their horizon.
    perturb: levels of perturbations, by axis. constants: those that differ from the task's.
    options: of env_options.py.
    """
    options = dict(options or {})
    constants = {**options.pop("constants", {}), **(constants or {})} or None
    return engram.make_vec(
        task,
        num_envs=num_envs,
        seed=seed,
        obs_mode=obs_mode,
        threads=1,
        autoreset_mode="DISABLED",
        after_end="hold",
        terminate_on_success=False,
        language_in_info=False,
        perturb=perturb,
        constants=constants,
        **options,
    )


class ObjectsEnv:
    """Environment with objects observations: the student's rows (N, D) are the labels.

    Attributes:
        horizon: Steps of the longest episodes.
        horizons: Steps (N, 1) of every environment's.
        objects, layout: Layouts of the labels, and of the student's rows.
        parts: By task of several, its environments; empty for one task.

    Args:
        inputs: TaskInputs, of one task that a policy of several plays, or of several.
        wording: Function of the batch at a reset -> the instructions.
        options: Of the environment, from env_options.py.
    """

    detector = None  # only images need one

    def __init__(
        self,
        task,
        num_envs,
        seed=0,
        most_steps=None,
        perturb=None,
        constants=None,
        inputs=None,
        wording=instructions.own,
        options=None,
    ):
        given = {"perturb": perturb, "constants": constants, "options": options}
        self.make_batch = partial(make_batch, task, num_envs, seed, **given)
        self.batch = self.make_batch("objects")
        self.num_envs, description = num_envs, self.batch.description
        tasks = description.get("tasks", [])
        self.inputs = inputs or (TaskInputs(description) if tasks else None)
        self.objects = self.inputs.layout if self.inputs else ObservationLayout(description)
        self.layout = self.objects
        self.wording, self.sentences = wording, []
        self.parts = {
            one["id"]: slice(one["first_env"], one["first_env"] + one["num_envs"]) for one in tasks
        }
        self.horizons = torch.full((num_envs, 1), float(description["horizon"]))
        for one in tasks:
            self.horizons[self.parts[one["id"]]] = one["horizon"]
        self.horizons.clamp_(max=most_steps or description["horizon"])
        self.horizon = int(self.horizons.max())
        self.infos, self.truth, self.narrowed = {}, None, None

    def narrow(self, constants, steps):
        """Ranges of the constants, and steps of the episodes, from the next reset on."""
        self.narrowed, self.horizon = {"constants": constants}, steps
        self.horizons.fill_(steps)

    def reset(self, seed=None):
        """-> observations of the student (N, D)."""
        rows, self.infos = self.batch.reset(seed=seed, options=self.narrowed)
        if self.layout.words:
            self.sentences = self.wording(self.batch)
        self.truth = self.student_rows(rows)
        return self.truth

    def step(self, actions):
        """Actions (N, A) -> observations of the student, rewards (N,)."""
        rows, rewards, _, _, self.infos = self.batch.step(actions.numpy())
        self.truth = self.student_rows(rows)
        return self.truth, torch.from_numpy(np.array(rewards))

    def student_rows(self, rows):
        rows = torch.from_numpy(np.array(rows))
        if self.inputs is None:
            return rows
        if not self.parts:
            rows = self.inputs.of_task(self.batch.description["id"], rows, self.sentences)
            return rows[:, : self.width_of(self.batch.description)]
        return self.inputs.of_batch(rows, self.task_numbers(), self.sentences)

    def task_numbers(self):
        """Number of every environment's task (N,), for a policy of several."""
        if self.parts:
            return torch.from_numpy(np.array(self.infos["task_index"]))
        return self.inputs.numbers_of(self.batch.description["id"], self.num_envs)

    def by_length(self):
        """Environments (E,) whose rows have one horizon and width: horizon, columns (E, W), these.

        The columns are the robot's and those of the objects that a task has.
        """
        columns = [torch.arange(self.truth.shape[1])] * self.num_envs
        for one in self.batch.description.get("tasks", []):
            columns[self.parts[one["id"]]] = [self.columns_of(one)] * one["num_envs"]
        widths = torch.tensor([len(own) for own in columns])
        sizes = torch.stack([self.horizons[:, 0].long(), widths], -1)
        kinds, which = sizes.unique(dim=0, return_inverse=True)
        groups = [(which == i).nonzero()[:, 0] for i in range(len(kinds))]
        return [
            (horizon, torch.stack([columns[i] for i in envs]), envs)
            for horizon, envs in zip(kinds[:, 0].tolist(), groups)
        ]

    def columns_of(self, task):
        """Columns of the rows of one task of several, from its description."""
        return torch.arange(self.width_of(task))

    def width_of(self, task):
        return self.objects.agent + tokens_of(task) * self.objects.width

    def store(self):
        """Called in steps on which a detector is trained."""

    def oracle(self):
        return torch.from_numpy(self.batch.act("oracle")).clamp(-1, 1)


def scale_lr(optimiser, scale):
    """Sets learning rates to a share of the optimiser's initial ones."""
    for group in optimiser.param_groups:
        group["lr"] = scale * group.setdefault("full_lr", group["lr"])


@torch.no_grad()
def evaluate(policy, env, seed, forget=False):
    """Rates of success and of correct first answers; of several tasks, also those of each.

    env: of several tasks, by id.
    forget: the memory is reset whenever an object appears; `resets` counts that, per episode.
    The policy is not computed for episodes whose rates are decided.
    """
    if isinstance(env, dict):
        tasks = {id: evaluate(policy, one, seed, forget) for id, one in env.items()}
        return {**means(tasks), "tasks": tasks}
    layout, rows, state = policy.layout, env.reset(seed=seed), None
    actions = torch.zeros(len(rows), layout.actions)
    played = torch.arange(len(rows))
    resets = 0
    for t in range(env.horizon):
        if t > 0:
            still = ~decided(env.infos)[played]
            if not still.any():
                break
            if still.sum() < 0.8 * len(still):
                played, state = played[still], selected(policy, state, still)
        own = rows[played]
        if forget and state is not None:
            which = appearing(policy, own, state)
            resets += int(which.sum())
            state = policy.reset_state(state, which)
        choice, _, state, _ = policy(own[None], state)
        actions[played] = choice.best()[0]
        rows, _ = env.step(actions)
    found = rates(env.infos, slice(None))
    return {**found, "resets": resets / len(actions)} if forget else found


def appearing(policy, rows, state):
    """Episodes (N,) in which an object appears in a step; state: that before the step."""
    tokens = policy.layout.split(rows)[1]
    bodies = policy.layout.bodies(tokens, policy.layout.pairs(tokens))
    return arrivals(bodies[None], state[0])[0, :, 0] > 0


def forgotten(policy, rows, state):
    """The state before a step, reset in the episodes in which an object appears in it."""
    return policy.reset_state(state, appearing(policy, rows, state))


def decided(infos):
    """Episodes (N,) that have succeeded and, where the task has an answer, have given one."""
    result = infos["success_once"]
    if "answered" in infos:
        result = result & (infos["answered"] | ~infos["_answered"])
    return torch.from_numpy(np.array(result))


def selected(policy, state, which):
    """The state of some environments (N,)."""
    if state is None:
        return None
    states = [one for one, of_it in zip(policy.split(state), which) if of_it]
    return policy.join(states) if states else None


def transfer(policy, ids, episodes=200):
    """Rates in tasks that the policy was not trained on, by id."""
    tasks = {}
    for id in ids:
        env = ObjectsEnv(id, episodes)
        if env.layout.tokens != policy.layout.tokens:
            given = f"{env.layout.tokens} objects in {id}"
            raise ValueError(f"{given}; {policy.layout.tokens} needed, as in training")
        tasks[id] = evaluate(policy, env, FINAL_SEED)
    return tasks


def rates(infos, part):
    """Answers of some environments of a batch, all of one task. None: the task has no answer."""
    answers = infos.get("first_answer_correct")
    if answers is not None and not infos["_first_answer_correct"][part].all():
        answers = None
    return {
        "success_once": float(np.mean(infos["success_once"][part])),
        "first_answer_correct": None if answers is None else float(np.mean(answers[part])),
    }


def means(tasks):
    """Means of the rates of several tasks, and the least success."""
    success = [one["success_once"] for one in tasks.values()]
    answers = [one["first_answer_correct"] for one in tasks.values()]
    answers = [one for one in answers if one is not None]
    return {
        "success_once": float(np.mean(success)),
        "least_success_once": min(success),
        "first_answer_correct": float(np.mean(answers)) if answers else None,
    }


def finish(policy, env, args, log, cpu_s, learner, **figures):
    """Draws the curve; evaluates the policy in 200 new episodes, with and without its memory.

    figures: more of the result.
    """
    several = not isinstance(args.id, str)
    log.draw(f"{f'{len(args.id)} tasks' if several else args.id}, {learner}, seed {args.seed}")
    result = {"id": args.id, "learner": learner, "seed": args.seed, "cpu_s": round(cpu_s, 1)}
    if getattr(args, "perturb", None):
        result["perturb"] = args.perturb
    if getattr(args, "option", None):
        result["options"] = args.option
    result |= figures
    result |= evaluate(policy, env, FINAL_SEED)
    if policy.memory:
        result["wiped"] = evaluate(policy, env, FINAL_SEED, forget=True)
        tasks = result["wiped"].get("tasks") or {args.id: result["wiped"]}
        never = [id for id, of_task in tasks.items() if of_task["resets"] == 0]
        if never:
            print(
                f"wiped: the memory was never reset in {', '.join(never)}, as no object appears "
                "after the first step: these rates say nothing of what it is needed for"
            )
    write_result(result, args.out)
