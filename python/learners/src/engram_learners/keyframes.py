"""Keyframes: what a policy's state keeps of its last events, exactly.

Events come from the policy's own observations: a view begins (an object appears), or a lamp or a
button goes on. The state keeps the objects' poses of the view's first step, the tool's position at
the moment when an object went on, and clocks: steps since the view began and since something went
on. The features are what has changed since then.
"""

import math
from typing import NamedTuple

import torch

from engram_learners.rotations import angle, relative

ON, OFF = 0.35, 0.2  # thresholds with hysteresis of lit lamps and pressed buttons
RATES = (1, 2, 4, 8, 16, 32)  # angular frequencies over the logarithm of a clock
HEIGHTS = (5, 10, 20, 40)  # ... over the tool's rise, per 0.5 m
# Features by object: its motion (3) and turn (3) in this view; the tool's way since it went on (3)
# and rise in detail; that it is on, and goes on now; what remains of a commanded turn (3).
N_SINCE = 3 + 3 + 3 + 2 * len(HEIGHTS) + 2 + 3
N_CLOCK = 2 * (1 + 2 * len(RATES))  # features of both clocks
N_KEPT = 3 + 2 + 3 + 1 + 2  # numbers by object in the state


def arrivals(bodies, before=None):
    """Steps (T, N, 1) in which an object appears: a new view begins, with fixed tokens.

    bodies (T, N, tokens): those of `ObservationLayout.bodies`; another index means another object.
    before: those (N, tokens) before the first step, or None.
    """
    earlier = torch.full_like(bodies[:1], -1) if before is None else before[None]
    earlier = torch.cat([earlier, bodies[:-1]])
    return ((bodies >= 0) & (bodies != earlier)).any(-1, keepdim=True).float()


def last_step(event):
    """The last step (T, ...) of the event up to every step; -1 before the first one."""
    steps = torch.arange(len(event), device=event.device).view(-1, *[1] * (event.dim() - 1))
    return torch.where(event, steps, -1).cummax(0).values


def latch(values, event, initial):
    """Values (T, N, tokens, D) of the event's last step (T, N, tokens); `initial` before it."""
    index = (last_step(event) + 1)[..., None].expand_as(values)
    return torch.cat([initial[None], values]).gather(0, index)


def clock(event, initial):
    """Steps (T, N) since the event, which go on from the initial ones."""
    last = last_step(event)
    steps = torch.arange(len(event), device=event.device)[:, None]
    return torch.where(last < 0, initial + steps + 1, steps - last).float()


def rises(state, new, was_on):
    """Steps (T, N, tokens) in which an object's state goes on in a view; whether it is on."""
    above = state >= ON
    below = ((state <= OFF) | new) & ~above
    since = last_step(above), last_step(below)
    on = torch.where(torch.maximum(*since) < 0, was_on, since[0] > since[1])
    before = torch.cat([was_on[None], on[:-1]])
    return on & ~before & ~new, on


def clock_features(steps):
    """Features (..., N_CLOCK / 2): equal shares of a duration are equally far apart."""
    log = (1 + steps).log()[..., None]
    phases = log * torch.tensor(RATES, device=steps.device)
    return torch.cat([log / 3, phases.sin(), phases.cos()], -1)


def remaining(layout, agent, turned_by):
    """What remains (..., tokens, 3) of a commanded turn, coarse to fine, after these angles."""
    if layout.turn is None:
        return turned_by.new_zeros(*turned_by.shape[:-1], 3)
    rest = math.pi * agent[..., None, layout.turn] - turned_by
    rest = torch.remainder(rest + math.pi, 2 * math.pi) - math.pi
    return torch.cat([rest, (5 * rest).tanh(), (25 * rest).tanh()], -1)


class Keyframes(NamedTuple):
    """Features by object (T, N, tokens, N_SINCE) and of the clocks (T, N, N_CLOCK).

    kept (N, tokens, N_KEPT): what the next call continues from.
    """

    by_object: torch.Tensor
    clocks: torch.Tensor
    kept: torch.Tensor


@torch.no_grad()
def keyframes(layout, rows, new, kept):
    """Continues from what is kept (N, tokens, N_KEPT); None begins an episode.

    new (T, N, 1): from `arrivals`.
    -> Keyframes.
    """
    agent, tokens = layout.split(rows)
    if kept is None:
        kept = tokens.new_zeros(*tokens.shape[1:3], N_KEPT)
    pose, tool_then, was_on, clocks = kept.split([5, 3, 1, 2], -1)
    new = (new > 0).expand(tokens.shape[:3])
    tool = agent[..., None, layout.tcp].expand(*tokens.shape[:3], 3)
    now = torch.cat([tokens[..., layout.place], layout.yaw(tokens)], -1)
    pose = latch(now, new, pose)
    rose, on = rises(tokens[..., layout.part["state"]][..., 0], new, was_on[..., 0] > 0)
    tool_then = latch(tool * rose[..., None], new | rose, tool_then)
    view, change = clocks[:, 0].unbind(-1)
    view = clock(new[..., 0], view)
    change = clock(new[..., 0] | rose.any(-1), change)
    went_on = (tool_then != 0).any(-1, keepdim=True)
    seen = tokens[..., :1]
    turn = relative(pose[..., 3:], now[..., 3:])
    turned_by = angle(turn)[..., None]
    moved = 5 * (now[..., :3] - pose[..., :3])
    now_on = torch.stack([on, 3 * rose], -1).float()
    way = (tool - tool_then) * went_on
    rise = way[..., 2:] * torch.tensor(HEIGHTS, device=way.device)
    remains = remaining(layout, agent, turned_by)
    since = [moved, turn, turned_by, 5 * way, rise.sin(), rise.cos(), now_on, remains]
    since = torch.cat(since, -1) * seen
    of_clocks = torch.cat([clock_features(view), clock_features(change)], -1)
    both = torch.stack([view[-1], change[-1]], -1)[:, None].expand(*tokens.shape[1:3], 2)
    kept = torch.cat([pose[-1], tool_then[-1], on[-1, ..., None].float(), both], -1)
    return Keyframes(since, of_clocks, kept)
