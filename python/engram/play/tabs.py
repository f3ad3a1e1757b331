"""Tabs of the page. One of them plays; another one may take over at once."""

from __future__ import annotations

import asyncio
import contextlib
from typing import Any, Protocol

from aiohttp import web

TAKEN = 4001  # code of a connection that another tab has ended
_SECONDS = 1.0  # for a last message; a tab that stands still takes none


class _Playing(Protocol):
    def abandon(self) -> None: ...


class Tab:
    """One WebSocket, and the session that it plays."""

    def __init__(self, socket: web.WebSocketResponse, transport: Any) -> None:
        self.socket = socket
        self.session: _Playing | None = None
        self._transport = transport

    async def dismiss(self, code: int, message: dict[str, Any] | None = None) -> None:
        """Ends the connection, with a message if the tab takes it."""
        with contextlib.suppress(Exception):
            await asyncio.wait_for(self._say_goodbye(code, message), _SECONDS)
        if self._transport is not None:
            self._transport.abort()

    async def _say_goodbye(self, code: int, message: dict[str, Any] | None) -> None:
        if message is not None:
            await self.socket.send_json(message)
        await self.socket.close(code=code)


class Tabs:
    """Open tabs, and which one plays."""

    def __init__(self) -> None:
        self._open: set[Tab] = set()
        self._player: Tab | None = None
        self._dismissals: set[asyncio.Task[None]] = set()

    def __bool__(self) -> bool:
        return bool(self._open)

    def add(self, tab: Tab) -> None:
        self._open.add(tab)

    def remove(self, tab: Tab) -> None:
        self._open.discard(tab)
        if self._player is tab:
            self._player = None

    def may_play(self, tab: Tab) -> bool:
        """Makes it the tab that plays, unless another one is."""
        if self._player is None:
            self._player = tab
        return self._player is tab

    def take_over(self, tab: Tab) -> None:
        """Makes it the tab that plays. The other one gets a message, and is not waited for."""
        old, self._player = self._player, tab
        if old is None or old is tab:
            return
        if old.session is not None:
            old.session.abandon()
        task = asyncio.get_running_loop().create_task(old.dismiss(TAKEN, {"type": "taken"}))
        self._dismissals.add(task)
        task.add_done_callback(self._dismissals.discard)

    async def close(self) -> None:
        """Ends all connections."""
        for tab in self._open:
            if tab.session is not None:
                tab.session.abandon()
        await asyncio.gather(*(tab.dismiss(1001) for tab in list(self._open)))
