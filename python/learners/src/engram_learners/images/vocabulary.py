"""Vocabulary of an ObjectDetector: classes of objects, and the tokens of a task."""

from typing import NamedTuple

import torch

from engram_learners.images.detector import CELL, HEIGHT, Objects
from engram_learners.images.views import METRES, SIDE, apparent, base_view, project
from engram_learners.rotations import nearer_half

MARGIN = 0.04  # metres of the heat map beyond the objects
LIT = 0.5  # least state of a lit lamp and a pressed button
AHEAD = torch.tensor([1.0, 0.0])  # turn of what is not seen
LONG = 2.5  # least length, in widths, of an object whose turn is seen


def class_codes(layout, tokens):
    """Code (...,) of every object's appearance, kind and state; -1 for invisible objects."""
    pairs = layout.pairs(tokens)
    kind = tokens[..., layout.part["kind"]].argmax(-1)
    lit = tokens[..., layout.part["state"]][..., 0] > LIT
    return torch.where(pairs >= 0, (pairs * 16 + kind) * 2 + lit, -1)


class Vocabulary(NamedTuple):
    """Buffers of an ObjectDetector, in the order of its arguments."""

    codes: torch.Tensor
    templates: torch.Tensor
    bodies: torch.Tensor
    tokens: torch.Tensor
    extent: torch.Tensor
    turning: torch.Tensor | None


def vocabulary(layout, tokens):
    """Vocabulary of tokens (T, N, tokens, width) of episodes."""
    codes, bodies = class_codes(layout, tokens), layout.bodies(tokens, layout.pairs(tokens))
    classes = codes[codes >= 0].unique()
    templates = torch.stack([template(layout, tokens[codes == one]) for one in classes])
    kinds = bodies[bodies >= 0].unique()
    of_class = torch.stack([bodies[codes == one][0] for one in classes])
    of_token = kinds.repeat_interleave(most_alike(bodies, kinds))
    shown = METRES * tokens[..., layout.place][codes >= 0]
    long = long_classes(layout, templates)
    return Vocabulary(classes, templates, of_class, of_token, extent(shown[in_image(shown)]), long)


def most_alike(bodies, kinds):
    """How many objects (kinds,) of each kind of body there are at most in a step (..., tokens)."""
    return torch.stack([(bodies == kind).sum(-1).max() for kind in kinds])


def long_classes(layout, templates):
    """Which classes (classes,) are long along their own x; None if none is."""
    length, width = templates[:, layout.part["size"]].split([1, 2], -1)
    long = (length > LONG * width).all(-1)
    return long if long.any() else None


def extent(places):
    """Low and high of x and of y in which the base camera shows these places (P, 3)."""
    places = apparent(places, HEIGHT)[:, :2]
    low, high = places.amin(0) - MARGIN, places.amax(0) + MARGIN
    cells = ((high - low) / CELL).ceil()
    return torch.stack([low, low + CELL * (cells - 1e-3)], -1)


def in_image(places):
    """Whether places (..., 3) are in the base camera's image."""
    pixels = project(places.reshape(1, -1, 3), base_view()).view(*places.shape[:-1], 2)
    return ((pixels > 0) & (pixels < SIDE - 1)).all(-1)


def template(layout, tokens):
    """Token of a class: the first, with the mean state and height."""
    result = tokens[0].clone()
    result[layout.part["state"]] = tokens[:, layout.part["state"]].mean(0)
    return result


def ranks(of_token):
    """Number of every token (tokens,) among those of the same body."""
    return (of_token == of_token[:, None]).tril(-1).sum(-1)


def used_tokens(layout, detector, tokens):
    """Which of the detector's tokens (tokens,) episodes use, from their labels' tokens."""
    bodies = layout.bodies(tokens, layout.pairs(tokens))
    return ranks(detector.tokens) < most_alike(bodies, detector.tokens)


def sort(layout, detector, tokens, before):
    """The labels of tokens (..., width) in any order, as Objects in the order of the detector.

    before: Objects of the step before, whose turns go on.
    """
    bodies = layout.bodies(tokens, layout.pairs(tokens))
    same = bodies[..., None, :] == bodies[..., None]
    rank = (same & torch.ones(same.shape[-2:]).tril(-1).bool()).sum(-1)
    mine = (bodies[..., None, :] == detector.tokens[:, None]) & (
        rank[..., None, :] == ranks(detector.tokens)[:, None]
    )
    place = METRES * (mine.float() @ tokens[..., layout.place])
    equal = class_codes(layout, tokens)[..., None] == detector.codes
    named = torch.where(equal.any(-1), equal.float().argmax(-1), -1)
    known = torch.where(mine, named[..., None, :], -1).amax(-1)
    known = torch.where(in_image(place), known, -1)
    turn = nearer_half(mine.float() @ layout.yaw(tokens), before.turn)
    return Objects(place, known, torch.where(known[..., None] < 0, AHEAD, turn))
