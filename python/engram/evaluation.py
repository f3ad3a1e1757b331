"""The benchmark's evaluation protocol with a policy in Python."""

from __future__ import annotations

import contextlib
import functools
import json
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal, ParamSpec

import numpy as np

from engram import _core
from engram._args.methods import real_array
from engram._args.options import make_evaluation_options
from engram._args.values import integer, path, text
from engram.errors import Error, InvalidArgumentError
from engram.tasks import describe

if TYPE_CHECKING:
    from engram.typing import ControlMode, Physics, Renderer, Rules

__all__ = ["compare", "evaluate", "merge", "probe", "report", "suites"]

PROBES = ("twins", "forgetting", "interference", "capacity")
Policy = Callable[[dict[str, Any]], Any]
Act = Callable[[dict[str, Any]], list[np.ndarray]]
Results = str | os.PathLike[str] | Mapping[str, Any]
P = ParamSpec("P")
Result = dict[str, Any]


def _with_servers(function: Callable[P, Result]) -> Callable[P, Result]:
    """A function whose policy may be the address of a server."""

    @functools.wraps(function)
    def evaluate(*args: P.args, **kwargs: P.kwargs) -> Result:
        given: Any = args[0] if args else kwargs.get("policy")
        if not isinstance(given, str):
            return function(*args, **kwargs)
        from engram.servers.options import is_url
        from engram.servers.policy import ServerPolicy

        if not is_url(given):
            return function(*args, **kwargs)
        dim = _action_dim(args[1] if len(args) > 1 else kwargs.get("ids"), kwargs)
        own = {name: kwargs.pop(name) for name in ("replan", "history") if name in kwargs}
        chosen: dict[str, Any] = {
            name: str(value) for name, value in own.items() if value not in (0, "last")
        }
        with contextlib.closing(ServerPolicy(given, action_dim=dim, **chosen)) as server:
            kwargs.setdefault("config", server.config)
            kwargs.update({} if args else {"policy": server})
            return function(*((server, *args[1:]) if args else ()), **kwargs)  # type: ignore[arg-type]

    return evaluate


@_with_servers
def evaluate(
    policy: Policy | str | None = None,
    ids: str | Iterable[str] | None = None,
    *,
    # begin generated: evaluate (tools/surface, and the options below)
    suite: str | None = None,
    episodes: int | None = None,
    seed: int = 4242424242,
    num_envs: int = 8,
    threads: int = 0,
    obs: Literal["rgb", "state", "objects"] = "rgb",
    renderer: Renderer = "cpu",
    control_mode: ControlMode | None = None,
    joint_proprio: bool = False,
    rules: Rules = "reference",
    task_options: Mapping[str, float] | None = None,
    constants: Mapping[str, Any] | None = None,
    name: str = "external",
    config: Mapping[str, Any] | None = None,
    output: str | os.PathLike[str] | None = None,
    resume: str | os.PathLike[str] | None = None,
    tell_episodes: bool = False,
    seed_file: str | os.PathLike[str] | None = None,
    progress: Callable[[int, int, int], None] | None = None,
    repeat: int = 1,
    policy_seed: int = 0,
    latency: int | str = 0,
    perturb: Mapping[str, float] | None = None,
    choices: Callable[[dict[str, Any]], Any] | None = None,
    choices_stride: int = 1,
    physics: Physics = "engram",
    shard: str | None = None,
    # end generated
    replan: int = 0,
    history: str = "last",
) -> dict[str, Any]:
    """Success rates of a policy: ``{"summary": ..., "tasks": [...]}``, as ``engram eval --json``.

    ``policy(observation)`` is called with the episodes that need actions, N of them:

    * ``rgb`` (N, 128, 128, 6) uint8, base camera before wrist camera; with ``obs="rgb"`` only
    * ``state`` (N, state_dim) float32: the row of ``obs="state"`` or ``obs="objects"``, recorded
      in the results
    * ``proprio`` (N, 7) float32, or with ``joint_proprio`` (N, 8): seven joint angles (rad) and
      the gripper's opening (m); ``instruction`` N strings, ``env_id``
    * ``episode``, ``step`` (N,): opaque number of the episode, control steps so far. The number is
      the same in every run and fit to seed random numbers. With ``tell_episodes`` it counts from 0,
      and ``seed`` (N,) is there
    * ``first`` (N,): 1 at the first request of an episode
    * ``worker`` and ``slot`` (N,): constant during an episode
    * ``policy_seed``: of the policy's own random numbers, the same for all N

    Or ``policy`` is the address of a policy server, such as "openpi://localhost:8000?replan=8"
    (docs/policy_servers.md), with the server's options as its query.

    The arrays are copies. The policy returns an array of shape (N, A) or (N, K, A), or a sequence
    of N arrays of shape (A), (K, A) or (1, K, A), where A is what ``control_mode`` has
    (docs/robot.md); without one, the tasks' own counts: pd_ee_delta_pose (7), or
    pd_joint_delta_pos (8) of the RL ids. The K actions are used one per step before the
    policy is called for the episode again. It is called from several threads, by one at a time;
    ``threads=1, num_envs=50`` makes one large batch.

    ``ids``: one id or several, 50 ``episodes`` each by default. Or ``suite``: the ids
    and episodes of a list in :func:`engram.suites`, such as "mikasa5".
    ``rules``: "reference" or "original"; like ``task_options`` and ``constants``, those of the
    environments.
    ``output``: results go to ``<output>/<split>/<date_time>/``, and so does ``policy.identity``, if
    there is such a dict: what the policy is, such as ``{"checkpoint": "sha256:..."}``.
    ``resume``: folder of an interrupted run with the same arguments.
    ``seed_file``: a sealed evaluation, whose seeds follow from the secret line in that file instead
    of ``seed``; see docs/evaluation.md.
    ``progress``: a function of episodes, all_episodes and env_steps, called several times a second.
    ``repeat``: rounds of the same episodes; round i has ``policy_seed`` + i.
    ``latency``: control steps (``3``), or milliseconds (``"120ms"``), from a call of the policy to
    the first action of its answer; the world goes on with the last action meanwhile.
    ``perturb``: departures from the tasks' usual scenes, robot and words, by axis, from 0 (none) to
    1: docs/variants.md.
    ``physics``: "engram": its own; "mujoco": MuJoCo's, by ``mj_step``.
    ``shard``: "I/N": plays share I of N alone, into ``<output>/shard-I-of-N/``, or what is missing
    of it; then :func:`merge` makes one result of all shares, and the call returns {"shard", "out",
    "episodes"}.

    ``choices``: in place of ``policy``, a function that names an answer, which a scripted hand
    carries out (docs/choices.md). ``choices(question)`` is called for one episode at a time, with
    ``choices`` (a list of texts), ``question`` and ``instruction``, the frames since the episode
    began (``rgb``, ``state``, ``proprio``, ``text``, ``steps``, ``choices_stride`` steps apart) and
    ``least``, ``most`` and ``repeats`` of an answer. It returns a text of ``choices``, its index,
    or a list of these.

    ``replan``: actions of a chunk that are used before the policy is called again; 0: all.
    ``history``: frames that the policy is shown: "last", "since-last" or "N,STRIDE", as for servers
    (docs/policy_servers.md). Unless it is "last", observations also have ``frames``, a dict for
    each episode: ``rgb``, ``state``, ``proprio`` and ``step`` over time, the oldest first.
    """
    arguments = dict(locals())
    if choices is not None:
        if policy is not None:
            raise InvalidArgumentError("policy, choices: one of them allowed")
        if not callable(choices):
            raise InvalidArgumentError(f"choices: {choices!r} given, a function needed")
    call: Any = choices
    act = _checked_policy(policy if choices is None else choices, obs, progress)
    if choices is None:
        act = _with_history(act, arguments)
    elif replan or history != "last":
        raise InvalidArgumentError("replan, history: for policies that act; choices given")

    def choose(question: dict[str, Any]) -> list[str]:
        return _named(call(question))

    tasks, episodes = _tasks(ids, suite, episodes)
    if constants:
        # Warns of those without effect and those with which the oracle fails. The evaluation
        # refuses bad arguments in its own words.
        with contextlib.suppress(Error):
            for id in tasks:
                describe(id, rules=rules, task_options=task_options, constants=constants)
    document = _core.evaluate(
        policy=act if choices is None else choose,
        options=make_evaluation_options(tasks, {**arguments, "episodes": episodes}),
        progress=progress,
        choices=choices is not None,
        identity=lambda: _identity_of(policy),
    )
    return json.loads(document)


@_with_servers
def probe(
    policy: Policy | str,
    ids: str | Iterable[str],
    *,
    # begin generated: probe
    probes: Iterable[str] = PROBES,
    other: str | None = None,
    episodes: int = 50,
    seed: int = 4242424242,
    num_envs: int = 8,
    threads: int = 0,
    obs: Literal["rgb", "state", "objects"] = "rgb",
    renderer: Renderer = "cpu",
    control_mode: ControlMode | None = None,
    joint_proprio: bool = False,
    rules: Rules = "reference",
    constants: Mapping[str, Any] | None = None,
    name: str = "external",
    config: Mapping[str, Any] | None = None,
    output: str | os.PathLike[str] | None = None,
    progress: Callable[[int, int, int], None] | None = None,
    task_options: Mapping[str, float] | None = None,
    policy_seed: int = 0,
    latency: int | str = 0,
    perturb: Mapping[str, float] | None = None,
    physics: Physics = "engram",
    # end generated
    replan: int = 0,
    history: str = "last",
) -> dict[str, Any]:
    """Whether a policy reads its memory: ``{"settings", "other", "tasks"}``, as ``engram probe``.

    docs/probe.md has the definitions and keys. ``policy`` and all arguments that :func:`evaluate`
    has as well are as there; ``first`` is also 1 where a policy is wiped at the question.

    ``probes``: some of "twins", "forgetting", "interference" and "capacity". ``other``: id of the
    task of further episodes of interference. ``episodes``: at each point; pairs of twins.
    ``output``: folder of probe.json and probe.html.
    """
    arguments = dict(locals())
    act = _with_history(_checked_policy(policy, obs, progress), arguments)
    if isinstance(probes, (str, bytes)) or not isinstance(probes, Iterable):
        raise InvalidArgumentError(f"probes: {probes!r} given, a list of words needed")
    document = _core.probe(
        policy=act,
        options=make_evaluation_options(_ids(ids), arguments),
        progress=progress,
        probes=",".join(text("probes", word) for word in probes),
        other=None if other is None else text("other", other),
    )
    return json.loads(document)


def _identity_of(policy: Any) -> str:
    """What the policy tells of itself so far, as JSON; nothing if it tells nothing."""
    identity = getattr(policy, "identity", None)
    if not isinstance(identity, Mapping) or not identity:
        return ""
    from engram.servers.identity import identity_in, packed_identity

    return packed_identity(identity_in(identity)).decode()


def _checked_policy(policy: Any, obs: Any, progress: Any) -> Act:
    """The policy with one array per episode as its answer."""
    if not isinstance(obs, str) or obs not in ("rgb", "state", "objects"):
        raise InvalidArgumentError(f"obs: {obs!r} given, 'rgb', 'state' or 'objects' allowed")
    for what, function in (("policy", policy), ("progress", progress)):
        if not callable(function) and (function is not None or what == "policy"):
            more = ", or the address of a policy server" if what == "policy" else ""
            raise InvalidArgumentError(f"{what}: {function!r} given, a function needed{more}")

    def act(observation: dict[str, Any]) -> list[np.ndarray]:
        return _chunks(policy(observation), len(observation["instruction"]))

    return act


def _with_history(act: Act, arguments: dict[str, Any]) -> Act:
    """The policy with the chunks and the frames that the arguments name, which results say."""
    from engram.servers.chunked import ChunkedPolicy
    from engram.servers.limits import ACTIONS

    replan = integer("replan", arguments["replan"], 0, ACTIONS)
    history = text("history", arguments["history"])
    chosen: dict[str, Any] = {"replan": replan} if replan else {}
    chosen |= {"history": history} if history != "last" else {}
    if not chosen:
        return act
    arguments["config"] = {**(arguments["config"] or {}), **chosen}
    return ChunkedPolicy(act, replan, history)


def merge(
    folders: str | os.PathLike[str] | Iterable[str | os.PathLike[str]],
    output: str | os.PathLike[str] | None = None,
) -> dict[str, Any]:
    """One result of the shards of an evaluation: what :func:`evaluate` returns in one process.

    The files have its bytes, too. ``folders``: folders of shards, or those that have them, as
    ``output`` of the shards. ``output``: the result goes to ``<output>/<split>/<date_time>/``;
    default: beside the first shard.

    Raises:
        UnavailableError: Shards are missing or not finished.
        InvalidArgumentError: They do not belong to one run.
    """
    several = (
        folders if isinstance(folders, Iterable) and not isinstance(folders, str) else [folders]
    )
    names = [path("folders", folder) for folder in several]
    out = None if output is None else path("output", output)
    return json.loads(_core.merge(folders=names, output=out))


def compare(a: Results, b: Results, *, allow: Iterable[str] = ()) -> dict[str, Any]:
    """Two policies on the same episodes: ``{"a", "b", "tasks", "splits", "total"}``.

    The same as ``engram compare --json``; docs/evaluation.md describes the keys. ``a`` and ``b``
    are folders of runs, JSON files of results, or what :func:`evaluate` has returned. ``allow``:
    in what they may differ, of "ids", "seeds", "version", "rules", "constants", "choices" and
    "physics".
    """
    if isinstance(allow, (str, bytes)) or not isinstance(allow, Iterable):
        raise InvalidArgumentError(f"allow: {allow!r} given, a list of words needed")
    words = [text("allow", word) for word in allow]
    return json.loads(_core.compare(a=_source("a", a), b=_source("b", b), allow=words))


def report(results: Results, format: str = "md") -> str:
    """A table of results, as ``engram report`` prints it.

    ``results``: the folder of a run, a JSON file of results, or what :func:`evaluate` has returned.
    ``format``: "md", "latex" (booktabs), "csv" (a line per task), "episodes" (CSV, a line per
    episode) or "vla-eval" (an entry of its leaderboard).
    """
    return _core.report(results=_source("results", results), format=text("format", format))


def _source(what: str, results: Any) -> str:
    if isinstance(results, Mapping):
        try:
            return json.dumps(dict(results), allow_nan=False)
        except (TypeError, ValueError, RecursionError):
            raise InvalidArgumentError(f"{what}: no results of an evaluation given") from None
    return path(what, results)


def suites() -> dict[str, dict[str, Any]]:
    """Named lists of tasks that results are published on: {name: {"ids", "episodes", "seed"}}."""
    return json.loads(_core.suites_json())


def _tasks(ids: Any, suite: Any, episodes: int | None) -> tuple[list[str], int]:
    """The tasks and the number of episodes."""
    if suite is None:
        if ids is None:
            raise InvalidArgumentError("ids: None given, an id, a list of them or a suite needed")
        return _ids(ids), 50 if episodes is None else episodes
    if ids is not None:
        raise InvalidArgumentError("ids, suite: one of them allowed")
    found = suites().get(text("suite", suite))
    if found is None:
        raise InvalidArgumentError(f"suite: {suite!r} given, {', '.join(suites())} allowed")
    return found["ids"], found["episodes"] if episodes is None else episodes


def _action_dim(ids: Any, options: Mapping[str, Any]) -> int:
    """Numbers of an action in the control mode that the options ask for."""
    mode = options.get("control_mode")
    tasks, _ = _tasks(ids, options.get("suite"), None)
    return describe(tasks[0], control_mode=mode)["action_dim"] if tasks else 7


def _ids(ids: Any) -> list[str]:
    if isinstance(ids, str):
        ids = [ids]
    if not isinstance(ids, Iterable) or isinstance(ids, (bytes, Mapping)):
        raise InvalidArgumentError(f"ids: {ids!r} given, an id or a list of them needed")
    return [text("ids", id) for id in ids]


def _named(answer: Any) -> list[str]:
    """The answer to a question as texts: those of choices, or indices in digits."""
    items = list(answer) if isinstance(answer, (list, tuple, np.ndarray)) else [answer]
    named = []
    for item in items:
        if isinstance(item, str):
            named.append(text("choices", item))
        elif isinstance(item, (int, np.integer)) and not isinstance(item, bool):
            named.append(str(int(item)))
        else:
            raise InvalidArgumentError(
                f"choices: {answer!r} given, a text, an index or a list of them needed"
            )
    return named


def _chunks(answer: Any, count: int) -> list[np.ndarray]:
    """The answer as one array per episode."""
    if not isinstance(answer, Sequence) or isinstance(answer, (str, bytes)):
        answer = real_array("policy", answer)
        if answer.ndim == 0:
            raise InvalidArgumentError(f"policy: {answer!r} given, {count} rows of actions needed")
    if len(answer) != count:
        raise InvalidArgumentError(f"policy: {len(answer)} rows given, {count} needed")
    return [
        np.require(real_array(f"policy, row {row}", chunk), np.float32, ["C_CONTIGUOUS", "ALIGNED"])
        for row, chunk in enumerate(answer)
    ]
