"""Inference with a trained policy, for `engram.evaluate` or over pipes (`serve.py`).

runner = load_runner("runs/color3/agent.pt")
engram.evaluate(runner, runner.task, obs=runner.obs, threads=1, num_envs=50)

A policy of several tasks has their ids in runner.task, and plays each of them alone. Conditioned on
instructions, it plays others as well.
"""

import numpy as np
import torch

from engram_learners.checkpoints import load_policy, options_of
from engram_learners.clone import StudentRunner
from engram_learners.env_options import TIME, Time
from engram_learners.images.detector import Tracks
from engram_learners.instructions import turns_of
from engram_learners.several_tasks import TaskInputs
from engram_learners.training import forgotten


def load_runner(path, forget=False):
    """The runner of an agent.pt: of clone.py, or of the other learners.

    forget: the memory is reset as in the learner's figures that are named `wiped`.
    """
    cloned = "student" in torch.load(path, weights_only=True)
    runner = (StudentRunner if cloned else PolicyRunner).load(path)
    runner.forget = forget
    return runner


class PolicyRunner:
    """Policy with the memory of every running episode, by (worker, slot).

    From images: also with the detector's tracks.
    forget: the memory is reset whenever an object appears. Tracks are not.
    """

    def __init__(self, policy, detector=None, task=None, options=None):
        torch.set_num_threads(1)
        self.policy, self.detector, self.task = policy.eval(), detector, task
        self.options = options or {}  # of the environment
        self.time = Time(self.options) if self.options.get(TIME) else None
        several = task is not None and not isinstance(task, str)
        self.inputs = TaskInputs.like(task, policy.layout, options) if several else None
        self.reads = bool(policy.layout.words)
        self.instruction = None  # in place of those of the observations
        self.forget = False
        self.obs = "objects" if detector is None else "rgb"
        self.width = policy.layout.agent + policy.layout.tokens * policy.layout.width
        self.states, self.tracks = {}, {}
        if policy.memory:
            state = policy(torch.zeros(1, 1, self.width))[2]
            self.initial = policy.reset_state(state, torch.tensor([True]))

    @classmethod
    def load(cls, path):
        return cls(*load_policy(path), options_of(path))

    @torch.no_grad()
    def __call__(self, observation):
        """Observation of `engram.evaluate` -> actions (N, A)."""
        keys = [(observation["worker"], slot) for slot in observation["slot"]]
        rows = self.rows(observation, keys)
        if not self.policy.memory:
            return self.policy(rows[None])[0].best()[0].numpy()
        begins = zip(keys, observation["first"])
        states = [self.initial if first else self.states[key] for key, first in begins]
        state = self.policy.join(states)
        if self.forget:
            state = forgotten(self.policy, rows, state)
        choice, _, state, _ = self.policy(rows[None], state)
        self.states.update(zip(keys, self.policy.split(state)))
        return choice.best()[0].numpy()

    def rows(self, observation, keys):
        """Inputs of the policy (N, width). keys: those of its states."""
        given = "images" if observation.get("rgb") is not None else "numbers"
        if (given == "numbers") != (self.detector is None):
            raise ValueError(f"{given} given, obs {self.obs} needed: it was trained on them")
        if self.detector is not None:
            return self.see(observation, keys)
        rows = torch.from_numpy(np.array(observation["state"], dtype=np.float32))
        if self.time is not None:
            rows = self.time.add(observation["env_id"], rows, observation["step"])
        if self.inputs is not None:
            return self.inputs.of_task(observation["env_id"], rows, self.sentences(observation))
        if rows.shape[1] != self.width:
            given = f"{rows.shape[1]} numbers given, {self.width} needed"
            raise ValueError(f"{given}: obs objects of {self.task}, or of a task like it")
        return rows

    def see(self, observation, keys):
        """Inputs of the policy from images."""
        images, proprio = (torch.from_numpy(np.array(observation[k])) for k in ("rgb", "proprio"))
        begins, new = zip(keys, observation["first"]), self.detector.initial(1)
        before = [new if first else self.tracks[key] for key, first in begins]
        before = Tracks(*(torch.cat(parts) for parts in zip(*before)))
        now = self.detector.update(images, proprio, before)
        self.tracks.update(zip(keys, zip(*(part.split(1) for part in now))))
        layout = self.policy.layout
        turns = turns_of(self.sentences(observation)) if layout.turn else None
        rows = self.detector.rows(proprio, now, layout, turns)
        if self.inputs is None:
            return rows
        return self.inputs.of_images(observation["env_id"], rows, self.sentences(observation))

    def sentences(self, observation):
        if self.instruction is None:
            return observation["instruction"]
        return [self.instruction] * len(observation["slot"])
