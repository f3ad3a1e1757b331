"""Policies that are served: engram's own, in a twin of the client's episode, and learnt ones."""

from __future__ import annotations

import abc
import collections
import dataclasses
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from engram._io.source_file import run_file
from engram.errors import Error, InvalidArgumentError
from engram.factory import make
from engram.servers.identity import identity_of_file
from engram.servers.limits import FRAMES

Array = npt.NDArray[Any]

SCRIPTED = ("oracle", "sweep", "blind", "random", "zero")
_TCP = 7  # numbers of proprio with the TCP's pose
_TWINS = 256


class RequestError(Error):
    """A request that a policy cannot answer."""


@dataclasses.dataclass(frozen=True)
class Request:
    """What a client has sent: frames, oldest first, without names of keys.

    session: number of the connection or session; first: its episode has just begun.
    rgb: (T, H, W, 6), proprio: (T, 7 or 8), row: (T, W), each None if it was not sent.
    episode: what ``--tell-episodes`` tells.
    """

    session: int
    first: bool
    rgb: Array | None
    proprio: Array | None
    row: Array | None
    prompt: str
    episode: Mapping[str, Any] | None


class ServedPolicy(abc.ABC):
    identity: Mapping[str, Any] = {}  # what the server tells of it

    @abc.abstractmethod
    def answer(self, request: Request) -> Array:
        """Actions (K, dim). Raises Error with a sentence for the client."""


# --- engram's own policies ---


class _Twin:
    """The client's episode, played by the policy itself.

    The environment is deterministic, so the same seed and the same actions give the same course.
    """

    def __init__(self, policy: str, env_id: str, seed: int, options: Mapping[str, Any]) -> None:
        self._policy = policy
        self._seed = seed
        self._env: Any = make(env_id, obs_mode="state", **options)
        self._actions: list[Array] = []  # that have been found
        self._proprio: list[Array] = []  # before each of them
        self._restart()

    def chunk(self, step: int, length: int) -> Array:
        """Actions from that step on; the last one again after the end of the episode."""
        while len(self._actions) < step + length and not self._ended:
            self._advance()
        if not self._actions[step:]:
            raise RequestError(f"step {step}: the episode has ended after {len(self._actions)}")
        found = self._actions[step : step + length]
        return np.stack(found + [found[-1]] * (length - len(found)))

    def require_same(self, step: int, proprio: Array) -> None:
        """Refuses a client whose episode took another course."""
        here = self._proprio[step]
        if proprio.shape != here.shape:
            raise RequestError(
                f"engram: proprio of {proprio.size} numbers given, {here.size} needed; "
                "engram serve needs --joint-proprio where the client has it"
            )
        if not np.array_equal(here, proprio):
            far = float(np.abs(here[:3] - proprio[:3]).max())
            tcp = here.size == _TCP
            where = f"TCP {1000 * far:.1f} mm away" if tcp else f"a joint {far:.4f} rad"
            raise RequestError(
                f"step {step}: the client's robot is elsewhere than this policy has moved it "
                f"({where}); its actions are not executed as they are sent"
            )

    def close(self) -> None:
        self._env.close()

    def _restart(self) -> None:
        _, info = self._env.reset(seed=self._seed)
        self._now = np.array(info["proprio"], np.float32)
        self._ended = False

    def _advance(self) -> None:
        action = np.array(self._env.act(self._policy), np.float32)
        self._actions.append(action)
        self._proprio.append(self._now)
        _, _, terminated, truncated, info = self._env.step(action)
        self._now = np.array(info["proprio"], np.float32)
        self._ended = bool(terminated or truncated)


class ScriptedPolicy(ServedPolicy):
    """One of engram's own policies. They see what is hidden, so the client has to tell its episode.

    Args:
        name: One of SCRIPTED.
        chunk: Actions of an answer.
        options: Of the environments: rules, task_options, constants.
    """

    def __init__(self, name: str, chunk: int, options: Mapping[str, Any]) -> None:
        self.identity = {"policy": name}
        self._name = name
        self._chunk = chunk
        self._options = options
        self._twins: collections.OrderedDict[tuple[str, int], _Twin] = collections.OrderedDict()

    def answer(self, request: Request) -> Array:
        episode = request.episode
        if episode is None:
            raise RequestError(
                f"{self._name} needs env_id, seed and step of the episode under the key 'engram'; "
                "--tell-episodes (tell_episodes=True) sends them"
            )
        try:
            env_id, seed, step = str(episode["env_id"]), int(episode["seed"]), int(episode["step"])
        except (KeyError, TypeError, ValueError):
            raise RequestError(
                f"engram: {episode!r:.100} given; env_id, seed, step needed"
            ) from None
        if not 0 <= step < 1_000_000:
            raise RequestError(f"engram: step {step} given, 0 or more needed")
        twin = self._twin(env_id, seed)
        chunk = twin.chunk(step, self._chunk)
        if episode.get("proprio") is not None:
            twin.require_same(step, np.asarray(episode["proprio"], np.float32))
        return chunk

    def _twin(self, env_id: str, seed: int) -> _Twin:
        name = (env_id, seed)
        if name not in self._twins:
            self._twins[name] = _Twin(self._name, env_id, seed, self._options)
            if len(self._twins) > _TWINS:
                self._twins.popitem(last=False)[1].close()
        self._twins.move_to_end(name)
        return self._twins[name]


# --- learnt policies ---


class CallablePolicy(ServedPolicy):
    """A policy of ``engram.evaluate``, called with one episode and one frame at a time."""

    def __init__(self, policy: Callable[[dict[str, Any]], Any]) -> None:
        self._policy = policy
        self._steps: dict[int, int] = {}

    def answer(self, request: Request) -> Array:
        sent = [part for part in (request.rgb, request.proprio, request.row) if part is not None]
        counts = {len(part) for part in sent}
        if not any(counts):
            raise RequestError("no images and no state given; keys of the preset needed")
        frames = max(counts)
        if len(counts) > 1 or frames > FRAMES:
            raise RequestError(
                f"{', '.join(map(str, sorted(counts)))} frames given; the same number of images "
                f"and states, 1 to {FRAMES}, needed"
            )
        for frame in range(frames):  # those before the last one are for its memory
            begins = request.first and frame == 0
            step = 0 if begins else self._steps.get(request.session, -1) + 1
            self._steps[request.session] = step
            chunk = self._act(self._observation(request, frame, begins, step))
        return chunk.reshape(-1, chunk.shape[-1])

    def _act(self, observation: dict[str, Any]) -> Array:
        try:
            return np.asarray(self._policy(observation)[0], np.float32)
        except Exception as error:
            raise RequestError(f"the policy failed: {type(error).__name__}: {error}") from error

    def _observation(self, request: Request, frame: int, first: bool, step: int) -> dict[str, Any]:
        def row(values: Array | None) -> Array | None:
            return None if values is None else values[frame : frame + 1]

        episode = request.episode or {}
        return {
            "env_id": str(episode.get("env_id", "")),
            "worker": 0,
            "slot": np.array([request.session], np.int32),
            "episode": np.array([episode.get("episode", 0)], np.int32),
            "step": np.array([step], np.int32),
            "first": np.array([first], np.uint8),
            "instruction": [request.prompt],
            "proprio": row(request.proprio),
            "rgb": row(request.rgb),
            "state": row(request.row),
        }


def load_policy(loader: str, file: str) -> CallablePolicy:
    """A policy that a function of the user's makes of a file; loader: FILE.py:NAME."""
    path, _, name = loader.rpartition(":")
    if not path.endswith(".py") or not name:
        raise InvalidArgumentError(f"--loader: {loader!r} given, FILE.py:NAME needed")
    source = Path(path).resolve()
    if not source.is_file():
        raise InvalidArgumentError(f"--loader: there is no file {path!r}")
    sys.path.insert(0, str(source.parent))  # as of a program: it may import its neighbours
    made: Any = run_file(source.stem, source)
    for part in name.split("."):
        made = getattr(made, part, None)
    if not callable(made):
        raise InvalidArgumentError(f"--loader: {path!r} has no function {name!r}")
    policy = made(file)
    if not callable(policy):
        raise InvalidArgumentError(f"--loader: {name} made {policy!r:.60}, a policy needed")
    served = CallablePolicy(policy)
    if Path(file).is_file():
        served.identity = identity_of_file(file)
    return served
