"""Policies behind servers: clients of the protocols that checkpoints are served with, and a server.

    policy = engram.servers.ServerPolicy("openpi://localhost:8000", keys="libero", replan=8)
    engram.evaluate(policy, "RememberColor3-VLA-v0")

``engram eval --policy-server URL`` starts ``python -m engram.servers bridge URL``, the same policy
behind pipes. ``engram.servers.check(URL, ID)`` asks a server some questions before a run.
docs/policy_servers.md has protocols and options.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from engram.servers.policy import ServerError, ServerPolicy

if TYPE_CHECKING:
    from engram.servers.checking.run import check

__all__ = ["ServerError", "ServerPolicy", "check"]


def __getattr__(name: str) -> Any:
    if name != "check":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from engram.servers.checking.run import check  # which runs of policies do not need

    return check
