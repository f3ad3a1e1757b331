"""Shared parts of the learners: episodes in lockstep, evaluation, checkpoints and logs."""

import csv
import json
import time
from pathlib import Path

import numpy as np
import torch
from object_detector import ObjectDetector, detector_layout
from policy import ObservationLayout, Policy, arrivals

import engram

EVALUATION_SEED = 1_000_000
FINAL_SEED = 2_000_000


def make_batch(task, num_envs, seed, obs_mode):
    """A batch without early ends: all episodes run to the horizon."""
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
    )


class ObjectsEnv:
    """Environment with objects observations: the student's rows (N, D) are the labels."""

    detector = None  # only images need one

    def __init__(self, task, num_envs, seed=0, most_steps=None):
        self.batch = make_batch(task, num_envs, seed, "objects")
        self.num_envs, self.horizon = num_envs, self.batch.description["horizon"]
        self.horizon = min(self.horizon, most_steps or self.horizon)
        self.layout = ObservationLayout(self.batch.description)
        self.infos, self.truth = {}, None

    def reset(self, seed=None):
        """-> observations of the student (N, D)."""
        self.truth = torch.from_numpy(np.array(self.batch.reset(seed=seed)[0]))
        return self.truth

    def step(self, actions):
        """Actions (N, 7) -> observations of the student, rewards (N,)."""
        rows, rewards, _, _, self.infos = self.batch.step(actions.numpy())
        self.truth = torch.from_numpy(np.array(rows))
        return self.truth, torch.from_numpy(np.array(rewards))

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
    """Rates of success and of correct first answers.

    forget: the memory is reset whenever an object appears.
    """
    layout, rows, state = policy.layout, scenes.reset(seed=seed), None
    for _ in range(scenes.horizon):
        if forget and state is not None:
            tokens = layout.split(rows)[1]
            bodies = layout.bodies(tokens, layout.pairs(tokens))
            state = policy.wipe(state, arrivals(bodies[None], state[0])[0, :, 0] > 0)
        choice, _, state, _ = policy(rows[None], state)
        rows, _ = scenes.step(choice.best()[0])
    answers = scenes.infos.get("first_answer_correct")
    return {
        "success_once": float(np.mean(scenes.infos["success_once"])),
        "first_answer_correct": None if answers is None else float(np.mean(answers)),
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

    def add(self, **row):
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
        """FOLDER/curve.png: success and first answers over processor time."""
        if self.folder is None:
            return
        import matplotlib

        matplotlib.use("Agg")
        from matplotlib import pyplot

        figure, axes = pyplot.subplots(figsize=(6, 3.5))
        for name in ("success_once", "first_answer_correct"):
            if self.rows[0][name] is not None:
                axes.plot([r["cpu_s"] for r in self.rows], [r[name] for r in self.rows], label=name)
        axes.set(title=title, xlabel="processor seconds", ylim=(0, 1.02))
        axes.legend()
        axes.grid(alpha=0.3)
        figure.tight_layout()
        figure.savefig(self.folder / "curve.png", dpi=120)
        pyplot.close(figure)


def finish(policy, scenes, args, log, cpu_s, learner):
    """Draws the curve; evaluates the policy in 200 new episodes, with and without its memory."""
    log.draw(f"{args.id}, {learner}, seed {args.seed}")
    result = {"id": args.id, "learner": learner, "seed": args.seed, "cpu_s": round(cpu_s, 1)}
    result |= evaluate(policy, scenes, FINAL_SEED)
    if policy.memory:
        result["wiped"] = evaluate(policy, scenes, FINAL_SEED, forget=True)
    if args.out:
        partial = args.out / "result.part"
        partial.write_text(json.dumps(result) + "\n")
        partial.replace(args.out / "result.json")
    print(json.dumps(result), flush=True)


def save_policy(policy, path, task, detector=None):
    path.parent.mkdir(parents=True, exist_ok=True)
    saved = {"task": task, "memory": policy.memory, "weights": policy.state_dict()}
    if detector is not None:
        saved["detector"] = detector.state_dict()
    torch.save(saved, path)


def load_policy(path):
    """-> policy, its ObjectDetector (None for objects observations), its task."""
    saved = torch.load(Path(path), weights_only=True)
    layout, detector = ObservationLayout(engram.describe(saved["task"], obs_mode="objects")), None
    if "detector" in saved:
        detector = ObjectDetector(saved["detector"]["appearances"], saved["detector"]["templates"])
        detector.load_state_dict(saved["detector"])
        layout = detector_layout(layout, detector.appearances)
    policy = Policy(layout, memory=saved["memory"])
    try:
        policy.load_state_dict(saved["weights"])
    except RuntimeError as error:
        raise ValueError(f"{path}: weights of another version of policy.py") from error
    return policy, detector, saved["task"]
