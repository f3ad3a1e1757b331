"""Access control: only the page that was opened by the printed address may send requests."""

from __future__ import annotations

import hmac
import secrets

from aiohttp import web

from engram.play.refusals import Refusals
from engram.servers.hosts import OwnNames


def new_token() -> str:
    """Secret part of the address, 192 random bits."""
    return secrets.token_urlsafe(24)


class Guard:
    """Checks every request before it is handled, and counts refused ones.

    Pages of other origins may send requests to this machine, by its name or by one that resolves
    to it (DNS rebinding). They have no token, another Origin and another Host.
    """

    def __init__(self, host: str, token: str, refusals: Refusals) -> None:
        self._token = token.encode()
        self._names = OwnNames(host)
        self._refusals = refusals

    def check(self, request: web.Request) -> None:
        """Raises HTTPForbidden if the request is not the page's."""
        reason = self._reason(request)
        if reason is not None:
            self._refusals.add(reason)
            refused = web.HTTPForbidden(text=f"refused: {_MESSAGES[reason]}\n")
            refused.force_close()  # unauthenticated clients keep no connection
            raise refused

    def _reason(self, request: web.Request) -> str | None:
        if not hmac.compare_digest(request.match_info.get("token", "").encode(), self._token):
            return "token"
        hosts = request.headers.getall("Host", [])
        if len(hosts) != 1 or hosts[0] not in self._names:
            return "host"
        origins = request.headers.getall("Origin", [])
        upgrade = request.headers.get("Upgrade", "").lower() == "websocket"
        # Browsers send the origin with every WebSocket, but not with files of the same server.
        if (upgrade and not origins) or any(one != f"http://{hosts[0]}" for one in origins):
            return "origin"
        site = request.headers.get("Sec-Fetch-Site", "none")
        if site not in ("none", "same-origin") and not _opens_page(request):
            return "origin"
        return None


def _opens_page(request: web.Request) -> bool:
    """True for a window that goes to the page, as from the file that the browser was given."""
    headers = request.headers
    wish = (headers.get("Sec-Fetch-Mode"), headers.get("Sec-Fetch-Dest"))
    return wish == ("navigate", "document") and request.match_info["rest"] in ("", "/")


_MESSAGES = {
    "token": "the address lacks the token that the server has printed",
    "host": "the server does not have that name",
    "origin": "sent by another page",
}
