"""Clones written demonstrations into a recurrent student that sees pictures (behaviour cloning).

The data set alone is read: pictures, proprio and actions, nothing privileged. The simulator only
plays the evaluations.

    engram collect RememberColor3-VLA-v0 --episodes 1000 --out demos
    python clone.py demos/data_npz/RememberColor3-VLA-v0 --out runs/clone
    python evaluate.py runs/clone/agent.pt
"""

import argparse
import json
import time
from pathlib import Path

import numpy as np
import torch
from distil import imitation
from object_detector import CELL, CELLS, METRES, ROBOT, downsample, robot_features, unproject
from policy import Choice, mlp
from torch import nn

import engram
from engram.datasets import DemonstrationFolder

ACTIONS = 7
HEIGHT = 0.02 / METRES  # of the points that keypoints mark: the middle of a cube on the table
SEED = 2_000_000  # of the first evaluated episode; demonstrations begin at seed 0


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    add = parser.add_argument
    add("demonstrations", type=Path, help="folder of NPZ files that engram collect has written")
    add("--out", type=Path, required=True, help="folder for log.jsonl and agent.pt")
    add("--seed", type=int, default=1)
    add("--no-memory", action="store_true", help="the control: every step is an episode's first")
    add("--keypoints", type=int, default=16)
    add("--updates", type=int, default=2000)
    add("--batch", type=int, default=24, help="episodes per update")
    add("--lr", type=float, default=2e-3)
    add("--evaluate-every", type=int, default=400, help="updates")
    add("--episodes", type=int, default=200, help="per evaluation")
    return parser.parse_args()


class Student(nn.Module):
    """Eye, memory and hand: keypoints of the picture, a GRU, attention that chooses a keypoint.

    Sequences are (T, N, ...) and begin where an episode begins.
    """

    def __init__(self, memory=True, keypoints=16, hidden=64, width=64):
        super().__init__()
        self.memory, self.keypoints, self.hidden = memory, keypoints, hidden
        self.register_buffer("mean", torch.zeros(ROBOT))
        self.register_buffer("std", torch.ones(ROBOT))
        layers = [nn.Conv2d(6, 16, 5, 2, 2), nn.ReLU(), nn.Conv2d(16, 24, 3, 2, 1), nn.ReLU()]
        self.eye = nn.Sequential(*layers, nn.Conv2d(24, keypoints, 3, 1, 1))
        cells = torch.arange(CELLS) * float(CELL)
        self.register_buffer("pixels", torch.cartesian_prod(cells, cells).flip(-1))
        known = ROBOT + 4 * keypoints
        self.encode = mlp(known, hidden)
        self.gru = nn.GRU(hidden, hidden)
        self.choose = mlp(hidden + known, width, keypoints)
        self.act = mlp(hidden + ROBOT + 3, width, width, ACTIONS, gain=0.01)

    def see(self, pictures):
        """Pictures (B, SIDE, SIDE, 3) uint8 -> positions on the table (B, K, 2), peaks (B, K)."""
        color = pictures.permute(0, 3, 1, 2).float() / 255
        tint = color / (color.sum(1, keepdim=True) + 0.1)
        tint = tint - tint.mean((-1, -2), keepdim=True)
        heat = self.eye(torch.cat([color - 0.5, 5 * tint], 1)).flatten(2)
        pixels = (4 * heat).softmax(-1) @ self.pixels
        return unproject(pixels, torch.full_like(pixels[..., 0], HEIGHT)), heat.amax(-1)

    def forward(self, pictures, robot, state=None):
        """-> Choice of actions (T, N, keypoints, ...), state of the memory."""
        steps = robot.shape[:2]
        place, peak = self.see(pictures.flatten(0, 1))
        place, peak = place.unflatten(0, steps), peak.unflatten(0, steps)
        offset = 5 * (place - robot[..., None, :2])
        scaled = ((robot - self.mean) / self.std).clamp(-5, 5)
        known = torch.cat([scaled, peak, peak.tanh(), offset.flatten(-2)], -1)
        entry = self.encode(known).tanh()
        if self.memory:
            remembered, state = self.gru(entry, state)
        else:
            remembered = self.gru(entry.flatten(0, 1)[None])[0][0].unflatten(0, steps)
        weights = self.choose(torch.cat([remembered, known], -1)).log_softmax(-1)
        own = torch.cat([remembered, scaled], -1)[..., None, :].expand(*offset.shape[:-1], -1)
        mean = self.act(torch.cat([own, offset, peak[..., None]], -1))
        # Initial action: toward the chosen keypoint.
        mean = torch.cat([mean[..., :2] + offset.clamp(-1, 1), mean[..., 2:]], -1)
        return Choice(weights, mean, torch.zeros_like(mean)), state


class StudentRunner:
    """Plays a student for `engram.evaluate`, with the memory of each episode by (worker, slot).

    forget: the memory is reset until the hand moves, and so begins with the view that is acted on.
    """

    obs = "rgb"

    def __init__(self, student, task, forget=False):
        torch.set_num_threads(1)
        self.student, self.task, self.forget = student.eval(), task, forget
        self.states, self.begins = {}, {}

    @classmethod
    def load(cls, path):
        saved = torch.load(Path(path), weights_only=True)
        student = Student(saved["memory"], saved["keypoints"])
        student.load_state_dict(saved["student"])
        return cls(student, saved["task"])

    @torch.no_grad()
    def __call__(self, observation):
        """Observation of `engram.evaluate` -> actions (N, 7)."""
        robot = robot_features(observation["proprio"])
        keys = [(observation["worker"], slot) for slot in observation["slot"]]
        empty = torch.zeros(1, 1, self.student.hidden)
        for key, first, now in zip(keys, observation["first"], robot):
            if first:
                self.begins[key] = now
            still = (now[:3] - self.begins[key][:3]).abs().max() < 2e-3  # 1 mm
            if first or (self.forget and still):
                self.states[key] = empty
        state = torch.cat([self.states[key] for key in keys], 1)
        choice, state = self.student(downsample(observation["rgb"])[None], robot[None], state)
        if self.student.memory:
            self.states.update(zip(keys, state.split(1, 1)))
        return choice.best()[0].numpy()


def load_demonstrations(folder):
    """-> task; pictures (T, N, ...), robot, actions and which steps exist (T, N)."""
    demonstrations = DemonstrationFolder(folder)
    pictures, robot, actions = [], [], []
    for episode in demonstrations:
        pictures.append(downsample(episode.image))
        robot.append(robot_features(episode.proprio))
        actions.append(torch.from_numpy(np.array(episode.action)))
    exists = [torch.ones(len(one)) for one in actions]
    padded = [nn.utils.rnn.pad_sequence(one) for one in (pictures, robot, actions, exists)]
    return demonstrations.metadata["env_id"], padded


def loss_of(student, pictures, robot, actions, exists):
    # Steps without motion have less weight: they are frequent and easy.
    weight = exists * torch.where(actions[..., :-1].abs().amax(-1) > 0, 1.0, 0.1)
    choice, _ = student(pictures, robot)
    return (imitation(choice, actions) * weight).sum() / weight.sum()


def evaluate(student, task, episodes, forget=False):
    """Success in unseen episodes and its Wilson interval."""
    runner = StudentRunner(student, task, forget)
    options = {"obs": runner.obs, "episodes": episodes, "seed": SEED}
    one = engram.evaluate(runner, task, threads=1, num_envs=50, **options)["tasks"][0]
    student.train()
    return {"success_once": one["sr"], "interval": one["sr_interval"]}


def main():
    args = arguments()
    torch.manual_seed(args.seed)
    torch.set_num_threads(1)
    args.out.mkdir(parents=True, exist_ok=True)
    task, data = load_demonstrations(args.demonstrations)
    student = Student(not args.no_memory, args.keypoints)
    robot = data[1][data[3] > 0]
    student.mean.copy_(robot.mean(0))
    student.std.copy_(robot.std(0) + 1e-2)
    optimiser = torch.optim.Adam(student.parameters(), args.lr)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimiser, args.lr, args.updates)
    log = (args.out / "log.jsonl").open("w")
    losses, cpu_s, begin = [], 0.0, time.process_time()
    for update in range(1, args.updates + 1):
        pick = torch.randint(data[0].shape[1], (args.batch,))
        loss = loss_of(student, *(part[:, pick] for part in data))
        optimiser.zero_grad()
        loss.backward()
        nn.utils.clip_grad_norm_(student.parameters(), 1.0)
        optimiser.step()
        schedule.step()
        losses.append(loss.item())
        if update % args.evaluate_every and update < args.updates:
            continue
        cpu_s += time.process_time() - begin
        row = {"updates": update, "cpu_s": round(cpu_s, 1), "loss": round(np.mean(losses), 4)}
        row |= evaluate(student, task, args.episodes)
        if student.memory and update == args.updates:
            row["wiped"] = evaluate(student, task, args.episodes, forget=True)
        print(json.dumps(row), file=log, flush=True)
        print(json.dumps(row), flush=True)
        saved = {"task": task, "memory": student.memory, "keypoints": student.keypoints}
        torch.save({**saved, "student": student.state_dict()}, args.out / "agent.pt")
        losses, begin = [], time.process_time()


if __name__ == "__main__":
    main()
