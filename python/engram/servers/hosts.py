"""Names of this machine in requests of browsers, whose pages may come from anywhere."""

from __future__ import annotations

import ipaddress
import socket
from urllib.parse import urlsplit

_LOOPBACK = ("localhost", "127.0.0.1", "::1")


class OwnNames:
    """Host headers of a server that listens at ``host``. Ports may differ: there are tunnels."""

    def __init__(self, host: str) -> None:
        self.everywhere = host in ("0.0.0.0", "::", "")
        self._names = {*_LOOPBACK, host.lower()}
        if self.everywhere:
            self._names.add(socket.gethostname().lower())

    def __contains__(self, header: str) -> bool:
        try:
            parts = urlsplit(f"//{header}")
            name = parts.hostname or ""
            _ = parts.port
        except ValueError:
            return False
        if parts.path or parts.query or parts.username is not None:
            return False
        return name in self._names or (self.everywhere and _is_address(name))


def _is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True
