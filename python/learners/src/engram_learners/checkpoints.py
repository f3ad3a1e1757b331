"""Files of policies: agent.pt, and the progress of a run that is cut off."""

from pathlib import Path
from typing import Any, NamedTuple

import torch

import engram
from engram_learners.images.detector import ObjectDetector, detector_layout
from engram_learners.layout import ObservationLayout
from engram_learners.policy import Policy
from engram_learners.run_log import write_whole
from engram_learners.several_tasks import TaskInputs
from engram_learners.zoo.policy import ZooPolicy


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


class LoadedPolicy(NamedTuple):
    """A policy; its detector, None for objects observations; its task, or a list of several."""

    policy: Any
    detector: ObjectDetector | None
    task: Any


def load_policy(path, task=None, options=None):
    """Reads an agent.pt.

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
    return LoadedPolicy(policy, detector, saved["task"])


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
