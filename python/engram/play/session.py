"""The conversation with one page: what it asks for is done here, in the order of its messages."""

from __future__ import annotations

import asyncio
import concurrent.futures
import dataclasses
import sys
import time
import traceback
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any, TypeVar

import engram
from engram.datasets.checks import DatasetError
from engram.play.catalogue import Catalogue
from engram.play.playback import Film, recorded
from engram.play.game import VIEWS, Game
from engram.play.saving import KeepError, keep
from engram.play.messages import MessageError
from engram.play.policy_process import PolicyError
from engram.play.score import Scores
from engram.play.episode_spec import Setting
from engram.play.sources import SourceError, Sources
from engram.play.grid_view import COLUMNS, ENVS, Wall

T = TypeVar("T")
CONTROL_STEP = 0.05  # seconds
_MOST_UNSEEN = 3  # pictures on their way; a page that is slower gets fewer
_LATE = 0.25  # seconds behind after which lost time is let go
_SLOW = 0.8 * CONTROL_STEP  # a step that takes longer than this leaves no time to spare
_SLOW_STEPS = 10
_TOLD = (
    engram.Error, DatasetError, KeepError, MessageError, PolicyError, SourceError, OSError,
)  # fmt: skip


@dataclasses.dataclass
class House:
    """What outlives a page."""

    out: Path
    catalogue: Catalogue
    sources: Sources
    scores: Scores
    # All that simulates runs in one thread, so that messages are read and sent meanwhile.
    engine: concurrent.futures.Executor


class Channel:
    """Sends to the page."""

    def __init__(
        self,
        text: Callable[[dict[str, Any]], Awaitable[None]],
        binary: Callable[[bytes], Awaitable[None]],
    ) -> None:
        self.text = text
        self.binary = binary


class Session:
    """One page's game, film or wall; never more than one of them at a time."""

    def __init__(self, house: House, channel: Channel) -> None:
        self._house = house
        self._channel = channel
        self._lock = asyncio.Lock()  # of what is on show
        self._stage: Game | Film | Wall | None = None
        self._played: Game | None = None  # whose last episode may be kept
        self._clock: asyncio.Task[None] | None = None
        self._wake = asyncio.Event()
        self._running = False
        self._turns = False  # time passes only while the player acts
        self._speed = 1.0
        self._action = [0.0] * 6 + [1.0]
        self._held = False
        self._input = 0
        self._sent = 0
        self._seen = 0
        self._slow = 0
        self._size = 0  # of the human view, once a machine has turned out to be slow

    async def begin(self) -> None:
        """Greets the page."""
        await self._channel.text(
            {
                "type": "hello",
                "version": engram.__version__,
                "out": str(self._house.out),
                "envs": ENVS,
                "columns": COLUMNS,
                **self._house.sources.told(),
            }
        )

    async def handle(self, message: dict[str, Any]) -> None:
        """Does what a checked message asks for; what cannot be done is told."""
        kind = message["do"]
        if kind == "act":
            self._take_action(message)
            return
        if kind == "seen":
            self._seen += 1
            return
        try:
            async with self._lock:
                await _HANDLERS[kind](self, message)
        except _TOLD as error:
            if isinstance(error, PolicyError):
                await self._work(self._house.sources.lost)
            await self._tell(str(error))
        except Exception:
            traceback.print_exc(file=sys.stderr)
            await self._tell("something went wrong; the terminal says what")

    async def close(self) -> None:
        """Ends everything that this page has begun."""
        if self._clock is not None:
            self._clock.cancel()
            await asyncio.gather(self._clock, return_exceptions=True)
        async with self._lock:
            await self._clear()

    # --- playing ---

    async def _play(self, message: dict[str, Any]) -> None:
        setting = self._setting(message)
        game = await self._game(setting)
        self._played = game
        self._action = [0.0] * 6 + self._action[6:]
        await self._channel.text(
            {
                "type": "opened",
                "id": setting.id,
                "instruction": game.instruction,
                "horizon": game.description["horizon"],
                # A seed that was drawn is told at the end: it could be looked up.
                "seed": str(setting.seed) if setting.seed_given else None,
                "view": list(VIEWS[game.size]),
                "score": self._house.scores.of(game.description),
            }
        )
        await self._show()

    async def _game(self, setting: Setting) -> Game:
        """A game at the beginning of the episode; the last one, where it is of the same kind."""
        size, game = self._size, self._stage
        if isinstance(game, Game) and game.setting.kind == setting.kind:
            self._pause()
            old = game
            await self._work(lambda: old.start(setting))
        else:
            await self._clear()
            self._stage = game = await self._work(lambda: Game(setting))
        new = game
        await self._work(lambda: new.resize(size))
        return new

    def _take_action(self, message: dict[str, Any]) -> None:
        self._action = message["a"]
        self._held = message["held"]
        self._input = message["n"]
        if self._held and self._turns:
            self._wake.set()

    async def _step(self, message: dict[str, Any]) -> None:
        if not isinstance(self._stage, Game):
            raise MessageError("step: there is nothing to play; play first")
        if self._running:
            raise MessageError("step: the episode runs; pause first")
        self._action = message["a"]
        self._input = message["n"]
        await self._advance()

    async def _run(self, message: dict[str, Any]) -> None:
        if not isinstance(self._stage, (Game, Wall)):
            raise MessageError("run: there is nothing to run; play first")
        self._running = message["on"]
        self._seen = self._sent
        self._wake.set()
        if self._clock is None:
            self._clock = asyncio.create_task(self._tick())
        await self._channel.text({"type": "running", "on": self._running})

    async def _set_speed(self, message: dict[str, Any]) -> None:
        self._speed = message["of"]
        self._turns = message["turns"]
        self._wake.set()

    def _pause(self) -> None:
        self._running = False

    @property
    def _waits(self) -> bool:
        """Whether time stands still."""
        if isinstance(self._stage, Game) and self._turns and not self._held:
            return True
        return not self._running

    async def _tick(self) -> None:
        loop = asyncio.get_running_loop()
        due = loop.time()
        while True:
            if self._waits:
                self._wake.clear()
                await self._wake.wait()
                due = loop.time()
                continue
            due += CONTROL_STEP / self._speed
            if due < loop.time() - _LATE:
                due = loop.time()
            await asyncio.sleep(due - loop.time())
            try:
                async with self._lock:
                    if not self._waits:
                        await self._advance()
            except ConnectionError:
                return
            except _TOLD as error:
                self._pause()
                await self._tell(str(error))
            except Exception:
                self._pause()
                traceback.print_exc(file=sys.stderr)
                await self._tell("something went wrong; the terminal says what")

    async def _advance(self) -> None:
        """One step of what is on show, and its picture unless the page lags behind."""
        stage = self._stage
        lags = self._running and self._sent - self._seen >= _MOST_UNSEEN
        if isinstance(stage, Wall):
            await self._work(stage.step)
            if not lags:
                self._sent += 1
                await self._channel.binary(await self._work(stage.picture))
        elif isinstance(stage, Game) and not stage.ended:
            action, number = self._action, self._input
            began = time.perf_counter()
            picture = await self._work(lambda: _stepped(stage, action, number, lags))
            await self._watch_speed(stage, time.perf_counter() - began)
            if picture is not None:
                self._sent += 1
                await self._channel.binary(picture)
            if stage.ended:
                await self._end(stage)

    async def _end(self, game: Game) -> None:
        self._pause()
        setting, result = game.setting, game.result()
        counted = setting.plain and self._house.scores.add(
            setting.id, setting.seed, result["success"], result["first_answer_correct"]
        )
        await self._channel.text(
            {
                "type": "ended",
                **result,
                "counted": counted,
                "keepable": result["success"] and setting.plain,
                "score": self._house.scores.of(game.description),
            }
        )

    async def _watch_speed(self, game: Game, seconds: float) -> None:
        """Draws smaller pictures where large ones take too long."""
        self._slow = self._slow + 1 if seconds > _SLOW else max(0, self._slow - 1)
        if self._slow >= _SLOW_STEPS and self._size + 1 < len(VIEWS):
            self._slow = 0
            self._size += 1
            await self._work(lambda: game.resize(self._size))

    async def _show(self) -> None:
        game = self._stage
        assert isinstance(game, Game)
        number = self._input
        self._sent += 1
        await self._channel.binary(await self._work(lambda: game.picture(number)))

    async def _save(self, _message: dict[str, Any]) -> None:
        game = self._ended_game("save")
        if not game.setting.plain:
            raise KeepError(
                "the episode had pins, constants or options of its own; seed and actions alone do "
                "not make it again"
            )
        out, setting, actions = self._house.out, game.setting, list(game.actions)
        file, episodes = await self._work(lambda: keep(out, setting.id, setting.seed, actions))
        await self._channel.text({"type": "saved", "file": str(file), "episodes": episodes})

    def _ended_game(self, what: str) -> Game:
        if self._played is None or not self._played.ended:
            raise MessageError(f"{what}: there is no episode that has been played to its end")
        return self._played

    # --- watching ---

    async def _review(self, _message: dict[str, Any]) -> None:
        game = self._ended_game("review")
        setting, actions = game.setting, list(game.actions)
        await self._open_film(
            lambda: Film(setting, recorded(actions), ends_at_success=True, most_steps=len(actions)),
        )

    async def _watch(self, message: dict[str, Any]) -> None:
        setting, name = self._setting(message), message["source"]

        def make() -> Film:
            player, obs = self._house.sources.player(name)
            return Film(setting, player, obs_mode=obs)

        await self._open_film(make)

    async def _stored(self, message: dict[str, Any]) -> None:
        numbers = (message["folder"], message["task"], message["episode"])
        await self._open_film(lambda: self._house.sources.stored(*numbers))

    async def _open_film(self, make: Callable[[], Film]) -> None:
        self._pause()
        film = await self._work(make)
        await self._clear()
        self._stage = film
        await self._channel.text(film.told())

    async def _frame(self, message: dict[str, Any]) -> None:
        film, frame = self._stage, message["n"]
        if not isinstance(film, Film):
            raise MessageError("frame: there is no film; watch first")
        if frame >= len(film):
            raise MessageError(f"frame: {frame} given; 0 to {len(film) - 1} allowed")
        await self._channel.binary(await self._work(lambda: film.picture(frame)))

    async def _wall(self, message: dict[str, Any]) -> None:
        setting, name = self._setting(message), message["source"]
        await self._clear()

        def make() -> Wall:
            player, obs = self._house.sources.player(name)
            return Wall(setting, player, obs)

        wall = await self._work(make)
        self._stage = wall
        await self._channel.text({"type": "wall", "id": setting.id, "source": name})
        self._sent += 1
        await self._channel.binary(await self._work(wall.picture))

    async def _leave(self, _message: dict[str, Any]) -> None:
        await self._clear()

    # --- inside ---

    def _setting(self, message: dict[str, Any]) -> Setting:
        setting = Setting.of(message)
        if setting.id not in self._house.catalogue:
            raise MessageError(f"id: '{setting.id}' given, which is no task")
        return setting

    async def _clear(self) -> None:
        """Takes away what is on show."""
        self._pause()
        stage, self._stage = self._stage, None
        if stage is not None:
            await self._work(stage.close)

    async def _work(self, call: Callable[[], T]) -> T:
        return await asyncio.get_running_loop().run_in_executor(self._house.engine, call)

    async def _tell(self, message: str) -> None:
        await self._channel.text({"type": "error", "message": message[:600]})


def _stepped(game: Game, action: list[float], number: int, lags: bool) -> bytes | None:
    game.step(action)
    return None if lags and not game.ended else game.picture(number)


_HANDLERS: dict[str, Callable[[Session, dict[str, Any]], Awaitable[None]]] = {
    "play": Session._play,
    "step": Session._step,
    "run": Session._run,
    "speed": Session._set_speed,
    "save": Session._save,
    "review": Session._review,
    "watch": Session._watch,
    "stored": Session._stored,
    "frame": Session._frame,
    "wall": Session._wall,
    "leave": Session._leave,
}
