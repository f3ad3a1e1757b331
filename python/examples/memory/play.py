"""Whole episodes of a batch in lockstep, evaluation, checkpoints and logs: what the learners share."""

import csv
import json
import time
from pathlib import Path

import numpy as np
import torch
from policy import Policy, Sight

import engram


def make_batch(task, num_envs, seed=0, **options):
    """A batch whose episodes all last to the horizon."""
    return engram.make_vec(
        task,
        num_envs=num_envs,
        seed=seed,
        obs_mode="objects",
        autoreset_mode="DISABLED",
        terminate_on_success=False,
        language_in_info=False,
        **options,
    )


def observed(batch_observation):
    return torch.from_numpy(np.array(batch_observation))


class Clock:
    """Processor seconds of collecting and learning; evaluations are left out."""

    def __init__(self):
        self.start, self.out = time.process_time(), 0.0

    def __call__(self):
        return time.process_time() - self.start - self.out

    def leave_out(self, function, *arguments):
        begin = time.process_time()
        result = function(*arguments)
        self.out += time.process_time() - begin
        return result


@torch.no_grad()
def success_of(policy, batch, seed, forget=False):
    """Shares of episodes with success and with a right first answer, of the mean action.

    forget: the memory is wiped in the step in which the robot can first act.
    """
    rows, state = observed(batch.reset(seed=seed)[0]), None
    seen_most = torch.zeros(batch.num_envs)
    horizon = batch.description["horizon"]
    for _ in range(horizon):
        if forget:
            seen = policy.sight.split(rows)[1][..., 0].sum(-1)
            state = policy.wipe(state, seen > seen_most)
            seen_most = torch.maximum(seen_most, seen)
        choice, _, state, _ = policy(rows[None], state)
        step = batch.step(choice.best()[0].numpy())
        rows = observed(step[0])
    infos = step[4]
    answers = infos.get("first_answer_correct")
    return {
        "success_once": float(np.mean(infos["success_once"])),
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
            pass  # CSV and the curve are there without it

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


def save_policy(policy, path, task, memory, **more):
    path.parent.mkdir(parents=True, exist_ok=True)
    torch.save({"task": task, "memory": memory, "weights": policy.state_dict(), **more}, path)


def load_policy(path):
    """The policy of a checkpoint, and the checkpoint."""
    saved = torch.load(Path(path), weights_only=True)
    sight = Sight(engram.make_vec(saved["task"], num_envs=1, obs_mode="objects").description)
    policy = Policy(sight, memory=saved["memory"])
    policy.load_state_dict(saved["weights"])
    return policy, saved
