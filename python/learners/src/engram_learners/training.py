"""Shared parts of the learners: episodes in lockstep, evaluation, checkpoints and logs."""

import argparse
import csv
import json
import time
from functools import partial
from pathlib import Path

import numpy as np
import torch

import engram
from engram_learners import instructions
from engram_learners.images.detector import ObjectDetector, detector_layout
from engram_learners.keyframes import arrivals
from engram_learners.policy import ObservationLayout, Policy, tokens_of
from engram_learners.several_tasks import TaskInputs
from engram_learners.zoo.policy import ZooPolicy

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


class Clock:
    """Processor seconds of collecting and learning, without evaluations."""

    def __init__(self):
        # The first optimiser imports most of torch, which does not count.
        torch.optim.Adam([torch.zeros(1, requires_grad=True)])
        self.start, self.out = time.process_time(), 0.0

    def __call__(self):
        return time.process_time() - self.start - self.out

    def exclude(self, function, *arguments):
        begin = time.process_time()
        result = function(*arguments)
        self.out += time.process_time() - begin
        return result


def scale_lr(optimiser, scale):
    """Sets learning rates to a share of the optimiser's initial ones."""
    for group in optimiser.param_groups:
        group["lr"] = scale * group.setdefault("full_lr", group["lr"])


@torch.no_grad()
def evaluate(policy, scenes, seed, forget=False):
    """Rates of success and of correct first answers; of several tasks, also those of each.

    scenes: of several tasks, by id.
    forget: the memory is reset whenever an object appears.
    The policy is not computed for episodes whose rates are decided.
    """
    if isinstance(scenes, dict):
        tasks = {id: evaluate(policy, one, seed, forget) for id, one in scenes.items()}
        return {**means(tasks), "tasks": tasks}
    layout, rows, state = policy.layout, scenes.reset(seed=seed), None
    actions = torch.zeros(len(rows), layout.actions)
    played = torch.arange(len(rows))
    for t in range(scenes.horizon):
        if t > 0:
            still = ~decided(scenes.infos)[played]
            if not still.any():
                break
            if still.sum() < 0.8 * len(still):
                played, state = played[still], selected(policy, state, still)
        own = rows[played]
        if forget and state is not None:
            state = forgotten(policy, own, state)
        choice, _, state, _ = policy(own[None], state)
        actions[played] = choice.best()[0]
        rows, _ = scenes.step(actions)
    return rates(scenes.infos, slice(None))


def forgotten(policy, rows, state):
    """The state before a step, reset in the episodes (N,) in which an object appears in it."""
    tokens = policy.layout.split(rows)[1]
    bodies = policy.layout.bodies(tokens, policy.layout.pairs(tokens))
    return policy.wipe(state, arrivals(bodies[None], state[0])[0, :, 0] > 0)


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
    return policy.join([one for one, of_it in zip(policy.split(state), which) if of_it])


def transfer(policy, ids, episodes=200):
    """Rates in tasks that the policy was not trained on, by id."""
    tasks = {}
    for id in ids:
        scenes = ObjectsEnv(id, episodes)
        if scenes.layout.tokens != policy.layout.tokens:
            given = f"{scenes.layout.tokens} objects in {id}"
            raise ValueError(f"{given}; {policy.layout.tokens} needed, as in training")
        tasks[id] = evaluate(policy, scenes, FINAL_SEED)
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


class Log:
    """A row per evaluation: printed, and in FOLDER/log.csv and TensorBoard's files there."""

    def __init__(self, folder):
        self.folder, self.rows, self.board = folder, [], None
        if folder is None:
            return
        folder.mkdir(parents=True, exist_ok=True)
        try:
            from torch.utils.tensorboard import SummaryWriter

            self.board = SummaryWriter(str(folder))
        except ImportError:
            pass  # optional: there are log.csv and the curve

    def add(self, tasks=None, **row):
        """tasks: rates by task of several, which get a column each."""
        for id, one in (tasks or {}).items():
            row |= {f"{id} {name}": rate for name, rate in one.items()}
        self.rows.append(row)
        print(json.dumps(row), flush=True)
        if self.folder is None:
            return
        with (self.folder / "log.csv").open("w", newline="") as file:
            writer = csv.DictWriter(file, self.rows[0])
            writer.writeheader()
            writer.writerows(self.rows)
        if self.board is not None:
            for name, value in row.items():
                if isinstance(value, (int, float)):
                    self.board.add_scalar(name, value, row["env_steps"])
            self.board.flush()

    def draw(self, title):
        """FOLDER/curve.png: success and first answers over processor time.

        Of several tasks: the success of each, and the mean.
        """
        if self.folder is None or not self.rows or "success_once" not in self.rows[0]:
            return
        import matplotlib

        matplotlib.use("Agg")
        from matplotlib import pyplot

        of_tasks = [name for name in self.rows[0] if name.endswith(" success_once")]
        figure, axes = pyplot.subplots(figsize=(8, 4.5) if of_tasks else (6, 3.5))
        times = [row["cpu_s"] for row in self.rows]
        for i, name in enumerate(of_tasks or ("success_once", "first_answer_correct")):
            if self.rows[0][name] is not None:
                style = {"linestyle": ("-", "--", ":")[i // 10 % 3]} if of_tasks else {}
                label = name.split()[0]
                axes.plot(times, [row[name] for row in self.rows], label=label, **style)
        if of_tasks:
            mean = [row["success_once"] for row in self.rows]
            axes.plot(times, mean, "k", linewidth=2.5, label="mean")
            axes.set(ylabel="success_once")
        axes.set(title=title, xlabel="processor seconds", ylim=(0, 1.02))
        axes.legend(fontsize=7 if of_tasks else None)
        axes.grid(alpha=0.3)
        figure.tight_layout()
        figure.savefig(self.folder / "curve.png", dpi=120)
        pyplot.close(figure)


def finish(policy, scenes, args, log, cpu_s, learner, **figures):
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
    result |= evaluate(policy, scenes, FINAL_SEED)
    if policy.memory:
        result["wiped"] = evaluate(policy, scenes, FINAL_SEED, forget=True)
    write_result(result, args.out)


def write_result(result, folder):
    """Prints a run's result, and writes FOLDER/result.json if there is a folder."""
    text = json.dumps(result)
    if folder:
        write_whole(folder / "result.json", lambda part: part.write_text(text + "\n"))
    print(text, flush=True)


def save_policy(policy, path, task, detector=None, options=None):
    """task: an id, or a list of several; options: of its environment."""
    path.parent.mkdir(parents=True, exist_ok=True)
    saved = {"task": task, "memory": policy.memory, "weights": policy.state_dict()}
    if isinstance(policy, ZooPolicy):
        saved |= {"kind": policy.kind, "size": policy.remember.size}
    else:
        saved["sizes"] = policy.sizes
        saved["task_inputs"] = {
            "words": policy.layout.words,
            "numbered": policy.layout.tasks > 0,
        }
    if detector is not None:
        saved["detector"] = detector.state_dict()
    if options:
        saved["options"] = options
    write_whole(path, lambda part: torch.save(saved, part))


def write_whole(path, write):
    """Writes a file, by a function of a path, that is whole whenever the run is cut off."""
    part = path.with_suffix(".part")
    write(part)
    part.replace(path)


def load_policy(path, task=None, options=None):
    """-> policy, its ObjectDetector (None for objects observations), its task or tasks.

    task: another task for the policy, or several, and the options of its environment; None: what it
    was trained on.
    """
    saved = torch.load(Path(path), weights_only=True)
    if task is None:
        task_of_layout, options = saved["task"], saved.get("options")
    else:
        task_of_layout = task
    layout, detector = layout_of(task_of_layout, saved.get("task_inputs", {}), options), None
    if "detector" in saved:
        detector = ObjectDetector.of_weights(saved["detector"])
        layout = detector_layout(layout, len(detector.tokens))
    if "kind" in saved:
        policy = ZooPolicy(layout, saved["kind"], saved["size"])
    else:
        policy = Policy(layout, saved["memory"], **saved.get("sizes", {}))
    try:
        policy.load_state_dict(saved["weights"])
    except RuntimeError as error:
        given = "another version of the policy" if task is None else "a policy that does not fit"
        raise ValueError(f"{path}: weights of {given}") from error
    return policy, detector, saved["task"]


def options_of(path):
    """Options of the environment that the policy of an agent.pt was trained with."""
    return torch.load(Path(path), weights_only=True).get("options", {})


def save_progress(folder, iterations, optimiser, log, clock):
    """What a run that is cut off needs beside agent.pt. iterations: those that are done."""
    saved = {"iterations": iterations, "cpu_s": clock(), "optimiser": optimiser.state_dict()}
    saved["rows"] = log.rows
    write_whole(folder / "progress.pt", lambda part: torch.save(saved, part))


def load_progress(folder, optimiser, log, clock):
    """-> iterations that are done: 0 if the run has ended, and another one begins."""
    path = folder / "progress.pt"
    if not path.exists():
        return 0
    saved = torch.load(path, weights_only=True)
    optimiser.load_state_dict(saved["optimiser"])
    log.rows = saved["rows"]
    clock.out -= saved["cpu_s"]
    return saved["iterations"]


def end_progress(folder):
    if folder is not None:
        (folder / "progress.pt").unlink(missing_ok=True)


def layout_of(task, inputs, options=None):
    """Layout of a policy's inputs, for an id or several. inputs: arguments of TaskInputs."""
    options = options or {}
    if isinstance(task, str):
        return ObservationLayout(engram.describe(task, obs_mode="objects", **options))
    return TaskInputs.of(task, **inputs, options=options).layout
