"""Auxiliary loss of the memory of `policy`, with labels from the episode's own observations.

Sequences are (T, N, ...) and begin where an episode begins.
"""

from typing import NamedTuple

import torch
from torch import nn
from torch.nn.functional import binary_cross_entropy_with_logits

from engram_learners.keyframes import arrivals, rises
from engram_learners.policy import N_VIEWS

NEAR = 0.1  # most distance of equal positions, 0.05 m
LIFTED = 0.17  # rise of the tool that ends a press, 0.085 m


class Labels(NamedTuple):
    """Labels of the memory's loss, (T, N, ...).

    shown (3, appearances); predecessor (tokens, appearances); of_objects (tokens, appearances +
    counts + 1).
    """

    shown: torch.Tensor
    predecessor: torch.Tensor
    of_objects: torch.Tensor


class MemoryLoss:
    """Auxiliary loss of the memory. Labels come from the episode's own observations.

    * shown: by appearance, its presence in the first view, in any earlier one, and the first such.
    * predecessor: by visible object, the appearance of the object that was first at its position,
      tracked as it moves.
    * changed: by visible object, the number of times that it (a lamp, a button) has gone on.
    * touched: by visible object, the tool has rested at its top; by button, it has been pressed
      and the tool has not been lifted since.
    """

    @staticmethod
    def labels(policy, rows):
        """Labels of whole episodes (T, N, D)."""
        tokens = policy.layout.split(rows)[1]
        pairs = policy.layout.pairs(tokens)
        new = arrivals(policy.layout.bodies(tokens, pairs))[..., 0]
        view = new.cumsum(0)[..., None] - 1
        code = policy.code(pairs)
        first = torch.where(code.amax(-2) > 0, view, N_VIEWS).cummin(0).values
        shown = torch.stack([first == 0, first < view, first.clamp(max=N_VIEWS) / N_VIEWS], -2)
        predecessor = first_at_position(policy.layout, tokens, code)
        by_object = tracked(policy.layout, rows, code, new, policy.counts)
        return Labels(shown, predecessor, torch.cat(by_object, -1))

    @staticmethod
    def loss(policy, rows, recalled, labels, ever=None):
        """ever: of chunks, what `shown` (1, N, 3, appearances) is at the ends of the episodes."""
        seen = policy.layout.split(rows)[1][..., 0]
        (shown, predecessor, of_objects), labels = recalled, Labels(*labels)
        shown_label = labels.shown
        error = binary_cross_entropy_with_logits(shown, shown_label, reduction="none")
        # Appearances that the episode never shows are left out: they would dominate the loss.
        ever = shown_label[-1:] if ever is None else ever
        error = error * ever[..., 2:, :].lt(1)
        error[..., 2, :] *= shown_label[..., 1, :]
        of_all = error.sum((-1, -2)).mean()
        known = nn.functional.pad(policy.vocabulary >= 0, (0, policy.counts + 1), value=True)
        error = (
            binary_cross_entropy_with_logits(of_objects, labels.of_objects, reduction="none")
            * known
        )
        of_places = binary_cross_entropy_with_logits(
            predecessor, labels.predecessor, reduction="none"
        )
        error = error.sum(-1) + (of_places * known[: policy.appearances]).sum(-1)
        return of_all + (error * seen).sum() / seen.sum().clamp(min=1)


def first_at_position(layout, tokens, appearances):
    """Appearance of the object first at every object's position (T, N, tokens, appearances)."""
    where = tokens[..., layout.place][..., :2]
    distance = (where[:, :, :, None] - where[0][None, :, None]).norm(dim=-1)
    distance = distance.masked_fill(tokens[0, ..., 0][None, :, None] == 0, 9)
    near, which = distance.min(-1)
    predecessor = (
        appearances[:1].expand_as(appearances).gather(2, which[..., None].expand_as(appearances))
    )
    return predecessor * (near < NEAR)[..., None] * tokens[..., :1]


def tracked(layout, rows, appearances, new, most):
    """Labels by object, tracked from view to view by positions. most: numbers of changes.

    -> appearance of the object that was first there, number of changes (one-hot), touched.
    """
    agent, tokens = layout.split(rows)
    where = tokens[..., layout.place][..., :2]
    seen = tokens[..., 0] > 0
    state = tokens[..., layout.part["state"]][..., 0]
    button = tokens[..., layout.button] > 0
    height = agent[..., layout.tcp][..., 2:].expand_as(state)
    touched_now = layout.touched(rows).float()
    # By object: appearance, changes, touched, height of the tool when it went on.
    at_first = known = nn.functional.pad(appearances[0], (0, 3))
    result, off = [], torch.zeros_like(seen[0])
    rose = rises(state, (new > 0)[..., None].expand_as(seen), off)[0]
    for t in range(len(tokens)):
        if t > 0 and new[t].any():
            moved = associate(
                known, (where[t - 1], seen[t - 1]), at_first, (where[0], seen[0]), where[t]
            )
            known = torch.where(new[t][:, None, None] > 0, moved * seen[t][..., None], known)
        changes, touched, began = known[..., -3:].unbind(-1)
        began = torch.where(rose[t], height[t], began)
        pressed = rose[t] | (touched > 0) & (height[t] < began + LIFTED)
        touched = torch.where(button[t], pressed.float(), torch.maximum(touched, touched_now[t]))
        kept = torch.stack([changes + rose[t], touched, began], -1)
        known = torch.cat([known[..., :-3], kept], -1)
        result.append(known)
    predecessor, changes, touched, _ = torch.stack(result).split(
        [appearances.shape[-1], 1, 1, 1], -1
    )
    counts = changes[..., 0].long().clamp(max=most - 1)
    return predecessor, nn.functional.one_hot(counts, most).float(), touched


def associate(known, last, at_first, first, where):
    """Labels of the objects at these positions in a new view (nearest-neighbour association).

    They are those of the object last there, else those of the object first there.
    """
    distance = torch.cdist(where, torch.cat([last[0], first[0]], 1))
    distance = distance.masked_fill(~torch.cat([last[1], first[1]], 1)[:, None], 9)
    distance[..., known.shape[1] :] += NEAR
    distance, which = distance.min(-1)
    source = torch.cat([known, at_first], 1)
    return source.gather(1, which[..., None].expand_as(known)) * (distance < 2 * NEAR)[..., None]
