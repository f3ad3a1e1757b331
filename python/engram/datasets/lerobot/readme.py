"""The card of a LeRobotDataset."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

from engram.datasets import card, frame_stats, frozen
from engram.datasets.collected import EpisodeSource
from engram.datasets.lerobot import layout
from engram.datasets.lerobot_options import FRAMES, Options
from engram.datasets.spaces import ANGLES, CONTROL_RATE, Spaces

_READERS = {"3.0": "lerobot 0.4 and newer", "2.1": "lerobot 0.3"}


def text(
    folder: EpisodeSource,
    chosen: Options,
    asked: Options,
    instructions: Sequence[str],
    *,
    is_frozen: bool,
) -> str:
    """README.md; asked: the options as they were given, of which `chosen` were made.

    is_frozen: whether the set has the column of actions that were not executed.
    """
    frames = f"videos ({chosen.encoder}, 4:2:0, lossy)"
    if chosen.frames != FRAMES[0]:
        frames = "PNG images (lossless)"
    facts = {
        "frames per second": _rate(chosen.fps),
        "pictures": f"{frames} of 128 x 128, base and wrist camera",
        "read by": _READERS[chosen.version] + (", Isaac-GR00T" if chosen.modality else ""),
    }
    return card.text(
        folder,
        instructions,
        card.Card(
            layout=f"LeRobotDataset v{chosen.version}",
            command=_command(folder, asked),
            tags=("LeRobot", "engram", "mikasa-robo-vla"),
            data_files="data/*/*.parquet",
            facts=facts,
            notes=_notes(folder.spaces, chosen) + frozen.notes(is_frozen, layout.ACTION),
            use=_use(folder.env_id, chosen),
        ),
    )


def _command(folder: EpisodeSource, asked: Options) -> list[str]:
    """The arguments that differ from the usual ones."""
    words = ["lerobot", "data", folder.env_id]
    for field in dataclasses.fields(Options):
        value = getattr(asked, field.name)
        if value != field.default:
            words += [f"--{field.name}"] if value is True else [f"--{field.name}", str(value)]
    return words


def _rate(fps: int) -> str:
    if fps == CONTROL_RATE:
        return f"{fps}: a second of time stamps and videos is one of the robot"
    return f"{fps}: a second of time stamps and videos is {fps / CONTROL_RATE:g} s of the robot"


def _notes(spaces: Spaces, options: Options) -> list[str]:
    notes = [
        f"`{layout.STATE}`, before the action: {', '.join(spaces.proprio_names)}. "
        + ("Joint angles in rad" if spaces.joint_proprio else "Position in m, angles in rad")
        + ", the gripper's opening in m.",
        f"`{layout.ACTION}`: {', '.join(spaces.action_names)}, of the control mode "
        f"`{spaces.control_mode}`; gripper from -1 (closed) to 1 (open).",
        "Statistics are of all frames; those of images of up to 100 per episode. They have floors: "
        f"standard deviations of state and action are at least {frame_stats.FLOOR:g}, and the "
        "distances of min and max, q01 and q99, q10 and q90 at least "
        f"{2 * frame_stats.FLOOR:g}. Otherwise numbers that hardly change would be huge inputs "
        "after normalisation.",
    ]
    if not spaces.joint_proprio:
        notes.insert(1, _ANGLES[options.angles])
    keys = f"`{layout.TOP}_{{}}`, `{layout.WRIST}_{{}}`"
    notes += card.map_notes(options.additions, keys, "meta/info.json")
    for name, key in layout.ROWS.items():
        notes += card.row_notes([name] if name in options.additions else [], key)
    if options.labels:
        language = "" if options.version == "2.1" else "`language_persistent`, "
        notes.append(
            f"**Labels are privileged**: {language}`subtask_index` (of meta/subtasks.parquet) and "
            "`privileged.*` tell what a policy has to find out. Train on them as targets, or for a "
            "teacher; a policy that is shown them is not to be scored."
        )
    return notes


_ANGLES = {
    ANGLES[0]: "Angles are continuous: roll is from 0 to 2 pi, yaw from -3/4 pi to 5/4 pi, where "
    "the benchmark's jump between -pi and pi (roll does so all the time, because the hand points "
    "down). A policy that is trained on them needs the same when it acts: `lerobot-eval` with "
    "engram's environment gives it; elsewhere, add 2 pi to a roll below 0 and to a yaw below "
    "-3/4 pi.",
    ANGLES[1]: "Angles are the benchmark's own, from -pi to pi. Roll jumps between the two, "
    "because the hand points down.",
}


def _use(env_id: str, options: Options) -> str:
    lines = [
        "from lerobot.datasets.lerobot_dataset import LeRobotDataset",
        "",
        f'data = LeRobotDataset("local/{env_id}", root="FOLDER")',
        f'data[0]["{layout.TOP}"], data[0]["{layout.STATE}"], data[0]["action"], data[0]["task"]',
    ]
    if options.labels and options.version != "2.1":
        lines += [
            "",
            "# Rows of language have empty fields, which torch's own collate function refuses.",
            "from lerobot.utils.collate import lerobot_collate_fn",
            "from torch.utils.data import DataLoader",
            "",
            "loader = DataLoader(data, batch_size=8, collate_fn=lerobot_collate_fn)",
        ]
    if options.modality:
        lines.append("# Isaac-GR00T: --dataset-path FOLDER; its parts are in meta/modality.json")
    return "\n".join(lines)
