"""Episodes continue, bit for bit, from snapshots in other slots and batches."""

from __future__ import annotations

from typing import Any

from engram.kit.checks.hints import suspicious_lines
from engram.kit.checks.play import Player, actions_of, difference
from engram.kit.checks.subject import Subject

_SEEDS = tuple(range(60, 64))
_MOST_STEPS = 40  # after a snapshot


def check(subject: Subject) -> None:
    horizon, policy = subject.horizon, subject.policy
    moments = sorted({min(1, horizon - 1), horizon // 3, horizon // 2, max(horizon - 2, 0)})
    saved = {}
    with subject.batch(len(_SEEDS)) as env:
        player = Player(subject, env, policy)
        player.begin(_SEEDS)
        for step in range(horizon):
            if step in moments:
                saved[step] = [env.save(i) for i in range(len(_SEEDS))]
            player.step()
    actions = actions_of(player.steps, policy)
    for moment in moments:
        found = _continued(subject, saved[moment], player.steps[moment:], actions[moment:])
        if found is not None:
            name, step, env_index = found
            lines = suspicious_lines(subject.tasks[-1]) if subject.is_own else ""
            subject.add(
                "snapshots", "wrong",
                f"saved in step {moment} and restored in another batch, {name} differs "
                f"{step} steps later (seed {_SEEDS[env_index]}): what a method keeps has to be in "
                f"columns (remember()), and draws may not be drawn later{lines}", step=moment,
            )  # fmt: skip
            return
    subject.add(
        "snapshots", "ok",
        f"episodes saved in steps {', '.join(map(str, moments))} continue in other slots and "
        "batches, bit for bit",
    )  # fmt: skip


def _continued(
    subject: Subject, saved: list[bytes], steps: list[dict[str, Any]], actions: list[Any]
) -> tuple[str, int, int] | None:
    """What differs, restored into a batch of another size that has played something else."""
    count = len(saved)
    with subject.batch(count + 2) as env:
        player = Player(subject, env, subject.policy)
        player.begin(range(900, 902 + count))
        for _ in range(min(4, subject.horizon - 1)):
            player.step()
        slots = [count + 1 - i for i in range(count)]  # back to front
        for slot, one in zip(slots, saved):
            observation, info = env.restore(one, slot)
        restored = [player.outputs(observation, info)]
        for number, given in enumerate(actions):
            mixed = env.act("zero")
            mixed[slots] = given
            restored.append(player.step(mixed))
            if number >= _MOST_STEPS:
                break
    unlike = [{name: value[slots] for name, value in step.items()} for step in restored]
    return difference(steps, unlike)
