"""Session of one page: handles its messages, one at a time and in their order."""

from __future__ import annotations

import asyncio
import concurrent.futures
import contextlib
import dataclasses
import sys
import time
import traceback
from collections.abc import Awaitable, Callable, Mapping
from pathlib import Path
from typing import Any, TypeVar

import engram
from engram.datasets.checks import DatasetError, printable
from engram.play.catalogue import Catalogue
from engram.play.episode_spec import EpisodeSpec
from engram.play.folders import SourceError
from engram.play.game import VIEWS, Game
from engram.play.grid_view import COLUMNS, ENVS, GridView
from engram.play.messages import MessageError
from engram.play.playback import Playback, recorded_policy
from engram.play.policy_process import PolicyError
from engram.play.saving import SaveError, save
from engram.play.score import Scores
from engram.play.sources import Sources

T = TypeVar("T")
CONTROL_STEP = 0.05  # seconds
_MOST_UNSEEN = 3  # pictures that are not acknowledged; a slower page gets fewer
_LATE = 0.25  # seconds of delay that are not caught up
_SLOW = 0.8 * CONTROL_STEP  # seconds of a step from which on it counts as slow
_SLOW_STEPS = 10
_SHARE = 0.05  # seconds for which an episode in the background has the engine
_PROGRESS = 0.3  # seconds between messages about it
# Messages after which an episode in the background is no longer wanted.
_LEAVING = ("play", "review", "watch", "stored", "grid", "leave", "stop")
REPORTED_ERRORS = (
    engram.Error, DatasetError, SaveError, MessageError, PolicyError, SourceError, OSError,
)  # fmt: skip


@dataclasses.dataclass
class ServerContext:
    """State that all sessions share."""

    out: Path
    catalogue: Catalogue
    sources: Sources
    scores: Scores
    # One thread for the simulation, while messages are read and sent.
    engine: concurrent.futures.Executor
    perturb: Mapping[str, float]  # of every episode that is begun
    physics: str = "engram"  # likewise
    choices: bool = False  # the page begins with answers by name
    task: str | None = None  # the page begins with this id


class Channel:
    """Functions that send to the page."""

    def __init__(
        self,
        text: Callable[[dict[str, Any]], Awaitable[None]],
        binary: Callable[[bytes], Awaitable[None]],
    ) -> None:
        self.text = text
        self.binary = binary


class Session:
    """One page's game, playback or grid, one of them at a time."""

    def __init__(self, context: ServerContext, channel: Channel) -> None:
        self._context = context
        self._channel = channel
        self._lock = asyncio.Lock()  # of the view
        self._view: Game | Playback | GridView | None = None
        self._played: Game | None = None  # its last episode may be saved
        self._clock: asyncio.Task[None] | None = None
        self._wake = asyncio.Event()
        self._running = False
        self._asking = False  # time stands still until the page has answered a question
        self._turns = False  # True: time passes only while the player acts
        self._speed = 1.0
        self._action = [0.0] * 6 + [1.0]
        self._held = False
        self._input = 0
        self._sent = 0
        self._seen = 0
        self._slow = 0
        self._size = 0  # of the human view; larger on slow machines
        self._building: asyncio.Task[None] | None = None  # of an episode to watch
        self._abandoned = False

    async def begin(self) -> None:
        """Sends the page its first message."""
        await self._channel.text(
            {
                "type": "hello",
                "version": engram.__version__,
                "out": str(self._context.out),
                "envs": ENVS,
                "columns": COLUMNS,
                "choices": self._context.choices,
                "task": self._context.task,
                **self._context.sources.message(),
            }
        )

    async def handle(self, message: dict[str, Any]) -> None:
        """Handles a checked message; failures are sent to the page."""
        kind = message["do"]
        if self._abandoned:
            return
        if kind == "act":
            self._take_action(message)
            return
        if kind == "seen":
            self._seen += 1
            return
        if kind in _LEAVING:
            self._stop_work()
        try:
            async with self._lock:
                await _HANDLERS[kind](self, message)
        except Exception as error:
            await self._report(error)

    async def _report(self, error: Exception) -> None:
        if isinstance(error, ConnectionError):
            raise error  # the page was closed
        if isinstance(error, REPORTED_ERRORS):
            await self._send_error(str(error))
        else:
            traceback.print_exception(error, file=sys.stderr)
            await self._send_error("internal error; the terminal has the details")

    def abandon(self) -> None:
        """Another page plays now: nothing more is done for this one."""
        self._abandoned = True
        self._pause()
        self._stop_work()

    def _stop_work(self) -> None:
        """What takes long is no longer wanted."""
        if self._building is not None:
            self._building.cancel()
            self._building = None
        self._context.sources.shorten_deadline()

    async def close(self) -> None:
        """Ends the clock and the view of this page."""
        self.abandon()
        if self._clock is not None:
            self._clock.cancel()
            await asyncio.gather(self._clock, return_exceptions=True)
        async with self._lock:
            await self._close_view()

    # --- playing ---

    async def _play(self, message: dict[str, Any]) -> None:
        spec = self._episode_spec(message)
        game = await self._game(spec)
        self._played = game
        self._asking = False
        self._action = [0.0] * 6 + self._action[6:]
        await self._channel.text(
            {
                "type": "opened",
                "id": spec.id,
                "instruction": game.instruction,
                "horizon": game.description["horizon"],
                # A random seed is sent at the end only: its answer could be looked up.
                "seed": str(spec.seed) if spec.seed_given else None,
                "view": list(VIEWS[game.size]),
                "score": self._context.scores.of(game.description, spec.choices),
            }
        )
        await self._show()
        await self._ask(game)

    async def _game(self, spec: EpisodeSpec) -> Game:
        """A game at the beginning of the episode; the last one if its batch can play it."""
        size, game = self._size, self._view
        if isinstance(game, Game) and game.spec.batch_key == spec.batch_key:
            self._pause()
            old = game
            await self._run_in_engine(lambda: old.start(spec))
        else:
            game = await self._run_in_engine(lambda: Game(spec))
            await self._close_view()
            self._view = game
        new = game
        await self._run_in_engine(lambda: new.resize(size))
        return new

    async def _ask(self, game: Game) -> None:
        """Sends the question that is due, if there is one."""
        question = await self._run_in_engine(game.question)
        self._asking = question is not None
        if question is not None:
            await self._channel.text({"type": "question", **question})

    async def _choose(self, message: dict[str, Any]) -> None:
        game = self._view
        if not isinstance(game, Game) or not self._asking:
            raise MessageError("choose: there is no question")
        await self._run_in_engine(lambda: game.choose(message["choices"]))
        await self._channel.text({"type": "chosen"})
        await self._ask(game)
        self._wake.set()

    def _take_action(self, message: dict[str, Any]) -> None:
        self._action = message["a"]
        self._held = message["held"]
        self._input = message["n"]
        if self._held and self._turns:
            self._wake.set()

    async def _step(self, message: dict[str, Any]) -> None:
        if not isinstance(self._view, Game):
            raise MessageError("step: there is no episode; play first")
        if self._running:
            raise MessageError("step: the episode runs; pause first")
        if self._asking:
            raise MessageError("step: a question is open; choose first")
        self._action = message["a"]
        self._input = message["n"]
        await self._advance()

    async def _run(self, message: dict[str, Any]) -> None:
        if not isinstance(self._view, (Game, GridView)):
            raise MessageError("run: there is no episode; play first")
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
    def _is_waiting(self) -> bool:
        """True while time stands still."""
        if self._asking:
            return True
        if isinstance(self._view, Game) and self._turns and not self._held:
            return True
        return not self._running

    async def _tick(self) -> None:
        loop = asyncio.get_running_loop()
        due = loop.time()
        while True:
            if self._is_waiting:
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
                    if not self._is_waiting:
                        await self._advance()
            except ConnectionError:
                return
            except Exception as error:
                self._pause()
                with contextlib.suppress(ConnectionError):
                    await self._channel.text({"type": "running", "on": False})
                    await self._report(error)

    async def _advance(self) -> None:
        """One step of the view, and its picture unless the page lags behind."""
        view = self._view
        lags = self._running and self._sent - self._seen >= _MOST_UNSEEN
        if isinstance(view, GridView):
            await self._run_in_engine(view.step)
            if not lags:
                self._sent += 1
                await self._channel.binary(await self._run_in_engine(view.picture))
        elif isinstance(view, Game) and not view.ended:
            action, number = self._action, self._input
            began = time.perf_counter()
            picture = await self._run_in_engine(lambda: _stepped(view, action, number, lags))
            await self._adapt_size(view, time.perf_counter() - began)
            if picture is not None:
                self._sent += 1
                await self._channel.binary(picture)
            if view.ended:
                await self._end(view)
            else:
                await self._ask(view)

    async def _end(self, game: Game) -> None:
        self._pause()
        spec, result = game.spec, game.result()
        counted = spec.is_default and self._context.scores.add(
            spec.id, spec.seed, result["success"], result["first_answer_correct"], spec.choices
        )
        await self._channel.text(
            {
                "type": "ended",
                **result,
                "counted": counted,
                "savable": result["success"] and spec.is_default,
                "score": self._context.scores.of(game.description, spec.choices),
            }
        )

    async def _adapt_size(self, game: Game, seconds: float) -> None:
        """Switches to smaller pictures when large ones take too long."""
        self._slow = self._slow + 1 if seconds > _SLOW else max(0, self._slow - 1)
        if self._slow >= _SLOW_STEPS and self._size + 1 < len(VIEWS):
            self._slow = 0
            self._size += 1
            await self._run_in_engine(lambda: game.resize(self._size))

    async def _show(self) -> None:
        game = self._view
        assert isinstance(game, Game)
        number = self._input
        self._sent += 1
        await self._channel.binary(await self._run_in_engine(lambda: game.picture(number)))

    async def _save(self, _message: dict[str, Any]) -> None:
        game = self._ended_game("save")
        if not game.spec.is_default:
            raise SaveError(
                "the episode had pins, constants, options or another physics; seed and actions "
                "alone do not reproduce it"
            )
        out, spec, actions = self._context.out, game.spec, list(game.actions)
        file, episodes = await self._run_in_engine(lambda: save(out, spec.id, spec.seed, actions))
        await self._channel.text({"type": "saved", "file": str(file), "episodes": episodes})

    def _ended_game(self, what: str) -> Game:
        if self._played is None or not self._played.ended:
            raise MessageError(f"{what}: there is no finished episode")
        return self._played

    # --- watching ---

    async def _review(self, _message: dict[str, Any]) -> None:
        game = self._ended_game("review")
        spec, actions = game.spec, list(game.actions)
        await self._build(
            lambda: Playback(
                spec, recorded_policy(actions), ends_at_success=True, most_steps=len(actions)
            ),
        )

    async def _watch(self, message: dict[str, Any]) -> None:
        spec, name = self._episode_spec(message), message["source"]
        policy, obs = self._context.sources.policy(name)
        await self._build(lambda: Playback(spec, policy, obs_mode=obs))

    async def _stored(self, message: dict[str, Any]) -> None:
        numbers = (message["folder"], message["task"], message["episode"])
        # A thread of its own: the file may be large.
        recording = await asyncio.to_thread(self._context.sources.recording, *numbers)
        await self._build(
            lambda: Playback(
                recording.spec,
                recording.policy,
                obs_mode=recording.obs_mode,
                most_steps=recording.most_steps,
                recorded=(recording.success, recording.steps),
            )
        )

    async def _build(self, make: Callable[[], Playback]) -> None:
        """Plays an episode in the background; then its view is opened."""
        self._pause()
        playback = await self._run_in_engine(make)
        self._building = asyncio.create_task(self._play_back(playback))

    async def _play_back(self, playback: Playback) -> None:
        shown = False
        try:
            reported = time.monotonic()
            while not await self._run_in_engine(lambda: playback.run(_SHARE)):
                if time.monotonic() - reported >= _PROGRESS:
                    reported = time.monotonic()
                    steps, most = len(playback) - 1, playback.steps
                    await self._channel.text({"type": "building", "steps": steps, "most": most})
            message = await self._run_in_engine(playback.message)
            async with self._lock:
                self._building = None
                await self._close_view()
                self._view, shown = playback, True
                await self._channel.text(message)
        except ConnectionError:
            pass  # the page was closed
        except Exception as error:
            self._building = None
            with contextlib.suppress(ConnectionError):
                await self._report(error)
        finally:
            if not shown:  # behind the last share of it, in the same thread
                with contextlib.suppress(RuntimeError):  # of an executor that is shut down
                    self._context.engine.submit(playback.close)

    async def _frame(self, message: dict[str, Any]) -> None:
        playback, frame = self._view, message["n"]
        if not isinstance(playback, Playback):
            raise MessageError("frame: there is no playback; watch first")
        if frame >= len(playback):
            raise MessageError(f"frame: {frame} given; 0 to {len(playback) - 1} allowed")
        await self._channel.binary(await self._run_in_engine(lambda: playback.picture(frame)))

    async def _grid(self, message: dict[str, Any]) -> None:
        spec, name = self._episode_spec(message), message["source"]
        policy, obs = self._context.sources.policy(name)
        grid = await self._run_in_engine(lambda: GridView(spec, policy, obs))
        await self._close_view()
        self._view = grid
        await self._channel.text({"type": "grid", "id": spec.id, "source": name})
        self._sent += 1
        await self._channel.binary(await self._run_in_engine(grid.picture))

    async def _leave(self, _message: dict[str, Any]) -> None:
        await self._close_view()

    async def _stop(self, _message: dict[str, Any]) -> None:
        pass  # what is played in the background has been given up

    # --- internals ---

    def _episode_spec(self, message: dict[str, Any]) -> EpisodeSpec:
        context = self._context
        spec = dataclasses.replace(
            EpisodeSpec.from_message(message), perturb=context.perturb, physics=context.physics
        )
        if spec.id not in self._context.catalogue:
            raise MessageError(f"id: '{spec.id}' given, which is no task")
        return spec

    async def _close_view(self) -> None:
        """Closes the view."""
        self._pause()
        self._asking = False
        view, self._view = self._view, None
        if view is not None:
            await self._run_in_engine(view.close)

    async def _run_in_engine(self, call: Callable[[], T]) -> T:
        return await asyncio.get_running_loop().run_in_executor(self._context.engine, call)

    async def _send_error(self, message: str) -> None:
        await self._channel.text({"type": "error", "message": printable(message)})


def _stepped(game: Game, action: list[float], number: int, lags: bool) -> bytes | None:
    game.step(action)
    return None if lags and not game.ended else game.picture(number)


_HANDLERS: dict[str, Callable[[Session, dict[str, Any]], Awaitable[None]]] = {
    "play": Session._play,
    "choose": Session._choose,
    "step": Session._step,
    "run": Session._run,
    "speed": Session._set_speed,
    "save": Session._save,
    "review": Session._review,
    "watch": Session._watch,
    "stored": Session._stored,
    "frame": Session._frame,
    "grid": Session._grid,
    "leave": Session._leave,
    "stop": Session._stop,
}
