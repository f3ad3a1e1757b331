"""Cards of data sets: the README.md that hubs show, with what the set is and how it was made."""

from __future__ import annotations

import dataclasses
import json
import shlex
from collections.abc import Collection, Mapping, Sequence
from typing import Any

from engram.datasets.additions import ADDITIONS, DEPTH, LABELS, OBJECTS, SEGMENTATION, STATE
from engram.datasets.checks import printable
from engram.datasets.collected import EpisodeSource
from engram.datasets.spaces import CONTROL_RATE

_LICENCE = "apache-2.0"  # engram's, of what it makes
_MOST_INSTRUCTIONS = 20


@dataclasses.dataclass(frozen=True)
class Card:
    """What a converter says about its folder.

    Attributes:
        layout: The format, such as "LeRobotDataset v3.0".
        command: The converter's, after `python -m engram.datasets`.
        tags: For hubs.
        data_files: Of hubs' viewers, as a pattern; None if they read none of them.
        facts: Further rows of the table.
        notes: Paragraphs about states, actions and statistics.
        use: Python that reads it.
    """

    layout: str
    command: Sequence[str]
    tags: Sequence[str]
    data_files: str | None
    facts: Mapping[str, str]
    notes: Sequence[str]
    use: str


def text(folder: EpisodeSource, instructions: Sequence[str], card: Card) -> str:
    """The README.md of a converted folder."""
    origin = folder.metadata.get("engram", {})
    lines = [
        *_front_matter(card),
        f"# Demonstrations of {folder.env_id}",
        "",
        f"{card.layout} of a robot arm on a table, simulated by engram. Every episode solves the "
        "task, and ends when it is solved.",
        "",
        "| | |",
        "| --- | --- |",
        *(f"| {name} | {_cell(value)} |" for name, value in _facts(folder, card.facts).items()),
        "",
        "## Instructions",
        "",
        *(f"* {_cell(one)}" for one in instructions[:_MOST_INSTRUCTIONS]),
    ]
    if len(instructions) > _MOST_INSTRUCTIONS:
        lines.append(f"* and {len(instructions) - _MOST_INSTRUCTIONS} more")
    lines += ["", "## Numbers", ""]
    for note in card.notes:
        lines += [note, ""]
    lines += ["## How it was made", "", *_origin(origin), "", "```sh"]
    if not _is_recorded(origin):
        lines.append(collect_command(folder))
    lines += [shlex.join(["python", "-m", "engram.datasets", *card.command]), "```", ""]
    lines += [
        "An episode is determined by the task, its seed and its actions: "
        "`python -m engram.datasets replay` plays them again and compares every number."
    ]
    lines += ["", "## Use", "", "```python", card.use.strip(), "```", ""]
    return "\n".join(lines)


def _front_matter(card: Card) -> list[str]:
    lines = [
        "---",
        f"license: {_LICENCE}",
        "task_categories:",
        "- robotics",
        "tags:",
        *(f"- {tag}" for tag in card.tags),
    ]
    if card.data_files:
        lines += ["configs:", "- config_name: default", f"  data_files: {card.data_files}"]
    return [*lines, "---", ""]


def _facts(folder: EpisodeSource, further: Mapping[str, str]) -> dict[str, str]:
    lengths = folder.metadata["episode_lengths"]
    seeds = folder.metadata["episode_seeds"]
    origin = folder.metadata.get("engram", {})
    facts = {
        "episodes": f"{len(lengths):,}",
        "frames": f"{sum(lengths):,}",
        "frames per episode": f"{min(lengths)} to {max(lengths)}, "
        f"{sum(lengths) / len(lengths):.1f} on average",
        "seeds": f"{min(seeds)} to {max(seeds)}",
        "control mode": folder.spaces.control_mode,
        "control steps per second": str(CONTROL_RATE),
        **further,
    }
    if folder.keeps_failures:
        facts["successes"] = str(sum(folder.metadata["success_once"]))
    for name in ("attempts", "rules", "physics", "renderer"):
        if name in origin:
            facts[name] = str(origin[name])
    if origin.get("variant") is not None:
        facts["changed constants"] = f"`{json.dumps(origin['variant'])}`"
    if origin.get("perturbations"):
        facts["perturbations"] = f"`{json.dumps(origin['perturbations'])}`"
    facts["licence"] = _LICENCE
    if "version" in origin:
        facts["version of engram"] = str(origin["version"])
    if "mujoco_version" in origin:
        facts["version of MuJoCo"] = str(origin["mujoco_version"])
    return facts


def _is_recorded(origin: Mapping[str, Any]) -> bool:
    """True if no command can make the demonstrations again."""
    return not origin or origin.get("player") is not None


def _origin(origin: Mapping[str, Any]) -> list[str]:
    if not origin:
        return ["The original benchmark's own scripts collected it. It was converted by:"]
    if _is_recorded(origin):
        return [f"It was played with {_cell(str(origin['player']))}, and converted by:"]
    return ["The task's scripted oracle, which knows what is hidden, acted."]


def collect_command(folder: EpisodeSource) -> str:
    """The command that makes the demonstrations again."""
    origin = folder.metadata.get("engram", {})
    words = ["engram", "collect", folder.env_id, "--episodes", str(len(folder))]
    if origin.get("start_seed"):
        words += ["--seed", str(origin["start_seed"])]
    for option, name, usual in (
        ("--rules", "rules", "reference"),
        ("--physics", "physics", "engram"),
        ("--renderer", "renderer", "cpu"),
        ("--control-mode", "control_mode", "pd_ee_delta_pose"),
    ):
        if origin.get(name, usual) != usual:
            words += [option, str(origin[name])]
    if folder.spaces.joint_proprio:
        words.append("--joint-proprio")
    words += [f"--{name}" for name in ADDITIONS if name in folder.additions]
    if origin.get("keep_failures"):
        words.append("--keep-failures")
    variant = origin.get("variant")
    constants = variant.get("constants") if isinstance(variant, dict) else None
    for name, value in constants.items() if isinstance(constants, dict) else ():
        words += ["--set", f"{name}={json.dumps(value)}"]
    perturbations = origin.get("perturbations")
    for axis, level in perturbations.items() if isinstance(perturbations, dict) else ():
        words += ["--perturb", f"{axis}={json.dumps(level)}"]
    return printable(shlex.join([*words, "--out", "data"]))


def of_steps(
    folder: EpisodeSource,
    added: Collection[str],
    keys: tuple[str, str, str, str],
    maps: list[str],
    **words: Any,
) -> Card:
    """The card of a format whose options are the additions and whose numbers are the benchmark's.

    keys: of proprio, actions, labels and paraphrases; maps: notes on depth and segmentation.
    """
    spaces = folder.spaces
    proprio, action, privileged, paraphrases = keys
    notes = [
        f"`{proprio}`, before the action: {', '.join(spaces.proprio_names)}"
        + (".", "; angles are the benchmark's, from -pi to pi.")[not spaces.joint_proprio],
        f"`{action}`: {', '.join(spaces.action_names)}.",
        *maps,
        *row_notes(added, proprio.rpartition("/")[0] + "/{}"),
    ]
    if LABELS in added:
        notes.append(
            f"**Labels are privileged**: `{privileged}` tells what a policy has to find out. Train "
            "on it as a target, or for a teacher; a policy that is shown it is not to be scored. "
            f"`{paraphrases}` is not privileged."
        )
    options = [f"--{name}" for name in added]
    words["command"] = [words["command"], "data", folder.env_id, *options]
    return Card(data_files=None, notes=notes, **words)


def map_notes(
    added: Collection[str], keys: str, names: str, stored: str = "PNG of 16 bits"
) -> list[str]:
    """What is said of depth and segmentation, by the form of their keys and the place of names."""
    meanings = {
        DEPTH: "distance along the camera's axis in mm, 0 where nothing is",
        SEGMENTATION: f"what the camera sees, an index into the names in {names}",
    }
    return [
        f"{keys.replace('{}', name)}: {meaning}; {stored}, lossless."
        for name, meaning in meanings.items()
        if name in added
    ]


def row_notes(added: Collection[str], key: str) -> list[str]:
    """What is said of state and objects, by the form of their key."""
    meanings = {
        STATE: "**privileged**, it tells what is hidden: for critics, teachers and probes",
        OBJECTS: "the robot, and what cameras can show of the objects",
    }
    return [
        f"`{key.replace('{}', name)}`, before the action: the row of the observation mode "
        f"`{name}`, whose fields `engram.describe` names; {meaning}."
        for name, meaning in meanings.items()
        if name in added
    ]


def _cell(value: str) -> str:
    """A foreign text in a line of Markdown."""
    return printable(value).replace("|", "\\|").replace("<", "&lt;")
