"""A policy server as a policy of ``engram.evaluate``, and of the pipe protocol (bridge.py)."""

from __future__ import annotations

import asyncio
import collections
import dataclasses
import secrets
import threading
from collections.abc import Coroutine
from typing import Any

import numpy as np
import numpy.typing as npt

from engram._distribution import install_command
from engram.errors import UnavailableError
from engram.servers import limits
from engram.servers.clients.connection import (
    Connection,
    LostError,
    Question,
    ServerError,
    UnreachableError,
)
from engram.servers.conventions import ACTIONS, LAYOUTS, known, state_of, to_engram
from engram.servers.frames import Frame, FrameHistory, resize
from engram.servers.identity import CHECKPOINT, identity_in
from engram.servers.keys import Keys, keys_of
from engram.servers.options import ServerOptions

__all__ = ["ServerError", "ServerPolicy"]

Array = npt.NDArray[Any]


def _connection_class(protocol: str) -> type[Connection]:
    try:
        if protocol == "gr00t":
            from engram.servers.clients.gr00t import Gr00tConnection

            return Gr00tConnection
        if protocol == "act":
            from engram.servers.clients.act import ActConnection

            return ActConnection
        from engram.servers.clients import sockets
    except ModuleNotFoundError as error:
        raise UnavailableError(
            f"policy servers: {error}; `{install_command('servers')}` installs what they need"
        ) from None
    return sockets.OpenpiConnection if protocol == "openpi" else sockets.VlaEvalConnection


@dataclasses.dataclass
class _Slot:
    """An episode in progress."""

    session: str  # name that no other client has
    history: FrameHistory[Frame]
    connection: Connection | None = None
    queue: collections.deque[Array] = dataclasses.field(default_factory=collections.deque)
    answers: int = 0  # of this episode


class ServerPolicy:
    """Asks a server for the actions of episodes, each over a connection of its own.

    Args:
        url: openpi://, gr00t://, act:// or vla-eval://HOST:PORT; a query may have the options.
        action_dim: Numbers of an action.
        timeout: Seconds for every answer.
        **options: keys, state, actions, image, replan, history, reset, wait; see
            docs/policy_servers.md.

    With ``history="last"`` it answers with whole chunks and sees the frames in which one is needed.
    With others it has to be called in every step, answers with one action, and asks the server when
    those of the last chunk are used up. Threads may call it at the same time.
    """

    def __init__(
        self, url: str, *, action_dim: int = 7, timeout: float = 300.0, **options: Any
    ) -> None:
        self.options = ServerOptions.parse(url, timeout, **options)
        self._class = _connection_class(self.options.protocol)
        self.keys = _completed(keys_of(self.options.protocol, self.options.keys), self.options)
        if self.keys.flat and "reset" not in self.options.given:
            self.options = dataclasses.replace(self.options, reset="none")
        self._dim = action_dim
        self._slots: dict[tuple[int, int], _Slot] = {}
        self._token = secrets.token_hex(8)
        self._lock = threading.Lock()
        self._loop: asyncio.AbstractEventLoop | None = None
        self.config = {"server": self.options.url, **self.options.given}
        self.identity: dict[str, Any] = {}  # what the server has told of itself

    def __call__(self, observation: dict[str, Any]) -> list[Array]:
        """Chunks of actions, (K, action_dim) each. Observations are those of engram.evaluate."""
        count = len(observation["instruction"])
        slots = [self._slot_of(observation, row) for row in range(count)]
        asked = []
        for row, slot in enumerate(slots):
            slot.history.add(self._frame(slot.history.last, observation, row))
            if not slot.queue:
                asked.append(self._ask(slot, observation, row))
        if asked:
            self._run(_all(asked))
        answer = []
        for slot in slots:
            count = len(slot.queue) if self.options.history.is_last else 1
            answer.append(np.stack([slot.queue.popleft() for _ in range(count)]))
        return answer

    def close(self) -> None:
        """Ends all connections."""
        if self._loop is None:
            return
        self._run(self._close_all())
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._loop = None

    # --- episodes ---

    def _slot_of(self, observation: dict[str, Any], row: int) -> _Slot:
        """The episode of a row; a new one begins without frames and without actions."""
        name = int(observation["worker"]), int(observation["slot"][row])
        with self._lock:
            old = self._slots.get(name)
            if old is not None and not observation["first"][row]:
                return old
            session = old.session if old is not None else f"{self._token}-{len(self._slots)}"
            connection = old.connection if old is not None else None
            slot = _Slot(session, FrameHistory(self.options.history), connection)
            self._slots[name] = slot
            return slot

    async def _ask(self, slot: _Slot, observation: dict[str, Any], row: int) -> None:
        """Fills the queue of an episode."""
        try:
            chunk = await self._answered(slot, self._question(slot, observation, row))
        except BaseException:
            if slot.connection is not None:
                await slot.connection.close()
                slot.connection = None
            raise
        slot.answers += 1
        used = self.options.replan or len(chunk)
        if len(chunk) < used:
            raise ServerError(
                f"policy server {self.options.url} answered with {len(chunk)} actions; --replan "
                f"{used} needs as many"
            )
        slot.queue.extend(chunk[:used])

    async def _answered(self, slot: _Slot, question: _Draft) -> Array:
        """The server's actions.

        Over a new connection if the old one is lost and the server need remember nothing.
        """
        try:
            return await self._within(self._exchange(slot, question))
        except LostError as error:
            if slot.answers and self.options.reset != "none":
                raise ServerError(
                    f"{error}; it may have forgotten the first {slot.answers} questions of this "
                    "episode (--server-reset none: it remembers nothing, so that another "
                    "connection will do)"
                ) from None
        if slot.connection is not None:
            await slot.connection.close()
            slot.connection = None
        try:
            return await self._within(self._exchange(slot, question))
        except UnreachableError as error:
            which = "a" if slot.answers else "the first"
            raise ServerError(
                f"{error}; it was there, and closed the connection after {which} question"
            ) from None

    async def _exchange(self, slot: _Slot, question: _Draft) -> Array:
        begins = slot.answers == 0
        old = slot.connection
        if old is not None and begins and self.options.reset == "reconnect":
            await old.finish()
            slot.connection = None
        if slot.connection is None:
            if slot.answers and self.options.reset != "none":
                raise LostError(f"policy server {self.options.url} was left in this episode")
            slot.connection = self._class(self.options, self.keys, slot.session)
            await slot.connection.open()
            self._identify(slot.connection)
        connection = slot.connection
        if begins:
            await connection.begin(question.env_id)
        answer = await connection.ask(question.finished(self._size(connection, question.frames)))
        actions = connection.chunk(answer, self._dim)
        return to_engram(self.keys.convention, actions).astype(np.float32)

    def _identify(self, connection: Connection) -> None:
        """Keeps what the server tells of itself, and refuses another checkpoint than before."""
        told = identity_in(connection.metadata)
        before, now = self.identity.get(CHECKPOINT), told.get(CHECKPOINT)
        if before is not None and now is not None and before != now:
            raise connection.fail(f"tells checkpoint {now!r:.100}, and told {before!r:.100} before")
        self.identity = self.identity or told

    async def _within(self, exchange: Coroutine[Any, Any, Array]) -> Array:
        try:
            return await asyncio.wait_for(exchange, self.options.timeout)
        except asyncio.TimeoutError:
            raise ServerError(
                f"policy server {self.options.url} has not answered within "
                f"{self.options.timeout:g} s"
            ) from None

    # --- questions ---

    def _frame(self, last: Frame | None, observation: dict[str, Any], row: int) -> Frame:
        rgb, numbers = observation["rgb"], observation["state"]
        state = None
        if self.keys.state:
            before = None if last is None else last.state
            state = state_of(self.keys.layout, observation["proprio"][row], before)
        return Frame(
            None if rgb is None else rgb[row], state, None if numbers is None else numbers[row]
        )

    def _size(self, connection: Connection, frames: list[Frame]) -> tuple[int, int] | None:
        if self.options.image == "native":
            return None
        if isinstance(self.options.image, tuple):
            return self.options.image
        if connection.size is None or frames[0].rgb is None:
            return self.keys.size
        height, width = connection.size
        count = len(frames) * height * width * frames[0].rgb.shape[-1]
        if count > limits.QUESTION:
            raise connection.fail(
                f"asks for images of {height} x {width}, with a history of {len(frames)} frames "
                f"{count >> 20} MiB; {limits.QUESTION >> 20} allowed, --server-image chooses "
                "another size"
            )
        return connection.size

    def _question(self, slot: _Slot, observation: dict[str, Any], row: int) -> _Draft:
        frames = slot.history.take()
        return _Draft(
            self.keys,
            frames,
            not self.options.history.is_last,
            observation["instruction"][row],
            observation["env_id"],
            _episode_facts(observation, row),
        )

    # --- the loop, which answers the server's pings while the simulator works ---

    def _run(self, work: Coroutine[Any, Any, None]) -> None:
        with self._lock:
            if self._loop is None:
                self._loop = asyncio.new_event_loop()
                threading.Thread(target=_run_loop, args=(self._loop,), daemon=True).start()
            loop = self._loop
        asyncio.run_coroutine_threadsafe(work, loop).result()

    async def _close_all(self) -> None:
        for slot in self._slots.values():
            if slot.connection is not None:
                await slot.connection.close()


@dataclasses.dataclass
class _Draft:
    """A question, whose images wait for the size that the server wants."""

    keys: Keys
    frames: list[Frame]
    has_time: bool
    prompt: str
    env_id: str
    episode: dict[str, Any] | None

    def finished(self, size: tuple[int, int] | None) -> Question:
        keys = self.keys
        images, state = {}, {}
        if self.frames[0].rgb is not None:
            views = {keys.base: slice(0, 3), keys.wrist: slice(3, 6)}
            for name, channels in views.items():
                if name is not None:
                    views_of = [resize(f.rgb[..., channels], size) for f in self.frames]  # type: ignore[index]
                    images[name] = self._over_time(views_of)
        if keys.row is not None and self.frames[0].row is not None:
            state[keys.row] = self._over_time([f.row for f in self.frames])
        if keys.state:
            whole = self._over_time([f.state for f in self.frames])
            for name, (start, stop) in keys.state.items():
                state[name] = whole[..., start:stop]
        return Question(images, state, self.prompt, self.has_time, self.env_id, self.episode)

    def _over_time(self, values: list[Any]) -> Array:
        return np.stack(values) if self.has_time else values[-1]


def _run_loop(loop: asyncio.AbstractEventLoop) -> None:
    try:
        loop.run_forever()
    finally:
        loop.close()


async def _all(work: list[Coroutine[Any, Any, None]]) -> None:
    """Waits for all; the first failure ends the others."""
    tasks = [asyncio.ensure_future(one) for one in work]
    try:
        await asyncio.gather(*tasks)
    finally:
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)


def _episode_facts(observation: dict[str, Any], row: int) -> dict[str, Any] | None:
    if observation.get("seed") is None:
        return None
    return {
        "env_id": observation["env_id"],
        "seed": int(observation["seed"][row]),
        "episode": int(observation["episode"][row]),
        "step": int(observation["step"][row]),
        "proprio": np.asarray(observation["proprio"][row], np.float32),
    }


def _completed(keys: Keys, options: ServerOptions) -> Keys:
    """The keys with the layout and the convention that were asked for."""
    layout, convention = options.state or keys.layout, options.actions or keys.convention
    known("state", layout, LAYOUTS)
    known("actions", convention, ACTIONS)
    state = keys.state
    if options.state and len(state) == 1:  # one array takes any layout
        width = 7 if layout == "tcp7" else 8
        state = dict.fromkeys(state, (0, width))
    return dataclasses.replace(keys, layout=layout, convention=convention, state=state)
