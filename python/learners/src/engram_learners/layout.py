"""Layout of object observations: offsets in a row, and what follows from them.

Observations are those of ``obs_mode="objects"``: the robot, then a token for every object.
"""

import math

import torch
from torch import nn

from engram_learners.rotations import alignments, angle, relative, tilt, turned, yaw

TOKEN = "object_"
TOUCH = 0.1  # most distance of the tool from an object's top, 0.05 m
STILL = 0.2 / math.pi  # most speed of a joint at rest, 0.2 rad/s
N_GATES = 5  # weights of turns of the tool
N_GEOMETRY = 3 + 5 + 5 + 2 + 2 + 4  # features of where an object is, seen from the tool


class ObservationLayout:
    """Offsets in a row of the objects observation, from the description of a batch.

    Of a policy of several tasks, behind the robot's numbers (`several_tasks.TaskInputs`):

    tasks: one-hot of the task.
    words: vocabulary of the bag of words of the instruction.
    """

    def __init__(self, description, tasks=0, words=()):
        fields = description["state_fields"]
        self.actions = description["action_dim"]
        # Whether the first three numbers of an action move the tool along x, y, z.
        self.moves_tool = description["control_mode"].startswith("pd_ee_delta_")
        self.tasks, self.words = tasks, list(words)
        robot = sum(f["width"] for f in fields if not f["name"].startswith(TOKEN))
        self.agent = robot + tasks + len(self.words)
        first = [f for f in fields if f["name"].startswith(f"{TOKEN}0_")]
        kinds = next(f["names"] for f in first if f["name"] == f"{TOKEN}0_kind")
        self.width = sum(f["width"] for f in first)
        self.tokens = tokens_of(description)
        begin = first[0]["offset"]
        self.part = {
            f["name"].removeprefix(f"{TOKEN}0_"): slice(
                f["offset"] - begin, f["offset"] - begin + f["width"]
            )
            for f in first
        }
        place = {f["name"]: slice(f["offset"], f["offset"] + f["width"]) for f in fields}
        self.tcp = slice(place["tcp_pose"].start, place["tcp_pose"].start + 3)
        self.tool = slice(place["tcp_pose"].start + 3, place["tcp_pose"].stop)
        self.turn = place.get("task_cue")  # by which an object is to turn
        self.arm_speed = slice(place["qvel"].start, place["qvel"].start + 7)
        self.place = self.part["position"]
        self.lamp, self.button = (
            self.part["kind"].start + kinds.index(kind) for kind in ("lamp", "button")
        )
        self.colors = self.part["color"].stop - self.part["color"].start
        self.shapes = self.part["shape"].stop - self.part["shape"].start
        self.appearance = [
            i for name in ("color", "shape", "kind") for i in indices(self.part[name])
        ]
        body = ("orientation", "size", "state", "kind")
        self.body = [i for name in body for i in indices(self.part[name])]

    @property
    def words_begin(self):
        """Where the bag of words begins."""
        return self.agent - len(self.words)

    def split(self, rows):
        """Rows (..., D) -> robot (..., agent), tokens (..., tokens, width).

        Rows may lack the last tokens, of objects that a task does not have.
        """
        tokens = rows[..., self.agent :].unflatten(-1, (-1, self.width))
        return rows[..., : self.agent], tokens

    def yaw(self, tokens):
        """Cosine and sine (..., tokens, 2) of the objects' turn about the vertical."""
        return yaw(tokens[..., self.part["orientation"]])

    def tool_yaw(self, agent):
        """Cosine and sine (..., 2) of the tool's turn about the vertical, from the robot's part."""
        if self.tool.start == self.tool.stop:  # proprio lacks it
            return torch.tensor([1.0, 0.0], device=agent.device).expand(*agent.shape[:-1], 2)
        return yaw(agent[..., self.tool])

    def geometry(self, rows):
        """Where every object is, seen from the tool (..., tokens, N_GEOMETRY)."""
        agent, tokens = self.split(rows)
        offset = tokens[..., self.place] - agent[..., None, self.tcp]
        turn = relative(self.tool_yaw(agent)[..., None, :], self.yaw(tokens))
        half, quarter = alignments(turn)
        along = turned(self.yaw(tokens), offset[..., :2], back=True)
        ways = torch.cat([offset, along], -1)
        scales = [5 * offset, (20 * ways).tanh(), (80 * ways).tanh(), 5 * along]
        angles = torch.stack([half, quarter, (10 * half).tanh(), (10 * quarter).tanh()], -1)
        return torch.cat([*scales, turn, angles], -1) * tokens[..., :1]

    def to_top(self, rows):
        """Vectors from the tool to the top of every object (..., tokens, 3)."""
        agent, tokens = self.split(rows)
        top = tokens[..., self.place].clone()
        top[..., 2] += 0.1 * tokens[..., self.part["size"]][..., 2]  # 0.05 m to 0.5 m
        return top - agent[..., None, self.tcp]

    def servo(self, rows, planar_motion, gates):
        """Actions by object (..., tokens, actions) of a servo to its top, as the oracle's gain.

        planar_motion (..., tokens, 2): along the object's own horizontal axes, added as well.
        gates (..., tokens, N_GATES): weights of turns: to be upright; none, to face ahead, to be
        aligned with the object, where it looks the same after half a turn, or a quarter.
        """
        agent, tokens = self.split(rows)
        if not self.moves_tool:
            return 0.0
        direction, tool = self.yaw(tokens), self.tool_yaw(agent)[..., None, :]
        reach = (8 * self.to_top(rows)).clamp(-3, 3)
        reach = reach + nn.functional.pad(turned(direction, planar_motion), (0, 1))
        if self.actions < 7 or self.tool.start == self.tool.stop:
            return nn.functional.pad(reach, (0, self.actions - 3))
        turns = [relative(tool, torch.tensor([1.0, 0], device=tool.device))]
        turns = [angle(turns[0]).expand(*tokens.shape[:-1]), *alignments(relative(tool, direction))]
        share = gates[..., 1:].softmax(-1)[..., 1:]
        turn = (share * torch.stack(turns, -1)).sum(-1, keepdim=True)
        upright = gates[..., :1].sigmoid() * tilt(agent[..., None, self.tool])
        rotation = -16 * torch.cat([upright, turn], -1)  # the benchmark negates rotations
        return torch.cat([reach, rotation, torch.zeros_like(turn)], -1)

    def touched(self, rows):
        """Visible objects (..., tokens) at whose top the tool rests."""
        agent, tokens = self.split(rows)
        near = self.to_top(rows).norm(dim=-1) < TOUCH
        still = (agent[..., self.arm_speed].abs() < STILL).all(-1, keepdim=True)
        return near & still & (tokens[..., 0] > 0)

    def pairs(self, tokens):
        """Index of every object's pair of colour and shape (or none); -1 for invisible objects."""
        color = tokens[..., self.part["color"]].argmax(-1)
        shape = tokens[..., self.part["shape"]]
        shape = torch.where(shape.sum(-1) > 0, shape.argmax(-1), self.shapes)
        return torch.where(tokens[..., 0] > 0, color * (self.shapes + 1) + shape, -1)

    def bodies(self, tokens, pairs):
        """The pairs, with one index for all lamps, because their colours may change."""
        lamp = tokens[..., self.lamp] > 0
        return torch.where(lamp, self.colors * (self.shapes + 1), pairs)


def tokens_of(task):
    """Objects of a task, from its description with objects observations."""
    return sum(field["name"].endswith("_seen") for field in task["state_fields"])


def indices(part):
    return range(part.start, part.stop)
