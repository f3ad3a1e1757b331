"""Clones written demonstrations into a recurrent student that sees images (behaviour cloning).

The data set alone is read: images, proprio and actions, nothing privileged. The simulator only
plays the evaluations.

    engram collect RememberColor3-VLA-v0 --episodes 300 --out demos
    python -m engram_learners.clone demos/data_npz/RememberColor3-VLA-v0 --out runs/clone
    python -m engram_learners.evaluate runs/clone/agent.pt
"""

import argparse
import json
import math
import time
from pathlib import Path

import numpy as np
import torch
from torch import nn

import engram
from engram.datasets import DemonstrationFolder
from engram_learners.distil import imitation
from engram_learners.images.views import METRES, ROBOT, robot_features, unproject
from engram_learners.policy import Choice, mlp

ACTIONS = 7
SIDE = 64  # pixels of an image's side, after downsampling
HEIGHT = 0.02  # of the points that keypoints mark: the middle of a cube on the table
SEED = 2_000_000  # of the first evaluated episode; demonstrations begin at seed 0


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    add = parser.add_argument
    add("demonstrations", type=Path, help="folder of NPZ files that engram collect has written")
    add("--out", type=Path, required=True, help="folder for log.jsonl and agent.pt")
    add("--seed", type=int, default=1)
    add("--no-memory", action="store_true", help="the control: every step is an episode's first")
    add("--keypoints", type=int, default=6)
    add("--updates", type=int, default=300)
    add("--batch", type=int, default=16, help="episodes per update")
    add("--lr", type=float, default=3e-3)
    add("--evaluate-every", type=int, default=100, help="updates")
    add("--episodes", type=int, default=200, help="per evaluation")
    return parser.parse_args()


class Student(nn.Module):
    """Keypoints of the image, a GRU, and attention that chooses a keypoint.

    Sequences are (T, N, ...) and begin where an episode begins.
    """

    def __init__(self, memory=True, keypoints=6, hidden=64, width=64):
        super().__init__()
        self.memory, self.keypoints, self.hidden = memory, keypoints, hidden
        self.register_buffer("mean", torch.zeros(ROBOT))
        self.register_buffer("std", torch.ones(ROBOT))
        # A keypoint is where the image is nearest to a hue, which is learnt.
        hues = torch.arange(keypoints) * (2 * math.pi / keypoints)
        hues = torch.stack([torch.cos(hues - 2 * math.pi * i / 3) for i in range(3)], -1)
        self.hues = nn.Parameter(5 * hues)
        side = torch.arange(SIDE).float()
        self.register_buffer("pixels", torch.cartesian_prod(side, side).flip(-1))
        self.encode = mlp(4 * keypoints, hidden)
        self.gru = nn.GRU(hidden, hidden)
        self.choose = mlp(hidden, width, keypoints)
        self.act = mlp(hidden + ROBOT + 3, width, width, ACTIONS, gain=0.01)

    def see(self, images):
        """Images (B, SIDE, SIDE, 3) uint8 -> positions on the table (B, K, 2), peaks (B, K)."""
        color = images.permute(0, 3, 1, 2).float() / 255
        tint = color / (color.sum(1, keepdim=True) + 0.1)
        tint = tint - tint.mean((-1, -2), keepdim=True)
        heat = self.hues @ tint.flatten(2)
        pixels = (4 * heat).softmax(-1) @ self.pixels
        return unproject(pixels, HEIGHT, SIDE)[..., :2] / METRES, heat.amax(-1)

    def forward(self, place, peak, robot, state=None):
        """What `see` returns (T, N, ...) -> Choice of actions, state of the memory."""
        offset = 5 * (place - robot[..., None, :2])
        # Memory and attention do not get the robot's numbers: the way of the demonstrator's hand
        # tells what it has chosen, and the cue would not have to be remembered.
        entry = self.encode(torch.cat([peak, peak.tanh(), place.flatten(-2)], -1)).tanh()
        if self.memory:
            remembered, state = self.gru(entry, state)
        else:
            remembered = self.gru(entry.flatten(0, 1)[None])[0][0].unflatten(0, robot.shape[:2])
        weights = self.choose(remembered).log_softmax(-1)
        scaled = ((robot - self.mean) / self.std).clamp(-5, 5)
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
    reads = False  # an instruction

    def __init__(self, student, task, forget=False):
        torch.set_num_threads(1)
        self.student, self.task, self.forget = student.eval(), task, forget
        self.states, self.begins, self.options = {}, {}, {}

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
        seen = (part[None] for part in self.student.see(downsample(observation["rgb"])))
        choice, state = self.student(*seen, robot[None], state)
        if self.student.memory:
            self.states.update(zip(keys, state.split(1, 1)))
        return choice.best()[0].numpy()


def downsample(rgb):
    """Base camera (N, SIDE, SIDE, 3) of images (N, 128, 128, 6), uint8 both."""
    parts = np.asarray(rgb)[..., :3].reshape(-1, SIDE, 2, SIDE, 2, 3)
    return torch.from_numpy(parts.mean((-4, -2), dtype=np.float32).astype(np.uint8))


def load_demonstrations(folder):
    """-> task; distinct images (F, ...); their indices, robot, actions, which steps exist (T, N).

    While the robot waits, one image follows another that is the same: it is seen once.
    """
    demonstrations = DemonstrationFolder(folder)
    images, index, robot, actions = [], [], [], []
    for episode in demonstrations:
        own = downsample(episode.image)
        new = torch.cat([torch.ones(1) > 0, (own[1:] != own[:-1]).flatten(1).any(1)])
        index.append(new.cumsum(0) - 1 + sum(map(len, images)))
        images.append(own[new])
        robot.append(robot_features(episode.proprio))
        actions.append(torch.from_numpy(np.array(episode.action)))
    exists = [torch.ones(len(one)) for one in actions]
    steps = [nn.utils.rnn.pad_sequence(one) for one in (index, robot, actions, exists)]
    return demonstrations.metadata["env_id"], torch.cat(images), steps


def loss_of(student, images, index, robot, actions, exists):
    """images: distinct ones; index (T, N): which of them a step shows."""
    # Steps without motion have less weight: they are frequent and easy.
    weight = exists * torch.where(actions[..., :-1].abs().amax(-1) > 0, 1.0, 0.1)
    shown, which = index.unique(return_inverse=True)
    choice, _ = student(*(part[which] for part in student.see(images[shown])), robot)
    return (imitation(choice, actions, doubt=0.2) * weight).sum() / weight.sum()


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
    task, images, steps = load_demonstrations(args.demonstrations)
    student = Student(not args.no_memory, args.keypoints)
    robot = steps[1][steps[3] > 0]
    student.mean.copy_(robot.mean(0))
    student.std.copy_(robot.std(0) + 1e-2)
    optimiser = torch.optim.Adam(student.parameters(), args.lr)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimiser, args.lr, args.updates)
    log = (args.out / "log.jsonl").open("w")
    losses, cpu_s, begin = [], 0.0, time.process_time()
    for update in range(1, args.updates + 1):
        pick = torch.randint(steps[0].shape[1], (args.batch,))
        loss = loss_of(student, images, *(part[:, pick] for part in steps))
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
