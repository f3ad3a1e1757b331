"""HTTP server: one page, one WebSocket, nothing else."""

from __future__ import annotations

import argparse
import asyncio
import concurrent.futures
import contextlib
import json
import signal
import sys
from pathlib import Path
from typing import Any

from aiohttp import WSMsgType, web

from engram.play import messages
from engram.play.browser import Browser
from engram.play.catalogue import Catalogue
from engram.play.connections import Connections
from engram.play.grid_view import ENVS
from engram.play.guard import Guard, new_token
from engram.play.refusals import Refusals
from engram.play.score import Scores
from engram.play.session import Channel, ServerContext, Session
from engram.play.sources import Sources
from engram.play.tabs import Tab, Tabs

_RELOAD_SECONDS = 3.0  # without a page, before the server ends
_HEARTBEAT = 20.0
_TRIES, _PAUSE = 10, 0.05  # before a tab is reported to be a second one
_SHUTDOWN_SECONDS = 3.0  # for unfinished work
_CONTENT_TYPES = {
    ".html": "text/html",
    ".css": "text/css",
    ".js": "text/javascript",
}
_PAGE = Path(__file__).parent / "page"


def serve(options: argparse.Namespace) -> int:
    """Serves the page until it is closed, or Ctrl-C."""
    try:
        return asyncio.run(Server(options).run())
    except KeyboardInterrupt:
        return 130


class Server:
    """Answers requests that the guard allows."""

    def __init__(self, options: argparse.Namespace) -> None:
        self._options = options
        self._token = new_token()
        self._refusals = Refusals()
        self._guard = Guard(options.host, self._token, self._refusals)
        self._connections = Connections(self._refusals)
        self._browser = Browser()
        # All files that are served, read once: no request reaches the file system.
        self._files = {
            file.name: (file.read_bytes(), _CONTENT_TYPES[file.suffix])
            for file in _PAGE.iterdir()
            if file.suffix in _CONTENT_TYPES
        }
        self._engine = concurrent.futures.ThreadPoolExecutor(1, "engram-play")
        self._library = concurrent.futures.ThreadPoolExecutor(1, "engram-choose")
        sources = Sources(
            options.folder,
            options.policy_command,
            options.obs,
            options.policy_timeout,
            ENVS,
        )
        self._context = ServerContext(
            options.out,
            Catalogue(),
            sources,
            Scores(),
            self._engine,
            dict(options.perturb),
            options.physics,
            options.choices,
            options.id,
        )
        self._library.submit(self._context.catalogue.list)  # while the browser starts
        self._tabs = Tabs()
        self._shutdown: asyncio.TimerHandle | None = None
        self._done = asyncio.Event()
        self._code = 0

    async def run(self) -> int:
        """Listens until the page is closed or a signal arrives; returns the exit code."""
        app = web.Application(client_max_size=messages.LARGEST)
        app.router.add_route("*", "/{token:[^/]*}{rest:.*}", self._respond)
        runner = web.AppRunner(
            app,
            access_log=None,
            logger=self._refusals.logger(),
            handle_signals=False,
            shutdown_timeout=1.0,
        )
        await runner.setup()
        loop = asyncio.get_running_loop()
        for number, code in ((signal.SIGINT, 130), (signal.SIGTERM, 143)):
            loop.add_signal_handler(number, self._stop, code)
        try:
            self._open(runner)
            await self._done.wait()
        finally:
            self._browser.close()
            self._context.sources.shorten_deadline(0)
            with contextlib.suppress(asyncio.TimeoutError, ConnectionError):
                await asyncio.wait_for(self._close(runner), _SHUTDOWN_SECONDS)
            self._engine.shutdown(wait=False, cancel_futures=True)
            self._library.shutdown(wait=False, cancel_futures=True)
            self._context.sources.close()
            self._refusals.close()
        return self._code

    def _open(self, runner: web.AppRunner) -> None:
        """Listens, says where, and opens the page."""
        host, port = self._options.host, self._options.port
        assert runner.server is not None  # it is set up
        try:
            address = self._connections.listen(host, port, runner.server)
        except OSError as error:
            where = f"--host {host} --port {port}"
            raise OSError(f"{where}: {error.strerror or error}") from error
        link = self._print_address(address)
        if self._options.no_open:
            return
        try:
            self._browser.open(link)
        except OSError as error:
            print(f"engram play: no browser was opened: {error}", file=sys.stderr)

    async def _close(self, runner: web.AppRunner) -> None:
        await self._connections.close()
        await self._tabs.close()
        await runner.cleanup()

    def _print_address(self, address: Any) -> str:
        host, port = address[0], address[1]
        shown = f"[{host}]" if ":" in host else host
        if host in ("0.0.0.0", "::"):
            shown = "localhost"
        link = f"http://{shown}:{port}/{self._token}/"
        print(f"engram play: {link}\nClose the page or press Ctrl-C to end it.", flush=True)
        if host not in ("127.0.0.1", "::1"):
            print(
                f"engram play: listens at {host}: everybody who learns the address can play, and "
                "it is sent unencrypted",
                file=sys.stderr,
            )
        return link

    def _stop(self, code: int) -> None:
        self._code = code
        self._done.set()

    # --- requests ---

    async def _respond(self, request: web.Request) -> web.StreamResponse:
        self._guard.check(request)
        self._connections.recognize(request.transport)
        if request.method not in ("GET", "HEAD"):
            self._refusals.add("method")
            raise web.HTTPMethodNotAllowed(request.method, ["GET", "HEAD"])
        path = request.match_info["rest"]
        if path == "/socket":
            return await self._serve_socket(request)
        if path == "":
            raise web.HTTPMovedPermanently(f"/{self._token}/")
        body, kind = await self._content(path.removeprefix("/"))
        headers = {**_HEADERS, "Content-Security-Policy": _policy(request.host)}
        charset = "utf-8" if kind.startswith("text/") else None
        return web.Response(body=body, content_type=kind, charset=charset, headers=headers)

    async def _content(self, path: str) -> tuple[bytes, str]:
        if path in ("", *self._files):
            return self._files[path or "index.html"]
        json_kind = "application/json"
        loop = asyncio.get_running_loop()
        catalogue = self._context.catalogue
        if path == "tasks.json":
            tasks = await loop.run_in_executor(self._library, catalogue.list)
            return _json(tasks), json_kind
        if path == "refused.json":
            return _json(dict(self._refusals.counts)), json_kind
        folder, _, name = path.partition("/")
        id, _, suffix = name.rpartition(".")
        if id in catalogue and (folder, suffix) in (("task", "json"), ("picture", "jpg")):
            query = catalogue.described if folder == "task" else catalogue.picture
            found: Any = await loop.run_in_executor(self._library, query, id)
            return (_json(found), json_kind) if folder == "task" else (found, "image/jpeg")
        self._refusals.add("path")
        raise web.HTTPNotFound(text="no such page\n", headers=_HEADERS)

    # --- the page ---

    async def _serve_socket(self, request: web.Request) -> web.WebSocketResponse:
        socket = web.WebSocketResponse(
            max_msg_size=messages.LARGEST, heartbeat=_HEARTBEAT, compress=False
        )
        if not socket.can_prepare(request).ok:
            self._refusals.add("upgrade")
            raise web.HTTPBadRequest(text="a WebSocket needed\n")
        await socket.prepare(request)
        tab = Tab(socket, request.transport)
        self._connected(tab)
        try:
            if await self._acquire_page(tab):
                await self._run_session(tab)
        finally:
            self._disconnected(tab)
        return socket

    async def _acquire_page(self, tab: Tab) -> bool:
        """Waits while another tab plays until this one takes over; False if this one is closed."""
        for _ in range(_TRIES):  # after a reload, the old socket is about to close
            if self._tabs.may_play(tab):
                return True
            await asyncio.sleep(_PAUSE)
        await tab.socket.send_json({"type": "busy"})
        while (message := await self._receive(tab.socket)) is not None:
            if message.get("do") == "take":
                self._tabs.take_over(tab)
                return True
        return False

    async def _run_session(self, tab: Tab) -> None:
        session = Session(self._context, Channel(tab.socket.send_json, tab.socket.send_bytes))
        tab.session = session
        self._browser.close()  # the page is open
        try:
            await session.begin()
            while (message := await self._receive(tab.socket)) is not None:
                if message and message["do"] != "take":
                    await session.handle(message)
        except ConnectionError:
            pass  # the page was closed
        finally:
            self._tabs.remove(tab)  # a reloaded page may play already
            with contextlib.suppress(RuntimeError):  # of an executor that is shut down
                await session.close()

    async def _receive(self, socket: web.WebSocketResponse) -> dict[str, Any] | None:
        """A message; {} for a refused one, None at the end of the connection."""
        got = await socket.receive()
        if got.type is WSMsgType.ERROR:
            self._refusals.add("oversized or broken message")
            return None
        if got.type not in (WSMsgType.TEXT, WSMsgType.BINARY):
            return None
        try:
            if got.type is WSMsgType.BINARY:
                raise messages.MessageError("bytes given, a text needed")
            return messages.parse(got.data)
        except messages.MessageError as error:
            self._refusals.add("message")
            await socket.send_json({"type": "error", "message": f"refused: {error}"})
            return {}

    def _connected(self, tab: Tab) -> None:
        self._tabs.add(tab)
        if self._shutdown is not None:
            self._shutdown.cancel()
            self._shutdown = None

    def _disconnected(self, tab: Tab) -> None:
        self._tabs.remove(tab)
        if not self._tabs and not self._options.stay:
            self._shutdown = asyncio.get_running_loop().call_later(_RELOAD_SECONDS, self._done.set)


_HEADERS = {
    "Cache-Control": "no-store",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
}


def _policy(host: str) -> str:
    """Content security policy: the page's own files and its own socket."""
    return (
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; "
        f"connect-src 'self' ws://{host}; base-uri 'none'; form-action 'none'; "
        "frame-ancestors 'none'"
    )


def _json(value: Any) -> bytes:
    return json.dumps(value).encode()
