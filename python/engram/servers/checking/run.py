"""The whole check of a server, and its report."""

from __future__ import annotations

import contextlib
import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from engram._args.values import integer
from engram.datasets.spaces import CONTROL_MODE, Spaces
from engram.errors import InvalidArgumentError
from engram.servers.checking import inputs, meaning
from engram.servers.checking.asking import Asker
from engram.servers.checking.findings import Finding
from engram.servers.checking.motions import small_motions
from engram.servers.checking.recording import Recording, record
from engram.servers.keys import PRESETS
from engram.servers.options import ServerOptions
from engram.servers.policy import ServerError, ServerPolicy

Array = npt.NDArray[Any]

_TASK = "RememberColor3-VLA-v0"
_POLICY_STEPS = 40  # questions of a recording


def check(
    url: str,
    ids: str | Sequence[str] = _TASK,
    *,
    seed: int = 4242424242,
    control_mode: str | None = None,
    tell_episodes: bool = False,
    timeout: float = 300.0,
    **options: Any,
) -> dict[str, Any]:
    """Asks a policy server some questions, and compares its answers with the oracle's.

    Args:
        url: As of ``ServerPolicy``.
        ids: Tasks that the policy was trained for. One episode of each is played by the oracle.
        seed: Of the first episode.
        control_mode: Of the environments; None: the tasks' own.
        tell_episodes: The server learns of the episode.
        timeout: Seconds for every answer.
        **options: Those of ``ServerPolicy``.

    Returns:
        A dict, which JSON can hold, with ``server``, ``questions`` (how many were asked), ``chunk``
        (actions of an answer), ``numbers`` (a dict for each number of an action: name, low, high,
        like, correlation, scale), ``agreement`` with the oracle (None: it does not move),
        ``motions`` (what each number does here), ``influence`` of each input on an answer,
        ``random`` (answers to one question differ), ``remembers`` (earlier frames matter), and
        ``findings``, each with ``mistake``, ``what``, ``likely`` and ``remedy``.
    """
    tasks = [ids] if isinstance(ids, str) else list(ids)
    if not tasks:
        raise InvalidArgumentError("ids: [] given, one id or several needed")
    seed = integer("seed", seed, 0, 2**63 - 1)
    keys = ServerPolicy(url, timeout=timeout, **options).keys
    environment: dict[str, Any] = {"joint_proprio": keys.needs_joints}
    if control_mode is not None:
        environment["control_mode"] = control_mode
    recordings = [record(id, seed + i, **environment) for i, id in enumerate(tasks)]
    dim = recordings[0].actions.shape[1]
    given = {"action_dim": dim, "timeout": timeout, "tell": tell_episodes, **options}
    with contextlib.closing(Asker(url, **given)) as asker:
        try:
            asker.ask(recordings[0], 0)
        except ServerError as error:
            return _refused(url, given, recordings[0], error)
        spaces = Spaces(control_mode or (CONTROL_MODE if dim == 7 else "pd_joint_delta_pos"))
        return _report(asker, recordings, spaces)


def _report(asker: Asker, recordings: list[Recording], spaces: Spaces) -> dict[str, Any]:
    findings: list[Finding | None] = []
    recording = recordings[0]
    noise = inputs.noise_of(asker, recording)
    influence = inputs.influences(asker, recording, noise)
    findings.append(inputs.reset_finding(asker, recording, noise))
    past = inputs.remembers(asker, recording, noise)
    steps, chunks, oracle = _answers(asker, recordings)
    answers = np.stack([chunk[0] for chunk in chunks])
    actions = meaning.meant(asker.convention, answers)
    findings += meaning.findings_of(asker.convention, answers, oracle)
    findings += [_spacing(asker, one, steps, chunks) for one in enumerate(recordings)]
    if influence.get("state"):
        findings += inputs.state_findings(asker, recording)
    findings.append(inputs.jump_finding(asker, recording))
    agreement = meaning.agreement(actions, oracle)
    findings += _notes(agreement, noise, influence, past, asker)
    return {
        "server": asker.options.url,
        "questions": asker.questions,
        "chunk": min(map(len, chunks)),
        "numbers": [
            dataclasses.asdict(number)
            for number in meaning.numbers_of(spaces.action_names, actions, oracle)
        ],
        "agreement": agreement,
        "motions": small_motions(asker.convention) if len(spaces.action_names) == 7 else [],
        "influence": influence,
        "random": noise > 0,
        "remembers": past,
        "findings": [dataclasses.asdict(one) for one in findings if one is not None],
    }


def _answers(
    asker: Asker, recordings: list[Recording]
) -> tuple[list[tuple[int, int]], list[Array], Array]:
    """Recording and step of each question, answers, and the oracle's actions."""
    steps, chunks, oracle = [], [], []
    for which, recording in enumerate(recordings):
        count = min(len(recording), _POLICY_STEPS)
        for i, t in enumerate(np.linspace(0, len(recording) - 1, count).round().astype(int)):
            steps.append((which, int(t)))
            chunks.append(asker.ask(recording, int(t), first=i == 0))
            oracle.append(recording.actions[t])
    return steps, chunks, np.stack(oracle).astype(np.float64)


def _spacing(
    asker: Asker,
    one: tuple[int, Recording],
    steps: list[tuple[int, int]],
    chunks: list[Array],
) -> Finding | None:
    which, recording = one
    asked = [
        (step, meaning.meant(asker.convention, chunk))
        for (owner, step), chunk in zip(steps, chunks)
        if owner == which
    ]
    return meaning.spacing_of(asked, recording.actions.astype(np.float64))


def _notes(
    agreement: float | None, noise: float, influence: dict[str, float], past: bool, asker: Asker
) -> list[Finding]:
    notes = []
    if agreement is None or agreement < 0.5:
        shown = "does not move" if agreement is None else f"{agreement:.2f}"
        notes.append(
            Finding(
                False,
                f"mean correlation with the oracle's actions: {shown}",
                "order, sign and scale cannot be seen in a policy that acts otherwise",
                "ids of tasks that it was trained for",
            )
        )
    if noise > 0:
        notes.append(
            Finding(
                False,
                f"answers to one question are up to {noise:.3g} apart",
                "the policy draws random numbers; results differ from run to run",
            )
        )
    unused = [name for name, distance in influence.items() if distance == 0]
    if unused:
        notes.append(
            Finding(
                False,
                f"answers do not depend on {', '.join(unused)}",
                "the server knows them by other names, or the policy does not use them",
                "--server-keys",
            )
        )
    if not past:
        notes.append(
            Finding(
                False,
                "earlier frames of an episode do not change an answer",
                "the policy has no memory, or never gets the frames between two questions",
                "--history since-last or N,STRIDE" if asker.options.history.is_last else "",
            )
        )
    return notes


# --- a server that refuses the first question ---


def _refused(
    url: str, given: dict[str, Any], recording: Recording, error: ServerError
) -> dict[str, Any]:
    protocol = ServerOptions.parse(url).protocol
    works = []
    for remedy, other in _others(protocol, given):
        try:
            with contextlib.closing(Asker(url, **other)) as asker:
                asker.ask(recording, 0)
                works.append(remedy)
        except (ServerError, InvalidArgumentError):
            continue
    finding = Finding(
        True,
        str(error),
        f"it answers with {', or with '.join(works)}" if works else "no other preset is answered",
        works[0] if works else "docs/policy_servers.md#keys",
    )
    return {
        "server": ServerOptions.parse(url).url,
        "questions": 0,
        "findings": [dataclasses.asdict(finding)],
    }


def _others(protocol: str, given: dict[str, Any]) -> list[tuple[str, dict[str, Any]]]:
    """Other options, and what the command line calls them."""
    others = [
        (f"--server-keys {name}", {**given, "keys": name, "wait": 1})
        for name in PRESETS[protocol]
        if name != given.get("keys", "mikasa")
    ]
    others += [
        (f"--server-state {layout}", {**given, "state": layout, "wait": 1})
        for layout in ("tcp7", "libero8")
    ]
    dim = 15 - given["action_dim"]
    mode = "--control-mode pd_joint_pos" if dim == 8 else "--control-mode pd_ee_delta_pose"
    return [*others, (mode, {**given, "action_dim": dim, "wait": 1})]
