"""Who may talk to the server: the page that it has served, opened by the address it printed."""

from __future__ import annotations

import collections
import hmac
import ipaddress
import secrets
import socket
from urllib.parse import urlsplit

from aiohttp import web

_LOOPBACK = ("localhost", "127.0.0.1", "::1")


def new_token() -> str:
    """Part of the address; 192 bits that nobody guesses."""
    return secrets.token_urlsafe(24)


class Guard:
    """Checks every request before anything is done for it, and counts what it refuses.

    A page of somebody else's may send requests to this machine, by its name or by one that it has
    pointed here (DNS rebinding). It knows no token, its Origin is another one, and so is its Host.
    """

    def __init__(self, host: str, token: str) -> None:
        self._token = token.encode()
        self._everywhere = host in ("0.0.0.0", "::", "")
        self._names = {*_LOOPBACK, host.lower()}
        if self._everywhere:
            self._names.add(socket.gethostname().lower())
        self.refused: collections.Counter[str] = collections.Counter()

    def check(self, request: web.Request) -> None:
        """Raises HTTPForbidden if the request is not the page's."""
        reason = self._reason(request)
        if reason is not None:
            self.refused[reason] += 1
            raise web.HTTPForbidden(text=f"refused: {_WORDS[reason]}\n")

    def _reason(self, request: web.Request) -> str | None:
        if not hmac.compare_digest(request.match_info.get("token", "").encode(), self._token):
            return "token"
        hosts = request.headers.getall("Host", [])
        if len(hosts) != 1 or not self._is_ours(hosts[0]):
            return "host"
        origins = request.headers.getall("Origin", [])
        upgrade = request.headers.get("Upgrade", "").lower() == "websocket"
        # Browsers name the origin of every WebSocket, but not of what a page loads from its server.
        if (upgrade and not origins) or any(one != f"http://{hosts[0]}" for one in origins):
            return "origin"
        if request.headers.get("Sec-Fetch-Site", "none") not in ("none", "same-origin"):
            return "origin"
        return None

    def _is_ours(self, host: str) -> bool:
        """Whether a Host header names this machine. Ports may differ: there are tunnels."""
        try:
            parts = urlsplit(f"//{host}")
            name = parts.hostname or ""
            _ = parts.port
        except ValueError:
            return False
        if parts.path or parts.query or parts.username is not None:
            return False
        return name in self._names or (self._everywhere and _is_address(name))


_WORDS = {
    "token": "the address lacks the token that the server has printed",
    "host": "the server does not go by that name",
    "origin": "asked for by another page",
}


def _is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True
